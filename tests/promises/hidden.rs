//! P6, of what is hidden: with bounds of the stored depths and without them, every byte is the
//! same, whatever the compare function, the shader, the instruction set, and whatever the caller
//! does to the depths in between.

use crate::oracle::Poly;
use crate::oracle::shapes::{Tally, check, unproject};
use hyperspan::depth::{Compare, DepthBounds, DepthSource, DepthTest};
use hyperspan::draw::{Frame, Polygons, Screen, With};
use hyperspan::polygon::Vertex;
use hyperspan::shade::{BLOCK, Block, Inputs, Shader, Solid};
use hyperspan::space::{DepthRange, Grid};
use hyperspan::target::DepthBuffer;
use hyperspan::{Outcome, Plane, Precision, Simd, Stats, Tiler, Viewport};
use proptest::prelude::*;

/// What happens to a picture and its depths.
#[derive(Clone, Debug)]
enum Step {
    Draw(Poly),
    Test(DepthTest),
    Clear(f32),
    /// The caller writes depths of one row, from a column on.
    Write(u32, u32, Vec<f32>),
    /// The caller attaches the bounds anew, and has changed a depth in between.
    Behind(u32, u32, f32),
    /// Skips, or not, while the bounds are kept.
    Skip(bool),
}

#[derive(Clone, Debug)]
struct Story {
    viewport: Viewport,
    origin: [i32; 2],
    size: (u32, u32),
    precision: Precision,
    first: f32,
    steps: Vec<Step>,
}

const COMPARES: [Compare; 8] = [
    Compare::Never,
    Compare::Less,
    Compare::Equal,
    Compare::LessEqual,
    Compare::Greater,
    Compare::NotEqual,
    Compare::GreaterEqual,
    Compare::Always,
];

/// Mostly one of the usual two.
fn tests() -> impl Strategy<Value = DepthTest> {
    let usual = prop_oneof![Just(Compare::Less), Just(Compare::Greater)];
    let any = prop::sample::select(COMPARES.to_vec());
    let compare = prop_oneof![3 => usual, 2 => any];
    let source = prop_oneof![4 => Just(DepthSource::Z), 1 => Just(DepthSource::InvW)];
    let write = prop_oneof![5 => Just(true), 1 => Just(false)];
    (compare, write, source).prop_map(|(compare, write, source)| DepthTest {
        compare,
        write,
        source,
    })
}

fn depths() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => 0.0..1.0_f32,
        4 => Just(0.5),
        2 => Just(0.0),
        2 => Just(1.0),
        1 => Just(f32::NAN),
        1 => prop::sample::select(vec![f32::INFINITY, -1.0, -0.0, 1e-40, 2.0]),
    ]
}

/// A polygon round a point of the framebuffer: depth and 1/w run linearly over it, but for what
/// bends it.
fn polygons(viewport: Viewport, span: [f64; 2]) -> impl Strategy<Value = Poly> {
    let radius = prop_oneof![3 => 1.0..6.0, 3 => 10.0..60.0, 2 => Just(400.0), 1 => 0.01..1.0_f64];
    let centre =
        [-0.1..1.1, -0.1..1.1].prop_map(move |[x, y]: [f64; 2]| [x * span[0], y * span[1]]);
    let depth = prop_oneof![4 => 0.0..1.0, 4 => Just(0.5), 1 => 0.0..1e-6_f64];
    let slope = prop_oneof![3 => -0.02..0.02, 2 => Just(0.0), 1 => -0.5..0.5_f64];
    // Thin ones reach far beyond their corners' depths.
    let thin = prop_oneof![6 => Just(1.0), 2 => 1e-6..0.05, 1 => 0.0..2e-5_f64];
    let bend = prop_oneof![8 => Just(0.0), 1 => -0.01..0.01, 1 => -0.3..0.3_f64];
    let shape = (radius, centre, 0.0..7.0_f64, thin);
    // Of thin ones the plane is steep.
    let loose = prop_oneof![2 => Just(vec![0.0; 8]), 1 => prop::collection::vec(0.0..0.1_f64, 8)];
    let plane = (depth, [slope.clone(), slope], [-0.8..0.8_f64, -0.8..0.8], bend, loose);
    let n = prop_oneof![3 => Just(3), 3 => Just(4), 1 => 5..8_usize];
    let colours = prop::collection::vec(0.0..1.0_f32, 2);
    (shape, plane, n, prop_oneof![3 => Just(0), 1 => -90..90_i32], colours).prop_map(
        move |(
            (radius, centre, turn, thin),
            (depth, slopes, q, bend, loose),
            n,
            scale,
            colours,
        )| {
            let place = |i: usize| {
                let angle = turn + i as f64 * std::f64::consts::TAU / n as f64;
                let (across, along) = (angle.cos() * radius, angle.sin() * radius * thin);
                let (sin, cos) = turn.sin_cos();
                [across * cos - along * sin, across * sin + along * cos]
            };
            let position = |i: usize| {
                let [x, y] = place(i);
                let bent = loose[i] + if i == 0 { bend } else { 0.0 };
                let z = depth + bent + (slopes[0] * x + slopes[1] * y) * (0.1 / thin.max(0.01));
                let w = 1.0 / (1.0 + (q[0] * x + q[1] * y) / (radius * 1.5));
                let z = match viewport.depth_range() {
                    DepthRange::ZeroToOne => z,
                    DepthRange::MinusOneToOne => 2.0 * z - 1.0,
                };
                let w = w * 2.0_f64.powi(scale);
                unproject(viewport, [centre[0] + x, centre[1] + y], z, w)
            };
            let positions: Vec<_> = (0..n).map(position).collect();
            let attributes = (0..n).map(|i| vec![colours[0], colours[1] + i as f32]).collect();
            Poly { positions, attributes }
        },
    )
}

