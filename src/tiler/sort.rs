//! Where a polygon is to be drawn, and whether at all: found before any pixel, so that polygons can
//! be sorted into bands of rows.

use fearless_simd::Simd as Lanes;

use super::{Outcome, Tiler};
use crate::depth::Occluders;
use crate::fixed::Subpixel;
use crate::patch::Patches;
use crate::placed::{Placed, PlacedVertex};
use crate::polygon::Polygon;
use crate::space::PixelRect;

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
        let placed = self.placed(polygon);
        let first = self.vertex_place(simd, polygon, placed, 0);
        let (mut low, mut high, mut within) = (first.bits, first.bits, first.within);
        let [fx, fy] = first.bits;
        let mut last = [0; 2];
        let (mut second, mut third) = ([0; 2], [0; 2]);
        // Twice the area; each term is below 2^61.
        let mut area = 0_i128;
        for i in 1..n {
            let PlacedVertex { bits: [x, y], within: is_within } =
                self.vertex_place(simd, polygon, placed, i);
            within &= is_within;
            low = [low[0].min(x), low[1].min(y)];
            high = [high[0].max(x), high[1].max(y)];
            let to = [x.wrapping_sub(fx), y.wrapping_sub(fy)];
            let wide = |a: i32, b: i32| i64::from(a).wrapping_mul(b.into());
            area += i128::from(wide(last[1], to[0]).wrapping_sub(wide(last[0], to[1])));
            last = to;
            (second, third) = (third, [x, y]);
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
        let (bounds, corner) = (self.bounds_between(low, high), self.viewport.rect());
        if let Some(occluders) = occluders
            && self.is_occluded(simd, polygon, window, occluders)
        {
            return (Outcome::Hidden, None);
        }
        let is_small = n == 3 && Patches::are_few(bounds);
        if is_small && bounds.x1 - bounds.x0 == 1 && bounds.y1 - bounds.y0 == 1 {
            // Most triangles of a fine mesh end here: between the centres.
            let corners = [[fx, fy], second, third];
            let pixel = [bounds.x0 - corner.x0, bounds.y0 - corner.y0];
            if !Patches::covers_pixel(pixel, corners, area > 0) {
                return (Outcome::Drawn, None);
            }
        }
        (Outcome::Drawn, Rows::of(bounds.intersect(window), !is_small))
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

    /// Where the vertices of `polygon` were placed for this viewport, if they were: asked once for a
    /// polygon, since of a small triangle it is felt.
    #[inline(always)]
    pub(super) fn placed<'p, V: Polygon + ?Sized>(&self, polygon: &'p V) -> Option<&'p Placed> {
        match polygon.placed() {
            Some(placed) if placed.viewport() == self.viewport => Some(placed),
            _ => None,
        }
    }

    /// Where vertex `i` lies, of a polygon that is [`placed`](Self::placed) so.
    #[inline(always)]
    pub(super) fn vertex_place<L: Lanes, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
        placed: Option<&Placed>,
        i: usize,
    ) -> PlacedVertex {
        match placed {
            Some(placed) => placed.vertex(polygon.placed_index(i)),
            None => self.place_constants.place(simd, &polygon.position(i)),
        }
    }

    /// Where the first `N` vertices lie, of a polygon that has as many.
    #[inline(always)]
    pub(super) fn vertex_places<const N: usize, L: Lanes, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
    ) -> [PlacedVertex; N] {
        let placed = self.placed(polygon);
        let mut places = [PlacedVertex::default(); N];
        for (i, place) in places.iter_mut().enumerate() {
            *place = self.vertex_place(simd, polygon, placed, i);
        }
        places
    }
}

impl Rows {
    /// Of the pixels `seen`, unless there are none.
    #[inline(always)]
    fn of(seen: PixelRect, keep: bool) -> Option<Self> {
        (!seen.is_empty()).then_some(Self { first: seen.y0, last: seen.y1 - 1, keep })
    }
}
