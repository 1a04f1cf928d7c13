//! Draws a model into a canvas: one frame, from positions in world space to pixels.
//!
//! Each position is transformed once, however many faces share it. Runs of faces that look the
//! same go through one compiled loop.

use std::ops::Range;

use hyperspan::batch::Batch;
use hyperspan::cull::{BoundingBox, Clusters, Hierarchy, ViewVolume};
use hyperspan::depth::DepthTest;
use hyperspan::draw::{Call, Frame, Polygons};
use hyperspan::placed::Placed;
use hyperspan::polygon::Polygon;
use hyperspan::simd::Simd;
use hyperspan::space::{PixelRect, Viewport};
use hyperspan::stats::Stats;
use hyperspan::tiler::{Cull, Precision, Tiler};

use crate::aov::Aov;
use crate::camera::{Camera, DepthFlag};
use crate::canvas::{Band, Canvas, Meter};
use crate::failure::Failure;
use crate::model::{Lit, Look, Model, Run};
use crate::needed::Needed;
use crate::progress::Progress;
use crate::shaders::{Layout, PaintCounts, PaintData, PaintDepth, PaintPicture, Reads};
use crate::surface::{Corner, LitTexture, Plain, Shaded, Surface, Textured, light_piece};

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
    /// On more than one thread?
    pub(crate) parallel: bool,
}

/// A model under a camera, with what is kept from one frame to the next.
#[derive(Debug)]
pub(crate) struct Scene<'a> {
    model: &'a Model,
    camera: Camera,
    options: Options,
    viewport: Viewport,
    frame: Frame,
    /// For the pass that counts overdraw.
    counter: Frame,
    /// Boxes over its pieces.
    hierarchy: Hierarchy,
    needed: Needed,
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
        let [mut frame, mut counter] = [tiler, counter].map(Frame::new);
        frame.set_parallel(options.parallel);
        counter.set_parallel(options.parallel);
        let hierarchy = Hierarchy::new(model.pieces.len(), |i, bounds: &mut BoundingBox| {
            for position in &model.corners.position[model.pieces[i].corners()] {
                bounds.add(model.positions[*position as usize]);
            }
        });
        Ok(Self {
            model,
            camera,
            options,
            viewport,
            frame,
            counter,
            hierarchy,
            needed: Needed::new(model),
            clip: Vec::new(),
            placed: Placed::new(viewport),
            light: if any_lit { vec![0.0; model.corners.len()] } else { Vec::new() },
        })
    }

    /// Draws a frame, the clear included, and gives its counts.
    pub(crate) fn draw(&mut self, canvas: &mut Canvas, progress: &mut Progress) -> Stats {
        let Self {
            model,
            camera,
            options,
            viewport,
            frame,
            counter,
            hierarchy,
            needed,
            clip,
            placed,
            light,
        } = self;
        let Options { simd, parallel, .. } = *options;
        for run in &model.runs {
            if model.is_lit(run.look, options.lit) {
                for piece in &model.pieces[run.pieces.clone()] {
                    light_piece(model, camera, run.look, *piece, light);
                }
            }
        }
        let (x, y) = canvas.crop.origin();
        frame.settings().set_origin(x, y);
        let crop = PixelRect::new(x, y, canvas.crop.width, canvas.crop.height);
        let volume = &ViewVolume::of_crop(camera.matrix, *viewport, crop);
        let ranges = needed.of(hierarchy, volume);
        placed.transform_some(camera.matrix, &model.positions, ranges, clip, simd, parallel);
        let view = View { model, hierarchy, volume, clip, placed };
        view.draw(frame, canvas, progress, |run| {
            if model.is_lit(run.look, options.lit) { light } else { &[] }
        });
        let mut stats = frame.stats();

        // How often a pixel is covered does not depend on what hides it.
        if let Some(counts) = canvas.overdraw() {
            counter.settings().set_origin(x, y);
            let batch = RunBatch { view, pieces: 0..model.pieces.len(), vertices: &() };
            counter.draw(counts, &[&Polygons::new(batch, PaintCounts)]);
            stats.peak_bytes = stats.peak_bytes.max(counter.stats().peak_bytes);
        }
        stats
    }
}

/// A model in clip space.
#[derive(Clone, Copy)]
struct View<'f> {
    model: &'f Model,
    hierarchy: &'f Hierarchy,
    volume: &'f ViewVolume,
    clip: &'f [[f64; 4]],
    placed: &'f Placed,
}

