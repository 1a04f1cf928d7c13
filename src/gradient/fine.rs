//! The plane of the polygon in twice the precision of `f64`: where `f64`'s bound is not good
//! enough, and for values that the X loop cannot tell.
//!
//! As good as exact arithmetic once its coefficients are rounded to `f64`, unless the polygon is
//! so thin, or so far away, that its determinant cannot be told from 0. docs/precision.md, "In
//! pairs", derives the bounds.

use fearless_simd::{Simd, SimdBase, f64x4};

use super::frame::{Anchor, Bounded, EVALUATION_ERROR, Linear, Projection, Reach, SECOND_ORDER, U};
use super::nearest_f32;
use super::twofold::{Twofold, Twofolds};
use crate::fixed::power_of_two;

/// The error of Q, of a weight times det or of a combination of them at a pixel, by the products
/// of the magnitudes that they are made of; det's is twice that.
const FINE_ERROR: f64 = 1.0 / (1_u128 << 97) as f64;

/// What det may be off by, relatively: far less than what the X loop leaves in doubt.
const CERTAIN_DET: f64 = 1.0 / (1_u64 << 42) as f64;

/// A quotient of two of them, relatively.
const QUOTIENT_ERROR: f64 = 1.0 / (1_u128 << 98) as f64;

/// What a value may be off by, relatively, for its rounding to be told by its high part.
const HALF_SPACING: f64 = 1.0 / (1_u64 << 56) as f64;

/// The 29 bits of a `f64` that a `f32` has not, where it is halfway between two of these.
const HALF_WAY: u64 = 1 << 28;

/// Powers of two beyond this might leave the range of `f64` on the way.
const LARGEST_EXPONENT: i32 = 500;

/// Far below any product that matters; far above what underflow can hide.
const TINY: f64 = 1e-250;

/// A linear function: x, y, c, and a lane that is not used.
#[derive(Clone, Copy, Debug, Default)]
struct FineLinear {
    hi: [f64; 4],
    lo: [f64; 4],
}

impl FineLinear {
    #[inline(always)]
    fn of<S: Simd>(lanes: Twofolds<S>) -> Self {
        let [hi, lo] = lanes.store();
        Self { hi, lo }
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S) -> Twofolds<S> {
        Twofolds::load(simd, &self.hi, &self.lo)
    }

    #[inline(always)]
    fn part(&self, k: usize) -> Twofold {
        Twofold { hi: self.hi[k], lo: self.lo[k] }
    }

    /// The value at the pixel (`u`, `v`) from the anchor.
    fn at(&self, [u, v]: [f64; 2]) -> Twofold {
        self.part(0).times_number(u).add(self.part(1).times_number(v)).add(self.part(2))
    }

    /// Each coefficient rounded.
    #[inline(always)]
    fn rounded(&self) -> Linear {
        let [x, y, c, _] = self.hi;
        Linear { x, y, c }
    }
}

/// base, b and c of a [`FineFrame::combine`].
pub(super) type Terms = [Twofold; 3];

/// The weights of a triple's vertices, times det.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FineFrame {
    q: FineLinear,
    weights: [FineLinear; 2],
    det: Twofold,
    /// Bounds of the error of Q, or of a weight times det, at any pixel; and of det's.
    error: f64,
    det_error: f64,
    /// Those of the slopes of Q.
    slope_errors: [f64; 2],
    reach: Reach,
}

impl FineFrame {
    #[inline(always)]
    pub(super) fn new<S: Simd>(
        simd: S,
        anchor: &Anchor,
        triple: [[f64; 4]; 3],
        reach: Reach,
    ) -> Self {
        let Projection { half, offset } = anchor.projection;
        let scale = f64x4::load_array_ref(simd, &[half[0], -half[1], 1.0, 0.0]);
        let shift = f64x4::load_array_ref(simd, &[offset[0], offset[1], 0.0, 0.0]);
        let [a, b, c] = &triple;
        let (a, a_size) = project(simd, a, scale, shift);
        let (b, b_size) = project(simd, b, scale, shift);
        let (c, c_size) = project(simd, c, scale, shift);
        let size = a_size + b_size + c_size;
        let (to_b, to_c) = (b.sub(a), c.sub(a));
        let q = Twofolds::cross(simd, to_b, to_c);
        let [[x, y, w, _], [low_x, low_y, low_w, _]] = q.times(simd, a).store();
        let sum = Twofold { hi: x, lo: low_x }.add(Twofold { hi: y, lo: low_y });
        let det = sum.add(Twofold { hi: w, lo: low_w });
        let [x, y, w, _] = size.into();
        Self {
            q: FineLinear::of(q),
            weights: [
                FineLinear::of(Twofolds::cross(simd, to_c, a)),
                FineLinear::of(Twofolds::cross(simd, a, to_b)),
            ],
            det,
            error: FINE_ERROR * reach.total([y * w, w * x, x * y]) + TINY,
            det_error: 2.0 * FINE_ERROR * x * y * w + TINY,
            slope_errors: [FINE_ERROR * y * w, FINE_ERROR * w * x],
            reach,
        }
    }

