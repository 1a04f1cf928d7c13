//! Exact sums and products of `f64`s, as lists of parts (Shewchuk, *Adaptive Precision
//! Floating-Point Arithmetic*, 1997), and pairs of `f64`s for what is well conditioned.
//!
//! Exact as long as nothing over- or underflows: the caller sees to that.

use std::cmp::Ordering;

/// high + low, where low is at most half a unit of high's last place: some 105 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pair {
    pub(crate) high: f64,
    pub(crate) low: f64,
}

/// What a pair's operation is off by at most, relatively to its operands' magnitudes; also what an
/// exact number loses when it becomes a pair. Dekker (1971) has some 2^-102.
pub(crate) const PAIR_ERROR: f64 = 1.0 / (1_u128 << 100) as f64;

impl Pair {
    /// `value`, exactly.
    pub(crate) fn of(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }

    /// a + b, exactly.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let of_b = high - a;
        Self { high, low: (a - (high - of_b)) + (b - of_b) }
    }

    /// a b, exactly: halves of 26 bits have products that `f64` holds.
    fn product(a: f64, b: f64) -> Self {
        let halves = |c: f64| {
            let scaled = 134_217_729.0 * c;
            let high = scaled - (scaled - c);
            (high, c - high)
        };
        let (high, (a, al), (b, bl)) = (a * b, halves(a), halves(b));
        Self { high, low: al * bl - (((high - a * b) - al * b) - a * bl) }
    }

    /// The sum.
    pub(crate) fn plus(self, other: Self) -> Self {
        let Self { high, low } = Self::sum(self.high, other.high);
        Self::sum(high, low + (self.low + other.low))
    }

    /// The product.
    pub(crate) fn times(self, factor: f64) -> Self {
        let Self { high, low } = Self::product(self.high, factor);
        Self::sum(high, low + self.low * factor)
    }

    /// The quotient: each step of long division takes care of another 50 bits.
    pub(crate) fn over(self, divisor: Self) -> Self {
        let mut quotient = Self::default();
        let mut rest = self;
        for _ in 0..3 {
            let part = rest.high / divisor.high;
            quotient = quotient.plus(Self::of(part));
            rest = rest.plus(divisor.times(-part));
        }
        quotient
    }

    /// Times a power of two.
    pub(crate) fn scaled(self, power: f64) -> Self {
        Self { high: self.high * power, low: self.low * power }
    }
}

/// An exact number: the sum of its parts, which do not overlap, the smallest first, none of them
/// zero.
#[derive(Clone, Debug, Default)]
pub(crate) struct Expansion(Vec<f64>);

impl Expansion {
    /// `value`, exactly.
    pub(crate) fn of(value: f64) -> Self {
        let mut sum = Self::default();
        sum.add(value);
        sum
    }

    fn add(&mut self, value: f64) {
        let mut carried = value;
        self.0.retain_mut(|part| {
            let Pair { high, low } = Pair::sum(carried, *part);
            carried = high;
            *part = low;
            low != 0.0
        });
        if carried != 0.0 {
            self.0.push(carried);
        }
    }

    /// The sum.
    pub(crate) fn plus(mut self, other: &Self) -> Self {
        other.0.iter().for_each(|part| self.add(*part));
        self
    }

    /// The product.
    pub(crate) fn times(&self, factor: f64) -> Self {
        let mut product = Self::default();
        for part in &self.0 {
            let Pair { high, low } = Pair::product(*part, factor);
            product.add(low);
            product.add(high);
        }
        product
    }

    /// The product of both.
    pub(crate) fn by(&self, other: &Self) -> Self {
        other.0.iter().fold(Self::default(), |sum, part| sum.plus(&self.times(*part)))
    }

    /// Compared with zero.
    pub(crate) fn sign(&self) -> Ordering {
        // The largest part outweighs all others.
        self.0.last().map_or(Ordering::Equal, |part| part.total_cmp(&0.0))
    }

    /// The nearest pair, but for [`PAIR_ERROR`].
    pub(crate) fn pair(&self) -> Pair {
        let mut rest = self.0.clone();
        let mut top = || {
            let mut carried = 0.0;
            for part in &mut rest {
                let Pair { high, low } = Pair::sum(*part, carried);
                carried = high;
                *part = low;
            }
            carried
        };
        let (high, low) = (top(), top());
        Pair::sum(high, low)
    }
}
