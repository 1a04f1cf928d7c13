//! P2, `Exact`: every value is the correctly rounded one, bit for bit.

use crate::oracle::Poly;
use crate::oracle::judge;
use crate::oracle::plane::Plane;
use crate::oracle::probe::{self, View};
use crate::oracle::shapes::{
    self, Tally, check, clipped_polygons, in_range, loose_polygons, scenes, unproject,
};
use hyperspan::space::{Grid, PixelRect, Viewport};
use hyperspan::tiler::Precision;
use hyperspan::varying::Interpolation;
use proptest::prelude::*;

/// What was compared.
#[derive(Default)]
struct Compared {
    pixels: Tally,
    values: Tally,
    /// Of them, those that no vertex has.
    between: Tally,
    /// Of them, those that run along edges and across spans.
    across: Tally,
    /// Values without a promise.
    left_out: Tally,
    /// Values for which the tiler took exact arithmetic.
    hard: Tally,
}

impl Compared {
    /// There must be so many values between those of the vertices for each case, and by far most
    /// must be defined.
    fn report(&self, cases: u64, between: u64) {
        self.pixels.report("pixels compared", between * cases / 10);
        self.values.report("values compared", between * cases);
        self.between.report("of them between the vertices'", between * cases);
        self.across.report("of them along edges and across spans", 0);
        self.hard.report("values that took exact arithmetic", 0);
        self.left_out.report("values left out", 0);
        assert!(self.left_out.count() <= self.values.count() / 20, "too many left out");
    }
}

/// Draws, and compares every value of every pixel with the oracle.
fn agrees(view: &View, poly: &Poly, compared: &Compared) -> Result<(), TestCaseError> {
    let (_, picture, stats) = probe::draw(view, poly);
    let found = judge::values(view, poly, &picture).map_err(TestCaseError::fail)?;
    probe::same_in_rows(view, poly, &picture).map_err(TestCaseError::fail)?;
    compared.pixels.add(picture.len());
    compared.values.add(found.values);
    compared.between.add(found.between);
    compared.across.add(found.across);
    compared.left_out.add(found.left_out);
    compared.hard.add(usize::try_from(stats.exact_values).expect("few"));
    Ok(())
}

#[test]
fn precision_of_flat_polygons_is_exact() {
    let compared = Compared::default();
    let cases = check(file!(), "precision_of_flat_polygons", 2500, &scenes(7.0), |scene| {
        agrees(&scene.view(), &scene.poly, &compared)
    });
    compared.report(cases, 100);
}

#[test]
fn precision_holds_up_to_ratios_of_a_million() {
    let compared = Compared::default();
    let cases = check(file!(), "precision_of_steep_polygons", 2500, &scenes(20.0), |scene| {
        agrees(&scene.view(), &scene.poly, &compared)
    });
    compared.report(cases, 100);
}

#[test]
fn precision_holds_up_to_ratios_of_a_billion() {
    let compared = Compared::default();
    let cases = check(file!(), "precision_of_steepest_polygons", 800, &scenes(30.0), |scene| {
        agrees(&scene.view(), &scene.poly, &compared)
    });
    compared.report(cases, 100);
}

#[test]
fn precision_of_clipped_polygons_is_that_of_the_plane_as_given() {
    let compared = Compared::default();
    let clipped = Tally::default();
    let cases = check(file!(), "precision_of_clipped", 800, &clipped_polygons(), |(view, poly)| {
        clipped.add(usize::from(probe::draw(&view, &poly).2.clipped > 0));
        agrees(&view, &poly, &compared)
    });
    clipped.report("clipped polygons", cases / 3);
    compared.report(cases, 100);
}

#[test]
fn precision_of_what_is_not_affine_is_that_of_edges_and_spans() {
    let compared = Compared::default();
    let cases = check(file!(), "precision_of_loose", 2000, &loose_polygons(), |(view, poly)| {
        agrees(&view, &poly, &compared)
    });
    compared.across.report("along edges and across spans", 50 * cases);
    compared.left_out.report("values left out", 0);
}

