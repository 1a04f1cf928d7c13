//! Textures: which texel a pair of coordinates names.

use alloc::vec::Vec;

use crate::error::Error;
use crate::shade::{BLOCK, Block, ROW};

/// A picture to look up: RGBA8 texels, row 0 on top, lookups repeat in both directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    width: u32,
    height: u32,
    /// The same, to multiply by.
    scale: [f32; 2],
    /// If both are powers of two and not above [`LARGEST`]: a column's bits, a row's, and how far a row is shifted.
    masks: Option<(u32, u32, u32)>,
    /// Row 0 is v = 0, the lowest of the picture.
    texels: Vec<[u8; 4]>,
}

impl Texture {
    /// A texture of `width` x `height` texels, rows from the top, v = 0 at the bottom (OBJ's
    /// way; for v = 0 at the top, as in glTF, hand the rows in from the bottom).
    ///
    /// # Errors
    /// [`Error::TextureSize`] unless there are `width * height` texels, at least one, and fewer
    /// than 2^31.
    pub fn new(width: u32, height: u32, rows: &[[u8; 4]]) -> Result<Self, Error> {
        let wrong = Error::TextureSize { width, height, given: rows.len() };
        if (width as usize).checked_mul(height as usize) != Some(rows.len())
            || rows.is_empty()
            || rows.len() > i32::MAX as usize
        {
            return Err(wrong);
        }
        let texels = rows.rchunks_exact(width as usize).flatten().copied().collect();
        #[expect(clippy::cast_precision_loss, reason = "the products are defined in f32")]
        let scale = [width as f32, height as f32];
        let usual = |side: u32| side.is_power_of_two() && side <= LARGEST;
        let masks = (usual(width) && usual(height))
            .then(|| (width - 1, height - 1, width.trailing_zeros()));
        Ok(Self { width, height, scale, masks, texels })
    }

    /// (width, height) in texels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The nearest texel: column floor(u W) mod W, and row floor(v H) mod H counted from the
    /// bottom, the products in `f32`. A product that is NaN or not below 2^31 in magnitude
    /// takes texel (0, 0).
    #[inline]
    pub fn nearest(&self, u: f32, v: f32) -> [u8; 4] {
        let mut texel = [[0; 4]; BLOCK];
        self.nearest_block(&[u; BLOCK], &[v; BLOCK], 1, &mut texel);
        texel[0]
    }

    /// [`nearest`](Self::nearest) for the lanes of `mask`; the others of `out` hold any texel.
    /// Sides that are powers of two are faster.
    #[inline(always)]
    pub fn nearest_block(
        &self,
        u: &[f32; BLOCK],
        v: &[f32; BLOCK],
        mask: u16,
        out: &mut [[u8; 4]; BLOCK],
    ) {
        let mut index = [[0; BLOCK]];
        self.find([[u, v]], &mut index);
        // Lane by lane only where that is little: nothing predicts how many there are.
        if mask.count_ones() > FEW {
            look_up(&self.texels, &index, core::array::from_mut(out));
        } else {
            let [index] = &index;
            let mut left = mask;
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                out[lane] = self.texels[index[lane] as usize];
            }
        }
    }

    /// [`nearest`](Self::nearest) for all lanes of `blocks`, at attributes `u` and `v`: what
    /// [`Shader::shade_row`](crate::shade::Shader::shade_row) is for, and faster than one block after the
    /// other. An attribute that there is none of is NaN.
    #[inline(always)]
    pub fn nearest_row(
        &self,
        blocks: &[Block<'_>; ROW],
        [u, v]: [usize; 2],
        out: &mut [[[u8; 4]; BLOCK]; ROW],
    ) {
        // Not by `map` over all four: that is a call.
        let [a, b, c, d] = blocks;
        let uvs = [uv_of(a, u, v), uv_of(b, u, v), uv_of(c, u, v), uv_of(d, u, v)];
        let mut index = [[0; BLOCK]; ROW];
        self.find(uvs, &mut index);
        look_up(&self.texels, &index, out);
    }

    /// The number of each lane's texel.
    #[inline(always)]
    fn find<const N: usize>(&self, uvs: [Uv<'_>; N], index: &mut [[u32; BLOCK]; N]) {
        if let Some((column_mask, row_mask, shift)) = self.masks {
            // They go into [`LARGEST`].
            let wrap = |column, row| (column & column_mask) + ((row & row_mask) << shift);
            self.find_by(uvs, index, wrap);
        } else {
            let of = |floor: u32| floor.wrapping_sub(WHOLE.to_bits()).cast_signed();
            self.find_by(uvs, index, |column, row| self.wrap(of(column), of(row)));
        }
    }

    /// The same, where `wrap` makes it of column and row, both too large by the bits of [`WHOLE`].
    #[inline(always)]
    fn find_by<const N: usize>(
        &self,
        uvs: [Uv<'_>; N],
        index: &mut [[u32; BLOCK]; N],
        wrap: impl Fn(u32, u32) -> u32,
    ) {
        let [width, height] = self.scale;
        // A lane for each: of a single sum the compiler makes one across all lanes after every block.
        let mut beyond = [0; BLOCK];
        for i in 0..N {
            let [u, v] = uvs[i];
            for lane in 0..BLOCK {
                let (column, row) = (Floor::of(u[lane] * width), Floor::of(v[lane] * height));
                beyond[lane] |= column.beyond | row.beyond;
                index[i][lane] = wrap(column.floor, row.floor);
            }
        }
        // One look at all of them.
        if beyond.iter().fold(0, |all, beyond| all | beyond) > LOW_BITS {
            self.find_far(&uvs, index);
        }
    }

    /// The same, however large they are; out of line.
    #[cold]
    #[inline(never)]
    fn find_far(&self, uvs: &[Uv<'_>], index: &mut [[u32; BLOCK]]) {
        let [width, height] = self.scale;
        for (index, [u, v]) in index.iter_mut().zip(uvs) {
            for lane in 0..BLOCK {
                let (column, row) = (floor(u[lane] * width), floor(v[lane] * height));
                let both = column.zip(row);
                index[lane] = both.map_or(0, |(column, row)| self.wrap(column, row));
            }
        }
    }

    /// The number of a texel, if the texture repeats.
    #[inline(always)]
    fn wrap(&self, column: i32, row: i32) -> u32 {
        // Both sides are below 2^31.
        let (width, height) = (self.width.cast_signed(), self.height.cast_signed());
        let (column, row) = (column.rem_euclid(width), row.rem_euclid(height));
        column.cast_unsigned().wrapping_add(row.cast_unsigned().wrapping_mul(self.width))
    }
}

/// Coordinates of a block.
type Uv<'a> = [&'a [f32; BLOCK]; 2];

/// Attributes `u` and `v` of `block`.
#[inline(always)]
fn uv_of<'a>(block: &Block<'a>, u: usize, v: usize) -> Uv<'a> {
    const NONE: [f32; BLOCK] = [f32::NAN; BLOCK];
    let attribute = |k: usize| block.attributes.get(k).unwrap_or(&NONE);
    [attribute(u), attribute(v)]
}

