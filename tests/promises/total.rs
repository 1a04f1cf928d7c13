//! P4: any bits in, and there is no panic, no write outside the target, and every polygon is
//! counted once.

use std::time::Instant;

use crate::oracle::Poly;
use crate::oracle::probe::{Closure, Sheet};
use crate::oracle::shapes::{Tally, check, clipped_polygons, loose_polygons, scenes};
use hyperspan::depth::{Compare, DepthSource, DepthTest};
use hyperspan::space::{DepthRange, Grid, Viewport};
use hyperspan::stats::Stats;
use hyperspan::target::Plane;
use hyperspan::tiler::{Cull, Outcome, Precision, Tiler};
use hyperspan::varying::Interpolation;
use proptest::prelude::*;

/// Numbers that have broken rasterizers, and any others.
fn number() -> impl Strategy<Value = f64> {
    let nasty = vec![
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        1e20,
        -1e20,
        3e38,
        -3e38,
        1e-40,
        5e-324,
        -5e-324,
        1e308,
        -1e308,
        f64::MAX,
        f64::MIN,
        f64::MIN_POSITIVE,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
        1e-300,
        32767.0,
        -32768.0,
        65536.0,
        2147483648.0,
        1.0 + f64::EPSILON,
        1.0 - f64::EPSILON / 2.0,
    ];
    let finite = nasty.iter().copied().filter(|c| c.is_finite()).collect::<Vec<_>>();
    prop_oneof![
        8 => -2.0..2.0,
        4 => (-4..4_i32).prop_map(|i| f64::from(i) / 2.0),
        4 => prop::sample::select(finite),
        2 => (-1000..1000_i32, -1.0..1.0).prop_map(|(e, m)| m * f64::from(e).exp2()),
        1 => any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |c| c.is_finite()),
        1 => any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |c| c.is_finite()).prop_map(f64::from),
    ]
}

/// Polygons of 0 to 40 vertices with 0 to 4 attributes, of any bits; a tenth of them has a
/// position that is not finite.
fn raw_polygons() -> impl Strategy<Value = Poly> {
    let infinite = prop::sample::select(vec![f64::INFINITY, f64::NEG_INFINITY, f64::NAN]);
    let bits = || {
        let single = any::<u32>().prop_map(|b| f64::from(f32::from_bits(b)).to_bits());
        prop_oneof![any::<u64>(), single, infinite.clone().prop_map(f64::to_bits)]
    };
    let position = [number(), number(), number(), number()];
    // Some share coordinates, so that polygons are degenerate, edge-on, or repeat vertices.
    let shared = prop::collection::vec(position, 1..6);
    let pick = prop::collection::vec((any::<prop::sample::Index>(), 0..4_usize, number()), 0..40);
    let attribute = prop_oneof![any::<u32>(), (-9.0..9.0_f32).prop_map(f32::to_bits)];
    let attributes = prop::collection::vec(prop::collection::vec(attribute, 4), 40);
    let spoil = prop::option::weighted(0.1, (any::<prop::sample::Index>(), 0..4_usize, bits()));
    (shared, pick, attributes, 0..=4_usize, spoil).prop_map(
        |(shared, pick, attributes, count, spoil)| {
            let vertex = |(index, coordinate, number): &(prop::sample::Index, usize, f64)| {
                let mut p = shared[index.index(shared.len())];
                p[*coordinate] = *number;
                p
            };
            let mut positions: Vec<[f64; 4]> = pick.iter().map(vertex).collect();
            if let Some((index, coordinate, bits)) = spoil
                && !positions.is_empty()
            {
                let at = index.index(positions.len());
                positions[at][coordinate] = f64::from_bits(bits);
            }
            let list = |a: &Vec<u32>| a[..count].iter().map(|b| f32::from_bits(*b)).collect();
            let attributes = attributes[..positions.len()].iter().map(list).collect();
            Poly { positions, attributes }
        },
    )
}

