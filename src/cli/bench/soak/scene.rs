//! What is drawn: polygons, and how.

use std::sync::Arc;

use hyperspan::depth::DepthTest;
use hyperspan::placed::Placed;
use hyperspan::polygon::Polygon;
use hyperspan::simd::Simd;
use hyperspan::space::{DepthRange, PixelRect, Viewport};
use hyperspan::tiler::{Precision, Tiler};

/// Most attributes of a polygon.
pub(crate) const MOST_ATTRIBUTES: usize = 5;

/// What is stored of a pixel: depth, w, 1/w, then attributes.
pub(crate) const LANES: usize = FIRST_ATTRIBUTE + MOST_ATTRIBUTES;
pub(crate) const FIRST_ATTRIBUTE: usize = 3;

/// A polygon.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// Clip space.
    pub(crate) positions: Vec<[f64; 4]>,
    /// `count` for each vertex.
    pub(crate) attributes: Vec<f32>,
    pub(crate) count: usize,
    /// Where the vertices of the whole mesh lie, and which of them are its own.
    pub(crate) placed: Option<(Arc<Placed>, Vec<usize>)>,
}

impl Piece {
    /// Without attributes.
    pub(crate) fn bare(positions: Vec<[f64; 4]>) -> Self {
        Self { positions, attributes: Vec::new(), count: 0, placed: None }
    }

    /// One list of attributes for each vertex.
    pub(crate) fn lists(&self) -> Vec<Vec<f32>> {
        let list = |i| self.attributes[i * self.count..][..self.count].to_vec();
        (0..self.positions.len()).map(list).collect()
    }

    /// As `hyperspan tile` reads it.
    pub(crate) fn text(&self) -> String {
        let line = |i: usize| {
            let position = self.positions[i].iter().map(|c| format!("{c:e} "));
            let values = (0..self.count).map(|k| format!(" {:e}", self.attribute(i, k)));
            position.chain(values).collect::<String>().trim_end().to_owned() + "\n"
        };
        (0..self.positions.len()).map(line).collect()
    }
}

impl Polygon for Piece {
    fn len(&self) -> usize {
        self.positions.len()
    }

    fn attribute_count(&self) -> usize {
        self.count
    }

    fn position(&self, i: usize) -> [f64; 4] {
        self.positions[i]
    }

    fn attribute(&self, i: usize, k: usize) -> f32 {
        self.attributes[i * self.count + k]
    }

    fn placed(&self) -> Option<&Placed> {
        self.placed.as_ref().map(|(placed, _)| placed.as_ref())
    }

    fn placed_index(&self, i: usize) -> usize {
        self.placed.as_ref().map_or(i, |(_, numbers)| numbers[i])
    }
}

/// How the polygons are handed over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    OneByOne,
    /// As a draw list, on one thread.
    List,
    /// On several.
    Threads,
}

/// Polygons, and how they are drawn.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) kind: &'static str,
    pub(crate) viewport: Viewport,
    /// The pixels of the target.
    pub(crate) window: PixelRect,
    pub(crate) pieces: Vec<Piece>,
    pub(crate) precision: Precision,
    pub(crate) simd: (&'static str, Simd),
    pub(crate) way: Way,
    /// Are the values looked at, not only which pixels are covered?
    pub(crate) values: bool,
    /// The test, and are there bounds of the depths?
    pub(crate) depth: Option<(DepthTest, bool)>,
    /// What the pieces cover together, each pixel once, if they have an outline of their own.
    pub(crate) outline: Option<Piece>,
}

impl Scene {
    /// The pixels that may be drawn.
    pub(crate) fn visible(&self) -> PixelRect {
        self.viewport.rect().intersect(self.window)
    }

    /// (width, height) of the target.
    pub(crate) fn size(&self) -> (u32, u32) {
        (self.window.x1.abs_diff(self.window.x0), self.window.y1.abs_diff(self.window.y0))
    }

    pub(crate) fn tiler(&self) -> Tiler {
        let mut tiler = Tiler::new(self.viewport);
        tiler
            .set_origin(self.window.x0, self.window.y0)
            .set_precision(self.precision)
            .set_simd(self.simd.1);
        if let Some((test, _)) = self.depth {
            tiler.set_depth_test(test);
        }
        tiler
    }

    /// Piece `i` alone, without a depth test.
    pub(crate) fn alone(&self, i: usize) -> Self {
        let pieces = vec![self.pieces[i].clone()];
        Self { pieces, depth: None, outline: None, way: Way::OneByOne, ..self.clone() }
    }

    /// How it is drawn, in the words of `hyperspan tile`, and piece `i`.
    pub(crate) fn text(&self, i: usize) -> String {
        let (rect, window) = (self.viewport.rect(), self.window);
        let range = match self.viewport.depth_range() {
            DepthRange::ZeroToOne => "0 1",
            DepthRange::MinusOneToOne => "-1 1",
        };
        let precision = if self.precision == Precision::Fast { "fast" } else { "exact" };
        format!(
            "# viewport at {},{}, --size {}x{}, grid {:?}; target from {},{} to {},{}; \
             --precision {precision} --simd {} {:?}\n# numbers are f64: `tile` reads f32\n\
             zrange {range}\n{}",
            rect.x0,
            rect.y0,
            self.viewport.width(),
            self.viewport.height(),
            self.viewport.grid(),
            window.x0,
            window.y0,
            window.x1,
            window.y1,
            self.simd.0,
            self.way,
            self.pieces.get(i).map_or(String::new(), Piece::text)
        )
    }
}
