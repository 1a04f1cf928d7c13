//! The right values of a flat polygon with affine attributes (P2 of docs/design.md), with a bound
//! of their own error. Shares no code with the library but its viewport.
//!
//! The centre of a pixel goes back to normalised device coordinates v = (X, Y, 1), and by the
//! inverse of the matrix M with the columns p = (x, y, w) of three vertices to their weights
//! l = M^-1 v. Then 1/w = sum l, z/w = sum l z, s = sum l s / sum l. All of them are quotients of
//! functions that are affine in the framebuffer, whose coefficients are found without any error;
//! a pixel's values are found in pairs of `f64`, or where these lose too much to cancellation,
//! without error but for the quotient.

mod expansion;
pub(crate) mod run;
mod sides;

use std::cmp::Ordering;

use hyperspan::space::{DepthRange, Viewport};

use expansion::{Expansion, PAIR_ERROR, Pair};

/// A value as a pair of `f64`, and a bound of its error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Value {
    pub(crate) high: f64,
    pub(crate) low: f64,
    pub(crate) error: f64,
}

impl Value {
    /// How far `computed` is from it, in units of the last place of `f32` at the right value.
    pub(crate) fn ulp(self, computed: f32) -> f64 {
        self.distance(computed) / self.unit()
    }

    /// The unit of the last place of `f32` there: the distance of neighbours, and never below
    /// the least subnormal.
    pub(crate) fn unit(self) -> f64 {
        const LEAST_EXPONENT: u64 = 1023 - 126;
        // The low part decides only if the high one is a power of two.
        let nearer_zero = self.low != 0.0 && (self.low < 0.0) == (self.high > 0.0);
        let bits = self.high.abs().to_bits() - u64::from(nearer_zero);
        f64::from_bits(((bits >> 52).max(LEAST_EXPONENT) - 23) << 52)
    }

    /// |`computed` - value|, rounded to `f64`; what is no number is infinitely far.
    pub(crate) fn distance(self, computed: f32) -> f64 {
        // Exact wherever they are near each other.
        let off = (f64::from(computed) - self.high - self.low).abs();
        if off.is_nan() { f64::INFINITY } else { off }
    }

    /// Exactly `value`.
    fn exactly(value: f64) -> Self {
        Self { high: value, low: 0.0, error: 0.0 }
    }

    /// `n` / `d`, each with a bound of its error.
    fn quotient((n, off_n): (Pair, f64), (d, off_d): (Pair, f64)) -> Self {
        const ROOM: f64 = 1.01;
        let Pair { high, low } = n.over(d);
        let size = high.abs();
        let error = ROOM * ((off_n + size * off_d) / d.high.abs() + 4.0 * PAIR_ERROR * size);
        Self { high, low, error }
    }

    /// The nearest within `least..=most`, which are themselves exact.
    fn clamped(self, least: f64, most: f64) -> Self {
        let beyond = |end: f64| (self.high - end) + self.low;
        let (below, above) = (-beyond(least), beyond(most));
        let end = |end: f64, by: f64| match by > self.error {
            true => Self::exactly(end),
            false => Self { high: end, low: 0.0, ..self },
        };
        match () {
            () if least == most => Self::exactly(least),
            () if below > 0.0 => end(least, below),
            () if above > 0.0 => end(most, above),
            () => self,
        }
    }

    fn scaled(self, power: f64) -> Self {
        let Pair { high, low } = Pair { high: self.high, low: self.low }.scaled(power);
        Self { high, low, error: self.error * power }
    }

    fn pair(self) -> (Pair, f64) {
        (Pair { high: self.high, low: self.low }, self.error)
    }
}

/// a i + b j + c k for whole numbers i, j, k that tell the pixel.
#[derive(Clone, Debug)]
struct Function {
    coefficients: [Expansion; 3],
    pairs: [Pair; 3],
}

impl Function {
    fn new(coefficients: [Expansion; 3]) -> Self {
        Self { pairs: coefficients.each_ref().map(Expansion::pair), coefficients }
    }

