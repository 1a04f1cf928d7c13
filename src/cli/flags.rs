//! The flags that `render` and `tile` share, and how their values are read. A value that
//! cannot be meant is refused here, before any file is opened.

use std::num::NonZero;
use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueEnum};
use hyperspan::simd::Simd;
use hyperspan::space::Viewport;
use hyperspan::tiler::Precision;

use crate::failure::Failure;

/// Width and height in pixels, each in `1..=16384`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    /// In pixels.
    pub(crate) width: u32,
    /// In pixels.
    pub(crate) height: u32,
}

impl Size {
    /// What is drawn if nobody says otherwise.
    pub(crate) const DEFAULT: Self = Self { width: 1280, height: 720 };

    /// A size that can be drawn.
    pub(crate) fn new(width: u64, height: u64) -> Result<Self, String> {
        let side = |side: u64| {
            u32::try_from(side).ok().filter(|side| (1..=Viewport::MAX_SIDE).contains(side))
        };
        match (side(width), side(height)) {
            (Some(width), Some(height)) => Ok(Self { width, height }),
            _ => Err(format!(
                "{width} x {height} pixels cannot be drawn: each side must be 1 to {}",
                Viewport::MAX_SIDE
            )),
        }
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sides =
            text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
        let (width, height) = sides.ok_or("give WIDTHxHEIGHT in pixels, as in 1280x720")?;
        Self::new(width, height)
    }
}

/// A rectangle of the picture: its first pixel and its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Crop {
    /// First column.
    pub(crate) x: u32,
    /// First row.
    pub(crate) y: u32,
    /// In pixels, at least 1.
    pub(crate) width: u32,
    /// In pixels, at least 1.
    pub(crate) height: u32,
}

impl Crop {
    /// The framebuffer position of the first pixel, as the tiler takes it.
    pub(crate) fn origin(self) -> (i32, i32) {
        (self.x.cast_signed(), self.y.cast_signed())
    }
}

impl FromStr for Crop {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [x, y, width, height] =
            list(text).ok_or("give X,Y,WIDTH,HEIGHT: whole numbers of pixels")?;
        if width == 0 || height == 0 {
            return Err("a crop needs at least one pixel".to_owned());
        }
        Ok(Self { x, y, width, height })
    }
}

/// RGBA8, straight alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Background(pub(crate) [u8; 4]);

impl FromStr for Background {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let opaque = || list(text).map(|[r, g, b]| Self([r, g, b, 255]));
        let wrong = "give R,G,B or R,G,B,A: whole numbers from 0 to 255";
        list(text).map(Self).or_else(opaque).ok_or_else(|| wrong.to_owned())
    }
}

/// Three finite numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Triple(pub(crate) [f64; 3]);

impl FromStr for Triple {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        list(text)
            .filter(|numbers: &[f64; 3]| numbers.iter().all(|number| number.is_finite()))
            .map(Self)
            .ok_or_else(|| "give X,Y,Z: three finite numbers".to_owned())
    }
}

/// Focal lengths and principal point in pixels, as OpenCV gives them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Intrinsics(pub(crate) [f64; 4]);

impl FromStr for Intrinsics {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        list(text)
            .filter(|n: &[f64; 4]| n.iter().all(|n| n.is_finite()) && n[0] > 0.0 && n[1] > 0.0)
            .map(Self)
            .ok_or_else(|| "give FX,FY,CX,CY in pixels, FX and FY above 0".to_owned())
    }
}

/// A file, or standard output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Sink {
    /// `-`
    Stdout,
    /// Anything else.
    File(PathBuf),
}

/// Reads where a picture goes: PNG into a file, or `-`.
fn picture_sink(text: &str) -> Result<Sink, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        _ if text == "-" => Ok(Sink::Stdout),
        Some(found) if found.eq_ignore_ascii_case("png") => Ok(Sink::File(path)),
        _ => Err("pictures are written as PNG: give a name that ends in .png, or -".to_owned()),
    }
}

fn stats_sink(text: &str) -> Result<Sink, String> {
    match text {
        "" => Err("give a file name, or -".to_owned()),
        "-" => Ok(Sink::Stdout),
        _ => Ok(Sink::File(PathBuf::from(text))),
    }
}

/// More threads than any machine has use for.
const MOST_THREADS: u32 = 1024;

/// Reads a number of threads.
pub(crate) fn thread_count(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(threads @ 0..=MOST_THREADS) => Ok(threads),
        _ => Err(format!("give a whole number: 0 (one for each core) to {MOST_THREADS}")),
    }
}

/// What `--threads` comes to: 0 is one for each core.
pub(crate) fn threads(asked: u32) -> usize {
    match asked {
        0 => std::thread::available_parallelism().map_or(1, NonZero::get),
        threads => threads as usize,
    }
}

/// So many threads.
pub(crate) fn pool(threads: usize) -> Result<rayon::ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| {
        Failure::new(format!("cannot start {threads} threads: {e}; give fewer --threads"))
    })
}

/// `--precision`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PrecisionFlag {
    /// Within 4u |value| + 3u M of the right value, u = 2^-24, M the largest at the vertices.
    Fast,
    /// Correctly rounded.
    Exact,
}

impl PrecisionFlag {
    /// As the library calls it.
    pub(crate) fn precision(self) -> Precision {
        match self {
            Self::Fast => Precision::Fast,
            Self::Exact => Precision::Exact,
        }
    }
}

