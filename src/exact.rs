//! Exact arithmetic on binary fractions: the last resort, where `f64` cannot tell.
//!
//! Sums, differences and products of `f64`s are binary fractions, so a set-up and a pixel's
//! numerator and denominator can be had without any error; what is left is to round their
//! quotient once. Slow (tens of nanoseconds an operation) and rarely run. It does not divide.

use alloc::vec::Vec;
use core::cmp::Ordering;

/// A whole number times 2^(64 `exponent`).
#[derive(Clone, Debug, Default)]
pub(crate) struct Dyadic {
    negative: bool,
    /// Least significant limb first; the last one is not 0. Empty for zero.
    limbs: Vec<u64>,
    /// In limbs of 64 bits.
    exponent: i32,
}

impl Dyadic {
    /// `value`, exactly; 0 for what is not finite.
    pub(crate) fn from_f64(value: f64) -> Self {
        let bits = value.to_bits();
        let biased = i32::try_from(bits >> 52 & 0x7FF).unwrap_or(0);
        let fraction = bits << 12 >> 12;
        let (whole, exponent) = match biased {
            0 => (fraction, -1074),
            0x7FF => (0, 0),
            _ => (fraction | 1 << 52, biased - 1075),
        };
        let shift = exponent.rem_euclid(64);
        let wide = u128::from(whole) << shift;
        #[expect(clippy::cast_possible_truncation, reason = "the two halves")]
        let limbs = Vec::from([wide as u64, (wide >> 64) as u64]);
        let mut value = Self { negative: value < 0.0, limbs, exponent: exponent.div_euclid(64) };
        value.trim();
        value
    }

    pub(crate) fn from_i32(value: i32) -> Self {
        Self::from_f64(f64::from(value))
    }

    /// -1, 0 or 1 as `Ordering` against 0.
    pub(crate) fn sign(&self) -> Ordering {
        match (self.limbs.is_empty(), self.negative) {
            (true, _) => Ordering::Equal,
            (false, true) => Ordering::Less,
            (false, false) => Ordering::Greater,
        }
    }

    pub(crate) fn neg(mut self) -> Self {
        self.negative = !self.negative;
        self
    }

    /// self * 2^`exponent`.
    pub(crate) fn scaled(&self, exponent: i32) -> Self {
        let mut scaled =
            self.mul(&Self::from_f64(crate::fixed::power_of_two(exponent.rem_euclid(64))));
        scaled.exponent += exponent.div_euclid(64);
        scaled
    }

    pub(crate) fn add(&self, other: &Self) -> Self {
        if self.limbs.is_empty() {
            return other.clone();
        }
        if other.limbs.is_empty() {
            return self.clone();
        }
        let exponent = self.exponent.min(other.exponent);
        let (a, b) = (self.aligned(exponent), other.aligned(exponent));
        let (negative, limbs) = if self.negative == other.negative {
            (self.negative, add_magnitudes(a, &b))
        } else {
            match compare_magnitudes(&a, &b) {
                Ordering::Less => (other.negative, sub_magnitudes(b, &a)),
                _ => (self.negative, sub_magnitudes(a, &b)),
            }
        };
        let mut sum = Self { negative, limbs, exponent };
        sum.trim();
        sum
    }

    pub(crate) fn sub(&self, other: &Self) -> Self {
        self.add(&other.clone().neg())
    }

    pub(crate) fn mul(&self, other: &Self) -> Self {
        let mut limbs =
            Vec::from_iter(core::iter::repeat_n(0_u64, self.limbs.len() + other.limbs.len()));
        for (i, a) in self.limbs.iter().enumerate() {
            let mut carry = 0_u128;
            for (j, b) in other.limbs.iter().enumerate() {
                let sum = u128::from(*a) * u128::from(*b) + u128::from(limbs[i + j]) + carry;
                #[expect(clippy::cast_possible_truncation, reason = "the low half")]
                let low = sum as u64;
                limbs[i + j] = low;
                carry = sum >> 64;
            }
            #[expect(clippy::cast_possible_truncation, reason = "a carry is one limb")]
            let high = carry as u64;
            limbs[i + other.limbs.len()] = high;
        }
        let negative = self.negative != other.negative;
        let mut product = Self { negative, limbs, exponent: self.exponent + other.exponent };
        product.trim();
        product
    }

