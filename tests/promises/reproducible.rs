//! P3: the same bits, for any crop, any rotation of the list of vertices, any power of two that
//! a polygon is scaled by, whatever was drawn before, and whatever the shader asks for.

use std::collections::BTreeMap;

use crate::oracle::Poly;
use crate::oracle::probe::{self, Picture, Sheet, View};
use crate::oracle::shapes::{
    Tally, check, clipped_polygons, loose_polygons, scenes, vanishing_polygons,
};
use hyperspan::depth::{Compare, DepthSource, DepthTest};
use hyperspan::polygon::{Indexed, Polygon, Strided, Vertex};
use hyperspan::shade::{Attributes, BLOCK, Block, Fragment, Inputs, Shader};
use hyperspan::simd::Simd;
use hyperspan::space::{PixelRect, Viewport};
use hyperspan::target::Plane;
use hyperspan::tiler::{Precision, Tiler};
use hyperspan::varying::Interpolation;
use proptest::prelude::*;

/// Flat ones, on the screen and out of it.
fn flat() -> impl Strategy<Value = (View, Poly)> {
    let kinds = prop_oneof![
        2 => scenes(12.0).prop_map(|scene| (scene.view(), scene.poly)),
        2 => clipped_polygons(),
        1 => vanishing_polygons(),
    ];
    in_either_precision(kinds)
}

/// All kinds: flat ones, clipped ones, and those whose attributes are not affine.
fn anything() -> impl Strategy<Value = (View, Poly)> {
    prop_oneof![3 => flat(), 1 => in_either_precision(loose_polygons())]
}

/// Twice round the same outline, with other attributes the second time: edges coincide, and
/// which of them carry values must not depend on where the list begins.
fn twice_around() -> impl Strategy<Value = (View, Poly)> {
    let second = prop::collection::vec(prop::collection::vec(-9.0..9.0_f32, 3), 5);
    (loose_polygons(), second).prop_map(|((view, mut poly), second)| {
        poly.attributes.extend_from_slice(&second[..poly.positions.len()]);
        poly.positions.extend_from_within(..);
        (view, poly)
    })
}

fn in_either_precision(
    polygons: impl Strategy<Value = (View, Poly)>,
) -> impl Strategy<Value = (View, Poly)> {
    let precision = prop_oneof![Just(Precision::Exact), Just(Precision::Fast)];
    (polygons, precision).prop_map(|((view, poly), precision)| (View { precision, ..view }, poly))
}

/// Both have the same pixels and bits.
fn same(a: &Picture, b: &Picture, what: &str) -> Result<(), TestCaseError> {
    let differs = |(place, seen): &(&(i32, i32), _)| b.get(place) != Some(*seen);
    let first = a.iter().find(differs);
    prop_assert!(first.is_none(), "{}: {:?}, not {:?}", what, first, first.map(|f| b.get(f.0)));
    prop_assert_eq!(a.len(), b.len(), "{}", what);
    Ok(())
}

#[test]
fn reproducible_for_any_rotation_of_the_list() {
    let any_list = prop_oneof![4 => anything(), 1 => in_either_precision(twice_around())];
    let tally = Tally::default();
    let cases = check(
        file!(),
        "reproducible_rotation",
        10000,
        &(any_list, 1..12_usize),
        |((view, poly), by)| {
            let mut turned = poly.rotated(by % poly.positions.len());
            // Of all things, only a flat attribute may depend on which vertex is first.
            for (k, mode) in view.interpolation.iter().enumerate() {
                if *mode == Interpolation::Flat {
                    turned.attributes[0][k] = poly.attributes[0][k];
                }
            }
            let mut poly = poly;
            for (k, mode) in view.interpolation.iter().enumerate() {
                if *mode == Interpolation::Flat {
                    // As the definition lets attributes decide ties, they must agree throughout.
                    let value = poly.attributes[0][k];
                    poly.attributes
                        .iter_mut()
                        .chain(&mut turned.attributes)
                        .for_each(|a| a[k] = value);
                }
            }
            let first = probe::draw(&view, &poly).1;
            tally.add(first.len());
            same(&first, &probe::draw(&view, &turned).1, "turned")
        },
    );
    tally.report("pixels compared", 30 * cases);
}

