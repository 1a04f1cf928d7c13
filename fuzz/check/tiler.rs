//! The whole tiler, on one to three polygons of up to eight vertices with up to five
//! attributes. Nothing panics, and:
//!
//! - nothing is written outside the target, nothing drawn outside the viewport;
//! - each polygon is counted once, each pixel as shaded or hidden;
//! - depth lies in 0..=1, finite attributes in their range over the vertices, flat ones are
//!   the first vertex's, a NaN is the canonical one;
//! - a rotated vertex list, all coordinates times a power of two, a crop, and another
//!   instruction set give the same bits, and so does a tiler that has drawn other things before;
//! - an attribute that is not finite changes nothing else (but where vertices at one place have
//!   several values); nor does leaving them all out;
//! - `Fast` is within its bound of `Exact`;
//! - a draw list, on one thread or several, with bounds of depth or without, with vertices that
//!   were placed before or not, gives the bits and the counts of polygons drawn one by one;
//! - a polygon that no plane cuts covers the pixels that P1 says, in exact integers.

use std::sync::OnceLock;

use hyperspan::depth::{DepthBounds, DepthSource};
use hyperspan::draw::{Frame, Polygons, Screen, With};
use hyperspan::placed::Placed;
use hyperspan::polygon::{Indexed, Strided};
use hyperspan::shade::Solid;
use hyperspan::simd::Simd;
use hyperspan::space::{Grid, Viewport};
use hyperspan::target::Plane;
use hyperspan::tiler::{Cull, Outcome, Precision, Tiler};

use super::bytes::Bytes;
use super::case::Case;
use super::picture::{Framed, Picture, RECORD, record};
use super::shape::{RATIO, Shape};

pub(crate) fn tiler(data: &[u8]) {
    let bytes = &mut Bytes(data);
    let case = Case::new(bytes);
    let mut tiler = Tiler::new(case.viewport);
    let picture = case.draw(&mut tiler);

    // What is flat follows the first vertex: there, let all vertices have its values.
    let mut evened = case.clone();
    for shape in &mut evened.shapes {
        shape.even_out(&case.interpolation);
    }
    let first = 1 + usize::from(bytes.below(7));
    let mut rotated = evened.clone();
    for shape in &mut rotated.shapes {
        *shape = shape.rotated(first);
    }
    let evened = evened.draw(&mut tiler);
    evened.must_equal(&rotated.draw(&mut tiler), "another first vertex");

    let factor = 2.0_f64.powi(bytes.pick(&[-120, -60, -30, -3, -1, 1, 2, 40, 60, 120]));
    let scaled: Option<Vec<Shape>> = case.shapes.iter().map(|s| s.scaled(factor)).collect();
    let by_inv_w = case.depth.is_some_and(|test| test.source == DepthSource::InvW);
    if let (Some(shapes), false) = (scaled, by_inv_w) {
        let scaled = Case { shapes, ..case.clone() };
        picture.must_equal(&scaled.draw(&mut tiler), "times a power of two");
    }

    let levels: Vec<Simd> = Simd::all().map(|(_, simd)| simd).collect();
    let other = Case { simd: bytes.pick(&levels), ..case.clone() };
    picture.must_equal(&other.draw(&mut tiler), "another instruction set");

    let (width, height) = case.size;
    let [x, y] = [width, height].map(|side| u32::from(bytes.byte()) % side);
    let size = [width - x, height - y].map(|side| 1 + u32::from(bytes.byte()) % side);
    let origin = (case.origin.0 + x as i32, case.origin.1 + y as i32);
    let crop = Case { origin, size: (size[0], size[1]), ..case.clone() };
    picture.crop(x, y, size[0], size[1]).must_equal(&crop.draw(&mut tiler), "a crop");

    // Of vertices at one place with several values, all attributes say which one counts.
    let ambiguous = case.shapes.iter().any(Shape::has_copies);
    for k in 0..case.shapes[0].count {
        if !ambiguous && !case.shapes.iter().all(|shape| shape.is_finite(k)) {
            let mut healed = case.clone();
            for shape in &mut healed.shapes {
                let column = shape.attributes.iter_mut().skip(k).step_by(shape.count);
                column.for_each(|a| *a = 0.5);
            }
            let healed = healed.draw(&mut tiler).without(k);
            picture.clone().without(k).must_equal(&healed, "a spoilt attribute");
        }
    }

    let alone = Case { depth: None, ..case.clone() };
    let exact = Case { precision: Precision::Exact, ..alone.clone() }.draw(&mut tiler);
    let fast = Case { precision: Precision::Fast, ..alone }.draw(&mut tiler);
    check_bound(&case, &exact, &fast);

    let mut bare = case.clone();
    for shape in &mut bare.shapes {
        (shape.attributes, shape.count) = (Vec::new(), 0);
    }
    let count = case.shapes[0].count;
    let expected = (0..count).fold(picture, Picture::without);
    expected.must_equal(&bare.draw(&mut tiler), "without attributes");

    for shape in &bare.shapes {
        check_coverage(&bare, shape, &mut tiler);
    }

    check_list(&case, bytes);
}