    /// The value, and a bound of its error: at most 2^-60 of it.
    fn at(&self, place: [f64; 3]) -> (Pair, f64) {
        const ENOUGH: f64 = 1.0 / (1_u64 << 60) as f64;
        let terms = [0, 1, 2].map(|i| self.pairs[i].times(place[i]));
        let size: f64 = terms.iter().map(|term| term.high.abs()).sum();
        let value = terms[0].plus(terms[1]).plus(terms[2]);
        let error = 6.0 * PAIR_ERROR * size;
        if error <= ENOUGH * value.high.abs() {
            return (value, error);
        }
        let terms = [0, 1, 2].map(|i| self.coefficients[i].times(place[i]));
        let [a, b, c] = terms;
        let value = a.plus(&b).plus(&c).pair();
        (value, PAIR_ERROR * value.high.abs())
    }
}

/// An attribute: its numerator over that of 1/w, and its range over the vertices.
#[derive(Clone, Debug)]
struct Attribute {
    numerator: Function,
    range: [f64; 2],
}

/// The right values of one polygon, at every pixel.
#[derive(Clone, Debug)]
pub(crate) struct Reference {
    viewport: Viewport,
    /// (x, y, w) of the vertices, and the power of two that they are multiplied by.
    points: Vec<[f64; 3]>,
    scale: f64,
    /// det/w, where det is the determinant of M times the area of the viewport: above 0.
    inv_w: Function,
    determinant: (Pair, f64),
    /// det times depth.
    depth: Function,
    attributes: Vec<Attribute>,
    /// Nothing of the polygon lies beyond a plane of the view volume or of the guard band.
    is_whole: bool,
}

impl Reference {
    /// The reference of a flat polygon with positions (x, y, z, w) in clip space, at least three,
    /// and attributes `attributes[vertex][k]` with perspective that are affine on it. Nothing
    /// if it is seen edge-on, or not finite, or has coordinates more than 2^200 apart.
    pub(crate) fn new(
        positions: &[[f64; 4]],
        attributes: &[Vec<f32>],
        viewport: &Viewport,
    ) -> Option<Self> {
        let largest = positions.iter().flatten().map(|c| c.abs()).fold(0.0, f64::max);
        let finite = attributes.iter().flatten().all(|s| s.is_finite())
            && positions.iter().flatten().all(|c| c.is_finite());
        let has_pixels = viewport.width() > 0 && viewport.height() > 0;
        if !finite || !has_pixels || positions.len() < 3 || attributes.len() != positions.len() {
            return None;
        }
        let scale = power_that_brings_to_one(largest);
        let scaled: Vec<[f64; 4]> = positions.iter().map(|p| p.map(|c| c * scale)).collect();
        // Whatever is made of them below stays far from underflow.
        const LEAST: f64 = 1.0 / (1_u128 << 100) as f64 / (1_u128 << 100) as f64;
        if scaled.iter().flatten().any(|c| *c != 0.0 && c.abs() < LEAST) {
            return None;
        }
        let points: Vec<[f64; 3]> = scaled.iter().map(|&[x, y, _, w]| [x, y, w]).collect();
        let triple = choose(&scaled, attributes, &points);
        let [a, b, c] = triple.map(|i| points[i]);
        let mut adjugate = [cross(b, c), cross(c, a), cross(a, b)];
        let mut determinant = dot(&adjugate[0], a);
        match determinant.sign() {
            Ordering::Equal => return None,
            Ordering::Less => {
                adjugate = adjugate.map(|row| row.map(|e| e.times(-1.0)));
                determinant = determinant.times(-1.0);
            }
            Ordering::Greater => {}
        }
        // The sum over the three vertices of weight times value, as a function of the pixel.
        let mean = |values: [f64; 3]| {
            [0, 1, 2].map(|i| {
                let terms = (0..3).map(|k| adjugate[k][i].times(values[k]));
                terms.fold(Expansion::default(), |sum, term| sum.plus(&term))
            })
        };
        let mut depth = mean(triple.map(|i| scaled[i][2]));
        if viewport.depth_range() == DepthRange::MinusOneToOne {
            depth[2] = depth[2].clone().plus(&determinant);
            depth = depth.map(|e| e.times(0.5));
        }
        let area = f64::from(viewport.width()) * f64::from(viewport.height());
        let determinant = determinant.times(area).pair();
        let of_attribute = |k: usize| {
            let values = || attributes.iter().map(|list| f64::from(list[k]));
            let range = [
                values().fold(f64::INFINITY, f64::min),
                values().fold(f64::NEG_INFINITY, f64::max),
            ];
            let numerator = Function::new(mean(triple.map(|i| f64::from(attributes[i][k]))));
            Attribute { numerator, range }
        };
        Some(Self {
            viewport: *viewport,
            scale,
            inv_w: Function::new(mean([1.0; 3])),
            determinant: (determinant, PAIR_ERROR * determinant.high),
            depth: Function::new(depth),
            attributes: (0..attributes[0].len()).map(of_attribute).collect(),
            is_whole: scaled.iter().all(|p| is_surely_inside(*p, viewport)),
            points,
        })
    }

