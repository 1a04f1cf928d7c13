//! The division and the snap, on up to eight vertices of any bits and any viewport, clipped or
//! not. Nothing panics, and:
//!
//! - all vertices come out in their order but those with w <= 0;
//! - each place in the framebuffer is P1's formula, bit for bit, and on the subpixel grid it is
//!   that, rounded to nearest even in exact integers, and never beyond the grid's reach;
//! - the area on the grid is the oracle's;
//! - the whole array is every number over w;
//! - all coordinates times a power of two give the same places, bit for bit;
//! - what the clipper leaves of numbers up to 1e100 lies within the reach of the grid, but for a
//!   hair, where w is not next to nothing.

use hyperspan::clip::{Clipped, Clipper, VertexArrays};
use hyperspan::divide::{ScreenVertex, divide, divide_array, snapped_area};
use hyperspan::fixed::Subpixel;
use hyperspan::space::{DepthRange, Grid, Viewport};

use super::bytes::Bytes;
use super::shape::Shape;
use crate::oracle::coverage::{doubled_area, framebuffer, steps};

pub(crate) fn divided(data: &[u8]) {
    let bytes = &mut Bytes(data);
    let corner = |bytes: &mut Bytes<'_>| match bytes.below(4) {
        0 => i32::from_le_bytes(bytes.array()),
        1 => bytes.pick(&[i32::MIN, i32::MAX, i32::MAX - 16384, 1 << 24]),
        2 => bytes.small(),
        _ => 0,
    };
    let [x, y] = [corner(bytes), corner(bytes)];
    let sides = bytes.pick(&[(64, 64), (1, 1), (16384, 16384), (7, 16383), (0, 0), (640, 480)]);
    let viewport = Viewport::new(x, y, sides.0, sides.1)
        .expect("sides of 16384 at most")
        .with_grid(bytes.pick(&[Grid::Sixteen, Grid::Eight]))
        .with_depth_range(bytes.pick(&[DepthRange::ZeroToOne, DepthRange::MinusOneToOne]));
    let clips = bytes.below(2) == 1;
    let exponent = bytes.small();
    let shape = Shape::new(bytes, 1, viewport, (x, y));
    let mut arrays = VertexArrays::new(1);
    for (position, attribute) in shape.positions.iter().zip(&shape.attributes) {
        arrays.push(*position, [f64::from(*attribute)]);
    }
    let tame = shape.positions.iter().flatten().all(|c| c.abs() <= 1e100);
    let mut is_clipped = false;
    if clips && tame && sides.0 > 0 {
        is_clipped = Clipper::new(viewport).clip(&mut arrays) != Clipped::Outside;
    }

    let mut places = Vec::new();
    divide(arrays.positions(), viewport, &mut places);
    check_places(viewport, &arrays, &places);
    if is_clipped {
        check_reach(viewport, &arrays, &places);
    }
    check_area(&places);
    for i in 0..arrays.len() {
        let [x, y, z, w] = arrays.position(i);
        let numbers = [x, y, z, 1.0, arrays.attributes(i)[0]];
        let all: Vec<u64> = divide_array(&arrays, i).map(number).collect();
        assert_eq!(all, numbers.map(|n| number(n / w)), "the array of vertex {i}");
    }
    check_scaled(viewport, &arrays, exponent, &places);
}

/// All NaNs are one.
fn number(n: f64) -> u64 {
    if n.is_nan() { f64::NAN.to_bits() } else { n.to_bits() }
}

