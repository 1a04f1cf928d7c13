//! Random scenes: thirteen kinds, each with its share.

use std::f64::consts::TAU;
use std::sync::Arc;

use hyperspan::depth::{Compare, DepthSource, DepthTest};
use hyperspan::error::Error;
use hyperspan::placed::Placed;
use hyperspan::simd::Simd;
use hyperspan::space::Viewport;
use hyperspan::tiler::Precision;

use super::super::stress::random::Random;
use super::scene::{Piece, Scene, Way};
use super::shapes::{
    CORNERS, Corner, STEPS, cells, corners, ellipse, grid, on_lattice, on_plane, plane_at,
    plane_through, round_some, set_piece, set_stage, unproject, varyings,
};

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
    Kind { name: "large", share: 24, make: large },
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

/// Pictures of up to 4096 x 4096 pixels.
fn large(random: &mut Random, scene: &mut Scene) -> Result<(), Error> {
    set_stage(random, scene, 4096.0)?;
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
