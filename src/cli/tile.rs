//! `hyperspan tile`: polygons in clip space to a picture, and to data. What the library does
//! with a polygon can be seen here, without a camera or a model around it.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use hyperspan::batch::Batch;
use hyperspan::depth::DepthTest;
use hyperspan::draw::{Call, Frame, Polygons};
use hyperspan::polygon::Polygon;
use hyperspan::shade::BLOCK;
use hyperspan::space::Viewport;
use hyperspan::stats::Stats;
use hyperspan::tiler::Tiler;

use crate::aov::{self, Aov, Request};
use crate::canvas::{Band, Canvas, Meter, Plan};
use crate::failure::{Failure, Place};
use crate::flags::{DrawFlags, Size};
use crate::frames::Timings;
use crate::poly::{self, PolyFile};
use crate::progress::Progress;
use crate::results;
use crate::shaders::{Colour, Layout, PaintCounts, PaintData, PaintDepth};
use crate::text::Lines;

/// Draws polygons given in clip space.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
FILE is text. A vertex is a line `x y z w a0 a1 ...` in clip space; blank lines end a polygon; `#`
begins a comment. Before the first vertex may stand `attrs` with one of perspective,
noperspective and flat for each attribute, and `zrange 0 1` or `zrange -1 1`.
The picture shows attributes 0 to 2 as red, green and blue in 0..1, missing ones as 1.

Data (--aov): depth (framebuffer depth; where nothing is drawn what it is cleared to: 0, or 1 for
--depth standard), w (clip w), id (index of the polygon in file order; 4294967295 where none),
overdraw (how often a pixel was covered, hidden or not), color (before rounding to 8 bits), attr
(all attributes). As .npy: f32, or u32 for id and overdraw, row 0 on top.")]
pub(crate) struct TileArgs {
    /// A .poly file.
    polygons: PathBuf,

    /// Size of the picture in pixels, which is the viewport.
    #[arg(long, value_name = "WxH", default_value = "1280x720", allow_hyphen_values = true)]
    size: Size,

    #[command(flatten)]
    draw: DrawFlags,

    /// Writes data: NAME is depth, w, id, overdraw, color or attr, FILE ends in .npy (exact
    /// values) or .png (for looking at). May be given several times.
    #[arg(long = "aov", value_name = "NAME=FILE", value_parser = aov::tile_request)]
    aovs: Vec<Request>,

    /// What is tested: nothing (later polygons overwrite), LESS with clear 1, or GREATER with
    /// clear 0.
    #[arg(long, value_enum, default_value = "none")]
    depth: DepthFlag,
}

/// `--depth` of `tile`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum DepthFlag {
    None,
    Standard,
    Reversed,
}

/// Draws what `args` asks for.
pub(crate) fn run(args: &TileArgs) -> Result<(), Failure> {
    results::check(&args.draw, &args.aovs)?;
    let crop = args.draw.crop(args.size)?;
    let file = read(&args.polygons)?;

    let aovs: Vec<Aov> = args.aovs.iter().map(|request| request.aov).collect();
    let only_data = args.draw.output.is_none() && !aovs.is_empty();
    let mut canvas = Canvas::new(&Plan {
        crop,
        // Counts and times alone are those of a picture.
        picture: (!only_data).then_some(args.draw.background.0),
        depth_buffer: args.depth != DepthFlag::None,
        clear_depth: if args.depth == DepthFlag::Standard { 1.0 } else { 0.0 },
        aovs: &aovs,
        attributes: file.attribute_count,
    })?;
    let viewport =
        Viewport::new(0, 0, args.size.width, args.size.height)?.with_depth_range(file.depth_range);
    let (x, y) = crop.origin();
    let mut tiler = Tiler::new(viewport);
    let mut counter = Tiler::new(viewport);
    counter.set_origin(x, y).set_simd(args.draw.simd.simd);
    tiler
        .set_origin(x, y)
        .set_precision(args.draw.precision.precision())
        .set_simd(args.draw.simd.simd)
        .set_interpolation(&file.interpolation)
        .set_depth_test(match args.depth {
            DepthFlag::Reversed => DepthTest::REVERSED,
            DepthFlag::None | DepthFlag::Standard => DepthTest::STANDARD,
        });
    let mut frames = Frames { frame: Frame::new(tiler), counter: Frame::new(counter) };
    let parallel = args.draw.threads() > 1;
    frames.frame.set_parallel(parallel);
    frames.counter.set_parallel(parallel);
    let timings = args.draw.on_threads(|| {
        Timings::measure(args.draw.repeat, |progress| {
            draw(&file, &mut frames, &mut canvas, progress)
        })
    })?;
    timings.report_refused(&args.polygons);
    results::write(&args.draw, &args.aovs, &canvas, &timings)
}

