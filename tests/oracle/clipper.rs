//! A naive clipper in rationals: Sutherland and Hodgman, one plane after the other.

use hyperspan::space::{DepthRange, Viewport};

use super::Poly;
use super::coverage::GUARD;
use super::exact::{Q, approximate, fraction, q, reduced, sum};

/// A vertex of a clipped polygon.
#[derive(Clone, Debug)]
pub(crate) struct Corner {
    /// Clip space (x, y, z, w).
    pub(crate) position: [Q; 4],
    /// Weights of the vertices as given, one for each: they sum to 1, and whatever is linear
    /// along the polygon's edges in clip space has this mean of its values here.
    pub(crate) weights: Vec<Q>,
    /// The same for what is linear along the edges in the framebuffer; where an end of an edge
    /// has w <= 0, in clip space.
    pub(crate) framebuffer_weights: Vec<Q>,
    /// On its way, an end of its edge was at infinity (w = 0): in f64, w may well have come out
    /// on either side of it, and with it the rule for `framebuffer_weights`.
    pub(crate) by_infinity: bool,
}

/// The planes in their order, as the coefficients of a distance that is negative outside.
pub(crate) fn planes(viewport: Viewport) -> Vec<[Q; 4]> {
    let (zero, one, minus) = (|| Q::ZERO, || Q::ONE, || -Q::ONE);
    let near = match viewport.depth_range() {
        DepthRange::ZeroToOne => [zero(), zero(), one(), zero()],
        DepthRange::MinusOneToOne => [zero(), zero(), one(), one()],
    };
    let far = [zero(), zero(), minus(), one()];
    // x/w W/2 + W/2 lies in +-32767, and likewise y, downwards.
    let half_w = fraction(i64::from(viewport.width()), 2);
    let half_h = fraction(i64::from(viewport.height()), 2);
    let guard = q(GUARD);
    let left = [half_w.clone(), zero(), zero(), &guard + &half_w];
    let right = [-&half_w, zero(), zero(), &guard - &half_w];
    let bottom = [zero(), half_h.clone(), zero(), &guard - &half_h];
    let top = [zero(), -&half_h, zero(), &guard + &half_h];
    vec![near, far, left, right, bottom, top]
}

/// The part of the polygon on the inner side of all `planes`, their surface included.
pub(crate) fn clip(poly: &Poly, planes: &[[Q; 4]]) -> Vec<Corner> {
    let n = poly.positions.len();
    let unit = |i: usize| (0..n).map(|j| if i == j { Q::ONE } else { Q::ZERO }).collect();
    let corner = |i: usize| Corner {
        position: poly.positions[i].map(q),
        weights: unit(i),
        framebuffer_weights: unit(i),
        by_infinity: false,
    };
    let all = (0..n).map(corner).collect();
    planes.iter().fold(all, |corners: Vec<Corner>, plane| cut(&corners, plane))
}

fn cut(corners: &[Corner], plane: &[Q; 4]) -> Vec<Corner> {
    let distance = |c: &Corner| sum((0..4).map(|i| &plane[i] * &c.position[i]));
    let mut kept = Vec::new();
    for (i, from) in corners.iter().enumerate() {
        let to = &corners[(i + 1) % corners.len()];
        let (d0, d1) = (distance(from), distance(to));
        if d0 >= Q::ZERO {
            kept.push(from.clone());
        }
        if (d0 < Q::ZERO && d1 > Q::ZERO) || (d0 > Q::ZERO && d1 < Q::ZERO) {
            kept.push(between(from, to, &reduced(&d0 / (&d0 - &d1))));
        }
    }
    kept
}

