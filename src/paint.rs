//! The blocks of a polygon: depth test, attributes, shader, target.
//!
//! This is the part that is compiled for each shader, target and instruction set; all that
//! comes before it is compiled once.

use alloc::vec::Vec;

use fearless_simd::{Level, Simd, SimdBase, SimdMask, dispatch};

use crate::depth::{Compare, DepthSource, DepthTest};
use crate::edge::Span;
use crate::gradient::Quantity;
use crate::lanes::{Narrow, low_bits};
use crate::settle::Walked;
use crate::shade::{BLOCK, Block, Inputs, Shader};
use crate::span::SpanWalker;
use crate::target::{DepthBuffer, Target};

/// Columns of a block.
const BLOCK_COLUMNS: i32 = BLOCK as i32;

/// Where a polygon's spans are drawn, and how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    /// The framebuffer position of the viewport's corner, from which spans count.
    pub(crate) corner: [i32; 2],
    /// The framebuffer position of the target's first pixel.
    pub(crate) origin: [i32; 2],
    pub(crate) test: DepthTest,
}

/// Paints on the instruction set `simd`. Returns how many pixels were shaded, and how many values
/// were found by exact arithmetic.
///
/// Not part of the caller, which is compiled for each kind of polygon: this is only for each
/// shader and target.
#[expect(clippy::too_many_arguments, reason = "a room's door: what comes in, and where to")]
#[inline(never)]
pub(crate) fn paint<S: Shader, T: Target<Pixel = S::Pixel>>(
    level: Level,
    walked: Walked<'_>,
    spans: &[Span],
    place: Placement,
    attributes: &mut Vec<[f32; BLOCK]>,
    shader: &mut S,
    target: &mut T,
    depth: Option<&mut DepthBuffer<'_>>,
) -> (u64, u64) {
    dispatch!(level, simd => {
        let walker = SpanWalker::new(simd, walked);
        paint_blocks(walker, spans, place, attributes, shader, target, depth)
    })
}

/// Walks `spans`, block by block: depth, then attributes, then the shader.
#[inline(always)]
fn paint_blocks<L: Simd, S: Shader, T: Target<Pixel = S::Pixel>>(
    mut walker: SpanWalker<'_, L>,
    spans: &[Span],
    place: Placement,
    attributes: &mut Vec<[f32; BLOCK]>,
    shader: &mut S,
    target: &mut T,
    mut depth: Option<&mut DepthBuffer<'_>>,
) -> (u64, u64) {
    let Placement { corner, origin, test } = place;
    let tested = depth.is_some().then_some(test.source);
    let mut lanes = Lanes { depth: [0.0; BLOCK], inv_w: [0.0; BLOCK], w: [0.0; BLOCK], attributes };
    let mut shaded = 0_u64;
    for span in spans {
        let y = span.row + corner[1];
        let (start, end) = (span.start + corner[0], span.end + corner[0]);
        let target_y = y.abs_diff(origin[1]);
        let mut x = start & !(BLOCK_COLUMNS - 1);
        while x < end {
            let mut mask = lanes_between(start - x, end - x);
            walker.seek(x, y);
            let run = TargetRun { x, y: target_y, origin_x: origin[0] };
            if let Some(buffer) = depth.as_deref() {
                let found = lanes.tested(&mut walker, test.source, span, mask);
                mask &= run.passing(walker.simd, buffer, mask, found, test.compare);
            }
            if mask != 0 {
                shaded += u64::from(mask.count_ones());
                walker.prepare_attributes(lanes.attributes);
                lanes.find(&mut walker, S::INPUTS, tested, span, mask);
                let mut pixels = [S::Pixel::default(); BLOCK];
                let kept = shader.shade(&lanes.block(x, y, mask), &mut pixels) & mask;
                run.write(target, kept, &pixels);
                if let Some(buffer) = depth.as_deref_mut()
                    && test.write
                {
                    run.write(buffer, kept, lanes.of(test.source));
                }
            }
            // The last block of all columns ends where i32 does.
            let Some(next) = x.checked_add(BLOCK_COLUMNS) else { break };
            x = next;
        }
    }
    (shaded, walker.exact_values())
}

/// The lanes `start..end` of a block; what lies beyond the block is cut.
#[inline(always)]
fn lanes_between(start: i32, end: i32) -> u16 {
    let from = u16::MAX << start.clamp(0, BLOCK_COLUMNS - 1);
    if end >= BLOCK_COLUMNS { from } else { from & !(u16::MAX << end.max(0)) }
}

/// A block's values.
struct Lanes<'a> {
    depth: [f32; BLOCK],
    inv_w: [f32; BLOCK],
    w: [f32; BLOCK],
    attributes: &'a mut Vec<[f32; BLOCK]>,
}

