//! Inputs that break rasterizers, by name. "B" is a triangle that fills the middle of a
//! 64 x 64 picture; "apex" replaces its third vertex.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::time::Instant;

use crate::oracle::coverage::{covered, is_unclipped, snapped};
use crate::oracle::judge;
use crate::oracle::probe::{self, Closure, Picture, View};
use crate::oracle::shapes::unproject;
use crate::oracle::{Poly, exact};
use hyperspan::camera::{self, DepthConvention, DepthPlanes};
use hyperspan::clip::{Clipper, VertexArrays};
use hyperspan::polygon::{Polygon, Strided, Vertex};
use hyperspan::shade::{Fragment, Solid};
use hyperspan::space::{DepthRange, PixelRect, Viewport};
use hyperspan::target::Plane;
use hyperspan::tiler::{Outcome, Tiler};

const B: [[f64; 4]; 3] = [[-0.5, -0.5, 0.5, 1.0], [0.5, -0.5, 0.5, 1.0], [0.0, 0.6, 0.5, 1.0]];
const FULL: usize = 64 * 64;

fn view() -> View {
    View::whole(Viewport::new(0, 0, 64, 64).expect("small"))
}

/// With u, v and one more attribute at three vertices; more vertices get zeros.
fn with_uv(positions: &[[f64; 4]]) -> Poly {
    let attributes = [vec![0.0, 0.0, 5.0], vec![1.0, 0.25, 7.0], vec![0.5, 1.0, -3.0]];
    let zeros = || vec![0.0; 3];
    let list = (0..positions.len()).map(|i| attributes.get(i).cloned().unwrap_or_else(zeros));
    Poly { positions: positions.to_vec(), attributes: list.collect() }
}

fn apex(p: [f64; 4]) -> Poly {
    with_uv(&[B[0], B[1], p])
}

/// Draws into 64 x 64, and compares pixels and values with the oracles.
fn draw(name: &str, poly: &Poly) -> (Outcome, Picture) {
    let (outcome, picture, _) = probe::draw(&view(), poly);
    if poly.positions.len() > 2 && poly.positions.iter().flatten().all(|c| c.is_finite()) {
        let right = judge::coverage(&view(), poly, &picture);
        assert_eq!(right, Ok(()), "{name}");
        if let Err(wrong) = judge::values(&view(), poly, &picture) {
            panic!("{name}: {wrong}");
        }
    }
    (outcome, picture)
}

#[test]
fn nasty_inputs_that_show_nothing() {
    let (line, point) = ([0.125, 0.25, 0.5, 1.0], [0.0, 0.0, 0.5, 1.0]);
    let cases: [(&str, Vec<[f64; 4]>, Outcome); 16] = [
        ("all components negated", B.map(|p| p.map(|c| -c)).to_vec(), Outcome::Outside),
        ("apex (0, 0, 0, 0)", vec![B[0], B[1], [0.0; 4]], Outcome::Degenerate),
        ("all vertices (0, 0, 0, 0)", vec![[0.0; 4]; 3], Outcome::Degenerate),
        ("two vertices (0, 0, 0, 0)", vec![B[0], [0.0; 4], [0.0; 4]], Outcome::Degenerate),
        ("no vertex", vec![], Outcome::Degenerate),
        ("one vertex", vec![B[0]], Outcome::Degenerate),
        ("two vertices", vec![B[0], B[1]], Outcome::Degenerate),
        ("three times the same", vec![point; 3], Outcome::Degenerate),
        ("12 times the same", vec![point; 12], Outcome::Degenerate),
        ("a vertex twice", vec![B[0], B[1], B[1]], Outcome::Degenerate),
        ("collinear", vec![point, line, [0.25, 0.5, 0.5, 1.0]], Outcome::Degenerate),
        ("collinear, w differs", vec![point, line, [0.5, 1.0, 0.5, 2.0]], Outcome::Degenerate),
        ("there and back", vec![B[0], B[1], B[2], B[1]], Outcome::Degenerate),
        ("before the near plane", B.map(|p| [p[0], p[1], -0.1, p[3]]).to_vec(), Outcome::Outside),
        ("beyond the far plane", B.map(|p| [p[0], p[1], 1.1, p[3]]).to_vec(), Outcome::Outside),
        ("to the left", B.map(|p| [p[0] - 2.0, p[1], p[2], p[3]]).to_vec(), Outcome::Outside),
    ];
    for (name, positions, expected) in cases {
        let (outcome, picture) = draw(name, &with_uv(&positions));
        assert!(picture.is_empty(), "{name}");
        assert_eq!(outcome, expected, "{name}");
    }
}

