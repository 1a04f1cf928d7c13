//! Draw lists: the bytes of polygons drawn one by one, on any number of threads, in any bands.

use crate::oracle::shapes::{Tally, check};
use hyperspan::batch::{Batch, Mesh};
use hyperspan::depth::{Compare, DepthBounds, DepthTest};
use hyperspan::draw::{Call, Canvas, Frame, Polygons, Screen, With};
use hyperspan::placed::Placed;
use hyperspan::polygon::{Indexed, Polygon, Vertex};
use hyperspan::shade::{BLOCK, Block, Inputs, Shader};
use hyperspan::simd::Simd;
use hyperspan::space::{DepthRange, Viewport};
use hyperspan::stats::Stats;
use hyperspan::target::Plane;
use hyperspan::tiler::{Cull, Precision, Tiler};
use proptest::prelude::*;

type Corner = Vertex<2, [f64; 4]>;

const SIZE: [u32; 2] = [150, 331];

/// The polygon's number and its attributes; some pixels are discarded, unless it has no holes.
#[derive(Clone, Debug, Default)]
struct Numbered<const HOLES: bool = true>(u32);

impl<const HOLES: bool> Shader for Numbered<HOLES> {
    type Pixel = [u32; 3];
    const INPUTS: Inputs = Inputs::attributes(2);
    const KEEPS_ALL: bool = !HOLES;

    fn start(&mut self, i: usize) {
        self.0 = u32::try_from(i).expect("few polygons");
    }

    fn shade(&mut self, block: &Block<'_>, out: &mut [[u32; 3]; BLOCK]) -> u16 {
        let mut kept = 0;
        for (lane, pixel) in out.iter_mut().enumerate() {
            let [a, b] = [0, 1].map(|k| block.attributes[k][lane].to_bits());
            *pixel = [self.0, a, b];
            kept |= u16::from(!HOLES || !b.is_multiple_of(7)) << lane;
        }
        kept
    }
}

/// Polygons of all kinds: small and large, behind the eye, bent, degenerate.
fn polygon() -> impl Strategy<Value = Vec<Corner>> {
    polygon_of(&[0.01, 0.03, 0.2, 2.0])
}

fn polygon_of(sizes: &[f64]) -> impl Strategy<Value = Vec<Corner>> + use<> {
    let near = (-1.2..1.2_f64, -1.2..1.2_f64, 0.0..1.0_f64, 0.2..3.0_f64);
    let size = prop::sample::select(sizes.to_vec());
    let offset = (-1.0..1.0_f64, -1.0..1.0_f64, -0.5..0.5_f64, -1.0..1.0_f64);
    let corner = (offset, prop_oneof![Just(0.5_f32), -9.0..9.0_f32], -1.0..1.0_f32);
    (near, size, prop::collection::vec(corner, 3..7)).prop_map(|((x, y, z, w), size, corners)| {
        let vertex = |((dx, dy, dz, dw), a, b): ((f64, f64, f64, f64), f32, f32)| {
            let position = [x * w + dx * size, y * w + dy * size, z * w + dz * size, w + dw * size];
            Vertex::new(position, [a, b])
        };
        corners.into_iter().map(vertex).collect()
    })
}

/// A picture, and the depths.
type Drawn = (Vec<[u32; 3]>, Vec<u32>);

fn blank() -> (Vec<[u32; 3]>, Vec<f32>) {
    let area = (SIZE[0] * SIZE[1]) as usize;
    (vec![[0; 3]; area], vec![0.25; area])
}

fn bits((picture, depths): (Vec<[u32; 3]>, Vec<f32>)) -> Drawn {
    (picture, depths.iter().map(|depth| depth.to_bits()).collect())
}

fn one_by_one(tiler: &mut Tiler, polygons: &[Vec<Corner>]) -> Drawn {
    let (mut picture, mut depths) = blank();
    depths.fill(1.0);
    let mut target = Plane::new(&mut picture, SIZE[0], SIZE[1]).expect("its size");
    let mut depth = Plane::new(&mut depths, SIZE[0], SIZE[1]).expect("its size");
    let mut shader = Numbered::<true>::default();
    for (i, polygon) in polygons.iter().enumerate() {
        shader.start(i);
        tiler.draw(polygon.as_slice(), &mut shader, &mut target, Some(&mut depth));
    }
    bits((picture, depths))
}

fn in_a_list(frame: &mut Frame, polygons: &[Vec<Corner>]) -> Drawn {
    list_of(frame, polygons, Numbered::<true>::default())
}

