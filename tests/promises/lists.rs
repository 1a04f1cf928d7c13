//! Lists of polygons: with vertices that are placed once for all of them, they have the bits and
//! the counts that they have without.

use crate::oracle::probe::Closure;
use crate::oracle::shapes::{Tally, check};
use hyperspan::polygon::Polygon;
use hyperspan::{
    Cull, DepthTest, Fragment, Indexed, Placed, Plane, Precision, Simd, Stats, Strided, Tiler,
    Viewport,
};
use proptest::prelude::*;

/// A list, and how it is drawn.
#[derive(Clone, Debug)]
struct List {
    viewport: Viewport,
    origin: [i32; 2],
    cull: Cull,
    precision: Precision,
    depth: Option<DepthTest>,
    positions: Vec<[f64; 4]>,
    faces: Vec<Vec<u32>>,
}

/// Pixels of the target.
const SIDES: (u32, u32) = (70, 50);

fn lists() -> impl Strategy<Value = List> {
    let corner = prop_oneof![3 => Just(0), 1 => -40_i32..40, 1 => Just(i32::MAX - 60)];
    let viewport = (corner.clone(), corner, 1_u32..150, 1_u32..150)
        .prop_map(|(x, y, w, h)| Viewport::new(x, y, w, h).expect("small"));
    let origin = [-20_i32..20, -20_i32..20];
    let cull = prop_oneof![Just(Cull::None), Just(Cull::Back), Just(Cull::Front)];
    let precision = prop_oneof![Just(Precision::Fast), Just(Precision::Exact)];
    let depth =
        prop::option::of(prop_oneof![Just(DepthTest::STANDARD), Just(DepthTest::REVERSED),]);
    // Now and then behind the eye, beyond a side, or at no number.
    let w = prop_oneof![20 => 0.5..2.0_f64, 1 => -1.0..1.0_f64, 1 => Just(f64::NAN)];
    let position = ([-1.1..1.1_f64, -1.1..1.1_f64, -0.02..1.0_f64], w)
        .prop_map(|([x, y, z], w)| [x * w, y * w, z * w, w]);
    let positions = prop::collection::vec(position, 12..40);
    let size = prop_oneof![Just(3), Just(3), Just(3), Just(3), Just(0), 1..8_usize];
    let face = size.prop_flat_map(|n| prop::collection::vec(0..12_u32, n));
    let settings = (viewport, origin, cull, precision, depth);
    (settings, positions, prop::collection::vec((face, 0..28_u32), 1..60)).prop_map(
        |((viewport, origin, cull, precision, depth), mut positions, faces)| {
            // Near neighbours make small triangles.
            for i in 1..positions.len() {
                if i % 4 != 0 {
                    let from = positions[i - 1];
                    let step = positions[i];
                    positions[i] = [0, 1, 2, 3].map(|k| from[k] * 0.94 + step[k] * 0.06);
                }
            }
            let last = positions.len() as u32 - 1;
            let faces = faces
                .into_iter()
                .map(|(face, start)| face.iter().map(|i| (start + i / 3).min(last)).collect())
                .collect();
            List { viewport, origin, cull, precision, depth, positions, faces }
        },
    )
}

/// Colour, depth and counts of what `paint` draws.
fn drawn(
    list: &List,
    paint: impl FnOnce(&mut Tiler, Closure<'_, u32>, &mut Plane<'_, u32>, Option<&mut Plane<'_, f32>>),
) -> (Vec<u32>, Vec<u32>, Stats) {
    let (width, height) = SIDES;
    let mut ids = vec![0_u32; (width * height) as usize];
    let clear = if list.depth == Some(DepthTest::STANDARD) { 1.0 } else { 0.0 };
    let mut depths = vec![clear; ids.len()];
    let mut tiler = Tiler::new(list.viewport);
    let corner = list.viewport.rect();
    // Two steps, for a viewport at the end of all columns.
    let origin = |first: i32, by: i32| first.saturating_add(by);
    tiler
        .set_origin(origin(corner.x0, list.origin[0]), origin(corner.y0, list.origin[1]))
        .set_cull(list.cull)
        .set_precision(list.precision)
        .set_depth_test(list.depth.unwrap_or(DepthTest::STANDARD));
    let mut target = Plane::new(&mut ids, width, height).expect("as many");
    let mut buffer = Plane::new(&mut depths, width, height).expect("as many");
    let mut shader = |f: &Fragment<'_>| {
        let bits = [f.depth(), f.attribute(0), f.attribute(1)].map(f32::to_bits);
        bits[0] ^ bits[1].rotate_left(11) ^ bits[2].rotate_left(22)
    };
    paint(&mut tiler, &mut shader, &mut target, list.depth.is_some().then_some(&mut buffer));
    let stats = Stats { peak_bytes: 0, ..tiler.stats() };
    (ids, depths.iter().map(|d| d.to_bits()).collect(), stats)
}

