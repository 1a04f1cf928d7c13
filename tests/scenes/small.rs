//! Many polygons of few pixels.

use std::f64::consts::TAU;

use super::{
    Corner, Look, Random, Scene, View, add, cross, direction, dot, in_proportion, scaled, sub,
    turn, unit,
};

/// A closed surface of some 200,000 triangles, of 4 pixels where they are seen.
pub(super) fn mesh(size: (u32, u32)) -> Scene {
    surface("mesh", size, 200_000)
}

/// The same in some 870,000 triangles, of one pixel.
pub(super) fn mesh_full(size: (u32, u32)) -> Scene {
    surface("mesh_full", size, 870_000)
}

/// A knotted tube with dents, coloured as if lit. Vertices are shared.
fn surface(name: &'static str, size: (u32, u32), triangles: usize) -> Scene {
    let eye = scaled(direction(15.0, -8.0), -2.3);
    let view =
        View { eye, target: [0.0; 3], fov_y_degrees: 40.0, far: 20.0, ..View::ahead(0.1, 20.0) };
    let mut scene = Scene::new(name, size, &view);
    // Eight times as many steps along the tube as round it.
    let around = ((in_proportion(size, triangles) as f64 / 16.0).sqrt() as usize).max(8);
    let along = 8 * around;
    let middle = |t: f64| {
        let ([cos_2, sin_2], [cos_3, sin_3]) = (turn(2.0 * t), turn(3.0 * t));
        scaled([(2.0 + cos_3) * cos_2, (2.0 + cos_3) * sin_2, sin_3], 0.22)
    };
    for i in 0..along {
        let t = TAU * i as f64 / along as f64;
        let place = middle(t);
        let forward = unit(sub(middle(t + 1e-3), middle(t - 1e-3)));
        let side = unit(cross(forward, [0.3, 0.2, 1.0]));
        let up = cross(side, forward);
        for j in 0..around {
            let s = TAU * j as f64 / around as f64;
            let [cos, sin] = turn(s);
            let outward = add(scaled(side, cos), scaled(up, sin));
            let dents = 1.0 + 0.08 * turn(5.0 * s + 40.0 * t)[1];
            let light = 0.15 + 0.85 * dot(outward, unit([0.4, 0.8, 0.6])).max(0.0);
            let attributes = outward.map(|n| (light * dents * (0.7 + 0.2 * n)) as f32);
            scene
                .corners
                .push(Corner { position: add(place, scaled(outward, 0.11 * dents)), attributes });
        }
    }
    for i in 0..along {
        for j in 0..around {
            let at = |i: usize, j: usize| (i % along) * around + j % around;
            scene.triangle([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            scene.triangle([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    scene
}

/// 100,000 triangles of 10 pixels, anywhere.
pub(super) fn soup(size: (u32, u32)) -> Scene {
    let view = View::ahead(0.5, 200.0);
    let mut scene = Scene::new("soup", size, &view);
    let mut random = Random(5);
    // Equilateral.
    let radius = (10.0 / (0.75 * 3.0_f64.sqrt())).sqrt();
    for _ in 0..in_proportion(size, 100_000) {
        let depth = random.between(2.0, 100.0);
        let x = random.between(6.0, f64::from(size.0) - 6.0);
        let y = random.between(6.0, f64::from(size.1) - 6.0);
        let angle = random.between(0.0, TAU);
        let corners = [0.0, 1.0, 2.0].map(|third: f64| {
            let [cos, sin] = turn(angle + third * TAU / 3.0);
            let depth = depth * random.between(0.97, 1.03);
            (view.at(size, [x + radius * cos, y + radius * sin], depth), random.colour())
        });
        scene.face(Look::Coloured, &corners);
    }
    scene
}

/// 60,000 triangles of a pixel's width, and 20 to 100 pixels long, that stand up and lean over.
pub(super) fn hairs(size: (u32, u32)) -> Scene {
    let view = View::ahead(0.5, 200.0);
    let mut scene = Scene::new("hairs", size, &view);
    let mut random = Random(9);
    for _ in 0..in_proportion(size, 60_000) {
        let depth = random.between(2.0, 100.0);
        let x = random.between(6.0, f64::from(size.0) - 6.0);
        let y = random.between(6.0, f64::from(size.1) - 6.0);
        let length = random.between(20.0, 100.0);
        let [up, aside] = turn(random.between(-0.8, 0.8));
        let tip = [x + length * aside, y - length * up];
        let place = |at: [f64; 2], depth: f64| view.at(size, at, depth);
        let corners = [
            (place([x - 0.75, y], depth), random.colour()),
            (place([x + 0.75, y], depth), random.colour()),
            (place(tip, depth * random.between(0.8, 1.25)), random.colour()),
        ];
        scene.face(Look::Coloured, &corners);
    }
    scene
}

/// 12,500 boxes of a few pixels, in rows, seen by a camera that does not roll: their upright edges are upright in
/// the picture. Two triangles for each of four sides.
pub(super) fn boxes(size: (u32, u32)) -> Scene {
    let view = View::turned([0.3, 14.0, 6.0], 5.0, -15.0);
    let mut scene = Scene::new("boxes", size, &view);
    let mut random = Random(10);
    let side = (in_proportion(size, 12_500) as f64).sqrt() as usize;
    for i in 0..side * side {
        let (column, row) = ((i % side) as f64, (i / side) as f64);
        let [x, z] = [column - side as f64 / 2.0, -row];
        let height = random.between(0.4, 3.0);
        // Round the box, then its lid.
        let around = [[0.0, 0.0], [0.7, 0.0], [0.7, -0.7], [0.0, -0.7]];
        let corner = |k: usize, y: f64| [x + around[k % 4][0], y, z + around[k % 4][1]];
        let sides = [0, 1, 3].map(|k| {
            [corner(k, 0.0), corner(k + 1, 0.0), corner(k + 1, height), corner(k, height)]
        });
        let lid = [0, 1, 2, 3].map(|k| corner(k, height));
        for side in sides.into_iter().chain([lid]) {
            let side = side.map(|place| (place, random.colour()));
            scene.face(Look::Coloured, &[side[0], side[1], side[2]]);
            scene.face(Look::Coloured, &[side[0], side[2], side[3]]);
        }
    }
    scene
}

/// 20,000 flat polygons of 3 to 12 vertices and 400 pixels.
pub(super) fn ngons(size: (u32, u32)) -> Scene {
    let view = View::ahead(0.5, 200.0);
    let mut scene = Scene::new("ngons", size, &view);
    let mut random = Random(7);
    let count = in_proportion(size, 20_000);
    while scene.faces.len() < count {
        let n = 3 + random.below(10);
        let [cos, sin] = turn(random.between(0.0, TAU));
        let flat = random.between(0.6, 1.0);
        let points: Vec<[f64; 2]> = (0..n)
            .map(|k| {
                let step = k as f64 + random.between(-0.3, 0.3);
                let [x, y] = turn(step * TAU / n as f64);
                [x * cos - flat * y * sin, x * sin + flat * y * cos]
            })
            .collect();
        let twice_area: f64 = (0..points.len())
            .map(|i| (points[i], points[(i + 1) % points.len()]))
            .map(|(p, q)| p[0] * q[1] - q[0] * p[1])
            .sum();
        let scale = (800.0 / twice_area).sqrt();
        let x = random.between(30.0, f64::from(size.0) - 30.0);
        let y = random.between(30.0, f64::from(size.1) - 30.0);
        let centre = view.at(size, [x, y], random.between(2.0, 100.0));
        let tilt = [0.0; 3].map(|_: f64| random.between(-0.6, 0.6));
        let normal = unit(sub(tilt, unit(centre)));
        let places: Vec<[f64; 3]> = points
            .iter()
            .map(|p| {
                let ray = view.at(size, [x + scale * p[0], y - scale * p[1]], 1.0);
                scaled(ray, dot(centre, normal) / dot(ray, normal))
            })
            .collect();
        if places.iter().any(|p| p[2] > -1.0) {
            continue;
        }
        // Colours that are affine on the plane.
        let across = unit(cross(normal, [0.3, 0.9, 0.1]));
        let axes = [across, cross(normal, across)];
        let radius = places.iter().map(|p| dot(sub(*p, centre), sub(*p, centre)).sqrt());
        let radius = radius.fold(0.0, f64::max);
        let slopes = [0.0; 6].map(|_: f64| random.between(-0.24, 0.24));
        let corners: Vec<_> = places
            .iter()
            .map(|place| {
                let [u, v] = axes.map(|axis| dot(sub(*place, centre), axis) / radius);
                let colour = [0, 2, 4].map(|k| (0.5 + slopes[k] * u + slopes[k + 1] * v) as f32);
                (*place, colour)
            })
            .collect();
        scene.face(Look::Coloured, &corners);
    }
    scene
}

/// 2000 triangles that cross the sides of the view volume, or reach behind the eye. As many in
/// a small picture.
pub(super) fn clip(size: (u32, u32)) -> Scene {
    let view = View::ahead(0.5, 60.0);
    let mut scene = Scene::new("clip", size, &view);
    let mut random = Random(8);
    let half_y = libm::tan(view.fov_y_degrees.to_radians() / 2.0);
    let half_x = half_y * f64::from(size.0) / f64::from(size.1);
    let outside = |[x, y, z]: [f64; 3]| {
        let w = -z;
        [x < -w * half_x, x > w * half_x, y < -w * half_y, y > w * half_y, w < 0.5, w > 60.0]
    };
    while scene.faces.len() < 2000 {
        let centre =
            [random.between(-40.0, 40.0), random.between(-25.0, 25.0), random.between(-70.0, 8.0)];
        let reach = random.between(2.0, 6.0);
        let places = [centre; 3].map(|c| c.map(|c| c + random.between(-reach, reach)));
        let codes = places.map(outside);
        let crosses = (0..6).any(|plane| codes.iter().any(|c| c[plane] != codes[0][plane]));
        let hidden = (0..6).any(|plane| codes.iter().all(|code| code[plane]));
        // Not nearly edge-on, and not through the eye.
        let normal = unit(cross(sub(places[1], places[0]), sub(places[2], places[0])));
        if !crosses || hidden || dot(normal, places[0]).abs() < 0.3 {
            continue;
        }
        scene.face(Look::Coloured, &places.map(|place| (place, random.colour())));
    }
    scene
}