/// What is drawn of `batch`, on a canvas that is cleared first.
fn list_of<S>(frame: &mut Frame, batch: &(impl Batch + ?Sized), shader: S) -> Drawn
where
    S: Shader<Pixel = [u32; 3]> + Clone + Sync,
{
    let (mut picture, mut depths) = blank();
    let screen = Screen {
        target: Plane::new(&mut picture, SIZE[0], SIZE[1]).expect("its size"),
        depth: Some(Plane::new(&mut depths, SIZE[0], SIZE[1]).expect("its size")),
        clear: Some(([0; 3], 1.0)),
    };
    frame.draw(screen, &[&Polygons::new(batch, With(shader))]);
    bits((picture, depths))
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads")
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 48,
        failure_persistence: Some(Box::new(
            prop::test_runner::FileFailurePersistence::WithSource("regressions"),
        )),
        ..ProptestConfig::default()
    })]

    /// P3: the same bytes and, but for what is counted at the first band, the same counts.
    #[test]
    fn draw_lists_have_the_bytes_of_polygons_one_by_one(
        polygons in prop::collection::vec(polygon(), 0..60),
        back in any::<bool>(),
        exact in any::<bool>(),
    ) {
        let mut tiler = Tiler::new(Viewport::new(-3, 7, 160, 340).expect("small"));
        tiler.set_origin(2, 11).set_cull(if back { Cull::Back } else { Cull::None });
        tiler.set_precision(if exact { Precision::Exact } else { Precision::Fast });
        let expected = one_by_one(&mut tiler, &polygons);
        let counts = tiler.stats();
        let mut frame = Frame::new(tiler);
        for threads in [1, 2, 5] {
            frame.set_parallel(threads > 1);
            // Twice: buffers that are used again must not show.
            for _ in 0..2 {
                let drawn = pool(threads).install(|| in_a_list(&mut frame, &polygons));
                prop_assert!(drawn == expected, "{} threads", threads);
                let stats = frame.stats();
                prop_assert_eq!(stats.culled, counts.culled);
                prop_assert_eq!(stats.polygons, counts.polygons);
                prop_assert_eq!(stats.clipped, counts.clipped);
                prop_assert_eq!(stats.pixels_covered, counts.pixels_covered);
                prop_assert_eq!(stats.pixels_shaded, counts.pixels_shaded);
            }
        }
    }
}

type Colours<'a> = Screen<'a, Plane<'a, [u32; 3]>>;

/// Calls on one canvas, some of them with holes.
type Calls = Vec<(Vec<Vec<Corner>>, bool)>;

/// Calls of polygons that hide each other: at one depth each, now and then all at the same one.
fn overlapping() -> impl Strategy<Value = Calls> {
    let polygon =
        (polygon_of(&[0.05, 0.6, 2.0, 2.0, 4.0]), prop::option::of(0.0..1.0_f64), 0..4_u32);
    let polygon = polygon.prop_map(|(mut polygon, depth, same)| {
        for Vertex { position: [_, _, z, w], .. } in &mut polygon {
            match (depth, same) {
                (_, 0) => (*z, *w) = (0.5, 1.0),
                (Some(depth), _) => *z = depth * *w,
                _ => {}
            }
        }
        polygon
    });
    prop::collection::vec((prop::collection::vec(polygon, 5..30), prop::bool::weighted(0.2)), 1..4)
}

fn depth_tests() -> impl Strategy<Value = DepthTest> {
    let standard = DepthTest::STANDARD;
    let with = |compare| DepthTest { compare, ..standard };
    prop::sample::select(vec![
        standard,
        DepthTest::REVERSED,
        DepthTest::INV_W,
        with(Compare::LessEqual),
        with(Compare::GreaterEqual),
        with(Compare::NotEqual),
        DepthTest { write: false, ..standard },
    ])
}

/// P6: what is drawn over later is left out where the depths have bounds, and no byte changes:
/// whatever is in the buffer before, and on any number of threads.
#[test]
fn draw_lists_leave_out_what_is_hidden_in_the_end() {
    let (cases, [left_out, _]) = leave_out("hidden_in_the_end", SIZE, 1200);
    left_out.report("lists of which something was left out", cases / 4);
}

/// P6: what long spans cover is not cleared before, and no byte changes.
#[test]
fn draw_lists_do_not_clear_what_they_cover() {
    let (cases, [_, not_cleared]) = leave_out("not_cleared", [1400, 35], 600);
    not_cleared.report("lists of which something was not cleared", cases / 10);
}

/// A triangle that begins above the target was taken for one that has no rows: its own were not cleared.
#[test]
fn draw_lists_clear_under_small_polygons_at_the_edge() {
    let corner = |x: f64, y: f64| Vertex::new([x, y, 0.25, 1.0], [1.0, 1.0]);
    // It lies within the view, and the target's first row runs through its middle.
    let viewport = Viewport::new(0, 0, SIZE[0], SIZE[1] + 40).expect("small");
    let middle = 1.0 - 2.0 * 20.0 / f64::from(viewport.height());
    let triangle =
        vec![corner(-0.9, middle), corner(-0.95, middle - 0.02), corner(-0.95, middle + 0.02)];
    let calls: Calls = vec![(vec![triangle], false)];
    let area = (SIZE[0] * SIZE[1]) as usize;
    let draw = |skips: bool| {
        let mut tiler = Tiler::new(viewport);
        tiler.set_origin(0, 20).set_hidden_skips(skips);
        let (mut bounds, mut picture, mut depths) =
            (DepthBounds::new(), vec![[9; 3]; area], vec![0.0; area]);
        let screen = Screen {
            target: Plane::new(&mut picture, SIZE[0], SIZE[1]).expect("its size"),
            depth: Some(
                Plane::new(&mut depths, SIZE[0], SIZE[1])
                    .expect("its size")
                    .with_bounds(&mut bounds),
            ),
            clear: Some(([0; 3], 1.0)),
        };
        draw_calls(&mut Frame::new(tiler), screen, &calls);
        bits((picture, depths))
    };
    let (drawn, expected) = (draw(true), draw(false));
    assert!(drawn == expected);
    assert!(drawn.0.iter().any(|pixel| *pixel != [0; 3]), "it covers something");
}

