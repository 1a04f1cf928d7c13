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
use crate::patch::{Patch, Patches};
use crate::row::AlongSpans;
use crate::settle::Walked;
use crate::shade::{BLOCK, Block, Shader};
use crate::span::{InPatch, Values, Walker};
use crate::target::{DepthBuffer, Target, copy_run};

/// Columns of a block.
const BLOCK_COLUMNS: i32 = BLOCK as i32;

/// The covered pixels of a polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Covered<'a> {
    Spans(&'a [Span]),
    Patches(&'a Patches),
}

/// Where a polygon's pixels are drawn, and how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    /// The framebuffer position of the viewport's corner, from which spans count.
    pub(crate) corner: [i32; 2],
    /// The framebuffer position of the target's first pixel.
    pub(crate) origin: [i32; 2],
    pub(crate) test: DepthTest,
}

/// Paints on the instruction set `level`. Returns how many pixels were shaded, and how many
/// values were found by exact arithmetic.
///
/// Not part of the caller, which is compiled for each kind of polygon: this is only for each
/// shader and target.
#[expect(clippy::too_many_arguments, reason = "a room's door: what comes in, and where to")]
#[inline(never)]
pub(crate) fn paint<S: Shader, T: Target<Pixel = S::Pixel>>(
    level: Level,
    walked: Walked<'_>,
    covered: Covered<'_>,
    place: Placement,
    attributes: &mut Vec<[f32; BLOCK]>,
    shader: &mut S,
    target: &mut T,
    depth: Option<&mut DepthBuffer<'_>>,
) -> (u64, u64) {
    let canvas = Canvas { place, shader, target, depth, shaded: 0 };
    let lanes = Lanes { depth: [0.0; BLOCK], inv_w: [0.0; BLOCK], w: [0.0; BLOCK], attributes };
    dispatch!(level, simd => match covered {
        Covered::Spans(spans) => {
            paint_spans(AlongSpans::new(simd, walked), spans, lanes, canvas)
        }
        Covered::Patches(patches) => {
            paint_patches(Walker::over_patches(simd, walked), patches, lanes, canvas)
        }
    })
}

/// What is drawn on, and with what.
struct Canvas<'a, 'd, S, T> {
    place: Placement,
    shader: &'a mut S,
    target: &'a mut T,
    depth: Option<&'a mut DepthBuffer<'d>>,
    /// Pixels that passed the depth test.
    shaded: u64,
}

/// Walks `spans`, 16 columns at a time: depth, then attributes, then the shader.
#[inline(always)]
fn paint_spans<L: Simd, S: Shader, T: Target<Pixel = S::Pixel>>(
    mut walker: AlongSpans<'_, L>,
    spans: &[Span],
    mut lanes: Lanes<'_>,
    mut canvas: Canvas<'_, '_, S, T>,
) -> (u64, u64) {
    let Placement { corner, origin, test } = canvas.place;
    let tested = canvas.depth.is_some().then_some(quantity_of(test.source));
    for span in spans {
        let y = span.row + corner[1];
        let (start, end) = (span.start + corner[0], span.end + corner[0]);
        let target_y = y.abs_diff(origin[1]);
        let mut x = start & !(BLOCK_COLUMNS - 1);
        walker.seek([x, y], [start, end], tested);
        loop {
            let left = end - x;
            let mut mask = if x >= start && left >= BLOCK_COLUMNS {
                u16::MAX
            } else {
                lanes_between(start - x, left)
            };
            let run = TargetRun { x, y: target_y, origin_x: origin[0] };
            if let Some(buffer) = canvas.depth.as_deref() {
                let found = lanes.of_mut(test.source);
                walker.tested(quantity_of(test.source), span, mask, found);
                mask &= run.passing(walker.simd(), buffer, mask, found, test.compare);
            }
            if mask != 0 {
                let block = BlockAt { first: [x, y], columns: 16, span: Some(span), mask };
                let kept = canvas.shade_run(&mut walker, &mut lanes, block, run);
                if let Some(buffer) = canvas.depth.as_deref_mut()
                    && test.write
                {
                    run.write(buffer, kept, lanes.of(test.source));
                }
            }
            if left <= BLOCK_COLUMNS {
                break;
            }
            x += BLOCK_COLUMNS;
            walker.advance();
        }
    }
    (canvas.shaded, walker.exact_values())
}

