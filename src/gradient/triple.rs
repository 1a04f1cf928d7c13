//! Which three vertices carry the polygon's plane.

use core::cmp::Ordering;

use super::Attributes;
use super::twofold::{TWOFOLD_ERROR, Twofold};
use crate::exact::Dyadic;
use crate::fixed::{exponent_of, power_of_two};
use crate::number::Number;

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

/// The least vertex.
fn least(positions: &[[f64; 4]], attributes: &dyn Attributes) -> usize {
    let mut least = 0;
    for i in 1..positions.len() {
        let (x, least_x) = (positions[i][0], positions[least][0]);
        // Nearly always x tells.
        if x < least_x || x == least_x && compare_vertices(positions, attributes, i, least).is_lt()
        {
            least = i;
        }
    }
    least
}

#[inline(always)]
fn choose_of_many(positions: &[[f64; 4]], attributes: &dyn Attributes) -> [usize; 3] {
    let less = |i: &usize, j: &usize| compare_vertices(positions, attributes, *i, *j);
    let a = least(positions, attributes);
    let pa = projective(positions[a]);
    let b = greatest(&Cross(pa, magnitude(pa)), positions, [a, a], &less);
    let c = greatest(&Determinant::new(pa, projective(positions[b])), positions, [a, b], &less);
    [a, b, c]
}

/// What a vertex p of the triple is chosen for.
trait Measure {
    /// In `f64`, and a bound of its error.
    fn nearly(&self, p: [f64; 3]) -> (f64, f64);

    /// The order of two vertices where that is not enough.
    fn compare(&self, p: [f64; 3], q: [f64; 3]) -> Ordering;
}

/// |a x p|^2, of a and its magnitude.
struct Cross([f64; 3], f64);

impl Measure for Cross {
    #[inline(always)]
    fn nearly(&self, p: [f64; 3]) -> (f64, f64) {
        let v = cross(self.0, p);
        // Each component is off by at most 4 u |a| |b|, and is at most 2 |a| |b|.
        let scale = self.1 * magnitude(p);
        let square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        (square, 3.0 * (2.0 * 2.0 * scale * 4.0 * U * scale) + 8.0 * U * square + TINY)
    }

    #[cold]
    fn compare(&self, p: [f64; 3], q: [f64; 3]) -> Ordering {
        let nearer = |p: [f64; 3]| {
            let (v, scale) = (Twofold::cross(self.0, p), self.1 * magnitude(p));
            (Twofold::dot(v, v), 16.0 * TWOFOLD_ERROR * scale * scale + TINY)
        };
        compare_pairs(nearer(p), nearer(q)).unwrap_or_else(|| {
            let exactly = |p: [f64; 3]| {
                let [x, y, w] = exact_cross(&exact(self.0), &exact(p));
                x.mul(&x).add(&y.mul(&y)).add(&w.mul(&w))
            };
            exactly(p).compare(&exactly(q))
        })
    }
}

/// |det(a, b, p)|
struct Determinant {
    a: [f64; 3],
    b: [f64; 3],
    /// a x b, and by what its product with a vector of magnitude 1 may be off.
    normal: [f64; 3],
    error: f64,
}

impl Determinant {
    #[inline(always)]
    fn new(a: [f64; 3], b: [f64; 3]) -> Self {
        let normal = cross(a, b);
        let normal_error = 2.0 * U * magnitude(a) * magnitude(b) * 4.0;
        Self { a, b, normal, error: (normal_error + 8.0 * U * magnitude(normal)) * 3.0 }
    }

    #[inline(always)]
    fn times_normal(&self, p: [f64; 3]) -> f64 {
        self.normal[0] * p[0] + self.normal[1] * p[1] + self.normal[2] * p[2]
    }

