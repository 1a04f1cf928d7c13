//! Linear functions along a row, a block of 16 pixels at a time.
//!
//! In the middle of a block, at lane 8, a function is found in `f64`. By how much the other lanes
//! differ is the same in every block; where that is small beside the value, `f32` holds it well
//! enough, and a lane costs two sums. Where it is not, each lane is found in `f64`.
//! docs/precision.md, "By blocks", derives which is which.
//!
//! Which way a pixel goes depends on the polygon and the pixel's block of the framebuffer alone.

use fearless_simd::{Simd, SimdBase, SimdNarrow, SimdWiden, f64x4};

use crate::gradient::frame::Linear;
use crate::gradient::{Plain, contains_zero, nearest_f32};
use crate::lanes::{Narrow, Wide};

/// The lane in the middle: no lane is farther from it.
pub(crate) const MIDDLE: f64 = 8.0;

/// What each lane is off the middle.
const OFF_MIDDLE: [f64; 16] =
    [-8.0, -7.0, -6.0, -5.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// A linear function on a row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OnRow {
    /// At the anchor's column.
    pub(crate) start: f64,
    pub(crate) step: f64,
}

impl OnRow {
    /// `v`: the row's offset from the anchor.
    #[inline(always)]
    pub(crate) fn of(function: &Linear, v: f64) -> Self {
        Self { start: function.row(v), step: function.x }
    }

    #[inline(always)]
    pub(crate) fn times(self, factor: f64) -> Self {
        Self { start: self.start * factor, step: self.step * factor }
    }

    /// At several columns.
    #[inline(always)]
    pub(crate) fn at_all<S: Simd>(self, simd: S, us: f64x4<S>) -> f64x4<S> {
        f64x4::splat(simd, self.start) + f64x4::splat(simd, self.step) * us
    }

    /// `u`: the column's offset from the anchor.
    #[inline(always)]
    pub(crate) fn at(self, u: f64) -> f64 {
        self.start + self.step * u
    }

    /// At the 16 columns around `middle`, each rounded once from `f64` unless the lanes are `near`
    /// each other.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(self, simd: S, middle: f64, near: bool) -> Narrow<S> {
        if near {
            return self.near(simd, middle, off_middle(simd, self.step));
        }
        self.wide(simd, middle).narrow()
    }

    /// At the 16 columns around `middle`, which are near each other.
    #[inline(always)]
    pub(crate) fn near<S: Simd>(self, simd: S, middle: f64, off_middle: Narrow<S>) -> Narrow<S> {
        let value = self.at(middle);
        let nearest = nearest_f32(value);
        let rest = nearest_f32(value - f64::from(nearest));
        Narrow::splat(simd, nearest) + (Narrow::splat(simd, rest) + off_middle)
    }

    /// The same in `f64`.
    #[inline(always)]
    pub(crate) fn wide<S: Simd>(self, simd: S, middle: f64) -> Wide<S> {
        let us = Wide::count_from(simd, middle - MIDDLE);
        Wide::splat(simd, self.start) + Wide::splat(simd, self.step) * us
    }
}

/// What a function that changes by `step` differs from its middle at each lane.
#[inline(always)]
pub(crate) fn steps_off_middle<S: Simd>(simd: S, step: f64) -> Wide<S> {
    Wide::load(simd, &OFF_MIDDLE) * Wide::splat(simd, step)
}

/// What each lane is off the middle's value, rounded.
#[inline(always)]
pub(crate) fn off_middle<S: Simd>(simd: S, step: f64) -> Narrow<S> {
    steps_off_middle(simd, step).narrow()
}

/// So many blocks are begun together: their latencies overlap.
pub(crate) const AHEAD: usize = 4;

/// How far their middles are from the first one's.
const BLOCKS: [f64; AHEAD] = [0.0, 16.0, 32.0, 48.0];

/// From a block's middle to its last lane.
pub(crate) const LAST: f64 = MIDDLE - 1.0;

/// The middles of the block around `middle` and the next ones.
#[inline(always)]
pub(crate) fn middles_from<S: Simd>(simd: S, middle: f64) -> f64x4<S> {
    f64x4::splat(simd, middle) + f64x4::from_slice(simd, &BLOCKS)
}

/// Values in the middles of blocks: the nearest `f32`, and what that is off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Middles {
    nearest: [f32; 2 * AHEAD],
    rest: [f32; 2 * AHEAD],
}

impl Middles {
    #[inline(always)]
    pub(crate) fn none() -> Self {
        Self { nearest: [0.0; 2 * AHEAD], rest: [0.0; 2 * AHEAD] }
    }