/// So many lanes are looked up one by one.
const FEW: u32 = 3;

/// Its sum with a number below 2^22 in magnitude has the same exponent and no room for a fraction:
/// its low bits are the nearest whole number. A conversion would do, but it saturates, which
/// vectors do not.
const WHOLE: f32 = 12_582_912.0;

/// 2^22, up to which that is so.
const LARGEST: u32 = 1 << 22;

/// The bits of a sum that are not its exponent.
const LOW_BITS: u32 = (1 << 23) - 1;

/// The floor of a number that a sum with [`WHOLE`] holds.
struct Floor {
    /// Above [`LOW_BITS`] if the sum does not hold the number.
    beyond: u32,
    /// Too large by the bits of [`WHOLE`], of which the lowest 22 are 0.
    floor: u32,
}

impl Floor {
    #[inline(always)]
    fn of(product: f32) -> Self {
        let sum = product + WHOLE;
        // The sign of what it is too large by: a comparison would be a mask, and take a way round.
        // Summed in this order, of a product of -0 it is +0.
        let above = ((WHOLE - sum) + product).to_bits().cast_signed() >> 31;
        let sum = sum.to_bits();
        Self { beyond: sum ^ (WHOLE.to_bits() & !LOW_BITS), floor: sum.wrapping_add_signed(above) }
    }
}

/// The texels of all lanes of some blocks.
///
/// Not inlined: where the compiler knows AVX-512 it makes gathers of it, which take longer than one load after
/// the other, and where it is short of registers it keeps them in memory.
#[inline(never)]
fn look_up<const N: usize>(
    texels: &[[u8; 4]],
    index: &[[u32; BLOCK]; N],
    out: &mut [[[u8; 4]; BLOCK]; N],
) {
    // Squares whose sides are a power of two: where the compiler knows the length, it is checked
    // once for all lanes.
    macro_rules! squares {
        ($($side:literal)+) => { $(
            if let Ok(texels) = <&[[u8; 4]; $side * $side]>::try_from(texels) {
                for (out, index) in out.iter_mut().zip(index) {
                    for lane in 0..BLOCK {
                        out[lane] = texels[index[lane] as usize % ($side * $side)];
                    }
                }
                return;
            }
        )+ };
    }
    squares!(64 128 256 512 1024 2048 4096);
    for (out, index) in out.as_flattened_mut().iter_mut().zip(index.as_flattened()) {
        *out = texels[*index as usize];
    }
}

