//! Rationals, and their correct rounding to `f32`.

use dashu_int::ops::{BitTest, DivRem};
use dashu_int::{IBig, UBig};
use dashu_ratio::Relaxed;

/// An exact number: a fraction that may have common factors, since to look for them at every step takes longer than
/// what they cost. See [`reduced`].
pub(crate) type Q = Relaxed;

/// A finite float, exactly.
pub(crate) fn q(value: f64) -> Q {
    Q::try_from(value).expect("a finite float")
}

/// `numerator / denominator`, exactly.
pub(crate) fn fraction(numerator: i64, denominator: i64) -> Q {
    Q::from_parts_signed(IBig::from(numerator), IBig::from(denominator))
}

/// The same number without common factors: for what goes on from one to the next, and would grow.
pub(crate) fn reduced(value: Q) -> Q {
    value.canonicalize().relax()
}

/// The sum of some exact numbers.
pub(crate) fn sum(terms: impl IntoIterator<Item = Q>) -> Q {
    terms.into_iter().fold(Q::ZERO, |a, b| a + b)
}

/// 2^`exponent`, exactly.
pub(crate) fn power_of_two(exponent: i32) -> Q {
    let power = Q::from(IBig::from(1) << exponent.unsigned_abs() as usize);
    if exponent < 0 { Q::ONE / power } else { power }
}

/// `value` as the `f64` nearest to it: good enough to look at, or to compare with a tolerance.
pub(crate) fn approximate(value: &Q) -> f64 {
    value.to_f64().value()
}

/// The `f32` nearest to `value`, ties to the one with an even last bit; infinity where IEEE 754
/// has it. What underflows keeps its sign; an exact 0 is +0.
pub(crate) fn round_to_f32(value: &Q) -> f32 {
    let sign = if *value < Q::ZERO { 1_u32 << 31 } else { 0 };
    if *value == Q::ZERO {
        return 0.0;
    }
    let (numerator, denominator) = value.clone().into_parts();
    let numerator = numerator.into_parts().1;
    f32::from_bits(sign | round_magnitude(&numerator, &denominator))
}

/// The bits of the `f32` nearest to `numerator / denominator`.
fn round_magnitude(numerator: &UBig, denominator: &UBig) -> u32 {
    // m 2^e with 2^23 <= m < 2^24 where e > -149; with m < 2^24 where e = -149 (subnormals).
    let length = |n: &UBig| i64::try_from(n.bit_len()).expect("a length");
    let guess = length(numerator) - length(denominator) - 25;
    let mut exponent = guess.max(-149);
    loop {
        let (mut n, mut d) = (numerator.clone(), denominator.clone());
        if exponent < 0 {
            n <<= exponent.unsigned_abs() as usize;
        } else {
            d <<= exponent.unsigned_abs() as usize;
        }
        let (m, rest) = n.div_rem(&d);
        if m >= UBig::from(1_u32 << 24) {
            exponent += 1;
            continue;
        }
        if exponent > 104 {
            return f32::INFINITY.to_bits();
        }
        let mut m = u32::try_from(m).expect("below 2^24");
        let twice = rest * UBig::from(2_u8);
        if twice > d || (twice == d && m % 2 == 1) {
            m += 1;
        }
        // A carry from the 24 bits goes on into the exponent, and from there into infinity.
        let biased = u32::try_from(exponent + 149).expect("at least 0");
        return (biased << 23) + m;
    }
}
