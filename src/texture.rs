//! Textures: which texel a pair of coordinates names.

use alloc::vec::Vec;

use crate::error::Error;

/// A picture to look up: RGBA8 texels, row 0 on top, lookups repeat in both directions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    width: u32,
    height: u32,
    /// Row 0 is v = 0, the lowest of the picture.
    texels: Vec<[u8; 4]>,
}

impl Texture {
    /// A texture of `width` x `height` texels, rows from the top, v = 0 at the bottom (OBJ's
    /// way; for v = 0 at the top, as in glTF, hand the rows in from the bottom).
    ///
    /// # Errors
    /// [`Error::TextureSize`] unless there are `width * height` texels, at least one, and both
    /// sides are below 2^31.
    pub fn new(width: u32, height: u32, rows: &[[u8; 4]]) -> Result<Self, Error> {
        let wrong = Error::TextureSize { width, height, given: rows.len() };
        if (width as usize).checked_mul(height as usize) != Some(rows.len())
            || rows.is_empty()
            || width.max(height) > i32::MAX as u32
        {
            return Err(wrong);
        }
        let texels = rows.rchunks_exact(width as usize).flatten().copied().collect();
        Ok(Self { width, height, texels })
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
        let (column, row) = match (floor_wrap(u, self.width), floor_wrap(v, self.height)) {
            (Some(column), Some(row)) => (column, row),
            _ => (0, 0),
        };
        self.texels[row * self.width as usize + column]
    }
}

/// floor(`coordinate` * `size`) mod `size`, or nothing where the product is no `i32`.
#[inline]
fn floor_wrap(coordinate: f32, size: u32) -> Option<usize> {
    #[expect(clippy::cast_precision_loss, reason = "the product is defined in f32")]
    let product = coordinate * size as f32;
    // Also refuses NaN.
    let in_range = product > -2_147_483_648.0 && product < 2_147_483_648.0;
    if !in_range {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, reason = "truncation, put right below")]
    let truncated = product as i64;
    #[expect(clippy::cast_precision_loss, reason = "an integer that was an f32 is one again")]
    let floor = truncated - i64::from(truncated as f32 > product);
    usize::try_from(floor.rem_euclid(i64::from(size))).ok()
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
        assert_eq!(texture.nearest(f32::NAN, 0.6), [3; 4]);
        assert_eq!(texture.nearest(1.0, f32::INFINITY), [3; 4]);
        assert_eq!(texture.nearest(7.5, 5.5), [1; 4]);
    }

    #[test]
    fn texture_sizes_are_checked() {
        assert!(Texture::new(0, 0, &[]).is_err());
        assert!(Texture::new(2, 2, &[[0; 4]; 3]).is_err());
    }
}
