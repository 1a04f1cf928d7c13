//! The blocks of a polygon: depth test, attributes, shader, target.
//!
//! This is the part that is compiled for each shader, target and instruction set; all that
//! comes before it is compiled once.

mod part;
mod patches;
mod short;
pub(crate) mod small;
mod small_strict;
mod spans;

use core::ops::Range;

use fearless_simd::{Level, Simd, SimdBase, dispatch};

use self::part::store_lanes;
use crate::aligned::LaneMemory;
use crate::depth::{Compare, DepthSource, DepthTest};
use crate::edge::Span;
use crate::gradient::Quantity;
use crate::gradient::enclosure::Enclosure;
use crate::lanes::{Narrow, bits_of};
use crate::patch::Patch;
use crate::row::AlongSpans;
use crate::settle::Walked;
use crate::shade::{BLOCK, Block, Inputs, Shader};
use crate::space::PixelRect;
use crate::span::{Values, Walker};
use crate::target::{DepthBuffer, Target};

/// The covered pixels of a polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Covered<'a> {
    /// And what their depths lie between, if there may be rows that have not been cleared.
    Spans(&'a [Span], Option<Enclosure>),
    Patches(&'a [Patch]),
    /// The same pixels in either way: by their patches, unless attributes need spans.
    Packed(&'a [Patch], &'a [Span]),
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

impl Placement {
    /// The rows of the target, first and last, in which pixels `within` the framebuffer lie. They may begin
    /// above it.
    #[inline(always)]
    pub(crate) fn rows(&self, within: PixelRect) -> [u32; 2] {
        let row = |y: i32| y.saturating_sub(self.origin[1]).max(0).cast_unsigned();
        [row(within.y0), row(within.y1.saturating_sub(1))]
    }
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
    attributes: &mut LaneMemory,
    shader: &mut S,
    target: &mut T,
    depth: Option<&mut DepthBuffer<'_>>,
) -> (u64, u64) {
    let tested = depth.is_some().then_some(place.test.source);
    let (depths, inv_w, w) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
    let lanes = Lanes { tested, depth: depths, inv_w, w, attributes };
    let brush = Brush { place, lanes, shader, shaded: 0 };
    let mut canvas = Canvas { brush, target };
    let mut depth = depth;
    dispatch!(level, simd => {
        let (spans, unclear, mut walked) = match covered {
            Covered::Spans(spans, unclear) => (spans, unclear, walked),
            Covered::Patches(patches) | Covered::Packed(patches, _) => {
                let mut walker = Walker::over_patches(simd, walked);
                let done = canvas.paint_patches(&mut walker, patches, depth.as_deref_mut());
                match covered {
                    Covered::Packed(_, spans) if !done => (spans, None, walker.polygon),
                    _ => return (canvas.brush.shaded, walker.exact_values()),
                }
            }
        };
        walked.columns = BLOCK as u16;
        let walker = AlongSpans::new(simd, walked, tested.map(quantity_of));
        canvas.paint_spans(walker, spans, unclear.as_ref(), depth)
    })
}

/// What is drawn on, and with what.
struct Canvas<'a, S, T> {
    brush: Brush<'a, S>,
    target: &'a mut T,
}

/// What is drawn with: apart from the target, whose rows are lent while blocks are shaded.
struct Brush<'a, S> {
    place: Placement,
    lanes: Lanes<'a>,
    shader: &'a mut S,
    /// Pixels that passed the depth test.
    shaded: u64,
}

/// Where a block is, and which of its lanes are drawn.
#[derive(Clone, Copy)]
struct BlockAt<'a> {
    first: [i32; 2],
    columns: u16,
    span: Option<&'a Span>,
    mask: u16,
}

impl<S: Shader> Brush<'_, S> {
    /// Finds and shades the lanes of `block`, and tells which are kept.
    #[inline(always)]
    fn shade(
        &mut self,
        values: &mut impl Values,
        block: BlockAt<'_>,
        pixels: &mut [S::Pixel; BLOCK],
    ) -> u16 {
        self.shaded += u64::from(block.mask.count_ones());
        self.lanes.find(S::INPUTS, values, block);
        let attributes = &self.lanes.attributes[..values.attribute_count()];
        let kept = self.shader.shade(&self.lanes.block(block, attributes), pixels);
        if S::KEEPS_ALL { block.mask } else { kept & block.mask }
    }

    /// [`paint_block`](Self::paint_block), out of line.
    #[inline(never)]
    fn paint_block_apart<L: Simd>(
        &mut self,
        simd: L,
        block: BlockAt<'_>,
        attributes: Range<usize>,
        tested: &[f32; BLOCK],
        pixels: &mut [S::Pixel; BLOCK],
        stored: Option<&mut [f32; BLOCK]>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.paint_block(simd, block, attributes, tested, pixels, stored),
        );
    }

    /// Shades `block` in the target's row: `attributes` are those of its values among all, `tested` is
    /// what the depth test found, and `stored` what it compared with, if there is one.
    #[inline(always)]
    fn paint_block<L: Simd>(
        &mut self,
        simd: L,
        block: BlockAt<'_>,
        attributes: Range<usize>,
        tested: &[f32; BLOCK],
        pixels: &mut [S::Pixel; BLOCK],
        stored: Option<&mut [f32; BLOCK]>,
    ) {
        if stored.is_some() {
            *self.lanes.of_mut(self.place.test.source) = *tested;
        }
        let mut mask = block.mask;
        self.shaded += u64::from(mask.count_ones());
        let shaded = self.lanes.block(block, &self.lanes.attributes[attributes]);
        let mut part = [S::Pixel::default(); BLOCK];
        let kept = self.shader.shade(&shaded, &mut part);
        if !S::KEEPS_ALL {
            mask &= kept;
        }
        store_lanes(simd, mask, &part, pixels);
        if let Some(stored) = stored.filter(|_| self.place.test.write) {
            store_lanes(simd, mask, tested, stored);
        }
    }
}