/// The point at `t` of the way.
fn between(from: &Corner, to: &Corner, t: &Q) -> Corner {
    // The next plane goes on from here.
    let mix = |a: &Q, b: &Q, t: &Q| reduced(mix(a, b, t));
    let position = [0, 1, 2, 3].map(|i| mix(&from.position[i], &to.position[i], t));
    let (w0, w1) = (&from.position[3], &to.position[3]);
    let seen = *w0 > Q::ZERO && *w1 > Q::ZERO;
    // In the framebuffer, the point w0 (1 - t) : w1 t.
    let s = if seen { reduced(t * w1 / mix(w0, w1, t)) } else { t.clone() };
    let all = |a: &[Q], b: &[Q], t: &Q| a.iter().zip(b).map(|(a, b)| mix(a, b, t)).collect();
    Corner {
        position,
        weights: all(&from.weights, &to.weights, t),
        framebuffer_weights: all(&from.framebuffer_weights, &to.framebuffer_weights, &s),
        by_infinity: from.by_infinity || to.by_infinity || *w0 == Q::ZERO || *w1 == Q::ZERO,
    }
}

/// From `a` to `b`, at `t` of the way.
pub(crate) fn mix(a: &Q, b: &Q, t: &Q) -> Q {
    a + t * (b - a)
}

impl Corner {
    /// The corner's value of something that has the given values at the polygon's vertices.
    pub(crate) fn mean(&self, values: &[Q], in_framebuffer: bool) -> Q {
        let weights = if in_framebuffer { &self.framebuffer_weights } else { &self.weights };
        sum(weights.iter().zip(values).map(|(weight, value)| weight * value))
    }

    /// Where it lands in the framebuffer, exactly, in pixels; nowhere if w is 0.
    pub(crate) fn framebuffer(&self, viewport: Viewport) -> Option<[Q; 2]> {
        let [x, y, _, w] = &self.position;
        if *w == Q::ZERO {
            return None;
        }
        let (vx, vy) = (i64::from(viewport.rect().x0), i64::from(viewport.rect().y0));
        let (width, height) = (i64::from(viewport.width()), i64::from(viewport.height()));
        let (half_w, half_h) = (fraction(width, 2), fraction(height, 2));
        let column = x / w * &half_w + fraction(vx, 1) + &half_w;
        let row = fraction(vy, 1) + &half_h - y / w * &half_h;
        Some([column, row])
    }
}

/// Where the centre of a pixel lies with respect to an exact polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Inside, and farther from every edge than the tolerance.
    Inside,
    /// Outside, and farther from every edge than the tolerance.
    Outside,
    /// Too near to an edge to say.
    Near,
}

/// The side of the centre of pixel (`x`, `y`), by non-zero winding and the distance to the
/// nearest edge in pixels. The corners lie in the guard band, so that `f64` has 2^-37 pixel.
pub(crate) fn side(outline: &[[f64; 2]], x: i32, y: i32, tolerance: f64) -> Side {
    let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
    let mut winding = 0;
    for (i, a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let squared = dx * dx + dy * dy;
        let along = (px - a[0]) * dx + (py - a[1]) * dy;
        let t = if squared > 0.0 { (along / squared).clamp(0.0, 1.0) } else { 0.0 };
        let (ex, ey) = (a[0] + t * dx - px, a[1] + t * dy - py);
        if (ex * ex + ey * ey).sqrt() <= tolerance {
            return Side::Near;
        }
        let left = dx * (py - a[1]) - dy * (px - a[0]);
        if a[1] <= py && py < b[1] && left < 0.0 {
            winding += 1;
        } else if b[1] <= py && py < a[1] && left > 0.0 {
            winding -= 1;
        }
    }
    if winding == 0 { Side::Outside } else { Side::Inside }
}

/// The clipped polygon in the framebuffer, rounded to `f64`; empty if nothing is left.
pub(crate) fn outline(viewport: Viewport, corners: &[Corner]) -> Vec<[f64; 2]> {
    let place = |c: &Corner| c.framebuffer(viewport).map(|p| p.map(|v| approximate(&v)));
    corners.iter().filter_map(place).collect()
}