    /// Attribute `k` at the centre of pixel (`x`, `y`) of the framebuffer, clamped to the vertices'
    /// range. Nothing where the plane does not reach, 1/w <= 0.
    pub(crate) fn attribute(&self, k: usize, x: i32, y: i32) -> Option<Value> {
        let Attribute { numerator, range: [least, most] } = &self.attributes[k];
        let place = self.place(x, y);
        let value = Value::quotient(numerator.at(place), self.positive_inv_w(place)?);
        Some(value.clamped(*least, *most))
    }

    /// Depth, 0 to 1. Nothing where the plane does not reach.
    pub(crate) fn depth(&self, x: i32, y: i32) -> Option<Value> {
        let place = self.place(x, y);
        self.positive_inv_w(place)?;
        Some(Value::quotient(self.depth.at(place), self.determinant).clamped(0.0, 1.0))
    }

    /// 1/w. Nothing where the plane does not reach, nor at the rim of a polygon that is clipped:
    /// it is clamped to its range over what is left, which is not known here.
    pub(crate) fn inv_w(&self, x: i32, y: i32) -> Option<Value> {
        let place = self.place(x, y);
        let value = Value::quotient(self.positive_inv_w(place)?, self.determinant);
        if !self.is_whole {
            let depth = Value::quotient(self.depth.at(place), self.determinant).high;
            let seen = 0.0 < depth && depth < 1.0 && self.is_surely_within(place);
            return seen.then(|| value.scaled(self.scale));
        }
        let w = || self.points.iter().map(|p| p[2]);
        let (nearest, farthest) = (w().fold(f64::INFINITY, f64::min), w().fold(0.0, f64::max));
        let end = |w: f64| Value::quotient((Pair::of(1.0), 0.0), (Pair::of(w), 0.0));
        let over = |a: Value, b: Value| (a.high - b.high) + (a.low - b.low);
        let (least, most) = (end(farthest), end(nearest));
        let kept = |end: Value, by: f64| {
            let doubt = if by > value.error + end.error { 0.0 } else { value.error };
            Value { error: doubt + end.error, ..end }
        };
        let kept = match (over(least, value), over(value, most)) {
            (below, _) if below > 0.0 => kept(least, below),
            (_, above) if above > 0.0 => kept(most, above),
            _ => value,
        };
        Some(kept.scaled(self.scale))
    }

    /// w, wherever 1/w is known.
    pub(crate) fn w(&self, x: i32, y: i32) -> Option<Value> {
        Some(Value::quotient((Pair::of(1.0), 0.0), self.inv_w(x, y)?.pair()))
    }

    /// What functions are evaluated at for pixel (`x`, `y`): its centre in normalised device
    /// coordinates, (X, Y, 1), times the area of the viewport: whole numbers.
    fn place(&self, x: i32, y: i32) -> [f64; 3] {
        let (rect, width, height) =
            (self.viewport.rect(), self.viewport.width(), self.viewport.height());
        let [width, height] = [width, height].map(f64::from);
        let across = 2.0 * (f64::from(x) - f64::from(rect.x0)) + 1.0 - width;
        let up = height - 2.0 * (f64::from(y) - f64::from(rect.y0)) - 1.0;
        [across * height, up * width, width * height]
    }

    fn positive_inv_w(&self, place: [f64; 3]) -> Option<(Pair, f64)> {
        Some(self.inv_w.at(place)).filter(|(value, _)| value.high > 0.0)
    }

