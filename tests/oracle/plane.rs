//! P2: the right value at a pixel of a flat polygon, through the inverse of the transform.
//!
//! The centre of the pixel goes back to normalised device coordinates (X, Y, 1), and these, as
//! M (la, lb, lc), to weights of three vertices; M has the columns p = (x, y, w) of the three.
//! Everything follows: 1/w = sum l, z/w = sum l z, s = sum l s / sum l. All in rationals.

pub(crate) mod quick;

use hyperspan::space::{DepthRange, Viewport};
use hyperspan::varying::{CANONICAL_NAN, Interpolation};

use super::Poly;
use super::clipper::{self, Corner};
use super::exact::{Q, approximate, fraction, power_of_two, q, round_to_f32, sum};

type Vector = [Q; 3];

fn cross(a: &Vector, b: &Vector) -> Vector {
    let minor = |i: usize, j: usize| &a[i] * &b[j] - &a[j] * &b[i];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn dot(a: &Vector, b: &Vector) -> Q {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn magnitude(value: Q) -> Q {
    if value < Q::ZERO { -value } else { value }
}

/// (least, greatest).
pub(crate) fn range(values: &[Q]) -> (Q, Q) {
    let extreme = |least: bool| values.iter().reduce(|a, b| if (b < a) == least { b } else { a });
    let take = |least: bool| extreme(least).expect("a value").clone();
    (take(true), take(false))
}

pub(crate) fn clamp(value: Q, (low, high): &(Q, Q)) -> Q {
    value.max(low.clone()).min(high.clone())
}

/// The right values of one polygon, at every pixel.
pub(crate) struct Plane {
    positions: Vec<[Q; 4]>,
    viewport: Viewport,
    /// Vertices a, b, c of P2.
    triple: [usize; 3],
    /// det M, and the rows of its adjugate: M^-1 = adjugate / determinant.
    determinant: Q,
    adjugate: [Vector; 3],
    flat: bool,
    attributes: Vec<Attribute>,
    /// What is left within the planes, without corners at w = 0, and the range of 1/w there.
    clipped: Vec<Corner>,
    inv_w_range: (Q, Q),
}

/// What an attribute is over a polygon.
enum Attribute {
    /// The same all over.
    Same(f32),
    /// Affine on the plane, or, if `linear`, in the framebuffer.
    Affine { values: Vec<Q>, range: (Q, Q), linear: bool },
    /// Runs along edges and across spans.
    Across,
    /// With an infinity at a vertex.
    Undefined,
}

/// What is right for a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Right {
    /// This, bit for bit.
    Is(f32),
    /// It is not the plane that says it: see `edges`.
    Across,
    /// No promise.
    Anything,
}

impl Plane {
    /// The oracle of a polygon of at least three vertices, all finite. Attributes beyond the
    /// list of interpolations have perspective.
    pub(crate) fn new(poly: &Poly, viewport: Viewport, listed: &[Interpolation]) -> Self {
        let positions: Vec<[Q; 4]> = poly.positions.iter().map(|p| p.map(q)).collect();
        let points: Vec<Vector> = positions.iter().map(in_plane).collect();
        let triple = choose(poly, &points);
        let [a, b, c] = triple.map(|i| &points[i]);
        let determinant = dot(a, &cross(b, c));
        let adjugate = [cross(b, c), cross(c, a), cross(a, b)];
        let flat = points.len() == 3 || is_flat(&positions, triple);
        let mut clipped = clipper::clip(poly, &clipper::planes(viewport));
        clipped.retain(|corner| corner.position[3] != Q::ZERO);
        let mut inv_w: Vec<Q> = clipped.iter().map(|c| Q::ONE / &c.position[3]).collect();
        inv_w.extend(clipped.is_empty().then_some(Q::ONE));
        let mut plane = Self {
            positions,
            viewport,
            triple,
            determinant,
            adjugate,
            flat,
            attributes: Vec::new(),
            clipped,
            inv_w_range: range(&inv_w),
        };
        for k in 0..poly.attributes[0].len() {
            let given: Vec<f32> = poly.attributes.iter().map(|a| a[k]).collect();
            let mode = listed.get(k).copied().unwrap_or_default();
            plane.attributes.push(plane.judge(&given, mode));
        }
        plane
    }

    /// Is the polygon flat by P2's rule?
    pub(crate) fn is_flat(&self) -> bool {
        self.flat
    }

    /// How far the three vertices of the plane are from a line: the sine at the first of them, of
    /// (x, y, w). Where it is next to 0, `f64` cannot say how flat the polygon is.
    pub(crate) fn sine(&self) -> f64 {
        let [a, b, c] = self.triple.map(|i| in_plane(&self.positions[i]));
        let side = |p: &Vector| [0, 1, 2].map(|i| &p[i] - &a[i]);
        let (e, f) = (side(&b), side(&c));
        let sides = dot(&e, &e) * dot(&f, &f);
        let normal = cross(&e, &f);
        if sides == Q::ZERO { 0.0 } else { approximate(&(dot(&normal, &normal) / sides)).sqrt() }
    }

    /// Is its plane seen from the side?
    pub(crate) fn is_edge_on(&self) -> bool {
        self.determinant == Q::ZERO
    }

    fn judge(&self, given: &[f32], mode: Interpolation) -> Attribute {
        let canonical = |s: f32| if s.is_nan() { CANONICAL_NAN } else { s };
        let same = given.iter().all(|s| s.to_bits() == given[0].to_bits());
        if mode == Interpolation::Flat || same {
            return Attribute::Same(canonical(given[0]));
        }
        if given.iter().any(|s| s.is_nan()) {
            return Attribute::Same(CANONICAL_NAN);
        }
        if given.iter().any(|s| s.is_infinite()) {
            return Attribute::Undefined;
        }
        let values: Vec<Q> = given.iter().map(|s| q(f64::from(*s))).collect();
        let affine = match mode {
            Interpolation::NoPerspective => {
                // In the framebuffer, if all of the polygon lies in front of the eye.
                let in_front = self.positions.iter().all(|p| p[3] > Q::ZERO);
                let place = |[x, y, _, w]: &[Q; 4]| [x / w, y / w, Q::ONE];
                in_front && self.is_affine(&values, place)
            }
            _ => self.flat && self.is_affine(&values, in_plane),
        };
        if !affine {
            return Attribute::Across;
        }
        let linear = mode == Interpolation::NoPerspective;
        Attribute::Affine { range: range(&values), values, linear }
    }

    /// Do the values at the vertices, which lie at `place`, belong to an affine function? Every
    /// one must lie within 2^-10 of their range from the function through the triple.
    fn is_affine(&self, values: &[Q], place: impl Fn(&[Q; 4]) -> Vector) -> bool {
        let points: Vec<Vector> = self.positions.iter().map(place).collect();
        let (low, high) = range(values);
        let tolerance = power_of_two(-10) * (high - low);
        let off = |i: usize| Some(deviation(&points, self.triple, values, i)?.0);
        points.len() == 3 || (0..points.len()).all(|i| off(i).is_none_or(|off| off <= tolerance))
    }

    /// M^-1 p, times det M, so that values are divided by it, and not their parts.
    fn weights(&self, p: &Vector) -> Vector {
        [0, 1, 2].map(|k| dot(&self.adjugate[k], p))
    }

    /// 1/w of the plane, from M^-1 p times det M.
    fn inv_w(&self, [a, b, c]: &Vector) -> Q {
        (a + b + c) / &self.determinant
    }

    /// The function that is `value` at vertex i and linear in the framebuffer, from the same.
    fn linear(&self, weights: &Vector, value: impl Fn(usize) -> Q) -> Q {
        dot(weights, &self.triple.map(value)) / &self.determinant
    }

    /// The values at the centre of pixel (`x`, `y`).
    pub(crate) fn at(&self, x: i32, y: i32) -> At<'_> {
        let (vx, vy) = (i64::from(self.viewport.rect().x0), i64::from(self.viewport.rect().y0));
        let (width, height) = (i64::from(self.viewport.width()), i64::from(self.viewport.height()));
        // ((x + 1/2) - (vx + W/2)) / (W/2), and downwards ((vy + H/2) - (y + 1/2)) / (H/2).
        let ndc = [
            fraction(2 * i64::from(x) + 1 - 2 * vx - width, width),
            fraction(2 * vy + height - 2 * i64::from(y) - 1, height),
            Q::ONE,
        ];
        if !self.is_edge_on() {
            let weights = self.weights(&ndc);
            if self.inv_w(&weights) > Q::ZERO {
                return At { plane: self, place: Place::Weights(weights) };
            }
        }
        let nearest = self.nearest(x, y).expect("something of the polygon is left");
        At { plane: self, place: Place::Corner(nearest) }
    }

    /// The clipped vertex that is nearest to the centre of pixel (`x`, `y`).
    fn nearest(&self, x: i32, y: i32) -> Option<&Corner> {
        let centre = [x, y].map(|c| fraction(2 * i64::from(c) + 1, 2));
        self.clipped.iter().min_by_key(|corner| {
            let place = corner.framebuffer(self.viewport).expect("w > 0");
            let d = [0, 1].map(|i| &place[i] - &centre[i]);
            &d[0] * &d[0] + &d[1] * &d[1]
        })
    }
}