    /// The order where, but for little, p - q is b - a or a - b, or p + q is a + b, as in a
    /// parallelogram: det(a, b, .) does not see that part, and of what is left `f64` is good enough.
    #[inline(always)]
    fn compare_on_parallels(&self, p: [f64; 3], q: [f64; 3]) -> Option<Ordering> {
        let (det_p, det_q) = (self.times_normal(p), self.times_normal(q));
        let certain = det_p.abs() > self.error * magnitude(p) + TINY
            && det_q.abs() > self.error * magnitude(q) + TINY;
        if !certain {
            return None;
        }
        // |det p| - |det q| is det of the one or the other, but for its sign.
        let same_side = (det_p > 0.0) == (det_q > 0.0);
        let sign = if same_side { -1.0 } else { 1.0 };
        for [to, from] in [[self.b, self.a], [self.a, self.b]] {
            let (mut rest, mut size) = ([0.0; 3], 0.0);
            for k in 0..3 {
                let along = Twofold::difference(to[k], -sign * from[k]);
                let between = Twofold::difference(p[k], -sign * q[k]);
                // Both are exact, and so is the rest where it is 0.
                let (high, low) = (between.hi - along.hi, between.lo - along.lo);
                rest[k] = high + low;
                size = larger(size, high.abs() + low.abs());
            }
            if size == 0.0 {
                return Some(Ordering::Equal);
            }
            let difference = self.times_normal(rest);
            if difference.abs() > self.error * size + TINY {
                return difference
                    .partial_cmp(&0.0)
                    .map(|order| if det_p > 0.0 { order } else { order.reverse() });
            }
        }
        None
    }
}

impl Measure for Determinant {
    #[inline(always)]
    fn nearly(&self, p: [f64; 3]) -> (f64, f64) {
        (self.times_normal(p).abs(), self.error * magnitude(p) + TINY)
    }

    fn compare(&self, p: [f64; 3], q: [f64; 3]) -> Ordering {
        self.compare_on_parallels(p, q).unwrap_or_else(|| self.compare_any(p, q))
    }
}

impl Determinant {
    #[cold]
    fn compare_any(&self, p: [f64; 3], q: [f64; 3]) -> Ordering {
        // In exact ties, which only numbers of few bits are likely to make.
        if let Some([a, b, p, q]) = whole([self.a, self.b, p, q]) {
            let det = |p: [i64; 3]| {
                let minor = |i: usize, j: usize| {
                    i128::from(a[i]) * i128::from(b[j]) - i128::from(a[j]) * i128::from(b[i])
                };
                let [x, y, w] = p.map(i128::from);
                (minor(1, 2) * x + minor(2, 0) * y + minor(0, 1) * w).abs()
            };
            return det(p).cmp(&det(q));
        }
        let nearer = |p: [f64; 3]| {
            let det = Twofold::dot(Twofold::cross(self.a, self.b), p.map(Twofold::from_f64));
            let scale = magnitude(self.a) * magnitude(self.b) * magnitude(p);
            (det.abs(), 16.0 * TWOFOLD_ERROR * scale + TINY)
        };
        compare_pairs(nearer(p), nearer(q)).unwrap_or_else(|| {
            let exactly = |p: [f64; 3]| {
                let [x, y, w] = exact_cross(&exact(self.a), &exact(self.b));
                let p = exact(p);
                let det = x.mul(&p[0]).add(&y.mul(&p[1])).add(&w.mul(&p[2]));
                if det.sign() == Ordering::Less { det.neg() } else { det }
            };
            exactly(p).compare(&exactly(q))
        })
    }
}

/// The order of two numbers with bounds of their errors, if these tell.
fn compare_pairs((p, p_error): (Twofold, f64), (q, q_error): (Twofold, f64)) -> Option<Ordering> {
    let difference = p.minus(q);
    let certain = difference.abs() > 2.0 * (p_error + q_error);
    certain.then(|| difference.total_cmp(&0.0))
}

/// The points times a power of two, if that makes whole numbers of 40 bits: so that the determinant of
/// three of them fits into 128.
fn whole(points: [[f64; 3]; 4]) -> Option<[[i64; 3]; 4]> {
    let largest = points.iter().fold(0.0, |size, p| larger(size, magnitude(*p)));
    let scale = power_of_two(39 - exponent_of(largest)?);
    let mut whole = [[0; 3]; 4];
    for (to, from) in whole.as_flattened_mut().iter_mut().zip(points.as_flattened()) {
        let scaled = from * scale;
        #[expect(clippy::cast_possible_truncation, reason = "below 2^40")]
        let number = scaled as i64;
        #[expect(clippy::cast_precision_loss, reason = "below 2^40")]
        let same = number as f64 == scaled;
        if !same {
            return None;
        }
        *to = number;
    }
    Some(whole)
}

fn exact(p: [f64; 3]) -> [Dyadic; 3] {
    p.map(Dyadic::from_f64)
}