/// Triangles and quadrilaterals along a row of centres, about as thick as a step of the grid: at
/// what they cover, the plane may be far from their corners.
fn slivers(viewport: Viewport, span: [f64; 2]) -> impl Strategy<Value = Poly> {
    let steps = if viewport.grid() == Grid::Eight { 256.0 } else { 65536.0 };
    let thickness = prop_oneof![Just(1.0), Just(4.0), Just(30.0)];
    let corner = || (-0.1..1.1_f64, -1.0..1.0_f64, 0.5..0.6_f64);
    let corners = prop::collection::vec(corner(), 3..=4);
    let upright = any::<bool>();
    (corners, 0..150_i32, thickness, upright).prop_map(move |(corners, row, thickness, upright)| {
        let place = |(along, off, z): (f64, f64, f64)| {
            let across = f64::from(row) + 0.5 + off * thickness / steps;
            let at = if upright { [across, along * span[1]] } else { [along * span[0], across] };
            unproject(viewport, at, z, 1.0)
        };
        let positions: Vec<_> = corners.into_iter().map(place).collect();
        let attributes = vec![vec![0.25, 1.0]; positions.len()];
        Poly { positions, attributes }
    })
}

fn stories() -> impl Strategy<Value = Story> {
    let corner = prop_oneof![3 => Just(0), 1 => -40_i32..40];
    let range = prop_oneof![3 => Just(DepthRange::ZeroToOne), 1 => Just(DepthRange::MinusOneToOne)];
    let grid = prop_oneof![4 => Just(Grid::Sixteen), 1 => Just(Grid::Eight)];
    let viewport = (corner.clone(), corner, 20_u32..150, 20_u32..150, range, grid).prop_map(
        |(x, y, w, h, range, grid)| {
            let viewport = Viewport::new(x, y, w, h).expect("small");
            viewport.with_depth_range(range).with_grid(grid)
        },
    );
    let target =
        (prop_oneof![2 => Just([0, 0]), 1 => [-20_i32..20, -20_i32..20]], 1_u32..150, 1_u32..150);
    let precision = prop_oneof![3 => Just(Precision::Fast), 1 => Just(Precision::Exact)];
    (viewport, target, precision, depths()).prop_flat_map(|(viewport, target, precision, first)| {
        let (origin, width, height) = target;
        let span = [f64::from(viewport.width()), f64::from(viewport.height())];
        let values = prop::collection::vec(depths(), 1..40);
        let step = prop_oneof![
            20 => polygons(viewport, span).prop_map(Step::Draw),
            8 => slivers(viewport, span).prop_map(Step::Draw),
            2 => tests().prop_map(Step::Test),
            1 => depths().prop_map(Step::Clear),
            1 => (0_u32..150, 0_u32..150, values).prop_map(|(x, y, v)| Step::Write(x, y, v)),
            1 => (0_u32..150, 0_u32..150, depths()).prop_map(|(x, y, v)| Step::Behind(x, y, v)),
            1 => any::<bool>().prop_map(Step::Skip),
        ];
        prop::collection::vec(step, 1..80).prop_map(move |steps| {
            let size = (width, height);
            Story { viewport, origin, size, precision, first, steps }
        })
    })
}

