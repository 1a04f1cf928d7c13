//! Texture files: PNG and JPEG, with limits, since a header may lie.

use std::fs;
use std::io::{self, Cursor};
use std::path::Path;

use hyperspan::texture::Texture;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use crate::failure::{Failure, Place};

/// Bytes that a texture may take: a small file may ask for many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TextureLimit(pub(crate) u64);

impl Default for TextureLimit {
    /// 4 GiB.
    fn default() -> Self {
        Self(4 << 30)
    }
}

/// Reads a texture; nothing if there is no such file.
pub(super) fn read(path: &Path, limit: TextureLimit) -> Result<Option<Texture>, Failure> {
    match fs::metadata(path) {
        Err(e) if is_missing(&e) => return Ok(None),
        Err(e) => return Err(Failure::io(path, "read", &e)),
        Ok(found) if !found.is_file() => return Err(bad(path, "it is no regular file")),
        Ok(_) => {}
    }
    let bytes = fs::read(path).map_err(|e| Failure::io(path, "read", &e))?;
    decode(&bytes, path, limit).map(Some)
}

/// The texture of a file with these `bytes`, which messages call `path`.
pub(super) fn decode(bytes: &[u8], path: &Path, limit: TextureLimit) -> Result<Texture, Failure> {
    const MOST_TEXELS_A_SIDE: u32 = 1 << 15;

    // What a byte can be of at most: of PNG, 1032 bytes of 8 pixels; of JPEG, a bit for a block of 8 x 8.
    const MOST_TEXELS_A_BYTE: [u64; 2] = [1032 * 8, 8 * 64];

    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|e| Failure::io(path, "read", &e))?;
    let most_a_byte = match reader.format() {
        Some(ImageFormat::Png) => MOST_TEXELS_A_BYTE[0],
        Some(ImageFormat::Jpeg) if jpeg_ends(bytes) => MOST_TEXELS_A_BYTE[1],
        Some(ImageFormat::Jpeg) => return Err(bad(path, "it is cut short")),
        _ => return Err(bad(path, "it is neither PNG nor JPEG")),
    };
    let mut limits = Limits::default();
    limits.max_image_width = Some(MOST_TEXELS_A_SIDE);
    limits.max_image_height = Some(MOST_TEXELS_A_SIDE);
    limits.max_alloc = Some(limit.0);
    reader.limits(limits);
    let failed = |e: ImageError| match e {
        ImageError::Limits(e) => bad(path, &format!("it is too large ({e})")),
        e => bad(path, &e.to_string()),
    };
    let decoder = reader.into_decoder().map_err(failed)?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > most_a_byte * bytes.len() as u64 {
        let size = format!("it says that it has {width} x {height} pixels, and cannot");
        return Err(bad(path, &size));
    }
    let taken = decoder.total_bytes().max(u64::from(width) * u64::from(height) * 4);
    if taken > limit.0 {
        let what = format!("it takes {} MiB; --texture-limit allows more", taken >> 20);
        return Err(bad(path, &what));
    }
    let picture = DynamicImage::from_decoder(decoder).map_err(failed)?;
    let mut picture = picture.into_rgba8();
    // Whatever the file's alpha, nothing shines through.
    picture.pixels_mut().for_each(|pixel| pixel.0[3] = u8::MAX);
    let (width, height) = picture.dimensions();
    let texture = Texture::new(width, height, picture.as_chunks().0);
    texture.map_err(|e| bad(path, &e.to_string()))
}

/// Is there no file of that name, nor could there be?
pub(super) fn is_missing(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory | io::ErrorKind::InvalidFilename
    )
}

/// Is there an end-of-image marker behind the last scan? The decoder does not mind if there is
/// none, and makes up the rest.
fn jpeg_ends(bytes: &[u8]) -> bool {
    let last = |marker: [u8; 2]| bytes.array_windows().rposition(|pair| *pair == marker);
    last([0xFF, 0xD9]) > last([0xFF, 0xDA])
}

fn bad(path: &Path, why: &str) -> Failure {
    Failure::at(
        Place::file(path),
        format!("cannot use this picture as a texture: {why}; save it as PNG or JPEG again"),
    )
}