/// The vertex of the greatest `measure`; of several, the least. It is 0 for the vertices `none`, the
/// first of which is the least of all.
#[inline(always)]
fn greatest(
    measure: &impl Measure,
    positions: &[[f64; 4]],
    none: [usize; 2],
    less: &dyn Fn(&usize, &usize) -> Ordering,
) -> usize {
    let (mut best, mut value, mut error) = (none[0], 0.0, 0.0);
    for (i, position) in positions.iter().enumerate() {
        if none.contains(&i) {
            continue;
        }
        let p = projective(*position);
        let (its_value, its_error) = measure.nearly(p);
        let order = if (its_value - value).abs() > its_error + error {
            its_value.total_cmp(&value)
        } else {
            // Of a parallelogram, two are as far: rounding alone tells them apart.
            let order = measure.compare(p, projective(positions[best]));
            order.then_with(|| less(&best, &i))
        };
        if order == Ordering::Greater {
            (best, value, error) = (i, its_value, its_error);
        }
    }
    best
}

/// (x, y, w) of a position.
#[inline(always)]
pub(crate) fn projective<F: Number>([x, y, _, w]: [F; 4]) -> [F; 3] {
    [x, y, w]
}

/// (x/w, y/w, 1) of a position: its place in the framebuffer, but for the viewport.
pub(crate) fn divided([x, y, _, w]: [f64; 4]) -> [f64; 3] {
    [x / w, y / w, 1.0]
}

#[inline(always)]
pub(crate) fn cross<F: Number>(a: [F; 3], b: [F; 3]) -> [F; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn exact_cross(a: &[Dyadic; 3], b: &[Dyadic; 3]) -> [Dyadic; 3] {
    let minor = |i: usize, j: usize| a[i].mul(&b[j]).sub(&a[j].mul(&b[i]));
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

#[inline(always)]
fn magnitude(p: [f64; 3]) -> f64 {
    larger(larger(p[0].abs(), p[1].abs()), p[2].abs())
}

#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
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

#[inline(always)]
pub(crate) fn sub<F: Number>(a: [F; 3], b: [F; 3]) -> [F; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every way to compare determinants is that of exact arithmetic.
    #[test]
    fn determinants_are_compared_exactly() {
        let exactly = |d: &Determinant, p: [f64; 3], q: [f64; 3]| {
            let det = |p: [f64; 3]| {
                let [x, y, w] = exact_cross(&exact(d.a), &exact(d.b));
                let p = exact(p);
                let det = x.mul(&p[0]).add(&y.mul(&p[1])).add(&w.mul(&p[2]));
                if det.sign() == Ordering::Less { det.neg() } else { det }
            };
            det(p).compare(&det(q))
        };
        let mut state = 1_u64;
        let mut next = |steps: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let fraction = f64::from((state >> 33) as u32) / f64::from(1_u32 << 31);
            ((fraction * 2.0 - 1.0) * steps).round_ties_even() / steps
        };
        let (mut ties, mut parallels) = (0, 0);
        for i in 0..4000 {
            // Few bits, or many.
            let steps = if i % 2 == 0 { 4.0 } else { 1e15 };
            let [a, b, p] = [0, 1, 2].map(|_| [next(steps), next(steps), next(steps)]);
            let determinant = Determinant::new(a, b);
            let along = [0, 1, 2].map(|k| p[k] + (b[k] - a[k]));
            let further = [0, 1, 2].map(|k| p[k] - 3.0 * (b[k] - a[k]));
            let opposite = [0, 1, 2].map(|k| a[k] + b[k] - p[k]);
            for q in [along, further, opposite, [next(steps), next(steps), next(steps)]] {
                let expected = exactly(&determinant, p, q);
                ties += u32::from(expected.is_eq());
                assert_eq!(determinant.compare(p, q), expected, "{a:?} {b:?} {p:?} {q:?}");
                assert_eq!(determinant.compare_any(p, q), expected, "{a:?} {b:?} {p:?} {q:?}");
                let quick = determinant.compare_on_parallels(p, q);
                parallels += u32::from(quick.is_some());
                assert!(quick.is_none_or(|order| order == expected), "{a:?} {b:?} {p:?} {q:?}");
            }
        }
        assert!(ties > 2000 && parallels > 9000, "{ties} {parallels}");
    }
}
