//! Draws a model into a canvas: one frame, from positions in world space to pixels.
//!
//! Each position is transformed once, however many faces share it. Runs of faces that look the
//! same go through one compiled loop.

use glam::DVec3;
use hyperspan::camera::transform;
use hyperspan::depth::DepthTest;
use hyperspan::placed::Placed;
use hyperspan::polygon::Polygon;
use hyperspan::simd::Simd;
use hyperspan::space::Viewport;
use hyperspan::stats::Stats;
use hyperspan::target::Plane;
use hyperspan::tiler::{Cull, Precision, Tiler};

use crate::aov::Aov;
use crate::camera::{Camera, DepthFlag};
use crate::canvas::Canvas;
use crate::failure::Failure;
use crate::model::{Lit, Look, Model, Piece, Run};
use crate::progress::Progress;
use crate::shaders::{Coverage, Data, Layout, Picture, Reads};
use crate::surface::{LitTexture, Plain, Shaded, Surface, Textured, light_piece};
use crate::tally::FaceTally;

/// How a model is to be drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    /// Which faces are left out.
    pub(crate) cull: Cull,
    /// How good attributes are.
    pub(crate) precision: Precision,
    /// Which instructions the loops are made of.
    pub(crate) simd: Simd,
    /// Which faces are lit.
    pub(crate) lit: Lit,
}

/// A model under a camera, with what is kept from one frame to the next.
#[derive(Debug)]
pub(crate) struct Scene<'a> {
    model: &'a Model,
    camera: Camera,
    options: Options,
    tiler: Tiler,
    /// For the pass that counts overdraw.
    counter: Tiler,
    /// Positions in clip space.
    clip: Vec<[f64; 4]>,
    /// The same on the grid.
    placed: Placed,
    /// At each corner; empty if nothing is lit.
    light: Vec<f32>,
}

impl<'a> Scene<'a> {
    /// `model` as `camera` sees it.
    pub(crate) fn new(model: &'a Model, camera: Camera, options: Options) -> Result<Self, Failure> {
        let viewport = Viewport::new(0, 0, camera.size.width, camera.size.height)?;
        let any_lit = model.runs.iter().any(|run| model.is_lit(run.look, options.lit));
        let mut tiler = Tiler::new(viewport);
        tiler.set_cull(options.cull).set_precision(options.precision).set_simd(options.simd);
        tiler.set_depth_test(match camera.depth {
            DepthFlag::Reversed => DepthTest::REVERSED,
            DepthFlag::Standard => DepthTest::STANDARD,
        });
        let mut counter = Tiler::new(viewport);
        counter.set_cull(options.cull).set_simd(options.simd);
        Ok(Self {
            model,
            camera,
            options,
            tiler,
            counter,
            clip: vec![[0.0; 4]; model.positions.len()],
            placed: Placed::new(viewport),
            light: if any_lit { vec![0.0; model.corners.len()] } else { Vec::new() },
        })
    }

    /// Draws a frame, the clear included, and gives its counts.
    pub(crate) fn draw(
        &mut self,
        canvas: &mut Canvas,
        progress: &mut Progress,
    ) -> Result<Stats, Failure> {
        let Self { model, camera, options, tiler, counter, clip, placed, light } = self;
        canvas.clear();
        for (clip, position) in clip.iter_mut().zip(&model.positions) {
            *clip = transform(camera.matrix, DVec3::from_array(*position));
        }
        placed.set(clip, options.simd);
        let (x, y) = canvas.crop.origin();
        tiler.set_origin(x, y).reset_stats();
        let tally = FaceTally::default();
        let mut frame = Frame { model, clip, placed, tiler, canvas, tally, progress };
        for run in &model.runs {
            let look = run.look;
            let lit = model.is_lit(look, options.lit);
            if lit {
                for piece in &model.pieces[run.pieces.clone()] {
                    light_piece(model, camera, look, *piece, light);
                }
            }
            let light = if lit { light.as_slice() } else { &[] };
            frame.draw_run(run, light)?;
        }
        let Frame { tally, .. } = frame;
        let mut stats = tally.settle(tiler);

        // How often a pixel is covered does not depend on what hides it.
        let mut extent = canvas.extent();
        if let Some(mut shader) = canvas.overdraw() {
            counter.set_origin(x, y);
            for piece in &model.pieces {
                let polygon: &dyn Polygon = &PiecePolygon::new(model, clip, placed, *piece, &());
                counter.draw(polygon, &mut shader, &mut extent, None);
            }
            stats.peak_bytes = stats.peak_bytes.max(counter.stats().peak_bytes);
        }
        Ok(stats)
    }
}

