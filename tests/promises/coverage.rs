//! P1: a pixel is covered if and only if its centre is inside the snapped polygon, and polygons
//! that share an edge cover each pixel exactly once.

use std::collections::BTreeMap;

use crate::oracle::Poly;
use crate::oracle::coverage::{covered, doubled_area, is_unclipped, snapped};
use crate::oracle::probe::{self, Sheet, View};
use crate::oracle::shapes::{self, Tally, check, in_range, look, scenes, unproject};
use hyperspan::space::{Grid, PixelRect, Viewport};
use hyperspan::target::Target as _;
use hyperspan::tiler::{Cull, Outcome};
use proptest::prelude::*;

/// Draws an unclipped polygon, and compares with the oracle pixel by pixel.
fn agrees(view: &View, poly: &Poly, tally: &Tally) -> Result<(), TestCaseError> {
    prop_assert!(is_unclipped(view.viewport, poly), "the strategy promises it");
    let points = snapped(view.viewport, poly);
    let expected = covered(view.viewport.grid(), &points, view.visible());
    let (outcome, picture, _) = probe::draw(view, poly);
    let drawn: Vec<_> = picture.keys().map(|&(y, x)| (x, y)).collect();
    prop_assert_eq!(&drawn, &expected, "{:?}", outcome);
    if !expected.is_empty() {
        prop_assert_eq!(outcome, Outcome::Drawn);
    }
    tally.add(expected.len());
    Ok(())
}

#[test]
fn coverage_of_convex_polygons_is_the_crossing_oracles() {
    let tally = Tally::default();
    let cases = check(file!(), "coverage_of_convex_polygons", 20000, &scenes(6.0), |scene| {
        agrees(&scene.view(), &scene.poly, &tally)
    });
    tally.report("covered pixels", 30 * cases);
}

/// Vertices anywhere: the outline crosses itself, turns back on itself, repeats vertices. Half
/// of them on a lattice of centres, corners and midpoints of pixels, so that ties abound.
fn soups() -> impl Strategy<Value = (View, Poly)> {
    let lattice = |steps: f64| {
        let c = (-20.0 * steps..20.0 * steps).prop_map(move |v: f64| v.floor() / steps);
        [c.clone(), c]
    };
    let free = || [-40.0..40.0, -40.0..40.0];
    let giant = || [-30_000.0..30_000.0, -30_000.0..30_000.0];
    let list = |point: BoxedStrategy<[f64; 2]>| prop::collection::vec(point, 3..=12);
    let mixed = prop_oneof![lattice(2.0), lattice(65536.0), free(), giant()];
    let points = prop_oneof![
        4 => list(lattice(2.0).boxed()),
        1 => list(lattice(1.0).prop_map(|p| p.map(|c| c + 0.5)).boxed()),
        1 => list(lattice(256.0).boxed()),
        2 => list(free().boxed()),
        1 => list(mixed.boxed()),
        1 => list(giant().boxed()),
    ];
    let side = || prop_oneof![Just(32_u32), Just(64), 1_u32..70];
    let w = prop_oneof![Just(0.0), -3.0..3.0_f64];
    let ws = prop::collection::vec(w, 12);
    let place = prop_oneof![Just(0), -5000..5000_i32, Just(1 << 28)];
    let viewport = (place.clone(), place, side(), side(), any::<bool>());
    let window = ([-9..9_i32, -9..9_i32], [0..70_u32, 0..70_u32]);
    let mirrored = prop::bool::weighted(0.1);
    let shape = (points, mirrored).prop_map(|(mut points, mirrored)| {
        if mirrored {
            // Its own mirror image, run through in the same order: what is drawn goes round as
            // much to the left as to the right, and has no area.
            points.truncate(6);
            points.extend_from_within(..);
            let half = points.len() / 2;
            points[half..].iter_mut().for_each(|p| p[0] = -p[0]);
        }
        points
    });
    (shape, ws, viewport, window).prop_map(|(points, ws, (x, y, w, h, fine), (aside, size))| {
        let grid = if fine { Grid::Sixteen } else { Grid::Eight };
        let viewport = Viewport::new(x, y, w, h).expect("small").with_grid(grid);
        let middle = [f64::from(w / 2), f64::from(h / 2)];
        let flat = points.len() > 3;
        let vertex = |(p, e): (&[f64; 2], &f64)| {
            let w = if flat { 1.0 } else { e.exp2() };
            unproject(viewport, [p[0] + middle[0], p[1] + middle[1]], 0.5, w)
        };
        let positions: Vec<_> = points.iter().zip(&ws).map(vertex).collect();
        // A target that sticks out of the viewport, or does not reach its sides.
        let window = PixelRect::new(x + aside[0], y + aside[1], size[0], size[1]);
        (View { window, ..View::whole(viewport) }, Poly::bare(&positions))
    })
}

