//! Random scenes: thirteen kinds, each with its share.

use std::f64::consts::TAU;
use std::sync::Arc;

use hyperspan::depth::{Compare, DepthSource, DepthTest};
use hyperspan::error::Error;
use hyperspan::placed::Placed;
use hyperspan::simd::Simd;
use hyperspan::space::{DepthRange, Grid, PixelRect, Viewport};
use hyperspan::tiler::Precision;

use super::super::stress::random::Random;
use super::scene::{MOST_ATTRIBUTES, Piece, Scene, Way};

/// Scenes of one kind.
#[derive(Clone, Copy, Debug)]
struct Kind {
    name: &'static str,
    /// Of all scenes.
    share: usize,
    make: fn(&mut Random, &mut Scene) -> Result<(), Error>,
}

const KINDS: [Kind; 13] = [
    Kind { name: "triangle", share: 4, make: triangle },
    Kind { name: "small triangle", share: 6, make: small },
    Kind { name: "N-gon", share: 4, make: inscribed },
    Kind { name: "sliver", share: 3, make: sliver },
    Kind { name: "lattice", share: 4, make: lattice },
    Kind { name: "outline", share: 2, make: outline },
    Kind { name: "large", share: 3, make: large },
    Kind { name: "giant", share: 2, make: giant },
    Kind { name: "near and far", share: 3, make: through },
    Kind { name: "mesh", share: 2, make: mesh },
    Kind { name: "fan", share: 3, make: fan },
    Kind { name: "clipped net", share: 2, make: net },
    Kind { name: "depth", share: 2, make: stack },
];

/// The names of all kinds.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    KINDS.iter().map(|kind| kind.name)
}

/// Scene `number` of those that belong to `seed`.
pub(crate) fn scene(seed: u64, number: u64) -> Result<Scene, Error> {
    let mut random = Random::new((seed << 40) ^ number);
    let shares = KINDS.iter().map(|kind| kind.share).sum();
    let mut left = random.below(shares);
    let mut kinds = KINDS.iter();
    let kind = loop {
        match kinds.next() {
            Some(kind) if left < kind.share => break kind,
            Some(kind) => left -= kind.share,
            None => break &KINDS[0],
        }
    };
    let levels: Vec<_> = Simd::all().collect();
    let viewport = Viewport::new(0, 0, 1, 1)?;
    let mut scene = Scene {
        kind: kind.name,
        viewport,
        window: viewport.rect(),
        pieces: Vec::new(),
        precision: if random.below(2) == 0 { Precision::Fast } else { Precision::Exact },
        simd: levels[random.below(levels.len())],
        way: [Way::OneByOne, Way::List, Way::Threads][random.below(3)],
        values: false,
        depth: None,
        outline: None,
    };
    (kind.make)(&mut random, &mut scene)?;
    Ok(scene)
}