#[test]
fn reproducible_in_any_crop() {
    let crop = ([0.0..1.0_f64, 0.0..1.0], [0_u32..50, 0_u32..50]);
    let tally = Tally::default();
    let cases = check(
        file!(),
        "reproducible_crop",
        15000,
        &(anything(), crop),
        |((view, poly), (at, size))| {
            let whole = probe::draw(&view, &poly).1;
            let place = |low: i32, high: i32, t: f64| low + (f64::from(high - low) * t) as i32;
            let rect = view.window;
            let (x, y) = (place(rect.x0, rect.x1, at[0]), place(rect.y0, rect.y1, at[1]));
            let window = PixelRect::new(x, y, size[0], size[1]);
            let window = window.intersect(rect);
            let cropped = probe::draw(&View { window, ..view }, &poly).1;
            let inside = |&(y, x): &(i32, i32)| {
                window.x0 <= x && x < window.x1 && window.y0 <= y && y < window.y1
            };
            let part: Picture = whole.into_iter().filter(|(place, _)| inside(place)).collect();
            tally.add(part.len());
            same(&part, &cropped, "cropped")
        },
    );
    tally.report("pixels compared", 10 * cases);
}

/// Bits of `value` times 2^`exponent`, if both are normal numbers.
fn shifted(bits: u32, exponent: i32) -> Option<u32> {
    let shifted = f64::from(f32::from_bits(bits)) * f64::from(exponent).exp2();
    let fits = f32::from_bits(bits).is_normal() && (shifted as f32).is_normal();
    fits.then_some((shifted as f32).to_bits())
}

#[test]
fn reproducible_at_any_scale() {
    let tally = Tally::default();
    let cases = check(
        file!(),
        "reproducible_scale",
        10000,
        &(anything(), -120..=120_i32),
        |((view, poly), e)| {
            let first = probe::draw(&view, &poly).1;
            let mut scaled = probe::draw(&view, &poly.scaled(f64::from(e).exp2())).1;
            tally.add(first.len());
            for (place, seen) in &mut scaled {
                let Some(right) = first.get(place) else { continue };
                // w and 1/w scale with it.
                let pairs = [(&mut seen.w, right.w, e), (&mut seen.inv_w, right.inv_w, -e)];
                for (bits, before, e) in pairs {
                    if let Some(after) = shifted(before, e) {
                        prop_assert_eq!(*bits, after, "{:?}", place);
                    }
                    *bits = before;
                }
            }
            same(&first, &scaled, "scaled")
        },
    );
    tally.report("pixels compared", 30 * cases);
}

/// Every instruction set that the machine has.
#[test]
fn reproducible_with_any_instruction_set() {
    let tally = Tally::default();
    let cases = check(file!(), "reproducible_simd", 6000, &anything(), |(view, poly)| {
        let mut scalar = view.tiler();
        scalar.set_simd(Simd::scalar());
        let right = probe::draw_with(&mut scalar, &view, &poly).1;
        tally.add(right.len());
        for (name, simd) in Simd::all() {
            let mut tiler = view.tiler();
            tiler.set_simd(simd);
            same(&right, &probe::draw_with(&mut tiler, &view, &poly).1, name)?;
        }
        Ok(())
    });
    tally.report("pixels compared", 30 * cases);
}

/// One tiler for many polygons and targets: each comes out as from a fresh one.
#[test]
fn reproducible_whatever_was_drawn_before() {
    let list = prop::collection::vec(anything(), 2..6);
    let tally = Tally::default();
    let cases = check(file!(), "reproducible_order", 2000, &list, |list| {
        // The tiler's viewport is that of the first.
        let viewport = list[0].0.viewport;
        let views: Vec<View> = list.iter().map(|(v, _)| View { viewport, ..v.clone() }).collect();
        let mut tiler = Tiler::new(viewport);
        for _ in 0..2 {
            for (view, (_, poly)) in views.iter().zip(&list) {
                tiler
                    .set_interpolation(&view.interpolation)
                    .set_precision(view.precision)
                    .set_origin(view.window.x0, view.window.y0);
                let again = probe::draw_with(&mut tiler, view, poly).1;
                tally.add(again.len());
                same(&probe::draw(view, poly).1, &again, "with a used tiler")?;
            }
        }
        Ok(())
    });
    tally.report("pixels compared", 30 * cases);
}