    #[inline(always)]
    pub(crate) fn of<S: Simd>(values: f64x4<S>) -> Self {
        let nearest = values.narrow(values);
        let rest = values - nearest.widen().0;
        let mut middles = Self::none();
        nearest.store_array(&mut middles.nearest);
        rest.narrow(rest).store_array(&mut middles.rest);
        middles
    }

    /// The same of twice as many.
    #[inline(always)]
    pub(crate) fn of_two<S: Simd>(low: f64x4<S>, high: f64x4<S>) -> Self {
        let nearest = low.narrow(high);
        let (low_nearest, high_nearest) = nearest.widen();
        let rest = (low - low_nearest).narrow(high - high_nearest);
        let mut middles = Self::none();
        nearest.store_array(&mut middles.nearest);
        rest.store_array(&mut middles.rest);
        middles
    }

    /// Value `i` in all lanes.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, simd: S, i: usize, off_middle: Narrow<S>) -> Narrow<S> {
        let i = i % (2 * AHEAD);
        Narrow::splat(simd, self.nearest[i]) + (Narrow::splat(simd, self.rest[i]) + off_middle)
    }
}

/// The least Q in a block's middle for which its lanes are near each other.
#[inline(always)]
pub(crate) fn least_for_q(q_step: f64) -> f64 {
    40.0 * q_step.abs()
}

/// The same for an attribute's N.
#[inline(always)]
pub(crate) fn least_for_numerator(plain: &Plain, q_step: f64) -> f64 {
    16.0 * plain.numerator.x.abs() / magnitude(plain) + MIDDLE * q_step.abs()
}

/// The same for an attribute that is divided once for each row, whose Q does not change.
#[inline(always)]
pub(crate) fn least_for_row(plain: &Plain) -> f64 {
    64.0 * plain.numerator.x.abs() / magnitude(plain)
}

/// Is an attribute that is not over w near enough everywhere?
#[inline(always)]
pub(crate) fn always_near(plain: &Plain) -> bool {
    64.0 * plain.numerator.x.abs() <= magnitude(plain)
}

/// The magnitude of an attribute's N in a block's middle up to which some of the block's lanes may be so
/// small, being `step` from each other, that `f32` would be too coarse for them, and each is found in
/// `f64`; [`NEVER_NEAR_ZERO`] if the attribute keeps away from 0.
#[inline(always)]
pub(crate) fn near_zero_up_to(plain: &Plain, step: f64) -> f64 {
    if contains_zero(plain.range) { near_zero_of(step) } else { NEVER_NEAR_ZERO }
}

/// The same of one that comes to 0.
#[inline(always)]
pub(crate) fn near_zero_of(step: f64) -> f64 {
    let steps = 2.0 * MIDDLE * step.abs();
    if steps > LEAST_NUMERATOR { steps } else { LEAST_NUMERATOR }
}

/// 2^-60: divided by any Q, what is larger keeps its sign.
const LEAST_NUMERATOR: f64 = 1.0 / 1_152_921_504_606_846_976.0;

/// No magnitude is so small.
pub(crate) const NEVER_NEAR_ZERO: f64 = -1.0;

/// The least magnitude of depth in a block's middle, for which its lanes are near each
/// other and none is in doubt.
#[inline(always)]
pub(crate) fn least_for_depth(plain: &Plain) -> f64 {
    let step = plain.numerator.x.abs();
    let (doubtful, steep) = (2.0 * plain.doubtful_below, 64.0 * step);
    (if doubtful > steep { doubtful } else { steep }) + MIDDLE * step
}

/// An attribute's largest magnitude at the vertices.
#[inline(always)]
fn magnitude(plain: &Plain) -> f64 {
    let [low, high] = plain.range;
    f64::from(if -low > high { -low } else { high })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Simd as Level;

    /// By blocks, a lane is off by no more than the last sum, and 16 steps' worth of roundings.
    #[test]
    fn lanes_around_a_middle_are_within_the_bound() {
        let u = f64::from(f32::EPSILON) / 2.0;
        for (_, level) in Level::all() {
            fearless_simd::dispatch!(level.0, simd => for i in 0..500 {
                let step = f64::from(i) * 0.000_73 - 0.18;
                let on_row = OnRow { start: 1.0 + f64::from(i) / 7.0, step };
                let mut lanes = [0.0; 16];
                on_row.lanes(simd, 24.0, true).store_array(&mut lanes);
                for (lane, column) in lanes.iter().zip(16_u8..) {
                    let right = on_row.at(f64::from(column));
                    let bound = 1.001 * u * (right.abs() + 16.0 * step.abs());
                    assert!((f64::from(*lane) - right).abs() <= bound, "{right}");
                }
            });
        }
    }
}
