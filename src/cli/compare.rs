//! `hyperspan compare`: are two pictures, or two arrays, the same?

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use clap::Args;
use image::{DynamicImage, ImageFormat, ImageReader, Limits};

use crate::failure::{Failure, Place, say};
use crate::flags::Sink;
use crate::output::{Array, NPY_MAGIC, Staged, check_place, read_npy, write_gray_png};

/// Compares two pictures (PNG) or two arrays (.npy). Exit code 0: the same, 1: different,
/// 2: they cannot be compared.
#[derive(Clone, Debug, Args)]
pub(crate) struct CompareArgs {
    /// A .png or .npy file.
    a: PathBuf,

    /// A file of the same kind.
    b: PathBuf,

    /// How much values may differ: in steps of 1/255 for pictures, as they are for arrays. NaN
    /// is the same as NaN, and an infinity as itself.
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = tolerance, allow_hyphen_values = true)]
    tolerance: f64,

    /// Writes a picture of the differences: black where there is none, the brighter the
    /// larger.
    #[arg(long, value_name = "OUT.png", value_parser = png_path)]
    diff: Option<PathBuf>,
}

fn tolerance(text: &str) -> Result<f64, String> {
    let wrong = "give a number, 0 or above";
    text.parse().ok().filter(|number| *number >= 0.0).ok_or_else(|| wrong.to_owned())
}

fn png_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_png = path.extension().is_some_and(|found| found.eq_ignore_ascii_case("png"));
    is_png.then_some(path).ok_or_else(|| "the name must end in .png".to_owned())
}

/// Says on standard error how the files of `args` differ; true if they are the same.
pub(crate) fn run(args: &CompareArgs) -> Result<bool, Failure> {
    if let Some(path) = &args.diff {
        check_place(path)?;
    }
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    if a.kind != b.kind {
        return Err(Failure::new(format!(
            "{} is {}, but {} is {}: give two of a kind",
            args.a.display(),
            a.kind.name(),
            args.b.display(),
            b.kind.name()
        )));
    }
    let names = format!("{} and {}", args.a.display(), args.b.display());
    if a.array.shape != b.array.shape {
        let (shape_a, shape_b) = (&a.array.shape, &b.array.shape);
        say(&format!("{names} differ in shape: {shape_a:?} and {shape_b:?}"));
        return Ok(false);
    }
    let comparison = Comparison::new(&a.array, &b.array, args.tolerance);
    if let Some(path) = &args.diff {
        comparison.write_picture(path)?;
    }
    if comparison.different == 0 {
        return Ok(true);
    }
    say(&format!(
        "{names} differ at {} of {} pixels, first at row {}, column {}, most by {}",
        comparison.different,
        comparison.pixels.len(),
        comparison.first / comparison.width.max(1),
        comparison.first % comparison.width.max(1),
        comparison.most,
    ));
    Ok(false)
}

/// What a file turned out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Picture,
    Array,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Picture => "a picture",
            Self::Array => "an array",
        }
    }
}

/// A file's values: of a picture rows x columns x RGBA, in steps of 1/255.
#[derive(Debug)]
struct Loaded {
    kind: Kind,
    array: Array,
}

fn read(path: &Path) -> Result<Loaded, Failure> {
    const MOST_BYTES: u64 = 8 << 30;

    let bytes = fs::read(path).map_err(|e| Failure::io(path, "read", &e))?;
    let bad = |why: &str| Failure::at(Place::file(path), why);
    if bytes.starts_with(NPY_MAGIC) {
        let array =
            read_npy(&bytes).map_err(|why| bad(&format!("cannot read this .npy: {why}")))?;
        return Ok(Loaded { kind: Kind::Array, array });
    }
    if !bytes.starts_with(b"\x89PNG") {
        return Err(bad("this is neither PNG nor .npy: only these can be compared"));
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let picture = reader.decode().map_err(|e| bad(&format!("cannot read this PNG: {e}")))?;
    let shape = vec![picture.height() as usize, picture.width() as usize, 4];
    let values = match picture {
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => {
            picture.into_rgba16().iter().map(|value| f64::from(*value) / 257.0).collect()
        }
        _ => picture.into_rgba8().iter().map(|value| f64::from(*value)).collect(),
    };
    Ok(Loaded { kind: Kind::Picture, array: Array { shape, values } })
}

/// How two arrays of one shape differ.
#[derive(Debug)]
struct Comparison {
    height: usize,
    width: usize,
    /// The largest difference of each pixel's values; 0 where it is within the tolerance.
    pixels: Vec<f64>,
    /// How many pixels differ, the first of them, and the largest difference.
    different: usize,
    first: usize,
    most: f64,
}

impl Comparison {
    fn new(a: &Array, b: &Array, tolerance: f64) -> Self {
        // Whatever follows rows and columns belongs to a pixel.
        let height = a.shape.first().copied().unwrap_or(1);
        let width = a.shape.get(1).copied().unwrap_or(1);
        let channels: usize = a.shape.iter().skip(2).product();
        let difference = |(a, b): (&f64, &f64)| {
            let same = a == b || (a.is_nan() && b.is_nan());
            let by = (a - b).abs();
            match () {
                () if same || by <= tolerance => 0.0,
                () if by.is_nan() => f64::INFINITY,
                () => by,
            }
        };
        let pixels: Vec<f64> = a
            .values
            .chunks(channels.max(1))
            .zip(b.values.chunks(channels.max(1)))
            .map(|(a, b)| a.iter().zip(b).map(difference).fold(0.0, f64::max))
            .collect();
        Self {
            height,
            width,
            different: pixels.iter().filter(|by| **by > 0.0).count(),
            first: pixels.iter().position(|by| *by > 0.0).unwrap_or(0),
            most: pixels.iter().copied().fold(0.0, f64::max),
            pixels,
        }
    }

    fn write_picture(&self, path: &Path) -> Result<(), Failure> {
        let side = |side: usize| u32::try_from(side).ok().filter(|side| *side > 0);
        let (Some(width), Some(height)) = (side(self.width), side(self.height)) else {
            return Err(Failure::new("these arrays have no pixels: leave --diff out"));
        };
        let finite = self.pixels.iter().copied().filter(|by| by.is_finite());
        let most = finite.fold(0.0, f64::max);
        let gray = |by: &f64| {
            const DARKEST: f64 = 64.0;
            if *by == 0.0 {
                return 0;
            }
            let part = if by.is_finite() { by / most } else { 1.0 };
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "between 64 and 255"
            )]
            let gray = (DARKEST + (255.0 - DARKEST) * part) as u8;
            gray
        };
        let grays: Vec<u8> = self.pixels.iter().map(gray).collect();
        let mut staged = Staged::default();
        staged
            .add(&Sink::File(path.to_owned()), |out| write_gray_png(out, &grays, width, height))?;
        staged.commit()
    }
}
