//! 16 lanes at a time: the vectors that the X loop computes in.
//!
//! No closures and no `map` here: what is not inlined is not compiled for the instruction set.
//! Only IEEE `+ - * /`, comparisons and conversions that round once: a lane's bits are the same
//! on every instruction set.

use core::ops::{Add, Mul, Sub};

use fearless_simd::{
    Simd, SimdBase, SimdFloat, SimdMask, SimdNarrow, SimdWiden, f32x16, f64x8, mask32x16, u32x16,
};

use crate::shade::BLOCK;

/// 16 lanes of `f64`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wide<S: Simd>(f64x8<S>, f64x8<S>);

/// 16 lanes of `f32`.
pub(crate) type Narrow<S> = f32x16<S>;

/// Binary digits of how many units in its last place a value may be off: see [`Ties`].
pub(crate) const NEAR: u32 = 16;

/// 0, 1, ... 15.
const COUNT: [f64; BLOCK] =
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

impl<S: Simd> Wide<S> {
    /// `value` in every lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f64) -> Self {
        let half = f64x8::splat(simd, value);
        Self(half, half)
    }

    /// The lanes of an array.
    #[inline(always)]
    pub(crate) fn load(simd: S, lanes: &[f64; BLOCK]) -> Self {
        let (low, high) = lanes.split_at(BLOCK / 2);
        Self(f64x8::from_slice(simd, low), f64x8::from_slice(simd, high))
    }

    /// `first`, `first` + 1, ...
    #[inline(always)]
    pub(crate) fn count_from(simd: S, first: f64) -> Self {
        Self::load(simd, &COUNT) + Self::splat(simd, first)
    }

    /// Those of two halves.
    #[inline(always)]
    pub(crate) fn of_halves(low: f64x8<S>, high: f64x8<S>) -> Self {
        Self(low, high)
    }

    /// Its halves.
    #[inline(always)]
    pub(crate) fn halves(self) -> [f64x8<S>; 2] {
        [self.0, self.1]
    }

    /// The first half of the lanes, twice.
    #[inline(always)]
    pub(crate) fn first_half(self) -> Self {
        Self(self.0, self.0)
    }

    /// 1 / self.
    #[inline(always)]
    pub(crate) fn reciprocal(self, simd: S) -> Self {
        let one = f64x8::splat(simd, 1.0);
        Self(one / self.0, one / self.1)
    }

    /// |self|.
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }

    /// Rounded once to `f32`.
    #[inline(always)]
    pub(crate) fn narrow(self) -> Narrow<S> {
        self.0.narrow(self.1)
    }

    /// The same to 2^-45, of what is well within the range of `f32`: by a division in `f32` and a
    /// step of Newton's.
    #[inline(always)]
    pub(crate) fn quick_reciprocal(self, simd: S) -> Self {
        let one = Self::splat(simd, 1.0);
        let estimate = Narrow::splat(simd, 1.0) / self.narrow();
        let (low, high) = estimate.widen();
        let r = Self(low, high);
        r + r * (one - self * r)
    }

    /// Rounded to `f32` and clamped to the range (see [`clamp_lanes`]), and the lanes at which every
    /// number that is not farther than `error` becomes the same (Ziv's test).
    #[inline(always)]
    pub(crate) fn round_within(self, error: Self, range: [f32; 2]) -> (Narrow<S>, u16) {
        let low = clamp_lanes((self - error).narrow(), range);
        let high = clamp_lanes((self + error).narrow(), range);
        (low, same_bits(low, high))
    }

    /// The lanes at which self < other.
    #[inline(always)]
    pub(crate) fn below(self, other: Self) -> u16 {
        let low = self.0.simd_lt(other.0).to_bitmask();
        low_bits(low | self.1.simd_lt(other.1).to_bitmask() << (BLOCK / 2))
    }
}

/// A `f64` has so many bits more than a `f32`.
const MORE_BITS: u32 = f64::MANTISSA_DIGITS - f32::MANTISSA_DIGITS;

/// How near the nearest of some values lie to the middle between two `f32`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ties<S: Simd>(u32x16<S>);

impl<S: Simd> Ties<S> {
    /// The last bits of a `f64`, which a `f32` has no room for, are moved up so far that none stands before
    /// them: what is halfway is this.
    const HALF_WAY: u32 = 1 << (u32::BITS - 1);

    /// An error of 2^[`NEAR`] units in the last place, moved as far.
    const NEAR_TIE: u32 = 1 << (u32::BITS - MORE_BITS + NEAR);

    /// Of no values.
    #[inline(always)]
    pub(crate) fn none(simd: S) -> Self {
        Self(u32x16::splat(simd, u32::MAX))
    }

    /// Of these values, too.
    #[inline(always)]
    #[must_use]
    pub(crate) fn and(self, simd: S, value: Wide<S>) -> Self {
        let bits = value.0.to_bits().narrow(value.1.to_bits()) << (u32::BITS - MORE_BITS);
        // What is near is below twice the distance, with the middle in the middle.
        let from_tie = bits + u32x16::splat(simd, Self::NEAR_TIE.wrapping_sub(Self::HALF_WAY));
        Self(self.0.min(from_tie))
    }

