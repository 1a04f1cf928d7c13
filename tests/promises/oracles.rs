//! The oracles against each other, and against cases done by hand.

use crate::oracle::clipper::{self, Side};
use crate::oracle::coverage::{self, is_unclipped, snapped, winding};
use crate::oracle::exact::{Q, fraction, power_of_two, q, round_to_f32};
use crate::oracle::plane::{Plane, Right};
use crate::oracle::shapes::{Tally, check, scenes};
use crate::oracle::{Poly, exact};
use hyperspan::space::{DepthRange, Grid, Viewport};
use hyperspan::varying::Interpolation;
use proptest::prelude::*;

fn viewport(width: u32, height: u32) -> Viewport {
    Viewport::new(0, 0, width, height).expect("sides up to 16384")
}

#[test]
fn oracle_rounds_as_f64_does_to_f32() {
    let special = [
        0.0,
        1.0,
        -1.0,
        1e-45,
        -7e-46,
        7.1e-46,
        1e-50,
        3.4e38,
        3.402_823_5e38,
        3.402_823_6e38,
        1e39,
        -1e300,
        5e-324,
        1.175_494_2e-38,
        1.0 + 2.0_f64.powi(-24),
        1.0 + 3.0 * 2.0_f64.powi(-24),
        2.0 - 2.0_f64.powi(-24),
        2.0_f64.powi(-150),
        3.0 * 2.0_f64.powi(-150),
    ];
    for value in special {
        assert_eq!(round_to_f32(&q(value)).to_bits(), (value as f32).to_bits(), "{value:e}");
    }
    assert_eq!(round_to_f32(&q(-0.0)).to_bits(), 0);
    check(file!(), "oracle_rounds", 2000, &any::<u64>(), |bits| {
        let value = f64::from_bits(bits);
        if value.is_finite() && value != 0.0 {
            prop_assert_eq!(round_to_f32(&q(value)).to_bits(), (value as f32).to_bits());
        }
        // And with the exponents of f32, down to its subnormals.
        let value = f64::from(f32::from_bits(bits as u32)) * (1.0 + f64::from(bits as u16) / 1e9);
        if value.is_finite() && value != 0.0 {
            prop_assert_eq!(round_to_f32(&q(value)).to_bits(), (value as f32).to_bits());
        }
        Ok(())
    });
}

#[test]
fn oracle_rounds_fractions_to_the_nearest() {
    let third = round_to_f32(&fraction(1, 3));
    assert_eq!(third.to_bits(), 0x3EAA_AAAB);
    assert_eq!(round_to_f32(&fraction(-2, 3)).to_bits(), 0xBF2A_AAAB);
    check(file!(), "oracle_rounds_fractions", 2000, &(1_i64.., 1_i64..), |(n, d)| {
        let exact = fraction(n, d);
        let rounded = round_to_f32(&exact);
        let off = |f: f32| {
            let d = q(f64::from(f)) - &exact;
            if d < Q::ZERO { -d } else { d }
        };
        prop_assert!(off(rounded) <= off(rounded.next_up()));
        prop_assert!(off(rounded) <= off(rounded.next_down()));
        Ok(())
    });
    assert_eq!(power_of_two(-3) * q(8.0), Q::ONE);
}

/// The square from (1, 1) to (3, 3) covers 2 x 2 pixels; moved onto centres, those at its upper
/// and left edges.
#[test]
fn oracle_of_coverage_is_half_open() {
    let square = |a: i64, b: i64| [[a, a], [a, b], [b, b], [b, a]];
    let rect = viewport(5, 5).rect();
    let whole = |points: &[[i64; 2]]| coverage::covered(Grid::Eight, points, rect);
    let four = vec![(1, 1), (2, 1), (1, 2), (2, 2)];
    assert_eq!(whole(&square(256, 768)), four);
    assert_eq!(whole(&square(384, 896)), four, "on centres: 1.5 to 3.5");
    assert_eq!(whole(&square(385, 897)), vec![(2, 2), (3, 2), (2, 3), (3, 3)]);
    assert_eq!(coverage::doubled_area(&square(0, 10)), 200, "down, then right");
    let twice: Vec<_> = [square(256, 768), square(256, 768)].concat();
    assert_eq!(winding(Grid::Eight, &twice, 1, 1).abs(), 2);
}

#[test]
fn oracle_snaps_half_to_even() {
    let half = 0.5 / 65536.0;
    let snap = |x| coverage::snap(Grid::Sixteen, [x, -x]);
    assert_eq!(snap(half), [0, 0]);
    assert_eq!(snap(3.0 * half), [2, -2]);
    assert_eq!(snap(1.0), [65536, -65536]);
    let view = Viewport::new(10, 20, 100, 50).unwrap();
    assert_eq!(coverage::framebuffer(view, [1.0, 1.0, 0.0, 2.0]), [85.0, 32.5]);
}

