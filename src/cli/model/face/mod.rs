//! Judges a face as the file has it: does it have an area, is it flat, is it convex, are its
//! attributes affine? In f64, on the file's own positions, once.
//!
//! It changes nothing; what follows from the verdict is decided in `model/mod.rs`.

mod outline;

pub(super) use outline::signed_area;
use outline::{convex_hull, turns_one_way_once};

/// How far from a face's plane a vertex of a flat face may be, as a part of the diagonal of
/// its bounding box; how far from affine an attribute, as a part of its range; how far inside
/// of its hull a vertex of a convex face. The library judges polygons by the same figure.
pub(super) const TOLERANCE: f64 = 1.0 / 1024.0;

/// A face whose greatest triangle is smaller than this part of its squared diagonal has no
/// area: collinear points with decimals are not quite collinear in binary.
const LEAST_AREA: f64 = 1.0 / (1_u64 << 40) as f64;

/// What was found out about a face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Verdict {
    /// No coordinate is NaN or infinite. If this is false, so is all else.
    pub(super) finite: bool,
    /// All vertices lie on a line, or nearly.
    pub(super) degenerate: bool,
    /// All vertices lie in a plane, or nearly.
    pub(super) flat: bool,
    /// It turns one way, once; or nearly.
    pub(super) convex: bool,
    /// Each attribute is linear over the plane, or nearly.
    pub(super) affine: bool,
}

/// A vertex of a face, relative to the face and scaled so that nothing overflows.
type Point = [f64; 3];

/// Judges faces one after the other, with buffers that are reused.
#[derive(Debug, Default)]
pub(super) struct Judge {
    /// The vertices: moved so that the least is 0, scaled so that the greatest coordinate is near 1.
    points: Vec<Point>,
    /// The same, in the two dimensions in which the face is largest.
    flat: Vec<[f64; 2]>,
    /// Attributes, `stride` for each vertex.
    attributes: Vec<f32>,
    stride: usize,
    hull: Vec<usize>,
}

impl Judge {
    /// Looks at the face of these vertices: positions, and `stride` attributes for each.
    pub(super) fn judge(
        &mut self,
        positions: impl Iterator<Item = [f64; 3]> + Clone,
        attributes: impl Iterator<Item = f32>,
        stride: usize,
    ) -> Verdict {
        self.attributes.clear();
        self.attributes.extend(attributes);
        self.stride = stride;
        if !self.place(positions) {
            return Verdict::default();
        }
        let diagonal = self.diagonal();
        let Some(plane) =
            self.plane().filter(|plane| length(plane.normal) > LEAST_AREA * diagonal * diagonal)
        else {
            return Verdict { finite: true, degenerate: true, ..Verdict::default() };
        };
        let n = length(plane.normal);
        let a = self.points[plane.a];
        let beside = |point: &Point| (dot(plane.normal, sub(*point, a)) / n).abs();
        let flat = self.points.iter().all(|point| beside(point) <= TOLERANCE * diagonal);
        self.project(plane.normal);
        Verdict {
            finite: true,
            degenerate: false,
            flat,
            convex: self.is_convex(diagonal),
            affine: self.is_affine(&plane),
        }
    }

    /// The face seen along its normal: the vertices of the face that was judged last in two
    /// dimensions, counter-clockwise or not as it happens. Empty if it has no area.
    pub(super) fn projected(&self) -> &[[f64; 2]] {
        &self.flat
    }

    /// The unit normal of a face whose front is counter-clockwise (Newell's: the mean one if
    /// the face is not flat); 0 if it has no area or is not finite.
    pub(super) fn unit_normal(
        &mut self,
        positions: impl Iterator<Item = [f64; 3]> + Clone,
    ) -> [f32; 3] {
        if !self.place(positions) {
            return [0.0; 3];
        }
        let points = &self.points;
        let pairs = points.iter().zip(points.iter().cycle().skip(1));
        let sum = pairs.fold([0.0; 3], |sum, (p, q)| {
            let c = cross(*p, *q);
            [sum[0] + c[0], sum[1] + c[1], sum[2] + c[2]]
        });
        // The squares of a small sum would underflow.
        let greatest = sum.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let sum = sum.map(|x| if greatest > 0.0 { x / greatest } else { 0.0 });
        let n = length(sum);
        #[expect(clippy::cast_possible_truncation, reason = "normals are f32")]
        sum.map(|x| if n > 0.0 { (x / n) as f32 } else { 0.0 })
    }

