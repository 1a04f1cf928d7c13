//! Four blocks that are begun together, in rows of long spans.

use fearless_simd::{Simd, SimdBase, SimdMask, f64x4, mask64x4};

use super::{Divided, FUNCTIONS, LAST_OF_ALL, Prepared};
use crate::along::{AHEAD, MIDDLE, Middles, middles_from};
use crate::lanes::{Narrow, clamp_numbers};
use crate::shade::BLOCK;

impl<S: Simd> Prepared<S> {
    /// The values of `count` attributes in the block around `middle` and the next ones: those of
    /// which any lane is set in `masks`. Returns how many are good. `lanes`: `count` for each.
    /// `undecided`: for each block a bit for each attribute whose values have yet to be found.
    #[inline(always)]
    pub(crate) fn find_some(
        &self,
        simd: S,
        count: usize,
        middle: f64,
        masks: &[u16],
        lanes: &mut [[f32; BLOCK]],
        undecided: &mut [u16; AHEAD],
    ) -> usize {
        if self.filled {
            return AHEAD;
        }
        if self.strict {
            return self.find_strict(simd, count, middle, masks, lanes, undecided);
        }
        let middles = middles_from(simd, middle);
        let values = |i: usize| self.on_row(i).at_all(simd, middles);
        let q = values(0);
        let good = q.simd_ge(f64x4::splat(simd, self.least_q));
        let mut ahead = [Middles::none(); FUNCTIONS];
        ahead[0] = Middles::of(q);
        for (i, ahead) in ahead.iter_mut().enumerate().skip(1).take(count) {
            *ahead = Middles::of(values(i));
        }
        let unclamped = self.unclamped.contain(middle - MIDDLE, middle + LAST_OF_ALL);
        match (unclamped, self.divided) {
            (true, Divided::ByLane) => {
                self.find_lanes::<true, false>(simd, count, &ahead, masks, lanes);
            }
            (true, _) => self.find_lanes::<false, false>(simd, count, &ahead, masks, lanes),
            (false, _) => self.find_lanes::<true, true>(simd, count, &ahead, masks, lanes),
        }
        if self.meets_zero {
            let mut any = mask64x4::splat(simd, false);
            for i in 1..=count.min(FUNCTIONS - 1) {
                any |= self.are_near_zero(simd, i, middle);
            }
            if any.any_true() {
                self.find_near_zero(simd, count, middle, masks, lanes);
            }
        }
        good.to_bitmask().trailing_ones() as usize
    }

    /// The lanes of the blocks whose middles are `ahead`: divided, unless `DIVIDED` says that none is, and
    /// `CLAMPED`, unless there is nothing to clamp.
    #[inline(always)]
    fn find_lanes<const DIVIDED: bool, const CLAMPED: bool>(
        &self,
        simd: S,
        count: usize,
        ahead: &[Middles; FUNCTIONS],
        masks: &[u16],
        lanes: &mut [[f32; BLOCK]],
    ) {
        for ((block, mask), lanes) in masks.iter().enumerate().zip(lanes.chunks_exact_mut(count)) {
            if *mask == 0 {
                continue;
            }
            let at = |i: usize| ahead[i].lanes(simd, block, self.off_middle[i]);
            let one = Narrow::splat(simd, 1.0);
            let divides = DIVIDED && self.divided == Divided::ByLane;
            let r = if divides { one / at(0) } else { one };
            for (i, lanes) in (1..FUNCTIONS).zip(lanes).take(count) {
                let value = if DIVIDED { at(i) * r } else { at(i) };
                if CLAMPED {
                    clamp_numbers(value, self.low[i], self.high[i]).store_array(lanes);
                } else {
                    value.store_array(lanes);
                }
            }
        }
    }

    /// Finds those anew that do not go by their block because they are near 0.
    #[inline(never)]
    fn find_near_zero(
        &self,
        simd: S,
        count: usize,
        middle: f64,
        masks: &[u16],
        lanes: &mut [[f32; BLOCK]],
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                for i in 1..=count.min(FUNCTIONS - 1) {
                    let mut left = self.are_near_zero(simd, i, middle).to_bitmask();
                    while left != 0 {
                        let block = left.trailing_zeros() as usize;
                        left &= left - 1;
                        let Some(lanes) = lanes.get_mut(block * count + i - 1) else { break };
                        if masks.get(block).is_none_or(|mask| *mask == 0) {
                            continue;
                        }
                        let middle = middle + (block * BLOCK) as f64;
                        let mut r = Narrow::splat(simd, 1.0);
                        if self.divided == Divided::ByLane {
                            r /= self.on_row(0).near(simd, middle, self.off_middle[0]);
                        }
                        let value = self.on_row(i).wide(simd, middle).narrow() * r;
                        clamp_numbers(value, self.low[i], self.high[i]).store_array(lanes);
                    }
                }
            },
        );
    }

    /// See [`near_zero_up_to`]: is function `i` so small in the block around `middle` and the next ones?
    #[inline(always)]
    fn are_near_zero(&self, simd: S, i: usize, middle: f64) -> mask64x4<S> {
        let values = self.on_row(i).at_all(simd, middles_from(simd, middle));
        values.abs().simd_le(f64x4::splat(simd, self.near_zero[i]))
    }
}