/// A viewport with sides of up to `most` pixels, and a target: the viewport's size and place, or
/// a part of it, or one that sticks out.
fn set_stage(random: &mut Random, scene: &mut Scene, most: f64) -> Result<(), Error> {
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
struct Corner {
    /// Pixels from the viewport's corner.
    at: [f64; 2],
    /// 0 to 1.
    depth: f64,
    w: f64,
}

/// The clip position that lands on `at`, in pixels from the viewport's corner.
fn unproject(viewport: Viewport, Corner { at, depth, w }: Corner) -> [f64; 4] {
    let half = [viewport.width(), viewport.height()].map(|side| f64::from(side) / 2.0);
    let z = match viewport.depth_range() {
        DepthRange::ZeroToOne => (depth * w).clamp(0.0, w),
        DepthRange::MinusOneToOne => ((2.0 * depth - 1.0) * w).clamp(-w, w),
    };
    [(at[0] - half[0]) / half[0] * w, (half[1] - at[1]) / half[1] * w, z, w]
}

/// Three corners within `reach` times the viewport's sides round its middle; the greatest w is
/// `ratio` times the least.
fn corners(random: &mut Random, viewport: Viewport, reach: f64, ratio: f64) -> [Corner; 3] {
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
fn varyings(random: &mut Random) -> Vec<[f64; 3]> {
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
fn on_plane(
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

const CORNERS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Now and then positions are those of `f32`.
fn round_some(random: &mut Random, piece: &mut Piece) {
    if random.below(3) == 0 {
        piece.positions.iter_mut().flatten().for_each(|c| *c = f64::from(*c as f32));
    }
}

/// Sets the scene's one polygon.
fn set_piece(random: &mut Random, scene: &mut Scene, mut piece: Piece) {
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

fn triangle(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 400.0)?;
    let ratio = random.up_to(1e9);
    let corners = corners(random, scene.viewport, 0.6, ratio);
    let piece = on_plane(scene.viewport, &corners, &CORNERS, &varyings(random));
    set_piece(random, scene, piece);
    scene.values = true;
    Ok(())
}

/// Of a few pixels each, one beside or upon the other.
fn small(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 64.0)?;
    let size = random.within(0.5, 14.0);
    for _ in 0..40 {
        let ratio = random.up_to(1000.0);
        let mut corners = corners(random, scene.viewport, 0.6, ratio);
        let at = corners[0].at;
        for corner in &mut corners {
            corner.at = at.map(|c| c + random.within(-size, size) / 2.0);
        }
        let mut piece = on_plane(scene.viewport, &corners, &CORNERS, &varyings(random));
        round_some(random, &mut piece);
        scene.pieces.push(piece);
    }
    scene.values = true;
    Ok(())
}

/// A convex polygon within an ellipse.
fn inscribed(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 400.0)?;
    let ratio = random.up_to(1000.0);
    let corners = corners(random, scene.viewport, 0.8, ratio);
    let weights = ellipse(random);
    let mut varyings = varyings(random);
    // Rounding must not bend what has hardly a range beside its magnitude.
    let piece = on_plane(scene.viewport, &corners, &weights, &varyings);
    let lists = piece.lists();
    let is_affine = |k: usize| {
        let values = || lists.iter().map(|list| list[k]);
        let ends = [values().fold(f32::MAX, f32::min), values().fold(f32::MIN, f32::max)];
        ends[0] == ends[1] || ends[1] - ends[0] > ends[0].abs().max(ends[1].abs()) / 1024.0
    };
    let mut k = 0;
    varyings.retain(|_| {
        k += 1;
        is_affine(k - 1)
    });
    let piece = on_plane(scene.viewport, &corners, &weights, &varyings);
    set_piece(random, scene, piece);
    scene.values = true;
    Ok(())
}

/// 4 to 64 vertices, as weights of three corners.
fn ellipse(random: &mut Random) -> Vec<[f64; 3]> {
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

/// Thinner than a pixel, along a line through centres, or anywhere.
fn sliver(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 300.0)?;
    let ways = [[1, 0], [0, 1], [1, 1], [1, -1], [2, 1], [-1, 3], [3, -2], [4, 1]];
    let side = [scene.viewport.width(), scene.viewport.height()].map(f64::from);
    let thick = 1.0 / random.up_to(65536.0);
    let exact = random.below(2) == 0;
    for _ in 0..8 {
        let way = ways[random.below(ways.len())].map(f64::from);
        let mut at = side.map(|side| (random.unit() * side).floor() + 0.5);
        if !exact {
            at = at.map(|c| c + random.within(-0.5, 0.5));
        }
        let length = random.within(4.0, 100.0).floor();
        let aside = [-way[1], way[0]].map(|c| c * random.signed(thick));
        let ratio = random.up_to(1e4);
        let mut corners = corners(random, scene.viewport, 0.6, ratio);
        corners[0].at = at;
        corners[1].at = [0, 1].map(|i| at[i] + length * way[i]);
        let along = random.within(0.0, length).floor();
        corners[2].at = [0, 1].map(|i| at[i] + along * way[i] + aside[i]);
        let piece = on_plane(scene.viewport, &corners, &CORNERS, &varyings(random));
        scene.pieces.push(piece);
    }
    scene.values = true;
    Ok(())
}

/// A place on a lattice: centres, sides and corners of pixels, or steps of a grid.
fn on_lattice(random: &mut Random, step: f64, from: [f64; 2], reach: f64) -> [f64; 2] {
    from.map(|c| c.floor() + (random.within(-reach, reach) / step).floor() * step)
}

const STEPS: [f64; 5] = [1.0, 0.5, 0.25, 1.0 / 256.0, 1.0 / 65536.0];

/// Triangles with vertices on a lattice, w powers of two.
fn lattice(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 128.0)?;
    let side = [scene.viewport.width(), scene.viewport.height()].map(f64::from);
    let (step, reach) = (STEPS[random.below(STEPS.len())], random.up_to(100.0) + 2.0);
    let shift = if random.below(2) == 0 { 0.5 } else { 0.0 };
    for _ in 0..20 {
        let from = side.map(|side| random.unit() * side);
        let corners = [0, 1, 2].map(|_| Corner {
            at: on_lattice(random, step, from, reach).map(|c| c + shift),
            depth: random.below(9) as f64 / 8.0,
            w: (1_u32 << random.below(12)).into(),
        });
        let piece = on_plane(scene.viewport, &corners, &CORNERS, &varyings(random));
        scene.pieces.push(piece);
    }
    scene.values = random.below(2) == 0;
    Ok(())
}

/// Any closed outline of 3 to 14 vertices: it may cross itself.
fn outline(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 256.0)?;
    let side = [scene.viewport.width(), scene.viewport.height()].map(f64::from);
    let (step, reach) = (STEPS[random.below(STEPS.len())], random.up_to(16_000.0));
    for _ in 0..6 {
        let from = side.map(|side| random.unit() * side);
        let count = 3 + random.below(12);
        let place = |_| {
            let at = on_lattice(random, step, from, reach);
            unproject(scene.viewport, Corner { at, depth: 0.5, w: 1.0 })
        };
        scene.pieces.push(Piece::bare((0..count).map(place).collect()));
    }
    Ok(())
}