#[test]
fn coverage_of_any_outline_is_the_crossing_oracles() {
    let tally = Tally::default();
    let cases = check(file!(), "coverage_of_any_outline", 30000, &soups(), |(view, poly)| {
        agrees(&view, &poly, &tally)
    });
    tally.report("covered pixels", 30 * cases);
}

#[test]
fn coverage_does_not_depend_on_where_the_list_begins_or_its_direction() {
    check(file!(), "coverage_of_lists", 5000, &(soups(), 0..12_usize), |((view, poly), by)| {
        let drawn = probe::coverage(&view, &poly);
        let by = by % poly.positions.len();
        prop_assert_eq!(&probe::coverage(&view, &poly.rotated(by)), &drawn);
        prop_assert_eq!(&probe::coverage(&view, &poly.reversed()), &drawn);
        Ok(())
    });
}

/// Corners within some roundings of a tie between two steps of the grid, beside a centre: the
/// formula's order of operations decides.
#[test]
fn coverage_follows_the_formula_to_the_last_bit() {
    let side = || prop_oneof![2..100_u32, 1000..8192_u32];
    let place = prop_oneof![Just(0), -3000..3000_i32];
    let viewport = (place.clone(), place, side(), side());
    let corner = ([0.0..1.0, 0.0..1.0_f64], 0.3..3.0_f64, [-6..=6_i64, -6..=6_i64]);
    let (covered, not) = (Tally::default(), Tally::default());
    let strategy = (viewport, corner);
    let cases = check(file!(), "coverage_formula", 20_000, &strategy, |((x, y, w, h), corner)| {
        let viewport = Viewport::new(x, y, w, h).expect("8192 at most");
        let (at, clip_w, ulps) = corner;
        let pixel = [at[0] * f64::from(w), at[1] * f64::from(h)].map(f64::floor);
        let tie = pixel.map(|c| c + 0.5 + 0.5 / 65536.0);
        let mut p = unproject(viewport, tie, 0.5, clip_w);
        for (c, ulps) in p.iter_mut().zip(ulps) {
            *c = f64::from_bits(c.to_bits().wrapping_add_signed(ulps));
        }
        let [right, bottom] = [p[0] + 4.0 * clip_w, p[1] - 4.0 * clip_w];
        let [z, w] = [p[2], p[3]];
        let poly = [p, [p[0], bottom, z, w], [right, bottom, z, w], [right, p[1], z, w]];
        let window = PixelRect::new(x + pixel[0] as i32, y + pixel[1] as i32, 2, 2);
        let view = View { window, ..View::whole(viewport) };
        let seen = Tally::default();
        agrees(&view, &Poly::bare(&poly), &seen)?;
        let whole = view.visible();
        let most = (whole.x1 - whole.x0) * (whole.y1 - whole.y0);
        let all = seen.count() == u64::from(most.unsigned_abs());
        (if all { &covered } else { &not }).add(1);
        Ok(())
    });
    covered.report("corners left of and above a centre", cases / 50);
    not.report("corners beyond it", cases / 50);
}

/// Triangles with an edge past the centre of a pixel, nearer than any other place of the grid
/// would let it: on it, or to one side by one or two of the edge's height in steps of the grid.
fn near_misses() -> impl Strategy<Value = (Poly, [i32; 2])> {
    let exponent = 17..31_u32;
    let delta = (exponent.clone(), exponent, -1.0..1.0_f64, 0.5..1.0_f64);
    let pixel = [0..64_i32, 0..64_i32];
    let third = [-30_000.0..30_000.0, -30_000.0..30_000.0_f64];
    (delta, -2..=2_i64, pixel, third).prop_map(|((ex, ey, dx, dy), off, pixel, third)| {
        let [dx, mut dy] = [(dx, ex), (dy, ey)].map(|(c, e)| (c * f64::from(e).exp2()) as i64 | 1);
        while inverse(dx, dy).is_none() {
            dy += 1;
        }
        // Where the edge meets the row of the centre, t below its upper end, it is at
        // x + t dx / dy = centre + off / dy.
        let t = (i128::from(inverse(dx, dy).expect("coprime")) * i128::from(off))
            .rem_euclid(i128::from(dy)) as i64;
        let along = (i128::from(t) * i128::from(dx) - i128::from(off)) / i128::from(dy);
        let [x, y] = pixel.map(|c| i64::from(c) * 65536 + 32768);
        let upper = [x - along as i64, y - t];
        let place = |p: [i64; 2]| p.map(|c| c as f64 / 65536.0);
        let points = [place(upper), place([upper[0] + dx, upper[1] + dy]), third];
        let viewport = Viewport::new(0, 0, 64, 64).expect("small");
        let positions = points.map(|p| unproject(viewport, p, 0.5, 1.0));
        (Poly::bare(&positions), pixel)
    })
}

