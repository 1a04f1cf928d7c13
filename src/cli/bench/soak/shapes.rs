//! What scenes are made of: viewports, polygons on a plane, grids.

use std::f64::consts::TAU;

use hyperspan::error::Error;
use hyperspan::space::{DepthRange, Grid, PixelRect, Viewport};

use super::super::stress::random::Random;
use super::scene::{MOST_ATTRIBUTES, Piece, Scene};

/// A viewport with sides of up to `most` pixels, and a target: the viewport's size and place, or
/// a part of it, or one that sticks out.
pub(super) fn set_stage(random: &mut Random, scene: &mut Scene, most: f64) -> Result<(), Error> {
    let place = [0, 1].map(|_| match random.below(4) {
        0 => random.within(-3000.0, 3000.0) as i32,
        1 => random.within(-2e6, 2e6) as i32,
        _ => 0,
    });
    let [width, height] = [0, 1].map(|_| match random.below(3) {
        0 => random.up_to(most) as u32,
        _ => random.within(most / 2.0, most) as u32 + 1,
    });
    let grid = if random.below(6) == 0 { Grid::Eight } else { Grid::Sixteen };
    let gl = random.below(4) == 0;
    let range = if gl { DepthRange::MinusOneToOne } else { DepthRange::ZeroToOne };
    let viewport = Viewport::new(place[0], place[1], width, height)?;
    scene.viewport = viewport.with_grid(grid).with_depth_range(range);
    let rect = viewport.rect();
    scene.window = rect;
    if random.below(3) == 0 {
        let sides = [width, height].map(f64::from);
        let from = sides.map(|side| random.within(-0.2, 0.8) * side);
        let size = sides.map(|side| (random.within(0.0, 1.2) * side) as u32);
        let [x, y] = from.map(|c| c as i32);
        scene.window = PixelRect::new(rect.x0 + x, rect.y0 + y, size[0], size[1]);
    }
    Ok(())
}

/// A corner of the triangle that carries a plane.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    /// Pixels from the viewport's corner.
    pub(super) at: [f64; 2],
    /// 0 to 1.
    pub(super) depth: f64,
    pub(super) w: f64,
}

/// The clip position that lands on `at`, in pixels from the viewport's corner.
pub(super) fn unproject(viewport: Viewport, Corner { at, depth, w }: Corner) -> [f64; 4] {
    let half = [viewport.width(), viewport.height()].map(|side| f64::from(side) / 2.0);
    let z = match viewport.depth_range() {
        DepthRange::ZeroToOne => (depth * w).clamp(0.0, w),
        DepthRange::MinusOneToOne => ((2.0 * depth - 1.0) * w).clamp(-w, w),
    };
    [(at[0] - half[0]) / half[0] * w, (half[1] - at[1]) / half[1] * w, z, w]
}

/// Three corners within `reach` times the viewport's sides round its middle; the greatest w is
/// `ratio` times the least.
pub(super) fn corners(
    random: &mut Random,
    viewport: Viewport,
    reach: f64,
    ratio: f64,
) -> [Corner; 3] {
    let side = [viewport.width(), viewport.height()].map(f64::from);
    let least = if random.below(3) == 0 { 1.0 / random.up_to(1e6) } else { 1.0 };
    let flat = random.below(8) == 0;
    let mut all = [0, 1, 2].map(|_| Corner {
        at: side.map(|side| (0.5 + random.within(-reach, reach)) * side),
        depth: random.unit(),
        w: least,
    });
    if !flat {
        all[1].w = least * random.up_to(ratio);
        all[2].w = least * ratio;
        all.rotate_left(random.below(3));
    }
    if random.below(10) == 0 {
        all.iter_mut().for_each(|corner| corner.depth = 0.5);
    }
    all
}

/// Attributes at three corners.
pub(super) fn varyings(random: &mut Random) -> Vec<[f64; 3]> {
    let list = |random: &mut Random| {
        let size = match random.below(6) {
            0 => 1000.0,
            1 => 1e-20,
            2 => 1e20,
            _ => 1.0,
        };
        let offset = if random.below(3) == 0 { 1.0 } else { 0.0 };
        if random.below(12) == 0 {
            return [size * random.unit(); 3];
        }
        [0, 1, 2].map(|_| size * (offset + random.within(-1.0, 1.0)))
    };
    (0..random.below(MOST_ATTRIBUTES + 1)).map(|_| list(random)).collect()
}

