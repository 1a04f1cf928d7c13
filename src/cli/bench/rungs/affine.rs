//! Affine interpolation, exact nowhere but at some points: of the polygon, of the span, or of
//! every so many pixels.

use fearless_simd::{Simd, SimdBase, SimdCombine, f32x8, f32x16};
use hyperspan::edge::Span;
use hyperspan::shade::BLOCK;

use super::knots::Knots;
use super::lanes::COUNT_F32;
use super::prepare::Prepared;
use super::walk::{Line, Rung};
use crate::bench::scenes::Facet;

/// Affine along the edges and across the spans (the PlayStation's way): exact at vertices only.
#[derive(Debug, Default)]
pub(crate) struct AffinePolygon {
    lines: Vec<Line>,
}

impl Rung for AffinePolygon {
    const GOES_ALONG_EDGES: bool = true;

    fn begin_polygon(&mut self, _prepared: &Prepared, _facet: &Facet) {}

    #[inline(always)]
    fn begin_span<S: Simd>(&mut self, _simd: S, prepared: &Prepared, span: &Span) {
        let left = Crossing::new(prepared, span.left, span.row);
        let right = Crossing::new(prepared, span.right, span.row);
        let width = right.x - left.x;
        let per_pixel = if width > 0.0 { 1.0 / width } else { 0.0 };
        let from_left = f64::from(span.start) + 0.5 - left.x;
        self.lines.clear();
        for k in 0..prepared.ranges.len() {
            let (from, to) = (left.value(prepared, k), right.value(prepared, k));
            let step = (to - from) * per_pixel;
            let start = from + step * from_left;
            self.lines.push(Line { start: start as f32, step: step as f32 });
        }
    }

    #[inline(always)]
    fn values<S: Simd>(
        &mut self,
        simd: S,
        _prepared: &Prepared,
        first: i32,
        out: &mut [[f32; BLOCK]],
    ) {
        values_of_lines(simd, &self.lines, first, out);
    }
}

/// The values of `lines` at 16 pixels, from the span's pixel `first` on.
#[inline(always)]
fn values_of_lines<S: Simd>(simd: S, lines: &[Line], first: i32, out: &mut [[f32; BLOCK]]) {
    for (line, out) in lines.iter().zip(out) {
        line.values(simd, first).store_slice(out);
    }
}

/// Where an edge crosses a row.
struct Crossing {
    /// In framebuffer pixels.
    x: f64,
    vertices: [usize; 2],
    /// How far it is from the upper vertex to the lower: 0 to 1.
    part: f64,
}

impl Crossing {
    #[inline(always)]
    fn new(prepared: &Prepared, ends: [u32; 2], row: i32) -> Self {
        let [upper, lower] = [0, 1].map(|i: usize| prepared.screen[ends[i] as usize]);
        let ([x0, y0], [x1, y1]) = (upper.framebuffer, lower.framebuffer);
        let part = (f64::from(row) + 0.5 - y0) / (y1 - y0);
        // The row may lie beyond an unsnapped end, by a hair.
        let part = if part > 0.0 { part.min(1.0) } else { 0.0 };
        let vertices = [upper.vertex as usize, lower.vertex as usize];
        Self { x: x0 + (x1 - x0) * part, vertices, part }
    }

    #[inline(always)]
    fn value(&self, prepared: &Prepared, k: usize) -> f64 {
        let upper = prepared.clipped.attributes(self.vertices[0])[k];
        let lower = prepared.clipped.attributes(self.vertices[1])[k];
        upper + (lower - upper) * self.part
    }
}

/// Affine between the exact values at a span's first and last pixel.
#[derive(Debug, Default)]
pub(crate) struct AffineSpan {
    lines: Vec<Line>,
}

impl Rung for AffineSpan {
    fn begin_polygon(&mut self, _prepared: &Prepared, _facet: &Facet) {}

