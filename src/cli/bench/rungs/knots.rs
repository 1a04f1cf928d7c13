//! Exact values at some pixels of a span, 16 of them at a time: between them, other rungs are
//! affine or quadratic.

use fearless_simd::{Simd, SimdBase, f32x16};
use hyperspan::edge::Span;
use hyperspan::shade::BLOCK;

use super::lanes::{LaneArrays, Wide, clamp};
use super::prepare::Prepared;

/// Values at the ends of segments of a span.
#[derive(Debug, Default)]
pub(crate) struct Knots {
    lanes: LaneArrays,
    count: usize,
    /// The segment of the first knot; below 0 if there are none yet.
    segment: i32,
    /// Row, first column, and the one after the last.
    span: [i32; 3],
}

impl Knots {
    /// As many attributes as `prepared` has.
    pub(crate) fn begin_polygon(&mut self, prepared: &Prepared) {
        self.count = prepared.ranges.len();
    }

    /// For each attribute.
    #[inline(always)]
    pub(crate) fn values(&self) -> &[[f32; BLOCK]] {
        &self.lanes.0[..self.count]
    }

    /// No knots of it are known yet.
    #[inline(always)]
    pub(crate) fn begin_span(&mut self, span: &Span) {
        self.span = [span.row, span.start, span.end];
        self.segment = -1;
    }

    /// The span's last pixel, from its first.
    #[inline(always)]
    pub(crate) fn last_pixel(&self) -> i32 {
        self.span[2] - self.span[1] - 1
    }

    /// Pixels from the span's first: `positions` from its pixel `from` on, and none beyond it.
    #[inline(always)]
    pub(crate) fn positions<S: Simd>(
        &self,
        simd: S,
        from: i32,
        positions: &[f64; BLOCK],
    ) -> Wide<S> {
        let positions = Wide::load(simd, positions) + Wide::splat(simd, f64::from(from));
        positions.at_most(simd, f64::from(self.last_pixel()))
    }

    /// Finds the values at `positions`, in pixels from the span's first, as `Fast` does.
    #[inline(always)]
    pub(crate) fn find<S: Simd>(&mut self, simd: S, prepared: &Prepared, positions: Wide<S>) {
        let [row, start, _] = self.span;
        let [u, v] = prepared.offset(start, row);
        let us = positions + Wide::splat(simd, u);
        let q = &prepared.inv_w;
        let q = Wide::splat(simd, q.row(v)) + Wide::splat(simd, q.x) * us;
        let w = f32x16::splat(simd, 1.0) / q.narrow();
        let functions = prepared.over_w.iter().zip(&prepared.ranges);
        for ((n, range), values) in functions.zip(&mut self.lanes.0) {
            let n = Wide::splat(simd, n.row(v)) + Wide::splat(simd, n.x) * us;
            clamp(simd, n.narrow() * w, *range).store_slice(values);
        }
    }

    /// How many segments before `segment` the knots begin that are held, which are those of so
    /// many `segments`; else they are to be found, for `segment` and what follows it.
    #[inline(always)]
    pub(crate) fn held(&mut self, segment: i32, segments: i32) -> Option<usize> {
        let ahead = segment.wrapping_sub(self.segment);
        if self.segment < 0 || !(0..segments).contains(&ahead) {
            self.segment = segment;
            return None;
        }
        Some(ahead as usize)
    }
}