    /// Is |self| below, equal to or above |other|?
    fn compare_magnitude(&self, other: &Self) -> Ordering {
        let exponent = self.exponent.min(other.exponent);
        compare_magnitudes(&self.aligned(exponent), &other.aligned(exponent))
    }

    pub(crate) fn compare(&self, other: &Self) -> Ordering {
        self.sub(other).sign()
    }

    /// The exponent e of 2^e <= |self| < 2^(e + 1); `None` for 0.
    pub(crate) fn exponent_of(&self) -> Option<i32> {
        let top = self.limbs.last()?.ilog2();
        let limbs = i32::try_from(self.limbs.len() - 1).unwrap_or(i32::MAX / 64);
        Some((self.exponent + limbs) * 64 + i32::try_from(top).unwrap_or(0))
    }

    /// self * 2^`fraction_bits`, cut towards 0 to a whole number, which must fit.
    pub(crate) fn to_fixed(&self, fraction_bits: i32) -> i64 {
        let mut magnitude = 0_u64;
        for (i, limb) in (0_i32..).zip(&self.limbs) {
            let shift = (self.exponent + i) * 64 + fraction_bits;
            magnitude |= match shift {
                0..64 => limb << shift,
                -63..0 => limb >> -shift,
                _ => 0,
            };
        }
        let magnitude = i64::try_from(magnitude).unwrap_or(i64::MAX);
        if self.negative { -magnitude } else { magnitude }
    }

    /// The nearest `f64`s' neighbourhood: within 2^-51 of self, relatively; 0 or infinity
    /// beyond the range.
    pub(crate) fn to_f64_near(&self) -> f64 {
        let Some(exponent) = self.exponent_of() else { return 0.0 };
        #[expect(clippy::cast_precision_loss, reason = "the nearest f64 is meant")]
        let leading = self.to_fixed(60 - exponent) as f64;
        // In two steps, so that neither factor leaves the range before the product does.
        let half = (exponent - 60) / 2;
        leading
            * crate::fixed::power_of_two(half)
            * crate::fixed::power_of_two(exponent - 60 - half)
    }

    /// The limbs with zeros below, so that they count from `exponent`.
    fn aligned(&self, exponent: i32) -> Vec<u64> {
        let zeros = usize::try_from(self.exponent - exponent).unwrap_or(0);
        let zeros = if self.limbs.is_empty() { 0 } else { zeros };
        core::iter::repeat_n(0, zeros).chain(self.limbs.iter().copied()).collect()
    }

    /// Drops zero limbs at both ends.
    fn trim(&mut self) {
        while self.limbs.last() == Some(&0) {
            self.limbs.pop();
        }
        let low = self.limbs.iter().take_while(|limb| **limb == 0).count();
        if low > 0 {
            self.limbs.drain(..low);
            self.exponent += i32::try_from(low).unwrap_or(0);
        }
        if self.limbs.is_empty() {
            self.exponent = 0;
            self.negative = false;
        }
    }
}

fn compare_magnitudes(a: &[u64], b: &[u64]) -> Ordering {
    a.len().cmp(&b.len()).then_with(|| a.iter().rev().cmp(b.iter().rev()))
}

fn add_magnitudes(mut a: Vec<u64>, b: &[u64]) -> Vec<u64> {
    let n = a.len().max(b.len()) + 1;
    a.resize(n, 0);
    let mut carry = false;
    for (i, limb) in a.iter_mut().enumerate() {
        (*limb, carry) = limb.carrying_add(b.get(i).copied().unwrap_or(0), carry);
    }
    a
}