/// Everything that can be set.
#[derive(Clone, Debug)]
struct Settings {
    viewport: Viewport,
    origin: (i32, i32),
    cull: Cull,
    precision: Precision,
    interpolation: Vec<Interpolation>,
    depth_test: DepthTest,
    planes: Vec<[f64; 4]>,
    /// Width, height and gap of the target and of the depth buffer, if there is one.
    target: (u32, u32, usize),
    depth: Option<(u32, u32, usize)>,
    clear: f32,
}

fn settings() -> impl Strategy<Value = Settings> {
    use Interpolation::{Flat, NoPerspective, Perspective};
    let side = || prop_oneof![Just(0_u32), Just(1), 2..100_u32, Just(16384), 0..=16384_u32];
    let place =
        || prop_oneof![6 => Just(0), 2 => -40..40_i32, 1 => any::<i32>(), 1 => Just(i32::MAX)];
    let viewport = (place(), place(), side(), side(), any::<bool>(), any::<bool>());
    let shape = || (0..40_u32, 0..40_u32, 0..5_usize);
    let all = Compare::Never as u8..=Compare::Always as u8;
    let compare = all.prop_map(|i| {
        use Compare::{Always, Equal, Greater, GreaterEqual, Less, LessEqual, Never, NotEqual};
        [Never, Less, Equal, LessEqual, Greater, NotEqual, GreaterEqual, Always][usize::from(i)]
    });
    let depth_test = (compare, any::<bool>(), any::<bool>()).prop_map(|(compare, write, z)| {
        DepthTest { compare, write, source: if z { DepthSource::Z } else { DepthSource::InvW } }
    });
    let modes =
        prop::collection::vec(prop::sample::select(vec![Perspective, NoPerspective, Flat]), 0..6);
    let planes = prop::collection::vec([number(), number(), number(), number()], 0..3);
    let aside = prop_oneof![3 => Just([0, 0]), 1 => [-30..30_i32, -30..30], 1 => [any::<i32>(), any::<i32>()]];
    let culls = prop::sample::select(vec![Cull::None, Cull::Back, Cull::Front]);
    let buffers = (shape(), prop::option::of(shape()), any::<u32>());
    let rest = (aside, culls, any::<bool>(), modes, depth_test, planes, buffers);
    (viewport, rest).prop_map(|((x, y, w, h, eight, gl), rest)| {
        let (aside, cull, exact, interpolation, depth_test, planes, (target, depth, clear)) = rest;
        let grid = if eight { Grid::Eight } else { Grid::Sixteen };
        let range = if gl { DepthRange::MinusOneToOne } else { DepthRange::ZeroToOne };
        let viewport = Viewport::new(x, y, w, h).expect("16384 at most");
        Settings {
            viewport: viewport.with_grid(grid).with_depth_range(range),
            origin: (x.saturating_add(aside[0]), y.saturating_add(aside[1])),
            cull,
            precision: if exact { Precision::Exact } else { Precision::Fast },
            interpolation,
            depth_test,
            planes,
            target,
            depth,
            clear: f32::from_bits(clear),
        }
    })
}

/// A buffer with gaps between its rows and more behind the last, to be checked for `canary`.
fn buffer<P: Copy>((width, height, gap): (u32, u32, usize), inside: P, canary: P) -> Vec<P> {
    let stride = width as usize + gap;
    let mut data = vec![canary; stride * height as usize + 7];
    for row in 0..height as usize {
        data[row * stride..][..width as usize].fill(inside);
    }
    data
}

/// Is what lies outside of the rows as it was?
fn untouched<P: PartialEq>(
    (width, height, gap): (u32, u32, usize),
    data: &[P],
    canary: &P,
) -> bool {
    let stride = width as usize + gap;
    let outside = |i: usize| i >= stride * height as usize || i % stride >= width as usize;
    data.iter().enumerate().all(|(i, pixel)| !outside(i) || pixel == canary)
}

