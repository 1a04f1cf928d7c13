//! Numbers of twice `f64`'s precision, as sums of two (Dekker 1971): for comparisons that `f64`
//! leaves open. About ten times as quick as exact arithmetic.

/// hi + lo.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twofold {
    hi: f64,
    lo: f64,
}

/// The relative error of a sum of products of three or four numbers, by the products'
/// magnitudes: each operation is off by 2^-100 at most, and there are some twenty.
pub(super) const TWOFOLD_ERROR: f64 = 1.0 / (1_u128 << 92) as f64;

impl Twofold {
    /// a b, exactly, unless it under- or overflows.
    #[inline(always)]
    fn product(a: f64, b: f64) -> Self {
        let hi = a * b;
        let ((a1, a2), (b1, b2)) = (split(a), split(b));
        Self { hi, lo: ((a1 * b1 - hi) + a1 * b2 + a2 * b1) + a2 * b2 }
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let hi = self.hi + other.hi;
        let other_part = hi - self.hi;
        let rest = (self.hi - (hi - other_part)) + (other.hi - other_part);
        Self::of(hi, rest + (self.lo + other.lo))
    }

    #[inline(always)]
    fn negated(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        let product = Self::product(self.hi, other.hi);
        Self::of(product.hi, product.lo + (self.hi * other.lo + self.lo * other.hi))
    }

    /// The sum of two of which the second is small.
    #[inline(always)]
    fn of(hi: f64, lo: f64) -> Self {
        let sum = hi + lo;
        Self { hi: sum, lo: lo - (sum - hi) }
    }

    /// |self|.
    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        if self.hi < 0.0 { self.negated() } else { self }
    }

    /// self - other, rounded.
    #[inline(always)]
    pub(super) fn minus(self, other: Self) -> f64 {
        self.add(other.negated()).hi
    }

    /// a x b.
    #[inline(always)]
    pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [Self; 3] {
        let minor = |i: usize, j: usize| Self::product(a[i], b[j]).add(Self::product(-a[j], b[i]));
        [minor(1, 2), minor(2, 0), minor(0, 1)]
    }

    /// v . p
    #[inline(always)]
    pub(super) fn dot(v: [Self; 3], p: [Self; 3]) -> Self {
        v[0].times(p[0]).add(v[1].times(p[1])).add(v[2].times(p[2]))
    }

    #[inline(always)]
    pub(super) fn from_f64(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

/// Two numbers of 26 bits each whose sum is `value` (Veltkamp).
#[inline(always)]
fn split(value: f64) -> (f64, f64) {
    let scaled = value * 134_217_729.0;
    let high = scaled - (scaled - value);
    (high, value - high)
}