/// The x of 0 < x < `m` with a x = 1 modulo m, if there is one.
fn inverse(a: i64, m: i64) -> Option<i64> {
    let (mut r, mut s) = ([m, a.rem_euclid(m)], [0, 1]);
    while r[1] != 0 {
        let quotient = r[0] / r[1];
        r = [r[1], r[0] - quotient * r[1]];
        s = [s[1], s[0] - quotient * s[1]];
    }
    (r[0] == 1).then(|| s[0].rem_euclid(m))
}

#[test]
fn coverage_of_edges_that_miss_a_centre_by_the_least_is_the_crossing_oracles() {
    let view = View::whole(Viewport::new(0, 0, 64, 64).expect("small"));
    let (covered, not) = (Tally::default(), Tally::default());
    let cases =
        check(file!(), "coverage_of_near_misses", 5000, &near_misses(), |(poly, [x, y])| {
            agrees(&view, &poly, &Tally::default())?;
            let drawn = probe::coverage(&view, &poly).contains(&(x, y));
            (if drawn { &covered } else { &not }).add(1);
            Ok(())
        });
    covered.report("centres covered", cases / 5);
    not.report("centres missed", cases / 5);
}

/// A convex polygon from steps between lattice points, sorted by angle: collinear vertices,
/// parallel sides and horizontal and vertical edges abound.
fn lattice_polygons() -> impl Strategy<Value = (View, Poly)> {
    let steps = prop::collection::vec([-6..6_i32, -6..6_i32], 2..=6);
    (steps, 1..=4_i32, any::<bool>(), [-4.0..4.0_f64, -4.0..4.0]).prop_map(
        |(half, scale, halves, at)| {
            let mut steps = half.clone();
            steps.extend(half.iter().map(|s| s.map(|c| -c)));
            let angle = |s: &[i32; 2]| f64::from(s[1]).atan2(f64::from(s[0]));
            steps.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
            let viewport = Viewport::new(0, 0, 64, 64).expect("small");
            let shift = if halves { 0.5 } else { 0.0 };
            let mut place = at.map(|c| c.floor() + 32.0 + shift);
            let vertex = |s: &[i32; 2]| {
                place = [0, 1].map(|i| place[i] + f64::from(s[i]) / f64::from(scale));
                unproject(viewport, place, 0.5, 1.0)
            };
            let positions: Vec<_> = steps.iter().map(vertex).collect();
            (View::whole(viewport), Poly::bare(&positions))
        },
    )
}

#[test]
fn coverage_of_lattice_polygons_is_the_crossing_oracles() {
    let tally = Tally::default();
    let cases =
        check(file!(), "coverage_of_lattice", 10000, &lattice_polygons(), |(view, poly)| {
            agrees(&view, &poly, &tally)
        });
    tally.report("covered pixels", 30 * cases);
}

/// Adds `by` for each pixel that `poly` covers.
fn count(counts: &mut BTreeMap<(i32, i32), i32>, view: &View, poly: &Poly, by: i32) {
    for pixel in probe::coverage(view, poly) {
        *counts.entry(pixel).or_default() += by;
    }
}

