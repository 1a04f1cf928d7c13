//! The plane of the polygon in the framebuffer: weights of its three vertices as linear
//! functions of the pixel, in `f64` with a bound of their error, and exactly.
//!
//! With (X, Y) = w times the framebuffer position *from the anchor pixel's centre*, a vertex is
//! p = (X, Y, w), and the pixel (u, v) from the anchor is the point (u, v, 1) times its w. So
//! the weights lambda that make it of the vertices a, b, c are
//!
//! ```text
//!   lambda_b det = (c x a) . (u, v, 1)      det = a . (b x c)
//!   lambda_c det = (a x b) . (u, v, 1)
//!   det / w      = ((b - a) x (c - a)) . (u, v, 1)
//! ```
//!
//! (Heckbert and Moreton 1991.) All three are linear, and every quantity that the polygon
//! carries is a combination of them. They are formed from the differences b - a and c - a, which
//! a w that is equal everywhere makes exactly 0. The derivation of the bounds is in
//! docs/precision.md, "Set-up".

use super::triple::{cross, exact_cross, sub};
use crate::exact::Dyadic;
use crate::fixed::{FixedPlane, exponent_of, power_of_two};
use crate::space::Viewport;

/// The rounding of `f64`.
pub(crate) const U: f64 = f64::EPSILON / 2.0;

/// (X, Y) of a vertex: two products and their sum, by the magnitude of the products.
const PROJECTION_ERROR: f64 = 3.0 * U;

/// A 2 x 2 minor of two edges: two products and their difference, by one product's greatest
/// magnitude.
const MINOR_ERROR: f64 = 5.0 * U;

/// The same for a minor of an edge and a vertex, by each product's magnitude.
const WEIGHT_ERROR: f64 = 3.0 * U;

/// det: three products and two sums, by each product's magnitude.
const DET_ERROR: f64 = 5.0 * U;

/// A combination of three coefficients, by each product's magnitude.
const COMBINATION_ERROR: f64 = 6.0 * U;

/// Room for what a bound of first order leaves out.
const SECOND_ORDER: f64 = 1.001;

/// Below this, underflow might hide an error.
const TINY: f64 = 1e-270;

/// A linear function of the pixel, `x u + y v + c`, and a bound of each coefficient's error.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Linear {
    /// x, y, c.
    pub(crate) k: [f64; 3],
    pub(crate) error: [f64; 3],
}

impl Linear {
    /// Greatest magnitude, and greatest error, at the pixels within `reach`.
    fn bounds(&self, reach: Reach) -> (f64, f64) {
        let sum = |k: [f64; 3]| k[0].abs() * reach.u + k[1].abs() * reach.v + k[2].abs();
        (sum(self.k), sum(self.error))
    }

    /// In fixed point, and a bound of its error in units of the last place; nothing if its
    /// magnitude is out of proportion.
    pub(crate) fn to_fixed(self, reach: Reach) -> Option<(FixedPlane, f64)> {
        let (magnitude, error) = self.bounds(reach);
        let Some(exponent) = exponent_of(magnitude) else {
            return (magnitude == 0.0 && error == 0.0).then(Default::default);
        };
        let fraction_bits = HEADROOM - exponent;
        if fraction_bits.abs() > 1000 {
            return None;
        }
        let scale = power_of_two(fraction_bits);
        #[expect(clippy::cast_possible_truncation, reason = "below 2^62; a unit is in the bound")]
        let [d_dx, d_dy, c] = self.k.map(|k| (k * scale) as i64);
        let plane = FixedPlane { c, d_dx, d_dy, fraction_bits };
        Some((plane, error * scale + reach.units()))
    }
}

/// Bits that a fixed-point value may have at the pixels of the polygon.
const HEADROOM: i32 = 60;

/// How far the covered pixels lie from the anchor, at most, in columns and rows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reach {
    pub(crate) u: f64,
    pub(crate) v: f64,
}

impl Reach {
    /// The error of three coefficients cut to whole units, in units.
    fn units(self) -> f64 {
        self.u + self.v + 1.0
    }
}

