//! Compares a picture with the oracles.

use super::Poly;
use super::clipper::{self, Side};
use super::coverage::{covered, is_unclipped, snapped};
use super::plane::Plane;
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
    /// Beside them, those that the plane does not define.
    pub(crate) left_out: usize,
}

/// Has every pixel the right values, bit for bit?
pub(crate) fn values(view: &View, poly: &Poly, picture: &Picture) -> Result<Compared, String> {
    let plane = Plane::new(poly, view.viewport, &view.interpolation);
    let mut compared = Compared::default();
    for (&(y, x), seen) in picture {
        let at = plane.at(x, y);
        let first = [(at.inv_w(), seen.inv_w), (at.w(), seen.w), (at.depth(), seen.depth)];
        let attributes = seen.attributes.iter().enumerate().map(|(k, s)| (at.attribute(k), *s));
        for (number, (right, seen)) in first.into_iter().chain(attributes).enumerate() {
            let Some(right) = right else {
                compared.left_out += 1;
                continue;
            };
            compared.values += 1;
            let given = |i: usize| number < 3 || poly.attributes[i][number - 3] != right;
            compared.between += usize::from((0..poly.positions.len()).all(given));
            if right.to_bits() != seen {
                let what = match number {
                    0 => "1/w".to_owned(),
                    1 => "w".to_owned(),
                    2 => "depth".to_owned(),
                    k => format!("attribute {}", k - 3),
                };
                let (right_bits, drawn) = (right.to_bits(), f32::from_bits(seen));
                return Err(format!(
                    "{what} at ({x}, {y}) is {right:e} = {right_bits:#x}, drawn {drawn:e} = {seen:#x}"
                ));
            }
        }
    }
    Ok(compared)
}