/// How the faces of a run look, and which attributes they have.
enum Skin<'f> {
    Plain(Plain),
    Shaded(Shaded<'f>),
    Textured(Textured<'f>),
    /// With what only data asks for.
    Data(Box<WithExtras<'f>>, Layout),
}

impl<'f> View<'f> {
    /// Draws all runs, which have the `light` that is said.
    fn draw(
        self,
        frame: &mut Frame,
        canvas: &mut Canvas,
        progress: &mut Progress,
        light: impl Fn(&Run) -> &'f [f32],
    ) {
        let runs = &self.model.runs;
        let meter = Meter::new(progress, canvas.crop.height);
        let skins: Vec<Skin<'_>> =
            runs.iter().map(|run| self.skin(run, light(run), canvas)).collect();
        let ids: Vec<_> = runs.iter().map(|run| self.ids(run)).collect();
        let looks = runs.iter().zip(skins.iter().zip(&ids));
        let calls: Vec<_> =
            looks.map(|(run, (skin, id))| self.call(run, skin, id, canvas)).collect();
        let calls: Vec<&dyn Call<Band<'_>>> = calls.iter().map(|call| &**call).collect();
        frame.draw(canvas.band(&meter), &calls);
    }

    /// Chooses how `run` looks; `light` is empty if it is not lit.
    fn skin(self, run: &Run, light: &'f [f32], canvas: &Canvas) -> Skin<'f> {
        let Model { colors, uvs, corners, materials, .. } = self.model;
        let diffuse = materials[run.look.material].diffuse;
        let plain = Plain { diffuse };
        if !canvas.has_color() {
            return self.dressed(run, plain, canvas, Skin::Plain(plain));
        }
        let texture = self.model.texture(run.look);
        match texture.map(|texture| Textured { texture, uvs, indices: &corners.uv }) {
            Some(textured) if light.is_empty() => {
                self.dressed(run, textured, canvas, Skin::Textured(textured))
            }
            Some(textured) => self.data(run, LitTexture { textured, light }, 3, canvas),
            None if light.is_empty() && colors.is_empty() => {
                self.dressed(run, plain, canvas, Skin::Plain(plain))
            }
            None => {
                let shaded = Shaded { diffuse, colors, light };
                self.dressed(run, shaded, canvas, Skin::Shaded(shaded))
            }
        }
    }

    /// `skin`, whose surface is `surface`, unless there is data to be drawn.
    fn dressed<S: Surface + Reads + 'f>(
        self,
        run: &Run,
        surface: S,
        canvas: &Canvas,
        skin: Skin<'f>,
    ) -> Skin<'f> {
        if canvas.has_data() { self.data(run, surface, S::ATTRIBUTES, canvas) } else { skin }
    }

    /// The same for all planes. The surface has `read` attributes.
    fn data(self, run: &Run, surface: impl Surface + 'f, read: usize, canvas: &Canvas) -> Skin<'f> {
        let (extras, layout) = extras(self.model, run.look, canvas, (read, surface.uv()));
        let surface = Box::new(surface);
        Skin::Data(Box::new(WithExtras { surface, read, model: self.model, extras }), layout)
    }

    /// The numbers of the faces of `run`.
    fn ids(self, run: &Run) -> impl Fn(usize) -> u32 + Sync + use<'f> {
        let pieces = &self.model.pieces[run.pieces.clone()];
        move |i| pieces[i].face
    }

    /// What draws `run`: the loop that is made for its `skin`.
    fn call<'c, 'b>(
        self,
        run: &Run,
        skin: &'c Skin<'f>,
        id: &'c (dyn Fn(usize) -> u32 + Sync),
        canvas: &Canvas,
    ) -> Box<dyn Call<Band<'b>> + 'c>
    where
        'f: 'c,
    {
        let pieces = run.pieces.clone();
        let has_picture = canvas.picture.is_some();
        match skin {
            Skin::Data(vertices, layout) => {
                let (colour, layout) = (vertices.surface.colour(), *layout);
                let batch = RunBatch { view: self, pieces, vertices: &**vertices };
                if canvas.has_depth_or_w() {
                    Box::new(Polygons::new(batch, PaintData::<true> { colour, layout, id }))
                } else {
                    Box::new(Polygons::new(batch, PaintData::<false> { colour, layout, id }))
                }
            }
            _ if !has_picture => {
                Box::new(Polygons::new(RunBatch { view: self, pieces, vertices: &() }, PaintDepth))
            }
            Skin::Plain(surface) => self.picture(pieces, surface),
            Skin::Shaded(surface) => self.picture(pieces, surface),
            Skin::Textured(surface) => self.picture(pieces, surface),
        }
    }

    fn picture<'c, 'b, S: Surface + Reads>(
        self,
        pieces: Range<usize>,
        surface: &'c S,
    ) -> Box<dyn Call<Band<'b>> + 'c>
    where
        'f: 'c,
    {
        let batch = RunBatch { view: self, pieces, vertices: surface };
        Box::new(Polygons::new(batch, PaintPicture(surface)))
    }
}

/// The attributes of a model's corners, as some pass wants them.
trait Vertices: Sync {
    /// How many each corner has.
    fn count(&self) -> usize;
    /// Attribute `k` of `corner` of face `face`.
    fn attribute(&self, face: u32, corner: Corner, k: usize) -> f32;
}

impl Vertices for () {
    fn count(&self) -> usize {
        0
    }

    fn attribute(&self, _face: u32, _corner: Corner, _k: usize) -> f32 {
        0.0
    }
}

impl<S: Surface + Reads> Vertices for S {
    #[inline(always)]
    fn count(&self) -> usize {
        S::ATTRIBUTES
    }

    #[inline(always)]
    fn attribute(&self, _face: u32, corner: Corner, k: usize) -> f32 {
        Surface::attribute(self, corner, k)
    }
}

/// A surface's attributes, and behind them those that only data asks for.
struct WithExtras<'a> {
    surface: Box<dyn Surface + 'a>,
    /// How many attributes the surface has.
    read: usize,
    model: &'a Model,
    extras: Vec<Extra>,
}

