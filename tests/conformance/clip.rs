//! Clipping: dEQP's functional.clipping (triangles near the edge of each plane and across it, huge
//! ones, none of whose vertices is seen), Vulkan's clipping.user_defined.complementarity, piglit's
//! triangle-guardband-viewport.

use std::collections::BTreeMap;

use hyperspan::space::{PixelRect, Viewport};

use crate::case::{Case, Rule, check};
use crate::oracle::Poly;
use crate::oracle::probe::{self, View};
use crate::oracle::shapes::unproject;

const SIZE: [u32; 2] = [64, 64];

/// The planes of the view volume: which coordinate, and its sign; z from 0 is the near one.
const PLANES: [(&str, usize, f64); 6] = [
    ("left", 0, -1.0),
    ("right", 0, 1.0),
    ("bottom", 1, -1.0),
    ("top", 1, 1.0),
    ("near", 2, -1.0),
    ("far", 2, 1.0),
];

/// Middle of the picture and of the range of depth: w = 1.
const MIDDLE: [f64; 4] = [0.0, 0.0, 0.5, 1.0];

/// A point at `t` of the way from the middle to the plane, `aside` along the other axes.
fn towards((_, axis, sign): (&str, usize, f64), t: f64, aside: [f64; 2]) -> [f64; 4] {
    let mut point = MIDDLE;
    let reach = if axis == 2 { 0.5 } else { 1.0 };
    point[axis] += sign * t * reach;
    let others = [(axis + 1) % 3, (axis + 2) % 3];
    for (other, by) in others.into_iter().zip(aside) {
        point[other] += by * if other == 2 { 0.4 } else { 0.9 };
    }
    point
}

/// A triangle with vertices so far on the way to a plane.
fn triangle(plane: (&str, usize, f64), t: [f64; 3]) -> Poly {
    let asides = [[-0.8, -0.6], [0.7, -0.5], [0.1, 0.8]];
    let place = |i: usize| towards(plane, t[i], asides[i]);
    let values = [[0.0_f32, 1.0], [1.0, 0.5], [0.25, -1.0]];
    Poly {
        positions: (0..3).map(place).collect(),
        attributes: values.iter().map(|list| list.to_vec()).collect(),
    }
}

/// The same seen from w instead of 1.
fn from(poly: &Poly, w: [f64; 3]) -> Poly {
    let scaled = |(p, w): (&[f64; 4], f64)| p.map(|c| c * w);
    Poly { positions: poly.positions.iter().zip(w).map(scaled).collect(), ..poly.clone() }
}

const HAIR: f64 = 1.0 / 1_048_576.0;

#[test]
fn conformance_clip_near_the_edge_of_each_plane() {
    let mut cases = Vec::new();
    for plane in PLANES {
        // All on the plane, a hair before it, a hair beyond it.
        for (name, t, nothing) in [
            ("inside", [0.2, 0.5, 0.9], false),
            ("touching", [0.2, 0.5, 1.0], false),
            ("a hair inside", [1.0 - HAIR, 0.3, 1.0 - HAIR], false),
            ("a hair outside", [1.0 + HAIR, 0.3, 1.0 + HAIR], false),
            ("one vertex outside", [0.2, 0.5, 1.5], false),
            ("two vertices outside", [0.2, 1.5, 1.7], false),
            ("all outside", [1.1, 1.5, 1.7], true),
            ("all a hair outside", [1.0 + HAIR, 1.0 + HAIR, 1.5], true),
        ] {
            for w in [[1.0; 3], [0.2, 1.0, 4.0]] {
                let poly = from(&triangle(plane, t), w);
                // z in 0..1, times two less one.
                for gl in [false, true] {
                    let mut poly = poly.clone();
                    if gl {
                        poly.positions.iter_mut().for_each(|p| p[2] = 2.0 * p[2] - p[3]);
                    }
                    let rule = if nothing { Rule::Nothing } else { Rule::Each };
                    let name = format!("{} plane, {name}, {w:?}, {gl}", plane.0);
                    cases.push(Case { gl, ..Case::new(name, SIZE, vec![poly], rule) });
                }
            }
        }
    }
    check(&cases);
}

/// Vertices far beyond every plane at once, none of them seen.
#[test]
fn conformance_clip_huge_triangles() {
    let mut cases = Vec::new();
    for size in [10.0, 1e3, 1e5, 1e7] {
        for turn in 0..6 {
            let corner = |k: u32| {
                let angle = f64::from(k) * std::f64::consts::TAU / 3.0 + f64::from(turn);
                [size * angle.cos(), size * angle.sin(), 0.5, 1.0]
            };
            let poly = Poly::bare(&[corner(0), corner(1), corner(2)]);
            let name = format!("{size:e} times the picture, turned by {turn}");
            cases.push(Case::new(name, SIZE, vec![poly], Rule::Everywhere));
            // Through near and far as well: a stripe is left.
            let mut tilted = [corner(0), corner(1), corner(2)];
            tilted[0][2] = 0.5 + size;
            tilted[1][2] = 0.5 - size;
            let name = format!("{size:e} times, turned by {turn}, through all six planes");
            cases.push(Case::new(name, SIZE, vec![Poly::bare(&tilted)], Rule::Each));
        }
        // Two triangles that share a diagonal through the middle.
        let [a, b, c, d] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| [size * x, size * y, 0.5, 1.0]);
        let parts = vec![Poly::bare(&[a, b, c]), Poly::bare(&[a, c, d]).reversed()];
        cases.push(Case::new(format!("quad of {size:e}"), SIZE, parts, Rule::Everywhere));
    }
    check(&cases);
}