/// The same polygons in a draw list.
fn check_list(case: &Case, bytes: &mut Bytes<'_>) {
    let [parallel, bounded, placed] = [(); 3].map(|()| bytes.below(2) == 1);
    let mut tiler = Tiler::new(case.viewport);
    let singles = case.draw(&mut tiler);
    let counts = tiler.stats();

    let first = &case.shapes[0];
    let mut all = Shape { positions: Vec::new(), attributes: Vec::new(), ..first.clone() };
    let mut faces: Vec<Vec<u32>> = Vec::new();
    for shape in &case.shapes {
        let start = all.positions.len() as u32;
        faces.push((start..start + shape.positions.len() as u32).collect());
        all.positions.extend(&shape.positions);
        all.attributes.extend(&shape.attributes);
    }
    let vertices = Strided::new(&all.positions, &all.attributes, all.count, all.count)
        .expect("as many as needed");
    let mut places = Placed::new(case.viewport);
    places.set(&all.positions, case.simd);
    let polygon = |face| {
        let polygon = Indexed::new(&vertices, face).expect("faces name vertices");
        if placed { polygon.with_placed(&places) } else { polygon }
    };
    let polygons: Vec<_> = faces.iter().map(|face| polygon(face.as_slice())).collect();

    let (width, height) = case.size;
    let mut pixels = Framed::new(width, height, [0; RECORD], [0xDEAD_BEEF; RECORD]);
    let mut depths = Framed::new(width, height, case.clear, -7.0);
    let mut bounds = DepthBounds::new();
    case.set_up(&mut tiler);
    let mut frame = Frame::new(tiler);
    frame.set_parallel(parallel);
    let call = Polygons::new(polygons, With(record));
    let buffer = case.depth.map(|_| match bounded {
        true => depths.plane().with_bounds(&mut bounds),
        false => depths.plane(),
    });
    let clear = Some(([0; RECORD], case.clear));
    let screen = Screen { target: pixels.plane(), depth: buffer, clear };
    pool().install(|| frame.draw(screen, &[&call]));
    let list = Picture { width, pixels: pixels.inside(), depths: depths.inside() };
    singles.must_equal(&list, "a draw list");
    let stats = frame.stats();
    assert_eq!(stats.polygons, counts.polygons, "polygons of a draw list");
    assert_eq!(stats.pixels_covered, stats.pixels_shaded + stats.pixels_hidden);
    assert!(bounded || stats.culled == counts.culled, "{:?} of a list", stats.culled);
    assert!(bounded || stats.pixels_shaded == counts.pixels_shaded, "pixels of a draw list");
}

/// Three threads for draw lists.
fn pool() -> &'static rayon::ThreadPool {
    static POOL: OnceLock<rayon::ThreadPool> = OnceLock::new();
    POOL.get_or_init(|| rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads"))
}

