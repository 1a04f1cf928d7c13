//! Numerical stability: the reference that the benchmarks and the stress measure with, against
//! rationals; and the stress of `hyperspan bench --stress`, thinned out.

use crate::bench::reference::{Reference, Value};
use crate::bench::stress::{self, Options, Until};
use crate::oracle::Poly;
use crate::oracle::exact::{Q, q, round_to_f32};
use crate::oracle::plane::Plane;
use crate::oracle::probe;
use crate::oracle::shapes::{Tally, check, corners, scenes, unproject, vanishing_polygons};
use hyperspan::space::{PixelRect, Viewport};
use proptest::prelude::*;

/// Triangles of any shape, slivers and giants included, with w over up to 30 powers of two, and
/// attributes of any size; some of the vertices behind the eye.
fn triangles() -> impl Strategy<Value = (Viewport, Poly)> {
    let side = || prop_oneof![1_u32..64, Just(1024), Just(16384)];
    let corner = || prop_oneof![3 => Just(0), 1 => -2_000_000..2_000_000_i32];
    let vertex = || {
        let depth = prop_oneof![5 => 0.0..1.0_f64, 1 => -1.0..2.0_f64];
        (depth, -15.0..15.0_f64, prop::sample::select(vec![1.0, 1.0, 1.0, 1.0, -1.0]))
    };
    let values = || (prop::collection::vec(-1.0..1.0_f32, 3), -100..100_i32, any::<bool>());
    let hair = || (prop_oneof![Just(0), 1..40_i32], [-1.0..1.0_f64, -1.0..1.0]);
    (side(), side(), corner(), corner()).prop_flat_map(move |(width, height, x, y)| {
        let viewport = Viewport::new(x, y, width, height).expect("up to 16384");
        let vertices = [vertex(), vertex(), vertex()];
        (corners(width, height), vertices, [values(), values()], hair()).prop_map(
            move |(mut at, vertices, values, (thin, aside))| {
                if thin > 0 {
                    let off = aside.map(|c| c * f64::from(-thin).exp2());
                    at[2] = [0, 1].map(|i| at[0][i] * 0.25 + at[1][i] * 0.75 + off[i]);
                }
                let mut poly = Poly::default();
                for (k, (depth, exponent, sign)) in vertices.into_iter().enumerate() {
                    let w = sign * exponent.exp2();
                    poly.positions.push(unproject(viewport, at[k], depth, w));
                    let size = |(list, exponent, offset): &(Vec<f32>, i32, bool)| {
                        let offset = if *offset { 1000.0 } else { 0.0 };
                        (list[k] + offset) * (*exponent as f32).exp2()
                    };
                    poly.attributes.push(values.iter().map(size).collect());
                }
                (viewport, poly)
            },
        )
    })
}

/// |value - right| <= its error, in rationals; and the error is small beside half a unit.
fn agrees(value: Value, right: &Q, what: &str) -> Result<(), TestCaseError> {
    let off = q(value.high) + q(value.low) - right;
    let off = if off < Q::ZERO { -off } else { off };
    prop_assert!(off <= q(value.error), "{what}: {value:?} is off by {:e}", off.to_f64().value());
    prop_assert!(value.error <= value.high.abs() * 2.0_f64.powi(-58), "{what}: {value:?}");
    let rounded = round_to_f32(right);
    prop_assert!(value.ulp(rounded) <= 0.5, "{what}: {} ulp", value.ulp(rounded));
    let farther = value.ulp(rounded.next_up()).min(value.ulp(rounded.next_down()));
    prop_assert!(farther >= 0.5, "{what}: a neighbour is {farther} ulp off");
    Ok(())
}

#[test]
fn stability_reference_is_the_inverse_of_the_transform() {
    let pixels = (triangles(), prop::collection::vec([0.0..1.0_f64, 0.0..1.0], 8));
    let compared = Tally::default();
    let cases =
        check(file!(), "stability_reference", 1500, &pixels, |((viewport, poly), places)| {
            let Some(reference) = Reference::new(&poly.positions, &poly.attributes, &viewport)
            else {
                prop_assert!(Plane::new(&poly, viewport, &[]).is_edge_on());
                return Ok(());
            };
            let plane = Plane::new(&poly, viewport, &[]);
            let PixelRect { x0, y0, .. } = viewport.rect();
            for [right, down] in places {
                let x = x0 + (right * f64::from(viewport.width())) as i32;
                let y = y0 + (down * f64::from(viewport.height())) as i32;
                let Some(depth) = reference.depth(x, y) else { continue };
                let at = plane.at(x, y);
                agrees(depth, &at.exact_depth(), "depth")?;
                for k in 0..2 {
                    let value = reference.attribute(k, x, y).expect("depth has one");
                    let right = at.exact_attribute(k).expect("a triangle's is affine");
                    agrees(value, &right, &format!("attribute {k}"))?;
                    compared.add(1);
                }
                if let Some(value) = reference.inv_w(x, y) {
                    agrees(value, &at.exact_inv_w(), "1/w")?;
                    let w = reference.w(x, y).expect("1/w has one");
                    agrees(w, &(Q::ONE / at.exact_inv_w()), "w")?;
                    compared.add(2);
                }
            }
            Ok(())
        });
    compared.report("values compared", 8 * cases);
}