fn in_plane([x, y, _, w]: &[Q; 4]) -> Vector {
    [x.clone(), y.clone(), w.clone()]
}

/// (a, b, c): the least vertex, the one that maximises |a x p|, the one that maximises
/// |det(a, b, p)|; ties to the least.
fn choose(poly: &Poly, points: &[Vector]) -> [usize; 3] {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let key = |i: usize| {
        let attributes = poly.attributes[i].iter().map(|s| f64::from(*s));
        poly.positions[i].into_iter().chain(attributes).collect::<Vec<_>>()
    };
    order.sort_by(|&i, &j| key(i).partial_cmp(&key(j)).unwrap_or(std::cmp::Ordering::Equal));
    // The first of the largest, in this order.
    let largest = |size: &dyn Fn(usize) -> Q| {
        let sizes = order.iter().map(|&i| (i, size(i)));
        sizes.reduce(|best, next| if next.1 > best.1 { next } else { best }).expect("a vertex").0
    };
    let a = order[0];
    let b = largest(&|i| {
        let normal = cross(&points[a], &points[i]);
        dot(&normal, &normal)
    });
    let c = largest(&|i| magnitude(dot(&cross(&points[a], &points[b]), &points[i])));
    [a, b, c]
}

/// By how much the value of vertex `i` is off the affine function through the triple's, and the
/// square of the vertex's distance from their plane, on which its foot is what counts. Points on
/// a line have no plane.
fn deviation(points: &[Vector], triple: [usize; 3], values: &[Q], i: usize) -> Option<(Q, Q)> {
    let minus = |a: &Vector, b: &Vector| [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]];
    let [a, b, c] = triple;
    let (e, f) = (minus(&points[b], &points[a]), minus(&points[c], &points[a]));
    let (normal, offset) = (cross(&e, &f), minus(&points[i], &points[a]));
    let squared = dot(&normal, &normal);
    if squared == Q::ZERO {
        return None;
    }
    let beta = dot(&normal, &cross(&offset, &f)) / &squared;
    let gamma = dot(&normal, &cross(&e, &offset)) / &squared;
    let height = dot(&normal, &offset);
    let value = beta * (&values[b] - &values[a]) + gamma * (&values[c] - &values[a]) + &values[a];
    Some((magnitude(value - &values[i]), &height * &height / squared))
}

