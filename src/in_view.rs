//! Small triangles and quadrilaterals within the view volume: from places on the grid to covered pixels.
//!
//! Most polygons are small ones that nothing clips. For triangles, and for quadrilaterals that are convex
//! on the grid, this does what edges and spans do for any polygon, and to the same pixels. What is neither
//! is left to those. Up to eight of a kind are looked at together: every number here is a whole one, or some
//! bits of one, and below 2^50, so that `f64` has it exactly.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over arrays are unrolled, iterators are not"
)]

use fearless_simd::Simd;

use crate::fixed::{Subpixel, WHOLE, whole_of};
use crate::gradient::middle;
use crate::number::{EIGHT, Lanes, Number, range_of};
use crate::patch::{Edge, Patches};
use crate::space::PixelRect;

/// A small polygon within the view volume that covers some pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct InView {
    pub(crate) patches: Patches,
    /// Pixels of the framebuffer that it may cover.
    pub(crate) bounds: PixelRect,
    pub(crate) pixels: u64,
    pub(crate) spans: u64,
    /// How far beyond those of its corners a triangle's depths may lie: times their range.
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

/// What became of a polygon.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Sight {
    /// It is not small, not within the view volume, or has no convex outline.
    #[default]
    Elsewhere,
    /// No area, once snapped.
    Degenerate,
    /// It faces away.
    Away,
    /// No pixel's centre is covered, or none in the window.
    Nothing,
    /// [`InView`] tells; of a quadrilateral.
    Pixels,
    PixelsOfQuad,
    /// What it covers is hidden.
    Hidden,
}

/// The longest side of a small polygon's bounding box, with 16 fraction bits.
const LARGEST: f64 = 256.0 * PIXEL;

/// A pixel, with 16 fraction bits.
const PIXEL: f64 = (1 << Subpixel::FRACTION_BITS) as f64;

/// A half of a number's last place, of those with 16 fraction bits.
const HALF_STEP: f64 = 0.5 / PIXEL;

/// How thick a polygon must be, in the reach of the snap, for its corners to tell its depths.
pub(crate) const THICK: f64 = 512.0;

/// By how much of the corners' range depths may lie beyond it, then.
pub(crate) const BEYOND: f64 = 1.0 / 64.0;

/// Where small polygons are to be drawn.
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

/// Vertices of polygons of `N` on the grid, from the viewport's corner, with 16 fraction bits.
#[derive(Debug)]
pub(crate) struct Places<const N: usize> {
    pub(crate) x: [Lanes; N],
    pub(crate) y: [Lanes; N],
    /// A bit for each lane: is there such a polygon within the view volume?
    pub(crate) within: u8,
}

impl<const N: usize> Default for Places<N> {
    fn default() -> Self {
        Self { x: [Lanes::default(); N], y: [Lanes::default(); N], within: 0 }
    }
}

/// What is known of them; of what is asked for by lane, [`WHOLE`] more than it is.
#[derive(Debug)]
pub(crate) struct Looks<const N: usize> {
    /// A bit for each lane; the first of these that holds counts.
    small: u8,
    degenerate: u8,
    away: u8,
    empty: u8,
    /// Columns and rows of the pixels whose centres lie in the bounding box, from the viewport's corner:
    /// the first, and the first beyond.
    first: [Lanes; 2],
    end: [Lanes; 2],
    edges: [EdgeLanes; N],
    beyond: Lanes,
}

impl<const N: usize> Default for Looks<N> {
    fn default() -> Self {
        Self {
            small: 0,
            degenerate: 0,
            away: 0,
            empty: 0,
            first: [Lanes::default(); 2],
            end: [Lanes::default(); 2],
            edges: [EdgeLanes::default(); N],
            beyond: Lanes::default(),
        }
    }
}

/// See [`Edge`].
#[derive(Clone, Copy, Debug, Default)]
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

impl<const N: usize> Looks<N> {
    /// Forgets all. Is any of the polygons of `places` worth a look?
    #[inline(always)]
    pub(crate) fn start(&mut self, places: &Places<N>) -> bool {
        self.small = 0;
        places.within != 0
    }

    /// Is there a small polygon in any lane?
    #[inline(always)]
    pub(crate) fn any(&self) -> bool {
        self.small != 0
    }

