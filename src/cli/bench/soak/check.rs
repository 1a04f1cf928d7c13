//! Draws a scene and compares it with the oracles, pixel by pixel.

use hyperspan::depth::{DepthBounds, DepthSource};
use hyperspan::draw::{Frame, Polygons, Rows, Screen, With};
use hyperspan::error::Error;
use hyperspan::shade::{BLOCK, Block, Inputs, Shader};
use hyperspan::space::PixelRect;
use hyperspan::stats::Stats;
use hyperspan::target::{DepthBuffer, Plane};
use rayon::ThreadPool;

use super::super::reference::Reference;
use super::cut::Cut;
use super::marks::Marks;
use super::outline::{Outline, Span};
use super::scene::{FIRST_ATTRIBUTE, LANES, MOST_ATTRIBUTES, Piece, Scene, Way};
use super::values::{Beyond, Compared, Values};

/// Where no polygon is.
const NONE: u32 = u32::MAX;

/// Of a scene with more polygons, the values of so many are compared.
const MOST_COMPARED: usize = 48;

/// What was looked at.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) scenes: u64,
    pub(crate) polygons: u64,
    /// Of them, those that a plane may cut.
    pub(crate) cut: u64,
    /// Pixels of all targets: each must show the last polygon that covers it, or none.
    pub(crate) pixels: u64,
    /// Pixels that are covered, once for each polygon.
    pub(crate) covered: u64,
    /// Beside them, those of cut polygons that are too near to a side to tell.
    pub(crate) undecided: u64,
    pub(crate) compared: Compared,
}

impl Tally {
    /// Adds what others have looked at.
    pub(crate) fn add(&mut self, other: &Self) {
        self.scenes += other.scenes;
        self.polygons += other.polygons;
        self.cut += other.cut;
        self.pixels += other.pixels;
        self.covered += other.covered;
        self.undecided += other.undecided;
        self.compared.add(&other.compared);
    }
}

/// What is wrong, and with which polygon.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wrong {
    pub(crate) piece: usize,
    pub(crate) what: String,
}

impl Wrong {
    pub(super) fn new(piece: usize, what: impl Into<String>) -> Self {
        Self { piece, what: what.into() }
    }
}

impl From<Error> for Wrong {
    fn from(error: Error) -> Self {
        Self::new(0, error.to_string())
    }
}

/// Writes which polygon a pixel is of.
#[derive(Clone, Copy, Debug)]
struct Ids(u32);

impl Shader for Ids {
    type Pixel = u32;
    const INPUTS: Inputs = Inputs::COVERAGE;
    const KEEPS_ALL: bool = true;

    #[inline(always)]
    fn start(&mut self, i: usize) {
        self.0 = i as u32;
    }

    #[inline(always)]
    fn shade(&mut self, _block: &Block<'_>, out: &mut [u32; BLOCK]) -> u16 {
        out.fill(self.0);
        u16::MAX
    }
}

/// Writes that, and everything that a shader sees.
#[derive(Clone, Copy, Debug)]
struct All(u32);

impl Shader for All {
    type Pixel = (u32, [f32; LANES]);

    #[inline(always)]
    fn start(&mut self, i: usize) {
        self.0 = i as u32;
    }

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, out: &mut [Self::Pixel; BLOCK]) -> u16 {
        let count = block.attributes.len().min(MOST_ATTRIBUTES);
        for (lane, (id, values)) in out.iter_mut().enumerate() {
            *id = self.0;
            values[0] = block.depth[lane];
            values[1] = block.w[lane];
            values[2] = block.inv_w[lane];
            for (k, lanes) in block.attributes[..count].iter().enumerate() {
                values[FIRST_ATTRIBUTE + k] = lanes[lane];
            }
        }
        block.mask
    }
}

/// Planes that are kept from scene to scene.
#[derive(Debug, Default)]
pub(crate) struct Desk {
    /// As drawn.
    pub(crate) ids: Vec<u32>,
    pub(crate) values: Vec<[f32; LANES]>,
    depths: Vec<f32>,
    bounds: DepthBounds,
    /// As they must be.
    right: Vec<u32>,
    right_depths: Vec<f32>,
    spans: Vec<Span>,
    pub(crate) marks: Marks,
}

