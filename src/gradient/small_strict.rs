//! Set-ups of small polygons within the view volume, in `Exact`, up to eight at a time: a lane is a
//! polygon.
//!
//! In `f64`, with bounds of the errors, by which each value can be shown to be rounded right. A triangle
//! of which any cannot is drawn as other polygons are. docs/precision.md, "Small triangles in `Exact`",
//! derives the bounds.

use super::frame::{Frame, U};
use super::small::{SmallCorners, SmallSetups, moderate};
use super::small_quad::{Fourth, depth_of, part_of};
use super::{CERTAIN, FITS, QUICK_QUOTIENT_ERROR, QUOTIENT_ROOM, SUM_ERROR};
use crate::number::{EIGHT, Lanes, Number, range_of};
use crate::space::Viewport;

/// A covered centre may lie outside the unsnapped triangle: Q is known where it is no less than this
/// part of the least at a corner.
const LEAST_Q: f64 = 15.0 / 16.0;

/// 1/det, its product with a numerator's coefficients, and the values' sums, relatively.
const SCALED_ERROR: f64 = 5.0 * U;

/// What values are off by, at most: `always` and `by_value` times the value.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ErrorBound {
    pub(crate) always: f64,
    pub(crate) by_value: f64,
}

/// What `Exact` has beside, of the triangles that are set up.
#[derive(Debug, Default)]
pub(super) struct StrictLanes {
    /// Where Q, times the unit, is less, nothing is known.
    least_q: Lanes,
    /// See [`ErrorBound`].
    depth_error: [Lanes; 2],
    attribute_error_by_value: Lanes,
}

impl SmallSetups {
    /// What [`set`](Self::set) and [`set_quads`](Self::set_quads) are to `Fast`, of polygons with `N` corners.
    #[inline(always)]
    pub(crate) fn set_strict<F: Number, const N: usize>(
        &mut self,
        level: F::Level,
        corners: &SmallCorners,
        lanes: u8,
        viewport: Viewport,
    ) {
        let triangle = corners.load::<F>(level);
        let [a, b, c] = &triangle;
        let [mut low, mut high] = range_of(&[a[3], b[3], c[3]]);
        let projection = corners.projection::<F>(level, viewport);
        let reach = corners.reach(level);
        let frame = Frame::new(&projection, triangle, reach);
        let (q, det) = (frame.plane.q, frame.plane.det);

        let mut fourth = None;
        if N > 3 {
            let d = corners.load_fourth::<F>(level);
            (low, high) = (low.lesser(d[3]), high.greater(d[3]));
            fourth = Some(Fourth::new(&projection, &frame.plane, &triangle, d));
        }
        let mut least_q = det.abs() / high;
        if let Some(fourth) = &fourth {
            least_q = fourth.least_q(least_q);
        }
        let unit = least_q.inverse_power(det);
        let unit_size = unit.abs();
        let least_unit_q = least_q * unit_size * LEAST_Q;
        let greatest_r = least_unit_q.reciprocal();
        let q_error = frame.q_error * unit_size * greatest_r;
        let scale = det.reciprocal();
        let det_error = frame.det_error * scale.abs();
        let limit = low.like(CERTAIN);
        // Neither holds for what is no number.
        let certain = q_error.le(limit) & det_error.le(limit);
        self.usual = F::bits(certain & high.le(low * FITS)) & moderate(&triangle, low, high);
        if let Some(fourth) = &fourth {
            self.usual &= F::bits(fourth.usual);
        }
        self.set_q(q.scaled(unit));
        least_unit_q.store(&mut self.strict.least_q);

        let range = viewport.depth_range();
        let z = [range.numerator(*a), range.numerator(*b), range.numerator(*c)];
        self.set_flat_zero(z);
        let depth = depth_of(&frame, z, reach);
        self.depth.store(depth.linear);
        let [always, by_value] = &mut self.strict.depth_error;
        (depth.error * QUOTIENT_ROOM).store(always);
        ((det_error + SCALED_ERROR) * QUOTIENT_ROOM + SUM_ERROR).store(by_value);

        let zero = low.like(0.0);
        let by_value = (q_error + QUICK_QUOTIENT_ERROR) * QUOTIENT_ROOM + SUM_ERROR;
        by_value.store(&mut self.strict.attribute_error_by_value);
        for attribute in self.attributes.iter_mut().take(self.count) {
            let values = attribute.load::<F, N>(level);
            let same = attribute.set_same(&values);
            let [a, b, c] = [values[0], values[1], values[2]];
            if attribute.same & lanes == lanes {
                a.store(&mut attribute.range[0]);
                continue;
            }
            let part = part_of(&frame, [a, b, c], zero);
            attribute.numerator.store(part.linear.scaled(unit));
            // No negative zero: so that no sum with it is one.
            (a + 0.0).store(&mut attribute.base);
            // |t| is no more than |value| + |base|.
            let by_base = by_value + SUM_ERROR;
            let error = part.error * unit_size * greatest_r * QUOTIENT_ROOM + a.abs() * by_base;
            error.store(&mut attribute.error);
            let [low, high] = range_of(&values);
            attribute.set_range(same, a, [low + 0.0, high + 0.0]);
            // What is no number makes no number of this.
            let mut known = low.lt(high) & (error * 0.0).eq(zero);
            if let (Some(fourth), Some(values)) = (&fourth, values.first_chunk::<4>()) {
                known = known & fourth.is_affine(values, [low, high]);
            }
            self.usual &= F::bits(known | same);
        }
    }