/// `fast` is within its bound of `exact`.
fn check_bound(case: &Case, exact: &Picture, fast: &Picture) {
    const U: f64 = 1.0 / 16_777_216.0;
    for (p, q) in exact.pixels.iter().zip(&fast.pixels) {
        assert_eq!(p[0], q[0], "coverage depends on the precision");
        assert!(p[1].abs_diff(q[1]) <= 1, "depth is off by more than an ulp");
        for k in 0..case.shapes[0].count {
            // Any of the polygons may have drawn the pixel.
            let columns = case.shapes.iter().flat_map(|shape| shape.column(k));
            let largest = columns.map(|a| f64::from(a).abs()).fold(0.0, f64::max);
            let [a, b] = [p, q].map(|pixel| f64::from(f32::from_bits(pixel[2 + k])));
            // The exact value is known to half an ulp.
            let ulp = 2.0 * U * a.abs().max(f64::from(f32::MIN_POSITIVE));
            let allowed = 4.0 * U * a.abs() + 3.0 * U * largest + ulp;
            let near = a == b || (a - b).abs() <= allowed;
            let spoilt = !case.shapes.iter().all(|shape| shape.is_finite(k));
            assert!(near || spoilt, "attribute {k}: {b:e} is too far from {a:e}");
        }
    }
}

/// Coverage of one polygon against P1, if it is not clipped.
fn check_coverage(case: &Case, shape: &Shape, tiler: &mut Tiler) {
    case.set_up(tiler);
    tiler.set_cull(Cull::None);
    let (width, height) = case.size;
    let mut data = vec![0_u8; (width * height) as usize];
    let mut target = Plane::new(&mut data, width, height).expect("long enough");
    let polygon = Strided::new(&shape.positions, &[], 0, 0).expect("no attributes");
    let outcome = tiler.draw(&polygon, &mut Solid(1), &mut target, None);
    let numbers = || shape.positions.iter().flatten().map(|c| c.abs()).filter(|c| *c > 0.0);
    let least = numbers().fold(f64::INFINITY, f64::min);
    let lost = numbers().any(|c| c / RATIO > least);
    if outcome != Outcome::Drawn || tiler.stats().clipped > 0 || lost {
        return;
    }
    let snapped = snapped(case.viewport, &shape.positions);
    let rect = case.viewport.rect();
    for (i, got) in (0..).zip(data) {
        let (x, y) = (case.origin.0 + i % width as i32, case.origin.1 + i / width as i32);
        let shown = (rect.x0..rect.x1).contains(&x) && (rect.y0..rect.y1).contains(&y);
        let expected = shown && winding(&snapped, x, y) != 0;
        assert_eq!(got != 0, expected, "coverage of {x}, {y} by {:?}", shape.positions);
    }
}

/// Framebuffer positions in 1/65536 of a pixel.
fn snapped(viewport: Viewport, positions: &[[f64; 4]]) -> Vec<[i64; 2]> {
    let rect = viewport.rect();
    let half = [f64::from(viewport.width()) / 2.0, f64::from(viewport.height()) / 2.0];
    let centre = [f64::from(rect.x0) + half[0], f64::from(rect.y0) + half[1]];
    let step = match viewport.grid() {
        Grid::Sixteen => 65536.0,
        Grid::Eight => 256.0,
    };
    let snap = |v: f64| (v * step).round_ties_even() as i64 * (65536.0 / step) as i64;
    let named = positions.iter().filter(|p| p[3] > 0.0);
    named
        .map(|[x, y, _, w]| [snap(x / w * half[0] + centre[0]), snap(centre[1] - y / w * half[1])])
        .collect()
}

/// How often the polygon goes round the centre of a pixel; left and top edges belong to it.
fn winding(polygon: &[[i64; 2]], x: i32, y: i32) -> i32 {
    let [x, y] = [x, y].map(|c| i64::from(c) * 65536 + 32768);
    let mut winding = 0;
    for (i, a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (upper, lower, sign) = if a[1] < b[1] { (*a, b, 1) } else { (b, *a, -1) };
        if upper[1] <= y && y < lower[1] {
            let [dx, dy] = [0, 1].map(|k| i128::from(lower[k] - upper[k]));
            // Is the edge to the left of the centre, or on it?
            let left = dx * i128::from(y - upper[1]) <= dy * i128::from(x - upper[0]);
            winding += if left { sign } else { 0 };
        }
    }
    winding
}
