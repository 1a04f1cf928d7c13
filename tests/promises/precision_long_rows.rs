//! P2, `Fast`, along rows that are just long enough to go by blocks, where an attribute's steps are longest:
//! next to 0, where it is 7u |value| + 2^-29 M (a quarter of what small triangles have), and at the ends
//! of its range.

use crate::oracle::Poly;
use crate::oracle::plane::{Plane, Right};
use crate::oracle::probe::{self, View};
use crate::oracle::shapes::{Tally, check, unproject};
use hyperspan::space::{PixelRect, Viewport};
use hyperspan::tiler::Precision;
use hyperspan::varying::Interpolation;
use proptest::prelude::*;

/// Columns; and rows, of which one is looked at.
const SIZE: [u32; 2] = [320, 32];

/// A triangle that is wider than the viewport, with w that is the same all over, along rows, or nowhere;
/// and four attributes that pass through 0 in the middle of some column's pixels, but for their roundings.
fn wide() -> impl Strategy<Value = (View, Poly)> {
    let jitter = [-0.2..0.2_f64, -0.2..0.2, -0.2..0.2, -0.2..0.2];
    let steep = [0.0..4.0, 0.0..4.0, 0.0..4.0_f64];
    let exponents = prop_oneof![
        Just([0.0; 3]),
        (0.0..9.0_f64).prop_map(|e| [0.0, 0.0, e]),
        (0.0..4.0_f64).prop_map(|e| [0.0, e, 0.0]),
        steep,
    ];
    let modes =
        prop::sample::select(vec![Interpolation::Perspective, Interpolation::NoPerspective]);
    let columns = [0..320_u16, 0..320, 0..320, 0..320];
    (jitter, exponents, columns, 0.5..1.0_f64, modes, 0_i32..32).prop_map(
        |(jitter, exponents, columns, step, mode, row)| {
            let [w, h] = SIZE;
            let viewport = Viewport::new(0, 0, w, h).expect("small");
            let mut poly = Poly::default();
            for (i, [x, y]) in [[-0.3, -0.4], [1.3, -0.3], [0.5, 1.9]].into_iter().enumerate() {
                let at = [(x + jitter[i]) * f64::from(w), (y + jitter[3]) * f64::from(h)];
                let own_w = exponents[i].exp2();
                let weight = if mode == Interpolation::Perspective { own_w } else { 1.0 };
                let value =
                    |column: u16| ((at[0] - f64::from(column) - 0.5) * step * weight) as f32;
                poly.positions.push(unproject(viewport, at, 0.5, own_w));
                poly.attributes.push(columns.map(value).to_vec());
            }
            let view = View {
                window: PixelRect::new(0, row, w, 1),
                precision: Precision::Fast,
                interpolation: vec![mode; 4],
                ..View::whole(viewport)
            };
            (view, poly)
        },
    )
}

#[test]
fn precision_next_to_zero_is_that_of_the_value() {
    const U: f64 = 1.0 / 16_777_216.0;
    let (near, compared) = (Tally::default(), Tally::default());
    let cases = check(file!(), "precision_near_zero", 200, &wide(), |(view, poly)| {
        let (_, picture, _) = probe::draw(&view, &poly);
        let plane = Plane::new(&poly, view.viewport, &view.interpolation);
        probe::same_in_rows(&view, &poly, &picture).map_err(TestCaseError::fail)?;
        for k in 0..4 {
            let size = |list: &Vec<f32>| f64::from(list[k].abs());
            let most = poly.attributes.iter().map(size).fold(0.0, f64::max);
            for ((y, x), seen) in &picture {
                let Right::Is(right) = plane.at(*x, *y).attribute(k) else { continue };
                let right = f64::from(right);
                let drawn = f64::from(f32::from_bits(seen.attributes[k]));
                // The right value is rounded itself.
                let bound = 8.0 * U * right.abs() + U / 32.0 * most;
                let near_enough = (right - drawn).abs() <= bound;
                prop_assert!(near_enough, "{k} at {x}, {y}: {right:e}, drawn {drawn:e}");
                compared.add(1);
                near.add(usize::from(right.abs() < U * most));
            }
        }
        Ok(())
    });
    compared.report("values compared", 500 * cases);
    near.report("values that are as good as 0", cases);
}

/// Rectangles whose corners lie in pixels' centres, where attributes have their least and their greatest
/// value: a rounding more, and they would be beyond.
#[test]
fn precision_at_the_ends_of_long_rows_is_clamped() {
    let ends = (0..20_u16, 290..319_u16);
    let values = [-1.0..1.0_f32, -1.0..1.0, -1.0..1.0, -1.0..1.0];
    let strategy = (ends, values.clone(), values, 0.0..6.0_f64);
    let at_ends = Tally::default();
    check(file!(), "precision_at_ends", 200, &strategy, |((x0, x1), left, right, exponent)| {
        let [w, h] = SIZE;
        let viewport = Viewport::new(0, 0, w, h).expect("small");
        let mut poly = Poly::default();
        for (x, y, values, own_w) in [
            (x0, 0.5, left, 1.0),
            (x0, 31.5, left, 1.0),
            (x1, 31.5, right, exponent.exp2()),
            (x1, 0.5, right, exponent.exp2()),
        ] {
            poly.positions.push(unproject(viewport, [f64::from(x) + 0.5, y], 0.5, own_w));
            poly.attributes.push(values.to_vec());
        }
        let view = View {
            window: PixelRect::new(0, 7, w, 2),
            precision: Precision::Fast,
            ..View::whole(viewport)
        };
        let (_, picture, _) = probe::draw(&view, &poly);
        probe::same_in_rows(&view, &poly, &picture).map_err(TestCaseError::fail)?;
        for (k, (a, b)) in left.into_iter().zip(right).enumerate() {
            for seen in picture.values() {
                let drawn = f32::from_bits(seen.attributes[k]);
                prop_assert!((a.min(b)..=a.max(b)).contains(&drawn), "{k}: {drawn}");
                at_ends.add(usize::from(drawn == a || drawn == b));
            }
        }
        Ok(())
    });
    at_ends.report("values of vertices", 500);
}