#[test]
fn nasty_positions_that_are_not_finite_are_refused_and_counted() {
    let mut tiler = Tiler::new(view().viewport);
    for bad in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for vertex in 0..3 {
            for component in 0..4 {
                let mut positions = B;
                positions[vertex][component] = bad;
                let (outcome, picture) = draw("not finite", &with_uv(&positions));
                assert_eq!((outcome, picture.len()), (Outcome::Refused, 0));
                tiler.draw(&Poly::bare(&positions), &mut Solid(()), &mut (), None);
            }
        }
    }
    assert_eq!((tiler.stats().polygons, tiler.stats().culled.refused), (48, 48));
    // f32 positions, too.
    let single = [[f32::NAN, 0.0, 0.5, 1.0], [0.5, -0.5, 0.5, 1.0], [0.0, 0.6, 0.5, 1.0]];
    let vertices = single.map(|p| Vertex::new(p, []));
    assert_eq!(tiler.draw(&vertices, &mut Solid(()), &mut (), None), Outcome::Refused);
}

#[test]
fn nasty_scales_have_the_same_bits() {
    let right = draw("B", &with_uv(&B)).1;
    assert!(right.len() > 500);
    let pixels = |picture: &Picture| {
        let bits = |(place, seen): (&(i32, i32), &probe::Seen)| {
            (*place, seen.depth, seen.attributes.clone())
        };
        picture.iter().map(bits).collect::<Vec<_>>()
    };
    for exponent in [-60, -120, 126, -1000, 1000] {
        let scaled = with_uv(&B).scaled(exact::approximate(&exact::power_of_two(exponent)));
        let picture = draw(&format!("B times 2^{exponent}"), &scaled).1;
        assert_eq!(pixels(&picture), pixels(&right), "2^{exponent}");
    }
    // In f32 this is subnormal, and rounded; what is drawn are the rounded positions.
    let tiny = B.map(|p| p.map(|c| f64::from((c * 2.0_f64.powi(-130)) as f32)));
    let picture = draw("B times 2^-130", &with_uv(&tiny)).1;
    assert!(picture.len().abs_diff(right.len()) < 20, "{}", picture.len());
    let vertices = tiny.map(|p| Vertex::new(p.map(|c| c as f32), [0.0, 0.0, 1.0]));
    assert_eq!(probe::draw(&view(), &vertices).1.len(), picture.len());
    let smallest = B.map(|p| p.map(|c| (c * 10.0).trunc() * f64::from_bits(1)));
    assert!(draw("a few times the least number", &with_uv(&smallest)).1.len() > 500);
}