/// The same polygon from an array of vertices, a slice with a stride, and by indices; and in
/// f32, if its positions are such.
#[test]
fn reproducible_however_a_polygon_is_kept() {
    let tally = Tally::default();
    let cases = check(file!(), "reproducible_storage", 3000, &anything(), |(view, poly)| {
        let mut poly = poly;
        for p in &mut poly.positions {
            *p = p.map(|c| f64::from(c as f32));
        }
        let count = poly.attributes[0].len();
        let right = probe::draw(&view, &poly).1;
        tally.add(right.len());
        let mut numbers = Vec::new();
        for list in &poly.attributes {
            numbers.extend_from_slice(list);
            numbers.extend([f32::NAN, 7.0]);
        }
        let strided = Strided::new(&poly.positions, &numbers, count + 2, count).expect("enough");
        same(&right, &probe::draw(&view, &strided).1, "strided")?;
        let singles: Vec<[f32; 4]> = poly.positions.iter().map(|p| p.map(|c| c as f32)).collect();
        let strided = Strided::new(&singles, &numbers, count + 2, count).expect("enough");
        same(&right, &probe::draw(&view, &strided).1, "strided, f32")?;
        // Backwards in the list, and backwards by the indices.
        let backwards = poly.reversed();
        let indices: Vec<u32> = (0..poly.positions.len() as u32).rev().collect();
        let indexed = Indexed::new(&backwards, &indices).expect("in range");
        same(&right, &probe::draw(&view, &indexed).1, "indexed")?;
        let vertices: Vec<Vertex<1>> = (0..singles.len())
            .map(|i| Vertex::new(singles[i], [poly.attributes[i].first().copied().unwrap_or(1.5)]))
            .collect();
        let one: Vec<_> = vertices.iter().map(|v| v.attributes.to_vec()).collect();
        let one = Poly { attributes: one, ..poly };
        same(&probe::draw(&view, &one).1, &probe::draw(&view, &vertices[..]).1, "vertices")
    });
    tally.report("pixels compared", 30 * cases);
}

/// Asks for a part of the values only, and notes what it is given.
struct Picky<const DEPTH: bool, const W: bool, const ATTRIBUTES: usize>(
    BTreeMap<(i32, i32), Vec<u32>>,
);

impl<const DEPTH: bool, const W: bool, const ATTRIBUTES: usize> Shader
    for Picky<DEPTH, W, ATTRIBUTES>
{
    type Pixel = ();
    const INPUTS: Inputs = Inputs { depth: DEPTH, inv_w: W, w: W, attributes: ATTRIBUTES };

    fn shade(&mut self, block: &Block<'_>, _: &mut [(); BLOCK]) -> u16 {
        for lane in (0..16_u16).filter(|lane| block.mask >> lane & 1 == 1) {
            let at = usize::from(lane);
            let mut values = Vec::new();
            values.extend(DEPTH.then(|| block.depth[at].to_bits()));
            values.extend(W.then(|| block.inv_w[at].to_bits()));
            values.extend(W.then(|| block.w[at].to_bits()));
            values.extend(block.attributes.iter().take(ATTRIBUTES).map(|a| a[at].to_bits()));
            self.0.insert((block.y(lane), block.x(lane)), values);
        }
        block.mask
    }
}

fn picky<const DEPTH: bool, const W: bool, const ATTRIBUTES: usize>(
    view: &View,
    poly: &Poly,
    all: &Picture,
) -> Result<(), TestCaseError> {
    let (width, height) = view.size();
    let mut shader = Picky::<DEPTH, W, ATTRIBUTES>(BTreeMap::new());
    view.tiler().draw(poly, &mut shader, &mut Sheet::new(width, height), None);
    prop_assert_eq!(shader.0.len(), all.len());
    for (place, values) in shader.0 {
        let seen = &all[&place];
        let mut right = Vec::new();
        right.extend(DEPTH.then_some(seen.depth));
        right.extend(W.then_some(seen.inv_w));
        right.extend(W.then_some(seen.w));
        right.extend(seen.attributes.iter().take(ATTRIBUTES));
        prop_assert_eq!(values, right, "{:?}", place);
    }
    Ok(())
}

#[test]
fn reproducible_whatever_the_shader_asks_for() {
    let tally = Tally::default();
    let cases = check(file!(), "reproducible_inputs", 4000, &anything(), |(view, poly)| {
        let all = probe::draw(&view, &poly).1;
        tally.add(all.len());
        picky::<false, false, 0>(&view, &poly, &all)?;
        picky::<true, false, 0>(&view, &poly, &all)?;
        picky::<false, true, 0>(&view, &poly, &all)?;
        picky::<false, false, 1>(&view, &poly, &all)?;
        picky::<true, false, 2>(&view, &poly, &all)?;
        picky::<true, true, { usize::MAX }>(&view, &poly, &all)
    });
    tally.report("pixels compared", 30 * cases);
}