/// Is every vertex within 2^-10 of the diameter of the plane through the triple, and z within as
/// much of the affine function through theirs?
fn is_flat(positions: &[[Q; 4]], triple: [usize; 3]) -> bool {
    let points: Vec<Vector> = positions.iter().map(in_plane).collect();
    let z: Vec<Q> = positions.iter().map(|p| p[2].clone()).collect();
    let side = |i: usize| {
        let (low, high) = range(&positions.iter().map(|p| p[i].clone()).collect::<Vec<_>>());
        high - low
    };
    let most = power_of_two(-20) * sum((0..4).map(|i| side(i) * side(i)));
    let within = |(off, distance): (Q, Q)| &off * &off <= most && distance <= most;
    (0..points.len()).all(|i| deviation(&points, triple, &z, i).is_none_or(within))
}

/// The right values at one pixel.
pub(crate) struct At<'a> {
    plane: &'a Plane,
    place: Place<'a>,
}

enum Place<'a> {
    /// M^-1 of the pixel's centre, times det M.
    Weights(Vector),
    /// The plane is edge-on or 1/w <= 0 here: the nearest clipped vertex.
    Corner(&'a Corner),
}

impl At<'_> {
    /// 1/w of the plane, before it is rounded.
    pub(crate) fn exact_inv_w(&self) -> Q {
        let inv_w = match &self.place {
            Place::Weights(l) => self.plane.inv_w(l),
            Place::Corner(corner) => Q::ONE / &corner.position[3],
        };
        clamp(inv_w, &self.plane.inv_w_range)
    }

    /// What is interpolated on the plane itself.
    fn if_flat(&self, value: impl FnOnce() -> Q) -> Right {
        if self.plane.flat { Right::Is(round_to_f32(&value())) } else { Right::Across }
    }

    /// 1/w.
    pub(crate) fn inv_w(&self) -> Right {
        self.if_flat(|| self.exact_inv_w())
    }

    /// w.
    pub(crate) fn w(&self) -> Right {
        self.if_flat(|| Q::ONE / self.exact_inv_w())
    }

    /// z/w, or (z/w + 1)/2.
    pub(crate) fn depth(&self) -> Right {
        self.if_flat(|| self.exact_depth())
    }

    /// Depth on the plane, before it is rounded.
    pub(crate) fn exact_depth(&self) -> Q {
        let range = self.plane.viewport.depth_range();
        let depth = match &self.place {
            Place::Weights(l) => {
                self.plane.linear(l, |i| depth_numerator(range, &self.plane.positions[i]))
            }
            Place::Corner(corner) => depth_numerator(range, &corner.position) / &corner.position[3],
        };
        clamp(depth, &(Q::ZERO, Q::ONE))
    }

    /// Attribute `k`.
    pub(crate) fn attribute(&self, k: usize) -> Right {
        match &self.plane.attributes[k] {
            Attribute::Same(value) => Right::Is(*value),
            Attribute::Across => Right::Across,
            Attribute::Undefined => Right::Anything,
            Attribute::Affine { values, range, linear } => {
                Right::Is(round_to_f32(&self.mean(values, range, *linear)))
            }
        }
    }

    /// Attribute `k` before it is rounded, where the plane says it.
    pub(crate) fn exact_attribute(&self, k: usize) -> Option<Q> {
        match &self.plane.attributes[k] {
            Attribute::Same(value) => Some(q(f64::from(*value))),
            Attribute::Affine { values, range, linear } => Some(self.mean(values, range, *linear)),
            Attribute::Across | Attribute::Undefined => None,
        }
    }

    fn mean(&self, values: &[Q], range: &(Q, Q), linear: bool) -> Q {
        let plane = self.plane;
        let mean = match &self.place {
            Place::Weights(l) if linear => plane.linear(l, |i| &values[i] * &plane.positions[i][3]),
            Place::Weights(l) => {
                // Whatever the weights are times.
                let [a, b, c] = plane.triple.map(|i| &values[i]);
                (&l[0] * a + &l[1] * b + &l[2] * c) / (&l[0] + &l[1] + &l[2])
            }
            Place::Corner(corner) => corner.mean(values, linear),
        };
        clamp(mean, range)
    }
}

/// What depth is times w.
pub(crate) fn depth_numerator(range: DepthRange, [_, _, z, w]: &[Q; 4]) -> Q {
    match range {
        DepthRange::ZeroToOne => z.clone(),
        DepthRange::MinusOneToOne => (z + w) / q(2.0),
    }
}
