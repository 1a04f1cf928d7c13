//! Blocks of small triangles, and of short spans: patches of a few columns and rows.

use fearless_simd::Simd;

use super::small::test_pixels;
use super::{BlockAt, Canvas, quantity_of};
use crate::patch::Patch;
use crate::shade::{BLOCK, Shader};
use crate::span::{InPatch, Values, Walker};
use crate::target::{DepthBuffer, Target};

impl<S: Shader, T: Target<Pixel = S::Pixel>> Canvas<'_, S, T> {
    /// Walks `patches`: depth, then attributes, then the shader. Says no, with nothing done, where
    /// attributes need spans.
    #[inline(always)]
    pub(super) fn paint_patches<L: Simd>(
        &mut self,
        walker: &mut Walker<'_, L, InPatch<L>>,
        patches: &[Patch],
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) -> bool {
        let (origin, test) = (self.brush.place.origin, self.brush.place.test);
        let mut needs_no_spans = S::INPUTS.attributes == 0;
        for patch in patches.iter().copied() {
            let Patch { first, columns, mut mask, .. } = patch;
            walker.seek(patch);
            if let Some(buffer) = depth.as_deref_mut() {
                let found = self.brush.lanes.of_mut(test.source);
                walker.evaluate(quantity_of(test.source), None, mask, found);
                // What passes is stored once it is known that no spans are needed.
                mask = test_pixels(buffer, patch, &self.brush.place, found, false);
            }
            if mask == 0 {
                continue;
            }
            if !needs_no_spans && walker.needs_spans(self.brush.lanes.attributes) {
                return false;
            }
            needs_no_spans = true;
            let mut pixels = [S::Pixel::default(); BLOCK];
            let block = BlockAt { first, columns, span: None, mask };
            let mut left = self.brush.shade(walker, block, &mut pixels);
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let [x, y] = patch.place(lane, origin);
                // A pixel at a time: nothing predicts how long a run is.
                self.target.write_pixel(x, y, pixels[lane]);
                if let Some(buffer) = depth.as_deref_mut()
                    && test.write
                {
                    buffer.set_tested(x, y, self.brush.lanes.of(test.source)[lane]);
                }
            }
        }
        true
    }
}
