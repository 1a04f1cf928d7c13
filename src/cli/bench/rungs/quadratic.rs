//! A parabola through three exact values in every 16 pixels (Wolberg's way).

use fearless_simd::{Simd, SimdBase, f32x16};
use hyperspan::edge::Span;
use hyperspan::shade::BLOCK;

use super::knots::Knots;
use super::lanes::{COUNT_F32, Wide, clamp};
use super::prepare::Prepared;
use super::walk::Rung;
use crate::bench::scenes::Facet;

/// Pixels of a segment.
const PERIOD: i32 = 16;

/// Segments of which the knots are held: two knots each, and one at the end.
const SEGMENTS: i32 = 7;

/// Where the segment of each knot begins, and where it ends; the same for those at an end.
const BEGINS: [f64; BLOCK] = [
    0.0, 0.0, 16.0, 16.0, 32.0, 32.0, 48.0, 48.0, 64.0, 64.0, 80.0, 80.0, 96.0, 96.0, 112.0, 112.0,
];
const ENDS: [f64; BLOCK] = [
    0.0, 16.0, 16.0, 32.0, 32.0, 48.0, 48.0, 64.0, 64.0, 80.0, 80.0, 96.0, 96.0, 112.0, 112.0,
    128.0,
];

/// Exact at both ends and in the middle of every 16 pixels; the last segment ends at the span's
/// last pixel.
#[derive(Debug, Default)]
pub(crate) struct Quadratic {
    knots: Knots,
}

impl Rung for Quadratic {
    fn begin_polygon(&mut self, prepared: &Prepared, _facet: &Facet) {
        self.knots.begin_polygon(prepared);
    }

    #[inline(always)]
    fn begin_span<S: Simd>(&mut self, _simd: S, _prepared: &Prepared, span: &Span) {
        self.knots.begin_span(span);
    }

    #[inline(always)]
    fn values<S: Simd>(
        &mut self,
        simd: S,
        prepared: &Prepared,
        first: i32,
        out: &mut [[f32; BLOCK]],
    ) {
        let segment = first / PERIOD;
        let at = match self.knots.held(segment, SEGMENTS) {
            Some(at) => 2 * at,
            None => {
                let begins = self.knots.positions(simd, first, &BEGINS);
                let ends = self.knots.positions(simd, first, &ENDS);
                let middles = (begins + ends) * Wide::splat(simd, 0.5);
                self.knots.find(simd, prepared, middles);
                0
            }
        };
        let length = (self.knots.last_pixel() - first).clamp(1, PERIOD);
        let count = f32x16::from_slice(simd, &COUNT_F32);
        let part = count * f32x16::splat(simd, 1.0 / length as f32);
        let knots = self.knots.values().iter().zip(&prepared.ranges);
        for ((knots, range), out) in knots.zip(out) {
            let [a, b, c] = [knots[at], knots[at + 1], knots[at + 2]];
            // From the differences: they are exact where the values are near each other.
            let (rise, bend) = (c - a, 2.0 * ((a - b) + (c - b)));
            let slope = f32x16::splat(simd, rise - bend) + part * f32x16::splat(simd, bend);
            let value = f32x16::splat(simd, a) + part * slope;
            clamp(simd, value, *range).store_slice(out);
        }
    }
}