/// Draws with everything set, and checks what must hold for any input. Returns the outcome, the
/// counts and how many pixels the target got.
fn draw(settings: &Settings, poly: &Poly) -> Result<(Outcome, Stats, usize), TestCaseError> {
    const CANARY: u32 = 0xDEAD_BEEF;
    let mut pixels = buffer(settings.target, 0_u32, CANARY);
    let shape = settings.depth.unwrap_or_default();
    let mut depths = buffer(shape, settings.clear.to_bits(), CANARY)
        .into_iter()
        .map(f32::from_bits)
        .collect::<Vec<_>>();
    let mut tiler = Tiler::new(settings.viewport);
    tiler
        .set_origin(settings.origin.0, settings.origin.1)
        .set_cull(settings.cull)
        .set_precision(settings.precision)
        .set_interpolation(&settings.interpolation)
        .set_depth_test(settings.depth_test)
        .set_clip_planes(&settings.planes);
    let rect = settings.viewport.rect();
    let mut shaded = 0_u64;
    let mut shader: Closure<'_, u32> = &mut |f| {
        shaded += 1;
        assert!(rect.x0 <= f.x() && f.x() < rect.x1 && rect.y0 <= f.y() && f.y() < rect.y1);
        assert!((0.0..=1.0).contains(&f.depth()), "depth {}", f.depth());
        assert!(f.inv_w() >= 0.0 && f.w() >= 0.0, "1/w {}, w {}", f.inv_w(), f.w());
        for k in 0..f.attribute_count() {
            let value = f.attribute(k);
            assert!(!value.is_nan() || value.to_bits() == 0x7FC0_0000, "{:#x}", value.to_bits());
        }
        assert!(f.attribute(f.attribute_count()).is_nan());
        1
    };
    let (width, height, gap) = settings.target;
    let mut target =
        Plane::with_stride(&mut pixels, width, height, width as usize + gap).expect("fits");
    let mut plane = Plane::with_stride(&mut depths, shape.0, shape.1, shape.0 as usize + shape.2)
        .expect("fits");
    let depth = settings.depth.map(|_| &mut plane);
    let outcome = tiler.draw(poly, &mut shader, &mut target, depth);
    prop_assert!(untouched(settings.target, &pixels, &CANARY), "outside of the target");
    let depth_bits: Vec<u32> = depths.iter().map(|d| d.to_bits()).collect();
    prop_assert!(untouched(shape, &depth_bits, &CANARY), "outside of the depth buffer");
    let drawn = pixels.iter().filter(|p| **p == 1).count();
    let stats = tiler.stats();
    prop_assert_eq!(stats.polygons, 1);
    let culled = [
        stats.culled.outside,
        stats.culled.backface,
        stats.culled.degenerate,
        stats.culled.refused,
        stats.culled.hidden,
    ];
    let right = match outcome {
        Outcome::Drawn => [0, 0, 0, 0, 0],
        Outcome::Outside => [1, 0, 0, 0, 0],
        Outcome::Backface => [0, 1, 0, 0, 0],
        Outcome::Degenerate => [0, 0, 1, 0, 0],
        Outcome::Refused => [0, 0, 0, 1, 0],
        Outcome::Hidden => [0, 0, 0, 0, 1],
    };
    prop_assert_eq!(culled, right, "{:?}", outcome);
    prop_assert_eq!(stats.culled.hidden, 0);
    prop_assert_eq!(stats.pixels_shaded, shaded);
    prop_assert_eq!(stats.pixels_covered, stats.pixels_shaded + stats.pixels_hidden);
    prop_assert_eq!(drawn as u64, shaded, "each pixel once");
    if outcome != Outcome::Drawn {
        prop_assert_eq!(stats.pixels_covered, 0, "{:?}", outcome);
    }
    Ok((outcome, stats, drawn))
}