/// What lies far apart in a large target is sorted into bands by a single thread, too: no byte changes, nor what
/// is counted.
#[test]
fn draw_lists_that_are_scattered_are_sorted() {
    const SIDE: u32 = 1024;
    let area = (SIDE * SIDE) as usize;
    let polygon = |i: usize| {
        let n = 3 + i % 4;
        let [x, y] = [0.754_877_666, 0.569_840_291].map(|g| 2.0 * (i as f64 * g % 1.0) - 1.0);
        let corner = |k: usize| {
            let angle = k as f64 * std::f64::consts::TAU / n as f64;
            let (dx, dy) = (libm::cos(angle) * 0.05, libm::sin(angle) * 0.05);
            let w = 1.0 + 0.2 * dx + (i % 7) as f64 * 0.1;
            let z = ((i * 37 % 100) as f64 / 100.0 + dy) * w;
            Vertex::new([(x + dx) * w, (y + dy) * w, z, w], [i as f32, k as f32])
        };
        (0..n).map(corner).collect::<Vec<_>>()
    };
    let scattered: Vec<_> = (0..1500).map(polygon).collect();
    // The same ones, from the top down: these are not sorted.
    let mut in_order = scattered.clone();
    in_order.sort_by(|a, b| {
        (b[0].position[1] / b[0].position[3]).total_cmp(&(a[0].position[1] / a[0].position[3]))
    });
    for precision in [Precision::Fast, Precision::Exact] {
        let mut bytes = Vec::new();
        for polygons in [&scattered, &in_order] {
            let blank = || (vec![[0; 3]; area], vec![1.0_f32; area]);
            let mut tiler = Tiler::new(Viewport::new(0, 0, SIDE, SIDE).expect("small"));
            tiler.set_precision(precision);
            let (mut picture, mut depths) = blank();
            let mut target = Plane::new(&mut picture, SIDE, SIDE).expect("its size");
            let mut depth = Plane::new(&mut depths, SIDE, SIDE).expect("its size");
            let mut shader = Numbered::<true>::default();
            for (i, polygon) in polygons.iter().enumerate() {
                shader.start(i);
                tiler.draw(polygon.as_slice(), &mut shader, &mut target, Some(&mut depth));
            }
            let (expected, counts) = (bits((picture, depths)), tiler.stats());
            let mut frame = Frame::new(tiler);
            let (mut picture, mut depths) = blank();
            let screen = Screen {
                target: Plane::new(&mut picture, SIDE, SIDE).expect("its size"),
                depth: Some(Plane::new(&mut depths, SIDE, SIDE).expect("its size")),
                clear: Some(([0; 3], 1.0)),
            };
            let batch = polygons.as_slice();
            frame.draw(screen, &[&Polygons::new(batch, With(Numbered::<true>::default()))]);
            assert!(bits((picture, depths)) == expected, "{precision:?}");
            bytes.push(frame.stats().peak_bytes);
            let of = |stats: Stats| Stats { peak_bytes: 0, spans: 0, ..stats };
            assert_eq!(of(frame.stats()), of(counts));
        }
        // A word for each polygon at least.
        assert!(bytes[0] > bytes[1] + 4 * 1500, "{bytes:?} bytes, if it was sorted and if not");
    }
}