/// `--simd`: a level that this machine has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SimdFlag {
    /// Its name; not `auto`, but what that came to.
    pub(crate) name: &'static str,
    /// As the library calls it.
    pub(crate) simd: Simd,
}

fn simd(text: &str) -> Result<SimdFlag, String> {
    let Some(name) = Simd::NAMES.into_iter().find(|name| *name == text) else {
        return Err(format!("there is no such level; choose one of {}", Simd::NAMES.join(", ")));
    };
    // From the narrowest to the widest.
    let all = || Simd::all().map(|(name, simd)| SimdFlag { name, simd });
    let found = if name == "auto" { all().last() } else { all().find(|flag| flag.name == name) };
    found.ok_or_else(|| {
        let names: Vec<&str> = all().map(|flag| flag.name).collect();
        format!("this machine does not have it; it has {}", names.join(", "))
    })
}

/// What `render` and `tile` have in common.
#[derive(Clone, Debug, Args)]
pub(crate) struct DrawFlags {
    /// Writes the picture as PNG; `-` is standard output.
    #[arg(short, long, value_name = "OUT.png", value_parser = picture_sink)]
    pub(crate) output: Option<Sink>,

    /// How good attributes are.
    #[arg(long, value_enum, default_value = "fast")]
    pub(crate) precision: PrecisionFlag,

    /// Background, 0 to 255 each; alpha is 255 if it is left out.
    #[arg(long, value_name = "R,G,B[,A]", default_value = "0,0,0,0", allow_hyphen_values = true)]
    pub(crate) background: Background,

    /// Draws a part of the picture only: the same bytes as that part of the whole.
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true)]
    crop: Option<Crop>,

    /// Threads; 0 is one for each core. The picture is the same.
    #[arg(long, value_name = "N", default_value = "0", value_parser = thread_count, allow_hyphen_values = true)]
    threads: u32,

    /// Instructions to draw with: auto (the widest), scalar, sse2, sse4.2, avx2, avx512, neon or
    /// wasm, if the machine has them; the picture is the same.
    #[arg(long, value_name = "LEVEL", default_value = "auto", value_parser = simd)]
    pub(crate) simd: SimdFlag,

    /// Draws the frame so often, for timing.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000), allow_hyphen_values = true)]
    pub(crate) repeat: u32,

    /// Writes times and counts as JSON; `-` is standard output.
    #[arg(long, value_name = "FILE.json", value_parser = stats_sink)]
    pub(crate) stats: Option<Sink>,
}

impl DrawFlags {
    /// Is there anything to do, and is it possible? `aovs` is how many were asked for.
    pub(crate) fn check(&self, aovs: usize) -> Result<(), Failure> {
        if self.output.is_none() && self.stats.is_none() && aovs == 0 {
            return Err(Failure::new(
                "nothing is asked for: add -o OUT.png for a picture, --aov NAME=FILE for data, \
                 or --stats FILE for times and counts",
            ));
        }
        if self.output == Some(Sink::Stdout) && self.stats == Some(Sink::Stdout) {
            return Err(Failure::new(
                "-o - and --stats - cannot both go to standard output: name a file for one of them",
            ));
        }
        Ok(())
    }

    /// How many threads draw.
    pub(crate) fn threads(&self) -> usize {
        threads(self.threads)
    }

    /// Runs `work` with as many threads to draw on.
    pub(crate) fn on_threads<R: Send>(
        &self,
        work: impl FnOnce() -> R + Send,
    ) -> Result<R, Failure> {
        let threads = self.threads();
        if threads == 1 {
            return Ok(work());
        }
        Ok(pool(threads)?.install(work))
    }

    /// The part of a picture of `size` that is drawn: all of it if nobody says otherwise.
    pub(crate) fn crop(&self, size: Size) -> Result<Crop, Failure> {
        let Size { width, height } = size;
        let crop = self.crop.unwrap_or(Crop { x: 0, y: 0, width, height });
        let inside = |start: u32, length: u32, side| {
            start.checked_add(length).is_some_and(|end| end <= side)
        };
        if inside(crop.x, crop.width, width) && inside(crop.y, crop.height, height) {
            return Ok(crop);
        }
        Err(Failure::new(format!(
            "the crop {},{},{},{} sticks out of the picture of {width} x {height} pixels: \
             choose a smaller one, or a larger --size",
            crop.x, crop.y, crop.width, crop.height
        )))
    }
}

/// `N` values with commas between them.
fn list<T: FromStr, const N: usize>(text: &str) -> Option<[T; N]> {
    let values: Vec<T> =
        text.split(',').map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    values.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_crops_are_checked() {
        assert_eq!("16384x1".parse(), Ok(Size { width: 16384, height: 1 }));
        for wrong in ["0x5", "5x0", "16385x2", "5", "5x5x5", "-1x5", "99999999999x1", "x", ""] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong}");
        }
        assert!("0,0,1,1".parse::<Crop>().is_ok());
        for wrong in ["0,0,0,1", "0,0,1", "-1,0,1,1", "a,b,c,d", "0,0,1,1,1"] {
            assert!(wrong.parse::<Crop>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn backgrounds_without_alpha_are_opaque() {
        assert_eq!("1,2,3".parse(), Ok(Background([1, 2, 3, 255])));
        assert_eq!("1,2,3,4".parse(), Ok(Background([1, 2, 3, 4])));
        assert!("1,2,300".parse::<Background>().is_err());
        assert!("1,2".parse::<Background>().is_err());
    }
}