fn depth_tests() -> impl Strategy<Value = DepthTest> {
    use Compare::{Always, Equal, Greater, GreaterEqual, Less, LessEqual, Never, NotEqual};
    let all = vec![Never, Less, Equal, LessEqual, Greater, NotEqual, GreaterEqual, Always];
    let source = prop_oneof![Just(DepthSource::Z), Just(DepthSource::InvW)];
    (prop::sample::select(all), any::<bool>(), source)
        .prop_map(|(compare, write, source)| DepthTest { compare, write, source })
}

/// Several polygons through one depth buffer, against a painter who knows every polygon's
/// pixels: what is kept, what is stored, what is shaded and what is counted.
#[test]
fn reproducible_depth_is_the_painters() {
    let list = prop::collection::vec((anything(), depth_tests()), 1..5);
    let (tally, hidden) = (Tally::default(), Tally::default());
    let strategy = (list, prop_oneof![Just(0.0_f32), Just(1.0), Just(0.5)]);
    let cases = check(file!(), "reproducible_depth", 6000, &strategy, |(list, clear)| {
        let (viewport, window) = (list[0].0.0.viewport, list[0].0.0.window);
        let (width, height) = list[0].0.0.size();
        let area = width as usize * height as usize;
        let (mut depths, mut ids) = (vec![clear; area], vec![0_u32; area]);
        let (mut right_depths, mut right_ids) = (depths.clone(), ids.clone());
        let mut tiler = list[0].0.0.tiler();
        for (id, ((view, poly), test)) in (1_u32..).zip(&list) {
            let view = View { viewport, window, ..view.clone() };
            // The painter. A shader that discards every third column leaves their depth alone.
            let mut count = [0_u64; 3];
            for ((y, x), seen) in probe::draw(&view, poly).1 {
                let at = (y - window.y0) as usize * width as usize + (x - window.x0) as usize;
                let new = match test.source {
                    DepthSource::Z => seen.depth,
                    DepthSource::InvW => seen.inv_w,
                };
                let passes = test.compare.passes(f32::from_bits(new), right_depths[at]);
                count[0] += 1;
                count[if passes { 1 } else { 2 }] += 1;
                if passes && x.rem_euclid(3) > 0 {
                    right_ids[at] = id;
                    if test.write {
                        right_depths[at] = f32::from_bits(new);
                    }
                }
            }
            tally.add(count[0] as usize);
            hidden.add(count[2] as usize);
            tiler.reset_stats();
            tiler
                .set_depth_test(*test)
                .set_precision(view.precision)
                .set_interpolation(&view.interpolation);
            let mut target = Plane::new(&mut ids, width, height).expect("its size");
            let mut buffer = Plane::new(&mut depths, width, height).expect("its size");
            tiler.draw(poly, &mut Sieve(id), &mut target, Some(&mut buffer));
            let stats = tiler.stats();
            let counted = [stats.pixels_covered, stats.pixels_shaded, stats.pixels_hidden];
            prop_assert_eq!(counted, count, "polygon {}", id);
            prop_assert_eq!(&ids, &right_ids, "polygon {}", id);
            let bits = |d: &[f32]| d.iter().map(|d| d.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&depths), bits(&right_depths), "polygon {}", id);
        }
        Ok(())
    });
    tally.report("pixels tested", 30 * cases);
    hidden.report("of them hidden", 3 * cases);
}

/// Draws an id, and discards every third column.
struct Sieve(u32);

impl Shader for Sieve {
    type Pixel = u32;
    const INPUTS: Inputs = Inputs::COVERAGE;

    fn shade(&mut self, block: &Block<'_>, out: &mut [u32; BLOCK]) -> u16 {
        out.fill(self.0);
        let kept = (0..16).filter(|lane| block.x(*lane).rem_euclid(3) > 0);
        // Bits beyond the mask are to be ignored.
        kept.fold(0, |mask, lane| mask | 1 << lane)
    }
}

/// The bits of two attributes. With `WHOLE` blocks are shaded in place and no more is asked for
/// than that, without, everything is, and every block is copied.
struct Pairs<const WHOLE: bool>;