    #[inline(always)]
    fn begin_span<S: Simd>(&mut self, _simd: S, prepared: &Prepared, span: &Span) {
        let [u, v] = prepared.offset(span.start, span.row);
        let steps = span.end - 1 - span.start;
        let last = u + f64::from(steps);
        let q = &prepared.inv_w;
        let row = q.row(v);
        let (w_first, w_last) = (1.0 / (row + q.x * u), 1.0 / (row + q.x * last));
        self.lines.clear();
        for (n, [low, high]) in prepared.over_w.iter().zip(&prepared.ranges) {
            let row = n.row(v);
            let (low, high) = (f64::from(*low), f64::from(*high));
            let first = ((row + n.x * u) * w_first).max(low).min(high);
            let last = ((row + n.x * last) * w_last).max(low).min(high);
            self.lines.push(Line::between(first, last, steps));
        }
    }

    #[inline(always)]
    fn values<S: Simd>(
        &mut self,
        simd: S,
        _prepared: &Prepared,
        first: i32,
        out: &mut [[f32; BLOCK]],
    ) {
        values_of_lines(simd, &self.lines, first, out);
    }
}

/// Exact at every `PERIOD` pixels (8, 16 or 32) and at the span's last, affine between (Quake's
/// way).
#[derive(Debug, Default)]
pub(crate) struct AffineEvery<const PERIOD: i32> {
    knots: Knots,
}

/// Segments of which the knots are held. Even: two of 8 pixels make a block.
const SEGMENTS: i32 = 14;

/// 0 to 7, twice.
const COUNT_TWICE: [f32; BLOCK] =
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

impl<const PERIOD: i32> AffineEvery<PERIOD> {
    /// The positions of 16 knots in pixels, from the first of them.
    const POSITIONS: [f64; BLOCK] = {
        let mut positions = [0.0; BLOCK];
        let mut i = 0;
        while i < BLOCK {
            positions[i] = i as f64 * PERIOD as f64;
            i += 1;
        }
        positions
    };
}

impl<const PERIOD: i32> Rung for AffineEvery<PERIOD> {
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
        let from = segment * PERIOD;
        let at = match self.knots.held(segment, SEGMENTS) {
            Some(at) => at,
            None => {
                let positions = self.knots.positions(simd, from, &Self::POSITIONS);
                self.knots.find(simd, prepared, positions);
                0
            }
        };
        let last = self.knots.last_pixel();
        let per_pixel = one_over_length::<PERIOD>(segment, last);
        if PERIOD == 8 {
            let count = f32x16::from_slice(simd, &COUNT_TWICE);
            let next = one_over_length::<PERIOD>(segment + 1, last);
            for (knots, out) in self.knots.values().iter().zip(out) {
                let [a, b, c] = [knots[at], knots[at + 1], knots[at + 2]];
                let start = f32x8::splat(simd, a).combine(f32x8::splat(simd, b));
                let step = f32x8::splat(simd, (b - a) * per_pixel)
                    .combine(f32x8::splat(simd, (c - b) * next));
                (start + count * step).store_slice(out);
            }
        } else {
            let offset = f32x16::splat(simd, (first - from) as f32);
            let count = f32x16::from_slice(simd, &COUNT_F32) + offset;
            for (knots, out) in self.knots.values().iter().zip(out) {
                let (a, b) = (knots[at], knots[at + 1]);
                let step = f32x16::splat(simd, (b - a) * per_pixel);
                (f32x16::splat(simd, a) + count * step).store_slice(out);
            }
        }
    }
}

/// One over the length of `segment`, which ends at the span's `last` pixel at the latest.
#[inline(always)]
fn one_over_length<const PERIOD: i32>(segment: i32, last: i32) -> f32 {
    let length = (last - segment * PERIOD).clamp(1, PERIOD);
    if length == PERIOD { 1.0 / PERIOD as f32 } else { 1.0 / length as f32 }
}
