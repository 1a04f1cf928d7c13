//! Numbers, one or eight in lanes: what the set-up of small polygons is written in.
//!
//! Written once, it serves a triangle that comes alone and eight that come together, with the same
//! bits: only IEEE `+ - * /`, comparisons and choices.

use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

use fearless_simd::{ExtractToken, Select, Simd, SimdBase, SimdFloat, SimdMask, f64x8, u64x8};

use crate::fixed::{exponent_of, power_of_two};

/// Lanes, at most.
pub(crate) const EIGHT: usize = 8;

/// Where numbers are kept, lane by lane.
pub(crate) type Lanes = [f64; EIGHT];

/// A `f64`, or eight of them.
pub(crate) trait Number:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// What is needed to make one.
    type Level: Copy;
    /// Truth, lane by lane.
    type Truth: Copy + Debug + BitAnd<Output = Self::Truth> + BitOr<Output = Self::Truth>;

    /// The first lanes of an array.
    fn load(level: Self::Level, lanes: &Lanes) -> Self;

    /// Into the first lanes of an array.
    fn store(self, lanes: &mut Lanes);

    /// `value` in every lane.
    fn like(self, value: f64) -> Self;

    /// |self|
    fn abs(self) -> Self;

    /// 1 / self
    fn reciprocal(self) -> Self;

    /// 2^-e of 2^e <= |self| < 2^(e + 1), with the sign of `sign`; self is normal, else anything.
    fn inverse_power(self, sign: Self) -> Self;

    fn lt(self, other: Self) -> Self::Truth;

    fn le(self, other: Self) -> Self::Truth;

    fn eq(self, other: Self) -> Self::Truth;

    /// Are all bits the same? That tells one zero from the other.
    fn same_bits(self, other: Self) -> Self::Truth;

    fn select(truth: Self::Truth, yes: Self, no: Self) -> Self;

    /// A bit for each lane.
    fn bits(truth: Self::Truth) -> u8;

    /// The lesser, of numbers.
    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        Self::select(other.lt(self), other, self)
    }

    /// The greater, of numbers.
    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        Self::select(self.lt(other), other, self)
    }

    /// 0 where `truth` holds.
    #[inline(always)]
    fn zero_if(self, truth: Self::Truth) -> Self {
        Self::select(truth, self.like(0.0), self)
    }
}

/// Least and greatest of some numbers.
#[inline(always)]
#[expect(clippy::needless_range_loop, reason = "loops over arrays are unrolled, iterators are not")]
pub(crate) fn range_of<F: Number, const N: usize>(numbers: &[F; N]) -> [F; 2] {
    let (mut low, mut high) = (numbers[0], numbers[0]);
    for i in 1..N {
        (low, high) = (low.lesser(numbers[i]), high.greater(numbers[i]));
    }
    [low, high]
}

impl Number for f64 {
    type Level = ();
    type Truth = bool;

    #[inline(always)]
    fn load((): (), lanes: &Lanes) -> Self {
        lanes[0]
    }

    #[inline(always)]
    fn store(self, lanes: &mut Lanes) {
        lanes[0] = self;
    }

    #[inline(always)]
    fn like(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        1.0 / self
    }

    #[inline(always)]
    fn inverse_power(self, sign: Self) -> Self {
        power_of_two(-exponent_of(self).unwrap_or(0)).copysign(sign)
    }

    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn same_bits(self, other: Self) -> bool {
        self.to_bits() == other.to_bits()
    }

    #[inline(always)]
    fn select(truth: bool, yes: Self, no: Self) -> Self {
        if truth { yes } else { no }
    }

    #[inline(always)]
    fn bits(truth: bool) -> u8 {
        truth.into()
    }
}

impl<S: Simd> Number for f64x8<S> {
    type Level = S;
    type Truth = fearless_simd::mask64x8<S>;

    #[inline(always)]
    fn load(simd: S, lanes: &Lanes) -> Self {
        Self::load_array_ref(simd, lanes)
    }

    #[inline(always)]
    fn store(self, lanes: &mut Lanes) {
        self.store_array(lanes);
    }

    #[inline(always)]
    fn like(self, value: f64) -> Self {
        Self::splat(self.token(), value)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        SimdBase::abs(self)
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        self.like(1.0) / self
    }

    #[inline(always)]
    fn inverse_power(self, sign: Self) -> Self {
        const EXPONENT: u64 = 0x7FF << 52;
        // Twice the exponent of 1, less this one's.
        const TWICE: u64 = 2046 << 52;
        let simd = self.token();
        let exponent = self.to_bits() & u64x8::splat(simd, EXPONENT);
        let power = u64x8::splat(simd, TWICE) - exponent;
        let sign = sign.to_bits() & u64x8::splat(simd, 1 << 63);
        Self::from_bits(power | sign)
    }

    #[inline(always)]
    fn lt(self, other: Self) -> Self::Truth {
        self.simd_lt(other)
    }

    #[inline(always)]
    fn le(self, other: Self) -> Self::Truth {
        self.simd_le(other)
    }

    #[inline(always)]
    fn eq(self, other: Self) -> Self::Truth {
        self.simd_eq(other)
    }

    #[inline(always)]
    fn same_bits(self, other: Self) -> Self::Truth {
        self.to_bits().simd_eq(other.to_bits())
    }

    #[inline(always)]
    fn select(truth: Self::Truth, yes: Self, no: Self) -> Self {
        truth.select(yes, no)
    }

    #[expect(clippy::cast_possible_truncation, reason = "eight lanes")]
    #[inline(always)]
    fn bits(truth: Self::Truth) -> u8 {
        truth.to_bitmask() as u8
    }
}