#[test]
fn nasty_vertices_at_infinity_and_behind_the_eye() {
    let distinct = |picture: &Picture, k: usize| {
        picture.values().map(|seen| seen.attributes[k]).collect::<BTreeSet<_>>().len()
    };
    let infinite = draw("apex at infinity", &apex([0.0, 1.0, 0.0, 0.0])).1;
    assert!((0..64).any(|x| infinite.contains_key(&(0, x))), "it reaches the upper side");
    assert!(distinct(&infinite, 0) > 100 && distinct(&infinite, 1) > 40, "u and v vary");
    let negative = draw("apex with w = -0", &apex([0.0, 1.0, 0.0, -0.0])).1;
    assert_eq!(infinite, negative);
    let cases: [(&str, [[f64; 4]; 3]); 8] = [
        ("two at infinity", [B[0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]),
        ("two at infinity, opposite", [B[0], [1.0, 0.1, 0.0, 0.0], [-1.0, 0.1, 0.0, 0.0]]),
        ("one behind", [B[0], B[1], [0.0, 0.6, 0.5, -1.0]]),
        ("one behind, visible", [B[0], B[1], [0.0, 2.0, 0.5, -0.5]]),
        ("one behind, z as well", [B[0], B[1], [0.0, 2.0, -0.5, -0.5]]),
        ("two behind", [B[2], [-1.0, -1.0, -0.5, -0.5], [1.0, -1.0, -0.5, -0.5]]),
        ("two far behind", [B[2], [-1e6, -1e6, -1e6, -1e6], [1e6, -1e6, -1e6, -1e6]]),
        ("on the eye's plane, z negative", [B[0], B[1], [0.0, 1.0, -1.0, 0.0]]),
    ];
    let mut seen = 0;
    for (name, positions) in cases {
        seen += usize::from(!draw(name, &with_uv(&positions)).1.is_empty());
    }
    assert!(seen >= 5, "most of them are in sight: {seen}");
}

#[test]
fn nasty_depths() {
    let at = |z: [f64; 3]| {
        let place = |i: usize| [B[i][0], B[i][1], z[i], B[i][3]];
        with_uv(&[place(0), place(1), place(2)])
    };
    let whole = draw("B", &with_uv(&B)).1.len();
    for (name, z, depth) in [("z = w everywhere", 1.0_f32, 1.0_f32), ("z = 0 everywhere", 0.0, 0.0)]
    {
        let picture = draw(name, &at([f64::from(z); 3])).1;
        assert_eq!(picture.len(), whole, "{name}");
        assert!(picture.values().all(|seen| seen.depth == depth.to_bits()), "{name}");
    }
    let clipped = draw("apex z below 0", &at([0.5, 0.5, -0.5])).1;
    assert!(clipped.len() > 100 && clipped.len() < whole);
    let clipped = draw("apex z beyond w", &at([0.5, 0.5, 1.5])).1;
    assert!(clipped.len() > 100 && clipped.len() < whole);
    let touching = draw("a vertex on the near, one on the far plane", &at([0.0, 1.0, 0.5])).1;
    assert_eq!(touching.len(), whole);
    let minus = draw("z = -0", &at([-0.0; 3])).1;
    assert!(minus.values().all(|seen| seen.depth == 0), "depth is +0");
}

#[test]
fn nasty_covers_are_drawn_everywhere_once() {
    let triangle =
        |m: f64| vec![[-m, -m, 0.5, 1.0], [3.0 * m, -m, 0.5, 1.0], [-m, 3.0 * m, 0.5, 1.0]];
    let quad =
        |m: f64| vec![[-m, -m, 0.5, 1.0], [m, -m, 0.5, 1.0], [m, m, 0.5, 1.0], [-m, m, 0.5, 1.0]];
    let diamond = |m: f64| {
        vec![[-m, 0.0, 0.5, 1.0], [0.0, -m, 0.5, 1.0], [m, 0.0, 0.5, 1.0], [0.0, m, 0.5, 1.0]]
    };
    let lop_sided =
        |m: f64| vec![[-m, -m / 3.0, 0.5, 1.0], [m, -m / 7.0, 0.5, 1.0], [m / 5.0, m, 0.5, 1.0]];
    let (single, double) = (f64::from(f32::MAX) / 4.0, f64::MAX / 4.0);
    for m in [1.0, 1000.0, 1e6, 1e9, 1e15, 1e20, 1e30, 3e38 / 3.0, single, 1e100, 1e300, double] {
        for (name, positions) in [("triangle", triangle(m)), ("quad", quad(m))] {
            let picture = draw(&format!("{name} of {m:e}"), &Poly::bare(&positions)).1;
            assert_eq!(picture.len(), FULL, "{name} of {m:e}");
        }
        if m > 2.0 && m < 1e200 {
            for (name, positions) in [("diamond", diamond(m)), ("lop-sided", lop_sided(m))] {
                let picture = draw(&format!("{name} of {m:e}"), &Poly::bare(&positions)).1;
                assert_eq!(picture.len(), FULL, "{name} of {m:e}");
            }
        }
    }
    // +-3e38, in f32.
    let m = 3e38_f32;
    let quad =
        [[-m, -m], [m, -m], [m, m], [-m, m]].map(|[x, y]| Vertex::new([x, y, 0.5, 1.0], [x]));
    assert_eq!(probe::draw(&view(), &quad).1.len(), FULL);
}

#[test]
fn nasty_attributes() {
    for (name, u, w) in [
        ("u = 3e38 with w = 0.5", 3e38_f32, 0.5),
        ("u = 1e-40", 1e-40, 1.0),
        ("u = -1e-45 with w = 1e30", -1e-45, 1e30),
        ("u = f32::MAX", f32::MAX, 1e-30),
        ("u = infinity", f32::INFINITY, 2.0),
        ("u = -0", -0.0, 3.0),
    ] {
        for ws in [[1.0, 1.0, 1.0], [1.0, 7.0, 0.01]] {
            let positions = [0, 1, 2].map(|i| B[i].map(|c| c * w * ws[i]));
            let mut poly = with_uv(&positions);
            poly.attributes.iter_mut().for_each(|a| a[0] = u);
            let picture = draw(name, &poly).1;
            assert!(picture.len() > 500, "{name}");
            assert!(picture.values().all(|seen| seen.attributes[0] == u.to_bits()), "{name}");
        }
    }
    let right = draw("B", &with_uv(&B)).1;
    for (name, bad) in [("NaN", f32::from_bits(0xFFFF_FFFF)), ("infinity", f32::INFINITY)] {
        for vertex in 0..3 {
            let mut poly = with_uv(&B);
            poly.attributes[vertex][0] = bad;
            let picture = probe::draw(&view(), &poly).1;
            assert_eq!(picture.len(), right.len(), "{name}");
            for (place, seen) in &picture {
                assert_eq!(seen.depth, right[place].depth, "{name}");
                assert_eq!(seen.attributes[1..], right[place].attributes[1..], "{name}");
                assert!(!bad.is_nan() || seen.attributes[0] == 0x7FC0_0000, "{name}");
            }
        }
    }
    // The extremes of f32 side by side, and zeros of both signs.
    for values in
        [[f32::MAX, f32::MIN, 1e-45], [0.0, -0.0, 0.0], [-0.0, 0.0, -0.0], [-0.0, 1.0, -1.0]]
    {
        let mut poly = with_uv(&B);
        poly.attributes.iter_mut().zip(values).for_each(|(a, value)| a[0] = value);
        draw(&format!("{values:?}"), &poly);
    }
}

#[test]
fn nasty_numbers_of_attributes() {
    for count in [0, 1, 17, 10_000] {
        let positions: Vec<[f64; 4]> =
            vec![[-0.1, -0.1, 0.5, 1.0], [0.2, -0.1, 1.0, 2.0], [0.0, 0.1, 0.5, 1.0]];
        let list = |i: usize| (0..count).map(|k| (k * (i + 1) % 101) as f32).collect::<Vec<_>>();
        let poly = Poly { positions: positions.clone(), attributes: (0..3).map(list).collect() };
        let few =
            poly.attributes.iter().map(|a| a.iter().rev().take(9).copied().collect()).collect();
        let few = Poly { positions: positions.clone(), attributes: few };
        let (all, some) = (draw("many attributes", &poly).1, draw("the last nine", &few).1);
        assert!(all.len() > 10);
        for (place, seen) in all {
            assert_eq!(seen.attributes.len(), count);
            let last: Vec<u32> = seen.attributes.iter().rev().take(9).copied().collect();
            assert_eq!(last, some[&place].attributes);
        }
        let numbers: Vec<f32> = poly.attributes.concat();
        let strided = Strided::new(&positions, &numbers, count, count).expect("enough");
        assert_eq!(probe::draw(&view(), &strided).1, probe::draw(&view(), &poly).1);
    }
}

/// Repeated vertices change nothing; nor do vertices within an edge.
#[test]
fn nasty_duplicates() {
    let once = with_uv(&B);
    let right = draw("B", &once).1;
    for times in [2, 3, 40] {
        let list = |i: usize| (0..times).map(move |_| i);
        let order: Vec<usize> = (0..3).flat_map(list).collect();
        let positions = order.iter().map(|&i| B[i]).collect();
        let attributes = order.iter().map(|&i| once.attributes[i].clone()).collect();
        let many = Poly { positions, attributes };
        assert_eq!(draw("repeated vertices", &many).1, right, "{times} times each");
    }
    let middle = [0.0, -0.5, 0.5, 1.0];
    let mut five = with_uv(&[B[0], middle, B[1], B[2]]);
    five.attributes = vec![vec![0.0], vec![1.0], vec![2.0], vec![0.5]];
    let mut three = with_uv(&B);
    three.attributes = vec![vec![0.0], vec![2.0], vec![0.5]];
    assert_eq!(draw("a vertex in an edge", &five).1, draw("without it", &three).1);
}

#[test]
fn nasty_clip_leaves_at_most_a_vertex_more_for_each_plane() {
    let mut clipper = Clipper::new(view().viewport);
    let planes: Vec<[f64; 4]> = (0..8)
        .map(|i| {
            let (s, c) = (f64::from(i) * std::f64::consts::TAU / 8.0).sin_cos();
            [c, s, 0.0, 0.8]
        })
        .collect();
    clipper.set_user_planes(&planes);
    assert_eq!(clipper.plane_count(), 14);
    for n in [3_u32, 4, 5, 12, 100] {
        // A disc far larger than everything, tilted through both depths.
        let mut vertices = VertexArrays::new(1);
        for i in 0..n {
            let (s, c) = (f64::from(i) * std::f64::consts::TAU / f64::from(n)).sin_cos();
            vertices.push([3000.0 * c, 3000.0 * s, 0.5 + 2.0 * c + 3.0 * s, 1.0], [f64::from(i)]);
        }
        clipper.clip(&mut vertices);
        let left = vertices.len();
        assert!(left >= 8 && left <= n as usize + 14, "{left} of {n}");
        for i in 0..left {
            let [x, y, z, w] = vertices.position(i);
            assert!((-1e-9..=w + 1e-9).contains(&z));
            assert!(planes.iter().all(|p| p[0] * x + p[1] * y + p[3] * w > -1e-9));
        }
    }
}

/// Counts how often a vertex is asked for.
struct Counted<'a> {
    poly: &'a Poly,
    reads: Cell<u64>,
}

