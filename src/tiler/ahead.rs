//! What polygons that come next may cover is asked for before it is needed, where they lie so far from each
//! other that it is in no cache.

use fearless_simd::Simd;

use super::Tiler;
use super::bunch::{BUNCH, Bunch, FAR};
use super::sort::placed_for;
use crate::in_view::Sight;
use crate::polygon::Polygon;
use crate::shade::BLOCK;
use crate::space::PixelRect;
use crate::target::{DepthBuffer, Target};

/// Where one small polygon in so many lies far from the one before, it is worth it: in a mesh one does where it
/// begins a new strip.
const FEW: usize = 4;

/// So many polygons before it is drawn what is small is asked for: more than memory has time for are no use.
pub(crate) const AHEAD: usize = 8;

/// After so many that are not worth it, only one of so many is looked at.
const PATIENCE: usize = 8;

/// So many runs of 16 pixels are asked for at most: what is larger takes longer than its memory does.
const MOST_RUNS: u32 = 128;

impl Tiler {
    /// Do the small polygons that have been looked at lie far from each other?
    #[inline(always)]
    pub(crate) fn are_far_apart(&self) -> bool {
        self.bunch.far * FEW > self.bunch.count
    }

    /// Asks for the memory of what polygon `k`, which has been looked at, may cover, if it is small.
    #[inline(always)]
    pub(crate) fn fetch_small<T: Target>(
        &self,
        k: usize,
        window: PixelRect,
        target: &T,
        depth: Option<&DepthBuffer<'_>>,
    ) {
        let Bunch { sights, found, count, .. } = &self.bunch;
        if k < *count && matches!(sights[k % BUNCH], Sight::Pixels | Sight::PixelsOfQuad) {
            self.fetch(found[k % BUNCH].bounds.intersect(window), target, depth);
        }
    }

    /// Is it worth a look where polygon `k` lies, which is none of the small ones?
    #[inline(always)]
    pub(crate) fn may_be_far(&self, k: usize) -> bool {
        let Bunch { sights, count, patience, .. } = &self.bunch;
        k < *count
            && sights[k % BUNCH] == Sight::Elsewhere
            && (*patience > 0 || k.is_multiple_of(PATIENCE))
    }

    /// Asks for the memory of what `polygon`, which is not small and comes next, may cover, if it is of few
    /// pixels and far from the one before it.
    #[inline(always)]
    pub(crate) fn fetch_next<L: Simd, V: Polygon + ?Sized, T: Target>(
        &mut self,
        simd: L,
        polygon: &V,
        window: PixelRect,
        target: &T,
        depth: Option<&DepthBuffer<'_>>,
    ) {
        // To find out where others lie takes longer.
        if placed_for(self.viewport, polygon).is_none() {
            return;
        }
        self.bunch.patience = self.bunch.patience.saturating_sub(1);
        let Some(bounds) = self.bounds_in_view(simd, polygon) else { return };
        let far = bounds.y0.abs_diff(self.bunch.last_row) > FAR;
        self.bunch.last_row = bounds.y0;
        let runs = bounds.x1.abs_diff(bounds.x0) / BLOCK as u32 + 1;
        if far && bounds.y1.abs_diff(bounds.y0).saturating_mul(runs) <= MOST_RUNS {
            self.bunch.patience = PATIENCE;
            self.fetch(bounds.intersect(window), target, depth);
        }
    }

    /// Asks for the memory of the pixels of `bounds`.
    #[inline(always)]
    fn fetch<T: Target>(&self, bounds: PixelRect, target: &T, depth: Option<&DepthBuffer<'_>>) {
        if bounds.is_empty() {
            return;
        }
        let [origin_x, origin_y] = self.origin;
        let [first, last] =
            [bounds.x0, bounds.x1 - 1].map(|x| x.wrapping_sub(origin_x).cast_unsigned());
        for y in bounds.y0..bounds.y1 {
            let y = y.wrapping_sub(origin_y).cast_unsigned();
            let mut x = first;
            loop {
                if let Some(depth) = depth {
                    depth.fetch_pixel(x, y);
                }
                target.fetch(x, y);
                if x >= last {
                    break;
                }
                x = last.min(x.saturating_add(BLOCK as u32));
            }
        }
    }
}