/// floor(`product`), if `product` is less than 2^31 in magnitude (NaN is not).
fn floor(product: f32) -> Option<i32> {
    #[expect(clippy::cast_possible_truncation, reason = "below 2^31")]
    let towards_zero = product as i32;
    #[expect(clippy::cast_precision_loss, reason = "it was a f32: exact")]
    let above = i32::from(towards_zero as f32 > product);
    (product.abs() < 2_147_483_648.0).then(|| towards_zero - above)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_lookups_floor_and_wrap() {
        let rows: Vec<[u8; 4]> = (0..6).map(|i| [i; 4]).collect();
        let texture = Texture::new(3, 2, &rows).expect("3 x 2 texels");
        assert_eq!(texture.nearest(0.0, 0.0), [3; 4], "v = 0 is the bottom row");
        assert_eq!(texture.nearest(0.999, 0.999), [2; 4]);
        assert_eq!(texture.nearest(-0.001, -0.001), [2; 4], "floor, not truncation");
        assert_eq!(texture.nearest(-1e-30, 0.0), [5; 4], "a hair below 0 is the last column");
        assert_eq!(texture.nearest(-0.0, -0.0), [3; 4], "the floor of -0 is 0");
        assert_eq!(texture.nearest(f32::NAN, 0.6), [3; 4]);
        assert_eq!(texture.nearest(1.0, f32::INFINITY), [3; 4]);
        assert_eq!(texture.nearest(7.5, 5.5), [1; 4]);
    }

    /// Where a sum does not hold the product any more, and around whole numbers.
    #[test]
    fn texture_lookups_floor_at_every_size() {
        for (width, height) in [(8_u8, 4_u8), (6, 5)] {
            let rows: Vec<[u8; 4]> = (0..height)
                .flat_map(|row| (0..width).map(move |column| [column, height - 1 - row, 0, 0]))
                .collect();
            let texture = Texture::new(width.into(), height.into(), &rows).expect("small");
            let sides = [4_194_303.0, 4_194_304.0, 4_194_305.0, 8_388_608.0, 1e9, 3.0, 0.0_f32];
            let beside = [-2.0, -0.5, -0.25, -1e-7, -0.0, 0.0, 1e-30, 0.25, 0.5, 1.0];
            let all = sides.into_iter().flat_map(|side| beside.map(|b| side + b));
            for c in all.flat_map(|c| [c, -c]) {
                let of = |coordinate: f32, side: u8| {
                    let floor = f64::from(coordinate * f32::from(side)).floor();
                    floor.rem_euclid(f64::from(side))
                };
                let (u, v) = (c / f32::from(width), -c / f32::from(height));
                let [column, row, ..] = texture.nearest(u, v).map(f64::from);
                assert_eq!([column, row], [of(u, width), of(v, height)], "{u:e} {v:e}");
            }
        }
    }

    /// One lane of one block that is far off, or none; and a texture of any size.
    #[test]
    fn texture_lookups_of_rows_are_those_of_pixels() {
        for (width, height) in [(8, 4), (6, 5), (64, 64)] {
            let rows: Vec<[u8; 4]> = (0..width * height).map(|i: u32| i.to_le_bytes()).collect();
            let texture = Texture::new(width, height, &rows).expect("small");
            for far in [None, Some((0, 0)), Some((2, 9)), Some((3, 15))] {
                let mut attributes = [[[0.25; BLOCK]; 3]; ROW];
                for (i, attributes) in (0_u8..).zip(&mut attributes) {
                    for lane in 0..BLOCK as u8 {
                        let at = f32::from(i) + f32::from(lane) / 7.0;
                        attributes[0][usize::from(lane)] = 1.3 - at * 0.43;
                        attributes[2][usize::from(lane)] = at * 0.37 - 0.9;
                    }
                }
                if let Some((i, lane)) = far {
                    attributes[i][2][lane] = 1e9;
                }
                let blocks = attributes.each_ref().map(|attributes| Block {
                    first: [0, 0],
                    columns: 16,
                    mask: u16::MAX,
                    depth: &[0.0; BLOCK],
                    inv_w: &[0.0; BLOCK],
                    w: &[0.0; BLOCK],
                    attributes,
                });
                let mut out = [[[0; 4]; BLOCK]; ROW];
                texture.nearest_row(&blocks, [0, 2], &mut out);
                let one =
                    |[u, _, v]: &[[f32; BLOCK]; 3], lane: usize| texture.nearest(u[lane], v[lane]);
                for (out, attributes) in out.iter().zip(&attributes) {
                    assert_eq!(*out, core::array::from_fn(|lane| one(attributes, lane)));
                }
                texture.nearest_row(&blocks, [0, 3], &mut out);
                assert_eq!(out, [[texture.nearest(f32::NAN, 0.0); BLOCK]; ROW], "no attribute 3");
            }
        }
    }

    #[test]
    fn texture_sizes_are_checked() {
        assert!(Texture::new(0, 0, &[]).is_err());
        assert!(Texture::new(2, 2, &[[0; 4]; 3]).is_err());
    }
}