#[test]
fn lists_with_places_are_drawn_as_without() {
    let (pixels, triangles) = (Tally::default(), Tally::default());
    let cases = check(file!(), "lists", 1500, &lists(), |list| {
        let attributes: Vec<f32> =
            (0..list.positions.len() * 2).map(|i| ((i * 37) % 101) as f32 / 50.0 - 1.0).collect();
        let vertices =
            Strided::new(&list.positions, &attributes, 2, 2).expect("two for each vertex");
        let face = |face| Indexed::new(&vertices, face).expect("faces name vertices");
        let one_by_one = drawn(&list, |tiler, mut shader, target, mut depth| {
            for indices in &list.faces {
                tiler.draw(&face(indices), &mut shader, target, depth.as_deref_mut());
            }
        });
        let mut placed = Placed::new(list.viewport);
        for (_, simd) in Simd::all() {
            placed.set(&list.positions, simd);
            let with_places = drawn(&list, |tiler, mut shader, target, mut depth| {
                tiler.set_simd(simd);
                for indices in &list.faces {
                    let polygon = face(indices).with_placed(&placed);
                    tiler.draw(&polygon, &mut shader, target, depth.as_deref_mut());
                }
            });
            prop_assert_eq!(&with_places, &one_by_one);
        }
        // Those of another viewport are of no use, and do no harm.
        let other = Viewport::new(1, 2, 3, 4).expect("small");
        let mut elsewhere = Placed::new(other);
        elsewhere.set(&list.positions, Simd::auto());
        let ignored = drawn(&list, |tiler, mut shader, target, mut depth| {
            for indices in &list.faces {
                let polygon = face(indices).with_placed(&elsewhere);
                tiler.draw(&polygon, &mut shader, target, depth.as_deref_mut());
            }
        });
        prop_assert_eq!(&ignored, &one_by_one);
        pixels.add(one_by_one.2.pixels_shaded as usize);
        triangles.add(list.faces.iter().filter(|f| f.len() == 3).count());
        Ok(())
    });
    pixels.report("pixels", 20 * cases);
    triangles.report("triangles", 10 * cases);
}

/// Fewer places than vertices: the rest is drawn as if it had none.
#[test]
fn lists_with_too_few_places_are_drawn() {
    let positions = [[-0.5, -0.5, 0.5, 1.0], [0.5, -0.5, 0.5, 1.0], [0.0, 0.6, 0.5, 1.0]];
    let vertices = Strided::new(&positions, &[], 0, 0).expect("no attributes");
    let viewport = Viewport::new(0, 0, 8, 8).expect("small");
    let mut placed = Placed::new(viewport);
    placed.set(&positions[..1], Simd::auto());
    let polygon = Indexed::new(&vertices, &[0, 1, 2]).expect("three").with_placed(&placed);
    assert!(polygon.placed().is_some());
    let (mut with, mut without) = ([0_u32; 64], [0_u32; 64]);
    let mut shader: Closure<'_, u32> = &mut |_| 1;
    let mut plane = Plane::new(&mut with, 8, 8).expect("64");
    Tiler::new(viewport).draw(&polygon, &mut shader, &mut plane, None);
    let mut plane = Plane::new(&mut without, 8, 8).expect("64");
    Tiler::new(viewport).draw(&vertices, &mut shader, &mut plane, None);
    assert_eq!(with, without);
    assert!(with.contains(&1));
}

/// Places that are not those of the positions: anything may be drawn, but only in the target, and
/// nothing panics.
#[test]
fn lists_with_wrong_places_do_no_harm() {
    let right = [[-0.5, -0.5, 0.5, 1.0], [0.5, -0.5, 0.5, 1.0], [0.0, 0.6, 0.5, 1.0]];
    let viewport = Viewport::new(0, 0, 8, 8).expect("small");
    let mut placed = Placed::new(viewport);
    placed.set(&right, Simd::auto());
    let numbers = [0.0, -0.0, 1.0, -1.0, 1e300, 5e-324, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for precision in [Precision::Fast, Precision::Exact] {
        for (i, number) in numbers.iter().enumerate() {
            for k in 0..12 {
                let mut wrong = right;
                wrong.as_flattened_mut()[k] = *number;
                wrong.as_flattened_mut()[(k + i) % 12] = *number;
                let vertices = Strided::new(&wrong, &[0.0, 1.0, 2.0], 1, 1).expect("one each");
                let polygon = Indexed::new(&vertices, &[0, 1, 2]).expect("three");
                let (mut pixels, mut depths) = ([0_u32; 64], [1.0_f32; 64]);
                let mut plane = Plane::new(&mut pixels, 8, 8).expect("64");
                let mut depth = Plane::new(&mut depths, 8, 8).expect("64");
                let mut shader: Closure<'_, u32> =
                    &mut |f| (f.attribute(0) + f.w() + f.inv_w()).to_bits();
                Tiler::new(viewport).set_precision(precision).draw(
                    &polygon.with_placed(&placed),
                    &mut shader,
                    &mut plane,
                    Some(&mut depth),
                );
            }
        }
    }
}