/// How many cases were tried, and of them lists that leave something out, and such that do not clear all, on
/// canvases of this size.
fn leave_out(name: &'static str, [width, height]: [u32; 2], cases: u32) -> (u64, [Tally; 2]) {
    let stored = prop_oneof![Just(f32::NAN), Just(0.0_f32), Just(1.0), 0.0..1.0_f32];
    let clear =
        prop_oneof![3 => Just(0.0_f32), 3 => Just(1.0), 2 => 0.0..1.0_f32, 1 => Just(f32::NAN)];
    let clear = prop::option::weighted(0.8, clear);
    let strategy = (overlapping(), depth_tests(), any::<bool>(), stored, clear);
    let (left_out, not_cleared) = (Tally::default(), Tally::default());
    let cases = check(file!(), name, cases, &strategy, |case| {
        let (calls, test, exact, stored, clear) = case;
        let area = (width * height) as usize;
        let frame = |skips: bool| {
            let mut tiler =
                Tiler::new(Viewport::new(-3, 7, width + 10, height + 9).expect("small"));
            tiler.set_origin(2, 11).set_depth_test(test).set_hidden_skips(skips);
            tiler.set_precision(if exact { Precision::Exact } else { Precision::Fast });
            Frame::new(tiler)
        };
        let draw = |frame: &mut Frame| {
            let mut bounds = DepthBounds::new();
            let mut picture = vec![[9; 3]; area];
            let mut depths: Vec<f32> =
                (0..area).map(|i| if i % 1000 < 300 { stored } else { 0.4 }).collect();
            let (mut shaded, mut not_cleared) = (0, 0);
            // The second time over the first, without a clear.
            for clear in [clear, None] {
                let depth = Plane::new(&mut depths, width, height).expect("its size");
                let screen = Screen {
                    target: Plane::new(&mut picture, width, height).expect("its size"),
                    depth: Some(depth.with_bounds(&mut bounds)),
                    clear: clear.map(|depth| ([0; 3], depth)),
                };
                draw_calls(frame, screen, &calls);
                shaded += frame.stats().pixels_shaded;
                not_cleared += frame.stats().pixels_not_cleared;
            }
            (bits((picture, depths)), shaded, not_cleared)
        };
        let (expected, all, none) = draw(&mut frame(false));
        prop_assert_eq!(none, 0, "all is cleared");
        let mut skipping = frame(true);
        for threads in [1, 3] {
            skipping.set_parallel(threads > 1);
            let (drawn, shaded, some) = pool(threads).install(|| draw(&mut skipping));
            prop_assert!(drawn == expected, "{} threads", threads);
            left_out.add(usize::from(shaded < all));
            not_cleared.add(usize::from(some > 0));
        }
        Ok(())
    });
    (cases, [left_out, not_cleared])
}

fn draw_calls<'a>(frame: &mut Frame, screen: Colours<'a>, calls: &'a Calls) {
    fn call<'a>(
        (polygons, holes): &'a (Vec<Vec<Corner>>, bool),
    ) -> Box<dyn Call<Colours<'a>> + 'a> {
        let polygons = polygons.as_slice();
        if *holes {
            Box::new(Polygons::new(polygons, With(Numbered::<true>::default())))
        } else {
            Box::new(Polygons::new(polygons, With(Numbered::<false>::default())))
        }
    }
    let list: Vec<_> = calls.iter().map(call).collect();
    let list: Vec<&dyn Call<Colours<'_>>> = list.iter().map(|call| &**call).collect();
    frame.draw(screen, &list);
}

/// A small triangle or quadrilateral: polygons of a batch need not have as many attributes.
#[derive(Clone, Debug)]
struct Small {
    positions: Vec<[f64; 4]>,
    attributes: Vec<[f32; 3]>,
    count: usize,
}

impl Polygon for Small {
    fn len(&self) -> usize {
        self.positions.len()
    }

    fn attribute_count(&self) -> usize {
        self.count
    }

    fn position(&self, i: usize) -> [f64; 4] {
        self.positions[i]
    }

    fn attribute(&self, i: usize, k: usize) -> f32 {
        self.attributes[i][k]
    }
}

/// What is unusual about a small polygon's corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Any,
    /// One lies at a pixel's centre, where depth is 0, or so little that it is in doubt.
    AtCentre,
    /// All do, and at other pixels depths and attributes lie halfway between two `f32`.
    Ties,
}

/// Where the fourth corner of a quadrilateral is, opposite to the first of three: by so much of the sides from
/// there; and how far it, and its attributes, are off their planes, by the length of one.
type Fourth = ([f64; 2], [f64; 2]);

/// Parallelograms, other flat ones with affine attributes, and such that are neither, or not convex.
fn fourth() -> impl Strategy<Value = Option<Fourth>> {
    let off = || prop_oneof![6 => Just(0.0), 2 => -0.002..0.002_f64, 1 => -1.0..1.0_f64];
    let along = prop_oneof![
        3 => Just([1.0, 1.0]),
        4 => [0.4..2.0_f64, 0.6..2.0],
        2 => [-0.5..1.0_f64, -0.5..1.0],
    ];
    prop::option::of((along, [off(), off()]))
}