/// Where pixel offsets count from, and how they become (X, Y, w).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Anchor {
    /// The framebuffer column and row.
    pub(crate) pixel: [i32; 2],
    half: [f64; 2],
    /// From the anchor's centre to the viewport's, in pixels: exact.
    offset: [f64; 2],
}

impl Anchor {
    pub(crate) fn new(viewport: Viewport, pixel: [i32; 2]) -> Self {
        let centre = viewport.centre();
        let offset = [0, 1].map(|k| centre[k] - f64::from(pixel[k]) - 0.5);
        Self { pixel, half: viewport.half_size(), offset }
    }

    /// (X, Y, w) of a clip position, and bounds of the errors of X and Y.
    fn project(&self, [x, y, _, w]: [f64; 4]) -> ([f64; 3], [f64; 2]) {
        let terms =
            [[x * self.half[0], w * self.offset[0]], [-y * self.half[1], w * self.offset[1]]];
        let error = terms.map(|[s, t]| PROJECTION_ERROR * (s.abs() + t.abs()) + TINY);
        ([terms[0][0] + terms[0][1], terms[1][0] + terms[1][1], w], error)
    }

    /// (X, Y, w) without error.
    fn project_exactly(&self, [x, y, _, w]: [f64; 4]) -> [Dyadic; 3] {
        let [x, y, w] = [x, -y, w].map(Dyadic::from_f64);
        let along = |c: &Dyadic, k: usize| {
            let scaled = c.mul(&Dyadic::from_f64(self.half[k]));
            scaled.add(&w.mul(&Dyadic::from_f64(self.offset[k])))
        };
        [along(&x, 0), along(&y, 1), w.clone()]
    }
}

/// The weights of a triple's vertices, times det.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Frame {
    /// det/w.
    pub(crate) q: Linear,
    /// det times the weight of b, and of c.
    weights: [Linear; 2],
    pub(crate) det: f64,
    pub(crate) det_error: f64,
}

impl Frame {
    pub(crate) fn new(anchor: &Anchor, triple: [[f64; 4]; 3]) -> Self {
        let projected = triple.map(|p| anchor.project(p));
        let [a, b, c] = projected.map(|(p, _)| p);
        let error = [0, 1].map(|k| projected[0].1[k].max(projected[1].1[k]).max(projected[2].1[k]));
        let edges = [sub(b, a), sub(c, a)];
        let size = [0, 1, 2].map(|k| edges[0][k].abs().max(edges[1][k].abs()));
        let edge_error = [2.0 * error[0] + U * size[0], 2.0 * error[1] + U * size[1], U * size[2]];

        // (b - a) x (c - a), by components; each is two products of edges.
        let minor_error = |i: usize, j: usize| {
            let bound = edge_error[i] * size[j] + (size[i] + edge_error[i]) * edge_error[j];
            let underflow = if size[i] == 0.0 && edge_error[i] == 0.0
                || size[j] == 0.0 && edge_error[j] == 0.0
            {
                0.0
            } else {
                TINY
            };
            SECOND_ORDER * (2.0 * bound + MINOR_ERROR * size[i] * size[j]) + underflow
        };
        let q = Linear {
            k: cross(edges[0], edges[1]),
            error: [minor_error(1, 2), minor_error(2, 0), minor_error(0, 1)],
        };

        // (c - a) x a and a x (b - a).
        let a_error = [error[0], error[1], 0.0];
        let weight_error = |i: usize, j: usize| {
            let one = |i: usize, j: usize| {
                edge_error[i] * (a[j].abs() + a_error[j])
                    + size[i] * a_error[j]
                    + WEIGHT_ERROR * size[i] * a[j].abs()
            };
            SECOND_ORDER * (one(i, j) + one(j, i)) + TINY
        };
        let error = [weight_error(1, 2), weight_error(2, 0), weight_error(0, 1)];
        let weights =
            [Linear { k: cross(edges[1], a), error }, Linear { k: cross(a, edges[0]), error }];

        let det = a[0] * q.k[0] + a[1] * q.k[1] + a[2] * q.k[2];
        let det_error = SECOND_ORDER
            * (0..3)
                .map(|k| {
                    (a[k].abs() + a_error[k]) * q.error[k]
                        + a_error[k] * q.k[k].abs()
                        + DET_ERROR * (a[k] * q.k[k]).abs()
                })
                .sum::<f64>()
            + TINY;
        Self { q, weights, det, det_error }
    }

