//! The driver: takes a polygon through the pipeline, stage by stage.

use alloc::vec::Vec;

use fearless_simd::{Level, dispatch};

use crate::clip::{ClipPlane, Clipper, VertexArrays};
use crate::depth::{DepthSource, DepthTest};
use crate::divide::ScreenVertex;
use crate::edge::{Outline, Span};
use crate::gradient::{AttributesOf, ConstantAlong, Gradients, Subject, Wanted};
use crate::paint::{Covered, Placement, paint};
use crate::placed::{Constants, PlacedVertex};
use crate::polygon::Polygon;
use crate::settle::Walked;
use crate::shade::{BLOCK, Shader};
use crate::simd::Simd;
use crate::space::{PixelRect, Viewport};
use crate::stats::Stats;
use crate::target::{DepthBuffer, Plane, Target};
use crate::triangle::{InView, Look, look};
use crate::varying::Interpolation;

mod scan;

use scan::{Scanned, take_in, take_in_view};

/// Which polygons are left out for the way they face. Front faces are counter-clockwise with
/// y up; a snapped area of 0 faces back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Cull {
    /// All are drawn.
    #[default]
    None,
    /// Back faces are left out.
    Back,
    /// Front faces are left out.
    Front,
}

impl Cull {
    /// Is a polygon drawn that faces the front, or not?
    #[inline(always)]
    fn keeps(self, front: bool) -> bool {
        match self {
            Self::None => true,
            Self::Back => front,
            Self::Front => !front,
        }
    }
}

/// How good attributes are; see docs/precision.md.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    /// Within 4u |value| + 3u M of the right value, where u is 2^-24 and M the attribute's largest
    /// magnitude at the vertices; depth within an ulp.
    #[default]
    Fast,
    /// Correctly rounded: at most half an ulp off.
    Exact,
}

/// What became of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// It went to the spans (and may still cover no pixel centre).
    Drawn,
    /// Nothing of it lies in the view volume.
    Outside,
    /// It faces the way that is left out.
    Backface,
    /// Fewer than three vertices, or no area once snapped.
    Degenerate,
    /// A position is not finite.
    Refused,
}

/// Draws polygons: holds the viewport, the settings, the counts and the buffers that are reused
/// from one polygon to the next.
#[derive(Debug)]
pub struct Tiler {
    viewport: Viewport,
    origin: [i32; 2],
    depth_test: DepthTest,
    cull: Cull,
    precision: Precision,
    interpolation: Vec<Interpolation>,
    clipper: Clipper,
    place_constants: Constants,
    simd: Simd,
    stats: Stats,
    scratch: Scratch,
}

/// What a polygon is turned into on its way, stage by stage; kept to save allocations.
#[derive(Debug, Default)]
struct Scratch {
    /// As given, times a power of two.
    given: Vec<[f64; 4]>,
    clipped: VertexArrays,
    screen: Vec<ScreenVertex>,
    outline: Outline,
    /// Within what is visible.
    spans: Vec<Span>,
    gradients: Gradients,
    attributes: Vec<[f32; BLOCK]>,
}

impl Tiler {
    /// A tiler for `viewport`: no culling, standard depth, every attribute with perspective.
    pub fn new(viewport: Viewport) -> Self {
        Self {
            viewport,
            origin: [0, 0],
            depth_test: DepthTest::STANDARD,
            cull: Cull::None,
            precision: Precision::Fast,
            interpolation: Vec::new(),
            clipper: Clipper::new(viewport),
            place_constants: Constants::new(viewport),
            simd: Simd::auto(),
            stats: Stats::default(),
            scratch: Scratch::default(),
        }
    }

    /// The framebuffer position of the target's first pixel: (0, 0) unless set. A target that
    /// is a crop of the picture has the bytes of that part of the whole.
    pub fn set_origin(&mut self, x: i32, y: i32) -> &mut Self {
        self.origin = [x, y];
        self
    }

    /// The depth test of the calls of [`draw`](Self::draw) that have a depth buffer.
    pub fn set_depth_test(&mut self, test: DepthTest) -> &mut Self {
        self.depth_test = test;
        self
    }

    /// Which faces are left out.
    pub fn set_cull(&mut self, cull: Cull) -> &mut Self {
        self.cull = cull;
        self
    }

    /// How good attributes are.
    pub fn set_precision(&mut self, precision: Precision) -> &mut Self {
        self.precision = precision;
        self
    }

    /// How attribute 0, 1, ... is interpolated; those beyond the list have perspective.
    pub fn set_interpolation(&mut self, interpolation: &[Interpolation]) -> &mut Self {
        self.interpolation.clear();
        self.interpolation.extend_from_slice(interpolation);
        self
    }

    /// Planes to clip against beside the view volume's: any number. With planes +d and -d the
    /// two parts of a polygon cover each of its pixels exactly once.
    pub fn set_clip_planes(&mut self, planes: &[ClipPlane]) -> &mut Self {
        self.clipper.set_user_planes(planes);
        self
    }

