//! The driver: takes a polygon through the pipeline, stage by stage.

use alloc::vec::Vec;

use fearless_simd::dispatch;

use crate::clip::{ClipPlane, Clipped, Clipper, VertexArrays};
use crate::depth::{DepthSource, DepthTest};
use crate::divide::{ScreenVertex, divide, snapped_area};
use crate::edge::{Outline, Span};
use crate::fixed::{exponent_of, power_of_two};
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
use crate::triangle::{InView, Sight, look};
use crate::varying::Interpolation;

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
    /// Within 4u |value| + 3u M of the right value. Until it has a path of its own, this is
    /// [`Exact`](Self::Exact).
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
    in_view: InView,
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
        self.stats.polygons += 1;
        let outcome = self.take_through(polygon, shader, target, depth);
        let culled = &mut self.stats.culled;
        match outcome {
            Outcome::Drawn => {}
            Outcome::Outside => culled.outside += 1,
            Outcome::Backface => culled.backface += 1,
            Outcome::Degenerate => culled.degenerate += 1,
            Outcome::Refused => culled.refused += 1,
        }
        outcome
    }

    /// The pipeline.
    fn take_through<V, S, T>(
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

        // 1 to 5 in one, for a triangle of a few pixels in the view.
        let sight = match polygon.len() {
            3 if !self.clipper.has_user_planes() => self.look(self.places(polygon), window),
            _ => Sight::Elsewhere,
        };
        let (exponent, found) = match sight {
            Sight::Degenerate => return Outcome::Degenerate,
            Sight::Away => return Outcome::Backface,
            Sight::Nothing => return Outcome::Drawn,
            Sight::Pixels => (0, None),
            Sight::Elsewhere => {
                // 1. The polygon, at a size where nothing overflows.
                let exponent = match take_in(polygon, &mut self.scratch.given) {
                    Ok(exponent) => exponent,
                    Err(outcome) => return outcome,
                };
                // 2 to 5. Clip, divide, cull, edges.
                match self.scan(window) {
                    Ok(found) => (exponent, Some(found)),
                    Err(outcome) => return outcome,
                }
            }
        };
        let triangle: [[f64; 4]; 3];
        let Scratch { given, screen, spans, in_view, gradients, attributes, .. } =
            &mut self.scratch;
        let (positions, covered, found) = match found {
            Some(found) => (given.as_slice(), Covered::Spans(spans), found),
            None => {
                triangle = [polygon.position(0), polygon.position(1), polygon.position(2)];
                let found = Scanned::of(in_view, &triangle);
                (triangle.as_slice(), Covered::Patches(&in_view.patches), found)
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
            in_view: sight == Sight::Pixels,
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
        gradients.set(&subject);
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
            _ => self.place([triangle.position(0), triangle.position(1), triangle.position(2)]),
        }
    }

    #[inline(never)]
    fn place(&self, [a, b, c]: [[f64; 4]; 3]) -> [PlacedVertex; 3] {
        let constants = &self.place_constants;
        dispatch!(self.simd.0, simd => {
            [constants.place(simd, &a), constants.place(simd, &b), constants.place(simd, &c)]
        })
    }

    /// Looks for a small triangle within `window`.
    #[inline(never)]
    fn look(&mut self, triangle: [PlacedVertex; 3], window: PixelRect) -> Sight {
        let (cull, rect) = (self.cull, self.viewport.rect());
        let keeps = |front| cull.keeps(front);
        let found = &mut self.scratch.in_view;
        look(self.simd.0, triangle, [rect.x0, rect.y0], keeps, window, found)
    }

    /// From the polygon that was taken in to its spans within `window`.
    fn scan(&mut self, window: PixelRect) -> Result<Scanned, Outcome> {
        let Scratch { given, clipped, screen, outline, spans, .. } = &mut self.scratch;

        // 2. Clip, against the crossed planes only.
        let outcodes = self.clipper.classify(given.iter().copied());
        if outcodes.hidden {
            return Err(Outcome::Outside);
        }
        let visible: &[[f64; 4]] = if outcodes.accepted() {
            given
        } else {
            clipped.reset(0);
            given.iter().for_each(|p| clipped.push(*p, []));
            if self.clipper.clip(clipped) == Clipped::Outside || clipped.is_empty() {
                return Err(Outcome::Outside);
            }
            self.stats.clipped += 1;
            clipped.bare_positions()
        };

        // 3. Divide by w, through the viewport, onto the subpixel grid.
        divide(visible.iter().copied(), self.viewport, screen);

        // 4. Which way it faces, exactly; and whether a pixel's centre is near.
        let area = snapped_area(screen);
        let bounds = bounds(screen, self.viewport);
        if area == 0 && (bounds.is_empty() || !outline.set(screen).covers_anything()) {
            return Err(Outcome::Degenerate);
        }
        if !self.cull.keeps(area > 0) {
            return Err(Outcome::Backface);
        }
        let seen = bounds.intersect(self.viewport.rect());
        if seen.intersect(window).is_empty() {
            return Err(Outcome::Drawn);
        }

        // 5. Edges: the Y loop, within what can be seen.
        let corner = self.viewport.rect();
        let (x0, x1) = (window.x0 - corner.x0, window.x1 - corner.x0);
        let mut pixels = 0;
        spans.clear();
        outline.set(screen).for_each_span(window.y0 - corner.y0..window.y1 - corner.y0, |span| {
            let (start, end) = (span.start.max(x0), span.end.min(x1));
            if start < end {
                pixels += u64::from(end.abs_diff(start));
                spans.push(Span { start, end, ..span });
            }
        });
        if spans.is_empty() {
            return Err(Outcome::Drawn);
        }
        Ok(Scanned {
            w: range_of_w(screen, visible),
            columns: [seen.x0, seen.x1 - 1],
            rows: [seen.y0, seen.y1 - 1],
            pixels,
            spans: spans.len() as u64,
        })
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

/// Exponents of the largest number up to which a polygon stays as it is: no product of a few
/// numbers leaves the range of `f64`, so a power of two changes no bit but the exponents.
const MODERATE: i32 = 64;

/// Copies the positions and, if they are huge or tiny, brings the largest number into 1..2 by a
/// power of two, whose negated exponent it returns: so that no product overflows, no subnormal
/// is left, and scaled polygons give the same bits.
#[inline(always)]
fn take_in<V: Polygon + ?Sized>(polygon: &V, given: &mut Vec<[f64; 4]>) -> Result<i32, Outcome> {
    let n = polygon.len();
    if n < 3 {
        return Err(Outcome::Degenerate);
    }
    given.clear();
    given.reserve(n);
    let (mut largest, mut finite) = (0.0_f64, true);
    for i in 0..n {
        let position = polygon.position(i);
        for component in position {
            let size = component.abs();
            finite &= size < f64::INFINITY;
            largest = if size > largest { size } else { largest };
        }
        given.push(position);
    }
    if !finite {
        return Err(Outcome::Refused);
    }
    let Some(exponent) = exponent_of(largest) else { return Err(Outcome::Degenerate) };
    if exponent.abs() <= MODERATE {
        return Ok(0);
    }
    // In two steps: the power alone may lie outside the range.
    let half = exponent / 2;
    let (first, second) = (power_of_two(-half), power_of_two(half - exponent));
    for component in given.as_flattened_mut() {
        *component = *component * first * second;
    }
    Ok(exponent)
}

/// What the stages up to the spans found of a polygon.
struct Scanned {
    /// Least and greatest w of the clipped vertices.
    w: [f64; 2],
    /// Framebuffer columns and rows that it may cover in the viewport: first and last.
    columns: [i32; 2],
    rows: [i32; 2],
    /// Pixels that are covered, in how many spans.
    pixels: u64,
    spans: u64,
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

/// The pixels of the framebuffer whose centres the snapped vertices may enclose.
fn bounds(screen: &[ScreenVertex], viewport: Viewport) -> PixelRect {
    let Some(first) = screen.first() else { return PixelRect::default() };
    let (mut low, mut high) = (first.snapped, first.snapped);
    for vertex in &screen[1..] {
        let [x, y] = vertex.snapped;
        low = [low[0].min(x), low[1].min(y)];
        high = [high[0].max(x), high[1].max(y)];
    }
    let corner = viewport.rect();
    PixelRect {
        x0: low[0].first_centre().saturating_add(corner.x0),
        y0: low[1].first_centre().saturating_add(corner.y0),
        x1: high[0].first_centre().saturating_add(corner.x0),
        y1: high[1].first_centre().saturating_add(corner.y0),
    }
}

/// Least and greatest w of the vertices that the division kept.
fn range_of_w(screen: &[ScreenVertex], positions: &[[f64; 4]]) -> [f64; 2] {
    let (mut low, mut high) = (f64::INFINITY, 0.0);
    for vertex in screen {
        let w = positions[vertex.vertex as usize][3];
        low = if w < low { w } else { low };
        high = if w > high { w } else { high };
    }
    [low, high]
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
