//! Gradients and values, on a window of a few pixels, for one polygon of up to eight vertices with
//! up to three attributes, flat or bent, clipped or not. Nothing panics, and, against the oracles
//! of tests/oracle in rational numbers:
//!
//! - `Exact` is correctly rounded, bit for bit, at every pixel: attributes, depth, w and 1/w;
//! - `Fast` is within the bound of P2, depth within a unit in the last place;
//! - the pixels are P1's, exactly where no plane cuts the polygon;
//! - both precisions draw the same pixels.
//!
//! What has no promise is left out: positions that are not finite or whose numbers are lost beside
//! the largest; values of more than three vertices where `f64` cannot tell how flat they are; of a
//! clipped polygon, all if it reaches the eye itself, and centres that are as near to its edge as
//! new vertices are rounded; and of one that is seen from the side, centres with two nearest
//! vertices.

use hyperspan::space::{DepthRange, Grid, PixelRect, Viewport};
use hyperspan::tiler::{Outcome, Precision};
use hyperspan::varying::Interpolation;

use super::bytes::Bytes;
use super::shape::{RATIO, Shape};
use crate::oracle::Poly;
use crate::oracle::clipper::{self, Side};
use crate::oracle::coverage::is_unclipped;
use crate::oracle::exact::approximate;
use crate::oracle::judge::{self, TOLERANCE};
use crate::oracle::plane::Plane;
use crate::oracle::probe::{self, Picture, View};

pub(crate) fn gradients(data: &[u8]) {
    let bytes = &mut Bytes(data);
    let (view, poly) = scene(bytes);
    if poly.positions.len() < 3 || !poly.positions.iter().flatten().all(|c| c.is_finite()) {
        return;
    }
    let numbers = || poly.positions.iter().flatten().map(|c| c.abs()).filter(|c| *c > 0.0);
    let [least, most] = [numbers().fold(f64::INFINITY, f64::min), numbers().fold(0.0, f64::max)];
    if most / RATIO > least {
        return;
    }

    let fast = View { precision: Precision::Fast, ..view.clone() };
    let (outcome, picture, _) = probe::draw(&view, &poly);
    let (outcome_fast, picture_fast, _) = probe::draw(&fast, &poly);
    assert_eq!(outcome, outcome_fast);
    assert!(picture.keys().eq(picture_fast.keys()), "coverage depends on the precision");
    let whole = is_unclipped(view.viewport, &poly);
    // New vertices between giants may lie anywhere near their edge, and those at the eye anywhere, if
    // the polygon is seen from the side.
    let is_placed = most / 1e6 < least && !(is_from_the_side(&poly) && reaches_eye(&view, &poly));
    if whole || is_placed {
        let right = if outcome == Outcome::Drawn || whole {
            judge::coverage(&view, &poly, &picture)
        } else {
            Ok(())
        };
        assert!(right.is_ok(), "{right:?} of {poly:?} on {view:?}");
    }
    if !is_judged(&view, &poly) {
        return;
    }
    for (view, mut picture) in [(&view, picture), (&fast, picture_fast)] {
        if !whole {
            keep_inside(view, &poly, &mut picture);
        }
        drop_ties(view, &poly, &mut picture);
        let right = judge::values(view, &poly, &picture);
        assert!(right.is_ok(), "{right:?} of {poly:?} on {view:?}");
    }
}

/// Does `f64` tell whether the polygon is flat? That is how the library judges it.
fn is_judged(view: &View, poly: &Poly) -> bool {
    let size = |p: &[f64; 4]| p.iter().fold(0.0, |size: f64, c| size.max(c.abs()));
    let sizes = || poly.positions.iter().map(size).filter(|size| *size > 0.0);
    let [least, most] = [sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max)];
    let sine = Plane::new(poly, view.viewport, &[]).sine();
    poly.positions.len() == 3 || (most <= 1e6 * least && sine > 1e-6)
}