impl Desk {
    /// Draws `scene` and compares; `pool` has the threads of those that are drawn on several.
    /// `spoil` may change what was drawn before it is compared, to see that it is noticed.
    pub(crate) fn check(
        &mut self,
        scene: &Scene,
        pool: &ThreadPool,
        spoil: &dyn Fn(&mut Self),
    ) -> Result<Tally, Wrong> {
        let mut tally = Tally { scenes: 1, ..Tally::default() };
        if scene.visible().is_empty() {
            return self.check_nothing(scene, pool, tally);
        }
        let (width, height) = scene.size();
        let size = width as usize * height as usize;
        if scene.depth.is_some() {
            // What each of them is without a test tells what is in front.
            self.right_depths.clear();
            self.right_depths.resize(size, CLEAR_DEPTH);
            let mut seen = vec![NONE; size];
            for i in 0..scene.pieces.len() {
                let alone = scene.alone(i);
                let of_one =
                    self.check(&alone, pool, spoil).map_err(|w| Wrong { piece: i, ..w })?;
                tally.add(&Tally { scenes: 0, ..of_one });
                self.test(scene, i as u32, &mut seen);
            }
            self.right = seen;
        }
        if let Some(outline) = only_outline(scene) {
            let counted = self.marks.draw(scene, pool)?;
            spoil(self);
            tally.polygons += 1;
            self.marks.compare(scene, &outline, counted, &mut tally)?;
            return Ok(tally);
        }
        let stats = self.draw(scene, pool)?;
        spoil(self);
        if scene.depth.is_some() {
            self.compare_all(scene)?;
            let differs = |(a, b): (&f32, &f32)| a.to_bits() != b.to_bits();
            return match self.depths.iter().zip(&self.right_depths).position(differs) {
                Some(i) => Err(Wrong::new(0, format!("depth {} at element {i}", self.depths[i]))),
                None => Ok(tally),
            };
        }
        tally.polygons += scene.pieces.len() as u64;
        tally.pixels += size as u64;
        let outlines: Vec<Option<Outline>> =
            scene.pieces.iter().map(|p| Outline::new(scene.viewport, &p.positions)).collect();
        if outlines.iter().all(Option::is_some) {
            let covered = self.lay_out(scene, &outlines);
            self.compare_all(scene)?;
            if stats.pixels_covered != covered {
                let drawn = stats.pixels_covered;
                return Err(Wrong::new(0, format!("{drawn} pixels are drawn, not {covered}")));
            }
            tally.covered += covered;
            self.compare_sum(scene, covered)?;
        } else {
            tally.cut += outlines.iter().filter(|outline| outline.is_none()).count() as u64;
            self.compare_cut(scene, &stats, &mut tally)?;
        }
        if scene.values {
            self.compare_values(scene, &mut tally.compared)?;
        }
        Ok(tally)
    }

    /// A target beside the viewport.
    fn check_nothing(
        &mut self,
        scene: &Scene,
        pool: &ThreadPool,
        tally: Tally,
    ) -> Result<Tally, Wrong> {
        self.draw(scene, pool)?;
        if self.ids.iter().all(|id| *id == NONE) {
            Ok(tally)
        } else {
            Err(Wrong::new(0, "something is drawn beside the viewport"))
        }
    }

    fn draw(&mut self, scene: &Scene, pool: &ThreadPool) -> Result<Stats, Error> {
        let (width, height) = scene.size();
        let size = width as usize * height as usize;
        self.ids.clear();
        self.ids.resize(size, NONE);
        let mut depth = None;
        if let Some((_, bounded)) = scene.depth {
            self.depths.clear();
            self.depths.resize(size, CLEAR_DEPTH);
            let plane = Plane::new(&mut self.depths, width, height)?;
            self.bounds.forget();
            depth = Some(if bounded { plane.with_bounds(&mut self.bounds) } else { plane });
        }
        let ids = Plane::new(&mut self.ids, width, height)?;
        if !scene.values {
            return Ok(run(scene, ids, Ids(0), depth, pool));
        }
        if self.values.len() < size {
            self.values.resize(size, [0.0; LANES]);
        }
        let values = Plane::new(&mut self.values, width, height)?;
        Ok(run(scene, (ids, values), All(0), depth, pool))
    }

    /// Puts what was drawn of piece `i`, alone, through the depth test.
    fn test(&mut self, scene: &Scene, i: u32, seen: &mut [u32]) {
        let Some((test, _)) = scene.depth else { return };
        let lane = if test.source == DepthSource::Z { 0 } else { 2 };
        let pixels = self.ids.iter().zip(&self.values);
        for ((id, values), (seen, depth)) in pixels.zip(seen.iter_mut().zip(&mut self.right_depths))
        {
            if *id != NONE && test.compare.passes(values[lane], *depth) {
                *seen = i;
                *depth = if test.write { values[lane] } else { *depth };
            }
        }
    }