/// A floor seen along z: 1/w and z/w at a pixel by hand.
#[test]
fn oracle_of_values_has_the_floor_right() {
    // w from 1 at the bottom to 4 at the top; y/w from -1 to 0.
    let poly = Poly {
        positions: vec![
            [-1.0, -1.0, 0.0, 1.0],
            [1.0, -1.0, 0.0, 1.0],
            [4.0, 0.0, 3.0, 4.0],
            [-4.0, 0.0, 3.0, 4.0],
        ],
        attributes: vec![vec![0.0, 0.0], vec![1.0, 0.0], vec![1.0, 1.0], vec![0.0, 1.0]],
    };
    let modes = [Interpolation::Perspective, Interpolation::NoPerspective];
    let plane = Plane::new(&poly, viewport(8, 8), &modes);
    assert!(plane.is_flat() && !plane.is_edge_on());
    // The centre of (3, 6) is (-1/8, -5/8) in NDC: a quarter of the way up from -1 to 0 is
    // -3/4, so three eighths up: 1/w = 1 - 3/4 * 3/8 = 23/32.
    let at = plane.at(3, 6);
    assert_eq!(at.inv_w(), Right::Is(23.0 / 32.0));
    assert_eq!(at.w(), Right::Is((32.0_f64 / 23.0) as f32));
    // z = w - 1.
    assert_eq!(at.depth(), Right::Is(9.0 / 32.0));
    // u = (x/w + 1)/2.. but on the floor's own grid: x runs from -w to w, so u is not affine.
    assert_eq!(at.attribute(0), Right::Across);
    assert_eq!(at.attribute(1), Right::Is(3.0 / 8.0), "noperspective: three eighths of the way");
}

#[test]
fn oracle_of_values_takes_perspective_into_account() {
    let poly = Poly {
        positions: vec![[-1.0, -1.0, 0.0, 1.0], [3.0, -1.0, 0.0, 1.0], [-3.0, 9.0, 3.0, 3.0]],
        attributes: vec![vec![0.0], vec![0.0], vec![1.0]],
    };
    let plane = Plane::new(&poly, viewport(4, 4), &[]);
    // The centre of (0, 0) is (-3/4, 3/4): b = (.., .., 7/16), l = b/w.
    let at = plane.at(0, 0);
    let (b, inv_w) = (7.0 / 16.0, 1.0 - 7.0 / 16.0 * (2.0 / 3.0));
    assert_eq!(at.inv_w(), Right::Is(inv_w as f32));
    assert_eq!(at.attribute(0), Right::Is((b / 3.0 / inv_w) as f32));
    let gl = viewport(4, 4).with_depth_range(DepthRange::MinusOneToOne);
    assert_eq!(Plane::new(&poly, gl, &[]).at(0, 0).depth(), Right::Is(((b + 1.0) / 2.0) as f32));
    // Far outside, where 1/w <= 0 on the plane: the nearest vertex.
    let steep = Poly {
        positions: vec![[-1.0, -1.0, 0.0, 1.0], [1.0, -1.0, 0.0, 1.0], [0.0, 0.0, 3.0, 4.0]],
        attributes: vec![vec![5.0], vec![6.0], vec![7.0]],
    };
    let plane = Plane::new(&steep, viewport(16, 16), &[]);
    assert_eq!(plane.at(8, -20).attribute(0), Right::Is(7.0));
    assert_eq!(plane.at(8, -20).w(), Right::Is(4.0));
    // Before that, what is outside is clamped.
    assert_eq!(plane.at(8, 6).w(), Right::Is(4.0));
}

#[test]
fn oracle_of_values_tells_flat_from_bent() {
    let square = |lift: f64| Poly {
        positions: vec![
            [-1.0, -1.0, 0.5, 2.0],
            [1.0, -1.0, 0.5, 2.0],
            [1.0, 1.0, 0.5, 2.0 + lift],
            [-1.0, 1.0, 0.5, 2.0],
        ],
        attributes: vec![vec![]; 4],
    };
    let view = viewport(4, 4);
    assert!(Plane::new(&square(0.0), view, &[]).is_flat());
    assert!(Plane::new(&square(1e-3), view, &[]).is_flat());
    assert!(!Plane::new(&square(1e-2), view, &[]).is_flat());
    assert!(Plane::new(&square(1e-2), view, &[]).at(1, 1).inv_w() == Right::Across);
    let edge_on = [[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.5, 2.0], [0.0, -1.0, 0.5, 2.0]];
    assert!(Plane::new(&Poly::bare(&edge_on), view, &[]).is_edge_on());
}