    /// Is the centre inside the polygon as given, farther from its edges than `f64` may be off?
    fn is_surely_within(&self, place: [f64; 3]) -> bool {
        // Of the products' sum: each minor is off by 3, a product and the sums by 4 times 2^-53.
        const ERROR: f64 = 1.0 / (1_u64 << 48) as f64;
        let side = |i: usize| {
            let [a, b] = [self.points[i], self.points[(i + 1) % self.points.len()]];
            let terms = |i: usize, j: usize| [a[i] * b[j], -a[j] * b[i]];
            let minors = [terms(1, 2), terms(2, 0), terms(0, 1)];
            let sum = |size: fn(f64) -> f64| -> f64 {
                (0..3).map(|i| (size(minors[i][0]) + size(minors[i][1])) * size(place[i])).sum()
            };
            let value = sum(|c| c);
            if value.abs() > ERROR * sum(f64::abs) { value.signum() } else { 0.0 }
        };
        let first = side(0);
        first != 0.0 && (1..self.points.len()).all(|i| side(i) == first)
    }
}

/// The power of two that brings `value` into 1..2 (or as near as there is one).
fn power_that_brings_to_one(value: f64) -> f64 {
    f64::from_bits((2046 - (value.to_bits() >> 52)).max(1) << 52)
}

/// Is a vertex within near and far, and at least a pixel within the guard band?
fn is_surely_inside([x, y, z, w]: [f64; 4], viewport: &Viewport) -> bool {
    const REACH: f64 = 32766.0;
    let near = if viewport.depth_range() == DepthRange::ZeroToOne { 0.0 } else { -w };
    let pixel = |ndc: f64, side: u32| (ndc + 1.0) * f64::from(side) / 2.0;
    w > 0.0
        && near <= z
        && z <= w
        && pixel(x / w, viewport.width()).abs() < REACH
        && pixel(-y / w, viewport.height()).abs() < REACH
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [Expansion; 3] {
    let product = |a: f64, b: f64| Expansion::of(a).times(b);
    let minor = |i: usize, j: usize| product(a[i], b[j]).plus(&product(-a[j], b[i]));
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn dot(a: &[Expansion; 3], b: [f64; 3]) -> Expansion {
    a[0].times(b[0]).plus(&a[1].times(b[1])).plus(&a[2].times(b[2]))
}

/// The vertices a, b, c that P2 takes the plane from: the least, the one that maximises |a x p|,
/// the one that maximises |det(a, b, p)|; ties to the least.
fn choose(positions: &[[f64; 4]], attributes: &[Vec<f32>], points: &[[f64; 3]]) -> [usize; 3] {
    if points.len() == 3 {
        return [0, 1, 2];
    }
    let key = |i: usize| {
        let list = attributes[i].iter().map(|s| f64::from(*s));
        positions[i].into_iter().chain(list)
    };
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&i, &j| key(i).partial_cmp(key(j)).unwrap_or(Ordering::Equal));
    let a = order[0];
    let normals: Vec<[Expansion; 3]> = points.iter().map(|p| cross(points[a], *p)).collect();
    let b = largest(
        &order,
        |i| normals[i].iter().map(|e| e.pair().high * e.pair().high).sum(),
        |i| normals[i].iter().fold(Expansion::default(), |sum, e| sum.plus(&e.by(e))),
    );
    let volumes: Vec<Expansion> = points.iter().map(|p| dot(&normals[b], *p)).collect();
    let squared = |i: usize| volumes[i].by(&volumes[i]);
    let c = largest(&order, |i| volumes[i].pair().high * volumes[i].pair().high, squared);
    [a, b, c]
}

/// The first in `order` of the largest; `about` is the size, as good as `f64` has it.
fn largest(
    order: &[usize],
    about: impl Fn(usize) -> f64,
    exactly: impl Fn(usize) -> Expansion,
) -> usize {
    const SURELY: f64 = 1.0 - 1e-12;
    let sizes: Vec<f64> = order.iter().map(|i| about(*i)).collect();
    let most = sizes.iter().copied().fold(0.0, f64::max);
    let mut near = order.iter().zip(&sizes).filter(|(_, size)| **size >= most * SURELY);
    let first = near.next().map_or(order[0], |(i, _)| *i);
    near.fold(first, |best, (next, _)| {
        let more = exactly(*next).plus(&exactly(best).times(-1.0));
        if more.sign() == Ordering::Greater { *next } else { best }
    })
}