/// Each vertex is outside of another plane, and the middle of the triangle is seen.
#[test]
fn conformance_clip_of_vertices_outside_of_different_planes() {
    let mut cases = Vec::new();
    let beyond = |plane, by: f64| towards(plane, 1.0 + by, [0.0, 0.0]);
    for (i, a) in PLANES.into_iter().enumerate() {
        for (j, b) in PLANES.into_iter().enumerate().skip(i + 1) {
            for (k, c) in PLANES.into_iter().enumerate().skip(j + 1) {
                if i / 2 == j / 2 || j / 2 == k / 2 {
                    continue;
                }
                // One of each pair of planes: the middle third lies before all of them.
                let poly = Poly::bare(&[beyond(a, 0.4), beyond(b, 0.7), beyond(c, 1.2)]);
                let name = format!("{}, {}, {}", a.0, b.0, c.0);
                cases.push(Case::new(name, SIZE, vec![poly], Rule::Each));
            }
        }
    }
    assert_eq!(cases.len(), 8);
    check(&cases);
}

/// What a plane of the user's and its negative leave covers each pixel exactly once: also of 1 to 8
/// planes in all combinations of signs.
#[test]
fn conformance_clip_planes_are_complementary() {
    let viewport = Viewport::new(0, 0, SIZE[0], SIZE[1]).expect("small");
    let cover =
        Poly::bare(&[[-1.0, -1.0], [3.0, -1.0], [-1.0, 3.0]].map(|[x, y]| [x, y, 0.5, 1.0]));
    let tilted = Poly::bare(&[
        [-0.8, -0.9, 0.1, 1.0],
        [0.7, -0.6, 0.2, 1.1],
        [2.9, 2.8, 2.8, 4.0],
        [-0.1, 0.19, 0.1, 0.2],
    ]);
    let view = View::whole(viewport);
    for poly in [cover, tilted] {
        let whole = probe::coverage(&view, &poly);
        assert!(whole.len() > 500);
        for count in 1..=8_u32 {
            let plane = |k: u32| {
                let (s, c) = (f64::from(k) * 0.9 + 0.3).sin_cos();
                [c, s, 0.0, 0.1 * f64::from(k) - 0.35]
            };
            let mut counts = BTreeMap::new();
            let mut parts = 0;
            for signs in 0..1_u32 << count {
                let side = |k| plane(k).map(|c| if signs >> k & 1 == 1 { -c } else { c });
                let sides: Vec<[f64; 4]> = (0..count).map(side).collect();
                let mut tiler = view.tiler();
                tiler.set_clip_planes(&sides);
                let part = probe::draw_with(&mut tiler, &view, &poly).1;
                parts += u32::from(!part.is_empty());
                part.into_keys().for_each(|at| *counts.entry(at).or_insert(0) += 1);
            }
            assert!(parts > count, "{parts} parts by {count} planes");
            assert!(counts.values().all(|times| *times == 1), "{count} planes: drawn twice");
            let seen: Vec<_> = counts.into_keys().map(|(y, x)| (x, y)).collect();
            assert_eq!(seen, whole, "{count} planes");
        }
    }
}

/// The viewport is far larger than what is drawn of it: piglit's guard band.
#[test]
fn conformance_clip_guard_band_beyond_the_viewport() {
    let mut cases = Vec::new();
    for side in [4096, 16384] {
        let viewport = Viewport::new(0, 0, side, side).expect("16384 at most");
        let last = f64::from(side);
        let place = |at: [f64; 2]| unproject(viewport, at, 0.5, 1.0);
        for (name, points) in [
            ("as large as the viewport", [[0.0, 0.0], [last, 0.0], [0.0, last]]),
            ("as large as the guard band", [[-32e3, -31e3], [32e3, -30e3], [1e3, 32e3]]),
            ("beyond the guard band", [[-5e4, -3e4], [6e4, 100.0], [50.0, 9e4]]),
        ] {
            for (x, y) in [(0, 0), (side - 60, 0), (0, side - 60), (side / 2 - 30, side / 2 - 30)] {
                let poly = Poly::bare(&points.map(place));
                let name = format!("{name}, {side}, from {x}, {y}");
                let [x, y] = [x, y].map(u32::cast_signed);
                let crop = PixelRect::new(x, y, 60, 60);
                let mut case = Case::new(name, [side; 2], vec![poly], Rule::Each);
                case.crop = crop;
                // At the far corners there may be nothing of it.
                if case.is_empty() {
                    case.rule = Rule::Nothing;
                }
                cases.push(case);
            }
        }
    }
    check(&cases);
}