    /// Is there one in `lane`?
    #[inline(always)]
    pub(crate) fn is_small(&self, lane: usize) -> bool {
        self.small >> (lane % EIGHT) & 1 != 0
    }

    /// Looks at the polygons of `places`.
    #[inline(always)]
    pub(crate) fn look<F: Number>(&mut self, level: F::Level, places: &Places<N>, scope: &Scope) {
        let (xs, ys) = (load::<F, N>(level, &places.x), load::<F, N>(level, &places.y));
        let ([low_x, high_x], [low_y, high_y]) = (range_of(&xs), range_of(&ys));
        let (width, height) = (high_x - low_x, high_y - low_y);
        let largest = low_x.like(LARGEST);
        self.small = places.within & F::bits(width.lt(largest) & height.lt(largest));
        let zero = low_x.like(0.0);
        let area = turn([xs[0], ys[0]], [xs[1], ys[1]], [xs[2], ys[2]]);
        let front = zero.lt(area);
        if N > 3 {
            self.small &= F::bits(turns_one_way(&xs, &ys));
        }
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
        let mut corners = [[zero; 2]; N];
        for i in 0..N {
            let k = (N - i) % N;
            let (cx, cy) = (F::select(front, xs[k], xs[i]), F::select(front, ys[k], ys[i]));
            corners[i] = [cx - x, cy - y];
        }
        for i in 0..N {
            self.edges[i].set(corners[i], corners[(i + 1) % N]);
        }

        if N > 3 {
            return;
        }
        let reach = scope.snap_reach;
        let size = (width + height) * (1.0 / PIXEL) + 2.0 * reach;
        let thick = (size * (THICK * reach)).le(area.abs() * (1.0 / (PIXEL * PIXEL)));
        F::select(thick, zero + BEYOND, zero + f64::INFINITY).store(&mut self.beyond);
    }

    /// What becomes of the polygon in `lane`. If it may cover pixels, `found` has its patches, with
    /// nothing covered yet.
    #[inline(always)]
    pub(crate) fn sight(&self, lane: usize, scope: &Scope, found: &mut InView) -> Sight {
        let lane = lane % EIGHT;
        let is = |lanes: u8| lanes >> lane & 1 != 0;
        if !self.is_small(lane) {
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

    /// Finds what the polygon in `lane` covers within the window, of those that may cover pixels.
    #[inline(always)]
    pub(crate) fn cover<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        scope: &Scope,
        found: &mut InView,
    ) -> Sight {
        let lane = lane % EIGHT;
        let mut edges = [self.edges[0].of(lane); N];
        for i in 1..N {
            edges[i] = self.edges[i].of(lane);
        }
        (found.pixels, found.spans) = found.patches.cover(simd, edges, scope.window);
        if found.pixels > 0 { Sight::Pixels } else { Sight::Nothing }
    }
}

/// Twice the area of a triangle; positive for counter-clockwise ones (y up).
#[inline(always)]
fn turn<F: Number>([ax, ay]: [F; 2], [bx, by]: [F; 2], [cx, cy]: [F; 2]) -> F {
    (by - ay) * (cx - ax) - (bx - ax) * (cy - ay)
}

/// Does the outline turn the same way at each corner? Of four corners none crosses itself then.
#[inline(always)]
fn turns_one_way<F: Number, const N: usize>(xs: &[F; N], ys: &[F; N]) -> F::Truth {
    let zero = xs[0].like(0.0);
    let area = turn([xs[0], ys[0]], [xs[1], ys[1]], [xs[2], ys[2]]);
    let (mut front, mut back) = (zero.lt(area), area.lt(zero));
    for i in 1..N {
        let (k, l) = ((i + 1) % N, (i + 2) % N);
        let area = turn([xs[i], ys[i]], [xs[k], ys[k]], [xs[l], ys[l]]);
        (front, back) = (front & zero.lt(area), back & area.lt(zero));
    }
    front | back
}

#[inline(always)]
fn load<F: Number, const N: usize>(level: F::Level, lanes: &[Lanes; N]) -> [F; N] {
    let mut numbers = [F::load(level, &lanes[0]); N];
    for i in 1..N {
        numbers[i] = F::load(level, &lanes[i]);
    }
    numbers
}
