//! What reads the values: the same for every rung.

use hyperspan::shade::{BLOCK, Block, Inputs, ROW, Shader};
use hyperspan::texture::Texture;

/// The bits of `N` attributes together: reads them all, and does nothing else.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bits<const N: usize>;

impl<const N: usize> Shader for Bits<N> {
    type Pixel = u32;
    const INPUTS: Inputs = Inputs::attributes(N);
    const KEEPS_ALL: bool = true;

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, out: &mut [u32; BLOCK]) -> u16 {
        // A number of attributes that is known: else the compiler does it lane by lane.
        let Some(attributes) = block.attributes.first_chunk::<N>() else { return 0 };
        for lane in 0..BLOCK {
            let mut bits = 0;
            for attribute in attributes {
                bits ^= attribute[lane].to_bits();
            }
            out[lane] = bits;
        }
        block.mask
    }
}

/// The nearest texel at attributes 0 and 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Textured<'a>(pub(crate) &'a Texture);

impl Shader for Textured<'_> {
    type Pixel = [u8; 4];
    const INPUTS: Inputs = Inputs::attributes(2);
    const KEEPS_ALL: bool = true;

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, out: &mut [[u8; 4]; BLOCK]) -> u16 {
        let Some([u, v]) = block.attributes.first_chunk::<2>() else { return 0 };
        self.0.nearest_block(u, v, block.mask, out);
        block.mask
    }

    #[inline(always)]
    fn shade_row(&mut self, blocks: &[Block<'_>; ROW], out: &mut [[[u8; 4]; BLOCK]; ROW]) {
        self.0.nearest_row(blocks, [0, 1], out);
    }
}

/// Keeps the values at chosen pixels.
#[derive(Debug)]
pub(crate) struct Capture<'a> {
    /// For each pixel of the picture, row by row: the number of its sample, counted from 1, or 0.
    pub(crate) wanted: &'a [u32],
    /// Of the picture.
    pub(crate) width: usize,
    /// The values of a sample: depth, then the attributes.
    pub(crate) stride: usize,
    /// Of all samples.
    pub(crate) values: &'a mut [f32],
    /// How many pixels were covered.
    pub(crate) pixels: u64,
}

impl Shader for Capture<'_> {
    type Pixel = ();
    const INPUTS: Inputs = Inputs { depth: true, ..Inputs::attributes(usize::MAX) };

    fn shade(&mut self, block: &Block<'_>, _out: &mut [(); BLOCK]) -> u16 {
        self.pixels += u64::from(block.mask.count_ones());
        let mut left = block.mask;
        while left != 0 {
            let lane = left.trailing_zeros() as u16;
            left &= left - 1;
            let [x, y] = [block.x(lane), block.y(lane)].map(i32::cast_unsigned);
            let sample = self.wanted[y as usize * self.width + x as usize] as usize;
            if sample > 0 {
                let values = self.values[(sample - 1) * self.stride..].iter_mut();
                let lane = usize::from(lane);
                let found = [block.depth].into_iter().chain(block.attributes);
                for (value, lanes) in values.zip(found) {
                    *value = lanes[lane];
                }
            }
        }
        block.mask
    }
}
