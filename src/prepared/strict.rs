//! Strict attributes by their quick test: see [`doubt`](crate::doubt).
#![expect(
    clippy::needless_range_loop,
    reason = "loops over arrays are unrolled, iterators are not"
)]

use fearless_simd::{Simd, SimdBase, SimdMask, f64x4};

use super::{Divided, FUNCTIONS, LAST_OF_ALL, Prepared};
use crate::along::{AHEAD, LAST, MIDDLE, middles_from, steps_off_middle};
use crate::doubt::{Doubt, LARGEST_Q};
use crate::gradient::{Gradients, Strict};
use crate::lanes::{Ties, Wide};
use crate::shade::BLOCK;

impl<S: Simd> Prepared<S> {
    #[inline(always)]
    pub(super) fn set_strict(
        &mut self,
        simd: S,
        i: usize,
        strict: &Strict,
        gradients: &Gradients,
    ) -> bool {
        let doubt = if strict.over_w {
            Some(Doubt::of_quotient(strict, gradients))
        } else {
            self.r = strict.scale;
            Doubt::of_scaled(strict, gradients.det_relative_error)
        };
        let Some(doubt) = doubt else { return false };
        let scale = if strict.over_w { gradients.unit } else { 1.0 };
        self.set_function(simd, i, strict.numerator.scaled(scale), strict.range);
        self.steps_off_middle[i] = steps_off_middle(simd, self.steps[i]);
        (self.bases[i], self.doubts[i]) = (strict.base, doubt);
        true
    }

    /// [`find_some`](Self::find_some) of strict attributes.
    #[inline(always)]
    pub(super) fn find_strict(
        &self,
        simd: S,
        count: usize,
        middle: f64,
        masks: &[u16],
        lanes: &mut [[f32; BLOCK]],
        undecided: &mut [u16; AHEAD],
    ) -> usize {
        let mut ahead = [[0.0; AHEAD]; FUNCTIONS];
        let good = self.look_ahead(simd, count, middle, &mut ahead, undecided);
        let is_clamped = !self.unclamped.contain(middle - MIDDLE, middle + LAST_OF_ALL);
        // All reciprocals first: each is a long chain of operations, and they do not wait for each other.
        let mut reciprocals = [Wide::splat(simd, self.r); AHEAD];
        if self.divided == Divided::ByLane {
            for (r, at_middle) in reciprocals.iter_mut().zip(&ahead[0]).take(masks.len()) {
                *r = self.strict_lanes(simd, 0, *at_middle).quick_reciprocal(simd);
            }
        }
        for ((block, mask), lanes) in masks.iter().enumerate().zip(lanes.chunks_exact_mut(count)) {
            if *mask == 0 {
                continue;
            }
            let block = block % AHEAD;
            let r = reciprocals[block];
            let mut ties = Ties::none(simd);
            for (i, lanes) in (1..FUNCTIONS).zip(lanes).take(count) {
                let value = self.strict_value(simd, i, ahead[i][block], r);
                ties = ties.and(simd, value);
                self.store_rounded(i, value, is_clamped, lanes);
            }
            if ties.any(simd) {
                let middle = middle + (block * BLOCK) as f64;
                undecided[block] |= self.near_ties(simd, count, middle, &reciprocals[block]);
            }
        }
        good
    }

    /// [`find_one`](Self::find_one) of strict attributes: what is found for four blocks is found for one here,
    /// and of that only the lanes from the first to the last of `mask` have to be decided.
    #[inline(always)]
    pub(super) fn find_one_strict(
        &self,
        simd: S,
        count: usize,
        middle: f64,
        mask: u16,
        lanes: &mut [[f32; BLOCK]],
    ) -> Option<u16> {
        let first_lane = f64::from(mask.trailing_zeros()) - MIDDLE;
        let last_lane = LAST - f64::from(mask.leading_zeros());
        let q = self.on_row(0).at(middle);
        let [first, last] = [q + first_lane * self.steps[0], q + last_lane * self.steps[0]];
        let (least, greatest) = if first < last { (first, last) } else { (last, first) };
        if !(least >= self.least_q && greatest < LARGEST_Q) {
            return None;
        }
        let mut r = Wide::splat(simd, self.r);
        let (mut r_first, mut r_last, mut greatest_r) = (self.r, self.r, self.r);
        if self.divided == Divided::ByLane {
            r = self.strict_lanes(simd, 0, q).quick_reciprocal(simd);
            (r_first, r_last, greatest_r) = (1.0 / first, 1.0 / last, 1.0 / least);
        }
        let (mut ties, mut undecided) = (Ties::none(simd), 0);
        for (i, lanes) in (1..FUNCTIONS).zip(lanes).take(count) {
            let (d, base) = (self.on_row(i).at(middle), self.bases[i]);
            let value = self.strict_value(simd, i, d, r);
            ties = ties.and(simd, value);
            self.store_rounded(i, value, true, lanes);
            // Between its ends a value is monotone.
            let first = (d + first_lane * self.steps[i]) * r_first + base;
            let last = (d + last_lane * self.steps[i]) * r_last + base;
            let least = self.doubts[i].least_of_one(greatest_r);
            let above = (first >= least) & (last >= least);
            let below = (first <= -least) & (last <= -least);
            undecided |= u16::from(!(above | below)) << (i - 1);
        }
        if ties.any(simd) {
            undecided |= self.near_ties(simd, count, middle, &r);
        }
        Some(undecided)
    }