    /// Is any so near that an error of 2^[`NEAR`] units in its last place may reach it?
    #[inline(always)]
    pub(crate) fn any(self, simd: S) -> bool {
        self.0.simd_lt(u32x16::splat(simd, 2 * Self::NEAR_TIE)).any_true()
    }
}

impl<S: Simd> Add for Wide<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0, self.1 + other.1)
    }
}

impl<S: Simd> Sub for Wide<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0, self.1 - other.1)
    }
}

impl<S: Simd> Mul for Wide<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0, self.1 * other.1)
    }
}

/// `value` within the range, whose lower end, if it is 0, is +0: what is below it becomes that,
/// and so does NaN.
#[inline(always)]
fn clamp_lanes<S: Simd>(value: Narrow<S>, [low, high]: [f32; 2]) -> Narrow<S> {
    use fearless_simd::Select as _;
    let simd = fearless_simd::ExtractToken::token(&value);
    let (low, high) = (f32x16::splat(simd, low), f32x16::splat(simd, high));
    let value = value.simd_gt(low).select(value, low);
    value.simd_gt(high).select(high, value)
}

/// `value`, which is a number where it matters, within the range; a zero is +0.
#[inline(always)]
pub(crate) fn clamp_numbers<S: Simd>(
    value: Narrow<S>,
    low: Narrow<S>,
    high: Narrow<S>,
) -> Narrow<S> {
    let simd = fearless_simd::ExtractToken::token(&value);
    // The instruction sets differ in which zero is the larger one: the sum makes them the same.
    value.max(low).min(high) + f32x16::splat(simd, 0.0)
}

/// The lanes whose bits are the same.
#[inline(always)]
fn same_bits<S: Simd>(a: Narrow<S>, b: Narrow<S>) -> u16 {
    let simd = fearless_simd::ExtractToken::token(&a);
    bits_of(simd, a.to_bits().simd_eq(b.to_bits()))
}

/// The lanes whose bits are set in `mask`.
#[inline(always)]
pub(crate) fn lanes_of<S: Simd>(simd: S, mask: u16) -> mask32x16<S> {
    mask32x16::from_bitmask(simd, mask.into())
}

/// A bit for each lane that is set.
#[inline(always)]
pub(crate) fn bits_of<S: Simd>(simd: S, lanes: mask32x16<S>) -> u16 {
    // Where a vector has fewer lanes, a half has an instruction for it, and all have none.
    if size_of::<S::f32s>() == size_of::<[f32; BLOCK]>() {
        return low_bits(lanes.to_bitmask());
    }
    let (low, high) = simd.split_mask32x16(lanes);
    low_bits(low.to_bitmask() | high.to_bitmask() << (BLOCK / 2))
}

/// A mask of 16 lanes.
#[expect(clippy::cast_possible_truncation, reason = "the mask has 16 lanes")]
#[inline(always)]
pub(crate) fn low_bits(mask: u64) -> u16 {
    mask as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Simd as Level;

    #[test]
    fn ties_are_seen_from_as_far_as_asked_for() {
        // Halfway between two `f32`, and so many units beside it.
        let tie = (1.5_f64 + f64::from(f32::EPSILON) / 2.0).to_bits();
        let far = 1_u64 << NEAR;
        let cases =
            [(0, true), (far - 1, true), (far + 1, false), (1 << 27, false), (1 << 28, false)];
        for (_, level) in Level::all() {
            fearless_simd::dispatch!(level.0, simd => for (units, near) in cases {
                for bits in [tie + units, tie - units] {
                    let value = f64::from_bits(bits);
                    for lane in 0..BLOCK {
                        // Others lie on a `f32`, and the first values do not hide the next.
                        let mut lanes = [1.5; BLOCK];
                        lanes[lane] = value;
                        let [usual, odd] = [[1.5; BLOCK], lanes].map(|l| Wide::load(simd, &l));
                        let ties = Ties::none(simd).and(simd, usual);
                        assert!(!ties.any(simd));
                        assert_eq!(ties.and(simd, odd).any(simd), near, "{units}");
                        let ties = Ties::none(simd).and(simd, odd).and(simd, usual);
                        assert_eq!(ties.any(simd), near, "{units}");
                    }
                }
            });
        }
    }

    #[test]
    fn quick_reciprocals_are_as_good_as_said() {
        for (_, level) in Level::all() {
            fearless_simd::dispatch!(level.0, simd => for i in 0..1000 {
                let q = 1.0 + f64::from(i) * 0.003_141_592_653;
                let r = Wide::splat(simd, q).quick_reciprocal(simd);
                let off = (r * Wide::splat(simd, q) - Wide::splat(simd, 1.0)).abs();
                assert_eq!(off.below(Wide::splat(simd, 1.25 / 70_368_744_177_664.0)), u16::MAX);
            });
        }
    }
}