fn read(path: &Path) -> Result<PolyFile, Failure> {
    if path.is_dir() {
        return Err(Failure::at(Place::file(path), "this is a folder: name a .poly file in it"));
    }
    poly::parse(Lines::open(path)?, path)
}

/// Attributes 0 to 2 as red, green and blue; 1 for those that there are not.
#[derive(Clone, Copy, Debug)]
struct FirstThree;

impl Colour for FirstThree {
    #[inline]
    fn rgb(&self, attributes: &[[f32; BLOCK]], lane: usize) -> [f32; 3] {
        [0, 1, 2].map(|k| attributes.get(k).map_or(1.0, |lanes| lanes[lane]))
    }
}

/// What is kept from one frame to the next.
#[derive(Debug)]
struct Frames {
    frame: Frame,
    /// For the pass that counts overdraw.
    counter: Frame,
}

/// Draws a frame, the clear included, and gives its counts.
fn draw(
    file: &PolyFile,
    frames: &mut Frames,
    canvas: &mut Canvas,
    progress: &mut Progress,
) -> Stats {
    let Frames { frame, counter } = frames;
    let has_values = canvas.has_data() || canvas.has_color();
    // What nobody looks at is not interpolated.
    let n = file.attribute_count;
    let read = if canvas.wants(Aov::Attr) { n } else { n.min(3) };
    let batch = FileBatch { file, read };
    // More polygons than ids: they would fill more memory than there is.
    let id = |i: usize| u32::try_from(i).unwrap_or(u32::MAX);
    let (colour, layout) = (&FirstThree, Layout::default());
    let call: &dyn Call<Band<'_>> = if canvas.has_depth_or_w() {
        &Polygons::new(batch, PaintData::<true> { colour, layout, id: &id })
    } else if has_values {
        &Polygons::new(batch, PaintData::<false> { colour, layout, id: &id })
    } else {
        &Polygons::new(batch, PaintDepth)
    };
    let meter = Meter::new(progress, canvas.crop.height);
    frame.draw(canvas.band(&meter), &[call]);
    let mut stats = frame.stats();

    // How often a pixel is covered does not depend on what hides it.
    if let Some(counts) = canvas.overdraw() {
        counter.draw(counts, &[&Polygons::new(batch, PaintCounts)]);
        stats.peak_bytes = stats.peak_bytes.max(counter.stats().peak_bytes);
    }
    stats
}

/// The polygons of a file with the first `read` of their attributes.
#[derive(Clone, Copy)]
struct FileBatch<'a> {
    file: &'a PolyFile,
    read: usize,
}

impl Batch for FileBatch<'_> {
    type Polygon<'p>
        = FilePolygon<'p>
    where
        Self: 'p;

    fn len(&self) -> usize {
        self.file.len()
    }

    #[inline(always)]
    fn polygon(&self, i: usize) -> FilePolygon<'_> {
        let PolyFile { positions, attributes, attribute_count, .. } = self.file;
        let vertices = self.file.vertices(i);
        let attributes = &attributes[vertices.start * attribute_count..];
        let positions = &positions[vertices];
        FilePolygon { positions, attributes, stride: *attribute_count, read: self.read }
    }
}

/// A polygon of a file.
struct FilePolygon<'a> {
    positions: &'a [[f32; 4]],
    /// From its own on, `stride` for each vertex.
    attributes: &'a [f32],
    stride: usize,
    read: usize,
}

impl Polygon for FilePolygon<'_> {
    #[inline]
    fn len(&self) -> usize {
        self.positions.len()
    }

    #[inline]
    fn attribute_count(&self) -> usize {
        self.read
    }

    #[inline]
    fn position(&self, i: usize) -> [f64; 4] {
        self.positions[i].map(f64::from)
    }

    #[inline]
    fn attribute(&self, i: usize, k: usize) -> f32 {
        self.attributes[i * self.stride + k]
    }
}
