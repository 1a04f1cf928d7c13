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
use crate::number::Number;
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

/// The value at a pixel from its coefficients: two products and two sums, by the magnitude of
/// all three terms. The same covers coefficients that are rounded once from exact ones.
pub(super) const EVALUATION_ERROR: f64 = 6.0 * U;

/// Room for what a bound of first order leaves out.
pub(super) const SECOND_ORDER: f64 = 1.001;

/// Below this, underflow might hide an error.
const TINY: f64 = 1e-270;

/// A linear function of the pixel `u` columns and `v` rows from the anchor: (c + y v) + x u, in
/// this order, so that the value at a pixel is the same by every path.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Linear<F = f64> {
    pub(crate) x: F,
    pub(crate) y: F,
    pub(crate) c: F,
}

impl<F: Number> Linear<F> {
    /// Times `scale`, each coefficient rounded.
    #[inline(always)]
    pub(crate) fn scaled(self, scale: F) -> Self {
        Self { x: self.x * scale, y: self.y * scale, c: self.c * scale }
    }

    /// The sum of the terms' greatest magnitudes within `reach`.
    #[inline(always)]
    pub(super) fn size(&self, reach: Reach<F>) -> F {
        self.x.abs() * reach.u + self.y.abs() * reach.v + self.c.abs()
    }
}

impl Linear {
    /// The part that a row has in common.
    #[inline(always)]
    pub(crate) fn row(&self, v: f64) -> f64 {
        self.c + self.y * v
    }
}

/// A linear function and a bound of its values' error at the covered pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bounded<F = f64> {
    pub(crate) linear: Linear<F>,
    pub(crate) error: F,
}

impl<F: Number> Bounded<F> {
    /// Times `scale`, with what that and the evaluation round.
    #[inline(always)]
    pub(crate) fn scaled(self, scale: F, reach: Reach<F>) -> Self {
        let linear = self.linear.scaled(scale);
        let error = self.error * scale.abs() + linear.size(reach) * EVALUATION_ERROR;
        Self { linear, error: error * SECOND_ORDER }
    }
}

/// How far the covered pixels lie from the anchor, at most, in columns and rows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reach<F = f64> {
    pub(crate) u: F,
    pub(crate) v: F,
}

impl<F: Number> Reach<F> {
    /// The greatest value of a linear function with coefficients of these magnitudes.
    #[inline(always)]
    pub(super) fn total(self, [x, y, c]: [F; 3]) -> F {
        x * self.u + y * self.v + c
    }
}

/// How clip positions become (X, Y, w).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Projection<F = f64> {
    pub(super) half: [f64; 2],
    /// From the anchor's centre to the viewport's, in pixels: exact.
    pub(super) offset: [F; 2],
}

impl<F: Number> Projection<F> {
    /// Around the centre of the pixel at these columns and rows of the framebuffer.
    #[inline(always)]
    pub(crate) fn new(viewport: Viewport, [column, row]: [F; 2]) -> Self {
        let [x, y] = viewport.centre();
        let offset = [column.like(x) - column - 0.5, row.like(y) - row - 0.5];
        Self { half: viewport.half_size(), offset }
    }

    /// The two terms of X and those of Y, of a clip position.
    #[inline(always)]
    fn terms(&self, [x, y, _, w]: [F; 4]) -> [[F; 2]; 2] {
        let [half_w, half_h] = self.half;
        [[x * half_w, w * self.offset[0]], [y * -half_h, w * self.offset[1]]]
    }

    /// (X, Y, w) of a clip position.
    #[inline(always)]
    pub(crate) fn project(&self, position: [F; 4]) -> [F; 3] {
        let [[x, dx], [y, dy]] = self.terms(position);
        [x + dx, y + dy, position[3]]
    }

    /// The same, and the magnitudes that X and Y are made of.
    #[inline(always)]
    fn project_with_size(&self, position: [F; 4]) -> ([F; 3], [F; 2]) {
        let [[x, dx], [y, dy]] = self.terms(position);
        ([x + dx, y + dy, position[3]], [x.abs() + dx.abs(), y.abs() + dy.abs()])
    }
}

/// Where pixel offsets count from.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Anchor {
    /// The framebuffer column and row.
    pub(crate) pixel: [i32; 2],
    pub(super) projection: Projection,
}