/// The polygon on the plane of `corners` whose vertices are their means with `weights`.
pub(super) fn on_plane(
    viewport: Viewport,
    corners: &[Corner; 3],
    weights: &[[f64; 3]],
    varyings: &[[f64; 3]],
) -> Piece {
    let mean = |weights: [f64; 3], values: [f64; 3]| {
        weights[0] * values[0] + weights[1] * values[1] + weights[2] * values[2]
    };
    let mut piece = Piece::bare(Vec::new());
    for &weights in weights {
        // 1/w and depth are linear in the framebuffer.
        let shares = [0, 1, 2].map(|k| weights[k] / corners[k].w);
        let inv_w = shares[0] + shares[1] + shares[2];
        let at = [0, 1].map(|i| mean(weights, corners.map(|corner| corner.at[i])));
        let depth = mean(weights, corners.map(|corner| corner.depth));
        piece.positions.push(unproject(viewport, Corner { at, depth, w: 1.0 / inv_w }));
        piece.attributes.extend(varyings.iter().map(|list| (mean(shares, *list) / inv_w) as f32));
    }
    piece.count = varyings.len();
    piece
}

pub(super) const CORNERS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Now and then positions are those of `f32`.
pub(super) fn round_some(random: &mut Random, piece: &mut Piece) {
    if random.below(3) == 0 {
        piece.positions.iter_mut().flatten().for_each(|c| *c = f64::from(*c as f32));
    }
}

/// Sets the scene's one polygon.
pub(super) fn set_piece(random: &mut Random, scene: &mut Scene, mut piece: Piece) {
    round_some(random, &mut piece);
    let by = random.below(piece.positions.len());
    piece.positions.rotate_left(by);
    piece.attributes.rotate_left(by * piece.count);
    if random.below(2) == 0 {
        let lists: Vec<f32> = piece.lists().into_iter().rev().flatten().collect();
        piece.attributes = lists;
        piece.positions.reverse();
    }
    scene.pieces = vec![piece];
}

/// 4 to 64 vertices, as weights of three corners.
pub(super) fn ellipse(random: &mut Random) -> Vec<[f64; 3]> {
    let count = 3 + random.up_to(61.0) as usize;
    let weights = |i: usize| {
        let angle = (i as f64 + 0.8 * random.unit()) / count as f64 * TAU;
        // Two directions at right angles among weights whose sum stays.
        let a = 0.4 * libm::cos(angle) / 2.0_f64.sqrt();
        let b = 0.4 * libm::sin(angle) / 6.0_f64.sqrt();
        [1.0 / 3.0 + a + b, 1.0 / 3.0 - a + b, 1.0 / 3.0 - 2.0 * b]
    };
    (0..count).map(weights).collect()
}

/// A place on a lattice: centres, sides and corners of pixels, or steps of a grid.
pub(super) fn on_lattice(random: &mut Random, step: f64, from: [f64; 2], reach: f64) -> [f64; 2] {
    from.map(|c| c.floor() + (random.within(-reach, reach) / step).floor() * step)
}

pub(super) const STEPS: [f64; 5] = [1.0, 0.5, 0.25, 1.0 / 256.0, 1.0 / 65536.0];

/// A plane through a point that is seen: `at`, and two axes, all in clip space.
pub(super) fn plane_through(random: &mut Random, viewport: Viewport) -> [[f64; 4]; 3] {
    let side = [viewport.width(), viewport.height()].map(f64::from);
    let at = side.map(|side| random.unit() * side);
    let w = 1.0 / random.up_to(1e4);
    let middle = unproject(viewport, Corner { at, depth: random.within(0.1, 0.9), w });
    let size = [0, 1].map(|_| w * random.up_to(1e5));
    let reversed = random.below(2) == 0;
    let axis = |size: f64, random: &mut Random| {
        let mut axis = [0, 1, 2, 3].map(|_| random.within(-1.0, 1.0) * size);
        // z is the same everywhere under a reversed depth without a far plane.
        axis[2] *= if reversed { 0.0 } else { 1.0 };
        axis
    };
    [middle, axis(size[0], random), axis(size[1], random)]
}

pub(super) fn plane_at([middle, right, down]: &[[f64; 4]; 3], [s, t]: [f64; 2]) -> [f64; 4] {
    [0, 1, 2, 3].map(|i| middle[i] + s * right[i] + t * down[i])
}

/// Points of a grid, every one but those of the rim shifted by up to `shift` of a cell.
pub(super) fn grid(random: &mut Random, [columns, rows]: [usize; 2], shift: f64) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    for row in 0..=rows {
        for column in 0..=columns {
            let mut inner = |at: usize, of: usize| {
                let by = random.within(-shift, shift);
                (at as f64 + if at > 0 && at < of { by } else { 0.0 }) / of as f64
            };
            points.push([inner(column, columns), inner(row, rows)]);
        }
    }
    points
}

/// The cells of a grid as triangles, in any order of vertices.
pub(super) fn cells(random: &mut Random, [columns, rows]: [usize; 2]) -> Vec<[usize; 3]> {
    let mut all = Vec::new();
    for cell in 0..columns * rows {
        let corner = cell / columns * (columns + 1) + cell % columns;
        let next = corner + columns + 1;
        let (a, b, c, d) = (corner, corner + 1, next + 1, next);
        let parts =
            if random.below(2) == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
        for mut part in parts {
            part.rotate_left(random.below(3));
            if random.below(2) == 0 {
                part.reverse();
            }
            all.push(part);
        }
    }
    all
}