/// Of polygons with more vertices, three carry the plane, and the others lie beside it by what
/// rounding has left: so it shows which. And where an attribute is 0 at the very centre, pairs are
/// no help.
#[test]
fn stability_reference_takes_the_same_three_vertices() {
    let compared = Tally::default();
    let polygons = prop_oneof![
        scenes(20.0).prop_map(|scene| (scene.view(), scene.poly)),
        vanishing_polygons(),
    ];
    let cases = check(file!(), "stability_triple", 600, &polygons, |(view, poly)| {
        let (poly, viewport) = (&poly, view.viewport);
        let Some(reference) = Reference::new(&poly.positions, &poly.attributes, &viewport) else {
            return Ok(());
        };
        let plane = Plane::new(poly, viewport, &[]);
        let (_, picture, _) = probe::draw(&view, poly);
        for &(y, x) in picture.keys().step_by(11) {
            let at = plane.at(x, y);
            for k in 0..poly.attributes[0].len() {
                let found = (at.exact_attribute(k), reference.attribute(k, x, y));
                let (Some(right), Some(value)) = found else { continue };
                agrees(value, &right, &format!("attribute {k}"))?;
                compared.add(1);
            }
            if let Some(value) = reference.inv_w(x, y).filter(|_| plane.is_flat()) {
                agrees(value, &at.exact_inv_w(), "1/w")?;
            }
        }
        Ok(())
    });
    compared.report("values compared", 5 * cases);
}

/// Every sweep, thinned out: no error is above its bound, and each step looked at something.
#[test]
fn stability_no_sweep_breaks_a_bound() {
    let options = Options { polygons: 200, search: None, seed: 1 };
    let rows = stress::run(options, &mut |_, _| {}).expect("good viewports");
    for row in &rows {
        assert!(row.judged.worst_of_all() <= 1.0, "{row:#?}");
        // A reference that is too forgiving would leave less of the bounds.
        let attributes = row.judged.worst.map(|of| of[0]);
        assert!(attributes[0] > 0.1 && attributes[1] > 0.99, "{row:#?}");
        assert!(row.judged.values > 10_000, "{row:#?}");
        assert!(row.judged.left_out < row.judged.values / 5, "{row:#?}");
        let clips = row.sweep == "near plane" || (row.sweep == "giant" && row.step >= 1000.0);
        assert!(!clips || row.judged.clipped > row.polygons / 2, "{row:#?}");
    }

    // A picture that moves by parts of a pixel does not swim: in the last hundred of a thousand
    // frames values are as good as in the first.
    let panned: Vec<_> = rows.iter().filter(|row| row.sweep == "pan").collect();
    let [first, .., last] = panned[..] else { panic!("{rows:#?}") };
    let (first, last) = (first.judged, last.judged);
    assert!(last.mean_of_fast() < 1.05 * first.mean_of_fast(), "{first:?} {last:?}");
    assert!(last.worst_of_fast() < 1.5 * first.worst_of_fast(), "{first:?} {last:?}");
}

/// A climb towards the worst gets as far as thousands of polygons of a sweep, and breaks no bound.
#[test]
fn stability_search_breaks_no_bound() {
    let until = Until { tried: 8000, seconds: f64::INFINITY };
    let options = Options { polygons: 0, search: Some(until), seed: 1 };
    let rows = stress::run(options, &mut |_, _| {}).expect("good viewports");
    let found = rows.last().expect("the search's");
    assert!(found.judged.worst_of_all() <= 1.0, "{found:#?}");
    assert!(found.judged.worst_of_fast() > 0.42, "{found:#?}");
    assert!(found.judged.pixels > 100_000, "{found:#?}");
}