/// One attribute that only data asks for: component 0, 1 or 2 of it.
#[derive(Clone, Copy)]
enum Extra {
    Uv(usize),
    Normal(usize),
    FaceNormal(usize),
    Position(usize),
}

/// What the data that is wanted needs of faces that look so, and where it is behind the first `read`
/// attributes, among which there may be texture coordinates from `uv` on.
fn extras(
    model: &Model,
    look: Look,
    canvas: &Canvas,
    (read, uv): (usize, Option<usize>),
) -> (Vec<Extra>, Layout) {
    let mut all = Vec::new();
    let mut add = |parts: &[Extra]| {
        all.extend_from_slice(parts);
        Some(read + all.len() - parts.len())
    };
    let mut layout = Layout::default();
    if canvas.wants(Aov::Uv) && look.has_uvs {
        layout.uv = uv.or_else(|| add(&[0, 1].map(Extra::Uv)));
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
    fn attribute(&self, face: u32, corner: Corner, k: usize) -> f32 {
        let Some(extra) = k.checked_sub(self.read) else {
            return self.surface.attribute(corner, k);
        };
        let Model { positions, uvs, normals, corners, face_normals, .. } = self.model;
        match self.extras[extra] {
            Extra::Uv(c) => uvs[corners.uv[corner.number] as usize][c],
            Extra::Normal(c) => normals[corners.normal[corner.number] as usize][c],
            Extra::FaceNormal(c) => face_normals[face as usize][c],
            #[expect(clippy::cast_possible_truncation, reason = "attributes are f32")]
            Extra::Position(c) => positions[corner.position][c] as f32,
        }
    }
}

/// Pieces of the model that have the same attributes.
struct RunBatch<'a, V> {
    view: View<'a>,
    pieces: Range<usize>,
    vertices: &'a V,
}

impl<V: Vertices> Batch for RunBatch<'_, V> {
    type Polygon<'p>
        = PiecePolygon<'p, V>
    where
        Self: 'p;

    fn len(&self) -> usize {
        self.pieces.len()
    }

    #[inline(always)]
    fn polygon(&self, i: usize) -> PiecePolygon<'_, V> {
        let View { model, clip, placed, .. } = self.view;
        let piece = model.pieces[self.pieces.start + i];
        let corners = piece.corners();
        let start = corners.start;
        let positions = &model.corners.position[corners];
        PiecePolygon { clip, positions, start, face: piece.face, vertices: self.vertices, placed }
    }

    #[inline(always)]
    fn continues(&self, i: usize) -> bool {
        let (pieces, i) = (&self.view.model.pieces, self.pieces.start + i);
        i > self.pieces.start && pieces[i - 1].face == pieces[i].face
    }

    fn clusters(&self) -> Option<Clusters<'_>> {
        let View { hierarchy, volume: view, .. } = self.view;
        Some(Clusters { hierarchy, view, first: self.pieces.start })
    }
}

/// A piece of the model, in clip space.
struct PiecePolygon<'a, V> {
    clip: &'a [[f64; 4]],
    /// Of its corners.
    positions: &'a [u32],
    /// Its first corner.
    start: usize,
    face: u32,
    vertices: &'a V,
    /// Of all positions of the model.
    placed: &'a Placed,
}

impl<V: Vertices> Polygon for PiecePolygon<'_, V> {
    #[inline(always)]
    fn len(&self) -> usize {
        self.positions.len()
    }

    #[inline(always)]
    fn attribute_count(&self) -> usize {
        self.vertices.count()
    }

    #[inline(always)]
    fn position(&self, i: usize) -> [f64; 4] {
        self.clip[self.positions[i] as usize]
    }

    #[inline(always)]
    fn attribute(&self, i: usize, k: usize) -> f32 {
        let corner = Corner { number: self.start + i, position: self.positions[i] as usize };
        self.vertices.attribute(self.face, corner, k)
    }

    #[inline(always)]
    fn placed(&self) -> Option<&Placed> {
        Some(self.placed)
    }

    #[inline(always)]
    fn placed_index(&self, i: usize) -> usize {
        self.positions[i] as usize
    }

    #[inline(always)]
    fn fetch(&self, i: usize) {
        prefetch_index::prefetch_index(self.clip, self.positions[i] as usize);
    }
}
