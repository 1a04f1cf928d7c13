//! The loop over spans and blocks that all rungs but the product's own share: it is theirs as
//! `Tiler` is the product's, with the library's shaders and targets.

use fearless_simd::{Level, Simd, SimdBase, SimdMask, dispatch, f32x16};
use hyperspan::edge::Span;
use hyperspan::shade::{BLOCK, Block, Shader};
use hyperspan::target::{DepthBuffer, Target};

use super::lanes::COUNT_F32;
use super::prepare::Prepared;
use crate::bench::scenes::Facet;

/// A way of interpolating along a span.
pub(crate) trait Rung {
    /// Does it need attributes at the clipped vertices?
    const GOES_ALONG_EDGES: bool = false;

    /// Takes a polygon.
    fn begin_polygon(&mut self, prepared: &Prepared, facet: &Facet);

    /// Takes a span of it.
    fn begin_span<S: Simd>(&mut self, simd: S, prepared: &Prepared, span: &Span);

    /// The attributes of 16 pixels, from the span's pixel `first` on.
    fn values<S: Simd>(
        &mut self,
        simd: S,
        prepared: &Prepared,
        first: i32,
        out: &mut [[f32; BLOCK]],
    );

    /// The depths of 16 pixels, where `line` is what it is along the span.
    #[inline(always)]
    fn depths<S: Simd>(&self, simd: S, line: Line, first: i32) -> f32x16<S> {
        line.values(simd, first)
    }
}

/// Affine along a span: at its first pixel, and from one to the next.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Line {
    pub(crate) start: f32,
    pub(crate) step: f32,
}

impl Line {
    /// From one value to another, `steps` pixels on.
    #[inline(always)]
    pub(crate) fn between(first: f64, last: f64, steps: i32) -> Self {
        let step = (last - first) / f64::from(steps.max(1));
        Self { start: first as f32, step: step as f32 }
    }

    /// At 16 pixels from the span's pixel `first` on.
    #[inline(always)]
    pub(crate) fn values<S: Simd>(self, simd: S, first: i32) -> f32x16<S> {
        let along = f32x16::from_slice(simd, &COUNT_F32) + f32x16::splat(simd, first as f32);
        along * f32x16::splat(simd, self.step) + f32x16::splat(simd, self.start)
    }
}

/// Draws a polygon that is prepared.
#[inline(never)]
pub(crate) fn paint<R: Rung, S: Shader, T: Target<Pixel = S::Pixel>>(
    level: Level,
    rung: &mut R,
    prepared: &Prepared,
    attributes: &mut [[f32; BLOCK]],
    shader: &mut S,
    target: &mut T,
    depth: Option<&mut DepthBuffer<'_>>,
) {
    dispatch!(level, simd => paint_spans(simd, rung, prepared, attributes, shader, target, depth));
}

#[inline(always)]
fn paint_spans<L: Simd, R: Rung, S: Shader, T: Target<Pixel = S::Pixel>>(
    simd: L,
    rung: &mut R,
    prepared: &Prepared,
    attributes: &mut [[f32; BLOCK]],
    shader: &mut S,
    target: &mut T,
    mut depth: Option<&mut DepthBuffer<'_>>,
) {
    const WIDTH: i32 = BLOCK as i32;
    let unused = [0.0; BLOCK];
    let mut depths = [0.0; BLOCK];
    for span in &prepared.spans {
        rung.begin_span(simd, prepared, span);
        let [u, v] = prepared.offset(span.start, span.row);
        let function = &prepared.depth;
        let start = function.row(v) + function.x * u;
        let line = Line { start: start as f32, step: function.x as f32 };
        let (y, length) = (span.row.cast_unsigned(), span.end - span.start);
        let mut first = 0;
        while first < length {
            let left = length - first;
            let mut mask = if left >= WIDTH { u16::MAX } else { !(u16::MAX << left) };
            let x = (span.start + first).cast_unsigned() as usize;
            if S::INPUTS.depth || depth.is_some() {
                rung.depths(simd, line, first).store_slice(&mut depths);
            }
            if let Some(buffer) = depth.as_deref() {
                mask &= passing(simd, &buffer.row(y)[x..], &depths);
            }
            if mask != 0 {
                if S::INPUTS.attributes > 0 {
                    rung.values(simd, prepared, first, attributes);
                }
                let mut pixels = [S::Pixel::default(); BLOCK];
                let place = [span.start + first, span.row];
                let block = Block {
                    first: place,
                    columns: 16,
                    mask,
                    depth: &depths,
                    inv_w: &unused,
                    w: &unused,
                    attributes,
                };
                let kept = shader.shade(&block, &mut pixels) & mask;
                write(target, x, y, kept, &pixels);
                if let Some(buffer) = depth.as_deref_mut() {
                    write(buffer, x, y, kept, &depths);
                }
            }
            first += WIDTH;
        }
    }
}

/// The lanes that are nearer than what is stored from the first lane's column on.
#[inline(always)]
fn passing<S: Simd>(simd: S, row: &[f32], depths: &[f32; BLOCK]) -> u16 {
    let mut part = [0.0; BLOCK];
    let stored = row.first_chunk::<BLOCK>().unwrap_or_else(|| {
        part[..row.len()].copy_from_slice(row);
        &part
    });
    let nearer = f32x16::from_slice(simd, depths).simd_lt(f32x16::from_slice(simd, stored));
    nearer.to_bitmask() as u16
}

/// Hands the lanes of `mask` to the target, run by run.
#[inline(always)]
fn write<T: Target>(target: &mut T, x: usize, y: u32, mask: u16, pixels: &[T::Pixel; BLOCK]) {
    let x = x as u32;
    if mask == u16::MAX {
        return target.write(x, y, pixels);
    }
    let mut left = mask;
    while left != 0 {
        let first = left.trailing_zeros();
        let count = (left >> first).trailing_ones();
        target.write(x + first, y, &pixels[first as usize..(first + count) as usize]);
        left &= u16::MAX << (first + count - 1) << 1;
    }
}
