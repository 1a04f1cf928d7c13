//! Bounding volumes, hierarchies of them and occlusion queries, against every vertex, polygon and
//! pixel that they speak for.

use crate::oracle::shapes::{Tally, check};
use glam::{DMat4, DVec3};
use hyperspan::batch::Batch;
use hyperspan::camera::{DepthConvention, DepthPlanes, look_at, multiply, perspective, transform};
use hyperspan::depth::{Compare, DepthBounds, DepthSource, DepthTest};
use hyperspan::draw::{Frame, Polygons, Screen, With};
use hyperspan::space::{DepthRange, PixelRect};
use hyperspan::{
    BoundingBox, BoundingSphere, Clusters, Hierarchy, Inclusion, Plane, Solid, Tiler, Vertex,
    ViewVolume, Viewport,
};
use proptest::prelude::*;

/// A camera at the origin's side, and a crop of what it sees.
#[derive(Clone, Debug)]
struct Eye {
    matrix: DMat4,
    viewport: Viewport,
    crop: PixelRect,
}

fn eyes() -> impl Strategy<Value = Eye> {
    let from = [-9.0..9.0_f64, -9.0..9.0, 2.0..9.0];
    let convention = prop_oneof![Just(DepthConvention::Standard), Just(DepthConvention::Reversed)];
    let range = prop_oneof![3 => Just(DepthRange::ZeroToOne), 1 => Just(DepthRange::MinusOneToOne)];
    let far = prop_oneof![Just(f64::INFINITY), Just(20.0)];
    let corner = prop_oneof![3 => Just(0), 1 => -5000..5000_i32];
    let crop = [-10..70_i32, -10..70, 0..90, 0..90];
    (from, 20.0..100.0_f64, convention, range, far, corner, crop).prop_map(
        |(from, fov, convention, range, far, corner, [x, y, w, h])| {
            let viewport = Viewport::new(corner, -corner, 64, 64).expect("small");
            let viewport = viewport.with_depth_range(range);
            let planes = DepthPlanes { near: 0.5, far, convention, range };
            let camera = perspective(fov, 1.0, planes).expect("a lens");
            let eye = look_at(DVec3::from_array(from), DVec3::ZERO, DVec3::Y).expect("a direction");
            let size = [w, h].map(i32::unsigned_abs);
            let crop = PixelRect::new(x + corner, y - corner, size[0], size[1]);
            Eye { matrix: multiply(camera, eye), viewport, crop }
        },
    )
}

/// A box as a middle and a half of its sides, and points in it from -1 to 1.
type Part = ([f64; 3], [f64; 3], Vec<[f64; 3]>);

fn parts(points: usize) -> impl Strategy<Value = Part> {
    let side = prop_oneof![3 => 0.01..2.0_f64, 1 => Just(0.0), 1 => 2.0..20.0];
    let middle = prop_oneof![3 => -6.0..6.0_f64, 1 => -40.0..40.0];
    let within = prop_oneof![3 => -1.0..1.0_f64, 1 => Just(-1.0), 1 => Just(1.0)];
    let point = [within.clone(), within.clone(), within];
    let middles = [middle.clone(), middle.clone(), middle];
    (middles, [side.clone(), side.clone(), side], prop::collection::vec(point, points))
}

fn points_of((middle, half, points): &Part) -> Vec<[f64; 3]> {
    let at = |p: &[f64; 3]| [0, 1, 2].map(|k| middle[k] + half[k] * p[k]);
    points.iter().map(at).collect()
}

fn box_of(points: &[[f64; 3]]) -> BoundingBox {
    let mut bounds = BoundingBox::EMPTY;
    points.iter().for_each(|p| bounds.add(*p));
    bounds
}

/// Draws triangles into the crop alone: pixels covered, polygons clipped, and the picture.
fn draw(eye: &Eye, triangles: impl Iterator<Item = [[f64; 3]; 3]>) -> (u64, u64, Vec<u32>) {
    let (width, height) = (eye.crop.x0.abs_diff(eye.crop.x1), eye.crop.y0.abs_diff(eye.crop.y1));
    let mut ids = vec![0_u32; (width * height) as usize];
    let mut target = Plane::new(&mut ids, width, height).expect("its size");
    let mut tiler = Tiler::new(eye.viewport);
    tiler.set_origin(eye.crop.x0, eye.crop.y0);
    for triangle in triangles {
        let vertices = triangle
            .map(|p| Vertex::<0, [f64; 4]>::new(transform(eye.matrix, DVec3::from_array(p)), []));
        let id = triangle.as_flattened().iter().fold(0, |hash: u32, c| {
            hash.wrapping_mul(31).wrapping_add(c.to_bits() as u32 ^ (c.to_bits() >> 32) as u32)
        });
        tiler.draw(&vertices, &mut Solid(id), &mut target, None);
    }
    let stats = tiler.stats();
    (stats.pixels_covered, stats.clipped, ids)
}