/// Small triangles and quadrilaterals with much that is unusual: corners one above the other, depths and w of
/// all sizes or the same all over, attributes that are the same, zeros of both signs, tiny, huge or no numbers.
fn small() -> impl Strategy<Value = Small> {
    let place = (-0.9..0.9_f64, -0.9..0.9_f64);
    let step = prop_oneof![1 => Just(0.0), 4 => -0.03..0.03_f64];
    let depth = prop_oneof![Just(0.0), Just(0.3), 0.0..1.0_f64, 0.0..1e-7_f64, Just(1e-38)];
    let w = prop_oneof![6 => Just(1.0), 6 => 0.5..2.0_f64, 1 => Just(1e-25), 1 => Just(1e25)];
    let corner = ([step.clone(), step], depth, prop_oneof![Just(1.0), 0.9..1.1_f64]);
    let usual = prop_oneof![Just(0.5_f32), -9.0..9.0_f32];
    let odd =
        prop::sample::select(vec![-0.0_f32, 0.0, 1e-40, 1e-30, 3e38, f32::INFINITY, f32::NAN]);
    let attribute = prop_oneof![Just(None), Just(Some(3_usize)), (0..3_usize).prop_map(Some)];
    let values = prop::collection::vec((prop_oneof![9 => usual, 1 => odd], attribute), 9);
    let corners = prop::collection::vec(corner, 3);
    let count = prop_oneof![8 => Just(2_usize), 1 => 0..4_usize];
    let kind = prop_oneof![6 => Just(Kind::Any), 2 => Just(Kind::AtCentre), 1 => Just(Kind::Ties)];
    let unusual = (any::<bool>(), kind, 0..8_usize);
    (place, w, corners, values, unusual, count, fourth()).prop_map(
        |(
            (mut x, mut y),
            mut w,
            mut corners,
            mut values,
            (mut level, kind, turn),
            count,
            fourth,
        )| {
            if kind != Kind::Any {
                (x, y) = (((x * 80.0).floor() + 0.5) / 80.0, ((y * 170.0).floor() + 0.5) / 170.0);
                (corners[0].0, corners[0].1) = ([0.0; 2], 0.0);
            }
            if kind == Kind::Ties {
                (w, level) = (1.0, false);
                let ends = [[0.0, 0.0], [4.0 / 80.0, 0.0], [0.0, 4.0 / 170.0]];
                for (i, (corner, [dx, dy])) in corners.iter_mut().zip(ends).enumerate() {
                    let more = if i == 0 { 0.0 } else { 1.0 };
                    *corner = ([dx, dy], 0.5 + more / 16_777_216.0, 1.0);
                    values[3 * i] = (16_777_216.0 + 2.0 * more as f32, None);
                }
            }
            let mut positions = Vec::from([0, 1, 2].map(|i| {
                let ([dx, dy], z, dw) = corners[i];
                let (z, w) = if level { (corners[0].1, w) } else { (z, w * dw) };
                [(x + dx) * w, (y + dy) * w, z * w, w]
            }));
            // Now and then that of another corner.
            let mut attributes = Vec::from([0, 1, 2].map(|i| {
                [0, 1, 2].map(|k| match values[3 * i + k] {
                    (_, Some(from)) if from < 3 => values[3 * from + k].0,
                    (value, _) => value,
                })
            }));
            if let Some(([s, t], [off_z, off])) = fourth {
                let at = |[a, b, c]: [f64; 3]| a + s * (b - a) + t * (c - a);
                let mut position = [0, 1, 2, 3].map(|k| at([0, 1, 2].map(|i| positions[i][k])));
                position[2] += off_z * (positions[1][0] - positions[0][0]);
                let value = |k: usize| {
                    let [a, b, c] = [0, 1, 2].map(|i| f64::from(attributes[i][k]));
                    // What is the same all over stays so.
                    (at([a, b, c]) + off * (b - a)) as f32
                };
                let values = [value(0), value(1), value(2)];
                positions.insert(2, position);
                attributes.insert(2, values);
                if turn >= 4 {
                    positions.reverse();
                    attributes.reverse();
                }
                positions.rotate_left(turn % 4);
                attributes.rotate_left(turn % 4);
            }
            Small { positions, attributes, count }
        },
    )
}

/// P3: small polygons that are set up together are what they are alone, and what they are where a shader
/// asks for w, which no way of theirs knows.
#[test]
fn draw_lists_of_small_polygons_of_any_kind() {
    let strategy = (
        prop::collection::vec(small(), 1..120),
        depth_tests(),
        prop::sample::select(vec![Cull::None, Cull::Back, Cull::Front]),
        any::<bool>(),
        prop::sample::select(vec![Precision::Fast, Precision::Exact]),
        any::<bool>(),
    );
    let (seen, exactly) = (Tally::default(), Tally::default());
    let cases = check(file!(), "small_of_any_kind", 150, &strategy, |case| {
        let (mut polygons, test, cull, minus_one, precision, alike) = case;
        // One that has not as many attributes as the first of eight goes the way of any polygon, whose bounds
        // leave other values of `Exact` in doubt.
        if alike {
            polygons.iter_mut().for_each(|polygon| polygon.count = 2);
        }
        let mut counted = None;
        for (name, simd) in Simd::all() {
            let mut viewport = Viewport::new(-3, 7, 160, 340).expect("small");
            if minus_one {
                viewport = viewport.with_depth_range(DepthRange::MinusOneToOne);
            }
            let mut tiler = Tiler::new(viewport);
            tiler.set_origin(2, 11).set_depth_test(test).set_cull(cull).set_simd(simd);
            let area = (SIZE[0] * SIZE[1]) as usize;
            tiler.set_precision(precision);
            let (any, _) = small_ones(&mut tiler, &polygons, Three::<true>::default());
            tiler.reset_stats();
            let (expected, stats) = small_ones(&mut tiler, &polygons, Three::<false>::default());
            prop_assert!(any == expected, "{}, one by one", name);
            counted = Some(stats);
            let mut frame = Frame::new(tiler);
            for (threads, bounded) in [(1, false), (1, true), (2, true)] {
                let (mut picture, mut depths) = (vec![[0; 3]; area], vec![0.5_f32; area]);
                let mut bounds = DepthBounds::new();
                let mut depth = Plane::new(&mut depths, SIZE[0], SIZE[1]).expect("its size");
                if bounded {
                    depth = depth.with_bounds(&mut bounds);
                }
                let target = Plane::new(&mut picture, SIZE[0], SIZE[1]).expect("its size");
                let screen = Screen { target, depth: Some(depth), clear: None };
                frame.set_parallel(threads > 1);
                let call = Polygons::new(polygons.as_slice(), With(Three::<false>::default()));
                pool(threads).install(|| frame.draw(screen, &[&call]));
                prop_assert!(bits((picture, depths)) == expected, "{}, {} threads", name, threads);
                if !bounded && (alike || precision == Precision::Fast) {
                    prop_assert_eq!(frame.stats().constant_w, stats.constant_w);
                    prop_assert_eq!(frame.stats().exact_values, stats.exact_values);
                }
            }
        }
        // Of one instruction set: what is expected must not depend on how many the machine has.
        let stats = counted.expect("scalars at least");
        seen.add(usize::from(stats.pixels_shaded > 20));
        exactly.add(usize::from(stats.exact_values > 0));
        Ok(())
    });
    seen.report("lists that are seen", cases / 2);
    exactly.report("lists with values found exactly", cases / 8);
}

