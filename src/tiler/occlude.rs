//! What a polygon hides, before anything is drawn.

use fearless_simd::Simd as Lanes;

use super::hidden::right_depth;
use super::scan::{Counts, Taken, bounds};
use super::tiles::{SMALL, TestedSpans};
use super::{Precision, Scratch, Tiler, set_gradients};
use crate::depth::{DepthSource, Occluders};
use crate::divide::snapped_area;
use crate::fixed::Subpixel;
use crate::gradient::{AttributesOf, Wanted, nearest_f32};
use crate::hidden::Area;
use crate::polygon::Polygon;
use crate::space::PixelRect;
use crate::subnormal;

impl Tiler {
    /// How many pixels of `window` `polygon` may cover, about, if it is large enough to hide
    /// anything; else 0.
    #[inline(always)]
    pub(crate) fn large_area<L: Lanes, V: Polygon + ?Sized>(
        &mut self,
        simd: L,
        polygon: &V,
        window: PixelRect,
    ) -> u64 {
        if self.is_placed_small(simd, polygon, window) {
            0
        } else {
            self.taken_area(polygon, window)
        }
    }

    /// Is it within the view, and too small to fill tiles of `window`?
    #[inline(always)]
    fn is_placed_small<L: Lanes, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
        window: PixelRect,
    ) -> bool {
        if polygon.len() < 3 {
            return true;
        }
        let bounds = self.bounds_in_view(simd, polygon);
        bounds.is_some_and(|bounds| bounds.intersect(window).area() < SMALL)
    }

    #[inline(never)]
    fn taken_area<V: Polygon + ?Sized>(&mut self, polygon: &V, window: PixelRect) -> u64 {
        let Some(taken) = self.take_uncounted(polygon) else { return 0 };
        let seen = taken.seen.intersect(window);
        let around = bounds(&self.scratch.screen, self.viewport);
        let pixels = if around.intersect(window) == around {
            let twice = snapped_area(&self.scratch.screen).unsigned_abs();
            u64::try_from(twice >> (2 * Subpixel::FRACTION_BITS + 1)).unwrap_or(u64::MAX)
        } else if seen.area() < SMALL {
            0
        } else {
            self.scan(window).pixels
        };
        if pixels < SMALL { 0 } else { pixels }
    }

    /// Takes `polygon` into the scratch, if anything of it is drawn. It is not drawn yet, so nothing
    /// counts.
    fn take_uncounted<V: Polygon + ?Sized>(&mut self, polygon: &V) -> Option<Taken> {
        let stats = self.stats;
        let taken = self.take(polygon);
        self.stats = stats;
        self.scratch.taken = taken.ok()?;
        Some(self.scratch.taken)
    }

    /// Notes which tiles of the depth buffer `polygon` fills, and returns how many of them were not
    /// filled before; nothing if it seems hidden itself, or is small.
    pub(crate) fn occlude<V: Polygon + ?Sized>(
        &mut self,
        polygon: &V,
        window: PixelRect,
        occluders: &mut Occluders,
    ) -> Option<u32> {
        self.take_uncounted(polygon)?;
        if self.seems_hidden(window, occluders) || self.scan(window).pixels < SMALL {
            return None;
        }
        let place = self.placement();
        let Scratch { given, taken, screen, spans, gradients, .. } = &mut self.scratch;
        let source = self.depth_test.source;
        let attributes = &AttributesOf(polygon);
        let wanted = Wanted {
            depth: source == DepthSource::Z,
            inv_w: source == DepthSource::InvW,
            w: false,
            attributes: 0,
            exact: self.precision == Precision::Exact,
        };
        let subject =
            taken.subject(attributes, given, screen, self.viewport, &self.interpolation, wanted);
        set_gradients(self.simd.0, gradients, &subject);
        Some(
            TestedSpans::new(gradients, &subject, place, Counts::default())
                .occlude(spans, occluders),
        )
    }

    /// Is what was taken hidden, as its vertices have it? It need not be right.
    fn seems_hidden(&self, window: PixelRect, occluders: &Occluders) -> bool {
        let Scratch { taken, given, .. } = &self.scratch;
        if !taken.whole {
            return false;
        }
        let source = self.depth_test.source;
        let depths = given.iter().map(|position| {
            // A power of two more or less is one of 1/w alone.
            nearest_f32(right_depth(*position, source, self.viewport))
        });
        let Some(nearest) = depths.reduce(|a, b| self.nearer(a, b)) else { return false };
        let area = Area::new(taken.seen.intersect(window), self.origin);
        area.is_none_or(|area| area.is_behind(occluders, nearest))
    }

    /// The nearest depth of a vertex of `polygon`.
    pub(crate) fn nearest_depth<V: Polygon + ?Sized>(&self, polygon: &V) -> f32 {
        let nearest = Occluders::nearest(self.depth_test.compare);
        let depths = (0..polygon.len()).map(|i| {
            let position = polygon.position(i);
            let depth = right_depth(position, self.depth_test.source, self.viewport);
            if position[3] > 0.0 { nearest_f32(depth) } else { nearest }
        });
        depths.reduce(|a, b| self.nearer(a, b)).unwrap_or(nearest)
    }

    fn nearer(&self, a: f32, b: f32) -> f32 {
        if self.depth_test.compare.raises() == (b > a) { b } else { a }
    }

    /// Are tiles that are filled known to hide something, if they are looked for?
    pub(crate) fn finds_occluders(&self) -> bool {
        self.hides && Occluders::serve(self.depth_test) && subnormal::are_kept()
    }
}
