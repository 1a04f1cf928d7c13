//! The right values of many pixels: in pairs of `f64`, with a bound of their error.
//!
//! Each value is a quotient of two functions that are affine in the framebuffer. Their
//! coefficients are found in rationals, at a pixel near those that are asked for, and kept as
//! pairs, about 105 bits. Where the bound leaves a doubt the caller asks [`Plane::at`].
//!
//! A pair operation is off by less than 2^-100 of its operands' magnitudes (Dekker 1971); `ERROR`
//! is a bound of the few that one value takes, with room.

use hyperspan::space::PixelRect;

use super::{Attribute, Plane, Q, depth_numerator, magnitude};
use crate::oracle::exact::{approximate, fraction, power_of_two, q, round_to_f32};

/// Of a sum's magnitude, or a quotient's.
const ERROR: f64 = 1.0 / (1_u128 << 95) as f64;

/// A sum that is not rounded: high part, low part.
#[derive(Clone, Copy, Debug)]
struct Pair(f64, f64);

impl Pair {
    fn of(value: &Q) -> Self {
        let high = approximate(value);
        Self(high, approximate(&(value - q(high))))
    }

    /// Exactly a + b.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let of_b = high - a;
        Self(high, (a - (high - of_b)) + (b - of_b))
    }

    /// Exactly a b: the factors' halves have products of 53 bits.
    fn product(a: f64, b: f64) -> Self {
        let halves = |c: f64| {
            let scaled = 134_217_729.0 * c;
            let high = scaled - (scaled - c);
            (high, c - high)
        };
        let (high, (a, al), (b, bl)) = (a * b, halves(a), halves(b));
        Self(high, al * bl - (((high - a * b) - al * b) - a * bl))
    }

    fn plus(self, other: Self) -> Self {
        let Self(high, low) = Self::sum(self.0, other.0);
        Self::sum(high, low + (self.1 + other.1))
    }

    fn times(self, factor: f64) -> Self {
        let Self(high, low) = Self::product(self.0, factor);
        Self::sum(high, low + self.1 * factor)
    }

    fn over(self, divisor: Self) -> Self {
        let mut quotient = Self(0.0, 0.0);
        let mut rest = self;
        for _ in 0..3 {
            let part = rest.0 / divisor.0;
            quotient = quotient.plus(Self(part, 0.0));
            rest = rest.plus(divisor.times(-part));
        }
        quotient
    }

    /// Rounded once to `f32`: by way of the `f64` that is odd, if it is not exact.
    fn to_f32(self) -> f32 {
        let Self(high, low) = self;
        let even = high.to_bits() & 1 == 0;
        let odd = match low.partial_cmp(&0.0) {
            Some(std::cmp::Ordering::Greater) if even => high.next_up(),
            Some(std::cmp::Ordering::Less) if even => high.next_down(),
            _ => high,
        };
        odd as f32
    }
}

/// a dx + b dy + c, all over 2^`exponent`; the largest of the three is about 1.
#[derive(Clone, Copy, Debug)]
struct Function {
    coefficients: [Pair; 3],
    exponent: i32,
}

impl Function {
    fn new(coefficients: &[Q; 3]) -> Self {
        let largest = coefficients.iter().map(|c| approximate(c).abs()).fold(0.0, f64::max);
        let exponent = if largest > 0.0 { largest.log2() as i32 } else { 0 };
        let scale = power_of_two(-exponent);
        Self { coefficients: [0, 1, 2].map(|i| Pair::of(&(&coefficients[i] * &scale))), exponent }
    }

    /// The value, and a bound of its error.
    fn at(&self, dx: f64, dy: f64) -> (Pair, f64) {
        let [a, b, c] = self.coefficients;
        let (along, down) = (a.times(dx), b.times(dy));
        let size = along.0.abs() + down.0.abs() + c.0.abs();
        (along.plus(down).plus(c), ERROR * size)
    }
}

/// What is interpolated: a quotient, clamped.
#[derive(Clone, Debug)]
struct Quotient {
    numerator: Function,
    denominator: Function,
    range: [f32; 2],
}

/// A value that is known well enough.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    /// Correctly rounded.
    pub(crate) rounded: f32,
    /// As an `f64`.
    pub(crate) value: f64,
}