/// Pictures of up to 2048 x 2048 pixels.
fn large(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 2048.0)?;
    let corners = corners(random, scene.viewport, 1.2, 4.0);
    let weights = if random.below(2) == 0 { CORNERS.to_vec() } else { ellipse(random) };
    let piece = on_plane(scene.viewport, &corners, &weights, &[]);
    set_piece(random, scene, piece);
    Ok(())
}

/// A triangle all round the viewport, most of them out of the guard band.
fn giant(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 400.0)?;
    let side = [scene.viewport.width(), scene.viewport.height()].map(f64::from);
    let reach = random.up_to(1e5) * side[0].max(side[1]);
    let (turn, ratio) = (random.unit(), random.up_to(100.0));
    let mut corners = corners(random, scene.viewport, 0.5, ratio);
    for (corner, third) in corners.iter_mut().zip([0.0, 1.0, 2.0]) {
        let angle = (turn + (third + random.within(-0.3, 0.3)) / 3.0) * TAU;
        let reach = reach * random.within(0.3, 1.0);
        let way = [libm::cos(angle), libm::sin(angle)];
        corner.at = [0, 1].map(|i| side[i] / 2.0 + reach * way[i]);
    }
    let piece = on_plane(scene.viewport, &corners, &CORNERS, &varyings(random));
    scene.pieces = vec![piece];
    scene.values = true;
    Ok(())
}

