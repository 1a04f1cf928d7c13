//! Blocks of rows: 16 pixels from a column that is a multiple of 16 on, or from where a short span begins.

use core::ops::Range;

use fearless_simd::{Simd, SimdBase};

use super::{BlockAt, Brush, Canvas, passing_lanes, quantity_of};
use crate::along::AHEAD;
use crate::depth::DepthSource;
use crate::edge::Span;
use crate::gradient::enclosure::Enclosure;
use crate::prepared::FUNCTIONS;
use crate::row::AlongSpans;
use crate::shade::{BLOCK, Shader};
use crate::space::PixelRect;
use crate::span::Values;
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
        unclear: Option<&Enclosure>,
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) -> (u64, u64) {
        let (corner, origin) = (self.brush.place.corner, self.brush.place.origin);
        let (mut width, _) = self.target.size();
        if let Some(depth) = &depth {
            width = width.min(depth.dimensions().0);
        }
        if let Some(depth) = depth.as_deref() {
            fetch(depth, spans, [corner[0] - origin[0], corner[1] - origin[1]]);
        }
        let one_by_one = walker.short || !self.finds_all(&walker, depth.is_some());
        for span in spans {
            let y = span.row + corner[1];
            let (start, end) = (span.start + corner[0], span.end + corner[0]);
            // What is found lane by lane may begin anywhere.
            let x = if walker.short { start } else { start & !(BLOCK_COLUMNS - 1) };
            let (first, last) = (start - x, end - x);
            let mut row = Row {
                span,
                first: [x, y],
                column: x.wrapping_sub(origin[0]),
                row: y.abs_diff(origin[1]),
                // Blocks at the ends may be cut.
                blocks: (last + BLOCK_COLUMNS - 1) / BLOCK_COLUMNS,
                from: u16::MAX << first,
                to: u16::MAX >> (-last & (BLOCK_COLUMNS - 1)),
                passes: false,
            };
            // Where nothing has been cleared, depths are found and stored, but not compared.
            if let (Some(depths), Some(buffer)) = (unclear, depth.as_deref_mut()) {
                let pixels = PixelRect { x0: start, y0: y, x1: end, y1: y + 1 };
                let compare = self.brush.place.test.compare;
                row.passes = buffer.take_unclear(self.target, pixels, origin, depths, compare);
            }
            let mut depths = depth.as_deref_mut().map(|buffer| buffer.tested_row_mut(row.row));
            walker.seek(row.first);
            let within = row.within(width);
            let mut i = 0;
            while i < row.blocks {
                if !one_by_one && within.contains(&i) {
                    let range = i..within.end;
                    let done = self.paint_within(&mut walker, row, range, depths.as_deref_mut());
                    walker.advance(done);
                    i += done;
                }
                if within.contains(&i) {
                    let range = i..if one_by_one { within.end } else { i + 1 };
                    let done = self.paint_short(&mut walker, row, range, depths.as_deref_mut());
                    i += done;
                    if done > 0 {
                        continue;
                    }
                }
                if i < row.blocks {
                    self.paint_any(&mut walker, row, i, depths.as_deref_mut());
                    walker.advance(1);
                    i += 1;
                }
            }
        }
        (self.brush.shaded, walker.exact_values())
    }

    /// Is all that is asked for among what is prepared?
    #[inline(always)]
    fn finds_all<L: Simd>(&self, walker: &AlongSpans<'_, L>, has_depth: bool) -> bool {
        let (source, inputs) = (self.brush.place.test.source, S::INPUTS);
        let is_given = |of, reads: bool| !reads || has_depth && source == of;
        is_given(DepthSource::Z, inputs.depth)
            && is_given(DepthSource::InvW, inputs.inv_w)
            && !inputs.w
            && !(has_depth && walker.tested.is_none())
    }

    /// Paints the blocks `range`, all of whose lanes lie in the target, covered or not; up to the
    /// first that is not prepared, or none if the target does not store pixels so. Returns how many.
    #[inline(always)]
    fn paint_within<L: Simd>(
        &mut self,
        walker: &mut AlongSpans<'_, L>,
        row: Row<'_>,
        range: Range<i32>,
        depths: Option<&mut [f32]>,
    ) -> i32 {
        let (test, inputs) = (self.brush.place.test, S::INPUTS);
        let (has_depth, first_block) = (depths.is_some(), range.start);
        let Some((pixels, stored)) = blocks(self.target, row, range, depths) else { return 0 };
        let count = pixels.len();
        let simd = walker.simd();
        let mut middle = walker.middle();
        // The last block that is covered in part, if any is, and how far it is.
        let last = (row.blocks - 1 - first_block).unsigned_abs() as usize;
        let mut found = [[0.0; BLOCK]; AHEAD];
        let mut count_attributes = inputs.attributes;
        let mut done = 0;
        while done < count {
            let mut some = AHEAD.min(count - done);
            let mut masks = [u16::MAX; AHEAD];
            if done == 0 {
                masks[0] = row.mask(first_block);
            }
            if let Some(mask) = masks.get_mut(last - done) {
                *mask &= row.to;
            }
            let mut any = true;
            if let Some(tested) = walker.tested.as_ref().filter(|_| has_depth) {
                let (ahead, good) = tested.look_ahead(simd, middle);
                some = some.min(good);
                any = false;
                let four = stored.get(done..).and_then(<[_]>::first_chunk::<AHEAD>);
                let usual = tested.off_middle().filter(|_| some == AHEAD);
                if let (Some(off_middle), Some(stored)) = (usual, four) {
                    for i in 0..AHEAD {
                        ahead.middles.lanes(simd, i, off_middle).store_array(&mut found[i]);
                        if !row.passes {
                            masks[i] &= passing_lanes(simd, test.compare, &found[i], &stored[i]);
                        }
                        any |= masks[i] != 0;
                    }
                } else {
                    for i in 0..some {
                        let Some(stored) = stored.get(done + i) else { break };
                        let Some(tested) = &walker.tested else { break };
                        let at = middle + (i * BLOCK) as f64;
                        let (new, undecided) = tested.lanes(simd, &ahead, i, at);
                        new.store_array(&mut found[i]);
                        if undecided & masks[i] != 0 {
                            let (quantity, blocks) = (quantity_of(test.source), (done + i) as i32);
                            walker.decide(blocks, quantity, row.span, masks[i], &mut found[i]);
                        }
                        if !row.passes {
                            masks[i] &= passing_lanes(simd, test.compare, &found[i], stored);
                        }
                        any |= masks[i] != 0;
                    }
                }
            }
            if any && some > 0 {
                if count_attributes != 0 && !walker.prepare(self.brush.lanes.attributes) {
                    break;
                }
                // Most shaders know how many they read.
                if count_attributes > FUNCTIONS {
                    count_attributes = walker.attribute_count();
                } else if count_attributes != walker.attribute_count() {
                    break;
                }
                let (attributes, count) = (&mut *self.brush.lanes.attributes, count_attributes);
                if count != 0 {
                    let (prepared, masks) = (&walker.prepared, &masks[..some]);
                    let mut undecided = [0; AHEAD];
                    let good =
                        prepared.find_some(simd, count, middle, masks, attributes, &mut undecided);
                    some = some.min(good);
                    // Most are: one look at all of them.
                    if undecided != [0; AHEAD] {
                        for i in 0..some {
                            let which = undecided[i % AHEAD];
                            if which != 0 && masks[i] != 0 {
                                let blocks = (done + i) as i32;
                                let lanes = &mut attributes[i * count..(i + 1) * count];
                                walker.decide_attributes(blocks, row.span, masks[i], which, lanes);
                            }
                        }
                    }
                }
                let stride = walker.prepared.stride(count);
                // One by one: to read all masks at once is to wait for each of them to be written.
                let every = masks.iter().fold(u16::MAX, |every, mask| every & mask);
                let whole = S::KEEPS_ALL && some == AHEAD && every == u16::MAX;
                if whole && let Some(pixels) = pixels[done..].first_chunk_mut::<AHEAD>() {
                    self.brush.shaded += (AHEAD * BLOCK) as u64;
                    if test.write
                        && let Some(stored) = stored.get_mut(done..done + AHEAD)
                    {
                        stored.copy_from_slice(&found);
                    }
                    let Brush { lanes, shader, .. } = &mut self.brush;
                    let block = |i: usize| {
                        let first = [row.column_at(first_block + (done + i) as i32), row.first[1]];
                        lanes.whole_block(
                            first,
                            S::INPUTS,
                            &found[i],
                            i * stride..i * stride + count,
                        )
                    };
                    let blocks = [block(0), block(1), block(2), block(3)];
                    shader.shade_row(&blocks, pixels);
                    done += some;
                    middle += (some * BLOCK) as f64;
                    continue;
                }
                let blocks = masks.iter().zip(&found).take(some).enumerate();
                for (i, (mask, found)) in blocks {
                    let Some(pixels) = pixels.get_mut(done + i).filter(|_| *mask != 0) else {
                        continue;
                    };
                    let first = [row.column_at(first_block + (done + i) as i32), row.first[1]];
                    let block = BlockAt { first, columns: 16, span: Some(row.span), mask: *mask };
                    let attributes = i * stride..i * stride + count;
                    let stored = stored.get_mut(done + i);
                    self.brush.paint_block_apart(simd, block, attributes, found, pixels, stored);
                }
            }
            if some == 0 {
                break;
            }
            done += some;
            middle += (some * BLOCK) as f64;
        }
        done as i32
    }

    /// Paints block `i`, run by run.
    #[inline(always)]
    fn paint_any<L: Simd>(
        &mut self,
        walker: &mut AlongSpans<'_, L>,
        row: Row<'_>,
        i: i32,
        mut depths: Option<&mut [f32]>,
    ) {
        let test = self.brush.place.test;
        let mut mask = row.mask(i);
        if let Some(depths) = &depths {
            let (simd, quantity) = (walker.simd(), quantity_of(test.source));
            let found = self.brush.lanes.of_mut(test.source);
            walker.evaluate(quantity, Some(row.span), mask, found);
            let mut stored = [0.0; BLOCK];
            let first = mask.trailing_zeros() as usize;
            let last = BLOCK - mask.leading_zeros() as usize;
            let start = row.column_of(i, first) as usize;
            copy_run(&depths[start..start + last - first], &mut stored[first..last]);
            if !row.passes {
                mask &= passing_lanes(simd, test.compare, found, &stored);
            }
        }
        if mask == 0 {
            return;
        }
        let first = [row.column_at(i), row.first[1]];
        let block = BlockAt { first, columns: 16, span: Some(row.span), mask };
        let mut pixels = [S::Pixel::default(); BLOCK];
        let mut left = self.brush.shade(walker, block, &mut pixels);
        while left != 0 {
            let first = left.trailing_zeros();
            let count = (left >> first).trailing_ones();
            left &= u16::MAX << (first + count - 1) << 1;
            let lanes = first as usize..(first + count) as usize;
            let column = row.column_of(i, lanes.start);
            self.target.write(column, row.row, &pixels[lanes.clone()]);
            if let Some(depths) = depths.as_deref_mut()
                && test.write
            {
                let to = &mut depths[column as usize..column as usize + lanes.len()];
                copy_run(&self.brush.lanes.of(test.source)[lanes], to);
            }
        }
    }
}