/// Convex in the picture, in front of the eye, with any w, z and attributes: nothing but the
/// picture's outline is flat.
fn bent_polygons() -> impl Strategy<Value = (View, Poly)> {
    let bends = prop::collection::vec(([0.0..20.0_f64, 0.0..1.0], [-9.0..9.0_f32, 0.0..1.0]), 12);
    let bent = (scenes(3.0), bends, any::<bool>());
    bent.prop_map(|(scene, bends, all)| {
        let mut poly = scene.poly.clone();
        let vertices = poly.positions.iter_mut().zip(&mut poly.attributes).zip(bends);
        for (i, ((position, attributes), ([e, z], values))) in vertices.enumerate() {
            if all || i == 0 {
                // Along the ray through the eye, so that it stays in its place.
                let w = e.exp2();
                *position = position.map(|c| c / position[3] * w);
                position[2] = z * w;
            }
            attributes.extend(values);
        }
        let mut view = scene.view();
        view.interpolation.extend([Interpolation::Perspective, Interpolation::NoPerspective]);
        (view, poly)
    })
}

#[test]
fn precision_of_bent_polygons_is_that_of_edges_and_spans() {
    let compared = Compared::default();
    let cases = check(file!(), "precision_of_bent", 3000, &bent_polygons(), |(view, poly)| {
        agrees(&view, &poly, &compared)
    });
    compared.report(cases, 100);
    compared.across.report("along edges and across spans", 100 * cases);
}

/// Triangles and quads thinner than the subpixel grid, through centres of pixels: the centres
/// lie outside of the polygon as given by a hair, and what counts is how values are clamped.
fn hairs() -> impl Strategy<Value = (View, Poly)> {
    let hair = || [-1.4..1.4, -1.4..1.4_f64];
    let slope = [-3..=3_i32, -3..=3_i32];
    let along = [0..8_i32, 0..8, 0..8];
    let exponents =
        prop_oneof![[0.0..3.0, 0.0..3.0, 0.0..3.0_f64], [0.0..30.0, 0.0..30.0, 0.0..30.0]];
    let attributes = prop::collection::vec([-9.0..9.0_f32, -9.0..9.0_f32], 3);
    ([hair(), hair(), hair()], slope, along, exponents, attributes, any::<bool>()).prop_map(
        |(hairs, slope, along, exponents, attributes, linear)| {
            let viewport = Viewport::new(0, 0, 50, 50).expect("small");
            let mut poly = Poly::default();
            for k in 0..3 {
                let at = [0, 1]
                    .map(|i| f64::from(24 + slope[i] * along[k]) + 0.5 + hairs[k][i] / 65536.0);
                let depth = f64::from(along[k]) / 16.0;
                poly.positions.push(in_range(unproject(viewport, at, depth, exponents[k].exp2())));
                poly.attributes.push(attributes[k].to_vec());
            }
            let mode =
                if linear { Interpolation::NoPerspective } else { Interpolation::Perspective };
            (View { interpolation: vec![mode], ..View::whole(viewport) }, poly)
        },
    )
}

#[test]
fn precision_of_hairs_is_clamped_to_the_vertices() {
    let compared = Compared::default();
    let cases = check(file!(), "precision_of_hairs", 20_000, &hairs(), |(view, poly)| {
        agrees(&view, &poly, &compared)?;
        // Where one bound for a small triangle must say that it is no good.
        agrees(&View { precision: Precision::Fast, ..view }, &poly, &compared)
    });
    compared.pixels.report("pixels compared", cases / 10);
    compared.values.report("values compared", cases / 2);
    compared.left_out.report("values left out", 0);
}