/// The same, patch by patch.
#[inline(always)]
fn paint_patches<L: Simd, S: Shader, T: Target<Pixel = S::Pixel>>(
    mut walker: Walker<'_, L, InPatch<L>>,
    patches: &Patches,
    mut lanes: Lanes<'_>,
    mut canvas: Canvas<'_, '_, S, T>,
) -> (u64, u64) {
    let Placement { origin, test, .. } = canvas.place;
    for patch in patches.iter() {
        let Patch { first, columns, mut mask, .. } = patch;
        walker.seek(patch);
        if let Some(buffer) = canvas.depth.as_deref() {
            let found = lanes.of_mut(test.source);
            walker.evaluate(quantity_of(test.source), None, mask, found);
            let stored = stored_depths(buffer, patch, origin);
            mask &= passing_lanes(
                test.compare,
                Narrow::load_array_ref(walker.simd, found),
                Narrow::load_array_ref(walker.simd, &stored),
            );
        }
        if mask == 0 {
            continue;
        }
        let mut pixels = [S::Pixel::default(); BLOCK];
        let block = BlockAt { first, columns, span: None, mask };
        canvas.find(&mut walker, &mut lanes, block);
        let kept = canvas.shade(&lanes, block, &mut pixels);
        let mut left = kept;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let [x, y] = patch.place(lane, origin);
            // A pixel at a time: nothing predicts how long a run is.
            canvas.target.write(x, y, &[pixels[lane]]);
            if let Some(buffer) = canvas.depth.as_deref_mut()
                && test.write
            {
                buffer.write(x, y, &[lanes.of(test.source)[lane]]);
            }
        }
    }
    (canvas.shaded, walker.exact_values())
}

/// The depths stored at the lanes of `patch`, where they are in the buffer.
#[inline(always)]
fn stored_depths(buffer: &DepthBuffer<'_>, patch: Patch, origin: [i32; 2]) -> [f32; BLOCK] {
    let columns = usize::from(patch.columns);
    let [x, y] = patch.place(0, origin);
    let (width, height) = buffer.dimensions();
    // Rows one after the other, each over the end of the one before.
    let mut stored = [0.0; 2 * BLOCK];
    let inside = u64::from(x) + 16 <= u64::from(width) && u64::from(y) + 16 <= u64::from(height);
    let mut lane = 0;
    if inside {
        let mut y = y;
        while lane < BLOCK {
            let start = x as usize;
            stored[lane..lane + BLOCK].copy_from_slice(&buffer.row(y)[start..start + BLOCK]);
            lane += columns;
            y += 1;
        }
    } else {
        // Near the buffer's end, or beyond it on any side.
        while lane < BLOCK {
            let [x, y] = patch.place(lane, origin);
            if x < width && y < height {
                stored[lane] = buffer.row(y)[x as usize];
            }
            lane += 1;
        }
    }
    let mut whole = [0.0; BLOCK];
    whole.copy_from_slice(&stored[..BLOCK]);
    whole
}

/// Where a block is, and which of its lanes are drawn.
#[derive(Clone, Copy)]
struct BlockAt<'a> {
    first: [i32; 2],
    columns: u16,
    span: Option<&'a Span>,
    mask: u16,
}

