//! `hyperspan render`: a model to a picture, and to data.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use hyperspan::tiler::Cull;

use crate::aov::{self, Aov, Request};
use crate::camera::{CameraFlags, DepthFlag};
use crate::canvas::{Canvas, Plan};
use crate::failure::Failure;
use crate::flags::DrawFlags;
use crate::frames::Timings;
use crate::model::{Lit, Model, Needs, TextureLimit};
use crate::results;
use crate::scene::{Options, Scene};

/// Draws a model.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Data (--aov): depth (framebuffer depth; 0 or 1, as --depth clears it, where nothing is drawn),
w (distance along the view axis; 1 in --ortho), id (index of the face in file order; 4294967295
where none), overdraw (how often a pixel was covered, hidden or not), uv (as in the file),
normal (interpolated; the face's own where the file has none), position (world), color (before
rounding to 8 bits). As .npy: f32, or u32 for id and overdraw, row 0 on top.")]
pub(crate) struct RenderArgs {
    /// A Wavefront OBJ file; materials and PNG or JPEG textures are found beside it.
    model: PathBuf,

    #[command(flatten)]
    draw: DrawFlags,

    /// Writes data: NAME is depth, w, id, overdraw, uv, normal, position or color, FILE ends
    /// in .npy (exact values) or .png (for looking at). May be given several times.
    #[arg(long = "aov", value_name = "NAME=FILE", value_parser = aov::render_request)]
    aovs: Vec<Request>,

    /// What colours are made of: unlit is the texel, else (vertex colour or white) times the
    /// material's Kd; gouraud lights that at the vertices, from over the viewer's left
    /// shoulder; auto lights only what has neither texture nor vertex colours.
    #[arg(long, value_enum, default_value = "auto")]
    shade: Shade,

    /// How textures are looked up.
    #[arg(long, value_enum, default_value = "nearest")]
    filter: Filter,

    /// Which faces are left out; front faces are counter-clockwise.
    #[arg(long, value_enum, default_value = "none")]
    cull: CullFlag,

    /// What a texture may take in memory, in MiB: small files may ask for much. (Its sides may have
    /// 32768 texels in any case.)
    #[arg(long, value_name = "MIB", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(1..))]
    texture_limit: u32,

    #[command(flatten)]
    camera: CameraFlags,
}

/// `--shade`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Shade {
    Auto,
    Unlit,
    Gouraud,
}

/// `--filter`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Filter {
    Nearest,
}

/// `--cull`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum CullFlag {
    None,
    Back,
}

/// Draws what `args` asks for.
pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    results::check(&args.draw, &args.aovs)?;
    let camera = args.camera.resolve()?;
    let crop = args.draw.crop(camera.size)?;

    let aovs: Vec<Aov> = args.aovs.iter().map(|request| request.aov).collect();
    let only_data = args.draw.output.is_none() && !aovs.is_empty();
    // Also if no colour is wanted: data must not depend on what else is asked for.
    let lit = match args.shade {
        Shade::Unlit => Lit::None,
        Shade::Gouraud => Lit::All,
        Shade::Auto => Lit::Bare,
    };
    let needs = Needs {
        face_normals: lit != Lit::None || aovs.contains(&Aov::Normal),
        lit,
        texture_limit: TextureLimit(u64::from(args.texture_limit) << 20),
    };
    let model = Model::read(&args.model, needs)?;

    let camera = camera.frame(&model.subject())?;
    let mut canvas = Canvas::new(&Plan {
        crop,
        // Counts and times alone are those of a picture.
        picture: (!only_data).then_some(args.draw.background.0),
        depth_buffer: true,
        clear_depth: match camera.depth {
            DepthFlag::Reversed => 0.0,
            DepthFlag::Standard => 1.0,
        },
        aovs: &aovs,
        attributes: 0,
    })?;
    let Filter::Nearest = args.filter;
    let options = Options {
        cull: match args.cull {
            CullFlag::None => Cull::None,
            CullFlag::Back => Cull::Back,
        },
        precision: args.draw.precision.precision(),
        simd: args.draw.simd.simd,
        lit,
        parallel: args.draw.threads() > 1,
    };
    let mut scene = Scene::new(&model, camera, options)?;
    let timings = args.draw.on_threads(|| {
        Timings::measure(args.draw.repeat, |progress| scene.draw(&mut canvas, progress))
    })?;
    timings.report_refused(&args.model);
    results::write(&args.draw, &args.aovs, &canvas, &timings)
}