impl Polygon for Counted<'_> {
    fn len(&self) -> usize {
        self.poly.len()
    }

    fn attribute_count(&self) -> usize {
        self.poly.attribute_count()
    }

    fn position(&self, i: usize) -> [f64; 4] {
        self.reads.set(self.reads.get() + 1);
        self.poly.position(i)
    }

    fn attribute(&self, i: usize, k: usize) -> f32 {
        self.reads.set(self.reads.get() + 1);
        self.poly.attribute(i, k)
    }
}

/// 100,000 vertices of a disc: exact, and ten times the work of 10,000.
#[test]
fn nasty_polygons_of_a_hundred_thousand_vertices() {
    let disc = |n: u32| {
        let place = |i: u32| {
            let (s, c) = (f64::from(i) * std::f64::consts::TAU / f64::from(n)).sin_cos();
            let w = 2.0 + c;
            [0.9 * c * w, 0.9 * s * w, 0.5 * w, w]
        };
        let positions: Vec<_> = (0..n).map(place).collect();
        let attributes = (0..n).map(|i| vec![positions[i as usize][0] as f32]).collect();
        Poly { positions, attributes }
    };
    // The least of three turns, so that what else the machine does is of no account.
    let timed = |poly: &Poly| {
        let turns = [(); 3].map(|()| {
            let begun = Instant::now();
            let picture = probe::draw(&view(), poly).1;
            (begun.elapsed().as_secs_f64(), picture)
        });
        turns.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).expect("three")
    };
    let (small, _) = timed(&disc(10_000));
    let large_disc = disc(100_000);
    let (large, picture) = timed(&large_disc);
    assert!(large < 30.0 * small + 0.2, "{small} s for 10,000, {large} s for 100,000");
    // What is counted does not depend on the machine: each vertex is read a few times.
    for n in [1000, 100_000] {
        let counted = Counted { poly: &disc(n), reads: Cell::new(0) };
        probe::draw(&view(), &counted);
        let reads = counted.reads.get();
        assert!(reads <= 8 * u64::from(n), "{reads} reads of {n} vertices");
    }
    let viewport = view().viewport;
    assert!(is_unclipped(viewport, &large_disc));
    let points = snapped(viewport, &large_disc);
    for y in [3, 4, 20, 32, 59, 60] {
        let right = covered(viewport.grid(), &points, PixelRect::new(0, y, 64, 1));
        let drawn = picture.keys().filter(|(row, _)| *row == y).map(|&(y, x)| (x, y));
        assert_eq!(drawn.collect::<Vec<_>>(), right, "row {y}");
    }
    draw("a disc of 500", &disc(500));
}