    /// A bit for each attribute that has a value near a tie in the block around `middle`, where 1/Q is `r`: one
    /// block in some hundred has.
    #[cold]
    #[inline(never)]
    fn near_ties(&self, simd: S, count: usize, middle: f64, r: &Wide<S>) -> u16 {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut near = 0;
                for i in 1..=count.min(FUNCTIONS - 1) {
                    let value = self.strict_value(simd, i, self.on_row(i).at(middle), *r);
                    near |= u16::from(Ties::none(simd).and(simd, value).any(simd)) << (i - 1);
                }
                near
            },
        )
    }

    /// Finds Q and the numerators in the middles of the block around `middle` and the next ones. Returns how
    /// many, from the first on, have a Q that is good enough; in these, attributes are undecided of which
    /// a value is too small.
    #[inline(always)]
    fn look_ahead(
        &self,
        simd: S,
        count: usize,
        middle: f64,
        ahead: &mut [[f64; AHEAD]; FUNCTIONS],
        undecided: &mut [u16; AHEAD],
    ) -> usize {
        let middles = middles_from(simd, middle);
        let q = self.on_row(0).at_all(simd, middles);
        q.store_array(&mut ahead[0]);
        let (first, last) = self.ends_of(simd, 0, q);
        let good = first.min(last).simd_ge(f64x4::splat(simd, self.least_q))
            & first.max(last).simd_lt(f64x4::splat(simd, LARGEST_Q));
        // Where 1/w is the same along the row, or nothing is divided by it, both are `r`.
        let (mut r_first, mut r_last) = (f64x4::splat(simd, self.r), f64x4::splat(simd, self.r));
        if self.divided == Divided::ByLane {
            let one = f64x4::splat(simd, 1.0);
            (r_first, r_last) = (one / first, one / last);
        }
        let greatest_r = r_first.max(r_last);
        for i in 1..=count.min(FUNCTIONS - 1) {
            let d = self.on_row(i).at_all(simd, middles);
            d.store_array(&mut ahead[i]);
            // Between its ends a value is monotone.
            let (first, last) = self.ends_of(simd, i, d);
            let base = f64x4::splat(simd, self.bases[i]);
            let (first, last) = (first * r_first + base, last * r_last + base);
            let least = self.doubts[i].least(simd, greatest_r);
            let large = first.min(last).simd_ge(least) | first.max(last).simd_le(-least);
            if !large.all_true() {
                let large = large.to_bitmask();
                for block in 0..AHEAD {
                    undecided[block] |= u16::from(large >> block & 1 == 0) << (i - 1);
                }
            }
        }
        good.to_bitmask().trailing_ones() as usize
    }

    /// Function `i` around the middle where it is so much.
    #[inline(always)]
    fn strict_lanes(&self, simd: S, i: usize, at_middle: f64) -> Wide<S> {
        Wide::splat(simd, at_middle) + self.steps_off_middle[i]
    }

    /// Attribute `i` there, where 1/Q is `r`.
    #[inline(always)]
    fn strict_value(&self, simd: S, i: usize, at_middle: f64, r: Wide<S>) -> Wide<S> {
        self.strict_lanes(simd, i, at_middle) * r + Wide::splat(simd, self.bases[i])
    }

    /// Attribute `i`, rounded once.
    #[inline(always)]
    fn store_rounded(&self, i: usize, value: Wide<S>, is_clamped: bool, lanes: &mut [f32; BLOCK]) {
        let rounded = value.narrow();
        let rounded = if is_clamped { rounded.max(self.low[i]).min(self.high[i]) } else { rounded };
        rounded.store_array(lanes);
    }

    /// Function `i` at the first lanes and at the last ones of blocks in whose middles it is so much.
    #[inline(always)]
    fn ends_of(&self, simd: S, i: usize, at_middle: f64x4<S>) -> (f64x4<S>, f64x4<S>) {
        let [first, last] = [-MIDDLE * self.steps[i], LAST * self.steps[i]];
        (at_middle + f64x4::splat(simd, first), at_middle + f64x4::splat(simd, last))
    }
}
