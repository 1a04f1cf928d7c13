//! Small triangles within the view volume: from places on the grid to covered pixels.
//!
//! Most polygons are small triangles that nothing clips. For them this does what edges and spans
//! do for any polygon, and to the same pixels. What is not such a triangle is left to those. Up to
//! eight are looked at together: every number here is a whole one, or some bits of one, and below
//! 2^50, so that `f64` has it exactly.

use fearless_simd::Simd;

use crate::fixed::{Subpixel, WHOLE, whole_of};
use crate::gradient::middle;
use crate::number::{EIGHT, Lanes, Number};
use crate::patch::{Edge, Patches};
use crate::space::PixelRect;

/// A small triangle within the view volume that covers some pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct InView {
    pub(crate) patches: Patches,
    /// Pixels of the framebuffer that it may cover.
    pub(crate) bounds: PixelRect,
    pub(crate) pixels: u64,
    pub(crate) spans: u64,
    /// How far beyond those of its corners its depths may lie: times their range.
    pub(crate) beyond: f64,
}

impl InView {
    /// The pixel in the middle, and how many columns and rows others are from it at most.
    #[inline(always)]
    pub(crate) fn middle(&self) -> [(i32, f64); 2] {
        let PixelRect { x0, y0, x1, y1 } = self.bounds;
        [middle([x0, x1 - 1]), middle([y0, y1 - 1])]
    }
}

/// What became of a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Sight {
    /// It is not small, or not within the view volume.
    #[default]
    Elsewhere,
    /// No area, once snapped.
    Degenerate,
    /// It faces away.
    Away,
    /// No pixel's centre is covered, or none in the window.
    Nothing,
    /// [`InView`] tells.
    Pixels,
}

/// The longest side of a small triangle's bounding box, with 16 fraction bits.
const LARGEST: f64 = 256.0 * PIXEL;

/// A pixel, with 16 fraction bits.
const PIXEL: f64 = (1 << Subpixel::FRACTION_BITS) as f64;

/// A half of a number's last place, of those with 16 fraction bits.
const HALF_STEP: f64 = 0.5 / PIXEL;

/// How thick a polygon must be, in the reach of the snap, for its corners to tell its depths.
pub(crate) const THICK: f64 = 512.0;

/// By how much of the corners' range depths may lie beyond it, then.
pub(crate) const BEYOND: f64 = 1.0 / 64.0;

/// Where triangles are to be drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scope {
    /// The viewport's corner in the framebuffer, and what of that is drawn.
    pub(crate) corner: [i32; 2],
    pub(crate) window: PixelRect,
    /// Are back faces drawn, and front faces?
    pub(crate) wants: [bool; 2],
    /// How far the snap moves a vertex, in pixels, at most.
    pub(crate) snap_reach: f64,
}

/// Triangles' vertices on the grid, from the viewport's corner, with 16 fraction bits.
#[derive(Debug, Default)]
pub(crate) struct Places {
    pub(crate) x: [Lanes; 3],
    pub(crate) y: [Lanes; 3],
    /// A bit for each lane: is it a triangle within the view volume?
    pub(crate) within: u8,
}

/// What is known of them; of what is asked for by lane, [`WHOLE`] more than it is.
#[derive(Debug, Default)]
pub(crate) struct Looks {
    /// A bit for each lane; the first of these that holds counts.
    small: u8,
    degenerate: u8,
    away: u8,
    empty: u8,
    /// Columns and rows of the pixels whose centres lie in the bounding box, from the viewport's corner:
    /// the first, and the first beyond.
    first: [Lanes; 2],
    end: [Lanes; 2],
    edges: [EdgeLanes; 3],
    beyond: Lanes,
}

/// See [`Edge`].
#[derive(Debug, Default)]
struct EdgeLanes {
    start: Lanes,
    step_x: Lanes,
    step_y: Lanes,
}

impl EdgeLanes {
    /// From `p` to `q`, with the inside on the left where y points down.
    #[inline(always)]
    fn set<F: Number>(&mut self, [px, py]: [F; 2], [qx, qy]: [F; 2]) {
        let (dx, dy) = (qx - px, qy - py);
        // On the edge itself: is a point a hair to the right, and a hair's hair below, inside?
        let zero = dx.like(0.0);
        let owns = dy.lt(zero) | dy.eq(zero) & zero.lt(dx);
        let start = dy * px - dx * py - dx.like(1.0).zero_if(owns);
        floor(start * (1.0 / PIXEL)).store(&mut self.start);
        (dx.like(WHOLE) - dy).store(&mut self.step_x);
        (dx + WHOLE).store(&mut self.step_y);
    }

    #[inline(always)]
    fn of(&self, lane: usize) -> Edge {
        Edge {
            start: whole_of(self.start[lane]),
            step_x: whole_of(self.step_x[lane]),
            step_y: whole_of(self.step_y[lane]),
        }
    }
}

/// [`WHOLE`] more than the greatest whole number that is not above a number with 16 fraction bits.
#[inline(always)]
fn floor<F: Number>(number: F) -> F {
    // Never halfway between two whole numbers.
    number - (0.5 - HALF_STEP) + WHOLE
}