    /// Lays out the ids as they must be; returns how many pixels were set, again and again.
    fn lay_out(&mut self, scene: &Scene, outlines: &[Option<Outline>]) -> u64 {
        let (window, visible) = (scene.window, scene.visible());
        let width = scene.size().0 as usize;
        self.right.clear();
        self.right.resize(self.ids.len(), NONE);
        let mut covered = 0;
        for (i, outline) in outlines.iter().flatten().enumerate() {
            let rows = outline.rows();
            for y in rows.start.max(visible.y0)..rows.end.min(visible.y1) {
                outline.row(y, &mut self.spans);
                let row = &mut self.right[(y - window.y0) as usize * width..][..width];
                for span in &self.spans {
                    let Some([start, end]) = within(*span, visible) else { continue };
                    row[(start - window.x0) as usize..(end - window.x0) as usize].fill(i as u32);
                    covered += u64::from(end.abs_diff(start));
                }
            }
        }
        covered
    }

    /// Are all pixels as they must be?
    fn compare_all(&self, scene: &Scene) -> Result<(), Wrong> {
        if self.ids == self.right {
            return Ok(());
        }
        let differs = |(a, b): (&u32, &u32)| a != b;
        let at = self.ids.iter().zip(&self.right).position(differs).unwrap_or_default();
        let (drawn, right) = (self.ids[at], self.right[at]);
        let piece = if right == NONE { drawn } else { right };
        let [x, y] = place(scene, at);
        let name = |id: u32| if id == NONE { "nothing".to_owned() } else { format!("#{id}") };
        let what = format!("({x}, {y}) shows {}, not {}", name(drawn), name(right));
        Err(Wrong::new(piece as usize, what))
    }

    /// Do pieces that share their edges cover what their outline covers, each pixel once?
    fn compare_sum(&mut self, scene: &Scene, covered: u64) -> Result<(), Wrong> {
        let Some(outline) = &scene.outline else { return Ok(()) };
        let Some(outline) = Outline::new(scene.viewport, &outline.positions) else { return Ok(()) };
        let whole = self.lay_out(scene, &[Some(outline)]);
        let missing = |(id, right): (&u32, &u32)| (*id == NONE) != (*right == NONE);
        if whole != covered || self.ids.iter().zip(&self.right).any(missing) {
            return Err(Wrong::new(0, format!("{covered} pixels in parts, {whole} as a whole")));
        }
        Ok(())
    }

    /// Polygons that planes cut; they do not lie upon each other.
    fn compare_cut(&self, scene: &Scene, stats: &Stats, tally: &mut Tally) -> Result<(), Wrong> {
        let drawn = self.ids.iter().filter(|id| **id != NONE).count() as u64;
        let counted = stats.pixels_covered;
        if counted != drawn && counted.wrapping_sub(drawn) > crowded(scene) {
            return Err(Wrong::new(0, format!("{counted} pixels are drawn on {drawn}")));
        }
        tally.covered += drawn;
        for (i, piece) in scene.pieces.iter().enumerate() {
            let Some(cut) = cut(scene, piece) else { continue };
            self.compare_rows(scene, &cut, &|id| id == i as u32, i, tally)?;
        }
        if let Some(cut) = scene.outline.as_ref().and_then(|piece| cut(scene, piece)) {
            self.compare_rows(scene, &cut, &|id| id != NONE, 0, &mut Tally::default())?;
        }
        Ok(())
    }

    fn compare_rows(
        &self,
        scene: &Scene,
        cut: &Cut,
        is_drawn: &dyn Fn(u32) -> bool,
        piece: usize,
        tally: &mut Tally,
    ) -> Result<(), Wrong> {
        let (window, visible) = (scene.window, scene.visible());
        let width = scene.size().0 as usize;
        for y in visible.y0..visible.y1 {
            let covered = cut.row(y, visible.x0..visible.x1);
            let row = &self.ids[(y - window.y0) as usize * width..][..width];
            let of_span = |[start, end]: Span| {
                let drawn = row[(start - window.x0) as usize..(end - window.x0) as usize].iter();
                (drawn.filter(|id| is_drawn(**id)).count(), (end - start) as usize)
            };
            let ((sure, of_sure), (possible, of_possible)) =
                (of_span(covered.surely), of_span(covered.perhaps));
            let all = row.iter().filter(|id| is_drawn(**id)).count();
            if sure != of_sure || possible != all {
                let what = format!("row {y}: {all} pixels are drawn, {covered:?}");
                return Err(Wrong::new(piece, what));
            }
            tally.undecided += (of_possible - of_sure) as u64;
        }
        Ok(())
    }