/// Keeps all pixels, or those of a pattern.
#[derive(Clone)]
struct Marks<const ALL: bool>;

impl<const ALL: bool> Shader for Marks<ALL> {
    type Pixel = u32;
    const INPUTS: Inputs = Inputs::attributes(2);
    const KEEPS_ALL: bool = ALL;

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, out: &mut [u32; BLOCK]) -> u16 {
        for (lane, out) in out.iter_mut().enumerate() {
            *out = block.attributes[1][lane].to_bits() ^ block.attributes[0][lane].to_bits() << 9;
        }
        let pattern = (0..16).filter(|lane| (block.x(*lane) + 3 * block.y(*lane)) % 4 != 0);
        if ALL { u16::MAX } else { pattern.fold(0, |mask, lane| mask | 1 << lane) }
    }
}

/// What came of a story.
#[derive(Debug, Default)]
struct Told {
    colours: Vec<u32>,
    depths: Vec<u32>,
    shaded: u64,
    hidden_polygons: u64,
    hidden_pixels: u64,
}

fn tell<S: Shader<Pixel = u32>>(story: &Story, shader: &mut S, simd: Simd, bounded: bool) -> Told {
    let (width, height) = story.size;
    let area = (width * height) as usize;
    let (mut colours, mut depths) = (vec![0_u32; area], vec![story.first; area]);
    let mut tiler = Tiler::new(story.viewport);
    tiler.set_precision(story.precision).set_simd(simd);
    tiler.set_origin(story.origin[0], story.origin[1]);
    let mut bounds = DepthBounds::new();
    let mut hidden = 0;
    for step in &story.steps {
        let mut target = Plane::new(&mut colours, width, height).expect("its size");
        let buffer: DepthBuffer<'_> = Plane::new(&mut depths, width, height).expect("its size");
        let mut buffer = if bounded { buffer.with_bounds(&mut bounds) } else { buffer };
        match step {
            Step::Draw(poly) => {
                let outcome = tiler.draw(poly, shader, &mut target, Some(&mut buffer));
                hidden += u64::from(outcome == Outcome::Hidden);
            }
            Step::Test(test) => {
                tiler.set_depth_test(*test);
            }
            Step::Clear(depth) => buffer.clear(*depth),
            Step::Write(x, y, values) => {
                let row = buffer.row_mut(*y % height);
                for (i, value) in values.iter().enumerate() {
                    row[(*x as usize + i) % width as usize] = *value;
                }
            }
            Step::Behind(x, y, value) => {
                depths[(y % height * width + x % width) as usize] = *value;
                bounds.forget();
            }
            Step::Skip(skip) => {
                tiler.set_hidden_skips(*skip);
            }
        }
    }
    let stats = tiler.stats();
    assert_eq!(stats.culled.hidden, hidden);
    assert_eq!(stats.pixels_covered, stats.pixels_shaded + stats.pixels_hidden);
    Told {
        colours,
        depths: depths.into_iter().map(f32::to_bits).collect(),
        shaded: stats.pixels_shaded,
        hidden_polygons: hidden,
        hidden_pixels: stats.pixels_hidden,
    }
}

#[test]
fn hidden_surfaces_left_out_change_no_byte() {
    let (polygons, pixels) = (Tally::default(), Tally::default());
    let cases =
        check(file!(), "hidden_bytes", 6000, &(stories(), any::<bool>()), |(story, all)| {
            let told = |simd, bounded| {
                if all {
                    tell(&story, &mut Marks::<true>, simd, bounded)
                } else {
                    tell(&story, &mut Marks::<false>, simd, bounded)
                }
            };
            let plain = told(Simd::auto(), false);
            let mut counted = None;
            for (name, simd) in Simd::all() {
                let bounded = told(simd, true);
                prop_assert!(plain.colours == bounded.colours, "colours, {name}");
                prop_assert!(plain.depths == bounded.depths, "depths, {name}");
                prop_assert_eq!(plain.shaded, bounded.shaded, "{}", name);
                counted = Some(bounded);
            }
            // Of one instruction set: what is expected must not depend on how many the machine has.
            let bounded = counted.expect("scalars at least");
            polygons.add(bounded.hidden_polygons as usize);
            pixels.add((plain.hidden_pixels - bounded.hidden_pixels) as usize);
            Ok(())
        });
    polygons.report("polygons hidden", cases);
    pixels.report("pixels hidden with them", 100 * cases);
}

