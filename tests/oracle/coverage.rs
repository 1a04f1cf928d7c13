//! P1: which pixels a polygon covers, by counting crossings in `i128`.

use hyperspan::space::{DepthRange, Grid, PixelRect, Viewport};

use super::Poly;

/// The guard band reaches this many pixels to each side of the viewport's upper left corner.
pub(crate) const GUARD: f64 = 32767.0;

/// Where a clip position with w > 0 lands in the framebuffer, in pixels: P1's formula, in `f64`
/// and in its order.
pub(crate) fn framebuffer(viewport: Viewport, [x, y, _, w]: [f64; 4]) -> [f64; 2] {
    let (vx, vy) = (f64::from(viewport.rect().x0), f64::from(viewport.rect().y0));
    let (half_w, half_h) = (f64::from(viewport.width()) / 2.0, f64::from(viewport.height()) / 2.0);
    [(x / w) * half_w + (vx + half_w), (vy + half_h) - (y / w) * half_h]
}

/// Positions of the subpixel grid in a pixel's side.
pub(crate) fn steps(grid: Grid) -> i64 {
    match grid {
        Grid::Sixteen => 65536,
        Grid::Eight => 256,
    }
}

/// The position on the subpixel grid, in its steps: round to nearest, ties to even.
pub(crate) fn snap(grid: Grid, position: [f64; 2]) -> [i64; 2] {
    position.map(|c| (c * steps(grid) as f64).round_ties_even() as i64)
}

/// Can no plane cut the polygon? All of it lies in front of the eye, in the range of depth and
/// in the guard band.
pub(crate) fn is_unclipped(viewport: Viewport, poly: &Poly) -> bool {
    let corner = [f64::from(viewport.rect().x0), f64::from(viewport.rect().y0)];
    poly.positions.iter().all(|&p| {
        let [x, y] = framebuffer(viewport, p);
        let near = match viewport.depth_range() {
            DepthRange::ZeroToOne => 0.0,
            DepthRange::MinusOneToOne => -p[3],
        };
        let in_guard = (x - corner[0]).abs() < GUARD && (y - corner[1]).abs() < GUARD;
        p[3] > 0.0 && near <= p[2] && p[2] <= p[3] && in_guard
    })
}

/// The polygon's snapped vertices. It must be unclipped.
pub(crate) fn snapped(viewport: Viewport, poly: &Poly) -> Vec<[i64; 2]> {
    let place = |&p: &[f64; 4]| snap(viewport.grid(), framebuffer(viewport, p));
    poly.positions.iter().map(place).collect()
}

/// How often the closed polygon winds round the centre of pixel (`x`, `y`), half-open: an edge
/// owns a row if its upper end is at or above the row's centre, and its lower end below it; and
/// a crossing counts if it is at the centre or to the left of it.
pub(crate) fn winding(grid: Grid, points: &[[i64; 2]], x: i32, y: i32) -> i32 {
    let centre = |c: i32| i128::from(c) * i128::from(steps(grid)) + i128::from(steps(grid) / 2);
    let (xc, yc) = (centre(x), centre(y));
    let mut sum = 0;
    for (i, from) in points.iter().enumerate() {
        let to = points[(i + 1) % points.len()];
        let (from, to) = (from.map(i128::from), to.map(i128::from));
        let (top, bottom, direction) =
            if from[1] <= to[1] { (from, to, 1) } else { (to, from, -1) };
        if top[1] <= yc && yc < bottom[1] {
            // top.x + (yc - top.y) (bottom.x - top.x) / (bottom.y - top.y) <= xc
            let run = (yc - top[1]) * (bottom[0] - top[0]);
            if run <= (xc - top[0]) * (bottom[1] - top[1]) {
                sum += direction;
            }
        }
    }
    sum
}

/// Twice the snapped polygon's area in steps of the grid; positive if it runs counter-clockwise
/// with y up, as the clip positions do for a front face.
pub(crate) fn doubled_area(points: &[[i64; 2]]) -> i128 {
    let next = |i: usize| points[(i + 1) % points.len()].map(i128::from);
    let cross = |i: usize, a: [i128; 2]| a[1] * next(i)[0] - a[0] * next(i)[1];
    points.iter().enumerate().map(|(i, p)| cross(i, p.map(i128::from))).sum()
}

/// The pixels of `rect` that the snapped polygon covers, row by row.
pub(crate) fn covered(grid: Grid, points: &[[i64; 2]], rect: PixelRect) -> Vec<(i32, i32)> {
    let mut pixels = Vec::new();
    for y in rect.y0..rect.y1 {
        pixels.extend(
            (rect.x0..rect.x1).filter(|&x| winding(grid, points, x, y) != 0).map(|x| (x, y)),
        );
    }
    pixels
}