    /// Takes the positions over; false if one is not finite.
    fn place(&mut self, positions: impl Iterator<Item = [f64; 3]> + Clone) -> bool {
        self.points.clear();
        self.flat.clear();
        if !positions.clone().flatten().all(f64::is_finite) {
            return false;
        }
        let greatest = positions.clone().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        // Before the difference, which could overflow.
        let scale = if greatest > 0.0 { power_of_two_below(greatest) } else { 1.0 };
        self.points.extend(positions.map(|point| point.map(|x| x / scale)));
        // The least: what rounds must not depend on where the list begins.
        let order = |p: &&Point, q: &&Point| {
            let pairs = p.iter().zip(q.iter()).map(|(x, y)| x.total_cmp(y));
            pairs.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
        };
        let origin = self.points.iter().min_by(order).copied().unwrap_or_default();
        for point in &mut self.points {
            *point = sub(*point, origin);
        }
        // And once more: a small face far away from the origin.
        let spread = self.points.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        if spread > 0.0 {
            let scale = power_of_two_below(spread);
            for x in self.points.iter_mut().flatten() {
                *x /= scale;
            }
        }
        true
    }

    /// Of the bounding box.
    fn diagonal(&self) -> f64 {
        let side = |axis: usize| {
            let start = (f64::INFINITY, f64::NEG_INFINITY);
            let (least, greatest) = self.points.iter().fold(start, |(least, greatest), point| {
                (least.min(point[axis]), greatest.max(point[axis]))
            });
            greatest - least
        };
        length([side(0), side(1), side(2)])
    }

    /// The plane of the best triple: a is the least vertex, b the farthest from it, c the one
    /// that makes the greatest triangle. Ties go to the least vertex, so that the verdict does
    /// not depend on where the list begins.
    fn plane(&self) -> Option<Plane> {
        let a = (0..self.points.len()).min_by(|i, j| self.order(*i, *j))?;
        let from_a = |i: usize| sub(self.points[i], self.points[a]);
        let b = self.greatest(|i| length(from_a(i)))?;
        let c = self.greatest(|i| length(cross(from_a(b), from_a(i))))?;
        Some(Plane { a, b, c, normal: cross(from_a(b), from_a(c)) })
    }

    /// The vertex with the greatest `measure`, the least of them if there are several.
    fn greatest(&self, measure: impl Fn(usize) -> f64) -> Option<usize> {
        (0..self.points.len())
            .max_by(|i, j| measure(*i).total_cmp(&measure(*j)).then_with(|| self.order(*j, *i)))
    }

    /// By x, y, z, then by attributes.
    fn order(&self, i: usize, j: usize) -> std::cmp::Ordering {
        let coordinates = self.points[i].iter().zip(&self.points[j]);
        let attributes = self.attributes_of(i).iter().zip(self.attributes_of(j));
        coordinates
            .map(|(x, y)| x.total_cmp(y))
            .chain(attributes.map(|(x, y)| x.total_cmp(y)))
            .find(|order| order.is_ne())
            .unwrap_or(std::cmp::Ordering::Equal)
    }

    fn attributes_of(&self, i: usize) -> &[f32] {
        &self.attributes[i * self.stride..(i + 1) * self.stride]
    }

    /// Drops the axis along which the normal is longest; x, y stay in an order that keeps the
    /// turning direction for a normal that points up that axis.
    fn project(&mut self, normal: Point) {
        let [x, y, z] = normal.map(f64::abs);
        let (u, v) = if z >= x && z >= y {
            (0, 1)
        } else if x >= y {
            (1, 2)
        } else {
            (2, 0)
        };
        self.flat.extend(self.points.iter().map(|point| [point[u], point[v]]));
    }

    fn is_convex(&mut self, diagonal: f64) -> bool {
        turns_one_way_once(&self.flat) || self.hugs_its_hull(TOLERANCE * diagonal)
    }

    /// Does every vertex lie within `tolerance` of the edge of the convex hull that it is to
    /// be on, one after the other?
    ///
    /// Six digits in a file make vertices on a straight side turn the wrong way by a hair. How
    /// much each of them turns does not tell a hair from a finely divided crescent; the
    /// distance from the hull does.
    fn hugs_its_hull(&mut self, tolerance: f64) -> bool {
        convex_hull(&self.flat, &mut self.hull);
        let points = &self.flat;
        let n = points.len();
        let &[first, _, _, ..] = self.hull.as_slice() else { return false };
        // The hull is counter-clockwise; walk the face so too.
        let backwards = signed_area(points) < 0.0;
        let step = |i: usize| if backwards { (i + n - 1) % n } else { (i + 1) % n };
        let mut at = first;
        let mut walked = 0;
        for (k, &corner) in self.hull.iter().enumerate() {
            let next = self.hull[(k + 1) % self.hull.len()];
            let (from, to) = (points[corner], points[next]);
            let along = [to[0] - from[0], to[1] - from[1]];
            let side = (along[0] * along[0] + along[1] * along[1]).sqrt();
            let mut reached = 0.0;
            while at != next {
                at = step(at);
                walked += 1;
                if walked > n {
                    return false;
                }
                let d = [points[at][0] - from[0], points[at][1] - from[1]];
                let forward = (d[0] * along[0] + d[1] * along[1]) / side;
                let inside = (along[0] * d[1] - along[1] * d[0]) / side;
                let on_edge = inside <= tolerance
                    && forward >= reached - tolerance
                    && forward <= side + tolerance;
                if !on_edge {
                    return false;
                }
                reached = forward.max(reached);
            }
        }
        walked == n
    }