    /// `base` det/w + `b` lambda_b det + `c` lambda_c det, where each of the three is off by
    /// `input_error` at most.
    pub(crate) fn combine(&self, [base, b, c]: [f64; 3], input_error: f64) -> Linear {
        let parts = [(base, &self.q), (b, &self.weights[0]), (c, &self.weights[1])];
        let mut sum = Linear::default();
        for i in 0..3 {
            sum.k[i] = parts.iter().map(|(factor, part)| factor * part.k[i]).sum();
            let error: f64 = parts
                .iter()
                .map(|(factor, part)| {
                    factor.abs() * part.error[i]
                        + (COMBINATION_ERROR * factor.abs() + input_error)
                            * (part.k[i].abs() + part.error[i])
                })
                .sum();
            sum.error[i] = SECOND_ORDER * error;
        }
        sum
    }
}

/// The same without error: x, y, c of each linear function.
#[derive(Clone, Debug)]
pub(crate) struct ExactFrame {
    pub(crate) q: [Dyadic; 3],
    weights: [[Dyadic; 3]; 2],
    pub(crate) det: Dyadic,
}

impl ExactFrame {
    pub(crate) fn new(anchor: &Anchor, triple: [[f64; 4]; 3]) -> Self {
        let [a, b, c] = triple.map(|p| anchor.project_exactly(p));
        let q = exact_cross(&exact_sub(&b, &a), &exact_sub(&c, &a));
        let det = exact_dot(&a, &q);
        Self { weights: [exact_cross(&c, &a), exact_cross(&a, &b)], q, det }
    }

    /// `base` det/w + `b` lambda_b det + `c` lambda_c det.
    pub(crate) fn combine(&self, [base, b, c]: &[Dyadic; 3]) -> [Dyadic; 3] {
        let [wb, wc] = &self.weights;
        core::array::from_fn(|i| base.mul(&self.q[i]).add(&b.mul(&wb[i])).add(&c.mul(&wc[i])))
    }
}

/// A linear function's value at the pixel (`u`, `v`) from the anchor.
pub(crate) fn exact_at([x, y, c]: &[Dyadic; 3], u: i32, v: i32) -> Dyadic {
    x.mul(&Dyadic::from_i32(u)).add(&y.mul(&Dyadic::from_i32(v))).add(c)
}

/// In fixed point, and a bound of its error in units of the last place.
pub(crate) fn exact_to_fixed(linear: &[Dyadic; 3], reach: Reach) -> (FixedPlane, f64) {
    let [x, y, c] = linear.each_ref().map(|k| k.exponent_of());
    let grown = |k: Option<i32>, by: f64| k.map(|e| e + exponent_of(by).map_or(0, |b| b + 1));
    let Some(exponent) = grown(x, reach.u).max(grown(y, reach.v)).max(c) else {
        return Default::default();
    };
    // Three terms, each below 2^(exponent + 1).
    let fraction_bits = HEADROOM - exponent - 2;
    let [d_dx, d_dy, c] = linear.each_ref().map(|k| k.to_fixed(fraction_bits));
    (FixedPlane { c, d_dx, d_dy, fraction_bits }, reach.units())
}

fn exact_sub(a: &[Dyadic; 3], b: &[Dyadic; 3]) -> [Dyadic; 3] {
    core::array::from_fn(|k| a[k].sub(&b[k]))
}

fn exact_dot(a: &[Dyadic; 3], b: &[Dyadic; 3]) -> Dyadic {
    a[0].mul(&b[0]).add(&a[1].mul(&b[1])).add(&a[2].mul(&b[2]))
}