fn triangles_of(points: &[[f64; 3]]) -> impl Iterator<Item = [[f64; 3]; 3]> + '_ {
    points.as_chunks::<3>().0.iter().copied()
}

#[test]
fn volumes_outside_draw_nothing_and_nothing_clips_those_inside() {
    let (outside, inside) = (Tally::default(), Tally::default());
    let cases = check(file!(), "volumes", 20000, &(eyes(), parts(18)), |(eye, part)| {
        let points = points_of(&part);
        let (middle, half) = (part.0, part.1);
        let radius = half.iter().map(|h| h * h).sum::<f64>().sqrt() * (1.0 + 1e-15);
        let view = ViewVolume::of_crop(eye.matrix, eye.viewport, eye.crop);
        let sphere = BoundingSphere { centre: middle, radius };
        let (pixels, clipped, _) = draw(&eye, triangles_of(&points));
        for found in [view.include(&box_of(&points)), view.include_sphere(&sphere)] {
            match found {
                Inclusion::Outside => {
                    outside.add(1);
                    prop_assert_eq!(pixels, 0);
                }
                Inclusion::Inside => {
                    inside.add(1);
                    prop_assert_eq!(clipped, 0);
                    for point in &points {
                        let [x, y, z, w] = transform(eye.matrix, DVec3::from_array(*point));
                        prop_assert!(x.abs() <= w && y.abs() <= w && z <= w, "{point:?}");
                    }
                }
                Inclusion::Crossing => {}
            }
        }
        Ok(())
    });
    outside.report("volumes outside", cases / 4);
    inside.report("volumes inside", cases / 50);
}

#[test]
fn volumes_that_are_certain_say_so() {
    let viewport = Viewport::new(0, 0, 64, 64).expect("small");
    let view = ViewVolume::new(DMat4::IDENTITY, viewport);
    let of = |low: [f64; 3], high: [f64; 3]| view.include(&box_of(&[low, high]));
    assert_eq!(of([-0.9, -0.9, 0.1], [0.9, 0.9, 0.9]), Inclusion::Inside);
    assert_eq!(of([-0.9, -0.9, 0.1], [1.1, 0.9, 0.9]), Inclusion::Crossing);
    assert_eq!(of([1.001, -0.9, 0.1], [1.1, 0.9, 0.9]), Inclusion::Outside);
    assert_eq!(of([-0.9, -0.9, -0.2], [0.9, 0.9, -0.1]), Inclusion::Outside);
    assert_eq!(of([f64::NAN; 3], [0.5; 3]), Inclusion::Crossing);
    assert_eq!(view.include(&BoundingBox::EMPTY), Inclusion::Outside);
    // A quarter of the picture sees no other.
    let crop = ViewVolume::of_crop(DMat4::IDENTITY, viewport, PixelRect::new(0, 0, 32, 32));
    let quarter = |x: f64, y: f64| crop.include(&box_of(&[[x, y, 0.5], [x * 0.1, y * 0.1, 0.5]]));
    assert_eq!(quarter(-0.9, 0.9), Inclusion::Inside);
    assert_eq!(quarter(-0.9, -0.9), Inclusion::Outside);
    assert_eq!(quarter(0.9, 0.9), Inclusion::Outside);
    let sphere = |x: f64, radius: f64| {
        view.include_sphere(&BoundingSphere { centre: [x, 0.0, 0.5], radius })
    };
    assert_eq!(sphere(0.0, 0.4), Inclusion::Inside);
    assert_eq!(sphere(1.2, 0.3), Inclusion::Crossing);
    assert_eq!(sphere(1.2, 0.1), Inclusion::Outside);
}

#[test]
fn hierarchies_leave_out_only_what_draws_nothing() {
    let left_out = Tally::default();
    let lists = prop::collection::vec((parts(9), 1..60_usize), 0..40);
    let cases = check(file!(), "hierarchies", 1500, &(eyes(), lists), |(eye, lists)| {
        // Each part several times over, drifting: neighbours in the list are neighbours in space.
        let mut triangles = Vec::new();
        for (part, count) in &lists {
            let points = points_of(part);
            for i in 0..*count {
                let shift = |p: [f64; 3]| [p[0] + 0.05 * i as f64, p[1], p[2]];
                triangles.extend(triangles_of(&points).map(|t| t.map(shift)));
            }
        }
        let hierarchy = Hierarchy::new(triangles.len(), |i, bounds| {
            triangles[i].iter().for_each(|p| bounds.add(*p));
        });
        let view = ViewVolume::of_crop(eye.matrix, eye.viewport, eye.crop);
        let (mut some, mut end) = (Vec::new(), 0);
        for range in hierarchy.visible(&view) {
            prop_assert!(end <= range.start && range.start < range.end, "{range:?} after {end}");
            end = range.end;
            some.extend_from_slice(&triangles[range]);
        }
        prop_assert!(end <= triangles.len());
        left_out.add(triangles.len() - some.len());
        let (all, few) = (draw(&eye, triangles.iter().copied()), draw(&eye, some.into_iter()));
        prop_assert_eq!(all.0, few.0);
        prop_assert!(all.2 == few.2);
        Ok(())
    });
    left_out.report("polygons left out", 100 * cases);
}