    /// Q, det and a bound of its error, if Q is nearly as good as exact arithmetic would make it, and
    /// det good enough.
    #[inline(always)]
    pub(super) fn plane(&self) -> Option<(Bounded, f64, f64)> {
        let mut linear = self.q.rounded();
        // A slope that cannot be told from 0 is 0.
        for (slope, error) in [&mut linear.x, &mut linear.y].into_iter().zip(self.slope_errors) {
            if slope.abs() <= error {
                *slope = 0.0;
            }
        }
        let bounded = self.bounded(linear, 3.0 * self.error)?;
        let det = self.det.hi;
        let certain = self.det_error <= CERTAIN_DET * det.abs();
        certain.then_some((bounded, det, self.det_error + U * det.abs()))
    }

    /// base det/w + b lambda_b det + c lambda_c det, if it is as good as exact arithmetic would
    /// make it.
    #[inline(always)]
    pub(super) fn combine<S: Simd>(&self, simd: S, terms: &Terms) -> Option<Bounded> {
        let [base, b, c] = terms.map(|term| Twofolds::splat(simd, term));
        let [wb, wc] = self.weights.each_ref().map(|weight| weight.lanes(simd));
        let weighed = b.times(simd, wb).add(c.times(simd, wc));
        let sum = base.times(simd, self.q.lanes(simd)).add(weighed);
        self.bounded(FineLinear::of(sum).rounded(), self.error_of(terms))
    }

    /// The bound for what is combined of `terms`.
    #[inline(always)]
    fn error_of(&self, terms: &Terms) -> f64 {
        let [base, b, c] = terms.map(|term| term.hi.abs());
        (base + b + c) * self.error
    }

    /// With what rounding and the evaluation add, unless `error` is larger.
    #[inline(always)]
    fn bounded(&self, linear: Linear, error: f64) -> Option<Bounded> {
        let rounding = EVALUATION_ERROR * linear.size(self.reach);
        let bounded = Bounded { linear, error: SECOND_ORDER * (rounding + error) };
        (error <= rounding).then_some(bounded)
    }

    /// What is found at a pixel.
    pub(super) fn at(&self, pixel: [f64; 2]) -> FineValues<'_> {
        let [b, c] = self.weights.each_ref().map(|weight| weight.at(pixel));
        FineValues { frame: self, q: self.q.at(pixel), weights: [b, c] }
    }
}

/// (X, Y, w) of a clip position, and the magnitudes that they are made of.
#[inline(always)]
fn project<S: Simd>(
    simd: S,
    [x, y, _, w]: &[f64; 4],
    scale: f64x4<S>,
    shift: f64x4<S>,
) -> (Twofolds<S>, f64x4<S>) {
    let place = f64x4::load_array_ref(simd, &[*x, *y, *w, 0.0]);
    let place = Twofolds::product(simd, place, scale);
    let moved = Twofolds::product(simd, f64x4::splat(simd, *w), shift);
    (place.add(moved), place.magnitude() + moved.magnitude())
}

/// Q and the weights at a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct FineValues<'a> {
    frame: &'a FineFrame,
    q: Twofold,
    weights: [Twofold; 2],
}

impl FineValues<'_> {
    /// Is 1/w positive here? No also means that it is not known.
    pub(super) fn in_front(&self) -> bool {
        self.q.hi * self.frame.det.hi > 0.0
            && self.q.hi.abs() > 2.0 * self.frame.error
            && self.frame.det.hi.abs() > 2.0 * self.frame.det_error
    }

    /// Q and det, and the bounds of their errors.
    pub(super) fn q(&self) -> (Twofold, f64) {
        (self.q, self.frame.error)
    }

    /// det.
    pub(super) fn det(&self) -> (Twofold, f64) {
        (self.frame.det, self.frame.det_error)
    }

    /// As [`FineFrame::combine`].
    pub(super) fn combine(&self, terms: &Terms) -> (Twofold, f64) {
        let [base, b, c] = *terms;
        let weighed = b.times(self.weights[0]).add(c.times(self.weights[1]));
        (base.times(self.q).add(weighed), self.frame.error_of(terms))
    }

    /// `base` det and what is combined of b and c.
    pub(super) fn combine_over_det(&self, [base, b, c]: Terms) -> (Twofold, f64) {
        let (sum, error) = self.combine(&[Twofold::default(), b, c]);
        let (det, det_error) = self.det();
        // The last sum and the product are in what det's bound leaves.
        (base.times(det).add(sum), 2.0 * (error + base.hi.abs() * det_error))
    }
}