/// A list of polygons, drawn as frames of a draw list, on a depth buffer that keeps its bounds.
#[test]
fn hidden_surfaces_left_out_of_draw_lists_change_no_byte() {
    let viewport = Viewport::new(0, 0, 150, 140).expect("small");
    let list = || prop::collection::vec(polygons(viewport, [150.0, 140.0]), 1..60);
    let hidden = Tally::default();
    let cases = check(file!(), "hidden_lists", 300, &[list(), list()], |lists| {
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.expect("threads");
            let mut bounds = DepthBounds::new();
            let (mut depths, mut plain) = (vec![0.0_f32; 150 * 140], vec![0.0_f32; 150 * 140]);
            let mut frame = Frame::new(Tiler::new(viewport));
            frame.set_parallel(threads > 1);
            for list in &lists {
                let mut draw = |depths: &mut [f32], bounds: Option<&mut DepthBounds>| {
                    let mut colours = vec![0_u32; 150 * 140];
                    let buffer = Plane::new(depths, 150, 140).expect("its size");
                    let buffer = match bounds {
                        Some(bounds) => buffer.with_bounds(bounds),
                        None => buffer,
                    };
                    let target = Plane::new(&mut colours, 150, 140).expect("its size");
                    let screen = Screen { target, depth: Some(buffer), clear: Some((0, 1.0)) };
                    let calls = Polygons::new(list, With(Marks::<true>));
                    pool.install(|| frame.draw(screen, &[&calls]));
                    (colours, frame.stats())
                };
                let (right, all) = draw(&mut plain, None);
                let (found, some) = draw(&mut depths, Some(&mut bounds));
                prop_assert!(right == found, "colours");
                let bits = |depths: &[f32]| depths.iter().map(|d| d.to_bits()).collect::<Vec<_>>();
                prop_assert!(bits(&plain) == bits(&depths), "depths");
                hidden.add((all.pixels_covered - some.pixels_covered) as usize);
            }
        }
        Ok(())
    });
    hidden.report("pixels of hidden polygons in lists", 100 * cases);
}

/// The last row of tiles was cut, and its bounds taken for those of the part above: what was drawn
/// below it did not count.
#[test]
fn hidden_surfaces_where_the_last_tiles_are_cut() {
    const SIZE: [u32; 2] = [16, 48];
    let viewport = Viewport::new(0, 0, SIZE[0], SIZE[1]).expect("small");
    let cover = |z: f64| {
        let corner = |x: f64, y: f64| Vertex::new([x, y, z, 1.0], []);
        [corner(-1.0, -1.0), corner(3.0, -1.0), corner(-1.0, 3.0)]
    };
    let (mut colour, mut depths) = ([0_u32; 768], [1.0; 768]);
    let mut bounds = DepthBounds::new();
    let mut tiler = Tiler::new(viewport);
    let whole = Plane::new(&mut depths, SIZE[0], SIZE[1]).expect("its size");
    let (mut above, _) = whole.with_bounds(&mut bounds).split_at_row(40);
    let mut target = Plane::new(&mut colour, SIZE[0], 40).expect("its size");
    tiler.draw(&cover(0.25), &mut Solid(1), &mut target, Some(&mut above));
    // Hidden, so that the depths are looked at.
    tiler.draw(&cover(0.5), &mut Solid(3), &mut target, Some(&mut above));
    let mut target = Plane::new(&mut colour, SIZE[0], SIZE[1]).expect("its size");
    let whole = Plane::new(&mut depths, SIZE[0], SIZE[1]).expect("its size");
    let mut whole = whole.with_bounds(&mut bounds);
    tiler.draw(&cover(0.5), &mut Solid(2), &mut target, Some(&mut whole));
    let expected = |i: usize| if i < 40 * 16 { 1 } else { 2 };
    assert!((0..colour.len()).all(|i| colour[i] == expected(i)), "{colour:?}");
}

/// The side of a target that has one small polygon.
const SIDE: u32 = 48;