/// Triangles from an inner point to the sides of an outline: inside, each pixel belongs to
/// exactly one; and should snapping turn one of them over, to one more of the others.
#[test]
fn coverage_of_a_fan_is_that_of_its_outline() {
    let inner = prop::collection::vec(0.01..1.0_f64, 12);
    let turns = prop::collection::vec((0..3_usize, any::<bool>()), 12);
    check(
        file!(),
        "coverage_of_a_fan",
        4000,
        &(scenes(4.0), inner, turns),
        |(scene, inner, turns)| {
            let (view, poly) = (View { interpolation: vec![], ..scene.view() }, &scene.poly);
            let n = poly.positions.len();
            let sum: f64 = inner[..n].iter().sum();
            let mean = |i: usize| {
                let terms =
                    poly.positions.iter().zip(&inner).map(|(p, weight)| p[i] * weight / sum);
                terms.sum::<f64>()
            };
            let hub = [0, 1, 2, 3].map(mean);
            let hub = in_range(hub);
            let whole = snapped(view.viewport, poly);
            let front = doubled_area(&whole) > 0;
            let mut counts = BTreeMap::new();
            for (i, (turn, over)) in (0..n).zip(&turns) {
                let part = Poly::bare(&[poly.positions[i], poly.positions[(i + 1) % n], hub]);
                let same_side = (doubled_area(&snapped(view.viewport, &part)) > 0) == front;
                let part = part.rotated(*turn);
                let part = if *over { part.reversed() } else { part };
                count(&mut counts, &view, &part, if same_side { 1 } else { -1 });
            }
            for &pixel in &covered(view.viewport.grid(), &whole, view.visible()) {
                // Less than none where snapping turned the outline itself over.
                let count = counts.remove(&pixel);
                prop_assert!(matches!(count, Some(1 | -1)), "{:?} at {:?}", count, pixel);
            }
            let outside = counts.iter().find(|(_, c)| **c != 0);
            prop_assert_eq!(outside, None, "drawn outside");
            Ok(())
        },
    );
}

/// Front faces are counter-clockwise with y up; a snapped area of 0 faces back.
#[test]
fn coverage_facing_is_the_sign_of_the_snapped_area() {
    check(file!(), "coverage_facing", 5000, &soups(), |(view, poly)| {
        let area = doubled_area(&snapped(view.viewport, &poly));
        let all = probe::coverage(&view, &poly);
        for (cull, shown) in [(Cull::Back, area > 0), (Cull::Front, area <= 0)] {
            let (width, height) = view.size();
            let mut sheet = Sheet::new(width, height);
            let mut tiler = view.tiler();
            let outcome = tiler.set_cull(cull).draw(
                &poly,
                &mut hyperspan::shade::Solid(1_u8),
                &mut sheet,
                None,
            );
            let drawn = sheet.pixels.iter().flatten().count();
            prop_assert_eq!(drawn, if shown { all.len() } else { 0 }, "{:?} {:?}", cull, outcome);
            if !shown && !all.is_empty() {
                prop_assert_eq!(outcome, Outcome::Backface);
                prop_assert_eq!(tiler.stats().culled.backface, 1);
            }
        }
        Ok(())
    });
}

/// A polygon over the whole of an image 8192 pixels wide, through windows: the same pixels as
/// the oracle's at the far ends.
#[test]
fn coverage_of_wide_images_is_exact_at_both_ends() {
    let strategy = (shapes::corners(8192, 8192), look());
    let tally = Tally::default();
    let cases = check(file!(), "coverage_of_wide_images", 3000, &strategy, |(corners, look)| {
        let viewport = Viewport::new(0, 0, 8192, 8192).expect("8192");
        let poly = Poly::bare(&corners.map(|c| unproject(viewport, c, 0.25, 1.0)));
        for (x, y) in [(0, 0), (8192 - 40, 8192 - 9), (8192 - 40, 0), (0, 8192 - 9)] {
            let window = PixelRect::new(x, y, 40, 9);
            agrees(&View { window, ..View::whole(viewport) }, &poly, &tally)?;
        }
        let window = look.window(viewport, &poly);
        agrees(&View { window, ..View::whole(viewport) }, &poly, &tally)
    });
    tally.report("covered pixels", 30 * cases);
}

#[test]
#[should_panic(expected = "(1, 0) is drawn twice")]
fn coverage_mock_panics_on_overdraw() {
    let mut sheet = Sheet::new(3, 3);
    sheet.write(0, 0, &[1_u8, 2]);
    sheet.write(1, 0, &[3_u8]);
}

#[test]
#[should_panic(expected = "(3, 0) lies outside the target")]
fn coverage_mock_panics_out_of_bounds() {
    Sheet::new(3, 3).write(2, 0, &[1_u8, 2]);
}
