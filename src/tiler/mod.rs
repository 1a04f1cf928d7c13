//! The driver: takes a polygon through the pipeline, stage by stage.

use alloc::vec::Vec;

use fearless_simd::{Level, dispatch};

use crate::aligned::LaneMemory;
use crate::clip::{Clipper, VertexArrays};
use crate::depth::{DepthSource, DepthTest};
use crate::divide::ScreenVertex;
use crate::edge::{Outline, Span};
use crate::gradient::{AttributesOf, Gradients, Subject, Wanted};
use crate::in_view::InView;
use crate::packed::pack;
use crate::paint::{Covered, Placement, paint};
use crate::patch::Patch;
use crate::placed::Constants;
use crate::polygon::Polygon;
use crate::settle::Walked;
use crate::shade::Shader;
use crate::simd::Simd;
use crate::space::{PixelRect, Viewport};
pub use crate::stats::Outcome;
use crate::stats::Stats;
use crate::subnormal;
use crate::target::{DepthBuffer, Plane, Target};
use crate::varying::Interpolation;

pub(crate) mod ahead;
pub(crate) mod bunch;
mod hidden;
pub(crate) mod occlude;
mod scan;
mod settings;
mod small;
pub(crate) mod sort;
mod tiles;

pub use settings::{Cull, Precision};

use bunch::{Asked, Bunch, One};
use scan::{Counts, Taken, may_be_packed};
use small::Next;
use tiles::TestedSpans;

/// Short spans are drawn by patches if they have so many pixels at most, on the average.
const PACKED: u64 = 8;

/// A clear is put off for polygons of which a span has so many pixels, on the average.
const LONG: u64 = 512;

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
    all_perspective: bool,
    clipper: Clipper,
    place_constants: Constants,
    simd: Simd,
    /// Is what is hidden left out, where that is known?
    hides: bool,
    stats: Stats,
    scratch: Scratch,
    bunch: Bunch,
}