impl Lanes<'_> {
    /// What the depth test compares.
    #[inline(always)]
    fn tested<L: Simd>(
        &mut self,
        walker: &mut SpanWalker<'_, L>,
        source: DepthSource,
        span: &Span,
        mask: u16,
    ) -> &[f32; BLOCK] {
        let (quantity, lanes) = match source {
            DepthSource::Z => (Quantity::Depth, &mut self.depth),
            DepthSource::InvW => (Quantity::InvW, &mut self.inv_w),
        };
        walker.evaluate(quantity, span, mask, lanes);
        lanes
    }

    /// Everything that the shader reads and the depth test has not found.
    #[inline(always)]
    fn find<L: Simd>(
        &mut self,
        walker: &mut SpanWalker<'_, L>,
        inputs: Inputs,
        tested: Option<DepthSource>,
        span: &Span,
        mask: u16,
    ) {
        // One loop, so that the code is there once.
        for k in 0..self.attributes.len() + 3 {
            let (quantity, lanes) = match k {
                0 if inputs.depth && tested != Some(DepthSource::Z) => {
                    (Quantity::Depth, &mut self.depth)
                }
                1 if inputs.inv_w && tested != Some(DepthSource::InvW) => {
                    (Quantity::InvW, &mut self.inv_w)
                }
                2 if inputs.w => (Quantity::W, &mut self.w),
                0..3 => continue,
                _ if walker.is_constant(k - 3) => continue,
                _ => (Quantity::Attribute(k - 3), &mut self.attributes[k - 3]),
            };
            walker.evaluate(quantity, span, mask, lanes);
        }
    }

    /// What the depth test found, to be stored.
    #[inline(always)]
    fn of(&self, source: DepthSource) -> &[f32; BLOCK] {
        match source {
            DepthSource::Z => &self.depth,
            DepthSource::InvW => &self.inv_w,
        }
    }

    #[inline(always)]
    fn block(&self, x: i32, y: i32, mask: u16) -> Block<'_> {
        Block {
            x,
            y,
            mask,
            depth: &self.depth,
            inv_w: &self.inv_w,
            w: &self.w,
            attributes: self.attributes,
        }
    }
}

/// The lanes at which `new` passes against `stored`.
#[inline(always)]
fn passing_lanes<L: Simd>(compare: Compare, new: Narrow<L>, stored: Narrow<L>) -> u16 {
    let lanes = match compare {
        Compare::Never => return 0,
        Compare::Less => new.simd_lt(stored),
        Compare::Equal => new.simd_eq(stored),
        Compare::LessEqual => new.simd_le(stored),
        Compare::Greater => new.simd_gt(stored),
        Compare::NotEqual => return !low_bits(new.simd_eq(stored).to_bitmask()),
        Compare::GreaterEqual => new.simd_ge(stored),
        Compare::Always => return u16::MAX,
    };
    low_bits(lanes.to_bitmask())
}

/// Where a block lies in the target: its row there, and its first column in the framebuffer.
#[derive(Clone, Copy)]
struct TargetRun {
    x: i32,
    y: u32,
    origin_x: i32,
}

impl TargetRun {
    /// The lanes of `mask` whose depth passes.
    #[inline(always)]
    fn passing<L: Simd>(
        self,
        simd: L,
        buffer: &DepthBuffer<'_>,
        mask: u16,
        depth: &[f32; BLOCK],
        compare: Compare,
    ) -> u16 {
        let row = buffer.row(self.y);
        let whole = usize::try_from(self.x.wrapping_sub(self.origin_x)).ok();
        let stored = whole.and_then(|start| row.get(start..)?.first_chunk::<BLOCK>());
        let mut part = [0.0; BLOCK];
        let stored = stored.unwrap_or_else(|| {
            let first = mask.trailing_zeros() as usize;
            let last = BLOCK - mask.leading_zeros() as usize;
            let start = self.column(first);
            part[first..last].copy_from_slice(&row[start..start + last - first]);
            &part
        });
        let new = Narrow::load_array_ref(simd, depth);
        mask & passing_lanes(compare, new, Narrow::load_array_ref(simd, stored))
    }

    /// The target's column of lane `lane`, which lies in it.
    #[inline(always)]
    fn column(self, lane: usize) -> usize {
        (self.x.wrapping_sub(self.origin_x))
            .wrapping_add_unsigned(u32::try_from(lane).unwrap_or(0))
            .unsigned_abs() as usize
    }

    /// Hands the lanes of `mask` to the target, run by run.
    #[inline(always)]
    fn write<T: Target>(self, target: &mut T, mask: u16, pixels: &[T::Pixel; BLOCK]) {
        let mut left = mask;
        while left != 0 {
            let first = left.trailing_zeros();
            let count = (left >> first).trailing_ones();
            let run = &pixels[first as usize..(first + count) as usize];
            let column = self.column(first as usize);
            target.write(u32::try_from(column).unwrap_or(u32::MAX), self.y, run);
            // In two shifts: the run may be all 16.
            left &= (u16::MAX << (first + count - 1)) << 1;
        }
    }
}