/// The same with four corners, each attribute at any value: the centres lie beyond an end of the
/// span, or above or below the polygon, by a hair.
fn bent_hairs() -> impl Strategy<Value = (View, Poly)> {
    let hair = || [-1.4..1.4, -1.4..1.4_f64];
    // One in each quarter of the picture.
    let corner = || ([0..6_i32, 0..6_i32], hair(), 0.0..4.0_f64, [-9.0..9.0_f32, -9.0..9.0]);
    let level = prop_oneof![Just(None), (0..6_i32).prop_map(Some)];
    ([corner(), corner(), corner(), corner()], level).prop_map(|(corners, level)| {
        let viewport = Viewport::new(0, 0, 16, 16).expect("small");
        let mut poly = Poly::default();
        for (k, (mut pixel, hair, e, attributes)) in corners.into_iter().enumerate() {
            // Two of them side by side: an edge along the centres of a row.
            pixel[1] = level.filter(|_| k < 2).unwrap_or(pixel[1]);
            let quarter = [[0, 0], [6, 0], [6, 6], [0, 6]][k];
            let at = [0, 1].map(|i| f64::from(quarter[i] + pixel[i]) + 2.5 + hair[i] / 65536.0);
            poly.positions.push(in_range(unproject(viewport, at, 0.5, e.exp2())));
            poly.attributes.push(attributes.to_vec());
        }
        let interpolation = vec![Interpolation::Perspective, Interpolation::NoPerspective];
        (View { interpolation, ..View::whole(viewport) }, poly)
    })
}

#[test]
fn precision_of_bent_hairs_stays_between_the_ends() {
    let compared = Compared::default();
    let cases = check(file!(), "precision_of_bent_hairs", 8000, &bent_hairs(), |(view, poly)| {
        agrees(&view, &poly, &compared)
    });
    compared.report(cases, 10);
    compared.across.report("along edges and across spans", 10 * cases);
}

/// Parallelograms without perspective: by symmetry, of the vertices that could carry the plane
/// two are as good; and attributes are a little off the plane, so that it shows which is taken.
fn ties() -> impl Strategy<Value = (View, Poly)> {
    let corner = || [-30..30_i32, -30..30_i32];
    let slopes = [-64..64_i32, -64..64_i32];
    ([corner(), corner(), corner()], slopes, 0..4_usize, -3..=3_i32).prop_map(
        |([a, b, c], slopes, which, off)| {
            let viewport = Viewport::new(0, 0, 64, 64).expect("small");
            let corners = [a, b, [b[0] + c[0] - a[0], b[1] + c[1] - a[1]], c];
            let mut poly = Poly::default();
            for (k, corner) in corners.iter().enumerate() {
                let at = corner.map(|c| f64::from(c) / 4.0 + 32.0);
                poly.positions.push(unproject(viewport, at, 0.5, 1.0));
                let value = slopes[0] * corner[0] + slopes[1] * corner[1];
                let off = if k == which { off as f32 / 1024.0 } else { 0.0 };
                poly.attributes.push(vec![value as f32 + off]);
            }
            (View::whole(viewport), poly)
        },
    )
}

#[test]
fn precision_of_ties_is_that_of_the_least_vertices() {
    let compared = Compared::default();
    let cases = check(file!(), "precision_of_ties", 2000, &ties(), |(view, poly)| {
        agrees(&view, &poly, &compared)
    });
    compared.report(cases, 100);
}

/// Seen from the side: the third vertex lies exactly on the line through the two others, which
/// goes through centres; snapped, it lies to the right. Each pixel has the values of the vertex that is
/// nearest.
#[test]
fn precision_of_an_edge_on_triangle_is_that_of_the_nearest_vertex() {
    let viewport = Viewport::new(0, 0, 64, 64).expect("small");
    let (a, b) = ([0.5, 0.5], [9.5, 3.5]);
    let c = [a[0] + 15.0 / 1_048_576.0, a[1] + 5.0 / 1_048_576.0];
    let poly = Poly {
        positions: vec![
            unproject(viewport, a, 0.25, 1.0),
            unproject(viewport, b, 0.5, 2.0),
            unproject(viewport, c, 0.75, 4.0),
        ],
        attributes: vec![vec![1.0], vec![2.0], vec![3.0]],
    };
    let view = View::whole(viewport);
    assert!(Plane::new(&poly, viewport, &[]).is_edge_on());
    let (_, picture, _) = probe::draw(&view, &poly);
    let values: Vec<_> = picture
        .iter()
        .map(|(&(y, x), seen)| {
            let [inv_w, depth] = [seen.inv_w, seen.depth].map(f32::from_bits);
            ((x, y), inv_w, depth, f32::from_bits(seen.attributes[0]))
        })
        .collect();
    let right = [((0, 0), 1.0, 0.25, 1.0), ((3, 1), 0.25, 0.75, 3.0), ((6, 2), 0.5, 0.5, 2.0)];
    assert_eq!(values, right);
}