impl Anchor {
    #[inline(always)]
    pub(crate) fn new(viewport: Viewport, pixel: [i32; 2]) -> Self {
        let [column, row] = pixel;
        Self { pixel, projection: Projection::new(viewport, [column.into(), row.into()]) }
    }

    /// (X, Y, w) without error.
    fn project_exactly(&self, [x, y, _, w]: [f64; 4]) -> [Dyadic; 3] {
        let [x, y, w] = [x, -y, w].map(Dyadic::from_f64);
        let along = |c: &Dyadic, k: usize| {
            let Projection { half, offset } = self.projection;
            c.mul(&Dyadic::from_f64(half[k])).add(&w.mul(&Dyadic::from_f64(offset[k])))
        };
        [along(&x, 0), along(&y, 1), w.clone()]
    }
}

/// The weights of a triple's vertices, times det, in `f64`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Plane<F = f64> {
    /// det/w.
    pub(crate) q: Linear<F>,
    /// det times the weight of b, and of c.
    weights: [Linear<F>; 2],
    pub(crate) det: F,
}

impl<F: Number> Plane<F> {
    /// Of a triple whose errors are of no interest.
    #[inline(always)]
    pub(crate) fn new(projection: &Projection<F>, [a, b, c]: [[F; 4]; 3]) -> Self {
        let (a, b, c) = (projection.project(a), projection.project(b), projection.project(c));
        Self::of(a, sub(b, a), sub(c, a))
    }

    /// Of a and the edges to b and c.
    #[inline(always)]
    fn of(a: [F; 3], to_b: [F; 3], to_c: [F; 3]) -> Self {
        let q = cross(to_b, to_c);
        Self {
            q: Linear::from(q),
            weights: [Linear::from(cross(to_c, a)), Linear::from(cross(a, to_b))],
            det: a[0] * q[0] + a[1] * q[1] + a[2] * q[2],
        }
    }

    /// `base` det/w + `b` lambda_b det + `c` lambda_c det.
    #[inline(always)]
    pub(crate) fn combine(&self, [base, b, c]: [F; 3]) -> Linear<F> {
        let ([wb, wc], q) = (&self.weights, &self.q);
        Linear {
            x: base * q.x + (b * wb.x + c * wc.x),
            y: base * q.y + (b * wb.y + c * wc.y),
            c: base * q.c + (b * wb.c + c * wc.c),
        }
    }
}

impl<F> From<[F; 3]> for Linear<F> {
    #[inline(always)]
    fn from([x, y, c]: [F; 3]) -> Self {
        Self { x, y, c }
    }
}

/// A component of the vertex a, or of both edges: its greatest magnitude, and a bound of its error.
#[derive(Clone, Copy)]
struct Rounded<F> {
    size: F,
    error: F,
}

impl<F: Number> Rounded<F> {
    /// Component `k` of the edges.
    #[inline(always)]
    fn edge(edges: [[F; 3]; 2], a_error: [F; 3], k: usize) -> Self {
        let size = edges[0][k].abs().greater(edges[1][k].abs());
        Self { size, error: a_error[k] * 2.0 + size * U }
    }

    /// Of a minor of the edges: two products of this component and another.
    #[inline(always)]
    fn minor_error(self, other: Self) -> F {
        (self.error * other.size + (self.size + self.error) * other.error) * 2.0
            + self.size * other.size * MINOR_ERROR
    }

    /// Of this component of a, times the normal's.
    #[inline(always)]
    fn term_error(self, normal: F, normal_error: F) -> F {
        (self.size + self.error) * normal_error
            + (self.error + self.size * DET_ERROR) * normal.abs()
    }

    /// Of a minor of an edge and a: this component and another, and the same of a.
    #[inline(always)]
    fn weight_error(self, other: Self, a: Self, other_a: Self) -> F {
        self.product_error(other_a) + other.product_error(a)
    }

    /// Of this component of an edge times one of a.
    #[inline(always)]
    fn product_error(self, a: Self) -> F {
        self.error * (a.size + a.error) + self.size * (a.error + a.size * WEIGHT_ERROR)
    }
}

/// The same with bounds of the errors.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Frame<F = f64> {
    pub(crate) plane: Plane<F>,
    pub(crate) q_error: F,
    q_size: F,
    weight_error: F,
    weight_size: F,
    pub(crate) det_error: F,
}