/// A plane through a point that is seen: `at`, and two axes, all in clip space.
fn plane_through(random: &mut Random, viewport: Viewport) -> [[f64; 4]; 3] {
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

fn plane_at([middle, right, down]: &[[f64; 4]; 3], [s, t]: [f64; 2]) -> [f64; 4] {
    [0, 1, 2, 3].map(|i| middle[i] + s * right[i] + t * down[i])
}

/// A triangle or a quadrilateral that reaches behind the eye, before the near plane, beyond the
/// far one.
fn through(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 300.0)?;
    let plane = plane_through(random, scene.viewport);
    let slopes: Vec<[f64; 3]> = varyings(random);
    let mut places = vec![[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    if random.below(2) == 0 {
        places = vec![[-2.0, -1.0], [2.0, -1.0], [random.within(-2.0, 2.0), 2.0]];
    }
    let positions = places.iter().map(|place| plane_at(&plane, *place)).collect();
    let value = |[s, t]: &[f64; 2], [a, b, c]: &[f64; 3]| (a + b * s + c * t) as f32;
    let lists = places.iter().flat_map(|place| slopes.iter().map(move |list| value(place, list)));
    let attributes = lists.collect();
    scene.pieces = vec![Piece { positions, attributes, count: slopes.len(), placed: None }];
    scene.values = true;
    Ok(())
}

/// Points of a grid, every one but those of the rim shifted by up to `shift` of a cell.
fn grid(random: &mut Random, [columns, rows]: [usize; 2], shift: f64) -> Vec<[f64; 2]> {
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
fn cells(random: &mut Random, [columns, rows]: [usize; 2]) -> Vec<[usize; 3]> {
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

/// Triangles that share their vertices and cover the whole viewport.
fn mesh(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 256.0)?;
    let side = [scene.viewport.width(), scene.viewport.height()].map(f64::from);
    let cell = random.within(0.6, 20.0);
    let shape = side.map(|side| ((side / cell) as usize).clamp(1, 120));
    let ratio = random.up_to(100.0);
    // Little enough to leave every cell convex.
    let points = grid(random, shape, 0.2);
    let place = |p: &[f64; 2]| {
        // A pixel beyond the viewport on all sides.
        let at = [0, 1].map(|i| p[i] * (side[i] + 2.0) - 1.0);
        let w = random.up_to(ratio);
        unproject(scene.viewport, Corner { at, depth: random.unit(), w })
    };
    let positions: Vec<[f64; 4]> = points.iter().map(place).collect();
    let count = random.below(4);
    let values: Vec<f32> =
        (0..positions.len() * count).map(|_| random.within(-1.0, 1.0) as f32).collect();
    let placed = (random.below(2) == 0).then(|| {
        let mut placed = Placed::new(scene.viewport);
        placed.set(&positions, scene.simd.1);
        Arc::new(placed)
    });
    for face in cells(random, shape) {
        scene.pieces.push(Piece {
            positions: face.iter().map(|i| positions[*i]).collect(),
            attributes: face.iter().flat_map(|i| &values[i * count..][..count]).copied().collect(),
            count,
            placed: placed.clone().map(|placed| (placed, face.to_vec())),
        });
    }
    let [w, h] = side;
    let rim = [[-1.0, -1.0], [w + 1.0, -1.0], [w + 1.0, h + 1.0], [-1.0, h + 1.0]];
    let corner = |at| unproject(scene.viewport, Corner { at, depth: 0.5, w: 1.0 });
    scene.outline = Some(Piece::bare(rim.map(corner).to_vec()));
    scene.values = true;
    Ok(())
}

/// Triangles from a point of a convex polygon to its sides.
fn fan(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 512.0)?;
    let ratio = random.up_to(16.0);
    let corners = corners(random, scene.viewport, 0.8, ratio);
    let weights = ellipse(random);
    let rim = on_plane(scene.viewport, &corners, &weights, &[]);
    let hub = on_plane(scene.viewport, &corners, &[[1.0 / 3.0; 3]], &[]).positions[0];
    let n = rim.positions.len();
    for i in 0..n {
        let mut part = vec![hub, rim.positions[i], rim.positions[(i + 1) % n]];
        part.rotate_left(random.below(3));
        if random.below(2) == 0 {
            part.reverse();
        }
        scene.pieces.push(Piece::bare(part));
    }
    Ok(())
}

/// Triangles of a plane that planes cut.
fn net(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 64.0)?;
    let plane = plane_through(random, scene.viewport);
    let shape = [1 + random.below(4), 1 + random.below(4)];
    let points = grid(random, shape, 0.2);
    let place = |p: &[f64; 2]| plane_at(&plane, p.map(|c| 2.0 * c - 1.0));
    let positions: Vec<[f64; 4]> = points.iter().map(place).collect();
    for face in cells(random, shape) {
        scene.pieces.push(Piece::bare(face.iter().map(|i| positions[*i]).collect()));
    }
    let rim = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    scene.outline = Some(Piece::bare(rim.iter().map(place).collect()));
    Ok(())
}

/// A few polygons one behind the other, or through each other, and a depth test.
fn stack(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    const COMPARES: [Compare; 8] = [
        Compare::Never,
        Compare::Less,
        Compare::Equal,
        Compare::LessEqual,
        Compare::Greater,
        Compare::NotEqual,
        Compare::GreaterEqual,
        Compare::Always,
    ];
    set_stage(random, scene, 200.0)?;
    for _ in 0..2 + random.below(6) {
        // The same one again is as near.
        if let Some(again) = scene.pieces.last().filter(|_| random.below(4) == 0).cloned() {
            scene.pieces.push(again);
            continue;
        }
        let ratio = random.up_to(100.0);
        let corners = corners(random, scene.viewport, 0.7, ratio);
        let weights = if random.below(2) == 0 { CORNERS.to_vec() } else { ellipse(random) };
        scene.pieces.push(on_plane(scene.viewport, &corners, &weights, &[]));
    }
    let compare = COMPARES[random.below(COMPARES.len())];
    let source = if random.below(3) == 0 { DepthSource::InvW } else { DepthSource::Z };
    let test = DepthTest { compare, write: random.below(5) > 0, source };
    scene.depth = Some((test, random.below(2) == 0));
    scene.values = true;
    Ok(())
}
