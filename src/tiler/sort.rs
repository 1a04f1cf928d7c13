//! Where a polygon is to be drawn, and whether at all: found before any pixel, so that polygons can
//! be sorted into bands of rows.

use fearless_simd::Simd;

use super::bunch::Bunch;
use super::{Outcome, Tiler};
use crate::depth::Occluders;
use crate::fixed::Subpixel;
use crate::in_view::{InView, Sight};
use crate::placed::{Constants, Placed, PlacedVertex};
use crate::polygon::Polygon;
use crate::space::{PixelRect, Viewport};

/// The rows that a polygon may cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rows {
    /// Of the framebuffer; not empty.
    pub(crate) first: i32,
    pub(crate) last: i32,
}

/// Vertices of a polygon that are looked at here; what has more goes the way of any polygon.
const MOST_VERTICES: usize = 16;

impl Tiler {
    /// What becomes of `polygon`, which was looked at from outside as that of `lane`, and which rows of
    /// `window` it may cover, if any, unless `occluders` hide it. Counts nothing but what was clipped.
    #[inline(always)]
    pub(crate) fn sort_next<L: Simd, V: Polygon + ?Sized>(
        &mut self,
        simd: L,
        polygon: &V,
        lane: usize,
        window: PixelRect,
        occluders: Option<&Occluders>,
    ) -> (Outcome, Option<Rows>) {
        let (scope, mut found) = (self.scope(window), InView::default());
        let Bunch { looks, quad_looks, .. } = &self.bunch;
        if quad_looks.is_small(lane) {
            return match quad_looks.sight(lane, &scope, &mut found) {
                Sight::Away => (Outcome::Backface, None),
                Sight::Nothing => (Outcome::Drawn, None),
                Sight::Pixels if !self.is_occluded_by(simd, polygon, window, occluders) => {
                    (Outcome::Drawn, Rows::of(found.bounds.intersect(window)))
                }
                Sight::Pixels => (Outcome::Hidden, None),
                _ => self.sort(simd, polygon, window, occluders),
            };
        }
        match looks.sight(lane, &scope, &mut found) {
            Sight::Degenerate => (Outcome::Degenerate, None),
            Sight::Away => (Outcome::Backface, None),
            Sight::Nothing => (Outcome::Drawn, None),
            // Most triangles of a fine mesh end here: between the centres.
            Sight::Pixels
                if found.patches.is_pixel()
                    && looks.cover(simd, lane, &scope, &mut found) == Sight::Nothing =>
            {
                (Outcome::Drawn, None)
            }
            Sight::Pixels => (Outcome::Drawn, Rows::of(found.bounds.intersect(window))),
            _ => self.sort(simd, polygon, window, occluders),
        }
    }

    #[inline(always)]
    fn is_occluded_by<L: Simd, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
        window: PixelRect,
        occluders: Option<&Occluders>,
    ) -> bool {
        let Some(occluders) = occluders else { return false };
        self.is_occluded(simd, polygon, window, occluders)
    }

    /// The same of a polygon that is not small.
    #[inline(always)]
    fn sort<L: Simd, V: Polygon + ?Sized>(
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
        let placed = placed_for(self.viewport, polygon);
        let first = vertex_place(simd, &self.place_constants, polygon, placed, 0);
        let (mut low, mut high, mut within) = (first.bits, first.bits, first.within);
        let [fx, fy] = first.bits;
        let mut last = [0; 2];
        // Twice the area; each term is below 2^61.
        let mut area = 0_i128;
        for i in 1..n {
            let PlacedVertex { bits: [x, y], within: is_within } =
                vertex_place(simd, &self.place_constants, polygon, placed, i);
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
        if self.is_occluded_by(simd, polygon, window, occluders) {
            return (Outcome::Hidden, None);
        }
        let bounds = self.bounds_between(low, high);
        (Outcome::Drawn, Rows::of(bounds.intersect(window)))
    }

    #[inline(never)]
    fn sort_any<V: Polygon + ?Sized>(
        &mut self,
        polygon: &V,
        window: PixelRect,
    ) -> (Outcome, Option<Rows>) {
        match self.take(polygon) {
            Ok(taken) => (Outcome::Drawn, Rows::of(taken.seen.intersect(window))),
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

    /// The pixels that a polygon may cover, if it has a vertex and lies within the view.
    #[inline(always)]
    pub(crate) fn bounds_in_view<L: Simd, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
    ) -> Option<PixelRect> {
        if polygon.len() == 0 {
            return None;
        }
        let placed = placed_for(self.viewport, polygon);
        let (mut low, mut high) = ([i32::MAX; 2], [i32::MIN; 2]);
        for i in 0..polygon.len() {
            let PlacedVertex { bits: [x, y], within } =
                vertex_place(simd, &self.place_constants, polygon, placed, i);
            if !within {
                return None;
            }
            low = [low[0].min(x), low[1].min(y)];
            high = [high[0].max(x), high[1].max(y)];
        }
        Some(self.bounds_between(low, high))
    }

    /// Where the four vertices lie, of a polygon that has as many.
    #[inline(always)]
    pub(super) fn vertex_places<L: Simd, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
    ) -> [PlacedVertex; 4] {
        let placed = placed_for(self.viewport, polygon);
        let mut places = [PlacedVertex::default(); 4];
        for (i, place) in places.iter_mut().enumerate() {
            *place = vertex_place(simd, &self.place_constants, polygon, placed, i);
        }
        places
    }
}

/// Where the vertices of `polygon` were placed for `viewport`, if they were: asked once for a polygon,
/// since of a small triangle it is felt.
#[inline(always)]
pub(super) fn placed_for<V: Polygon + ?Sized>(viewport: Viewport, polygon: &V) -> Option<&Placed> {
    match polygon.placed() {
        Some(placed) if placed.viewport() == viewport => Some(placed),
        _ => None,
    }
}

/// Where vertex `i` lies, of a polygon that is placed so.
#[inline(always)]
pub(super) fn vertex_place<L: Simd, V: Polygon + ?Sized>(
    simd: L,
    constants: &Constants,
    polygon: &V,
    placed: Option<&Placed>,
    i: usize,
) -> PlacedVertex {
    match placed {
        Some(placed) => placed.vertex(polygon.placed_index(i)),
        None => constants.place(simd, &polygon.position(i)),
    }
}

impl Rows {
    /// Of the pixels `seen`, unless there are none.
    #[inline(always)]
    fn of(seen: PixelRect) -> Option<Self> {
        (!seen.is_empty()).then_some(Self { first: seen.y0, last: seen.y1 - 1 })
    }
}