/// A frame that is being drawn.
struct Frame<'f> {
    model: &'f Model,
    clip: &'f [[f64; 4]],
    placed: &'f Placed,
    tiler: &'f mut Tiler,
    canvas: &'f mut Canvas,
    tally: FaceTally,
    progress: &'f mut Progress,
}

impl Frame<'_> {
    /// Draws `run`: chooses its surface, and the loop. `light` is empty if it is not lit.
    fn draw_run(&mut self, run: &Run, light: &[f32]) -> Result<(), Failure> {
        let Model { colors, uvs, corners, materials, .. } = self.model;
        let diffuse = materials[run.look.material].diffuse;
        if !self.canvas.has_color() {
            return self.draw(run, &Plain { diffuse });
        }
        let texture = self.model.texture(run.look);
        let textured = texture.map(|texture| Textured { texture, uvs, indices: &corners.uv });
        match textured {
            Some(textured) if light.is_empty() => self.draw(run, &textured),
            Some(textured) => self.draw_data(run, &LitTexture { textured, light }, 3),
            None if light.is_empty() && colors.is_empty() => self.draw(run, &Plain { diffuse }),
            None => {
                let positions = &corners.position;
                self.draw(run, &Shaded { diffuse, colors, light, positions })
            }
        }
    }

    /// Draws `run` in the quickest way for what is wanted.
    fn draw<S: Surface + Reads>(&mut self, run: &Run, surface: &S) -> Result<(), Failure> {
        if self.canvas.has_data() {
            return self.draw_data(run, surface, S::ATTRIBUTES);
        }
        let Self { model, clip, placed, tiler, canvas, tally, progress } = self;
        let mut extent = canvas.extent();
        let (width, height) = (extent.width, extent.height);
        let (depth, planes) = canvas.split();
        let mut depth = depth.map(|depth| Plane::new(depth, width, height)).transpose()?;
        if let Some(picture) = planes.picture {
            let mut target = Plane::new(picture, width, height)?;
            let shader = &mut Picture(surface);
            for i in run.pieces.clone() {
                let piece = next(model, i, tiler, tally, progress);
                let polygon = PiecePolygon::new(model, clip, placed, piece, surface);
                tiler.draw(&polygon, shader, &mut target, depth.as_mut());
            }
        } else {
            for i in run.pieces.clone() {
                let piece = next(model, i, tiler, tally, progress);
                let polygon: &dyn Polygon = &PiecePolygon::new(model, clip, placed, piece, &());
                tiler.draw(polygon, &mut Coverage::default(), &mut extent, depth.as_mut());
            }
        }
        Ok(())
    }

    /// Draws `run` into all planes. The surface has `read` attributes.
    fn draw_data(&mut self, run: &Run, surface: &dyn Surface, read: usize) -> Result<(), Failure> {
        let Self { model, clip, placed, tiler, canvas, tally, progress } = self;
        let (extras, layout) = extras(model, run.look, canvas, read);
        let mut extent = canvas.extent();
        let (depth, planes) = canvas.split();
        let mut depth =
            depth.map(|depth| Plane::new(depth, extent.width, extent.height)).transpose()?;
        let mut shader = Data { colour: surface, layout, id: 0, planes };
        for i in run.pieces.clone() {
            let piece = next(model, i, tiler, tally, progress);
            shader.id = piece.face;
            let vertices = WithExtras { surface, read, model, extras: &extras, face: piece.face };
            let polygon: &dyn Polygon = &PiecePolygon::new(model, clip, placed, piece, &vertices);
            tiler.draw(polygon, &mut shader, &mut extent, depth.as_mut());
        }
        Ok(())
    }
}

/// Piece `i`, which is going to be drawn.
#[inline]
fn next(
    model: &Model,
    i: usize,
    tiler: &Tiler,
    tally: &mut FaceTally,
    progress: &mut Progress,
) -> Piece {
    const PROGRESS_PIECES: usize = 1 << 10;
    if i.is_multiple_of(PROGRESS_PIECES) {
        progress.set(i as u64, model.pieces.len() as u64);
    }
    tally.before(tiler, &model.pieces, i);
    model.pieces[i]
}

