//! Oracles: what the tiler is to produce, computed slowly and plainly, in exact arithmetic.
//! They follow the promises P1 and P2 of docs/design.md word by word and share no code with the
//! library but its settings (viewport, interpolation) and its trait for polygons.
//!
//! - `exact`     rationals, and their correct rounding to `f32`
//! - `coverage`  P1: snapping, and the half-open non-zero winding rule, in `i128`
//! - `clipper`   a naive clipper in rationals
//! - `plane`     P2: values at a pixel through the inverse of the transform; `quick` ones of many
//! - `edges`     P2, what is not affine: along edges and across spans
//! - `judge`     compares a picture with them
//! - `probe`     draws with the library and records what arrives, pixel by pixel
//! - `shapes`    strategies that make polygons

pub(crate) mod clipper;
pub(crate) mod coverage;
pub(crate) mod edges;
pub(crate) mod exact;
pub(crate) mod judge;
pub(crate) mod plane;
pub(crate) mod probe;
pub(crate) mod shapes;

use hyperspan::polygon::Polygon;

/// A polygon as the tests keep it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Poly {
    /// Clip space (x, y, z, w).
    pub(crate) positions: Vec<[f64; 4]>,
    /// One list for each vertex, all of the same length.
    pub(crate) attributes: Vec<Vec<f32>>,
}

impl Poly {
    /// A polygon without attributes.
    pub(crate) fn bare(positions: &[[f64; 4]]) -> Self {
        Self { positions: positions.to_vec(), attributes: vec![Vec::new(); positions.len()] }
    }

    /// The same polygon, its list of vertices beginning at vertex `by`.
    pub(crate) fn rotated(&self, by: usize) -> Self {
        let mut turned = self.clone();
        turned.positions.rotate_left(by);
        turned.attributes.rotate_left(by);
        turned
    }

    /// The same polygon the other way round.
    pub(crate) fn reversed(&self) -> Self {
        let mut turned = self.clone();
        turned.positions.reverse();
        turned.attributes.reverse();
        turned
    }

    /// The same polygon with all four coordinates multiplied by `factor`.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        let positions = self.positions.iter().map(|p| p.map(|c| c * factor)).collect();
        Self { positions, attributes: self.attributes.clone() }
    }
}

impl Polygon for Poly {
    fn len(&self) -> usize {
        self.positions.len()
    }

    fn attribute_count(&self) -> usize {
        self.attributes.first().map_or(0, Vec::len)
    }

    fn position(&self, i: usize) -> [f64; 4] {
        self.positions[i]
    }

    fn attribute(&self, i: usize, k: usize) -> f32 {
        self.attributes[i][k]
    }
}
