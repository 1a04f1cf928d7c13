//! Numbers of twice `f64`'s precision, as sums of two (Dekker 1971): for comparisons and set-ups
//! that `f64` leaves open. Ten times as quick as exact arithmetic, and more in lanes.

use fearless_simd::{Simd, SimdBase, f64x4};

/// hi + lo.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Twofold {
    pub(super) hi: f64,
    pub(super) lo: f64,
}

/// 2^27 + 1: times this, a number falls into two halves.
const SPLITTER: f64 = 134_217_729.0;

/// The relative error of a sum of products of three or four numbers, by the products'
/// magnitudes: each operation is off by 2^-100 at most, and there are some twenty.
pub(super) const TWOFOLD_ERROR: f64 = 1.0 / (1_u128 << 92) as f64;

impl Twofold {
    /// a b, exactly, unless it under- or overflows.
    #[inline(always)]
    pub(super) fn product(a: f64, b: f64) -> Self {
        let hi = a * b;
        let ((a1, a2), (b1, b2)) = (split(a), split(b));
        Self { hi, lo: ((a1 * b1 - hi) + a1 * b2 + a2 * b1) + a2 * b2 }
    }

    #[inline(always)]
    pub(super) fn add(self, other: Self) -> Self {
        let hi = self.hi + other.hi;
        let other_part = hi - self.hi;
        let rest = (self.hi - (hi - other_part)) + (other.hi - other_part);
        Self::of(hi, rest + (self.lo + other.lo))
    }

    #[inline(always)]
    pub(super) fn negated(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }

    #[inline(always)]
    pub(super) fn times(self, other: Self) -> Self {
        let product = Self::product(self.hi, other.hi);
        Self::of(product.hi, product.lo + (self.hi * other.lo + self.lo * other.hi))
    }

    /// a - b, exactly, unless it overflows.
    #[inline(always)]
    pub(super) fn difference(a: f64, b: f64) -> Self {
        let hi = a - b;
        let other_part = hi - a;
        Self { hi, lo: (a - (hi - other_part)) - (b + other_part) }
    }

    /// self times a number.
    #[inline(always)]
    pub(super) fn times_number(self, factor: f64) -> Self {
        let product = Self::product(self.hi, factor);
        Self::of(product.hi, product.lo + self.lo * factor)
    }

    /// self / other, which is not 0.
    #[inline(always)]
    pub(super) fn over(self, other: Self) -> Self {
        let hi = self.hi / other.hi;
        let rest = self.add(other.times_number(hi).negated());
        Self::of(hi, rest.hi / other.hi)
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

/// Four of them; the operations are those of [`Twofold`], lane by lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twofolds<S: Simd> {
    hi: f64x4<S>,
    lo: f64x4<S>,
}

impl<S: Simd> Twofolds<S> {
    #[inline(always)]
    pub(super) fn load(simd: S, hi: &[f64; 4], lo: &[f64; 4]) -> Self {
        Self { hi: f64x4::load_array_ref(simd, hi), lo: f64x4::load_array_ref(simd, lo) }
    }

    /// `value` in every lane.
    #[inline(always)]
    pub(super) fn splat(simd: S, value: Twofold) -> Self {
        Self { hi: f64x4::splat(simd, value.hi), lo: f64x4::splat(simd, value.lo) }
    }

    /// What it is by its high part, without sign.
    #[inline(always)]
    pub(super) fn magnitude(self) -> f64x4<S> {
        self.hi.abs()
    }

    /// High and low parts.
    #[inline(always)]
    pub(super) fn store(self) -> [[f64; 4]; 2] {
        [self.hi.into(), self.lo.into()]
    }

    #[inline(always)]
    pub(super) fn product(simd: S, a: f64x4<S>, b: f64x4<S>) -> Self {
        let hi = a * b;
        let ((a1, a2), (b1, b2)) = (split_lanes(simd, a), split_lanes(simd, b));
        Self { hi, lo: ((a1 * b1 - hi) + a1 * b2 + a2 * b1) + a2 * b2 }
    }

    #[inline(always)]
    pub(super) fn add(self, other: Self) -> Self {
        let hi = self.hi + other.hi;
        let other_part = hi - self.hi;
        let rest = (self.hi - (hi - other_part)) + (other.hi - other_part);
        Self::of(hi, rest + (self.lo + other.lo))
    }

    #[inline(always)]
    pub(super) fn sub(self, other: Self) -> Self {
        let hi = self.hi - other.hi;
        let other_part = hi - self.hi;
        let rest = (self.hi - (hi - other_part)) - (other.hi + other_part);
        Self::of(hi, rest + (self.lo - other.lo))
    }

    #[inline(always)]
    pub(super) fn times(self, simd: S, other: Self) -> Self {
        let product = Self::product(simd, self.hi, other.hi);
        Self::of(product.hi, product.lo + (self.hi * other.lo + self.lo * other.hi))
    }

    #[inline(always)]
    fn of(hi: f64x4<S>, lo: f64x4<S>) -> Self {
        let sum = hi + lo;
        Self { hi: sum, lo: lo - (sum - hi) }
    }

    /// a x b, of the first three lanes.
    #[inline(always)]
    pub(super) fn cross(simd: S, a: Self, b: Self) -> Self {
        let ((a1, a2), (b1, b2)) = (a.turned(simd), b.turned(simd));
        a1.times(simd, b2).sub(a2.times(simd, b1))
    }

    /// The first three lanes turned on by one and by two; the fourth stays.
    #[inline(always)]
    fn turned(self, simd: S) -> (Self, Self) {
        let [[x, y, z, w], [low_x, low_y, low_z, low_w]] = self.store();
        (
            Self::load(simd, &[y, z, x, w], &[low_y, low_z, low_x, low_w]),
            Self::load(simd, &[z, x, y, w], &[low_z, low_x, low_y, low_w]),
        )
    }
}

#[inline(always)]
fn split_lanes<S: Simd>(simd: S, value: f64x4<S>) -> (f64x4<S>, f64x4<S>) {
    let scaled = value * f64x4::splat(simd, SPLITTER);
    let high = scaled - (scaled - value);
    (high, value - high)
}

/// Two numbers of 26 bits each whose sum is `value` (Veltkamp).
#[inline(always)]
fn split(value: f64) -> (f64, f64) {
    let scaled = value * SPLITTER;
    let high = scaled - (scaled - value);
    (high, value - high)
}