    fn compare_values(&self, scene: &Scene, compared: &mut Compared) -> Result<(), Wrong> {
        let (window, visible) = (scene.window, scene.visible());
        let width = scene.size().0 as usize;
        let step = scene.pieces.len().div_ceil(MOST_COMPARED).max(1);
        for (i, piece) in scene.pieces.iter().enumerate().step_by(step) {
            let Some(reference) = reference(scene, piece) else { continue };
            let values = Values::new(piece, &reference, scene.precision);
            let rows = Outline::new(scene.viewport, &piece.positions).map(|o| o.rows());
            let rows = rows.unwrap_or(visible.y0..visible.y1);
            for y in rows.start.max(visible.y0)..rows.end.min(visible.y1) {
                let first = (y - window.y0) as usize * width;
                let (ids, values_of) =
                    (&self.ids[first..][..width], &self.values[first..][..width]);
                let mut at = 0;
                for run in ids.chunk_by(|a, b| a == b) {
                    let from = at;
                    at += run.len();
                    if run[0] != i as u32 {
                        continue;
                    }
                    let wrong = |Beyond { at: [x, y], what }| {
                        Wrong::new(i, format!("at ({x}, {y}) {what}"))
                    };
                    let x = window.x0 + from as i32;
                    values.compare(x, y, &values_of[from..at], compared).map_err(wrong)?;
                }
            }
        }
        Ok(())
    }
}

/// Of a single piece that no plane cuts and whose coverage is all that counts.
fn only_outline(scene: &Scene) -> Option<Outline> {
    match &scene.pieces[..] {
        [piece] if !scene.values && scene.depth.is_none() => {
            Outline::new(scene.viewport, &piece.positions)
        }
        _ => None,
    }
}

/// What depth buffers are cleared to: every compare function passes and fails.
const CLEAR_DEPTH: f32 = 0.5;

fn reference(scene: &Scene, piece: &Piece) -> Option<Reference> {
    Reference::new(&piece.positions, &piece.lists(), &scene.viewport)
}

fn cut(scene: &Scene, piece: &Piece) -> Option<Cut> {
    let visible = scene.visible();
    let bare = Piece::bare(piece.positions.clone());
    Cut::new(&reference(scene, &bare)?, [visible.x0, visible.y0], scene.viewport.grid())
}

/// How often pixels may be drawn again that three pieces or more may cover: a piece thinner than the
/// grid's step can be turned over by the snap, and then lies on both its neighbours.
fn crowded(scene: &Scene) -> u64 {
    let visible = scene.visible();
    let cuts: Vec<Option<Cut>> = scene.pieces.iter().map(|piece| cut(scene, piece)).collect();
    let mut again = 0;
    for y in visible.y0..visible.y1 {
        let perhaps = |cut: &Option<Cut>| match cut {
            Some(cut) => cut.row(y, visible.x0..visible.x1).perhaps,
            None => [visible.x0, visible.x1],
        };
        let spans: Vec<Span> = cuts.iter().map(perhaps).collect();
        for x in visible.x0..visible.x1 {
            let pieces = spans.iter().filter(|[start, end]| (*start..*end).contains(&x)).count();
            again += if pieces > 2 { pieces as u64 - 1 } else { 0 };
        }
    }
    again
}

fn within([start, end]: Span, rect: PixelRect) -> Option<Span> {
    let span = [start.max(rect.x0), end.min(rect.x1)];
    (span[0] < span[1]).then_some(span)
}

fn place(scene: &Scene, at: usize) -> [i32; 2] {
    let width = scene.size().0 as usize;
    [scene.window.x0 + (at % width) as i32, scene.window.y0 + (at / width) as i32]
}

/// Draws all pieces.
pub(super) fn run<'a, T, S>(
    scene: &Scene,
    mut target: T,
    mut shader: S,
    mut depth: Option<DepthBuffer<'a>>,
    pool: &ThreadPool,
) -> Stats
where
    T: Rows + Send,
    T::Pixel: Send,
    S: Shader<Pixel = T::Pixel> + Clone + Sync,
{
    let mut tiler = scene.tiler();
    if scene.way == Way::OneByOne {
        for (i, piece) in scene.pieces.iter().enumerate() {
            shader.start(i);
            tiler.draw(piece, &mut shader, &mut target, depth.as_mut());
        }
        return tiler.stats();
    }
    let mut frame = Frame::new(tiler);
    let screen = Screen { target, depth, clear: None };
    let polygons = Polygons::new(&scene.pieces, With(shader));
    if scene.way == Way::Threads {
        frame.set_parallel(true);
        pool.install(|| frame.draw(screen, &[&polygons]));
    } else {
        frame.draw(screen, &[&polygons]);
    }
    frame.stats()
}