    /// Which of the machine's instruction sets to use; the widest unless set. No bit depends on
    /// it.
    pub fn set_simd(&mut self, simd: Simd) -> &mut Self {
        self.simd = simd;
        self
    }

    /// Counts since the tiler was made or since [`reset_stats`](Self::reset_stats).
    pub fn stats(&self) -> Stats {
        // Buffers never shrink: what they hold now is the most they held.
        Stats { peak_bytes: self.bytes() as u64, ..self.stats }
    }

    /// Sets the counts to 0.
    pub fn reset_stats(&mut self) {
        self.stats = Stats::default();
    }

    /// Draws `polygon` into `target`, through the depth test if there is a buffer for it.
    ///
    /// What lies outside the viewport, the target or the depth buffer (whose first pixel is
    /// the target's) is not drawn. Any bit pattern may come in.
    pub fn draw<V, S, T>(
        &mut self,
        polygon: &V,
        shader: &mut S,
        target: &mut T,
        depth: Option<&mut DepthBuffer<'_>>,
    ) -> Outcome
    where
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        let window = window(self.viewport, self.origin, target.size(), depth.as_deref());
        let mut found = InView::default();
        let outcome = match self.sight(polygon, window, &mut found) {
            Sight::Pixels => {
                let seen = Seen::Small(&found, &positions_of(polygon));
                self.fill(polygon, seen, shader, target, depth)
            }
            Sight::Elsewhere => self.draw_any(polygon, window, shader, target, depth),
            Sight::Left(outcome) => outcome,
        };
        self.count(outcome);
        outcome
    }

    /// What became of a polygon goes into the counts.
    #[inline(always)]
    fn count(&mut self, outcome: Outcome) {
        self.stats.polygons += 1;
        let culled = &mut self.stats.culled;
        match outcome {
            Outcome::Drawn => {}
            Outcome::Outside => culled.outside += 1,
            Outcome::Backface => culled.backface += 1,
            Outcome::Degenerate => culled.degenerate += 1,
            Outcome::Refused => culled.refused += 1,
        }
    }

    /// Draws any polygon, by its spans.
    fn draw_any<V, S, T>(
        &mut self,
        polygon: &V,
        window: PixelRect,
        shader: &mut S,
        target: &mut T,
        depth: Option<&mut DepthBuffer<'_>>,
    ) -> Outcome
    where
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        // 1. The polygon, at a size where nothing overflows.
        let exponent = match take_in(polygon, &mut self.scratch.given) {
            Ok(exponent) => exponent,
            Err(outcome) => return outcome,
        };
        // 2 to 5. Clip, divide, cull, edges.
        match self.scan(window) {
            Ok(scanned) => {
                self.fill(polygon, Seen::Scanned(scanned, exponent), shader, target, depth)
            }
            Err(outcome) => outcome,
        }
    }

    /// Draws the pixels that were found of `polygon`.
    fn fill<V, S, T>(
        &mut self,
        polygon: &V,
        seen: Seen<'_>,
        shader: &mut S,
        target: &mut T,
        depth: Option<&mut DepthBuffer<'_>>,
    ) -> Outcome
    where
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        let triangle: [[f64; 4]; 3];
        let Scratch { given, screen, spans, gradients, attributes, .. } = &mut self.scratch;
        let (in_view, positions, exponent, covered, found) = match seen {
            Seen::Scanned(scanned, exponent) => {
                (false, given.as_slice(), exponent, Covered::Spans(spans), scanned)
            }
            Seen::Small(found, given) => {
                // They may not be what was placed.
                let Some((positions, exponent)) = take_in_view(given) else {
                    return Outcome::Refused;
                };
                triangle = positions;
                let scanned = Scanned::of(found, &triangle);
                (true, triangle.as_slice(), exponent, Covered::Patches(&found.patches), scanned)
            }
        };

        // 6. Gradients, of what is asked for; found out: what is constant.
        let test = depth.is_some().then_some(self.depth_test.source);
        let subject = Subject {
            attributes: &AttributesOf(polygon),
            viewport: self.viewport,
            positions,
            exponent,
            screen,
            in_view,
            interpolation: &self.interpolation,
            clipped_w: found.w,
            columns: found.columns,
            rows: found.rows,
            wanted: Wanted {
                depth: S::INPUTS.depth || test == Some(DepthSource::Z),
                inv_w: S::INPUTS.inv_w || test == Some(DepthSource::InvW),
                w: S::INPUTS.w,
                attributes: polygon.attribute_count().min(S::INPUTS.attributes),
                exact: self.precision == Precision::Exact,
            },
        };
        set_gradients(self.simd.0, gradients, &subject);
        match gradients.constant {
            ConstantAlong::Nothing => {}
            ConstantAlong::Polygon => self.stats.constant_w.polygon += 1,
            ConstantAlong::Row => self.stats.constant_w.row += 1,
            ConstantAlong::Column => self.stats.constant_w.column += 1,
        }

        // 7. Spans: the X loop, depth, shader and target, block by block.
        let corner = self.viewport.rect();
        let place = Placement {
            corner: [corner.x0, corner.y0],
            origin: self.origin,
            test: self.depth_test,
        };
        let walked = Walked::new(&subject, gradients, &mut self.clipper);
        let (shaded, exact_values) =
            paint(self.simd.0, walked, covered, place, attributes, shader, target, depth);
        self.stats.spans += found.spans;
        self.stats.pixels_covered += found.pixels;
        self.stats.pixels_shaded += shaded;
        self.stats.pixels_hidden += found.pixels - shaded;
        self.stats.exact_values += exact_values;
        Outcome::Drawn
    }

    /// Where the vertices of a triangle lie.
    #[inline(always)]
    fn places<V: Polygon + ?Sized>(&self, triangle: &V) -> [PlacedVertex; 3] {
        match triangle.placed() {
            Some(placed) if placed.viewport() == self.viewport => {
                let place = |i: usize| placed.vertex(triangle.placed_index(i));
                [place(0), place(1), place(2)]
            }
            _ => self.place(positions_of(triangle)),
        }
    }

    #[inline(never)]
    fn place(&self, [a, b, c]: [[f64; 4]; 3]) -> [PlacedVertex; 3] {
        let constants = &self.place_constants;
        dispatch!(self.simd.0, simd => {
            [constants.place(simd, &a), constants.place(simd, &b), constants.place(simd, &c)]
        })
    }

    /// 1 to 5 in one, for a triangle of a few pixels in the view.
    #[inline(always)]
    fn sight<V: Polygon + ?Sized>(
        &self,
        polygon: &V,
        window: PixelRect,
        found: &mut InView,
    ) -> Sight {
        if polygon.len() != 3 || self.clipper.has_user_planes() {
            return Sight::Elsewhere;
        }
        self.look(self.places(polygon), window, found)
    }

    #[inline(never)]
    fn look(&self, triangle: [PlacedVertex; 3], window: PixelRect, found: &mut InView) -> Sight {
        let (cull, rect) = (self.cull, self.viewport.rect());
        let keeps = |front| cull.keeps(front);
        match look(self.simd.0, triangle, [rect.x0, rect.y0], keeps, window, found) {
            Look::Elsewhere => Sight::Elsewhere,
            Look::Degenerate => Sight::Left(Outcome::Degenerate),
            Look::Away => Sight::Left(Outcome::Backface),
            Look::Nothing => Sight::Left(Outcome::Drawn),
            Look::Pixels => Sight::Pixels,
        }
    }

    /// Bytes that the buffers hold.
    fn bytes(&self) -> usize {
        let scratch = &self.scratch;
        scratch.given.capacity() * size_of::<[f64; 4]>()
            + scratch.clipped.bytes()
            + scratch.screen.capacity() * size_of::<ScreenVertex>()
            + scratch.outline.bytes()
            + scratch.spans.capacity() * size_of::<Span>()
            + scratch.gradients.bytes()
            + scratch.attributes.capacity() * size_of::<[f32; BLOCK]>()
            + self.clipper.bytes()
    }
}