impl<const WHOLE: bool> Shader for Pairs<WHOLE> {
    type Pixel = [u32; 2];
    const INPUTS: Inputs = if WHOLE { Inputs::attributes(2) } else { Inputs::ALL };
    const KEEPS_ALL: bool = WHOLE;

    fn shade(&mut self, block: &Block<'_>, out: &mut [[u32; 2]; BLOCK]) -> u16 {
        for (lane, pixel) in out.iter_mut().enumerate() {
            *pixel = [0, 1].map(|k| block.attributes.get(k).map_or(7, |a| a[lane].to_bits()));
        }
        block.mask
    }
}

/// The bits of depth, or of 1/w if that is said. If it asks for one of them, blocks are shaded in place; if it
/// asks for both, everything is asked for, and every block is copied.
struct Depths<const DEPTH: bool, const INV_W: bool>(bool);

impl<const DEPTH: bool, const INV_W: bool> Shader for Depths<DEPTH, INV_W> {
    type Pixel = u32;
    const INPUTS: Inputs = if DEPTH && INV_W {
        Inputs::ALL
    } else {
        Inputs { depth: DEPTH, inv_w: INV_W, ..Inputs::COVERAGE }
    };
    const KEEPS_ALL: bool = !(DEPTH && INV_W);

    fn shade(&mut self, block: &Block<'_>, out: &mut [u32; BLOCK]) -> u16 {
        *out = if self.0 { block.inv_w } else { block.depth }.map(f32::to_bits);
        block.mask
    }
}

/// Depth, or 1/w, is the same in place or copied.
fn depths_in_place<const DEPTH: bool, const INV_W: bool>(
    tiler: &mut Tiler,
    poly: &Poly,
    depths: &[f32],
    width: u32,
) -> Result<(), TestCaseError> {
    let mut draw = |in_place: bool| {
        let (mut depths, mut pixels) = (depths.to_vec(), vec![9_u32; depths.len()]);
        let stride = depths.len() / HEIGHT as usize;
        let plane = Plane::with_stride(&mut pixels, width, HEIGHT, stride);
        let depth = Plane::with_stride(&mut depths, width, HEIGHT, stride);
        let (mut target, mut depth) = (plane.expect("its size"), depth.expect("its size"));
        if in_place {
            tiler.draw(poly, &mut Depths::<DEPTH, INV_W>(INV_W), &mut target, Some(&mut depth));
        } else {
            tiler.draw(poly, &mut Depths::<true, true>(INV_W), &mut target, Some(&mut depth));
        }
        pixels
    };
    let (in_place, copied) = (draw(true), draw(false));
    prop_assert_eq!(in_place, copied);
    Ok(())
}

/// Rows of what is drawn in place or copied.
const HEIGHT: u32 = 23;

