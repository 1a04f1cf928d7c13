//! Blocks of polygons that have few of them in a row: each by itself, all functions of its middle
//! at the same time.

use core::ops::Range;

use fearless_simd::{Simd, SimdBase};

use super::spans::{Row, blocks};
use super::{BlockAt, Canvas, passing_lanes, quantity_of};
use crate::prepared::FUNCTIONS;
use crate::row::AlongSpans;
use crate::shade::{BLOCK, Inputs, Shader};
use crate::span::Values;
use crate::target::Target;

impl<S: Shader, T: Target<Pixel = S::Pixel>> Canvas<'_, S, T> {
    /// Paints the blocks `range`, all of whose lanes lie in the target, covered or not; up to the
    /// first that is not prepared, or none if the target does not store pixels so. Returns how many,
    /// by which the walker has gone on.
    #[inline(always)]
    pub(super) fn paint_short<L: Simd>(
        &mut self,
        walker: &mut AlongSpans<'_, L>,
        row: Row<'_>,
        range: Range<i32>,
        depths: Option<&mut [f32]>,
    ) -> i32 {
        let (test, inputs) = (self.brush.place.test, S::INPUTS);
        let (has_depth, first_block) = (depths.is_some(), range.start);
        // What is not prepared is found block by block.
        let rest = Inputs { attributes: 0, ..inputs };
        let Some((pixels, stored)) = blocks(self.target, row, range, depths) else { return 0 };
        let all = pixels.len() as i32;
        let simd = walker.simd();
        let mut found = [0.0; BLOCK];
        let mut count = inputs.attributes;
        for (done, (block, pixels)) in (first_block..).zip(pixels).enumerate() {
            let middle = walker.middle();
            let mut mask = row.mask(block);
            if has_depth {
                let Some(tested) = &walker.tested else { return done as i32 };
                let new = tested.find_one(simd, middle, walker.short);
                let (Some((new, undecided)), Some(stored)) = (new, stored.get(done)) else {
                    return done as i32;
                };
                new.store_array(&mut found);
                if undecided & mask != 0 {
                    let quantity = quantity_of(test.source);
                    walker.decide(0, quantity, row.span, mask, &mut found);
                }
                if !row.passes {
                    mask &= passing_lanes(simd, test.compare, &found, stored);
                }
            }
            if mask != 0 {
                if count != 0 {
                    if !walker.prepare(self.brush.lanes.attributes) {
                        return done as i32;
                    }
                    // Most shaders know how many they read.
                    if count > FUNCTIONS {
                        count = walker.attribute_count();
                    } else if count != walker.attribute_count() {
                        return done as i32;
                    }
                    let (prepared, lanes) = (&walker.prepared, &mut *self.brush.lanes.attributes);
                    let undecided = prepared.find_one(simd, count, middle, mask, lanes);
                    let Some(undecided) = undecided else { return done as i32 };
                    if undecided != 0 {
                        let lanes = &mut lanes[..count];
                        walker.decide_attributes(0, row.span, mask, undecided, lanes);
                    }
                }
                let first = [row.column_at(block), row.first[1]];
                let at = BlockAt { first, columns: 16, span: Some(row.span), mask };
                self.brush.lanes.find(rest, walker, at);
                self.brush.paint_block(simd, at, 0..count, &found, pixels, stored.get_mut(done));
            }
            walker.advance(1);
        }
        all
    }
}
