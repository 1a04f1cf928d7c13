//! Few polygons of many pixels.

use super::{Look, Random, Scene, View, add, cross, direction, dot, scaled, turn, unit};

/// A ground seen at a slant: 1/w is constant along rows.
pub(super) fn floor(size: (u32, u32)) -> Scene {
    ground("floor", size, 0.0)
}

/// The same with the head turned: 1/w is constant along nothing.
pub(super) fn floor_roll(size: (u32, u32)) -> Scene {
    ground("floor_roll", size, 20.0)
}

fn ground(name: &'static str, size: (u32, u32), roll: f64) -> Scene {
    let mut view = View::turned([0.37, 1.6, 60.0], 20.0, -8.0);
    if roll != 0.0 {
        let forward = direction(20.0, -8.0);
        let right = unit(cross(forward, view.up));
        let [cos, sin] = turn(f64::to_radians(roll));
        view.up = add(scaled(cross(right, forward), cos), scaled(right, sin));
    }
    let mut scene = Scene::new(name, size, &view);
    let texture = scene.texture(&mut Random(1), [190, 180, 170], [60, 70, 90]);
    scene.face(
        Look::Textured(texture),
        &[
            ([-100.0, 0.0, 100.0], [0.0_f32, 0.0]),
            ([100.0, 0.0, 100.0], [50.0, 0.0]),
            ([100.0, 0.0, -100.0], [50.0, 50.0]),
            ([-100.0, 0.0, -100.0], [0.0, 50.0]),
        ],
    );
    scene
}

/// From within a box: every pixel is covered once.
pub(super) fn room(size: (u32, u32)) -> Scene {
    let view = View {
        fov_y_degrees: 90.0,
        near: 0.05,
        far: 100.0,
        ..View::turned([-0.7, 1.5, 0.9], 33.0, 9.0)
    };
    let mut scene = Scene::new("room", size, &view);
    let (x, y, z) = (5.0, 4.0, 4.0);
    let sides = [
        [[-x, 0.0, z], [x, 0.0, z], [x, 0.0, -z], [-x, 0.0, -z]],
        [[-x, y, -z], [x, y, -z], [x, y, z], [-x, y, z]],
        [[-x, 0.0, -z], [x, 0.0, -z], [x, y, -z], [-x, y, -z]],
        [[x, 0.0, z], [-x, 0.0, z], [-x, y, z], [x, y, z]],
        [[-x, 0.0, z], [-x, 0.0, -z], [-x, y, -z], [-x, y, z]],
        [[x, 0.0, -z], [x, 0.0, z], [x, y, z], [x, y, -z]],
    ];
    let mut random = Random(2);
    for (i, [a, b, c, d]) in (0_u8..).zip(sides) {
        let texture = scene.texture(&mut random, [40 * i, 190, 80], [30, 20 * i, 90]);
        let corners = [(a, [0.0_f32, 0.0]), (b, [3.0, 0.0]), (c, [3.0, 2.0]), (d, [0.0, 2.0])];
        scene.face(Look::Textured(texture), &corners);
    }
    scene
}

/// 400 walls that stand about: 1/w is constant along columns, and many pixels are hidden.
pub(super) fn walls(size: (u32, u32)) -> Scene {
    let mut scene = Scene::new("walls", size, &View::turned([0.0, 1.6, 0.0], -25.0, 0.0));
    let mut random = Random(3);
    for i in 0..8 {
        scene.texture(&mut random, [20 * i, 120, 60], [60, 60, 20 * i]);
    }
    while scene.faces.len() < 400 {
        let [x, z] = [random.between(-50.0, 50.0), random.between(-50.0, 50.0)];
        let length = random.between(2.0, 8.0);
        let [dx, dz] = turn(random.between(0.0, std::f64::consts::TAU)).map(|c| c * length / 2.0);
        let height = random.between(2.0, 4.5);
        // Not through the eye.
        let nearest = (-(x * dx + z * dz) / (dx * dx + dz * dz)).clamp(-1.0, 1.0);
        let (ex, ez) = (x + nearest * dx, z + nearest * dz);
        if ex * ex + ez * ez < 1.5 * 1.5 {
            continue;
        }
        let texture = random.below(8) as usize;
        let (u, v) = ((length / 2.0) as f32, (height / 2.0) as f32);
        scene.face(
            Look::Textured(texture),
            &[
                ([x - dx, 0.0, z - dz], [0.0, 0.0]),
                ([x + dx, 0.0, z + dz], [u, 0.0]),
                ([x + dx, height, z + dz], [u, v]),
                ([x - dx, height, z - dz], [0.0, v]),
            ],
        );
    }
    scene.faces.sort_by_key(|face| match face.look {
        Look::Textured(texture) => texture,
        Look::Coloured => 0,
    });
    scene
}

/// 16 tilted planes over all of the picture, from the front to the back: 15 of 16 pixels are
/// hidden.
pub(super) fn layers_ftb(size: (u32, u32)) -> Scene {
    layers("layers_ftb", size, (0..16).collect())
}

/// The same from the back to the front: all pixels are drawn.
pub(super) fn layers_btf(size: (u32, u32)) -> Scene {
    layers("layers_btf", size, (0..16).rev().collect())
}

fn layers(name: &'static str, size: (u32, u32), order: Vec<u8>) -> Scene {
    let view = View::ahead(0.1, 200.0);
    let mut scene = Scene::new(name, size, &view);
    let mut random = Random(6);
    for i in 0..4 {
        scene.texture(&mut random, [60 * i, 110, 190 - 60 * i], [30 * i, 55, 90 - 30 * i]);
    }
    let normal = unit([0.25, 0.15, 1.0]);
    let across = unit(cross([0.0, 1.0, 0.0], normal));
    let down = cross(normal, across);
    let (width, height) = (f64::from(size.0), f64::from(size.1));
    let (left, right, top, bottom) = (-40.0, width + 40.0, -40.0, height + 40.0);
    for i in order {
        let distance = 4.0 + 2.0 * f64::from(i);
        let corners = [[left, bottom], [right, bottom], [right, top], [left, top]].map(|pixel| {
            let ray = view.at(size, pixel, 1.0);
            let place = scaled(ray, -distance * normal[2] / dot(normal, ray));
            let [u, v] = [across, down].map(|axis| dot(place, axis) / 2.0);
            (place, [(u + 0.17 * f64::from(i)) as f32, v as f32])
        });
        scene.face(Look::Textured(usize::from(i % 4)), &corners);
    }
    scene
}

/// A board seen without perspective: 1/w is constant all over.
pub(super) fn board(size: (u32, u32)) -> Scene {
    let view = View::turned([0.0, 0.0, 5.0], 20.0, -10.0);
    let mut scene = Scene::new("board", size, &view);
    scene.camera = view.flat_matrix(size, 2.0);
    let texture = scene.texture(&mut Random(12), [200, 160, 90], [70, 90, 60]);
    let corner = |x: f64, y: f64| ([x, y, -0.2 * x], [(4.0 * x) as f32, (4.0 * y) as f32]);
    let corners = [corner(-1.0, -0.8), corner(3.0, -0.8), corner(3.0, 0.9), corner(-1.0, 0.9)];
    scene.face(Look::Textured(texture), &corners);
    scene
}