/// A floor that reaches infinity, under a reversed depth without a far plane: depth is near/w,
/// and 0 at the horizon.
#[test]
fn nasty_infinite_far_plane() {
    let planes = DepthPlanes {
        near: 1e-3,
        far: f64::INFINITY,
        convention: DepthConvention::Reversed,
        range: DepthRange::ZeroToOne,
    };
    let projection = camera::perspective(60.0, 1.0, planes).expect("a camera").to_cols_array_2d();
    let clip =
        |p: [f64; 4]| [0, 1, 2, 3].map(|r| (0..4).map(|c| projection[c][r] * p[c]).sum::<f64>());
    let floor = [
        clip([-5.0, -1.0, 5.0, 1.0]),
        clip([5.0, -1.0, 5.0, 1.0]),
        clip([1.0, 0.0, -1.0, 0.0]),
        clip([-1.0, 0.0, -1.0, 0.0]),
    ];
    assert_eq!(floor[2][2], 0.0, "the horizon's depth");
    let picture = draw("a floor to the horizon", &Poly::bare(&floor)).1;
    assert!((0..64).all(|x| picture.contains_key(&(33, x)) && !picture.contains_key(&(31, x))));
    for ((y, x), seen) in picture {
        // The eye is 1 above the floor, and sees 1/tan 30 degrees of it at y/w = -1.
        let distance = 3.0_f64.sqrt() / (f64::from(2 * y + 1 - 64) / 64.0);
        let depth = f64::from(f32::from_bits(seen.depth));
        assert!((depth * distance - 1e-3).abs() < 1e-9, "({x}, {y}): {depth:e}");
    }
    // A wall at infinity itself: all of it has depth 0, and w is what it is.
    let wall =
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| clip([x, y, -1.0, 0.0]));
    let picture = draw("a wall at infinity", &Poly::bare(&wall)).1;
    assert_eq!(picture.len(), FULL);
    assert!(picture.values().all(|seen| seen.depth == 0));
    assert!(camera::perspective(60.0, 1.0, DepthPlanes { near: 0.0, ..planes }).is_err());
    let close = DepthPlanes { near: 1e-300, ..planes };
    assert!(camera::perspective(60.0, 1.0, close).is_ok());
}