/// What `polygons` are on a canvas of [`SIZE`].
fn small_ones(
    tiler: &mut Tiler,
    polygons: &[Small],
    mut shader: impl Shader<Pixel = [u32; 3]>,
) -> (Drawn, Stats) {
    let area = (SIZE[0] * SIZE[1]) as usize;
    let (mut picture, mut depths) = (vec![[0; 3]; area], vec![0.5_f32; area]);
    let mut target = Plane::new(&mut picture, SIZE[0], SIZE[1]).expect("its size");
    let mut depth = Plane::new(&mut depths, SIZE[0], SIZE[1]).expect("its size");
    for (i, polygon) in polygons.iter().enumerate() {
        shader.start(i);
        tiler.draw(polygon, &mut shader, &mut target, Some(&mut depth));
    }
    (bits((picture, depths)), tiler.stats())
}

/// The polygon's number and the bits of up to three attributes. `W`: does it ask for w?
#[derive(Clone, Debug, Default)]
struct Three<const W: bool = false>(u32);

impl<const W: bool> Shader for Three<W> {
    type Pixel = [u32; 3];
    const INPUTS: Inputs = Inputs { w: W, ..Inputs::attributes(3) };
    const KEEPS_ALL: bool = true;

    fn start(&mut self, i: usize) {
        self.0 = u32::try_from(i).expect("few polygons");
    }

    fn shade(&mut self, block: &Block<'_>, out: &mut [[u32; 3]; BLOCK]) -> u16 {
        for (lane, pixel) in out.iter_mut().enumerate() {
            *pixel = [self.0; 3];
            for (part, lanes) in pixel.iter_mut().zip(block.attributes) {
                *part = part.wrapping_mul(31).wrapping_add(lanes[lane].to_bits());
            }
        }
        u16::MAX
    }
}

/// All in few rows: then bands are cut into parts. On every instruction set.
#[test]
fn draw_lists_in_a_single_band_are_shared_out() {
    let at = |i: usize, x: f64, y: f64| {
        let k = i as f64;
        [-0.95 + 0.011 * (k % 160.0) + x, 0.02 * (k * 0.37 % 1.0) + y, 0.5 + 0.0001 * k, 1.0]
    };
    let triangle = |i: usize| {
        let vertex = |x: f64, y: f64, a: f32| Vertex::new(at(i, x, y), [a, i as f32]);
        vec![vertex(0.0, 0.0, 1.0), vertex(0.05, 0.0, 2.0), vertex(0.0, 0.04, 3.0)]
    };
    let polygons: Vec<Vec<Corner>> = (0..20_000).map(triangle).collect();
    let viewport = Viewport::new(0, 0, SIZE[0], SIZE[1]).expect("small");
    let expected = one_by_one(&mut Tiler::new(viewport), &polygons);
    for (name, simd) in Simd::all() {
        let mut tiler = Tiler::new(viewport);
        tiler.set_simd(simd);
        let mut frame = Frame::new(tiler);
        frame.set_parallel(true);
        let drawn = pool(4).install(|| in_a_list(&mut frame, &polygons));
        assert!(drawn == expected, "{name}");
        assert_eq!(frame.stats().polygons, 20_000);
    }
}