/// Draws `polygon` over depths that are all `stored`: with bounds the same ones come out as without. Returns
/// what was counted.
fn same_with_bounds<const N: usize>(
    polygon: &[Vertex<0, [f64; 4]>; N],
    stored: f32,
    compare: Compare,
    precision: Precision,
) -> Result<Stats, TestCaseError> {
    let draw = |bounded: bool| {
        // Of what was there before bounds were attached nothing is known, and so they are looked for.
        let mut depths = vec![stored; (SIDE * SIDE) as usize];
        let mut bounds = DepthBounds::new();
        let mut buffer = Plane::new(&mut depths, SIDE, SIDE).expect("its size");
        if bounded {
            buffer = buffer.with_bounds(&mut bounds);
        }
        let mut tiler = Tiler::new(Viewport::new(0, 0, SIDE, SIDE).expect("small"));
        tiler.set_precision(precision);
        tiler.set_depth_test(DepthTest { compare, ..DepthTest::STANDARD });
        tiler.draw(polygon, &mut Solid(()), &mut (), Some(&mut buffer));
        (depths, tiler.stats())
    };
    let (plain, stats) = draw(false);
    prop_assert!(plain == draw(true).0, "{:?}, {:?}", compare, precision);
    Ok(stats)
}

/// A corner alone is nearer than what is stored everywhere: small quadrilaterals have bounds of their depths from
/// the three vertices that carry the plane, and from the fourth.
#[test]
fn hidden_small_quadrilaterals_show_a_corner() {
    let viewport = Viewport::new(0, 0, SIDE, SIDE).expect("small");
    let tally = Tally::default();
    let turn = 0.0..std::f64::consts::TAU;
    let quads =
        (turn.clone(), turn, 3.0..8.0_f64, [14.0..34.0, 14.0..34.0_f64], 0.6..1.0_f64, 0..4_usize);
    let cases = check(file!(), "hidden_small_quads", 2000, &quads, |case| {
        let (turn, steepest, radius, [x, y], behind, first) = case;
        // The two corners beside the nearest are behind what is stored, if by little.
        let slope = 0.2 / radius;
        let corner = |i: usize| {
            let angle = turn + (first + i) as f64 * std::f64::consts::FRAC_PI_2;
            let (dx, dy) = (angle.cos() * radius, angle.sin() * radius);
            let nearness = (angle - steepest).cos() * radius * slope;
            let z = 0.5 + 0.2 * behind - nearness;
            Vertex::new(unproject(viewport, [x + dx, y + dy], z, 1.0), [])
        };
        let quad = [corner(0), corner(1), corner(2), corner(3)];
        for compare in [Compare::Less, Compare::Greater] {
            let stored = if compare == Compare::Less { 0.5 } else { 0.5 + 0.4 * behind as f32 };
            let stats = same_with_bounds(&quad, stored, compare, Precision::Fast)?;
            tally.add(usize::from((1..10).contains(&stats.pixels_shaded)));
        }
        Ok(())
    });
    tally.report("corners that are seen", cases / 4);
}

/// Depths half a step of `f32` before what is stored, so that some of a small triangle's pixels round to that and
/// others do not: what bounds they lie between has to be rounded outward.
#[test]
fn hidden_small_triangles_whose_depths_are_ties() {
    let viewport = Viewport::new(0, 0, SIDE, SIDE).expect("small");
    let tally = Tally::default();
    let ways = (
        prop::sample::select(vec![Compare::Less, Compare::Greater]),
        prop::sample::select(vec![Precision::Fast, Precision::Exact]),
    );
    let ws = [0.0..3.0_f64, 0.0..3.0, 0.0..3.0];
    let centre = [14.0..34.0_f64, 14.0..34.0];
    let triangles = (0.25..0.75_f32, 0.0..std::f64::consts::TAU, 3.0..8.0_f64, centre, ws, ways);
    let cases = check(file!(), "hidden_ties", 2000, &triangles, |case| {
        let (stored, turn, radius, [x, y], ws, (compare, precision)) = case;
        let nearer = f32::from_bits(stored.to_bits().wrapping_add_signed(match compare {
            Compare::Less => -1,
            _ => 1,
        }));
        // Exact, but times w and divided by it again it may be on either side.
        let tie = f64::midpoint(stored.into(), nearer.into());
        let corner = |i: usize| {
            let angle = turn + i as f64 * (std::f64::consts::TAU / 3.0);
            let at = [x + angle.cos() * radius, y + angle.sin() * radius];
            Vertex::new(unproject(viewport, at, tie, ws[i].exp2()), [])
        };
        let triangle = [corner(0), corner(1), corner(2)];
        let stats = same_with_bounds(&triangle, stored, compare, precision)?;
        tally.add(usize::from((1..stats.pixels_covered).contains(&stats.pixels_shaded)));
        Ok(())
    });
    tally.report("triangles of which some pixels pass", cases / 4);
}