    /// Is each attribute within the tolerance of the affine function through a, b and c?
    fn is_affine(&self, plane: &Plane) -> bool {
        let Plane { a, b, c, normal } = *plane;
        let square = dot(normal, normal);
        let (ab, ac) = (sub(self.points[b], self.points[a]), sub(self.points[c], self.points[a]));
        (0..self.stride).all(|k| {
            let value = |i: usize| f64::from(self.attributes[i * self.stride + k]);
            let all = 0..self.points.len();
            let least = all.clone().map(value).fold(f64::INFINITY, f64::min);
            let greatest = all.clone().map(value).fold(f64::NEG_INFINITY, f64::max);
            let allowed = TOLERANCE * (greatest - least);
            all.clone().all(|i| {
                let d = sub(self.points[i], self.points[a]);
                let along_b = dot(cross(d, ac), normal) / square;
                let along_c = dot(cross(ab, d), normal) / square;
                let affine =
                    value(a) + along_b * (value(b) - value(a)) + along_c * (value(c) - value(a));
                let off = (value(i) - affine).abs();
                // A NaN spoils its own attribute, but makes no fan of the face.
                off <= allowed || off.is_nan()
            })
        })
    }
}

/// The plane through vertices a, b and c.
#[derive(Clone, Copy, Debug)]
struct Plane {
    a: usize,
    b: usize,
    c: usize,
    /// (b - a) x (c - a)
    normal: Point,
}

/// The greatest power of two that is not above `x`, which is positive and finite; the least
/// normal number for a subnormal one.
fn power_of_two_below(x: f64) -> f64 {
    const EXPONENT: u64 = 0x7FF << 52;
    f64::from_bits(x.to_bits() & EXPONENT).max(f64::MIN_POSITIVE)
}

fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is found out about a face at `points`, whatever vertex its list begins with, and
    /// wherever and however large it is.
    fn judge(points: &[[f64; 3]], attributes: &[f32]) -> Verdict {
        let stride = attributes.len() / points.len();
        let mut judge = Judge::default();
        let mut of = |turn: usize, backwards: bool, scale: f64, shift: f64| {
            let mut order: Vec<usize> =
                (0..points.len()).map(|i| (i + turn) % points.len()).collect();
            if backwards {
                order.reverse();
            }
            let positions = order.iter().map(|i| points[*i].map(|x| x * scale + shift));
            let values = order.iter().flat_map(|i| &attributes[i * stride..(i + 1) * stride]);
            judge.judge(positions, values.copied(), stride)
        };
        let verdict = of(0, false, 1.0, 0.0);
        for turn in 0..points.len() {
            for scale in [1.0, 1e-150, 1e300] {
                assert_eq!(of(turn, false, scale, 0.0), verdict);
                assert_eq!(of(turn, true, scale, 0.0), verdict);
            }
            assert_eq!(of(turn, false, 1.0, 64.0), verdict);
        }
        verdict
    }

    fn flat(points: &[[f64; 2]]) -> Vec<[f64; 3]> {
        points.iter().map(|[x, y]| [*x, *y, 0.5 * x - 0.25 * y]).collect()
    }

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];

    #[test]
    fn faces_flat_or_not() {
        let mut square = flat(&SQUARE);
        let good =
            Verdict { finite: true, degenerate: false, flat: true, convex: true, affine: true };
        assert_eq!(judge(&square, &[]), good);
        square[2][2] += 0.001;
        assert_eq!(judge(&square, &[]), good, "within 1/1024 of the diagonal");
        square[2][2] += 0.1;
        assert!(!judge(&square, &[]).flat);
        square[1][0] = f64::NAN;
        let mut judge = Judge::default();
        assert!(!judge.judge(square.iter().copied(), [].into_iter(), 0).finite);
    }

    #[test]
    fn faces_convex_or_not() {
        let convex = |points: &[[f64; 2]]| judge(&flat(points), &[]).convex;
        assert!(convex(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]));
        assert!(convex(&[[0.0, 0.0], [1.0, 1e-6], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]));
        assert!(!convex(&[[0.0, 0.0], [1.0, 0.1], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]));
        assert!(convex(&[[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]));
        // A bow tie, a spike, a pentagram.
        assert!(!convex(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]));
        assert!(!convex(&[[0.0, 0.0], [2.0, 0.0], [3.0, 0.0], [2.0, 0.0], [1.0, 2.0]]));
        let star = |i: i32| {
            let angle = f64::from(i * 2) * 0.4 * std::f64::consts::PI;
            [angle.cos(), angle.sin()]
        };
        assert!(!convex(&(0..5).map(star).collect::<Vec<_>>()));
    }

    #[test]
    fn faces_round_to_six_digits_stay_convex_and_crescents_do_not_become_so() {
        let arc = |n: u32, radius: f64, round: f64| {
            (0..n).map(move |i| {
                let angle = f64::from(i) / f64::from(n) * std::f64::consts::PI;
                [angle.cos(), radius * angle.sin()].map(|x| (x * round).round() / round)
            })
        };
        let half = || arc(5000, 1.0, 1e6);
        let disc: Vec<_> = half().chain(half().map(|[x, y]| [-x, -y])).collect();
        let mut judge = Judge::default();
        let mut of =
            |points: &[[f64; 2]]| judge.judge(flat(points).into_iter(), [].into_iter(), 0).convex;
        assert!(of(&disc));
        let mut crescent: Vec<_> = arc(5000, 1.0, 1e12).collect();
        crescent.extend(arc(5000, 0.5, 1e12).collect::<Vec<_>>().into_iter().rev());
        assert!(!of(&crescent));
    }

    /// A fuzzer's: coordinates were rounded from the first vertex on.
    #[test]
    fn faces_are_judged_the_same_from_any_vertex() {
        let far = -1.9260101025109388e27;
        let points = [
            [0.0, 0.0, far],
            [0.0, 2.9e-26, far],
            [-10.125, 12.75, 12.0],
            [-11.25, -14.5, 12.5],
            [10.875, -15.375, -8.125],
            [0.25, -4.125, -9.5],
            [-4.9e26, 1.7e-218, -1.8e15],
        ];
        let mut judge = Judge::default();
        let mut from = |first: usize| {
            let list = points.iter().cycle().skip(first).take(points.len()).copied();
            judge.judge(list, [].into_iter(), 0);
            let mut places = judge.points.clone();
            places.rotate_right(first);
            places
        };
        assert!((1..points.len()).all(|first| from(first) == from(0)));
    }

    #[test]
    fn faces_without_area() {
        for points in [
            [[0.0, 0.0], [0.1, 0.1], [0.3, 0.3], [0.7, 0.7]],
            [[1.0, 1.0]; 4],
            [[0.0, 0.0], [1.0, 3.0], [0.0, 0.0], [1.0, 3.0]],
        ] {
            assert!(judge(&flat(&points), &[]).degenerate);
        }
    }

    #[test]
    fn attributes_affine_or_not() {
        let affine = |values: &[f32]| judge(&flat(&SQUARE), values).affine;
        assert!(affine(&[0.0, 1.0, 3.0, 2.0]));
        assert!(affine(&[0.0, 1.0, 3.001, 2.0]), "within 1/1024 of the range");
        assert!(!affine(&[0.0, 1.0, 3.1, 2.0]));
        assert!(!affine(&[0.0, 0.0, 1.0, 1.0, 3.0, 0.0, 2.0, 1.0]));
        assert!(affine(&[5.0; 8]));
        assert!(affine(&[0.0, f32::NAN, 3.0, 2.0]));
    }

    #[test]
    fn normals_point_to_the_front() {
        let mut judge = Judge::default();
        let mut of = |points: [[f64; 3]; 3]| judge.unit_normal(points.into_iter());
        assert_eq!(of([[0.0; 3], [9.0, 0.0, 0.0], [0.0, 1e-3, 0.0]]), [0.0, 0.0, 1.0]);
        // A fuzzer's: squares of its area are subnormal.
        assert_eq!(of([[0.0; 3], [9.0, 0.0, 0.0], [0.0, 3e-162, 4e-162]]), [0.0, -0.8, 0.6]);
        assert_eq!(
            of([[1e300, 0.0, 0.0], [1e300, 0.0, 1e300], [1e300, 1e300, 0.0]]),
            [-1.0, 0.0, 0.0]
        );
        assert_eq!(of([[1.0; 3]; 3]), [0.0; 3]);
    }
}
