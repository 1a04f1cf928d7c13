//! Compares a picture with the oracles.

use std::cell::LazyCell;

use hyperspan::tiler::Precision;

use super::Poly;
use super::clipper::{self, Side};
use super::coverage::{covered, is_unclipped, snapped};
use super::edges::Edges;
use super::plane::{Plane, Right};
use super::probe::{Picture, View};

/// What clipping and snapping may move an edge by, in pixels.
pub(crate) const TOLERANCE: f64 = 1.0 / 16384.0;

/// Does the picture have the right pixels? Exactly those, if no plane cuts the polygon; else, of
/// those that are farther than the tolerance from its edges.
pub(crate) fn coverage(view: &View, poly: &Poly, picture: &Picture) -> Result<(), String> {
    let rect = view.visible();
    if is_unclipped(view.viewport, poly) {
        let points = snapped(view.viewport, poly);
        let right = covered(view.viewport.grid(), &points, rect);
        let drawn: Vec<_> = picture.keys().map(|&(y, x)| (x, y)).collect();
        return if drawn == right {
            Ok(())
        } else {
            Err(format!("drawn {drawn:?}, right {right:?}"))
        };
    }
    let corners = clipper::clip(poly, &clipper::planes(view.viewport));
    let outline = clipper::outline(view.viewport, &corners);
    for y in rect.y0..rect.y1 {
        for x in rect.x0..rect.x1 {
            match (clipper::side(&outline, x, y, TOLERANCE), picture.contains_key(&(y, x))) {
                (Side::Inside, false) => return Err(format!("({x}, {y}) is not drawn")),
                (Side::Outside, true) => return Err(format!("({x}, {y}) is drawn")),
                _ => {}
            }
        }
    }
    Ok(())
}

/// How many values were compared.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Compared {
    pub(crate) values: usize,
    /// Of them, those that no vertex has.
    pub(crate) between: usize,
    /// Of them, those that run along edges and across spans.
    pub(crate) across: usize,
    /// Beside them, those without a promise.
    pub(crate) left_out: usize,
}

/// Has every pixel the right values, to P2's precision? In `Exact` bit for bit, but those that
/// run along the edges of a polygon that was clipped: its new vertices are rounded.
pub(crate) fn values(view: &View, poly: &Poly, picture: &Picture) -> Result<Compared, String> {
    let plane = Plane::new(poly, view.viewport, &view.interpolation);
    let edges = Edges::new(poly, view.viewport, &view.interpolation);
    let whole = is_unclipped(view.viewport, poly);
    let mut compared = Compared::default();
    for (&(y, x), seen) in picture {
        let at = plane.at(x, y);
        let across = LazyCell::new(|| edges.at(x, y));
        for number in 0..3 + seen.attributes.len() {
            let (right, drawn) = match number {
                0 => (at.inv_w(), seen.inv_w),
                1 => (at.w(), seen.w),
                2 => (at.depth(), seen.depth),
                k => (at.attribute(k - 3), seen.attributes[k - 3]),
            };
            let right = match right {
                Right::Is(right) => Some((right, true)),
                Right::Across => across.as_ref().filter(|a| whole || a.is_sound()).map(|across| {
                    compared.across += 1;
                    let right = match number {
                        0 => across.inv_w(),
                        1 => across.w(),
                        2 => across.depth(),
                        k => across.attribute(k - 3),
                    };
                    (right, whole)
                }),
                Right::Anything => None,
            };
            let Some((right, is_exact)) = right else {
                compared.left_out += 1;
                continue;
            };
            compared.values += 1;
            let given = |i: usize| number < 3 || poly.attributes[i][number - 3] != right;
            compared.between += usize::from((0..poly.positions.len()).all(given));
            let drawn = f32::from_bits(drawn);
            let value = |i: usize| match number {
                0 | 1 => right,
                2 => 1.0,
                k => poly.attributes[i][k - 3],
            };
            let values = || (0..poly.positions.len()).map(value);
            let most = values().map(f32::abs).fold(0.0, f32::max);
            let meets_zero = values().any(|v| v <= 0.0) && values().any(|v| v >= 0.0);
            let near = match (is_exact, view.precision) {
                (true, Precision::Exact) => false,
                (true, Precision::Fast) => is_fast(number == 2, right, drawn, most, meets_zero),
                (false, _) => (right - drawn).abs() <= most * 1e-5,
            };
            if right.to_bits() != drawn.to_bits() && !near {
                let what = match number {
                    0 => "1/w".to_owned(),
                    1 => "w".to_owned(),
                    2 => "depth".to_owned(),
                    k => format!("attribute {}", k - 3),
                };
                let bits = [right, drawn].map(f32::to_bits);
                return Err(format!(
                    "{what} at ({x}, {y}) is {right:e} = {:#x}, drawn {drawn:e} = {:#x}",
                    bits[0], bits[1]
                ));
            }
        }
    }
    Ok(compared)
}

/// Is `drawn` within the bound of `Fast`: 4u |value| + 3u M, where M is the largest magnitude at
/// the vertices, or a unit in the last place for depth? An attribute that `meets_zero` has 7u |value| +
/// 2^-27 M, too, which is less where the value is small.
fn is_fast(is_depth: bool, right: f32, drawn: f32, most: f32, meets_zero: bool) -> bool {
    if is_depth {
        return right.to_bits().abs_diff(drawn.to_bits()) <= 1;
    }
    const U: f64 = 1.0 / 16_777_216.0;
    let [right, drawn, most] = [right, drawn, most].map(f64::from);
    // The right value is rounded itself, by at most half a unit: u |value|, or 2^-150.
    let rounded = (U * right.abs()).max(f64::from(f32::from_bits(1)) / 2.0);
    let promised = 4.0 * U * right.abs() + 3.0 * U * most;
    let near_zero = 7.0 * U * right.abs() + most / 134_217_728.0;
    let bound = if meets_zero { promised.min(near_zero) } else { promised };
    (right - drawn).abs() <= bound + rounded
}