#[test]
fn total_for_any_bits() {
    let (drawn, pixels) = (Tally::default(), Tally::default());
    let cases = check(
        file!(),
        "total_any_bits",
        30_000,
        &(settings(), raw_polygons()),
        |(settings, poly)| {
            let (outcome, _, count) = draw(&settings, &poly)?;
            drawn.add(usize::from(outcome == Outcome::Drawn));
            pixels.add(count);
            let finite = poly.positions.iter().flatten().all(|c| c.is_finite());
            if poly.positions.len() < 3 {
                prop_assert!(matches!(outcome, Outcome::Degenerate | Outcome::Refused));
            } else {
                prop_assert_eq!(outcome == Outcome::Refused, !finite);
            }
            Ok(())
        },
    );
    drawn.report("polygons drawn", cases / 50);
    pixels.report("pixels", cases / 10);
}

#[test]
fn total_for_any_settings() {
    let polygons = prop_oneof![
        scenes(30.0).prop_map(|scene| scene.poly),
        clipped_polygons().prop_map(|(_, poly)| poly),
        loose_polygons().prop_map(|(_, poly)| poly),
    ];
    let (drawn, pixels) = (Tally::default(), Tally::default());
    let cases = check(
        file!(),
        "total_any_settings",
        30_000,
        &(settings(), polygons),
        |(settings, poly)| {
            let (outcome, _, count) = draw(&settings, &poly)?;
            drawn.add(usize::from(outcome == Outcome::Drawn));
            pixels.add(count);
            prop_assert!(outcome != Outcome::Refused);
            Ok(())
        },
    );
    drawn.report("polygons drawn", cases / 10);
    pixels.report("pixels", cases);
}

/// Many polygons by one tiler: the counts are sums, and reset is reset.
#[test]
fn total_counts_add_up() {
    let list = prop::collection::vec(raw_polygons(), 0..12);
    check(file!(), "total_counts", 1500, &(settings(), list), |(settings, list)| {
        let mut tiler = Tiler::new(settings.viewport);
        tiler.set_cull(settings.cull).set_origin(settings.origin.0, settings.origin.1);
        let (width, height, _) = settings.target;
        let mut drawn = 0;
        for poly in &list {
            let mut sheet = Sheet::new(width, height);
            let mut shader: Closure<'_, u32> = &mut |_| 1;
            let outcome = tiler.draw(poly, &mut shader, &mut sheet, None);
            drawn += u64::from(outcome == Outcome::Drawn);
        }
        let stats = tiler.stats();
        let culled = stats.culled;
        let left_out = culled.outside + culled.backface + culled.degenerate + culled.refused;
        prop_assert_eq!((stats.polygons, culled.hidden), (list.len() as u64, 0));
        prop_assert_eq!(stats.polygons, drawn + left_out);
        tiler.reset_stats();
        let nothing = Stats { peak_bytes: tiler.stats().peak_bytes, ..Stats::default() };
        prop_assert_eq!(tiler.stats(), nothing);
        Ok(())
    });
}

/// What costs time must be rows and pixels in sight, not those of the viewport: a cover, through
/// a window at its top and one 16000 rows below.
#[test]
fn total_work_is_that_of_the_window() {
    let viewport = Viewport::new(0, 0, 16384, 16384).expect("the largest");
    let cover = [[-1.0, 1.0, 0.5, 1.0], [-1.0, -1.0, 0.5, 1.0], [1.0, -1.0, 0.5, 1.0]];
    let cover = Poly::bare(&[cover[0], cover[1], cover[2], [1.0, 1.0, 0.5, 1.0]]);
    let mut tiler = Tiler::new(viewport);
    let mut least = [f64::INFINITY; 2];
    // The least of many turns, so that what else the machine does is of no account.
    for turn in 0..100 {
        let begun = Instant::now();
        tiler.set_origin(8192, if turn % 2 == 0 { 0 } else { 16000 });
        for _ in 0..50 {
            let mut sheet = Sheet::new(4, 2);
            let mut shader: Closure<'_, u32> = &mut |_| 1;
            tiler.draw(&cover, &mut shader, &mut sheet, None);
            assert_eq!(sheet.pixels.iter().flatten().count(), 8);
        }
        let time = &mut least[turn % 2];
        *time = time.min(begun.elapsed().as_secs_f64());
    }
    // Walking all rows above would take tens of times as long.
    assert!(least[1] < 3.0 * least[0], "{least:?} s");
}