    /// Q times the unit below which nothing is known at a pixel.
    #[inline(always)]
    pub(crate) fn least_q(&self, lane: usize) -> f64 {
        self.strict.least_q[lane % EIGHT]
    }

    /// What depths are off by.
    #[inline(always)]
    pub(crate) fn depth_error(&self, lane: usize) -> ErrorBound {
        let [always, by_value] = &self.strict.depth_error;
        let lane = lane % EIGHT;
        ErrorBound { always: always[lane], by_value: by_value[lane] }
    }

    /// What attribute `k`, which was set, is besides its numerator over Q; and what it is off by.
    #[inline(always)]
    pub(crate) fn base(&self, k: usize, lane: usize) -> Option<(f64, ErrorBound)> {
        let attribute = self.attributes.get(k)?;
        let lane = lane % EIGHT;
        let by_value = self.strict.attribute_error_by_value[lane];
        Some((attribute.base[lane], ErrorBound { always: attribute.error[lane], by_value }))
    }
}

#[cfg(test)]
mod tests {
    use core::cmp::Ordering;

    use fearless_simd::{Level, dispatch, f64x8};

    use super::super::frame::{Anchor, ExactFrame, Linear, exact_at};
    use super::super::small::SmallField;
    use super::super::value::exact_values;
    use super::*;
    use crate::exact::Dyadic;
    use crate::gradient::nearest_f32;

    const COUNT: usize = 2;

    /// `value` and numerator / denominator differ by no more than `error` says; and by how much of that.
    fn is_within(value: f64, error: ErrorBound, numerator: &Dyadic, denominator: &Dyadic) -> f64 {
        let bound = error.always + error.by_value * value.abs();
        let off = size(Dyadic::from_f64(value).mul(denominator).sub(numerator));
        let allowed = Dyadic::from_f64(bound).mul(&size(denominator.clone()));
        assert!(off.compare(&allowed) != Ordering::Greater, "{value} {error:?}");
        off.to_f64_near() / allowed.to_f64_near()
    }

    fn size(number: Dyadic) -> Dyadic {
        if number.sign() == Ordering::Less { number.neg() } else { number }
    }

    fn at(Linear { x, y, c }: Linear, [u, v]: [f64; 2]) -> f64 {
        (c + y * v) + x * u
    }

