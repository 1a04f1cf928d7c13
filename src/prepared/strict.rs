//! Strict attributes by their quick test: see [`doubt`](crate::doubt).

use fearless_simd::{Simd, SimdBase, SimdMask, f64x4, mask32x16};

use super::{Divided, FUNCTIONS, Prepared};
use crate::along::{AHEAD, MIDDLE, middles_from};
use crate::doubt::{Doubt, LARGEST_Q};
use crate::gradient::{Gradients, Strict};
use crate::lanes::{Narrow, Wide, WideMask, bits_of};
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
        // The least Q of each block, where it is 1/w times something positive.
        let q = self.on_row(0).at_all(simd, middles_from(simd, middle));
        let least = q - f64x4::splat(simd, MIDDLE * self.steps[0].abs());
        let good = least.simd_ge(f64x4::splat(simd, self.least_q))
            & q.simd_lt(f64x4::splat(simd, LARGEST_Q));
        let mut greatest_r = [0.0; AHEAD];
        (f64x4::splat(simd, 1.0) / least).store_array(&mut greatest_r);
        for ((block, mask), lanes) in masks.iter().enumerate().zip(lanes.chunks_exact_mut(count)) {
            if *mask == 0 {
                continue;
            }
            let middle = middle + (block * BLOCK) as f64;
            let r = if self.divided == Divided::ByLane {
                self.on_row(0).wide(simd, middle).quick_reciprocal(simd)
            } else {
                Wide::splat(simd, self.r)
            };
            let mut near_tie = WideMask::none(simd);
            let mut large = mask32x16::splat(simd, true);
            for (i, lanes) in (1..FUNCTIONS).zip(lanes).take(count) {
                let d = self.on_row(i).wide(simd, middle);
                let value = d * r + Wide::splat(simd, self.bases[i]);
                near_tie = near_tie | value.near_tie(simd);
                let rounded = value.narrow();
                let least = self.doubts[i].least(greatest_r[block % AHEAD]);
                large &= rounded.abs().simd_ge(Narrow::splat(simd, least));
                rounded.max(self.low[i]).min(self.high[i]).store_array(lanes);
            }
            undecided[block % AHEAD] = near_tie.bits() | !bits_of(simd, large);
        }
        good.to_bitmask().trailing_ones() as usize
    }
}