/// Whole blocks in the target's rows, rows that are prepared, and closures that say how much they
/// read, change nothing: rows of any length, whatever is hidden, and none of what lies between the
/// rows.
#[test]
fn reproducible_in_place_or_copied() {
    const STRIDE: usize = 211;
    let list = prop::collection::vec((anything(), depth_tests()), 1..4);
    let strategy = (list, 1..200_u32, -40..5_i32, 0..6_usize);
    let tally = Tally::default();
    let cases =
        check(file!(), "reproducible_in_place", 1500, &strategy, |(list, width, x, two)| {
            let area = STRIDE * HEIGHT as usize;
            let (mut depths, mut in_place) = (vec![0.5_f32; area], vec![[9_u32; 2]; area]);
            let (mut right_depths, mut copied) = (depths.clone(), in_place.clone());
            let (mut closure_depths, mut closures) = (depths.clone(), in_place.clone());
            let mut tiler = Tiler::new(Viewport::new(0, 0, 170, HEIGHT).expect("small"));
            tiler.set_origin(x, 0);
            for ((view, poly), test) in &list {
                // Most shaders read so many, most polygons have more: cut them.
                let mut poly = poly.clone();
                poly.attributes.iter_mut().for_each(|a| a.truncate(if two > 0 { 2 } else { 9 }));
                tiler
                    .set_depth_test(*test)
                    .set_precision(view.precision)
                    .set_interpolation(&view.interpolation);
                depths_in_place::<true, false>(&mut tiler, &poly, &depths, width)?;
                depths_in_place::<false, true>(&mut tiler, &poly, &depths, width)?;
                fn plane<P: Copy>(data: &mut [P], width: u32) -> Plane<'_, P> {
                    Plane::with_stride(data, width, HEIGHT, STRIDE).expect("its size")
                }
                let (mut target, mut depth) =
                    (plane(&mut in_place, width), plane(&mut depths, width));
                tiler.draw(&poly, &mut Pairs::<true>, &mut target, Some(&mut depth));
                let (mut target, mut depth) =
                    (plane(&mut copied, width), plane(&mut right_depths, width));
                tiler.draw(&poly, &mut Pairs::<false>, &mut target, Some(&mut depth));
                let (mut target, mut depth) =
                    (plane(&mut closures, width), plane(&mut closure_depths, width));
                let count = poly.attribute_count();
                let mut closure = Attributes::<2, _>(|pixel: &Fragment<'_>| {
                    [0, 1].map(|k| if k < count { pixel.attribute(k).to_bits() } else { 7 })
                });
                tiler.draw(&poly, &mut closure, &mut target, Some(&mut depth));
                let bits = |d: &[f32]| d.iter().map(|d| d.to_bits()).collect::<Vec<_>>();
                prop_assert_eq!(bits(&depths), bits(&right_depths));
                prop_assert_eq!(bits(&closure_depths), bits(&right_depths));
                prop_assert_eq!(&in_place, &copied);
                prop_assert_eq!(&closures, &copied);
            }
            tally.add(in_place.iter().filter(|pixel| **pixel != [9; 2]).count());
            Ok(())
        });
    tally.report("pixels drawn", 100 * cases);
}

/// Several targets at once get what each alone would.
#[test]
fn reproducible_in_several_targets_at_once() {
    check(file!(), "reproducible_targets", 2000, &anything(), |(view, poly)| {
        let all = probe::draw(&view, &poly).1;
        let (width, height) = view.size();
        let mut targets =
            (Sheet::<f32>::new(width, height), Sheet::<[u8; 4]>::new(width + 3, height), ());
        let mut shader = |f: &Fragment<'_>| (f.depth(), f.w().to_bits().to_le_bytes(), ());
        view.tiler().draw(&poly, &mut shader, &mut targets, None);
        for ((y, x), seen) in all {
            let (row, column) = ((y - view.window.y0) as u32, (x - view.window.x0) as u32);
            let depth = targets.0.pixels[(row * width + column) as usize];
            let w = targets.1.pixels[(row * (width + 3) + column) as usize];
            prop_assert_eq!(depth.map(f32::to_bits), Some(seen.depth));
            prop_assert_eq!(w, Some(seen.w.to_le_bytes()));
        }
        Ok(())
    });
}

/// The same polygons from plain arithmetic on every machine, and one number from all that a
/// shader sees of them: it is the same in debug and release, on any machine.
#[test]
fn reproducible_on_any_machine() {
    let mut state = 1_u64;
    let mut random = |least: f64, most: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        least + (most - least) * ((state >> 33) as f64 / f64::from(u32::MAX / 2))
    };
    let mut hash = 0xCBF2_9CE4_8422_2325_u64;
    let mut pixels = 0;
    for number in 0..600 {
        let viewport = Viewport::new(0, 0, 40 + number % 31, 30 + number % 23).expect("small");
        let mut poly = Poly::default();
        for _ in 0..3 + number % 4 {
            let w = random(0.1, 4.0);
            poly.positions.push([random(-w, w), random(-w, w), random(-0.2, w), w]);
            poly.attributes.push(vec![random(-1.0, 1.0) as f32, random(-9.0, 9.0) as f32]);
        }
        let precision = if number / 4 % 2 == 0 { Precision::Exact } else { Precision::Fast };
        let interpolation = vec![Interpolation::Perspective, Interpolation::NoPerspective];
        let view = View { precision, interpolation, ..View::whole(viewport) };
        for ((y, x), seen) in probe::draw(&view, &poly).1 {
            pixels += 1;
            let words = [y.cast_unsigned(), x.cast_unsigned(), seen.depth, seen.inv_w, seen.w];
            for word in words.iter().chain(&seen.attributes) {
                hash = (hash ^ u64::from(*word)).wrapping_mul(0x0000_0100_0000_01B3);
            }
        }
    }
    assert_eq!((pixels, hash), (140_966, 0xE07F_3772_11D4_20E4));
}
