//! P2 on many pixels: `Exact` correctly rounded, `Fast` within its bound, 1/w, depth and attributes.
//!
//! A million pixels with every run of the tests, a hundred million when asked:
//!
//!     cargo test --release --test promises precision_many -- --ignored --nocapture

use crate::oracle::Poly;
use crate::oracle::plane::quick::{Known, Quick};
use crate::oracle::plane::{Plane, Right};
use crate::oracle::probe::{Closure, View};
use crate::oracle::shapes::scenes;
use hyperspan::depth::DepthTest;
use hyperspan::shade::Solid;
use hyperspan::space::Viewport;
use hyperspan::target::Plane as Target;
use hyperspan::tiler::{Precision, Tiler};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

const U: f64 = 1.0 / 16_777_216.0;

/// What was compared.
#[derive(Debug, Default)]
struct Compared {
    polygons: u64,
    pixels: u64,
    values: u64,
    /// Of them, those that took rational arithmetic.
    by_rationals: u64,
    /// The largest error of `Fast`, as a part of what it may be.
    worst: f64,
}

/// Everything of a pixel that has the same place in both precisions: 1/w, depth, attributes.
fn draw(view: &View, poly: &Poly, numbers: &mut Vec<f32>, places: &mut Vec<(i32, i32)>) {
    let (width, height) = view.size();
    let mut nothing = vec![(); width as usize * height as usize];
    let mut target = Target::new(&mut nothing, width, height).expect("its size");
    numbers.clear();
    places.clear();
    let mut record: Closure<'_, ()> = &mut |f| {
        places.push((f.x(), f.y()));
        numbers.extend([f.inv_w(), f.depth()]);
        numbers.extend((0..f.attribute_count()).map(|k| f.attribute(k)));
    };
    view.tiler().draw(poly, &mut record, &mut target, None);
}

/// The right value by rationals, if there is a promise.
fn settled(plane: &Plane, (x, y): (i32, i32), number: usize) -> Option<Known> {
    let at = plane.at(x, y);
    let right = match number {
        0 => at.inv_w(),
        1 => at.depth(),
        k => at.attribute(k - 2),
    };
    match right {
        Right::Is(rounded) => Some(Known { rounded, value: f64::from(rounded) }),
        Right::Across | Right::Anything => None,
    }
}

/// The error of a value of `Fast`, as a part of what it may be. `range` is what lies between the
/// least and the greatest at the vertices.
fn part_of_bound(number: usize, drawn: f32, right: Known, [low, high]: [f64; 2]) -> f64 {
    if number == 1 {
        return f64::from(drawn.to_bits().abs_diff(right.rounded.to_bits()));
    }
    let error = (f64::from(drawn) - right.value).abs();
    // For what rationals have rounded, and for numbers so small that a bit of f32 is more than the bound.
    let slack = U * right.value.abs() / 1000.0 + f64::from(f32::from_bits(1));
    let most = low.abs().max(high.abs());
    let promised = 4.0 * U * right.value.abs() + 3.0 * U * most;
    let near_zero = 7.0 * U * right.value.abs() + U / 8.0 * most;
    let bound = if low <= 0.0 && 0.0 <= high { promised.min(near_zero) } else { promised } + slack;
    if error == 0.0 { 0.0 } else { error / bound }
}