#[test]
fn nasty_corners_of_the_guard_band() {
    let (far, near) = (32767.0, -32767.0);
    let shapes = [
        vec![[near, near], [near, far], [far, far], [far, near]],
        vec![[near, near], [far, far], [far, near]],
        vec![[near, near], [near, far], [far, near]],
        vec![[near, near], [far, far], [far - 1.0, far]],
        vec![[near, far], [far, near], [far, near + 1.0 / 65536.0]],
        vec![[near, 8000.5], [far, 8000.5], [far, 8001.5]],
        vec![[8000.5, near], [8000.5, far], [8001.5, far]],
    ];
    for side in [16384, 8192, 1] {
        let viewport = Viewport::new(0, 0, side, side).expect("16384 at most");
        for points in &shapes {
            let positions: Vec<_> =
                points.iter().map(|p| unproject(viewport, *p, 0.5, 1.0)).collect();
            let poly = with_uv(&positions);
            let last = i32::try_from(side).expect("small") - 1;
            for [x, y] in
                [[0, 0], [last - 30, 0], [0, last - 30], [last - 30, last - 30], [7990, 7990]]
            {
                let window = PixelRect::new(x, y, 31, 31).intersect(viewport.rect());
                let view = View { window, ..View::whole(viewport) };
                let picture = probe::draw(&view, &poly).1;
                assert_eq!(judge::coverage(&view, &poly, &picture), Ok(()), "{points:?} in {side}");
                judge::values(&view, &poly, &picture).expect("the right values");
            }
        }
    }
}

