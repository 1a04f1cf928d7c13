//! 16 lanes at a time, for the rungs' loops.
//!
//! The library's own vectors are private to it. As there: no closures and no `map`, for what is
//! not inlined is not compiled for the instruction set.

use std::ops::{Add, Div, Mul};

use fearless_simd::{Simd, SimdBase, SimdNarrow, f32x16, f64x8};
use hyperspan::shade::BLOCK;

use crate::bench::scenes::MOST_ATTRIBUTES;

/// 0, 1, ... 15.
pub(crate) const COUNT: [f64; BLOCK] =
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

/// The same in `f32`.
pub(crate) const COUNT_F32: [f32; BLOCK] =
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

/// 16 lanes of each attribute, each on a line of the cache, as the product's are.
#[derive(Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct LaneArrays(pub(crate) [[f32; BLOCK]; MOST_ATTRIBUTES]);

/// 16 lanes of `f64`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wide<S: Simd>(f64x8<S>, f64x8<S>);

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

    /// Each lane, but no more than `most`.
    #[inline(always)]
    pub(crate) fn at_most(self, simd: S, most: f64) -> Self {
        let most = f64x8::splat(simd, most);
        Self(self.0.min(most), self.1.min(most))
    }

    /// Rounded once to `f32`.
    #[inline(always)]
    pub(crate) fn narrow(self) -> f32x16<S> {
        self.0.narrow(self.1)
    }
}

impl<S: Simd> Add for Wide<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0, self.1 + other.1)
    }
}

impl<S: Simd> Mul for Wide<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0, self.1 * other.1)
    }
}

impl<S: Simd> Div for Wide<S> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0, self.1 / other.1)
    }
}

/// `value` within a range.
#[inline(always)]
pub(crate) fn clamp<S: Simd>(simd: S, value: f32x16<S>, [low, high]: [f32; 2]) -> f32x16<S> {
    value.max(f32x16::splat(simd, low)).min(f32x16::splat(simd, high))
}
