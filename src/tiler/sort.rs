//! Where a polygon is to be drawn, and whether at all: found before any pixel, so that polygons can
//! be sorted into bands of rows.

use fearless_simd::Simd as Lanes;

use super::{Outcome, Tiler};
use crate::depth::Occluders;
use crate::fixed::Subpixel;
use crate::patch::Patches;
use crate::placed::PlacedVertex;
use crate::polygon::Polygon;
use crate::space::PixelRect;
use crate::triangle::LARGEST;

/// The rows that a polygon may cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rows {
    /// Of the framebuffer; not empty.
    pub(crate) first: i32,
    pub(crate) last: i32,
    /// Is its set-up so dear that it is to be kept from band to band?
    pub(crate) keep: bool,
}

/// Vertices of a polygon that are looked at here; what has more goes the way of any polygon.
const MOST_VERTICES: usize = 16;

impl Tiler {
    /// What becomes of `polygon`, and which rows of `window` it may cover, if any, unless
    /// `occluders` hide it. Counts nothing but what was clipped.
    #[inline(always)]
    pub(crate) fn sort<L: Lanes, V: Polygon + ?Sized>(
        &mut self,
        simd: L,
        polygon: &V,
        window: PixelRect,
        occluders: Option<&Occluders>,
    ) -> (Outcome, Option<Rows>) {
        let n = polygon.len();
        if !(3..=MOST_VERTICES).contains(&n) || self.clipper.has_user_planes() {
            return self.sort_any(polygon, window);
        }
        if n == 3
            && let Some(found) = self.sort_small(simd, polygon, window)
        {
            return found;
        }
        let first = self.vertex_place(simd, polygon, 0);
        let (mut low, mut high, mut within) = (first.bits, first.bits, first.within);
        let [fx, fy] = first.bits;
        let mut last = [0; 2];
        // Twice the area; each term is below 2^61.
        let mut area = 0_i128;
        for i in 1..n {
            let PlacedVertex { bits: [x, y], within: is_within } =
                self.vertex_place(simd, polygon, i);
            within &= is_within;
            low = [low[0].min(x), low[1].min(y)];
            high = [high[0].max(x), high[1].max(y)];
            let to = [x.wrapping_sub(fx), y.wrapping_sub(fy)];
            let wide = |a: i32, b: i32| i64::from(a).wrapping_mul(b.into());
            area += i128::from(wide(last[1], to[0]).wrapping_sub(wide(last[0], to[1])));
            last = to;
        }
        // Only a crossing polygon covers anything without an area.
        if !within || area == 0 && n > 3 {
            return self.sort_any(polygon, window);
        }
        if area == 0 {
            return (Outcome::Degenerate, None);
        }
        if !self.cull.keeps(area > 0) {
            return (Outcome::Backface, None);
        }
        if let Some(occluders) = occluders
            && self.is_occluded(simd, polygon, window, occluders)
        {
            return (Outcome::Hidden, None);
        }
        let bounds = self.bounds_between(low, high);
        (Outcome::Drawn, Rows::of(bounds.intersect(window), true))
    }

    /// The same of a triangle within the view, if it is small. Most of a fine mesh are, and lie between
    /// the centres.
    #[inline(always)]
    fn sort_small<L: Lanes, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
        window: PixelRect,
    ) -> Option<(Outcome, Option<Rows>)> {
        let a = self.vertex_place(simd, polygon, 0);
        let b = self.vertex_place(simd, polygon, 1);
        let c = self.vertex_place(simd, polygon, 2);
        if !(a.within & b.within & c.within) {
            return None;
        }
        let ([ax, ay], [bx, by], [cx, cy]) = (a.bits, b.bits, c.bits);
        let low = [ax.min(bx).min(cx), ay.min(by).min(cy)];
        let high = [ax.max(bx).max(cx), ay.max(by).max(cy)];
        // Within the view volume: no difference overflows.
        if (high[0] - low[0]) | (high[1] - low[1]) >= LARGEST {
            return None;
        }
        let wide = |p: i32, q: i32| i64::from(p) * i64::from(q);
        let area = wide(by - ay, cx - ax) - wide(bx - ax, cy - ay);
        if area == 0 {
            return Some((Outcome::Degenerate, None));
        }
        if !self.cull.keeps(area > 0) {
            return Some((Outcome::Backface, None));
        }
        let x = [Subpixel::first_centre_of(low[0]), Subpixel::first_centre_of(high[0])];
        let y = [Subpixel::first_centre_of(low[1]), Subpixel::first_centre_of(high[1])];
        if x[0] >= x[1] || y[0] >= y[1] {
            return Some((Outcome::Drawn, None));
        }
        if x[1] - x[0] == 1 && y[1] - y[0] == 1 {
            let corners = [a.bits, b.bits, c.bits];
            if !Patches::covers_pixel([x[0], y[0]], corners, area > 0) {
                return Some((Outcome::Drawn, None));
            }
        }
        let bounds = self.bounds_between(low, high);
        let is_small = Patches::are_few(bounds);
        is_small.then(|| (Outcome::Drawn, Rows::of(bounds.intersect(window), false)))
    }

    #[inline(never)]
    fn sort_any<V: Polygon + ?Sized>(
        &mut self,
        polygon: &V,
        window: PixelRect,
    ) -> (Outcome, Option<Rows>) {
        match self.take(polygon) {
            Ok(taken) => (Outcome::Drawn, Rows::of(taken.seen.intersect(window), true)),
            Err(outcome) => (outcome, None),
        }
    }

    /// The pixels whose centres lie between two places on the grid.
    #[inline(always)]
    pub(super) fn bounds_between(&self, low: [i32; 2], high: [i32; 2]) -> PixelRect {
        let corner = self.viewport.rect();
        let column = |x: i32| Subpixel::first_centre_of(x).saturating_add(corner.x0);
        let row = |y: i32| Subpixel::first_centre_of(y).saturating_add(corner.y0);
        PixelRect { x0: column(low[0]), y0: row(low[1]), x1: column(high[0]), y1: row(high[1]) }
    }

    /// Where vertex `i` lies.
    #[inline(always)]
    pub(super) fn vertex_place<L: Lanes, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
        i: usize,
    ) -> PlacedVertex {
        match polygon.placed() {
            Some(placed) if placed.viewport() == self.viewport => {
                placed.vertex(polygon.placed_index(i))
            }
            _ => self.place_constants.place(simd, &polygon.position(i)),
        }
    }
}

impl Rows {
    /// Of the pixels `seen`, unless there are none.
    #[inline(always)]
    fn of(seen: PixelRect, keep: bool) -> Option<Self> {
        (!seen.is_empty()).then_some(Self { first: seen.y0, last: seen.y1 - 1, keep })
    }
}