/// Rows of 16384 pixels, stored.
#[test]
fn nasty_targets_of_16384_pixels() {
    let viewport = Viewport::new(0, 0, 16384, 16384).expect("the largest");
    let cover = [[-1.0, -1.0, 0.5, 1.0], [3.0, -1.0, 0.5, 1.0], [-1.0, 3.0, 0.5, 1.0]];
    let vertices = cover.map(|p| Vertex::new(p, [p[0] as f32, p[1] as f32]));
    for (x, y, width, height) in [(0, 16380, 16384, 4), (16383, 0, 1, 16384), (0, 0, 16384, 2)] {
        let mut data = vec![f32::NAN.to_bits(); width as usize * height as usize];
        let mut target = Plane::new(&mut data, width, height).expect("its size");
        let mut shader: Closure<'_, u32> = &mut |f| {
            // Columns and rows as attributes: the right values are exact in f32.
            assert_eq!(f.attribute(0), (2 * f.x() + 1 - 16384) as f32 / 16384.0);
            assert_eq!(f.attribute(1), (16384 - 2 * f.y() - 1) as f32 / 16384.0);
            (f.attribute(0) + 2.0 * f.attribute(1)).to_bits()
        };
        let mut tiler = Tiler::new(viewport);
        tiler.set_origin(x, y).draw(&vertices, &mut shader, &mut target, None);
        assert!(data.iter().all(|bits| f32::from_bits(*bits).is_finite()));
        assert_eq!(tiler.stats().pixels_covered, u64::from(width) * u64::from(height));
    }
}

#[test]
fn nasty_empty_targets_and_viewports() {
    let vertices = B.map(|p| Vertex::new(p, []));
    for (width, height) in [(0, 0), (0, 5), (5, 0)] {
        let mut tiler = Tiler::new(view().viewport);
        let mut data = [7_u8; 16];
        let mut target = Plane::new(&mut data, width, height).expect("empty");
        tiler.draw(&vertices, &mut Solid(1), &mut target, None);
        assert_eq!(data, [7; 16]);
        let mut tiler = Tiler::new(Viewport::new(0, 0, width, height).expect("empty"));
        let mut target = Plane::new(&mut data, 4, 4).expect("16");
        tiler.draw(&vertices, &mut Solid(1), &mut target, None);
        assert_eq!(data, [7; 16]);
    }
    assert!(Viewport::new(0, 0, 16385, 1).is_err());
    assert!(Viewport::new(0, 0, 1, u32::MAX).is_err());
    // One pixel.
    let one = View::whole(Viewport::new(-3, 9, 1, 1).expect("small"));
    assert_eq!(probe::coverage(&one, &with_uv(&B)), [(-3, 9)]);
}

/// A target without bounds, as far as can be from the viewport.
#[test]
fn nasty_origins() {
    let cover = [[-1.0, -1.0, 0.5, 1.0], [3.0, -1.0, 0.5, 1.0], [-1.0, 3.0, 0.5, 1.0]];
    let cover = Poly::bare(&cover);
    for place in [0, 100, i32::MIN, i32::MAX - 64, i32::MAX - 3] {
        for origin in [i32::MIN, -1, 0, i32::MAX] {
            let mut tiler = Tiler::new(Viewport::new(place, place, 64, 64).expect("small"));
            tiler.set_origin(origin, origin);
            let mut pixels = 0;
            tiler.draw(&cover, &mut |_: &Fragment<'_>| pixels += 1, &mut (), None);
            let end = place.saturating_add(64);
            let side = if origin < end { end - place.max(origin) } else { 0 };
            assert_eq!(pixels, side * side, "{place} from {origin}");
        }
    }
}