/// Triangles with a level side, from hardly wider than a pixel to so wide that spans are long, whose
/// w is constant along rows, or all over.
fn level_triangles() -> impl Strategy<Value = (View, Poly)> {
    let width = prop_oneof![1.0..17.0_f64, 1.0..80.0_f64, 300.0..800.0_f64];
    let place = (0.0..20.0_f64, width, -0.5..1.5_f64);
    let ratio = prop_oneof![Just(1.0), 1.0..9.0_f64, 1.0..1000.0_f64];
    let attributes = prop::collection::vec([-9.0..9.0_f32, 0.0..1.0_f32], 3);
    (place, 0.0..150.0_f64, 0.0..150.0_f64, ratio, attributes).prop_map(
        |((left, width, apex), level, y, ratio, attributes)| {
            let viewport = Viewport::new(0, 0, 900, 150).expect("small");
            let corners = [[left, level], [left + width, level], [left + apex * width, y]];
            // Of what is wide, where it is wide.
            let (x, rows) = if width > 90.0 { (left + width / 2.0 - 40.0, 9) } else { (0.0, 150) };
            let first = if y > level { level } else { level - f64::from(rows) };
            let window =
                PixelRect::new(x as i32, first as i32, 90, rows).intersect(viewport.rect());
            let ws = [1.0, 1.0, ratio];
            let positions = corners.iter().zip(ws).zip(&attributes);
            let position = |((at, w), values): ((&[f64; 2], f64), &[f32; 2])| {
                in_range(unproject(viewport, *at, f64::from(values[1]), w))
            };
            let positions = positions.map(position).collect();
            let attributes = attributes.iter().map(|values| values.to_vec()).collect();
            (View { window, ..View::whole(viewport) }, Poly { positions, attributes })
        },
    )
}

/// Tall ones of 16 columns or fewer had the reciprocal of another row, or none, in `Exact`.
#[test]
fn precision_of_level_triangles_is_exact() {
    let strategy = (level_triangles(), prop_oneof![Just(Precision::Exact), Just(Precision::Fast)]);
    let compared = Compared::default();
    let cases = check(file!(), "precision_level", 2000, &strategy, |((view, poly), precision)| {
        agrees(&View { precision, ..view }, &poly, &compared)
    });
    compared.report(cases, 100);
}

/// Triangles as narrow as some steps of the grid, at any ratio of distances: the plane in `f64`
/// is good for little.
fn slivers() -> impl Strategy<Value = (View, Poly)> {
    let ends = [[0.0..60.0_f64, 0.0..60.0], [0.0..60.0, 0.0..60.0]];
    let third = (-0.5..1.5_f64, [-1.0..1.0_f64, -1.0..1.0], 0..14_i32);
    let exponents = [0.0..30.0_f64, 0.0..30.0, 0.0..30.0];
    let attributes = prop::collection::vec([-9.0..9.0_f32, -9.0..9.0_f32], 3);
    (ends, third, exponents, attributes).prop_map(
        |([a, b], (t, aside, e), exponents, attributes)| {
            let viewport = Viewport::new(0, 0, 60, 60).expect("small");
            let c = [0, 1].map(|i| a[i] + t * (b[i] - a[i]) + aside[i] * f64::from(-e).exp2());
            let mut poly = Poly::default();
            for (k, at) in [a, b, c].into_iter().enumerate() {
                let depth = attributes[k][1].abs() / 9.0;
                let w = exponents[k].exp2();
                poly.positions.push(in_range(unproject(viewport, at, f64::from(depth), w)));
                poly.attributes.push(attributes[k].to_vec());
            }
            let interpolation = vec![Interpolation::Perspective, Interpolation::NoPerspective];
            (View { interpolation, ..View::whole(viewport) }, poly)
        },
    )
}