/// Faces that share vertices, with and without their places.
#[test]
fn draw_lists_of_meshes() {
    let n = 40_u32;
    let vertex = |i: u32| {
        let (x, y) = (f64::from(i % n) / 20.0 - 1.0, f64::from(i / n) / 20.0 - 1.0);
        Vertex::new([x * 1.1, y, 0.3, 1.0 + 0.2 * x * y], [i as f32, y as f32])
    };
    let vertices: Vec<Corner> = (0..n * n).map(vertex).collect();
    let corner = |x: u32, y: u32| y * n + x;
    let faces: Vec<[u32; 3]> = (0..(n - 1) * (n - 1))
        .flat_map(|i| {
            let (x, y) = (i % (n - 1), i / (n - 1));
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(u, v)| corner(x + u, y + v));
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let viewport = Viewport::new(0, 0, SIZE[0], SIZE[1]).expect("small");
    let positions: Vec<_> = vertices.iter().map(|vertex| vertex.position).collect();
    let mut placed = Placed::new(viewport);
    placed.set(&positions, Simd::auto());
    let mesh = || Mesh::new(vertices.as_slice(), &faces).expect("all there");
    assert_eq!(mesh().len(), faces.len());
    let polygons: Vec<Vec<Corner>> =
        faces.iter().map(|face| face.map(|i| vertices[i as usize]).to_vec()).collect();
    let expected = one_by_one(&mut Tiler::new(viewport), &polygons);
    for (mesh, threads) in [(mesh(), 1), (mesh().with_placed(&placed), 1), (mesh(), 3)] {
        let mut frame = Frame::new(Tiler::new(viewport));
        frame.set_parallel(threads > 1);
        let shader = Numbered::<true>::default();
        let drawn = pool(threads).install(|| list_of(&mut frame, &mesh, shader));
        assert!(drawn == expected, "{threads} threads");
    }
}

/// A polygon that owns the places of its vertices, and is made when it is asked for.
struct Owner {
    triangle: Small,
    placed: Placed,
}

impl Polygon for Owner {
    fn len(&self) -> usize {
        3
    }

    fn attribute_count(&self) -> usize {
        self.triangle.count
    }

    fn position(&self, i: usize) -> [f64; 4] {
        self.triangle.positions[i]
    }

    fn attribute(&self, i: usize, k: usize) -> f32 {
        self.triangle.attributes[i][k]
    }

    fn placed(&self) -> Option<&Placed> {
        Some(&self.placed)
    }
}

/// Small triangles placed for one viewport and another by turns.
struct Owners([Viewport; 2]);

impl Owners {
    fn triangle(i: usize) -> Small {
        let (x, y) = ((i % 20) as f64 * 0.09 - 0.9, (i / 20) as f64 * 0.09 - 0.9);
        let corner = |dx: f64, dy: f64| [x + dx, y + dy, 0.5, 1.0];
        let positions = [corner(0.0, 0.0), corner(0.04, 0.01), corner(0.01, 0.03)];
        Small { positions: positions.to_vec(), attributes: vec![[1.0, 2.0, 3.0]; 3], count: 2 }
    }
}

impl Batch for Owners {
    type Polygon<'a> = Owner;

    fn len(&self) -> usize {
        400
    }

    fn polygon(&self, i: usize) -> Owner {
        let triangle = Self::triangle(i);
        let mut placed = Placed::new(self.0[i % 2]);
        placed.set(&triangle.positions, Simd::auto());
        Owner { triangle, placed }
    }
}

/// Places of another viewport are not used, wherever they lie in memory.
#[test]
fn draw_lists_of_polygons_that_own_their_places() {
    let viewport = Viewport::new(0, 0, SIZE[0], SIZE[1]).expect("small");
    let other = Viewport::new(0, 0, 2 * SIZE[0], SIZE[1]).expect("small");
    let triangles: Vec<Small> = (0..400).map(Owners::triangle).collect();
    let mut frame = Frame::new(Tiler::new(viewport));
    frame.set_parallel(false);
    let expected = list_of(&mut frame, triangles.as_slice(), Three::<false>::default());
    assert!(frame.stats().pixels_shaded > 400);
    for viewports in [[viewport, other], [other, viewport], [other; 2]] {
        assert!(list_of(&mut frame, &Owners(viewports), Three::<false>::default()) == expected);
    }
}

/// What they cover is asked for before they are drawn: places beyond the target on all four sides, too.
#[test]
fn draw_lists_of_octagons_far_from_each_other() {
    let vertex = |i: u32| {
        let (octagon, corner) = (i / 8, f64::from(i % 8) * std::f64::consts::FRAC_PI_4);
        let (x, y) = (f64::from(octagon % 37) / 18.0 - 1.0, 1.0 - f64::from(octagon % 13) / 100.0);
        let (x, y) = (x * 0.87, if octagon.is_multiple_of(2) { y } else { -y } * 0.87);
        let (dx, dy) = (0.12 * corner.cos(), 0.08 * corner.sin());
        let z = 0.5 + f64::from(octagon % 5) * 0.01 + dx * 0.1;
        Vertex::new([x + dx, y + dy, z, 1.0], [dx as f32, octagon as f32])
    };
    let vertices: Vec<Corner> = (0..8 * 200).map(vertex).collect();
    let faces: Vec<[u32; 8]> =
        (0..200).map(|i| [0, 1, 2, 3, 4, 5, 6, 7].map(|k| 8 * i + k)).collect();
    let polygons: Vec<Vec<Corner>> = vertices.chunks(8).map(<[Corner]>::to_vec).collect();
    let viewport = Viewport::new(-3, 7, 160, 340).expect("small");
    let positions: Vec<_> = vertices.iter().map(|vertex| vertex.position).collect();
    let mut placed = Placed::new(viewport);
    placed.set(&positions, Simd::auto());
    let mesh = Mesh::new(vertices.as_slice(), &faces).expect("all there").with_placed(&placed);
    for precision in [Precision::Fast, Precision::Exact] {
        let mut tiler = Tiler::new(viewport);
        tiler.set_origin(2, 11).set_precision(precision);
        let expected = one_by_one(&mut tiler, &polygons);
        let shaded = tiler.stats().pixels_shaded;
        assert!(shaded > 5000, "{shaded}");
        for threads in [1, 3] {
            let mut frame = Frame::new(Tiler::new(viewport));
            frame.set_parallel(threads > 1);
            frame.settings().set_origin(2, 11).set_precision(precision);
            let shader = Numbered::<true>::default();
            assert!(pool(threads).install(|| list_of(&mut frame, &mesh, shader)) == expected);
        }
    }
}

/// Placed polygons of no vertices, one, two and so on.
#[test]
fn draw_lists_of_placed_polygons_of_any_length() {
    let viewport = Viewport::new(0, 0, SIZE[0], SIZE[1]).expect("small");
    let vertex = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::FRAC_PI_4;
        Vertex::new([0.8 * angle.cos(), 0.8 * angle.sin(), 0.5, 1.0], [i as f32, 0.5])
    };
    let vertices: Vec<Corner> = (0..8).map(vertex).collect();
    let positions: Vec<_> = vertices.iter().map(|vertex| vertex.position).collect();
    let mut placed = Placed::new(viewport);
    placed.set(&positions, Simd::auto());
    // One in eight is looked at before it is drawn: that of no vertices, too.
    let lengths: Vec<usize> = (0..72).map(|i| i % 8).collect();
    let indices = [0, 1, 2, 3, 4, 5, 6, 7];
    let indexed = |n: &usize| {
        let polygon = Indexed::new(vertices.as_slice(), &indices[..*n]).expect("all there");
        polygon.with_placed(&placed)
    };
    let polygons: Vec<_> = lengths.iter().map(indexed).collect();
    let copies: Vec<Vec<Corner>> = lengths.iter().map(|n| vertices[..*n].to_vec()).collect();
    let expected = one_by_one(&mut Tiler::new(viewport), &copies);
    for threads in [1, 3] {
        let mut frame = Frame::new(Tiler::new(viewport));
        frame.set_parallel(threads > 1);
        let shader = Numbered::<true>::default();
        let draw = || list_of(&mut frame, polygons.as_slice(), shader);
        assert!(pool(threads).install(draw) == expected, "{threads} threads");
    }
}