/// What a polygon is turned into on its way, stage by stage; kept to save allocations.
#[derive(Debug, Default)]
struct Scratch {
    /// As given, times a power of two.
    given: Vec<[f64; 4]>,
    clipped: VertexArrays,
    taken: Taken,
    screen: Vec<ScreenVertex>,
    outline: Outline,
    /// Within what is visible.
    spans: Vec<Span>,
    /// For those to come, while others are cut.
    spare_spans: Vec<Span>,
    /// The same pixels, or those of a small polygon, if they are drawn so.
    patches: Vec<Patch>,
    gradients: Gradients,
    attributes: LaneMemory,
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
            all_perspective: true,
            clipper: Clipper::new(viewport),
            place_constants: Constants::new(viewport),
            simd: Simd::auto(),
            hides: true,
            stats: Stats::default(),
            scratch: Scratch::default(),
            bunch: Bunch::default(),
        }
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
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) -> Outcome
    where
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        let window = self.window(target.size(), depth.as_deref());
        // As draw lists have it, so that what is compiled for them serves here.
        let target = &mut &mut *target;
        let outcome = if subnormal::are_kept() {
            let asked = self.asked::<S>(depth.as_deref());
            let next = self.look_at_one(polygon, window, asked, depth.as_deref_mut());
            self.clear_under_small(target, depth.as_deref_mut());
            dispatch!(self.simd.0, simd => {
                self.follow(simd, next, &One(polygon), 0, window, shader, target, depth)
            })
        } else {
            Outcome::Refused
        };
        self.stats.count(outcome);
        outcome
    }

    /// Looks at `polygon`, and finds out what is next.
    ///
    /// It is compiled for each type of polygon, and not for each shader, too.
    #[inline(never)]
    fn look_at_one<V: Polygon + ?Sized>(
        &mut self,
        polygon: &V,
        window: PixelRect,
        asked: Asked,
        depth: Option<&mut DepthBuffer<'_>>,
    ) -> Next {
        dispatch!(self.simd.0, simd => {
            let one = One(polygon);
            self.look_at::<1, _, _>(simd, &one, 1, window);
            self.next::<1, _, _>(simd, &one, 0, window, asked, depth)
        })
    }

    /// Draws any polygon, by its spans.
    fn draw_any<V, S, T>(
        &mut self,
        polygon: &V,
        window: PixelRect,
        shader: &mut S,
        target: &mut T,
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) -> Outcome
    where
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        // 1 to 4: clipped, divided, culled.
        match self.take(polygon) {
            Ok(taken) => self.scratch.taken = taken,
            Err(outcome) => return outcome,
        }
        if self.hides && self.is_hidden(window, depth.as_deref_mut()) {
            return Outcome::Hidden;
        }
        // 5. Edges.
        let counts = self.scan(window);
        if counts.spans == 0 {
            return Outcome::Drawn;
        }
        self.fill(polygon, Seen::Spans, counts, shader, target, depth)
    }

    /// Draws the pixels that were found of `polygon`: `counts` of them.
    fn fill<V, S, T>(
        &mut self,
        polygon: &V,
        seen: Seen<'_>,
        counts: Counts,
        shader: &mut S,
        target: &mut T,
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) -> Outcome
    where
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        let place = self.placement();
        let Scratch {
            given,
            taken,
            screen,
            spans,
            spare_spans,
            patches,
            gradients,
            attributes,
            ..
        } = &mut self.scratch;
        let (is_small, positions, taken) = match seen {
            Seen::Spans => (false, given.as_slice(), *taken),
            Seen::Small(found, positions, taken) => {
                patches.clear();
                patches.extend(found.patches.covered());
                (true, positions.as_slice(), taken)
            }
        };

        // 6. Gradients, of what is asked for; found out: what is constant.
        let test = depth.is_some().then_some(self.depth_test.source);
        let wanted = Wanted {
            depth: S::INPUTS.depth || test == Some(DepthSource::Z),
            inv_w: S::INPUTS.inv_w || test == Some(DepthSource::InvW),
            w: S::INPUTS.w,
            attributes: polygon.attribute_count().min(S::INPUTS.attributes),
            exact: self.precision == Precision::Exact,
        };
        let (viewport, interpolation) = (self.viewport, self.interpolation.as_slice());
        let attributes_of = &AttributesOf(polygon);
        let subject = Subject {
            in_view: is_small,
            ..taken.subject(attributes_of, positions, screen, viewport, interpolation, wanted)
        };
        set_gradients(self.simd.0, gradients, &subject);
        self.stats.constant_w.count(gradients.constant);

        // 7. What of it is surely hidden falls out.
        let tested = match depth.as_deref_mut() {
            Some(buffer) if !is_small && buffer.has_bounds() => {
                let tested = TestedSpans::new(gradients, &subject, place, counts);
                if self.hides && tested.hide(spans, spare_spans, buffer) {
                    return Outcome::Hidden;
                }
                Some(tested)
            }
            _ => None,
        };

        // 8. Spans: the X loop, depth, shader and target, block by block.
        // Only what is found lane by lane has the same bits in patches, whatever a window leaves of its spans.
        let is_packed = !is_small
            && taken.short
            && counts.pixels <= PACKED * counts.spans
            && may_be_packed(gradients);
        if is_packed {
            pack(spans, place.corner, patches);
        }
        let mut unclear = None;
        let rows = place.rows(counts.within);
        if let Some(buffer) = depth.as_deref_mut().filter(|buffer| buffer.may_be_unclear(rows)) {
            // Short pieces in many rows are all over memory: that is faster cleared from end to end.
            let is_long = counts.pixels >= LONG * counts.spans;
            let passes = is_long && S::KEEPS_ALL && place.test.write && buffer.is_unclear(rows);
            unclear = tested.as_ref().filter(|_| passes).map(|tested| tested.depths);
            if unclear.is_none() {
                buffer.clear_rows(target, rows);
            }
        }
        let walked = Walked::new(&subject, gradients, &mut self.clipper);
        let covered = match (is_small, is_packed) {
            (true, _) => Covered::Patches(patches),
            (false, true) => Covered::Packed(patches, spans),
            (false, false) => Covered::Spans(spans, unclear),
        };
        let drawn = depth.as_deref_mut();
        let (shaded, exact_values) =
            paint(self.simd.0, walked, covered, place, attributes, shader, target, drawn);
        if let (Some(tested), Some(buffer)) = (tested, depth) {
            tested.wrote(spans, buffer, shaded, S::KEEPS_ALL);
            self.stats.pixels_not_cleared += buffer.take_drawn_unclear();
        }
        self.stats.exact_values += exact_values;
        self.count_pixels(counts, shaded);
        Outcome::Drawn
    }

    /// Of covered pixels some were shaded.
    #[inline(always)]
    fn count_pixels(&mut self, Counts { pixels, spans, .. }: Counts, shaded: u64) {
        self.stats.spans += spans;
        self.stats.pixels_covered += pixels;
        self.stats.pixels_shaded += shaded;
        self.stats.pixels_hidden += pixels - shaded;
    }

    /// The pixels of the framebuffer that can be drawn.
    #[inline(always)]
    pub(crate) fn window(&self, target: (u32, u32), depth: Option<&DepthBuffer<'_>>) -> PixelRect {
        let (width, height) = match depth.map(Plane::dimensions) {
            Some((width, height)) => (target.0.min(width), target.1.min(height)),
            None => target,
        };
        let [x, y] = self.origin;
        self.viewport.rect().intersect(PixelRect::new(x, y, width, height))
    }

    /// Where pixels are drawn, and how.
    #[inline(always)]
    fn placement(&self) -> Placement {
        let corner = self.viewport.rect();
        let (corner, origin) = ([corner.x0, corner.y0], self.origin);
        Placement { corner, origin, test: self.depth_test }
    }

    /// Bytes that the buffers hold.
    pub(crate) fn bytes(&self) -> usize {
        self.scratch.bytes() + self.bunch.bytes() + self.clipper.bytes()
    }
}

impl Scratch {
    /// Bytes held.
    fn bytes(&self) -> usize {
        self.given.capacity() * size_of::<[f64; 4]>()
            + self.clipped.bytes()
            + self.screen.capacity() * size_of::<ScreenVertex>()
            + self.outline.bytes()
            + (self.spans.capacity() + self.spare_spans.capacity()) * size_of::<Span>()
            + self.patches.capacity() * size_of::<Patch>()
            + self.gradients.bytes()
            + self.attributes.bytes()
    }
}

/// Compiled for the instruction set: it is arithmetic from end to end.
#[inline(never)]
fn set_gradients(level: Level, gradients: &mut Gradients, subject: &Subject<'_>) {
    dispatch!(level, simd => gradients.set(simd, subject));
}

/// The pixels of a polygon.
#[derive(Clone, Copy)]
enum Seen<'a> {
    /// In the scratch's spans, of what was taken.
    Spans,
    /// In patches; and the positions.
    Small(&'a InView, &'a [[f64; 4]; 3], Taken),
}

#[inline(always)]
fn positions_of<V: Polygon + ?Sized>(triangle: &V) -> [[f64; 4]; 3] {
    [triangle.position(0), triangle.position(1), triangle.position(2)]
}