impl<F: Number> Frame<F> {
    #[inline(always)]
    pub(crate) fn new(projection: &Projection<F>, triple: [[F; 4]; 3], reach: Reach<F>) -> Self {
        let (a, a_size) = projection.project_with_size(triple[0]);
        let (b, b_size) = projection.project_with_size(triple[1]);
        let (c, c_size) = projection.project_with_size(triple[2]);
        let a_error = [
            greatest([a_size[0], b_size[0], c_size[0]]) * PROJECTION_ERROR,
            greatest([a_size[1], b_size[1], c_size[1]]) * PROJECTION_ERROR,
            a[2].like(0.0),
        ];
        let edges = [sub(b, a), sub(c, a)];
        let [x, y, w] = [
            Rounded::edge(edges, a_error, 0),
            Rounded::edge(edges, a_error, 1),
            Rounded::edge(edges, a_error, 2),
        ];
        let mut plane = Plane::of(a, edges[0], edges[1]);
        // (b - a) x (c - a), by components.
        let mut q_error = [y.minor_error(w), w.minor_error(x), x.minor_error(y)];
        let a = [
            Rounded { size: a[0].abs(), error: a_error[0] },
            Rounded { size: a[1].abs(), error: a_error[1] },
            Rounded { size: a[2].abs(), error: a_error[2] },
        ];
        let Linear { x: normal_x, y: normal_y, c: normal_w } = plane.q;
        let det_error = a[0].term_error(normal_x, q_error[0])
            + a[1].term_error(normal_y, q_error[1])
            + a[2].term_error(normal_w, q_error[2]);
        // A slope that cannot be told from 0 is 0, and the bound says what that may cost.
        let [x_error, y_error, _] = &mut q_error;
        for (slope, error) in [(&mut plane.q.x, x_error), (&mut plane.q.y, y_error)] {
            let none = slope.abs().le(*error);
            *error = F::select(none, *error + slope.abs(), *error);
            *slope = slope.zero_if(none);
        }

        // (c - a) x a and a x (b - a).
        let weight_errors = [
            y.weight_error(w, a[1], a[2]),
            w.weight_error(x, a[2], a[0]),
            x.weight_error(y, a[0], a[1]),
        ];
        let q_size = plane.q.size(reach);
        let [weight_b, weight_c] = &plane.weights;
        let weight_size = weight_b.size(reach).greater(weight_c.size(reach));
        Self {
            plane,
            q_error: (reach.total(q_error) + q_size * EVALUATION_ERROR) * SECOND_ORDER + TINY,
            q_size,
            weight_error: reach.total(weight_errors) * SECOND_ORDER + TINY,
            weight_size,
            det_error: det_error * SECOND_ORDER + TINY,
        }
    }

    /// `base` det/w + `b` lambda_b det + `c` lambda_c det, where each of the three is off by
    /// `input_error` at most.
    #[inline(always)]
    pub(crate) fn combine(&self, [base, b, c]: [F; 3], input_error: F) -> Bounded<F> {
        const ROUNDING: f64 = COMBINATION_ERROR + EVALUATION_ERROR;
        let linear = self.plane.combine([base, b, c]);
        let (base, weight) = (base.abs(), b.abs() + c.abs());
        let error = base * (self.q_error + self.q_size * ROUNDING)
            + weight * (self.weight_error + self.weight_size * ROUNDING)
            + input_error * (self.q_size + self.weight_size * 2.0);
        Bounded { linear, error: error * SECOND_ORDER + TINY }
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

/// In `f64`.
pub(crate) fn nearby(linear: &[Dyadic; 3], reach: Reach) -> Bounded {
    let [x, y, c] = linear.each_ref().map(Dyadic::to_f64_near);
    let linear = Linear { x, y, c };
    let error = SECOND_ORDER * (EVALUATION_ERROR + 4.0 * U) * linear.size(reach) + TINY;
    Bounded { linear, error }
}

/// The greatest of three numbers.
#[inline(always)]
fn greatest<F: Number>([a, b, c]: [F; 3]) -> F {
    a.greater(b).greater(c)
}

fn exact_sub(a: &[Dyadic; 3], b: &[Dyadic; 3]) -> [Dyadic; 3] {
    core::array::from_fn(|k| a[k].sub(&b[k]))
}

fn exact_dot(a: &[Dyadic; 3], b: &[Dyadic; 3]) -> Dyadic {
    a[0].mul(&b[0]).add(&a[1].mul(&b[1])).add(&a[2].mul(&b[2]))
}