/// Triangles with a hierarchy, if they are to be culled.
struct Culled<'a> {
    triangles: Vec<[Vertex<0, [f64; 4]>; 3]>,
    culling: Option<(&'a Hierarchy, &'a ViewVolume)>,
}

impl Batch for Culled<'_> {
    type Polygon<'p>
        = &'p [Vertex<0, [f64; 4]>; 3]
    where
        Self: 'p;

    fn len(&self) -> usize {
        self.triangles.len()
    }

    fn polygon(&self, i: usize) -> Self::Polygon<'_> {
        &self.triangles[i]
    }

    fn clusters(&self) -> Option<Clusters<'_>> {
        self.culling.map(|(hierarchy, view)| Clusters { hierarchy, view, first: 0 })
    }
}

#[test]
fn hierarchies_in_draw_lists_change_no_byte() {
    let outside = Tally::default();
    let lists = prop::collection::vec((parts(9), 1..99_usize), 0..40);
    let cases = check(file!(), "hierarchies_in_lists", 400, &(eyes(), lists), |(eye, lists)| {
        let mut triangles = Vec::new();
        for (part, count) in &lists {
            (0..*count).for_each(|_| triangles.extend(triangles_of(&points_of(part))));
        }
        let hierarchy = Hierarchy::new(triangles.len(), |i, bounds| {
            triangles[i].iter().for_each(|p| bounds.add(*p));
        });
        let view = ViewVolume::of_crop(eye.matrix, eye.viewport, eye.crop);
        let (width, height) =
            (eye.crop.x0.abs_diff(eye.crop.x1), eye.crop.y0.abs_diff(eye.crop.y1));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
        let draw = |parallel: bool, culling| {
            let vertex = |p| Vertex::new(transform(eye.matrix, DVec3::from_array(p)), []);
            let triangles = triangles.iter().map(|t| t.map(vertex)).collect();
            let mut tiler = Tiler::new(eye.viewport);
            tiler.set_origin(eye.crop.x0, eye.crop.y0);
            let mut frame = Frame::new(tiler);
            frame.set_parallel(parallel);
            let mut pixels = vec![0_u8; (width * height) as usize];
            let target = Plane::new(&mut pixels, width, height).expect("its size");
            let screen = Screen { target, depth: None, clear: None };
            let batch = Culled { triangles, culling };
            pool.install(|| frame.draw(screen, &[&Polygons::new(batch, With(Solid(9)))]));
            (pixels, frame.stats())
        };
        let (all, stats) = draw(false, None);
        for parallel in [false, true] {
            let (found, few) = draw(parallel, Some((&hierarchy, &view)));
            prop_assert!(all == found);
            prop_assert_eq!(stats.polygons, few.polygons);
            prop_assert_eq!(stats.pixels_covered, few.pixels_covered);
            outside.add((few.culled.outside - stats.culled.outside) as usize);
        }
        Ok(())
    });
    outside.report("polygons left out of lists", cases);
}

#[test]
fn hierarchies_of_any_size_have_all_polygons() {
    let view = ViewVolume::new(DMat4::IDENTITY, Viewport::new(0, 0, 64, 64).expect("small"));
    for count in [0, 1, 31, 32, 33, 255, 256, 257, 2047, 2048, 2049, 20_000] {
        let hierarchy = Hierarchy::new(count, |i, bounds| {
            // Every 100th group of 50 lies behind.
            let z = if i / 50 % 100 == 99 { -1.0 } else { 0.5 };
            bounds.add([0.0, 0.0, z]);
        });
        let seen: usize = hierarchy.visible(&view).map(|range| range.len()).sum();
        let behind = (0..count).filter(|i| i / 50 % 100 == 99).count();
        assert!(seen <= count && seen >= count - behind, "{seen} of {count}");
        assert!(hierarchy.bytes() <= 2 * count + 2048, "{count}: {}", hierarchy.bytes());
        if count < 5000 {
            assert_eq!(hierarchy.visible(&view).collect::<Vec<_>>().len(), usize::from(count > 0));
        }
        let mut walk = hierarchy.visible(&view);
        assert_eq!(walk.next_run(|_, _| true), None, "all is hidden");
    }
}

