//! Which three vertices carry the polygon's plane, and whether the others agree.

use core::cmp::Ordering;

use super::Attributes;
use super::twofold::{TWOFOLD_ERROR, Twofold};
use crate::exact::Dyadic;

/// How far a vertex may be from the plane, relative to the polygon's diameter (the diagonal of
/// its bounding box), or an attribute from the affine function, relative to its range.
const FLATNESS: f64 = 1.0 / 1024.0;

/// The rounding of `f64`.
const U: f64 = f64::EPSILON / 2.0;

/// Far below any product of coordinates that matters; far above what underflow can hide.
const TINY: f64 = 1e-270;

/// The vertices a, b, c of a polygon: a is the least by (x, y, z, w, attributes), b maximises
/// |a x p|, c maximises |det(a, b, p)| in p = (x, y, w), ties to the least. So the choice does
/// not depend on where the list of vertices begins. `positions` are the polygon's, scaled.
///
/// A triangle has but one plane: from its least vertex on, in the order of the list.
#[inline(always)]
pub(crate) fn choose(positions: &[[f64; 4]], attributes: &dyn Attributes) -> [usize; 3] {
    if let [p, q, r] = positions {
        let a = first_of_three([p[0], q[0], r[0]]);
        return from(a.unwrap_or_else(|| least(positions, attributes)));
    }
    choose_of_many(positions, attributes)
}

/// The same of a triangle, if x alone tells, as it nearly always does.
#[inline(always)]
pub(crate) fn choose_by_x(xs: [f64; 3]) -> Option<[usize; 3]> {
    first_of_three(xs).map(from)
}

/// The vertices of a triangle from `a` on.
#[inline(always)]
fn from(a: usize) -> [usize; 3] {
    [a, (a + 1) % 3, (a + 2) % 3]
}

/// Which of three is less than both others.
#[inline(always)]
fn first_of_three([p, q, r]: [f64; 3]) -> Option<usize> {
    match (p < q, q < r, r < p) {
        (true, true, false) | (true, false, false) if p < r => Some(0),
        (false, true, _) if q < p => Some(1),
        (_, false, true) if r < q => Some(2),
        _ => None,
    }
}

fn least(positions: &[[f64; 4]], attributes: &dyn Attributes) -> usize {
    let less = |i: &usize, j: &usize| compare_vertices(positions, attributes, *i, *j);
    (0..positions.len()).min_by(less).unwrap_or(0)
}

fn choose_of_many(positions: &[[f64; 4]], attributes: &dyn Attributes) -> [usize; 3] {
    let less = |i: &usize, j: &usize| compare_vertices(positions, attributes, *i, *j);
    let a = least(positions, attributes);
    let pa = projective(positions[a]);
    let b = greatest(&Measure::Cross(pa), positions, &less);
    let pb = projective(positions[b]);
    let c = greatest(&Measure::Determinant(pa, pb), positions, &less);
    [a, b, c]
}

/// What a vertex p of the triple is chosen for.
enum Measure {
    /// |a x p|^2
    Cross([f64; 3]),
    /// |det(a, b, p)|
    Determinant([f64; 3], [f64; 3]),
}

impl Measure {
    /// In `f64`, and a bound of its error.
    fn nearly(&self, p: [f64; 3]) -> (f64, f64) {
        match *self {
            Self::Cross(a) => length_squared(cross(a, p), a, p),
            Self::Determinant(a, b) => {
                let normal = cross(a, b);
                let det = normal[0] * p[0] + normal[1] * p[1] + normal[2] * p[2];
                let normal_bound = 2.0 * U * magnitude(a) * magnitude(b) * 4.0;
                let bound = (normal_bound + 4.0 * U * magnitude(normal)) * magnitude(p) * 3.0;
                (det.abs(), bound + TINY)
            }
        }
    }

    /// In twice the precision, and a bound of its error.
    fn nearer(&self, p: [f64; 3]) -> (Twofold, f64) {
        match *self {
            Self::Cross(a) => {
                let v = Twofold::cross(a, p);
                let scale = magnitude(a) * magnitude(p);
                (Twofold::dot(v, v), 16.0 * TWOFOLD_ERROR * scale * scale + TINY)
            }
            Self::Determinant(a, b) => {
                let det = Twofold::dot(Twofold::cross(a, b), p.map(Twofold::from_f64));
                let scale = magnitude(a) * magnitude(b) * magnitude(p);
                (det.abs(), 16.0 * TWOFOLD_ERROR * scale + TINY)
            }
        }
    }

    fn exactly(&self, p: [f64; 3]) -> Dyadic {
        let exact = |p: [f64; 3]| p.map(Dyadic::from_f64);
        match *self {
            Self::Cross(a) => {
                let [x, y, w] = exact_cross(&exact(a), &exact(p));
                x.mul(&x).add(&y.mul(&y)).add(&w.mul(&w))
            }
            Self::Determinant(a, b) => {
                let [x, y, w] = exact_cross(&exact(a), &exact(b));
                let p = exact(p);
                let det = x.mul(&p[0]).add(&y.mul(&p[1])).add(&w.mul(&p[2]));
                if det.sign() == Ordering::Less { det.neg() } else { det }
            }
        }
    }

    fn compare(&self, p: [f64; 3], q: [f64; 3]) -> Ordering {
        let ((mp, ep), (mq, eq)) = (self.nearly(p), self.nearly(q));
        if (mp - mq).abs() > ep + eq {
            return mp.total_cmp(&mq);
        }
        // Of a parallelogram, two are as far: rounding alone tells them apart.
        let ((mp, ep), (mq, eq)) = (self.nearer(p), self.nearer(q));
        let difference = mp.minus(mq);
        if difference.abs() > 2.0 * (ep + eq) {
            return difference.total_cmp(&0.0);
        }
        self.exactly(p).compare(&self.exactly(q))
    }
}