#[test]
fn precision_of_slivers_is_exact() {
    let compared = Compared::default();
    let cases = check(file!(), "precision_of_slivers", 2000, &slivers(), |(view, poly)| {
        agrees(&view, &poly, &compared)
    });
    compared.pixels.report("pixels compared", cases / 10);
    compared.left_out.report("values left out", 0);
}

/// On the n.8 grid, centres that are covered may lie outside the polygon by 256 times as much.
#[test]
fn precision_on_the_coarse_grid_is_exact() {
    let polygons = prop_oneof![
        scenes(12.0).prop_map(|scene| (scene.view(), scene.poly)),
        hairs(),
        bent_hairs(),
        slivers(),
    ];
    let strategy = (polygons, prop_oneof![Just(Precision::Exact), Just(Precision::Fast)]);
    let compared = Compared::default();
    let cases = check(file!(), "precision_coarse", 3000, &strategy, |((view, poly), precision)| {
        let viewport = view.viewport.with_grid(Grid::Eight);
        agrees(&View { viewport, precision, ..view }, &poly, &compared)
    });
    compared.report(cases, 10);
}

/// The other precision: 4u |value| + 3u M, depth to a unit in the last place.
#[test]
fn precision_of_fast_is_within_its_bound() {
    let polygons = prop_oneof![
        scenes(20.0).prop_map(|scene| (scene.view(), scene.poly)),
        clipped_polygons(),
        bent_polygons(),
        slivers(),
    ];
    let compared = Compared::default();
    let cases = check(file!(), "precision_of_fast", 3000, &polygons, |(view, poly)| {
        agrees(&View { precision: Precision::Fast, ..view }, &poly, &compared)
    });
    compared.report(cases, 100);
}

/// A quarter, a half and three quarters of a unit in the last place: every second value is a
/// true tie, and goes to the even neighbour.
#[test]
fn precision_of_true_ties_is_half_to_even() {
    let viewport = Viewport::new(0, 0, 64, 64).expect("small");
    let cover = [[-1.0, -1.0, 0.5, 1.0], [3.0, -1.0, 0.5, 1.0], [-1.0, 3.0, 0.5, 1.0]];
    let unit = 2.0_f32.powi(-23);
    for w in [1.0, 0.25, 1024.0] {
        // At column c, 1 + (c + 1/2) units; at row r, 1 - (63 - r + 1/2) quarters of a unit.
        let poly = Poly {
            positions: cover.map(|p| p.map(|v| v * w)).to_vec(),
            attributes: vec![
                vec![1.0, 1.0],
                vec![1.0 + 128.0 * unit, 1.0],
                vec![1.0, 1.0 - 32.0 * unit],
            ],
        };
        let (_, picture, _) = probe::draw(&View::whole(viewport), &poly);
        assert_eq!(picture.len(), 64 * 64);
        for ((y, x), seen) in picture {
            let even = (x + 1) / 2 * 2;
            let right = 1.0 + f64::from(even) * f64::from(unit);
            assert_eq!(f64::from(f32::from_bits(seen.attributes[0])), right, "column {x}");
            // Below 1 a unit is half as large: (63.5 - r) / 4 units are (63.5 - r) / 2 of these.
            let halves = f64::from(2 * (63 - y) + 1) / 4.0;
            let right = 1.0 - halves.round_ties_even() * f64::from(unit) / 2.0;
            assert_eq!(f64::from(f32::from_bits(seen.attributes[1])), right, "row {y}");
        }
    }
}