/// Small polygons far from each other: what they cover is asked for, too.
#[test]
fn draw_lists_of_small_polygons_far_from_each_other() {
    let polygon = |i: usize| -> Vec<Corner> {
        let (x, y) = ((i % 37) as f64 / 18.0 - 1.0, 1.0 - (i % 13) as f64 / 100.0);
        let (x, y) = (x * 0.97, if i.is_multiple_of(2) { y } else { -y } * 0.97);
        let corners = [[-0.02, -0.015], [0.02, -0.02], [0.018, 0.02], [-0.02, 0.018]];
        let z = 0.5 + (i % 5) as f64 * 0.01;
        let corner = |[dx, dy]: [f64; 2]| Vertex::new([x + dx, y + dy, z, 1.0], [i as f32, 0.5]);
        corners.map(corner)[..3 + i / 2 % 2].to_vec()
    };
    let polygons: Vec<_> = (0..400).map(polygon).collect();
    let viewport = Viewport::new(-3, 7, 160, 340).expect("small");
    for precision in [Precision::Fast, Precision::Exact] {
        let mut tiler = Tiler::new(viewport);
        tiler.set_origin(2, 11).set_precision(precision);
        let expected = one_by_one(&mut tiler, &polygons);
        let shaded = tiler.stats().pixels_shaded;
        assert!(shaded > 2000, "{shaded}");
        let mut frame = Frame::new(Tiler::new(viewport));
        frame.settings().set_origin(2, 11).set_precision(precision);
        assert!(in_a_list(&mut frame, &polygons) == expected);
        assert_eq!(frame.stats().pixels_shaded, shaded);
    }
}

/// Nothing to draw on, or nothing to draw.
#[test]
fn draw_lists_without_pixels_or_polygons() {
    let viewport = Viewport::new(0, 0, SIZE[0], SIZE[1]).expect("small");
    let mut frame = Frame::new(Tiler::new(viewport));
    let polygons: [Vec<Corner>; 0] = [];
    for parallel in [false, true] {
        frame.set_parallel(parallel);
        for size in [[0, 0], [5, 0], [0, 5]] {
            let target = Plane::<[u32; 3]>::new(&mut [], size[0], size[1]).expect("no pixel");
            let screen = Screen { target, depth: None, clear: None };
            assert_eq!(screen.size(), (size[0], size[1]));
            pool(2).install(|| frame.draw(screen, &[]));
        }
        let (picture, _) = in_a_list(&mut frame, &polygons);
        assert!(picture.iter().all(|pixel| *pixel == [0; 3]));
    }
}