impl<S: Shader, T: Target<Pixel = S::Pixel>> Canvas<'_, '_, S, T> {
    /// Shades a block of a row into the target, and tells which lanes are kept.
    #[inline(always)]
    fn shade_run(
        &mut self,
        values: &mut impl Values,
        lanes: &mut Lanes<'_>,
        block: BlockAt<'_>,
        run: TargetRun,
    ) -> u16 {
        self.find(values, lanes, block);
        if S::KEEPS_ALL && block.mask == u16::MAX {
            let x = u32::try_from(run.column(0)).unwrap_or(u32::MAX);
            if let Some(pixels) = self.target.block(x, run.y) {
                self.shader.shade(&lanes.block(BlockAt { mask: u16::MAX, ..block }), pixels);
                return u16::MAX;
            }
        }
        let mut pixels = [S::Pixel::default(); BLOCK];
        let kept = self.shade(lanes, block, &mut pixels);
        run.write(self.target, kept, &pixels);
        kept
    }

    /// Finds what the shader reads at the lanes of `block`.
    #[inline(always)]
    fn find(&mut self, values: &mut impl Values, lanes: &mut Lanes<'_>, block: BlockAt<'_>) {
        let BlockAt { span, mask, .. } = block;
        self.shaded += u64::from(mask.count_ones());
        let tested = self.depth.is_some().then_some(self.place.test.source);
        let inputs = S::INPUTS;
        if inputs.depth && tested != Some(DepthSource::Z) {
            values.evaluate(Quantity::Depth, span, mask, &mut lanes.depth);
        }
        if inputs.inv_w && tested != Some(DepthSource::InvW) {
            values.evaluate(Quantity::InvW, span, mask, &mut lanes.inv_w);
        }
        if inputs.w {
            values.evaluate(Quantity::W, span, mask, &mut lanes.w);
        }
        if inputs.attributes > 0 {
            values.evaluate_attributes(inputs.attributes, span, mask, lanes.attributes);
        }
    }

    /// Shades the lanes of `block`, whose values were found, and tells which are kept.
    #[inline(always)]
    fn shade(
        &mut self,
        lanes: &Lanes<'_>,
        block: BlockAt<'_>,
        pixels: &mut [S::Pixel; BLOCK],
    ) -> u16 {
        let kept = self.shader.shade(&lanes.block(block), pixels);
        if S::KEEPS_ALL { block.mask } else { kept & block.mask }
    }
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
    /// As the shader sees them.
    #[inline(always)]
    fn block(&self, at: BlockAt<'_>) -> Block<'_> {
        let BlockAt { first, columns, mask, .. } = at;
        let Self { depth, inv_w, w, attributes } = self;
        Block { first, columns, mask, depth, inv_w, w, attributes }
    }

    /// What the depth test compares, to be found.
    #[inline(always)]
    fn of_mut(&mut self, source: DepthSource) -> &mut [f32; BLOCK] {
        match source {
            DepthSource::Z => &mut self.depth,
            DepthSource::InvW => &mut self.inv_w,
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
}

/// What is compared.
#[inline(always)]
fn quantity_of(source: DepthSource) -> Quantity {
    match source {
        DepthSource::Z => Quantity::Depth,
        DepthSource::InvW => Quantity::InvW,
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

/// Where lane 0 lies: its row in the target, and its column in the framebuffer.
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
            copy_run(&row[start..start + last - first], &mut part[first..last]);
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

    /// Hands `run`, which begins at lane `lane`, to the target.
    #[inline(always)]
    fn write_one<T: Target>(self, target: &mut T, lane: usize, run: &[T::Pixel]) {
        target.write(u32::try_from(self.column(lane)).unwrap_or(u32::MAX), self.y, run);
    }

    /// Hands the lanes of `mask` to the target, run by run.
    #[inline(always)]
    fn write<T: Target>(self, target: &mut T, mask: u16, pixels: &[T::Pixel; BLOCK]) {
        if mask == u16::MAX {
            return self.write_one(target, 0, pixels);
        }
        let mut left = mask;
        while left != 0 {
            let first = left.trailing_zeros();
            let count = (left >> first).trailing_ones();
            self.write_one(
                target,
                first as usize,
                &pixels[first as usize..(first + count) as usize],
            );
            left &= u16::MAX << (first + count - 1) << 1;
        }
    }
}