#[test]
fn oracle_of_clipping_cuts_a_cube_from_a_giant() {
    let view = viewport(64, 64);
    let giant = [[-1e9, -1e9, 0.5, 1.0], [1e9, -1e9, 0.5, 1.0], [0.0, 1e9, 0.5, 1.0]];
    let corners = clipper::clip(&Poly::bare(&giant), &clipper::planes(view));
    assert_eq!(corners.len(), 4, "the guard band itself");
    for corner in &corners {
        assert_eq!(exact::sum(corner.weights.iter().cloned()), Q::ONE);
        let place = corner.framebuffer(view).unwrap().map(|c| exact::approximate(&c));
        assert!(place.iter().all(|c| c.abs() <= coverage::GUARD), "{place:?}");
    }
    let behind = [[0.0, 0.0, -1.0, -1.0], [1.0, 0.0, -2.0, -1.0], [0.0, 1.0, -1.0, -1.0]];
    assert!(clipper::clip(&Poly::bare(&behind), &clipper::planes(view)).is_empty());
}

#[test]
fn oracle_of_clipping_agrees_with_the_one_of_coverage() {
    check(file!(), "oracle_of_clipping", 300, &scenes(10.0), |scene| {
        let view = scene.viewport;
        prop_assert!(is_unclipped(view, &scene.poly), "the strategy promises it");
        let points = snapped(view, &scene.poly);
        let corners = clipper::clip(&scene.poly, &clipper::planes(view));
        prop_assert_eq!(corners.len(), points.len());
        let outline = clipper::outline(view, &corners);
        for y in scene.window.y0..scene.window.y1 {
            for x in scene.window.x0..scene.window.x1 {
                let covered = winding(view.grid(), &points, x, y) != 0;
                match clipper::side(&outline, x, y, 1.0 / 16384.0) {
                    Side::Inside => prop_assert!(covered, "({}, {})", x, y),
                    Side::Outside => prop_assert!(!covered, "({}, {})", x, y),
                    Side::Near => {}
                }
            }
        }
        Ok(())
    });
}

/// The oracle of values against the textbook's formula in f64, within a tolerance.
#[test]
fn oracle_of_values_agrees_with_barycentrics_in_f64() {
    let pixels = Tally::default();
    let cases = check(file!(), "oracle_of_values", 1000, &scenes(6.0), |scene| {
        let (view, poly) = (scene.viewport, &scene.poly);
        let plane = Plane::new(poly, view, &scene.interpolation);
        let places: Vec<_> =
            poly.positions.iter().map(|p| coverage::framebuffer(view, *p)).collect();
        let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        // Three vertices that are well apart.
        let n = places.len();
        let [i, j, k] = [0, n / 3, 2 * n / 3];
        let area = turn(places[i], places[j], places[k]);
        let reach = places.iter().flatten().fold(0.0, |a: f64, c| a.max(c.abs()));
        // Slivers, or too far away, for this formula in f64.
        if area.abs() < 50.0 + 1e-5 * reach * reach {
            return Ok(());
        }
        prop_assert!(plane.is_flat());
        let points = snapped(view, poly);
        for (x, y) in coverage::covered(view.grid(), &points, scene.window) {
            let p = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            let b =
                [turn(p, places[j], places[k]), turn(places[i], p, places[k])].map(|t| t / area);
            let l = [(i, b[0]), (j, b[1]), (k, 1.0 - b[0] - b[1])];
            let inv_w: f64 = l.iter().map(|(i, b)| b / poly.positions[*i][3]).sum();
            let at = plane.at(x, y);
            pixels.add(1);
            let close = |oracle: Right, value: f64, size: f64| match oracle {
                Right::Is(o) => (f64::from(o) - value).abs() <= 1e-4 * size,
                _ => true,
            };
            prop_assert!(close(at.inv_w(), inv_w, 1.0));
            for m in 0..poly.attributes[0].len() {
                let s = |i: usize| f64::from(poly.attributes[i][m]);
                let size =
                    poly.attributes.iter().map(|a| f64::from(a[m]).abs()).fold(0.0, f64::max);
                let value = match scene.interpolation[m] {
                    Interpolation::Flat => s(0),
                    Interpolation::NoPerspective => l.iter().map(|(i, b)| b * s(*i)).sum(),
                    Interpolation::Perspective => {
                        l.iter().map(|(i, b)| b * s(*i) / poly.positions[*i][3]).sum::<f64>()
                            / inv_w
                    }
                };
                let oracle = at.attribute(m);
                prop_assert!(close(oracle, value, size.max(1e-37)), "{} {:?} {}", m, oracle, value);
            }
        }
        Ok(())
    });
    pixels.report("pixels", 10 * cases);
}