/// A buffer that polygons of one depth each have been drawn into.
fn stored(
    viewport: Viewport,
    test: DepthTest,
    rects: &[([f64; 4], f64)],
    draw: impl FnOnce(&mut Plane<'_, f32>),
) {
    let (width, height) = (viewport.width(), viewport.height());
    let clear = if test.compare == Compare::Less { 1.0 } else { 0.0 };
    let mut depths = vec![clear; (width * height) as usize];
    let mut bounds = DepthBounds::new();
    let mut buffer = Plane::new(&mut depths, width, height).expect("its size");
    buffer = buffer.with_bounds(&mut bounds);
    let mut tiler = Tiler::new(viewport);
    tiler.set_depth_test(test);
    let corner = viewport.rect();
    tiler.set_origin(corner.x0, corner.y0);
    for ([x0, y0, x1, y1], depth) in rects {
        let z = match viewport.depth_range() {
            DepthRange::ZeroToOne => *depth,
            DepthRange::MinusOneToOne => 2.0 * depth - 1.0,
        };
        let corners = [[*x0, *y0], [*x1, *y0], [*x1, *y1], [*x0, *y1]];
        let quad = corners.map(|[x, y]| Vertex::<0, [f64; 4]>::new([x, y, z, 1.0], []));
        tiler.draw(&quad, &mut Solid(()), &mut (), Some(&mut buffer));
    }
    draw(&mut buffer);
}

#[test]
fn queries_are_never_wrong_on_the_side_of_hiding() {
    let (hidden, seen) = (Tally::default(), Tally::default());
    let test = prop_oneof![Just(Compare::Less), Just(Compare::Greater)]
        .prop_map(|compare| DepthTest { compare, write: true, source: DepthSource::Z });
    let side = prop_oneof![2 => -1.3..1.3_f64, 1 => Just(-1.0), 1 => Just(1.0)];
    let rect = [side.clone(), side.clone(), side.clone(), side];
    let rects = prop::collection::vec((rect, 0.0..1.0_f64), 0..12);
    let pixels = [-10..70_i32, -10..70, 0..60, 0..60];
    let asked = (pixels, 0.0..1.0_f32, 0.0..0.3_f32);
    let scene = (eyes(), test, rects, prop::collection::vec(parts(40), 4), asked);
    let cases = check(file!(), "queries", 6000, &scene, |(eye, test, rects, parts, asked)| {
        let viewport = eye.viewport;
        let view = ViewVolume::new(eye.matrix, viewport);
        let origin = [viewport.rect().x0, viewport.rect().y0];
        let mut wrong = None;
        stored(viewport, test, &rects, |buffer| {
            let ([x, y, w, h], near, thick) = asked;
            let pixels = PixelRect::new(x, y, w.unsigned_abs(), h.unsigned_abs());
            let depths = [near, near + thick];
            if buffer.surely_hides(pixels, depths, test.compare) {
                let (width, height) = buffer.dimensions();
                let inside = pixels.intersect(PixelRect::new(0, 0, width, height));
                for y in inside.y0..inside.y1 {
                    for x in inside.x0..inside.x1 {
                        hidden.add(1);
                        let stored = buffer.row(y as u32)[x as usize];
                        if depths.iter().any(|depth| test.compare.passes(*depth, stored)) {
                            wrong = Some(format!("pixel {x}, {y}"));
                        }
                    }
                }
            }
            for part in &parts {
                let points = points_of(part);
                let hides = buffer.surely_hides_box(&view, &box_of(&points), origin, test);
                for point in points {
                    let [x, y, z, w] = transform(eye.matrix, DVec3::from_array(point));
                    if !(x.abs() < w && y.abs() < w && z < w) {
                        continue;
                    }
                    let [column, row] = [(x / w + 1.0) * 32.0, (1.0 - y / w) * 32.0];
                    let z = match viewport.depth_range() {
                        DepthRange::ZeroToOne => z / w,
                        DepthRange::MinusOneToOne => (z / w + 1.0) / 2.0,
                    };
                    let stored = buffer.row(row as u32)[column as usize];
                    if !test.compare.passes(z as f32, stored) {
                        continue;
                    }
                    seen.add(1);
                    if hides {
                        wrong = Some(format!("point {point:?}"));
                    }
                }
                hidden.add(usize::from(hides));
            }
        });
        prop_assert_eq!(wrong, None);
        Ok(())
    });
    hidden.report("pixels and boxes hidden", 10 * cases);
    seen.report("points seen", cases);
}