/// [`WHOLE`] more than the first row (or column) whose centre is at or beyond `bits`: see
/// [`Subpixel::first_centre`].
#[inline(always)]
fn first_centre<F: Number>(bits: F) -> F {
    bits * (1.0 / PIXEL) - HALF_STEP + WHOLE
}

impl Looks {
    /// Forgets all. Is any of the triangles of `places` worth a look?
    #[inline(always)]
    pub(crate) fn start(&mut self, places: &Places) -> bool {
        self.small = 0;
        places.within != 0
    }

    /// Looks at the triangles of `places`.
    #[inline(always)]
    pub(crate) fn look<F: Number>(&mut self, level: F::Level, places: &Places, scope: &Scope) {
        let [ax, bx, cx] = load::<F>(level, &places.x);
        let [ay, by, cy] = load::<F>(level, &places.y);
        let (low_x, high_x) = (ax.lesser(bx).lesser(cx), ax.greater(bx).greater(cx));
        let (low_y, high_y) = (ay.lesser(by).lesser(cy), ay.greater(by).greater(cy));
        let (width, height) = (high_x - low_x, high_y - low_y);
        let largest = ax.like(LARGEST);
        self.small = places.within & F::bits(width.lt(largest) & height.lt(largest));
        let area = (by - ay) * (cx - ax) - (bx - ax) * (cy - ay);
        let zero = ax.like(0.0);
        let front = zero.lt(area);
        self.degenerate = F::bits(area.eq(zero));
        let [back_wanted, front_wanted] = scope.wants;
        self.away = match (back_wanted, front_wanted) {
            (true, true) => 0,
            (true, false) => F::bits(front),
            (false, true) => !F::bits(front),
            (false, false) => u8::MAX,
        };
        let (x0, y0) = (first_centre(low_x), first_centre(low_y));
        let (x1, y1) = (first_centre(high_x), first_centre(high_y));
        self.empty = F::bits(x1.le(x0) | y1.le(y0));
        x0.store(&mut self.first[0]);
        y0.store(&mut self.first[1]);
        x1.store(&mut self.end[0]);
        y1.store(&mut self.end[1]);

        // From the first pixel's centre, the same way round for all.
        let (x, y) = ((x0 - WHOLE) * PIXEL + PIXEL / 2.0, (y0 - WHOLE) * PIXEL + PIXEL / 2.0);
        let a = [ax - x, ay - y];
        let b = [F::select(front, cx, bx) - x, F::select(front, cy, by) - y];
        let c = [F::select(front, bx, cx) - x, F::select(front, by, cy) - y];
        let [ab, bc, ca] = &mut self.edges;
        ab.set(a, b);
        bc.set(b, c);
        ca.set(c, a);

        let reach = scope.snap_reach;
        let size = (width + height) * (1.0 / PIXEL) + 2.0 * reach;
        let thick = (size * (THICK * reach)).le(area.abs() * (1.0 / (PIXEL * PIXEL)));
        F::select(thick, zero + BEYOND, zero + f64::INFINITY).store(&mut self.beyond);
    }

    /// What becomes of the triangle in `lane`. If it may cover pixels, `found` has its patches, with
    /// nothing covered yet.
    #[inline(always)]
    pub(crate) fn sight(&self, lane: usize, scope: &Scope, found: &mut InView) -> Sight {
        let lane = lane % EIGHT;
        let is = |lanes: u8| lanes >> lane & 1 != 0;
        if !is(self.small) {
            return Sight::Elsewhere;
        }
        if is(self.degenerate) {
            return Sight::Degenerate;
        }
        if is(self.away) {
            return Sight::Away;
        }
        if is(self.empty) {
            return Sight::Nothing;
        }
        let [corner_x, corner_y] = scope.corner;
        let [[x0, y0], [x1, y1]] =
            [&self.first, &self.end].map(|[x, y]| [whole_of(x[lane]), whole_of(y[lane])]);
        // The viewport may lie at the end of all columns or rows.
        let (Some(end_x), Some(end_y)) = (x1.checked_add(corner_x), y1.checked_add(corner_y))
        else {
            return Sight::Elsewhere;
        };
        found.bounds = PixelRect { x0: x0 + corner_x, y0: y0 + corner_y, x1: end_x, y1: end_y };
        let Some(patches) = Patches::of(found.bounds) else { return Sight::Elsewhere };
        (found.patches, found.beyond) = (patches, self.beyond[lane]);
        Sight::Pixels
    }

    /// Finds what the triangle in `lane` covers within the window, of those that may cover pixels.
    #[inline(always)]
    pub(crate) fn cover<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        scope: &Scope,
        found: &mut InView,
    ) -> Sight {
        let [ab, bc, ca] = &self.edges;
        let lane = lane % EIGHT;
        let edges = [ab.of(lane), bc.of(lane), ca.of(lane)];
        (found.pixels, found.spans) = found.patches.cover(simd, edges, scope.window);
        if found.pixels > 0 { Sight::Pixels } else { Sight::Nothing }
    }
}

#[inline(always)]
fn load<F: Number>(level: F::Level, [a, b, c]: &[Lanes; 3]) -> [F; 3] {
    [F::load(level, a), F::load(level, b), F::load(level, c)]
}
