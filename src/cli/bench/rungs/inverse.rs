//! The definition itself: the pixel through the inverse of the three vertices' matrix, and a
//! division for each value, all in `f64` and from the picture's corner, without further care.

use fearless_simd::{Simd, SimdBase, f32x16};
use hyperspan::edge::Span;
use hyperspan::shade::BLOCK;

use super::lanes::{COUNT, Wide, clamp};
use super::prepare::{Linear, Prepared, weights};
use super::walk::{Line, Rung};
use crate::bench::scenes::Facet;

/// The matrix that takes a pixel to weights over w.
#[derive(Debug, Default)]
pub(crate) struct Inverse {
    weights: [Linear; 3],
    /// z of the three vertices, and their attributes.
    depths: [f64; 3],
    values: Vec<[f64; 3]>,
    /// Column and row where the span begins.
    start: [f64; 2],
}

impl Inverse {
    /// The weights over w of 16 pixels.
    #[inline(always)]
    fn weights<S: Simd>(&self, simd: S, first: i32) -> [Wide<S>; 3] {
        let [x, y] = self.start;
        let xs = Wide::load(simd, &COUNT) + Wide::splat(simd, x + f64::from(first));
        let [a, b, c] = &self.weights;
        [
            Wide::splat(simd, a.row(y)) + Wide::splat(simd, a.x) * xs,
            Wide::splat(simd, b.row(y)) + Wide::splat(simd, b.x) * xs,
            Wide::splat(simd, c.row(y)) + Wide::splat(simd, c.x) * xs,
        ]
    }
}

/// The sum of `values` with `weights`.
#[inline(always)]
fn weighted<S: Simd>(simd: S, [a, b, c]: [Wide<S>; 3], values: [f64; 3]) -> Wide<S> {
    let sum = a * Wide::splat(simd, values[0]) + b * Wide::splat(simd, values[1]);
    sum + c * Wide::splat(simd, values[2])
}

impl Rung for Inverse {
    fn begin_polygon(&mut self, prepared: &Prepared, facet: &Facet) {
        let points = prepared.seen_from(facet, [0, 0]);
        self.weights = weights(prepared.corners.map(|i| points[i]));
        self.depths = prepared.corners.map(|i| facet.positions[i][2]);
        let stride = facet.attributes.len() / facet.positions.len().max(1);
        self.values.clear();
        for k in 0..prepared.ranges.len() {
            let value = |i: usize| f64::from(facet.attributes[i * stride + k]);
            self.values.push(prepared.corners.map(value));
        }
    }

    #[inline(always)]
    fn begin_span<S: Simd>(&mut self, _simd: S, _prepared: &Prepared, span: &Span) {
        self.start = [f64::from(span.start), f64::from(span.row)];
    }

    #[inline(always)]
    fn values<S: Simd>(
        &mut self,
        simd: S,
        prepared: &Prepared,
        first: i32,
        out: &mut [[f32; BLOCK]],
    ) {
        let weights = self.weights(simd, first);
        let [a, b, c] = weights;
        let sum = a + b + c;
        for ((values, range), out) in self.values.iter().zip(&prepared.ranges).zip(out) {
            let value = (weighted(simd, weights, *values) / sum).narrow();
            clamp(simd, value, *range).store_slice(out);
        }
    }

    #[inline(always)]
    fn depths<S: Simd>(&self, simd: S, _line: Line, first: i32) -> f32x16<S> {
        weighted(simd, self.weights(simd, first), self.depths).narrow()
    }
}