fn compare(pixels: u64) -> Compared {
    let mut compared = Compared::default();
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let strategy = scenes(20.0);
    let (mut exact, mut fast) = (Vec::new(), Vec::new());
    let (mut places, mut same_places) = (Vec::new(), Vec::new());
    while compared.pixels < pixels {
        let scene = strategy.new_tree(&mut runner).expect("a polygon").current();
        let (view, poly) = (scene.view(), scene.poly);
        draw(&view, &poly, &mut exact, &mut places);
        if places.is_empty() {
            continue;
        }
        let quickly = View { precision: Precision::Fast, ..view.clone() };
        draw(&quickly, &poly, &mut fast, &mut same_places);
        assert_eq!(places, same_places, "coverage depends on precision");
        let plane = Plane::new(&poly, view.viewport, &view.interpolation);
        let Some(quick) = Quick::new(&plane, view.window) else { continue };
        compared.polygons += 1;
        compared.pixels += places.len() as u64;
        let count = 2 + poly.attributes[0].len();
        let ranges: Vec<[f64; 2]> = (0..count)
            .map(|number| {
                let value = |i: usize| match number {
                    0 => 1.0 / poly.positions[i][3],
                    1 => 1.0,
                    k => f64::from(poly.attributes[i][k - 2]),
                };
                let start = [f64::INFINITY, f64::NEG_INFINITY];
                let wider = |[low, high]: [f64; 2], v: f64| [low.min(v), high.max(v)];
                (0..poly.positions.len()).map(value).fold(start, wider)
            })
            .collect();
        let rows = exact.chunks_exact(count).zip(fast.chunks_exact(count));
        for (place, (exact, fast)) in places.iter().zip(rows) {
            let mut known = quick.at(place.0, place.1);
            for number in 0..count {
                let found = known.as_mut().and_then(|known| known.next().flatten());
                let right = found.or_else(|| {
                    let right = settled(&plane, *place, number)?;
                    compared.by_rationals += 1;
                    Some(right)
                });
                let Some(right) = right else { continue };
                compared.values += 1;
                assert_eq!(
                    exact[number].to_bits(),
                    right.rounded.to_bits(),
                    "Exact: value {number} at {place:?} is {right:?}, drawn {:e}: {view:?} {poly:?}",
                    exact[number]
                );
                let part = part_of_bound(number, fast[number], right, ranges[number]);
                assert!(
                    part <= 1.0,
                    "Fast: value {number} at {place:?} is {right:?}, drawn {:e}, {part} of the \
                     bound: {view:?} {poly:?}",
                    fast[number]
                );
                compared.worst = compared.worst.max(if number == 1 { 0.0 } else { part });
            }
        }
    }
    compared
}

#[test]
fn precision_of_a_million_pixels() {
    println!("{:#?}", compare(1_000_000));
}

#[test]
#[ignore = "takes minutes"]
fn precision_of_a_hundred_million_pixels() {
    println!("{:#?}", compare(100_000_000));
}

/// Depth as it is tested and stored, along spans that begin where it is next to nothing: there an
/// error that is small beside the rest of the span is many units of the last place.
#[test]
fn precision_of_stored_depth_next_to_zero() {
    const WIDTH: u32 = 500;
    let viewport = Viewport::new(0, 0, WIDTH, 3).expect("small");
    let mut state = 7_u64;
    let mut random = |least: f64, most: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        least + (most - least) * ((state >> 33) as f64 / f64::from(u32::MAX / 2))
    };
    let mut tiny = 0;
    for case in 0..500 {
        let zero = (random(3.0, 420.0).floor() + 0.5) * 2.0 / f64::from(WIDTH) - 1.0;
        let (slope, off) = (random(0.1, 0.3), random(1e-12, 1e-9));
        let corners = [[-1.0, -1.0], [3.0, -1.0], [-1.0, 3.0]];
        let positions = corners.map(|[x, y]| {
            let w = random(0.5, 2.0);
            [x * w, y * w, slope * (x - zero + off) * w, w]
        });
        let poly = Poly::bare(&positions);
        let depths = [Precision::Fast, Precision::Exact].map(|precision| {
            let mut depths = [1.0_f32; WIDTH as usize * 3];
            let mut buffer = Target::new(&mut depths, WIDTH, 3).expect("its size");
            let mut tiler = Tiler::new(viewport);
            tiler.set_precision(precision).set_depth_test(DepthTest::STANDARD);
            tiler.draw(&poly, &mut Solid(()), &mut (), Some(&mut buffer));
            depths
        });
        for (fast, exact) in depths[0].iter().zip(depths[1]) {
            tiny += usize::from(exact > 0.0 && exact < 1e-8);
            let ulps = fast.to_bits().abs_diff(exact.to_bits());
            assert!(ulps <= 1, "case {case}: {fast:e} is {ulps} units from {exact:e}");
        }
    }
    assert!(tiny > 1000, "only {tiny} depths next to nothing");
}
