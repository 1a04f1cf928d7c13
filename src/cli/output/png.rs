//! PNG: pictures as they are, and data made visible. Data as PNG is for looking at; exact
//! values are what `.npy` is for.

use std::io::Write;

use hyperspan::shade::unorm8;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::aov::Aov;
use crate::canvas::Drawn;
use crate::failure::Failure;

/// Writes RGBA8 as it is, straight alpha.
pub(crate) fn write_rgba_png(
    out: &mut dyn Write,
    pixels: &[[u8; 4]],
    width: u32,
    height: u32,
) -> Result<(), Failure> {
    encode(out, pixels.as_flattened(), width, height, ExtendedColorType::Rgba8)
}

/// Writes one byte for each pixel.
pub(crate) fn write_gray_png(
    out: &mut dyn Write,
    pixels: &[u8],
    width: u32,
    height: u32,
) -> Result<(), Failure> {
    encode(out, pixels, width, height, ExtendedColorType::L8)
}

/// Writes data so that it can be looked at: ids in colours of their own, counts from black (0)
/// to white (the most), normals as n/2 + 1/2, (u, v) without their whole parts, colours
/// rounded, and all else stretched from dark (least) to bright (greatest), 0 in black.
pub(crate) fn write_data_png(
    out: &mut dyn Write,
    aov: Aov,
    data: Drawn<'_>,
    width: u32,
    height: u32,
) -> Result<(), Failure> {
    let (values, channels) = match data {
        Drawn::Integers { values } if aov == Aov::Id => {
            let colours: Vec<[u8; 4]> = values.iter().map(|id| id_colour(*id)).collect();
            return write_rgba_png(out, &colours, width, height);
        }
        Drawn::Integers { values } => {
            let most = values.iter().max().copied().unwrap_or(0).max(1);
            #[expect(clippy::cast_possible_truncation, reason = "at most 255")]
            let gray = |count: &u32| (u64::from(*count) * 255 / u64::from(most)) as u8;
            let grays: Vec<u8> = values.iter().map(gray).collect();
            return write_gray_png(out, &grays, width, height);
        }
        Drawn::Floats { values, channels } => (values, channels),
    };
    if aov == Aov::Color {
        let bytes: Vec<u8> = values.iter().map(|value| unorm8(*value)).collect();
        return encode(out, &bytes, width, height, ExtendedColorType::Rgba8);
    }
    let stretch = |c| Stretch::of(values.iter().skip(c).step_by(channels.max(1)).copied());
    let stretches = [stretch(0), stretch(1), stretch(2)];
    let shown = |pixel: usize, c: usize| {
        let value = values.get(pixel * channels + c).filter(|_| c < channels);
        value.map_or(0, |value| match aov {
            Aov::Uv => unorm8(value - value.floor()),
            Aov::Normal => unorm8(value * 0.5 + 0.5),
            _ => stretches[c].apply(*value),
        })
    };
    let pixels = 0..width as usize * height as usize;
    if channels <= 1 {
        let grays: Vec<u8> = pixels.map(|pixel| shown(pixel, 0)).collect();
        return write_gray_png(out, &grays, width, height);
    }
    let colours: Vec<[u8; 3]> = pixels.map(|i| [0, 1, 2].map(|c| shown(i, c))).collect();
    encode(out, colours.as_flattened(), width, height, ExtendedColorType::Rgb8)
}

/// A colour that neighbours in number do not share; white where there is no polygon.
fn id_colour(id: u32) -> [u8; 4] {
    if id == u32::MAX {
        return [255; 4];
    }
    // The finaliser of MurmurHash3 spreads every bit.
    let mut bits = id.wrapping_add(1);
    bits = (bits ^ (bits >> 16)).wrapping_mul(0x85EB_CA6B);
    bits = (bits ^ (bits >> 13)).wrapping_mul(0xC2B2_AE35);
    bits ^= bits >> 16;
    let [r, g, b, _] = bits.to_le_bytes();
    [r, g, b, 255]
}

/// The least and the greatest finite value but 0, which is what most data is cleared to.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    least: f32,
    greatest: f32,
}

impl Stretch {
    fn of(values: impl Iterator<Item = f32>) -> Self {
        let none = Self { least: f32::INFINITY, greatest: f32::NEG_INFINITY };
        values.filter(|value| value.is_finite() && *value != 0.0).fold(none, |all, value| Self {
            least: all.least.min(value),
            greatest: all.greatest.max(value),
        })
    }

    /// 0 and NaN in black, all else from dark gray to white.
    fn apply(self, value: f32) -> u8 {
        const DARKEST: f32 = 0.1;
        if value == 0.0 || value.is_nan() {
            return 0;
        }
        // Halved, so that the widest range does not overflow.
        let range = self.greatest * 0.5 - self.least * 0.5;
        let part = if range > 0.0 { (value * 0.5 - self.least * 0.5) / range } else { 1.0 };
        unorm8(DARKEST + (1.0 - DARKEST) * part)
    }
}

fn encode(
    out: &mut dyn Write,
    bytes: &[u8],
    width: u32,
    height: u32,
    kind: ExtendedColorType,
) -> Result<(), Failure> {
    PngEncoder::new_with_quality(out, CompressionType::Fast, FilterType::Adaptive)
        .write_image(bytes, width, height, kind)
        .map_err(|e| Failure::new(format!("cannot write the PNG: {e}")))
}