/// `numerator` / `denominator` 2^`exponent`, rounded once, if the errors that stand beside them
/// leave no doubt.
pub(super) fn round_fine_quotient(
    (numerator, numerator_error): (Twofold, f64),
    (denominator, denominator_error): (Twofold, f64),
    exponent: i32,
) -> Option<f32> {
    let value = numerator.over(denominator);
    let size = value.hi.abs();
    let error = (numerator_error + size * denominator_error) / denominator.hi.abs();
    let error = SECOND_ORDER * error + QUOTIENT_ERROR * size;
    let scale = power_of_two(exponent);
    let (hi, lo, size) = (value.hi * scale, value.lo, size * scale);
    // Where `f32` has all its bits, and no number here is subnormal.
    let normal = (f64::from(f32::MIN_POSITIVE)..f64::from(f32::MAX)).contains(&size)
        && exponent.abs() <= LARGEST_EXPONENT;
    if !(normal && error * scale <= HALF_SPACING * size) {
        return None;
    }
    let bits = hi.to_bits();
    if bits & (2 * HALF_WAY - 1) != HALF_WAY {
        return Some(nearest_f32(hi));
    }
    // Halfway between two: the low part tells, if anything does.
    let away = (lo > 0.0) == (hi > 0.0);
    let beside = f64::from_bits(if away { bits + 1 } else { bits - 1 });
    (lo.abs() > error).then(|| nearest_f32(beside))
}

#[cfg(test)]
mod tests {
    use core::cmp::Ordering;

    use fearless_simd::{Level, dispatch};

    use super::*;
    use crate::exact::{Dyadic, round_quotient};
    use crate::gradient::frame::{ExactFrame, exact_at};
    use crate::space::Viewport;

    /// Each sum of a pair is within its bound of exact arithmetic, and a quotient that leaves no
    /// doubt is rounded as that rounds it.
    #[test]
    fn fine_frames_are_within_their_bounds() {
        let viewport = Viewport::new(0, 0, 640, 480).expect("small");
        let anchor = Anchor::new(viewport, [311, 102]);
        let reach = Reach { u: 90.0, v: 70.0 };
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let fraction = f64::from((state >> 33) as u32) / f64::from(1_u32 << 31);
            fraction * 2.0 - 1.0
        };
        let within = |pair: Twofold, exact: &Dyadic, error: f64| {
            let pair = Dyadic::from_f64(pair.hi).add(&Dyadic::from_f64(pair.lo));
            let off = pair.sub(exact);
            let off = if off.sign() == Ordering::Less { off.neg() } else { off };
            assert!(off.compare(&Dyadic::from_f64(error)) != Ordering::Greater, "{off:?} {error}");
        };
        let mut rounded = 0;
        for _ in 0..2000 {
            let triple = [0, 1, 2].map(|_| {
                let w = 1.0 + 1000.0 * next().abs();
                [next() * w, next() * w * 1e-3, next(), w]
            });
            let fine = dispatch!(Level::baseline(), simd =>
                FineFrame::new(simd, &anchor, triple, reach));
            let exact = ExactFrame::new(&anchor, triple);
            within(fine.det, &exact.det, fine.det_error);
            let pixel = [(next() * 90.0) as i32, (next() * 70.0) as i32];
            let here = fine.at(pixel.map(f64::from));
            let [u, v] = pixel;
            let q = exact_at(&exact.q, u, v);
            within(here.q, &q, fine.error);
            let terms = [0, 1, 2].map(|_| Twofold::from_f64(next()));
            let (n, n_error) = here.combine(&terms);
            let combined = exact.combine(&terms.map(|term| Dyadic::from_f64(term.hi)));
            let exact_n = exact_at(&combined, u, v);
            within(n, &exact_n, n_error);
            if let Some(value) = round_fine_quotient((n, n_error), here.q(), 3) {
                rounded += 1;
                assert_eq!(value, round_quotient(&exact_n.scaled(3), &q));
            }
        }
        assert!(rounded > 1900, "{rounded}");
    }
}
