//! What the fuzzers found, each with a line on what it was; docs/fuzzing.md lists them.

use crate::oracle::Poly;
use crate::oracle::judge;
use crate::oracle::probe::{self, View};
use hyperspan::space::{DepthRange, Viewport};
use hyperspan::texture::Texture;
use hyperspan::tiler::Precision;

/// Draws `poly` in both precisions; pixels and values must be the oracles'.
fn agrees(view: &View, poly: &Poly) {
    for precision in [Precision::Exact, Precision::Fast] {
        let view = View { precision, ..view.clone() };
        let (_, picture, _) = probe::draw(&view, poly);
        assert!(!picture.is_empty());
        judge::values(&view, poly, &picture).expect("the right values");
    }
}

/// A product of -0 had its floor taken for -1: the last column instead of the first.
#[test]
fn fuzzed_texture_coordinate_of_minus_zero_is_zero() {
    for side in [1, 3, 32, 64] {
        let texels: Vec<[u8; 4]> = (0..side * side).map(u32::to_le_bytes).collect();
        let texture = Texture::new(side, side, &texels).expect("a square");
        let bottom = (side * (side - 1)).to_le_bytes();
        for (u, v) in [(-0.0, 0.0), (0.0, -0.0), (-0.0, -0.0)] {
            assert_eq!(texture.nearest(u, v), bottom, "{u}, {v} of {side} x {side}");
        }
    }
}

/// Where the three vertices that stand for the plane were all (0, 0, 0, 0), depth was 0 all over,
/// and not the nearest vertex's.
#[test]
fn fuzzed_depth_of_vertices_at_no_place_is_the_nearest_ones() {
    let viewport = Viewport::new(0, 0, 40, 30).expect("small");
    for range in [DepthRange::ZeroToOne, DepthRange::MinusOneToOne] {
        let triangle = [[0.1, 0.1, 0.5, 1.0], [0.7, 0.2, 0.25, 1.0], [0.3, 0.9, 0.75, 1.0]];
        let positions = [[0.0; 4], triangle[0], triangle[1], triangle[2]];
        agrees(&View::whole(viewport.with_depth_range(range)), &Poly::bare(&positions));
    }
}
