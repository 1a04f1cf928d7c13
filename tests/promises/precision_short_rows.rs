//! P2, `Exact`, in rows of few blocks: values that a quick test shows to be rounded right, against the careful
//! way, which finds every value with a bound of its own.

use crate::oracle::shapes::{Tally, check, unproject};
use hyperspan::polygon::Vertex;
use hyperspan::shade::{BLOCK, Block, Inputs, Shader};
use hyperspan::space::Viewport;
use hyperspan::target::Plane;
use hyperspan::tiler::{Precision, Tiler};
use proptest::prelude::*;

/// A power of two, so that the centres of pixels are exact in clip space.
const SIDE: u32 = 128;

/// The most attributes that are prepared for a row; with one more each goes the careful way.
const QUICK: usize = 11;
const CAREFUL: usize = QUICK + 1;

/// Stores the first [`QUICK`] of `N` attributes.
struct Bits<const N: usize>;

impl<const N: usize> Shader for Bits<N> {
    type Pixel = [u32; QUICK];
    const INPUTS: Inputs = Inputs::attributes(N);
    const KEEPS_ALL: bool = true;

    fn shade(&mut self, block: &Block<'_>, out: &mut [[u32; QUICK]; BLOCK]) -> u16 {
        for (k, attribute) in block.attributes.iter().enumerate().take(QUICK) {
            for (pixel, value) in out.iter_mut().zip(attribute) {
                pixel[k] = value.to_bits();
            }
        }
        block.mask
    }
}

/// A triangle's vertices in pixels, and w; its attributes.
type Triangle = [([f64; 2], f64, [f32; QUICK]); 3];

/// The middle of a pixel.
fn centre() -> impl Strategy<Value = f64> {
    (0..SIDE).prop_map(|c| f64::from(c) + 0.5)
}

/// Corners anywhere, on centres, or at a right angle between legs of as many pixels as make gradients exact: then
/// values lie on ties.
fn corners() -> impl Strategy<Value = [[f64; 2]; 3]> {
    let side = f64::from(SIDE);
    let right_angle = ([centre(), centre()], 3..7).prop_map(move |([x, y], legs)| {
        let inward = |c: f64| c + f64::from(1 << legs) * (side / 2.0 - c).signum();
        [[x, y], [inward(x), y], [x, inward(y)]]
    });
    prop_oneof![
        prop::array::uniform3([0.0..side, 0.0..side]),
        prop::array::uniform3([centre(), centre()]),
        right_angle,
    ]
}

/// The same w; about the same, of few bits or many; or two that are so far away that of 1/w little is right.
fn ws() -> impl Strategy<Value = [f64; 3]> {
    let near = prop_oneof![0.0..3.0_f64, (0..24).prop_map(f64::from)].prop_map(f64::exp2);
    let quarters = (4..32).prop_map(|w| f64::from(w) / 4.0);
    let far = [0.0..45.0_f64, 0.0..1.0].prop_map(|[a, b]| [a.exp2(), (a + b).exp2()]);
    prop_oneof![
        Just([1.0; 3]),
        prop::array::uniform3(near),
        prop::array::uniform3(quarters),
        far.prop_map(|[a, b]| [a, 1.0, b]),
    ]
}

/// An attribute at the vertices, or the column of pixels in which it is to be 0.
fn attribute() -> impl Strategy<Value = Result<[f32; 3], f64>> {
    let value = prop_oneof![-1.0..1.0_f32, 0.5..1.5_f32, -0.01..1.0_f32, Just(0.0_f32)];
    prop_oneof![3 => prop::array::uniform3(value).prop_map(Ok), 2 => centre().prop_map(Err)]
}

fn triangles() -> impl Strategy<Value = Triangle> {
    let attributes = prop::array::uniform11(attribute());
    (corners(), ws(), attributes).prop_map(|(corners, ws, attributes)| {
        core::array::from_fn(|i| {
            let ([x, y], w) = (corners[i], ws[i]);
            let zero_in = |column: f64| ((x - column) * w / f64::from(SIDE)) as f32;
            let values = attributes.map(|given| given.map_or_else(zero_in, |values| values[i]));
            ([x, y], w, values)
        })
    })
}

fn drawn<const N: usize>(triangle: &Triangle, pixels: &mut [[u32; QUICK]]) -> u64 {
    let viewport = Viewport::new(0, 0, SIDE, SIDE).expect("small");
    let vertices = triangle.each_ref().map(|(at, w, values)| {
        let mut attributes = [0.75; N];
        attributes[..QUICK].copy_from_slice(values);
        Vertex::new(unproject(viewport, *at, 0.5, *w), attributes)
    });
    let mut tiler = Tiler::new(viewport);
    tiler.set_precision(Precision::Exact);
    let mut target = Plane::new(pixels, SIDE, SIDE).expect("as many pixels");
    tiler.draw(&vertices, &mut Bits::<N>, &mut target, None);
    tiler.stats().pixels_shaded
}

/// What goes wrong without a part of the quick test is rare (a value in some hundred million, of triangles at random):
/// so most of these have ties, columns of zeros, or hardly any 1/w.
#[test]
fn precision_of_short_rows_is_that_of_the_careful_way() {
    let compared = Tally::default();
    let cases = check(file!(), "precision_short_rows", 3000, &triangles(), |triangle| {
        let empty = || vec![[7; QUICK]; (SIDE * SIDE) as usize];
        let (mut quick, mut careful) = (empty(), empty());
        let pixels = drawn::<QUICK>(&triangle, &mut quick);
        prop_assert_eq!(drawn::<CAREFUL>(&triangle, &mut careful), pixels);
        if let Some(i) = quick.iter().zip(&careful).position(|(a, b)| a != b) {
            let values = [quick[i], careful[i]].map(|pixel| pixel.map(f32::from_bits));
            prop_assert!(false, "pixel {i}: {values:?}");
        }
        compared.add(pixels as usize);
        Ok(())
    });
    compared.report("pixels compared", 500 * cases);
}