fn check_places(viewport: Viewport, arrays: &VertexArrays, places: &[ScreenVertex]) {
    let behind = |i: &usize| arrays.position(*i)[3] <= 0.0;
    let named: Vec<usize> = (0..arrays.len()).filter(|i| !behind(i)).collect();
    let found: Vec<usize> = places.iter().map(|place| place.vertex as usize).collect();
    assert_eq!(found, named, "which vertices have a place");
    for place in places {
        let right = framebuffer(viewport, arrays.position(place.vertex as usize));
        assert_eq!(place.framebuffer.map(number), right.map(number), "in the framebuffer");
        let corner = [viewport.rect().x0, viewport.rect().y0];
        for ((snapped, at), corner) in place.snapped.iter().zip(place.framebuffer).zip(corner) {
            let right = snap(viewport.grid(), at, corner);
            assert_eq!(i64::from(snapped.bits()), right, "{:?}", place.framebuffer);
        }
    }
}

/// The grid's reach, 16 fraction bits.
const REACH: i64 = (Subpixel::REACH as i64) << 16;

/// From the viewport's corner, 16 fraction bits; in integers alone.
fn snap(grid: Grid, place: f64, corner: i32) -> i64 {
    if place.is_nan() {
        // As the framebuffer's 0.
        return (-65536 * i64::from(corner)).clamp(-REACH, REACH);
    }
    let bits = place.to_bits();
    let biased = (bits >> 52 & 0x7FF) as i32;
    let fraction = i128::from(bits & ((1 << 52) - 1));
    let magnitude = if biased == 0 { fraction } else { fraction | 1 << 52 };
    // place = magnitude 2^exponent, in steps of the grid.
    let exponent = biased.max(1) - 1075 + steps(grid).ilog2() as i32;
    let whole = if exponent >= 0 {
        magnitude << exponent.min(60)
    } else if exponent < -100 {
        0
    } else {
        let (half, low) = (1_i128 << (-exponent - 1), magnitude & ((1 << -exponent) - 1));
        let down = magnitude >> -exponent;
        let up = low > half || (low == half && down & 1 == 1);
        down + i128::from(up)
    };
    let whole = if place < 0.0 { -whole } else { whole };
    let offset = whole * i128::from(65536 / steps(grid)) - (i128::from(corner) << 16);
    offset.clamp((-REACH).into(), REACH.into()) as i64
}

/// Within the guard band, but for a hair.
fn check_reach(viewport: Viewport, arrays: &VertexArrays, places: &[ScreenVertex]) {
    let corner = [viewport.rect().x0, viewport.rect().y0].map(f64::from);
    let largest = arrays.positions().flatten().map(f64::abs).fold(0.0, f64::max);
    for place in places {
        // A w that is next to nothing beside the others is rounding's; subnormals have few bits.
        if arrays.position(place.vertex as usize)[3] < (1e-6 * largest).max(1e-280) {
            continue;
        }
        for (at, corner) in place.framebuffer.iter().zip(corner) {
            let hair = 1e-9 + corner.abs() * 1e-15;
            let from_corner = (at - corner).abs();
            assert!(from_corner <= 32767.0 + hair, "{place:?} of {arrays:?} on {viewport:?}");
        }
    }
}

fn check_area(places: &[ScreenVertex]) {
    let points: Vec<[i64; 2]> =
        places.iter().map(|place| place.snapped.map(|c| i64::from(c.bits()))).collect();
    assert_eq!(snapped_area(places), doubled_area(&points), "area of {points:?}");
}

fn check_scaled(viewport: Viewport, arrays: &VertexArrays, exponent: i32, right: &[ScreenVertex]) {
    let factor = 2.0_f64.powi(exponent);
    let times: Vec<[f64; 4]> = arrays.positions().map(|p| p.map(|c| c * factor)).collect();
    let exact = |(p, q): ([f64; 4], &[f64; 4])| (0..4).all(|k| q[k] / factor == p[k]);
    if arrays.positions().zip(&times).all(exact) {
        let mut places = Vec::new();
        divide(times.into_iter(), viewport, &mut places);
        let bits =
            |place: &ScreenVertex| (place.vertex, place.framebuffer.map(number), place.snapped);
        assert!(places.iter().map(bits).eq(right.iter().map(bits)), "times 2^{exponent}");
    }
}