/// The vertex of the greatest `measure`; of several, the least.
fn greatest(
    measure: &Measure,
    positions: &[[f64; 4]],
    less: &dyn Fn(&usize, &usize) -> Ordering,
) -> usize {
    let mut best = 0;
    for i in 1..positions.len() {
        let order = measure.compare(projective(positions[i]), projective(positions[best]));
        if order.then_with(|| less(&best, &i)) == Ordering::Greater {
            best = i;
        }
    }
    best
}

/// (x, y, w) of a position.
pub(crate) fn projective([x, y, _, w]: [f64; 4]) -> [f64; 3] {
    [x, y, w]
}

/// (x/w, y/w, 1) of a position: its place in the framebuffer, but for the viewport.
pub(crate) fn divided([x, y, _, w]: [f64; 4]) -> [f64; 3] {
    [x / w, y / w, 1.0]
}

#[inline(always)]
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn exact_cross(a: &[Dyadic; 3], b: &[Dyadic; 3]) -> [Dyadic; 3] {
    let minor = |i: usize, j: usize| a[i].mul(&b[j]).sub(&a[j].mul(&b[i]));
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn magnitude(p: [f64; 3]) -> f64 {
    p[0].abs().max(p[1].abs()).max(p[2].abs())
}

/// |`v`|^2 for a cross product v of a and b, and a bound of its error.
fn length_squared(v: [f64; 3], a: [f64; 3], b: [f64; 3]) -> (f64, f64) {
    // Each component is off by at most 4 u |a| |b|, and is at most 2 |a| |b|.
    let scale = magnitude(a) * magnitude(b);
    let square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    (square, 3.0 * (2.0 * 2.0 * scale * 4.0 * U * scale) + 8.0 * U * square + TINY)
}

fn compare_vertices(
    positions: &[[f64; 4]],
    attributes: &dyn Attributes,
    i: usize,
    j: usize,
) -> Ordering {
    let (p, q) = (positions[i], positions[j]);
    // Positions are finite; zeros of either sign are the same.
    p.partial_cmp(&q).unwrap_or(Ordering::Equal).then_with(|| {
        (0..attributes.count())
            .map(|k| attributes.attribute(i, k).total_cmp(&attributes.attribute(j, k)))
            .find(|order| order.is_ne())
            .unwrap_or(Ordering::Equal)
    })
}

/// Affine coordinates in the plane of three points, as far as the tests of flatness need them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AffineFrame {
    triple: [usize; 3],
    a: [f64; 3],
    edges: [[f64; 3]; 2],
    normal: [f64; 3],
    normal_squared: f64,
}

impl AffineFrame {
    /// The plane of the points `point(i)` for the vertices i of `triple`.
    pub(crate) fn new(triple: [usize; 3], point: impl Fn(usize) -> [f64; 3]) -> Self {
        let [a, b, c] = triple.map(point);
        let edges = [sub(b, a), sub(c, a)];
        let normal = cross(edges[0], edges[1]);
        Self { triple, a, edges, normal, normal_squared: dot(normal, normal) }
    }

    /// (beta, gamma) of p = a + beta (b - a) + gamma (c - a), and the square of p's distance
    /// from the plane.
    fn coordinates(&self, p: [f64; 3]) -> ([f64; 2], f64) {
        let offset = sub(p, self.a);
        let beta = dot(self.normal, cross(offset, self.edges[1])) / self.normal_squared;
        let gamma = dot(self.normal, cross(self.edges[0], offset)) / self.normal_squared;
        let height = dot(self.normal, offset);
        ([beta, gamma], height * height / self.normal_squared)
    }

    /// By how much the value at vertex `i`, which lies at `p`, differs from that of the affine
    /// function through the triple's.
    fn deviation(&self, i: usize, p: [f64; 3], value: &impl Fn(usize) -> f64) -> f64 {
        let [sa, sb, sc] = self.triple.map(value);
        let ([beta, gamma], _) = self.coordinates(p);
        (sa + beta * (sb - sa) + gamma * (sc - sa) - value(i)).abs()
    }

    /// Is every vertex within the tolerance of the plane, and z affine over it? Points that are
    /// collinear, or lie on a line through the eye, have no plane to be off.
    pub(crate) fn is_flat(&self, positions: &[[f64; 4]]) -> bool {
        if self.normal_squared == 0.0 {
            return true;
        }
        let (mut low, mut high) = (positions[0], positions[0]);
        for p in &positions[1..] {
            low = core::array::from_fn(|k| low[k].min(p[k]));
            high = core::array::from_fn(|k| high[k].max(p[k]));
        }
        let diameter_squared: f64 = (0..4).map(|k| (high[k] - low[k]) * (high[k] - low[k])).sum();
        let tolerance = FLATNESS * FLATNESS * diameter_squared;
        let z = |i: usize| positions[i][2];
        (0..positions.len()).all(|i| {
            let p = projective(positions[i]);
            let off = self.deviation(i, p, &z);
            self.coordinates(p).1 <= tolerance && off * off <= tolerance
        })
    }

    /// Is `value(i)`, at the points `point(i)` of `n` vertices, affine within the tolerance of
    /// its `range`?
    pub(crate) fn is_affine(
        &self,
        n: usize,
        range: f64,
        point: impl Fn(usize) -> [f64; 3],
        value: impl Fn(usize) -> f64,
    ) -> bool {
        self.normal_squared == 0.0
            || (0..n).all(|i| self.deviation(i, point(i), &value) <= FLATNESS * range)
    }
}

#[inline(always)]
pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