    /// Values are within their bounds of exact arithmetic, and these are not much too wide.
    #[test]
    fn small_strict_values_are_within_their_bounds() {
        let viewport = Viewport::new(0, 0, 1920, 1080).expect("not large");
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            f64::from((state >> 33) as u32) / f64::from(1_u32 << 31)
        };
        let (mut usual, mut values, mut worst) = (0, 0, [0.0_f64; 2]);
        let mut setups = SmallSetups::default();
        for _ in 0..3000 {
            let anchor = [next() * 1920.0, next() * 1080.0].map(|c| c as i32);
            let spread = 2.0 + 14.0 * next();
            let w = if next() < 0.3 { 0.0 } else { next() };
            let triangle = [0, 1, 2].map(|_| {
                let w = 1.0 + w * next();
                let near = |c: i32, t: f64| f64::from(c) + (t - 0.5) * spread;
                let [x, y] = [near(anchor[0], next()), near(anchor[1], next())];
                [(x / 960.0 - 1.0) * w, (1.0 - y / 540.0) * w, next() * w, w]
            });
            let corners = SmallCorners {
                positions: [0, 1, 2, 2].map(|i| triangle[i].map(|c| [c; EIGHT])),
                anchor: anchor.map(|c| [f64::from(c); EIGHT]),
                reach: [9.0; EIGHT],
                beyond: [0.0; EIGHT],
            };
            let attributes = [0; COUNT].map(|_| {
                let offset = if next() < 0.5 { 0.0 } else { 1000.0 };
                [0; 3].map(|_| f64::from((offset + next()) as f32))
            });
            let given = setups.attributes_mut(COUNT).iter_mut().zip(attributes);
            given.for_each(|(to, [a, b, c])| to.values = [a, b, c, c].map(|value| [value; EIGHT]));
            if next() < 0.5 {
                setups.set_strict::<f64, 3>((), &corners, 1, viewport);
            } else {
                dispatch!(Level::baseline(), simd =>
                    setups.set_strict::<f64x8<_>, 3>(simd, &corners, u8::MAX, viewport));
            }
            if !setups.is_usual(0) {
                continue;
            }
            usual += 1;
            let exact = ExactFrame::new(&Anchor::new(viewport, anchor), triangle);
            for _ in 0..4 {
                let pixel = [next(), next()].map(|t| ((t - 0.5) * 18.0) as i32);
                let [u, v] = pixel;
                let pixel = pixel.map(f64::from);
                let q = at(setups.unit_q(0), pixel);
                if q < setups.least_q(0) {
                    continue;
                }
                let [za, zb, zc] = triangle.map(|p| Dyadic::from_f64(p[2]));
                let z = exact.combine(&[za.clone(), zb.sub(&za), zc.sub(&za)]);
                let (depth, _) = setups.depth(0).expect("not 0 all over");
                let (depth, error) = (at(depth, pixel), setups.depth_error(0));
                let off = is_within(depth, error, &exact_at(&z, u, v), &exact.det);
                worst[0] = worst[0].max(off);
                // As `Wide::quick_reciprocal` has it.
                let r = f64::from(1.0 / nearest_f32(q));
                let r = r + r * (1.0 - q * r);
                let exact_q = exact_at(&exact.q, u, v);
                for (k, values) in attributes.into_iter().enumerate() {
                    let Some(SmallField::Linear(numerator, _)) = setups.attribute(k, 0) else {
                        panic!("attribute {k} is not the same all over");
                    };
                    let (base, error) = setups.base(k, 0).expect("it was set");
                    let value = at(numerator, pixel) * r + base;
                    let [base, b, c] = exact_values(&triangle, values, true);
                    let n = exact.combine(&[base, b, c]);
                    let off = is_within(value, error, &exact_at(&n, u, v), &exact_q);
                    worst[1] = worst[1].max(off);
                }
                values += 1;
            }
        }
        assert!(usual > 2500 && values > 5000, "{usual} {values}");
        assert!(worst.iter().all(|off| (0.01..1.0).contains(off)), "{worst:?}");
    }
}