/// Attributes that are equal at all vertices, of any bits, beside others that are not.
#[test]
fn precision_of_constants_is_exact_for_any_bits() {
    let modes = [Interpolation::Perspective, Interpolation::NoPerspective, Interpolation::Flat];
    let bits = prop_oneof![8 => any::<u32>(), 1 => Just(0x8000_0000), 1 => Just(0xFF80_0000)];
    let strategy = (scenes(10.0), clipped_polygons(), bits, prop::sample::select(modes.to_vec()));
    let tally = Tally::default();
    let cases = check(
        file!(),
        "precision_of_constants",
        2000,
        &strategy,
        |(scene, clipped, bits, mode)| {
            let right = if f32::from_bits(bits).is_nan() { 0x7FC0_0000 } else { bits };
            for (view, mut poly) in [(scene.view(), scene.poly.clone()), clipped.clone()] {
                for list in &mut poly.attributes {
                    list.insert(0, f32::from_bits(bits));
                }
                let mut interpolation = vec![mode];
                interpolation.extend(&view.interpolation);
                for precision in [Precision::Exact, Precision::Fast] {
                    let interpolation = interpolation.clone();
                    let view = View { interpolation, precision, ..view.clone() };
                    let (_, picture, _) = probe::draw(&view, &poly);
                    tally.add(picture.len());
                    for (place, seen) in picture {
                        prop_assert_eq!(seen.attributes[0], right, "{:?}", place);
                    }
                }
            }
            Ok(())
        },
    );
    tally.report("constants compared", 100 * cases);
}

/// A NaN, or an infinity, at one vertex: coverage, depth and the other attributes keep their
/// bits, and the NaN's attribute is NaN all over.
#[test]
fn precision_of_an_attribute_is_spoiled_by_its_own_nan_only() {
    let bad = prop_oneof![
        (0x7F80_0001_u32..0x8000_0000, any::<bool>()).prop_map(|(b, s)| b | u32::from(s) << 31),
        Just(0x7F80_0000),
        Just(0xFF80_0000),
    ];
    let strategy = (scenes(10.0), bad, any::<prop::sample::Index>(), any::<prop::sample::Index>());
    let tally = Tally::default();
    let cases =
        check(file!(), "precision_of_nan", 3000, &strategy, |(scene, bits, which, vertex)| {
            let view = scene.view();
            let count = scene.poly.attributes[0].len();
            if count == 0 {
                return Ok(());
            }
            let (k, vertex) = (which.index(count), vertex.index(scene.poly.positions.len()));
            let mut spoiled = scene.poly.clone();
            spoiled.attributes[vertex][k] = f32::from_bits(bits);
            let (_, before, _) = probe::draw(&view, &scene.poly);
            let (_, mut after, _) = probe::draw(&view, &spoiled);
            let flat = view.interpolation[k] == Interpolation::Flat && vertex > 0;
            prop_assert_eq!(before.len(), after.len());
            for (place, seen) in &mut after {
                let right = &before[place];
                if f32::from_bits(bits).is_nan() && !flat {
                    prop_assert_eq!(seen.attributes[k], 0x7FC0_0000, "{:?}", place);
                }
                seen.attributes[k] = right.attributes[k];
                prop_assert_eq!(&*seen, right, "{:?}", place);
            }
            tally.add(after.len());
            Ok(())
        });
    tally.report("pixels compared", 5 * cases);
}

/// A triangle over images 8192 and 16384 pixels wide: the far ends.
#[test]
fn precision_at_the_ends_of_wide_images() {
    let corners = prop_oneof![Just(8192_u32), Just(16384)].prop_flat_map(|w| {
        (Just(w), shapes::corners(w, 64), [0.0..20.0, 0.0..20.0, 0.0..20.0_f64])
    });
    let values = [-1.0..1.0_f32, -1.0..1.0, -1.0..1.0];
    let compared = Compared::default();
    let cases =
        check(file!(), "precision_of_wide", 500, &(corners, values), |((w, at, e), values)| {
            let viewport = Viewport::new(0, 0, w, 64).expect("16384");
            let mut poly = Poly::default();
            for k in 0..3 {
                poly.positions.push(unproject(
                    viewport,
                    at[k],
                    0.5 / f64::from(k as u8 + 1),
                    e[k].exp2(),
                ));
                poly.attributes.push(vec![values[k]]);
            }
            for x in [0, w / 2 - 5, w - 20] {
                for y in [0, 32, 61] {
                    let window = PixelRect::new(x.cast_signed(), y, 20, 3);
                    agrees(&View { window, ..View::whole(viewport) }, &poly, &compared)?;
                }
            }
            Ok(())
        });
    compared.report(cases, 100);
}
