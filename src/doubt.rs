//! What leaves a value in doubt: the bounds behind the quick test of `Exact`.
//!
//! A value in `f64` that is off by fewer than 2^[`NEAR`] units in its last place, and farther than
//! that from the middle between two `f32`, is rounded right. The units are those of the value, and
//! part of the error is not: so what is small beside that part is in doubt too.
//! docs/precision.md, "The X loop, `Exact`", derives the bounds.

use fearless_simd::{Simd, SimdBase, f64x4};

use crate::gradient::frame::U;
use crate::gradient::{Gradients, QUICK_QUOTIENT_ERROR, QUOTIENT_ROOM, Strict};
use crate::lanes::NEAR;

/// One over the error that is allowed, by the value's magnitude; half for what goes by the value.
const ALLOWED: f64 = (1_u64 << (f64::MANTISSA_DIGITS + 1 - NEAR)) as f64;

/// Two products and two sums, relatively.
const PRODUCT_ERROR: f64 = 10.0 * U;

/// A lane is found from its block's middle, which may lie 8 columns beyond any covered pixel: three
/// roundings of what these are worth, and two of what the lane is off, by what a column changes.
const BLOCK_ERROR: f64 = 40.0 * U;

/// Below this, a value might round to a subnormal.
const SMALLEST: f64 = 1e-36;

/// Room for what rounds where a value is compared with the least that is not in doubt.
const ROOM: f64 = 1.0 + 1.0 / 1_048_576.0;

/// The least Q, with which 1/Q is well within the range of `f32`.
const SMALLEST_Q: f64 = 1.0 / 1_048_576.0;

/// Above the Q of which that is true.
pub(crate) const LARGEST_Q: f64 = 1e30;

/// What is doubtful of a strict quantity: values below `always` + `by_r` times the greatest 1/Q.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Doubt {
    always: f64,
    by_r: f64,
}

impl Doubt {
    /// Of base + D/Q, both times the unit.
    #[inline(always)]
    pub(crate) fn of_quotient(strict: &Strict, gradients: &Gradients) -> Self {
        let (base, unit) = (strict.base.abs(), gradients.unit.abs());
        let by_r =
            strict.error + BLOCK_ERROR * strict.numerator.x.abs() + q_error(gradients) * base;
        Self {
            always: ALLOWED * QUICK_QUOTIENT_ERROR * base + SMALLEST,
            by_r: ALLOWED * QUOTIENT_ROOM * by_r * unit,
        }
    }

    /// Of base + D scale, if the error that goes by the value is small enough.
    #[inline(always)]
    pub(crate) fn of_scaled(strict: &Strict, det_relative_error: f64) -> Option<Self> {
        let relative = det_relative_error + PRODUCT_ERROR;
        let error = strict.error + BLOCK_ERROR * (strict.numerator.x * strict.scale).abs();
        let always = ALLOWED * QUOTIENT_ROOM * (error + relative * strict.base.abs());
        (ALLOWED * relative <= 1.0 && always < f64::INFINITY)
            .then_some(Self { always: always + SMALLEST, by_r: 0.0 })
    }

    /// The least Q, times the unit, for which the error that goes by the value is small enough;
    /// nothing if there is none.
    #[inline(always)]
    pub(crate) fn least_q(gradients: &Gradients) -> Option<f64> {
        let least = 2.0 * ALLOWED * q_error(gradients) * gradients.unit.abs();
        let known = gradients.q_sign != 0.0 && least < f64::INFINITY;
        known.then_some(if least > SMALLEST_Q { least } else { SMALLEST_Q })
    }

    /// The least magnitude that is not in doubt, of what does not go by 1/Q.
    #[inline(always)]
    pub(crate) fn least_of_scaled(&self) -> f64 {
        self.always * ROOM
    }

    /// The same in a block with this greatest 1/Q; what is not a number says that all are in doubt.
    #[inline(always)]
    pub(crate) fn least_of_one(&self, greatest_r: f64) -> f64 {
        self.always * ROOM + self.by_r * ROOM * greatest_r
    }

    /// The same in some blocks with these greatest 1/Q.
    #[inline(always)]
    pub(crate) fn least<S: Simd>(&self, simd: S, greatest_r: f64x4<S>) -> f64x4<S> {
        f64x4::splat(simd, self.always * ROOM) + f64x4::splat(simd, self.by_r * ROOM) * greatest_r
    }
}

/// What Q is off by, in a lane of a block.
#[inline(always)]
fn q_error(gradients: &Gradients) -> f64 {
    gradients.q_error + BLOCK_ERROR * gradients.q.x.abs()
}