/// Is the polygon's plane one through the eye, or nearly?
fn is_from_the_side(poly: &Poly) -> bool {
    let unit = |[x, y, _, w]: &[f64; 4]| {
        let length = (x * x + y * y + w * w).sqrt();
        [x, y, w].map(|c| if length > 0.0 { c / length } else { 0.0 })
    };
    let all: Vec<[f64; 3]> = poly.positions.iter().map(unit).collect();
    let volume = |[a, b, c]: [f64; 3], [d, e, f]: [f64; 3], [g, h, i]: [f64; 3]| {
        (a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)).abs()
    };
    all.iter().all(|p| all.iter().all(|q| all.iter().all(|r| volume(*p, *q, *r) < 1e-9)))
}

/// Is a corner of the clipped polygon at the eye, or nearly, so that its place and its w are what
/// rounding leaves?
fn reaches_eye(view: &View, poly: &Poly) -> bool {
    let corners = clipper::clip(poly, &clipper::planes(view.viewport));
    let most = poly.positions.iter().flatten().fold(0.0, |most: f64, c| most.max(c.abs()));
    corners.iter().any(|corner| approximate(&corner.position[3]) < 1e-9 * most)
}

/// Drops the pixels that are not surely inside; all of them where the clipped polygon reaches the eye.
fn keep_inside(view: &View, poly: &Poly, picture: &mut Picture) {
    if reaches_eye(view, poly) {
        picture.clear();
    }
    let corners = clipper::clip(poly, &clipper::planes(view.viewport));
    let outline = clipper::outline(view.viewport, &corners);
    picture.retain(|(y, x), _| clipper::side(&outline, *x, *y, TOLERANCE) == Side::Inside);
}

/// Of a polygon that is seen from the side, drops the pixels to which two vertices are as near,
/// or nearly.
fn drop_ties(view: &View, poly: &Poly, picture: &mut Picture) {
    if !Plane::new(poly, view.viewport, &[]).is_edge_on() {
        return;
    }
    let corners = clipper::clip(poly, &clipper::planes(view.viewport));
    let places = clipper::outline(view.viewport, &corners);
    picture.retain(|(y, x), _| {
        let [x, y] = [*x, *y].map(|c| f64::from(c) + 0.5);
        let squared = |p: &[f64; 2]| (p[0] - x) * (p[0] - x) + (p[1] - y) * (p[1] - y);
        let mut distances: Vec<f64> = places.iter().map(squared).collect();
        distances.sort_by(f64::total_cmp);
        distances.first().zip(distances.get(1)).is_none_or(|(a, b)| *a < b * (1.0 - 1e-6))
    });
}

/// A polygon, and a window on it.
fn scene(bytes: &mut Bytes<'_>) -> (View, Poly) {
    let corner = [(); 2].map(|()| match bytes.below(4) {
        0 => bytes.pick(&[1 << 24, -(1 << 24), -100, 3]),
        _ => 0,
    });
    let sides = bytes.pick(&[(24, 24), (64, 64), (40, 30), (1920, 1080), (16384, 16384), (7, 5)]);
    let viewport = Viewport::new(corner[0], corner[1], sides.0, sides.1)
        .expect("sides of 16384 at most")
        .with_grid(bytes.pick(&[Grid::Sixteen, Grid::Sixteen, Grid::Eight]))
        .with_depth_range(bytes.pick(&[DepthRange::ZeroToOne, DepthRange::MinusOneToOne]));
    let at = [(); 2].map(|()| i32::from(bytes.below(24)));
    let size = bytes.pick(&[(5, 4), (3, 3), (17, 1), (1, 9), (2, 2)]);
    let window = PixelRect::new(corner[0] + at[0], corner[1] + at[1], size.0, size.1);
    let count = usize::from(bytes.below(4));
    let interpolation = (0..bytes.below(4))
        .map(|_| {
            bytes.pick(&[
                Interpolation::Perspective,
                Interpolation::NoPerspective,
                Interpolation::Flat,
            ])
        })
        .collect();
    let shape = Shape::new(bytes, count, viewport, (corner[0], corner[1]));
    let attributes = (0..shape.positions.len())
        .map(|i| shape.attributes[i * count..][..count].to_vec())
        .collect();
    let view = View { window, interpolation, ..View::whole(viewport) };
    (view, Poly { positions: shape.positions, attributes })
}