/// The blocks `range` of a row, and their depths if there are any; nothing if the target does not
/// store pixels so.
#[expect(clippy::type_complexity, reason = "two slices")]
#[inline(always)]
pub(super) fn blocks<'a, T: Target>(
    target: &'a mut T,
    row: Row<'_>,
    range: Range<i32>,
    depths: Option<&'a mut [f32]>,
) -> Option<(&'a mut [[T::Pixel; BLOCK]], &'a mut [[f32; BLOCK]])> {
    let has_depth = depths.is_some();
    let start = row.column_of(range.start, 0);
    let count = (range.end - range.start).unsigned_abs() as usize;
    let pixels = target.blocks(start, row.row, count);
    let depths = depths.and_then(|depths| depths.get_mut(start as usize..));
    let stored: &mut [[f32; BLOCK]] = depths.unwrap_or_default().as_chunks_mut().0;
    let all = pixels.len() == count && (!has_depth || stored.len() >= count);
    all.then_some((pixels, stored))
}

/// More spans than these need not be fetched at once: memory is ahead of them.
const FETCHED: usize = 64;

/// Asks for the depths of all `spans` before the first is tested, so that memory looks for them at
/// the same time. `offset` is the spans' corner in the buffer.
#[inline(always)]
fn fetch(depth: &DepthBuffer<'_>, spans: &[Span], [x, y]: [i32; 2]) {
    if spans.len() > FETCHED {
        return;
    }
    for span in spans {
        for column in [span.start, span.end - 1] {
            depth.fetch_pixel((column + x).cast_unsigned(), (span.row + y).cast_unsigned());
        }
    }
}