/// Compiled for the instruction set: it is arithmetic from end to end.
#[inline(never)]
fn set_gradients(level: Level, gradients: &mut Gradients, subject: &Subject<'_>) {
    dispatch!(level, _simd => gradients.set(subject));
}

/// Where a polygon is found.
enum Sight {
    /// By its spans, if at all.
    Elsewhere,
    /// In patches: there are pixels to draw.
    Pixels,
    /// There are none.
    Left(Outcome),
}

/// The pixels of a polygon.
enum Seen<'a> {
    /// And the positions.
    Small(&'a InView, &'a [[f64; 4]; 3]),
    /// In the scratch's spans; the positions were multiplied by two to minus this.
    Scanned(Scanned, i32),
}

impl Scanned {
    /// The same of a small triangle.
    fn of(found: &InView, [a, b, c]: &[[f64; 4]; 3]) -> Self {
        let InView { bounds, pixels, spans, .. } = *found;
        let (low, high) = if a[3] < b[3] { (a[3], b[3]) } else { (b[3], a[3]) };
        let w = [if c[3] < low { c[3] } else { low }, if c[3] > high { c[3] } else { high }];
        let columns = [bounds.x0, bounds.x1 - 1];
        Self { w, columns, rows: [bounds.y0, bounds.y1 - 1], pixels, spans }
    }
}

#[inline(always)]
fn positions_of<V: Polygon + ?Sized>(triangle: &V) -> [[f64; 4]; 3] {
    [triangle.position(0), triangle.position(1), triangle.position(2)]
}

/// The pixels of the framebuffer that can be drawn.
#[inline(always)]
fn window(
    viewport: Viewport,
    origin: [i32; 2],
    target: (u32, u32),
    depth: Option<&DepthBuffer<'_>>,
) -> PixelRect {
    let (width, height) = match depth.map(Plane::dimensions) {
        Some((width, height)) => (target.0.min(width), target.1.min(height)),
        None => target,
    };
    viewport.rect().intersect(PixelRect::new(origin[0], origin[1], width, height))
}
