//! What the machine can do, for ratios: an idealised loop, and filling memory.

use fearless_simd::{Level, Simd, SimdBase, SimdFloat, dispatch, f32x16};
use hyperspan::Aligned;
use hyperspan::shade::BLOCK;

use super::rungs::COUNT_F32;
use crate::failure::Failure;

/// Two attributes with perspective in `f32`, start + k * step along whole rows: spans, gradients
/// and promises cost nothing. Their bits are stored together, as the rungs' are.
#[derive(Debug)]
pub(crate) struct Yardstick {
    level: Level,
    size: [usize; 2],
    pixels: Aligned<u32>,
}

impl Yardstick {
    /// A picture of `size`.
    pub(crate) fn new(level: Level, size: [u32; 2]) -> Result<Self, Failure> {
        let size = size.map(|side| side as usize);
        Ok(Self { level, size, pixels: Aligned::filled(0, size[0] * size[1])? })
    }

    /// Pixels that it draws.
    pub(crate) fn area(&self) -> usize {
        self.pixels.len()
    }

    /// The idealised loop, over all of the picture.
    pub(crate) fn draw(&mut self) {
        dispatch!(self.level, simd => self.draw_with(simd));
        std::hint::black_box(&mut self.pixels);
    }

    #[inline(always)]
    fn draw_with<S: Simd>(&mut self, simd: S) {
        let count = f32x16::from_slice(simd, &COUNT_F32);
        let one = f32x16::splat(simd, 1.0);
        let scale = 1.0 / (self.size[0] + self.size[1]) as f32;
        let mut y = 0.0;
        for row in self.pixels.chunks_exact_mut(self.size[0]) {
            let mut x = 0.0;
            for pixels in row.as_chunks_mut::<BLOCK>().0 {
                let along = count + f32x16::splat(simd, x);
                let w = one / (along * scale + (0.1 + y * scale));
                let u = (along * (0.3 * scale) + y * scale) * w;
                let v = (along * (0.7 * scale) + (0.2 - y * scale)) * w;
                (u.to_bits() ^ v.to_bits()).store_slice(pixels);
                x += BLOCK as f32;
            }
            y += 1.0;
        }
    }

    /// Fills the same memory.
    pub(crate) fn fill(&mut self) {
        self.pixels.fill(std::hint::black_box(7));
        std::hint::black_box(&mut self.pixels);
    }
}