/// A block's values.
struct Lanes<'a> {
    /// What the depth test compares, if there is one: it finds it.
    tested: Option<DepthSource>,
    depth: [f32; BLOCK],
    inv_w: [f32; BLOCK],
    w: [f32; BLOCK],
    /// Of one block, or of some, one after the other.
    attributes: &'a mut LaneMemory,
}

impl Lanes<'_> {
    /// Finds what a shader reads at the lanes of `block`.
    #[inline(always)]
    fn find(&mut self, inputs: Inputs, values: &mut impl Values, block: BlockAt<'_>) {
        let BlockAt { span, mask, .. } = block;
        if inputs.depth && self.tested != Some(DepthSource::Z) {
            values.evaluate(Quantity::Depth, span, mask, &mut self.depth);
        }
        if inputs.inv_w && self.tested != Some(DepthSource::InvW) {
            values.evaluate(Quantity::InvW, span, mask, &mut self.inv_w);
        }
        if inputs.w {
            values.evaluate(Quantity::W, span, mask, &mut self.w);
        }
        if inputs.attributes > 0 {
            values.evaluate_attributes(span, mask, self.attributes);
        }
    }

    /// As the shader sees them.
    #[inline(always)]
    fn block<'b>(&'b self, at: BlockAt<'_>, attributes: &'b [[f32; BLOCK]]) -> Block<'b> {
        let BlockAt { first, columns, mask, .. } = at;
        let Self { depth, inv_w, w, .. } = self;
        Block { first, columns, mask, depth, inv_w, w, attributes }
    }

    /// A block of a row of which all lanes are drawn: what the depth test compared is `tested`, if a shader
    /// with these `inputs` reads it.
    #[inline(always)]
    fn whole_block<'b>(
        &'b self,
        first: [i32; 2],
        inputs: Inputs,
        tested: &'b [f32; BLOCK],
        attributes: Range<usize>,
    ) -> Block<'b> {
        Block {
            first,
            columns: BLOCK as u16,
            mask: u16::MAX,
            depth: if inputs.depth { tested } else { &self.depth },
            inv_w: if inputs.inv_w { tested } else { &self.inv_w },
            w: &self.w,
            attributes: &self.attributes[attributes],
        }
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
fn passing_lanes<L: Simd>(
    simd: L,
    compare: Compare,
    new: &[f32; BLOCK],
    stored: &[f32; BLOCK],
) -> u16 {
    let lanes = |lanes| Narrow::load_array_ref(simd, lanes);
    match compare {
        Compare::Less => bits_of(simd, lanes(new).simd_lt(lanes(stored))),
        Compare::Greater => bits_of(simd, lanes(new).simd_gt(lanes(stored))),
        // Out of line: what is usual is predicted, without a table.
        _ => passing_otherwise(simd, compare, new, stored),
    }
}

/// The same for what is not usual.
#[inline(never)]
fn passing_otherwise<L: Simd>(
    simd: L,
    compare: Compare,
    new: &[f32; BLOCK],
    stored: &[f32; BLOCK],
) -> u16 {
    simd.vectorize(
        #[inline(always)]
        || {
            let (new, stored) =
                (Narrow::load_array_ref(simd, new), Narrow::load_array_ref(simd, stored));
            let lanes = match compare {
                Compare::Never => return 0,
                Compare::Less => new.simd_lt(stored),
                Compare::Equal => new.simd_eq(stored),
                Compare::LessEqual => new.simd_le(stored),
                Compare::Greater => new.simd_gt(stored),
                Compare::NotEqual => return !bits_of(simd, new.simd_eq(stored)),
                Compare::GreaterEqual => new.simd_ge(stored),
                Compare::Always => return u16::MAX,
            };
            bits_of(simd, lanes)
        },
    )
}
