//! Whether a polygon is flat, and its attributes are affine: where the vertices are in the plane of the three
//! that carry it.

use alloc::vec::Vec;

use super::triple::{cross, larger, sub};
use crate::number::Number;

/// How far a vertex may be from the plane, relative to the polygon's diameter (the diagonal of
/// its bounding box), or an attribute from the affine function, relative to its range.
pub(crate) const FLATNESS: f64 = 1.0 / 1024.0;

/// The plane of three points, and what tells where others are in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Basis<F> {
    origin: [F; 3],
    normal: [F; 3],
    /// Of the normal; 0 if the plane is a line. And one over it.
    pub(crate) square: F,
    per_square: F,
    /// The functions of the offset from a that are 1 at b or c, and 0 at the others.
    beta: [F; 3],
    gamma: [F; 3],
}

impl<F: Number> Basis<F> {
    #[inline(always)]
    pub(crate) fn new([a, b, c]: [[F; 3]; 3]) -> Self {
        let (to_b, to_c) = (sub(b, a), sub(c, a));
        let normal = cross(to_b, to_c);
        let square = dot(normal, normal);
        let per_square = square.reciprocal();
        let beta = scaled(cross(to_c, normal), per_square);
        let gamma = scaled(cross(normal, to_b), per_square);
        Self { origin: a, normal, square, per_square, beta, gamma }
    }

    /// (beta, gamma) of a + beta (b - a) + gamma (c - a), and how far `point` is off the plane, times the
    /// normal's length.
    #[inline(always)]
    pub(crate) fn place(&self, point: [F; 3]) -> ([F; 2], F) {
        let offset = sub(point, self.origin);
        ([dot(self.beta, offset), dot(self.gamma, offset)], dot(self.normal, offset).abs())
    }

    /// The square of such a distance.
    #[inline(always)]
    pub(crate) fn squared(&self, height: F) -> F {
        height * height * self.per_square
    }
}

/// The square of what a value at a place differs from that of the affine function with the values `a`, `b`
/// and `c` at the triple.
#[inline(always)]
pub(crate) fn off_affine<F: Number>([a, b, c]: [F; 3], [beta, gamma]: [F; 2], value: F) -> F {
    let off = a + beta * (b - a) + gamma * (c - a) - value;
    off * off
}

/// The place of each vertex in the plane of the triple: (beta, gamma) of
/// a + beta (b - a) + gamma (c - a). None if the plane is a line.
///
/// What the tests of flatness need, which are no part of any value: they are as `f64` has it.
#[derive(Debug, Default)]
pub(crate) struct Places {
    triple: [usize; 3],
    places: Vec<[f64; 2]>,
    /// The greatest square of a vertex's distance from the plane.
    height_squared: f64,
}

impl Places {
    /// Of the points `point(position)` in the plane of those of `triple`. Points that are collinear,
    /// or lie on a line through the eye, have no plane to be off.
    #[inline(always)]
    pub(crate) fn set(
        &mut self,
        positions: &[[f64; 4]],
        triple: [usize; 3],
        point: impl Fn([f64; 4]) -> [f64; 3],
    ) {
        let basis = Basis::new(triple.map(|i| point(positions[i])));
        (self.triple, self.height_squared) = (triple, 0.0);
        self.places.clear();
        if basis.square == 0.0 {
            return;
        }
        self.places.reserve(positions.len());
        let mut height = 0.0;
        for position in positions {
            let (place, its_height) = basis.place(point(*position));
            self.places.push(place);
            height = larger(height, its_height);
        }
        let [a, b, c] = triple;
        (self.places[a], self.places[b], self.places[c]) = ([0.0, 0.0], [1.0, 0.0], [0.0, 1.0]);
        self.height_squared = basis.squared(height);
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.places.capacity() * size_of::<[f64; 2]>()
    }

    /// Is `value(i)` of every vertex i affine within a tolerance, given by its square?
    #[inline(always)]
    pub(crate) fn are_affine(&self, tolerance_squared: f64, value: impl Fn(usize) -> f64) -> bool {
        let values = self.triple.map(&value);
        let mut affine = true;
        for (i, place) in self.places.iter().enumerate() {
            affine &= off_affine(values, *place, value(i)) <= tolerance_squared;
        }
        affine
    }

    /// Is every vertex within the tolerance of the plane, and z affine over it?
    #[inline(always)]
    pub(crate) fn are_flat(&self, positions: &[[f64; 4]]) -> bool {
        let Some(first) = positions.first() else { return true };
        let (mut low, mut high) = (*first, *first);
        for p in positions {
            for k in 0..4 {
                low[k] = if p[k] < low[k] { p[k] } else { low[k] };
                high[k] = if p[k] > high[k] { p[k] } else { high[k] };
            }
        }
        let [x, y, z, w] = [0, 1, 2, 3].map(|k| high[k] - low[k]);
        let diameter_squared = x * x + y * y + z * z + w * w;
        let tolerance_squared = FLATNESS * FLATNESS * diameter_squared;
        self.height_squared <= tolerance_squared
            && self.are_affine(tolerance_squared, |i| positions[i][2])
    }
}

#[inline(always)]
fn scaled<F: Number>([x, y, w]: [F; 3], factor: F) -> [F; 3] {
    [x * factor, y * factor, w * factor]
}

#[inline(always)]
fn dot<F: Number>(a: [F; 3], b: [F; 3]) -> F {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