/// Where a span's blocks lie.
#[derive(Clone, Copy)]
pub(super) struct Row<'a> {
    pub(super) span: &'a Span,
    /// Of the first block's lane 0, in the framebuffer.
    pub(super) first: [i32; 2],
    /// Of the same, in the target; it may lie beyond it.
    column: i32,
    /// In the target.
    row: u32,
    blocks: i32,
    /// The covered lanes of the first block, and of the last.
    from: u16,
    to: u16,
    /// Do all of its pixels pass the depth test, whatever is stored?
    pub(super) passes: bool,
}

impl Row<'_> {
    /// The target's column of a lane of block `i` that lies in it.
    #[inline(always)]
    fn column_of(self, i: i32, lane: usize) -> u32 {
        self.column.wrapping_add(i * BLOCK_COLUMNS).cast_unsigned().wrapping_add(lane as u32)
    }

    /// The framebuffer's column of block `i`.
    #[inline(always)]
    pub(super) fn column_at(self, i: i32) -> i32 {
        self.first[0].wrapping_add(i * BLOCK_COLUMNS)
    }

    /// The covered lanes of block `i`.
    #[inline(always)]
    pub(super) fn mask(self, i: i32) -> u16 {
        let from = if i == 0 { self.from } else { u16::MAX };
        if i == self.blocks - 1 { from & self.to } else { from }
    }

    /// The blocks that lie whole in a target that is `width` wide.
    #[inline(always)]
    fn within(self, width: u32) -> Range<i32> {
        let column = i64::from(self.column);
        let end = (i64::from(width) - column) / i64::from(BLOCK_COLUMNS);
        #[expect(clippy::cast_possible_truncation, reason = "no more than there are")]
        let end = if end < i64::from(self.blocks) { end as i32 } else { self.blocks };
        i32::from(column < 0)..end
    }
}
