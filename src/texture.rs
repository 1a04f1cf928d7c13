//! Textures: which texel a pair of coordinates names.

use alloc::vec::Vec;

use crate::error::Error;
use crate::shade::BLOCK;

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
        let index = if let Some((column_mask, row_mask, shift)) = self.masks {
            // They go into `LARGEST`.
            self.find(u, v, |column, row| (column & column_mask) + ((row & row_mask) << shift))
        } else {
            // Both sides are below 2^31.
            let (width, height) = (self.width.cast_signed(), self.height.cast_signed());
            self.find(u, v, |column, row| {
                let of = |floor: u32| floor.wrapping_sub(LARGEST).cast_signed();
                let (column, row) = (of(column).rem_euclid(width), of(row).rem_euclid(height));
                column.cast_unsigned().wrapping_add(row.cast_unsigned().wrapping_mul(self.width))
            })
        };
        // Lane by lane only where that is little: nothing predicts how many there are.
        if mask.count_ones() > FEW {
            look_up(&self.texels, &index, out);
        } else {
            let mut left = mask;
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                out[lane] = self.texels[index[lane] as usize];
            }
        }
    }

    /// The number of each lane's texel, where `wrap` makes it of column and row, both too large by
    /// [`LARGEST`].
    #[inline(always)]
    fn find(
        &self,
        u: &[f32; BLOCK],
        v: &[f32; BLOCK],
        wrap: impl Fn(u32, u32) -> u32,
    ) -> [u32; BLOCK] {
        let mut index = [0; BLOCK];
        let [width, height] = self.scale;
        let mut sums = 0;
        for lane in 0..BLOCK {
            let (column, row) = (Floor::of(u[lane] * width), Floor::of(v[lane] * height));
            sums |= column.sum | row.sum;
            index[lane] = wrap(column.floor, row.floor);
        }
        if sums >= 2 * LARGEST {
            let of = |floor: i32| floor.cast_unsigned().wrapping_add(LARGEST);
            for lane in 0..BLOCK {
                let both = (floor(u[lane] * width), floor(v[lane] * height));
                index[lane] = if let (Some(c), Some(r)) = both { wrap(of(c), of(r)) } else { 0 };
            }
        }
        index
    }
}

/// So many lanes are looked up one by one.
const FEW: u32 = 3;

/// Its sum with a number below 2^22 in magnitude has the same exponent and no room for a fraction:
/// its low bits are the nearest whole number. A conversion would do, but it saturates, which
/// vectors do not.
const WHOLE: f32 = 12_582_912.0;

/// 2^22, up to which that is so.
const LARGEST: u32 = 1 << 22;

/// The floor of a number that a sum with [`WHOLE`] holds.
struct Floor {
    /// The nearest whole number and [`LARGEST`]: from 0 to twice that, if the sum holds the number.
    sum: u32,
    /// Too large by the same, so that no sign is in the way.
    floor: u32,
}

impl Floor {
    #[inline(always)]
    fn of(product: f32) -> Self {
        let sum = product + WHOLE;
        // The sign of what it is too large by: a comparison would be a mask, and take a way round.
        // Summed in this order, of a product of -0 it is +0.
        let above = ((WHOLE - sum) + product).to_bits().cast_signed() >> 31;
        let sum = sum.to_bits().wrapping_sub(WHOLE.to_bits() - LARGEST);
        Self { sum, floor: sum.wrapping_add_signed(above) }
    }
}

/// The texels of all lanes.
#[inline(always)]
fn look_up(texels: &[[u8; 4]], index: &[u32; BLOCK], out: &mut [[u8; 4]; BLOCK]) {
    // Squares whose sides are a power of two: where the compiler knows the length, it is checked
    // once for all lanes.
    macro_rules! squares {
        ($($side:literal)+) => { $(
            if let Ok(texels) = <&[[u8; 4]; $side * $side]>::try_from(texels) {
                for (out, index) in out.iter_mut().zip(index) {
                    *out = texels[*index as usize % ($side * $side)];
                }
                return;
            }
        )+ };
    }
    squares!(64 128 256 512 1024 2048 4096);
    for (out, index) in out.iter_mut().zip(index) {
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

    #[test]
    fn texture_sizes_are_checked() {
        assert!(Texture::new(0, 0, &[]).is_err());
        assert!(Texture::new(2, 2, &[[0; 4]; 3]).is_err());
    }
}