/// a - b for a >= b.
fn sub_magnitudes(mut a: Vec<u64>, b: &[u64]) -> Vec<u64> {
    let mut borrow = false;
    for (i, limb) in a.iter_mut().enumerate() {
        (*limb, borrow) = limb.borrowing_sub(b.get(i).copied().unwrap_or(0), borrow);
    }
    a
}

/// `numerator` / `denominator` (not 0), rounded once to the nearest `f32`, ties to even. An
/// exact zero is +0; what underflows keeps its sign.
pub(crate) fn round_quotient(numerator: &Dyadic, denominator: &Dyadic) -> f32 {
    if numerator.sign() == Ordering::Equal {
        return 0.0;
    }
    let negative = numerator.negative != denominator.negative;
    // Positive floats are ordered as their bits are: look for the last one not above the
    // quotient. 0 is not above it; 2^128, whose bits are those of infinity, may be.
    let not_above = |bits: u32| {
        denominator.mul(&Dyadic::from_f64(widen(bits))).compare_magnitude(numerator).is_le()
    };
    let (mut low, mut high) = (0_u32, f32::INFINITY.to_bits());
    if not_above(high) {
        low = high;
    }
    while high - low > 1 {
        let middle = low.midpoint(high);
        if not_above(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    let bits = if low == high {
        low
    } else {
        let half_way = Dyadic::from_f64((widen(low) + widen(high)) / 2.0);
        match denominator.mul(&half_way).compare_magnitude(numerator) {
            Ordering::Less => high,
            Ordering::Equal => low + (low & 1),
            Ordering::Greater => low,
        }
    };
    f32::from_bits(bits | u32::from(negative) << 31)
}

/// The value of a positive float's bits; that of infinity's is 2^128 here, as in rounding.
fn widen(bits: u32) -> f64 {
    if bits == f32::INFINITY.to_bits() {
        crate::fixed::power_of_two(128)
    } else {
        f64::from(f32::from_bits(bits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dyadic(value: f64) -> Dyadic {
        Dyadic::from_f64(value)
    }

    #[test]
    fn exact_sums_and_products_lose_nothing() {
        let (big, small) = (dyadic(1e300), dyadic(-1e-300));
        let sum = big.add(&small);
        assert_eq!(sum.sub(&big).compare(&small), Ordering::Equal);
        assert_eq!(sum.sub(&big).sub(&small).sign(), Ordering::Equal);
        // (a + b)(a - b) = a^2 - b^2
        let left = big.add(&small).mul(&big.sub(&small));
        let right = big.mul(&big).sub(&small.mul(&small));
        assert_eq!(left.compare(&right), Ordering::Equal);
        assert_eq!(dyadic(f64::from_bits(1)).exponent_of(), Some(-1074));
        assert_eq!(dyadic(-6.5).to_fixed(3), -52);
        assert_eq!(dyadic(6.9).to_fixed(0), 6);
        assert_eq!(dyadic(-1.5e-200).to_f64_near(), -1.5e-200);
    }

    #[test]
    fn exact_quotients_round_as_division_does() {
        let cases = [
            (1.0, 3.0),
            (-2.0, 3.0),
            (16_777_217.0, 1.0),
            (16_777_219.0, 1.0),
            (1e-45, 2.0),
            (-1e-46, 1.0),
            (3.4e38, 0.5),
            (f64::from(f32::MAX), 1.0),
            (f64::from(f32::MAX) * (1.0 + 2e-8), 1.0),
            (5e-324, 7e-320),
        ];
        for (n, d) in cases {
            // These quotients are no ties that f64 would move, so rounding twice is right.
            #[expect(clippy::cast_possible_truncation, reason = "the reference")]
            let expected = (n / d) as f32;
            assert_eq!(
                round_quotient(&dyadic(n), &dyadic(d)).to_bits(),
                expected.to_bits(),
                "{n}/{d}"
            );
        }
        assert_eq!(round_quotient(&dyadic(0.0), &dyadic(-3.0)).to_bits(), 0);
    }
}
