//! Which three vertices carry the polygon's plane, and whether the others agree.

use core::cmp::Ordering;

use crate::clip::VertexArrays;
use crate::exact::Dyadic;
use crate::polygon::Polygon;

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
/// For a triangle any order is as good.
pub(crate) fn choose<V: Polygon + ?Sized>(positions: &VertexArrays, polygon: &V) -> [usize; 3] {
    let n = positions.len();
    if n == 3 {
        return [0, 1, 2];
    }
    let less = |i: &usize, j: &usize| compare_vertices(positions, polygon, *i, *j);
    let a = (0..n).min_by(less).unwrap_or(0);
    let pa = projective(positions, a);
    let greatest = |measure: &dyn Fn(usize) -> (f64, f64), exact: &dyn Fn(usize) -> Dyadic| {
        (0..n).reduce(|best, i| {
            let ((m, em), (b, eb)) = (measure(i), measure(best));
            let order = if (m - b).abs() > em + eb {
                m.total_cmp(&b)
            } else {
                exact(i).compare(&exact(best))
            };
            match order.then_with(|| less(&best, &i)) {
                Ordering::Greater => i,
                _ => best,
            }
        })
    };
    let b = greatest(
        &|i| length_squared(cross(pa, projective(positions, i)), pa, projective(positions, i)),
        &|i| {
            let [x, y, w] = exact_cross(pa, projective(positions, i));
            x.mul(&x).add(&y.mul(&y)).add(&w.mul(&w))
        },
    )
    .unwrap_or(0);
    let pb = projective(positions, b);
    let normal = cross(pa, pb);
    let normal_bound = 2.0 * U * magnitude(pa) * magnitude(pb) * 4.0;
    let c = greatest(
        &|i| {
            let p = projective(positions, i);
            let det = normal[0] * p[0] + normal[1] * p[1] + normal[2] * p[2];
            let bound = (normal_bound + 4.0 * U * magnitude(normal)) * magnitude(p) * 3.0 + TINY;
            (det.abs(), bound)
        },
        &|i| {
            let p = projective(positions, i).map(Dyadic::from_f64);
            let [x, y, w] = exact_cross(pa, pb);
            let det = x.mul(&p[0]).add(&y.mul(&p[1])).add(&w.mul(&p[2]));
            if det.sign() == Ordering::Less { det.neg() } else { det }
        },
    )
    .unwrap_or(0);
    [a, b, c]
}

/// (x, y, w) of vertex `i`.
pub(crate) fn projective(positions: &VertexArrays, i: usize) -> [f64; 3] {
    let [x, y, _, w] = positions.position(i);
    [x, y, w]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn exact_cross(a: [f64; 3], b: [f64; 3]) -> [Dyadic; 3] {
    let (a, b) = (a.map(Dyadic::from_f64), b.map(Dyadic::from_f64));
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

fn compare_vertices<V: Polygon + ?Sized>(
    positions: &VertexArrays,
    polygon: &V,
    i: usize,
    j: usize,
) -> Ordering {
    let (p, q) = (positions.position(i), positions.position(j));
    // Positions are finite; zeros of either sign are the same.
    p.partial_cmp(&q).unwrap_or(Ordering::Equal).then_with(|| {
        (0..polygon.attribute_count())
            .map(|k| polygon.attribute(i, k).total_cmp(&polygon.attribute(j, k)))
            .find(|order| order.is_ne())
            .unwrap_or(Ordering::Equal)
    })
}

/// The affine coordinates of every vertex in the plane of a, b, c, as far as the tests of
/// flatness need them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AffineFrame {
    a: [f64; 3],
    edges: [[f64; 3]; 2],
    normal: [f64; 3],
    normal_squared: f64,
}

impl AffineFrame {
    pub(crate) fn new(positions: &VertexArrays, triple: [usize; 3]) -> Self {
        let [a, b, c] = triple.map(|i| projective(positions, i));
        let edges = [sub(b, a), sub(c, a)];
        let normal = cross(edges[0], edges[1]);
        Self { a, edges, normal, normal_squared: dot(normal, normal) }
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

    /// Is every vertex within the tolerance of the plane, and z affine over it? A polygon whose
    /// a, b, c are collinear has no plane to be off.
    pub(crate) fn is_flat(&self, positions: &VertexArrays, triple: [usize; 3]) -> bool {
        if self.normal_squared == 0.0 {
            return true;
        }
        let corner = |pick: fn(f64, f64) -> f64, start: f64| {
            (0..positions.len()).fold([start; 4], |corner, i| {
                let p = positions.position(i);
                [0, 1, 2, 3].map(|k| pick(corner[k], p[k]))
            })
        };
        let (low, high) = (corner(f64::min, f64::INFINITY), corner(f64::max, f64::NEG_INFINITY));
        let sides = [0, 1, 2, 3].map(|k| high[k] - low[k]);
        let diameter_squared: f64 = sides.iter().map(|side| side * side).sum();
        let tolerance_squared = FLATNESS * FLATNESS * diameter_squared;
        let [za, zb, zc] = triple.map(|i| positions.position(i)[2]);
        (0..positions.len()).all(|i| {
            let ([beta, gamma], distance_squared) = self.coordinates(projective(positions, i));
            let z = za + beta * (zb - za) + gamma * (zc - za);
            let off = z - positions.position(i)[2];
            distance_squared <= tolerance_squared && off * off <= tolerance_squared
        })
    }

    /// Is the quantity that is `value(i)` at vertex i affine over the plane, within the
    /// tolerance of its `range`?
    pub(crate) fn is_affine(
        &self,
        positions: &VertexArrays,
        triple: [usize; 3],
        range: f64,
        value: impl Fn(usize) -> f64,
    ) -> bool {
        if self.normal_squared == 0.0 {
            return true;
        }
        let [sa, sb, sc] = triple.map(&value);
        (0..positions.len()).all(|i| {
            let ([beta, gamma], _) = self.coordinates(projective(positions, i));
            let s = sa + beta * (sb - sa) + gamma * (sc - sa);
            (s - value(i)).abs() <= FLATNESS * range
        })
    }
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