impl Quotient {
    fn at(&self, dx: f64, dy: f64) -> Option<Known> {
        let ((n, off_n), (d, off_d)) = (self.numerator.at(dx, dy), self.denominator.at(dx, dy));
        if d.0 <= 1e6 * off_d {
            return None;
        }
        let value = n.over(d);
        let off = 1.01 * (off_n + value.0.abs() * off_d) / d.0 + ERROR * value.0.abs();
        let scale = f64::from(self.numerator.exponent - self.denominator.exponent).exp2();
        let Pair(high, low) = value;
        let near = |off: f64| Pair::sum(high * scale, (low + off) * scale).to_f32();
        let rounded = near(off);
        // Below, zeros and their signs would have to be told apart.
        if rounded.to_bits() != near(-off).to_bits() || rounded.abs() < 1e-38 {
            return None;
        }
        let [least, most] = self.range;
        let clamped = if rounded <= least { least } else { rounded.min(most) };
        let value = (high * scale).clamp(f64::from(least), f64::from(most));
        Some(Known { rounded: clamped, value })
    }
}

/// An attribute.
#[derive(Clone, Debug)]
enum Kind {
    Same(f32),
    Affine(Quotient),
    Other,
}

/// The values of a flat polygon near a window.
#[derive(Debug)]
pub(crate) struct Quick {
    origin: [i32; 2],
    /// 1/w; no value of the plane if it is not positive.
    inv_w: Quotient,
    depth: Quotient,
    attributes: Vec<Kind>,
}

impl Quick {
    /// Nothing for a polygon that is not flat, or edge-on.
    pub(crate) fn new(plane: &Plane, window: PixelRect) -> Option<Self> {
        if !plane.flat || plane.is_edge_on() {
            return None;
        }
        let rect = plane.viewport.rect();
        let (width, height) =
            (i64::from(plane.viewport.width()), i64::from(plane.viewport.height()));
        let [x, y] = [window.x0 - rect.x0, window.y0 - rect.y0].map(i64::from);
        let ndc = [fraction(2 * x + 1 - width, width), fraction(height - 2 * y - 1, height)];
        let steps = [fraction(2, width), fraction(-2, height)];
        // With the determinant's sign, so that the weights' sum is positive.
        let sign = if plane.determinant < Q::ZERO { q(-1.0) } else { Q::ONE };
        let determinant = magnitude(plane.determinant.clone());
        let weights = [0, 1, 2].map(|k| {
            let row = [0, 1, 2].map(|i| &plane.adjugate[k][i] * &sign);
            let here = &row[0] * &ndc[0] + &row[1] * &ndc[1] + &row[2];
            [&row[0] * &steps[0], &row[1] * &steps[1], here]
        });
        let function = |values: [Q; 3]| {
            Function::new(&[0, 1, 2].map(|i| {
                &weights[0][i] * &values[0]
                    + &weights[1][i] * &values[1]
                    + &weights[2][i] * &values[2]
            }))
        };
        let of = |values: &dyn Fn(usize) -> Q| function(plane.triple.map(values));
        let constant = Function::new(&[Q::ZERO, Q::ZERO, determinant]);
        let rounded = |(least, most): &(Q, Q)| [round_to_f32(least), round_to_f32(most)];
        let sum = of(&|_| Q::ONE);
        let depth_range = plane.viewport.depth_range();
        let attributes = plane.attributes.iter().map(|attribute| {
            let (values, range, linear) = match attribute {
                Attribute::Same(value) => return Kind::Same(*value),
                Attribute::Affine { values, range, linear } => (values, range, *linear),
                Attribute::Across | Attribute::Undefined => return Kind::Other,
            };
            let value = |i: usize| {
                let w = if linear { plane.positions[i][3].clone() } else { Q::ONE };
                &values[i] * w
            };
            let denominator = if linear { constant } else { sum };
            Kind::Affine(Quotient { numerator: of(&value), denominator, range: rounded(range) })
        });
        Some(Self {
            origin: [window.x0, window.y0],
            inv_w: Quotient {
                numerator: sum,
                denominator: constant,
                range: rounded(&plane.inv_w_range),
            },
            depth: Quotient {
                numerator: of(&|i| depth_numerator(depth_range, &plane.positions[i])),
                denominator: constant,
                range: [0.0, 1.0],
            },
            attributes: attributes.collect(),
        })
    }

    /// 1/w, depth and the attributes at pixel (`x`, `y`), as far as they are known. Nothing at
    /// all where 1/w may not be positive: there it is not the plane that counts.
    pub(crate) fn at(&self, x: i32, y: i32) -> Option<impl Iterator<Item = Option<Known>> + '_> {
        let [dx, dy] = [x - self.origin[0], y - self.origin[1]].map(f64::from);
        let (sum, off) = self.inv_w.numerator.at(dx, dy);
        if sum.0 <= 1e6 * off {
            return None;
        }
        let first = [self.inv_w.at(dx, dy), self.depth.at(dx, dy)];
        let attributes = self.attributes.iter().map(move |attribute| match attribute {
            Kind::Same(value) => Some(Known { rounded: *value, value: f64::from(*value) }),
            Kind::Affine(quotient) => quotient.at(dx, dy),
            Kind::Other => None,
        });
        Some(first.into_iter().chain(attributes))
    }
}
