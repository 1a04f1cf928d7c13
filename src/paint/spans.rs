//! Blocks of rows: 16 pixels from a column that is a multiple of 16 on.

use fearless_simd::Simd;

use super::{BlockAt, Canvas, passing_lanes, quantity_of};
use crate::edge::Span;
use crate::row::AlongSpans;
use crate::shade::{BLOCK, Shader};
use crate::target::{DepthBuffer, Target, copy_run};

/// Columns of a block.
const BLOCK_COLUMNS: i32 = BLOCK as i32;

impl<S: Shader, T: Target<Pixel = S::Pixel>> Canvas<'_, S, T> {
    /// Walks `spans`, 16 columns at a time: depth, then attributes, then the shader.
    #[inline(always)]
    pub(super) fn paint_spans<L: Simd>(
        mut self,
        mut walker: AlongSpans<'_, L>,
        spans: &[Span],
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) -> (u64, u64) {
        let (corner, origin) = (self.place.corner, self.place.origin);
        for span in spans {
            let y = span.row + corner[1];
            let (start, end) = (span.start + corner[0], span.end + corner[0]);
            let row = y.abs_diff(origin[1]);
            let mut depths = depth.as_deref_mut().map(|buffer| buffer.row_mut(row));
            let mut x = start & !(BLOCK_COLUMNS - 1);
            walker.seek([x, y], [start, end], self.lanes.tested.map(quantity_of));
            while x < end {
                let at =
                    |x: i32| RunAt { span, first: [x, y], column: x.wrapping_sub(origin[0]), row };
                // Closures, of which there may be many, are compiled once less.
                let whole = if S::KEEPS_ALL && x >= start { (end - x) / BLOCK_COLUMNS } else { 0 };
                let mask = if whole > 0 {
                    let (done, mask) =
                        self.paint_whole(&mut walker, at(x), whole, depths.as_deref_mut());
                    x += BLOCK_COLUMNS * done;
                    if done == whole {
                        continue;
                    }
                    mask
                } else {
                    let mask = lanes_between(start - x, end - x);
                    self.passing(&mut walker, at(x), mask, depths.as_deref())
                };
                if mask != 0 {
                    self.paint_part(&mut walker, at(x), mask, depths.as_deref_mut());
                }
                // Beyond the last block there may be no number for a column.
                if end - x <= BLOCK_COLUMNS {
                    break;
                }
                x += BLOCK_COLUMNS;
                walker.advance();
            }
        }
        (self.shaded, walker.exact_values())
    }

    /// Paints `count` whole blocks from `at` on, up to one of which only some pixels pass the
    /// depth test, or that cannot be shaded in place. Returns how many are done, and the lanes
    /// of the next that passed.
    #[inline(always)]
    fn paint_whole<L: Simd>(
        &mut self,
        walker: &mut AlongSpans<'_, L>,
        at: RunAt<'_>,
        count: i32,
        depths: Option<&mut [f32]>,
    ) -> (i32, u16) {
        let test = self.place.test;
        let (start, blocks) = (at.column(0), count.unsigned_abs() as usize);
        let mut stored = depths.map(|row| {
            row[start as usize..start as usize + blocks * BLOCK].as_chunks_mut().0.iter_mut()
        });
        let mut pixels = self.target.blocks(start, at.row, blocks).iter_mut();
        let mut first = at.first;
        for done in 0..count {
            let mut mask = u16::MAX;
            let stored = stored.as_mut().and_then(Iterator::next);
            if let Some(stored) = &stored {
                let found = self.lanes.of_mut(test.source);
                walker.tested(quantity_of(test.source), at.span, mask, found);
                mask = passing_lanes(walker.simd(), test.compare, found, stored);
            }
            let pixels = pixels.next();
            if mask != 0 {
                let Some(pixels) = pixels else { return (done, mask) };
                if mask != u16::MAX {
                    return (done, mask);
                }
                let block = BlockAt { first, columns: 16, span: Some(at.span), mask };
                self.shaded += 16;
                self.lanes.find(S::INPUTS, walker, block);
                self.shader.shade(&self.lanes.block(block), pixels);
                if let Some(stored) = stored
                    && test.write
                {
                    *stored = *self.lanes.of(test.source);
                }
            }
            first[0] += BLOCK_COLUMNS;
            walker.advance();
        }
        (count, 0)
    }

    /// The lanes of `mask` that pass the depth test.
    #[inline(always)]
    fn passing<L: Simd>(
        &mut self,
        walker: &mut AlongSpans<'_, L>,
        at: RunAt<'_>,
        mask: u16,
        depths: Option<&[f32]>,
    ) -> u16 {
        let Some(row) = depths else { return mask };
        let test = self.place.test;
        let found = self.lanes.of_mut(test.source);
        walker.tested(quantity_of(test.source), at.span, mask, found);
        let start = usize::try_from(at.column).ok();
        let whole = start.and_then(|start| row.get(start..)?.first_chunk::<BLOCK>());
        let mut part = [0.0; BLOCK];
        let stored = whole.unwrap_or_else(|| {
            let first = mask.trailing_zeros() as usize;
            let last = BLOCK - mask.leading_zeros() as usize;
            let start = at.column(first) as usize;
            copy_run(&row[start..start + last - first], &mut part[first..last]);
            &part
        });
        mask & passing_lanes(walker.simd(), test.compare, found, stored)
    }

    /// Shades the lanes of `mask`, which passed, and stores what is kept, run by run.
    #[inline(always)]
    fn paint_part<L: Simd>(
        &mut self,
        walker: &mut AlongSpans<'_, L>,
        at: RunAt<'_>,
        mask: u16,
        mut depths: Option<&mut [f32]>,
    ) {
        let test = self.place.test;
        let mut pixels = [S::Pixel::default(); BLOCK];
        let block = BlockAt { first: at.first, columns: 16, span: Some(at.span), mask };
        let mut left = self.shade(walker, block, &mut pixels);
        while left != 0 {
            let first = left.trailing_zeros();
            let count = (left >> first).trailing_ones();
            left &= u16::MAX << (first + count - 1) << 1;
            let lanes = first as usize..(first + count) as usize;
            let column = at.column(lanes.start);
            self.target.write(column, at.row, &pixels[lanes.clone()]);
            if let Some(row) = depths.as_deref_mut()
                && test.write
            {
                let to = &mut row[column as usize..column as usize + lanes.len()];
                copy_run(&self.lanes.of(test.source)[lanes], to);
            }
        }
    }
}

/// Where a block lies.
#[derive(Clone, Copy)]
struct RunAt<'a> {
    span: &'a Span,
    /// Of lane 0, in the framebuffer.
    first: [i32; 2],
    /// Of lane 0, in the target; it may lie beyond it.
    column: i32,
    /// In the target.
    row: u32,
}

impl RunAt<'_> {
    /// The target's column of lane `lane`, which lies in it.
    #[inline(always)]
    fn column(self, lane: usize) -> u32 {
        self.column.cast_unsigned().wrapping_add(lane as u32)
    }
}

/// The lanes `start..end` of a block; what lies beyond the block is cut.
#[inline(always)]
fn lanes_between(start: i32, end: i32) -> u16 {
    let from = u16::MAX << start.clamp(0, BLOCK_COLUMNS - 1);
    if end >= BLOCK_COLUMNS { from } else { from & !(u16::MAX << end.max(0)) }
}
