//! Blocks of small triangles: patches of a few columns and rows.

use fearless_simd::Simd;

use super::{BlockAt, Canvas, passing_lanes, quantity_of};
use crate::patch::{Patch, Patches};
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
        patches: &Patches,
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) -> bool {
        let (origin, test) = (self.brush.place.origin, self.brush.place.test);
        let mut needs_no_spans = S::INPUTS.attributes == 0;
        for i in 0..patches.count() {
            let patch = patches.patch(i);
            let Patch { first, columns, mut mask, .. } = patch;
            if mask == 0 {
                continue;
            }
            walker.seek(patch);
            if let Some(buffer) = depth.as_deref() {
                let found = self.brush.lanes.of_mut(test.source);
                walker.evaluate(quantity_of(test.source), None, mask, found);
                let stored = stored_depths(buffer, patch, origin);
                mask &= passing_lanes(walker.simd, test.compare, found, &stored);
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

/// The depths stored at the covered lanes of `patch`, where they are in the buffer.
#[inline(always)]
fn stored_depths(buffer: &DepthBuffer<'_>, patch: Patch, origin: [i32; 2]) -> [f32; BLOCK] {
    let columns = usize::from(patch.columns);
    let [x, y] = patch.place(0, origin);
    let (width, height) = buffer.dimensions();
    // Rows one after the other, each over the end of the one before.
    let mut stored = [0.0; 2 * BLOCK];
    let inside = u64::from(x) + 16 <= u64::from(width) && u64::from(y) + 16 <= u64::from(height);
    // The smallest have no more than two rows. Where others end is nothing that could be predicted.
    let needed = BLOCK - patch.mask.leading_zeros() as usize;
    let end = if needed <= 2 * columns { BLOCK.min(2 * columns) } else { BLOCK };
    let mut lane = 0;
    if inside {
        let mut y = y;
        while lane < end {
            let start = x as usize;
            stored[lane..lane + BLOCK].copy_from_slice(&buffer.row(y)[start..start + BLOCK]);
            lane += columns;
            y += 1;
        }
    } else {
        // Near the buffer's end, or beyond it on any side.
        while lane < end {
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