/// The attributes of a model's corners, as some pass wants them.
trait Vertices {
    /// How many each corner has.
    fn count(&self) -> usize;
    /// Attribute `k` of corner `corner`.
    fn attribute(&self, corner: usize, k: usize) -> f32;
}

impl Vertices for () {
    fn count(&self) -> usize {
        0
    }

    fn attribute(&self, _corner: usize, _k: usize) -> f32 {
        0.0
    }
}

impl<S: Surface + Reads> Vertices for S {
    #[inline]
    fn count(&self) -> usize {
        S::ATTRIBUTES
    }

    #[inline]
    fn attribute(&self, corner: usize, k: usize) -> f32 {
        Surface::attribute(self, corner, k)
    }
}

/// A surface's attributes, and behind them those that only data asks for.
struct WithExtras<'a> {
    surface: &'a dyn Surface,
    /// How many attributes the surface has.
    read: usize,
    model: &'a Model,
    extras: &'a [Extra],
    /// The face that is being drawn.
    face: u32,
}

/// One attribute that only data asks for: component 0, 1 or 2 of it.
#[derive(Clone, Copy)]
enum Extra {
    Uv(usize),
    Normal(usize),
    FaceNormal(usize),
    Position(usize),
}

/// What the data that is wanted needs of faces that look so, and where it is behind `first`
/// other attributes.
fn extras(model: &Model, look: Look, canvas: &Canvas, first: usize) -> (Vec<Extra>, Layout) {
    let mut all = Vec::new();
    let mut add = |parts: &[Extra]| {
        all.extend_from_slice(parts);
        Some(first + all.len() - parts.len())
    };
    let mut layout = Layout::default();
    if canvas.wants(Aov::Uv) && look.has_uvs {
        layout.uv = add(&[0, 1].map(Extra::Uv));
    }
    if canvas.wants(Aov::Normal) {
        let own = look.has_normals && !model.normals.is_empty();
        layout.normal = add(&[0, 1, 2].map(if own { Extra::Normal } else { Extra::FaceNormal }));
    }
    if canvas.wants(Aov::Position) {
        layout.position = add(&[0, 1, 2].map(Extra::Position));
    }
    (all, layout)
}

impl Vertices for WithExtras<'_> {
    #[inline]
    fn count(&self) -> usize {
        self.read + self.extras.len()
    }

    #[inline]
    fn attribute(&self, corner: usize, k: usize) -> f32 {
        let Some(extra) = k.checked_sub(self.read) else {
            return self.surface.attribute(corner, k);
        };
        let Model { positions, uvs, normals, corners, face_normals, .. } = self.model;
        match self.extras[extra] {
            Extra::Uv(c) => uvs[corners.uv[corner] as usize][c],
            Extra::Normal(c) => normals[corners.normal[corner] as usize][c],
            Extra::FaceNormal(c) => face_normals[self.face as usize][c],
            #[expect(clippy::cast_possible_truncation, reason = "attributes are f32")]
            Extra::Position(c) => positions[corners.position[corner] as usize][c] as f32,
        }
    }
}

/// A piece of the model, in clip space.
struct PiecePolygon<'a, V> {
    clip: &'a [[f64; 4]],
    /// Of its corners.
    positions: &'a [u32],
    /// Its first corner.
    start: usize,
    vertices: &'a V,
    /// Of all positions of the model.
    placed: &'a Placed,
}

impl<'a, V: Vertices> PiecePolygon<'a, V> {
    #[inline]
    fn new(
        model: &'a Model,
        clip: &'a [[f64; 4]],
        placed: &'a Placed,
        piece: Piece,
        vertices: &'a V,
    ) -> Self {
        let corners = piece.corners();
        let start = corners.start;
        let positions = &model.corners.position[corners];
        Self { clip, positions, start, vertices, placed }
    }
}

impl<V: Vertices> Polygon for PiecePolygon<'_, V> {
    #[inline]
    fn len(&self) -> usize {
        self.positions.len()
    }

    #[inline]
    fn attribute_count(&self) -> usize {
        self.vertices.count()
    }

    #[inline]
    fn position(&self, i: usize) -> [f64; 4] {
        self.clip[self.positions[i] as usize]
    }

    #[inline]
    fn attribute(&self, i: usize, k: usize) -> f32 {
        self.vertices.attribute(self.start + i, k)
    }

    #[inline]
    fn placed(&self) -> Option<&Placed> {
        Some(self.placed)
    }

    #[inline]
    fn placed_index(&self, i: usize) -> usize {
        self.positions[i] as usize
    }
}
