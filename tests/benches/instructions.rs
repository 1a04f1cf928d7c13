//! Work whose instructions tests/benches/instructions.py counts: for `COUNT` things and for twice as
//! many, so that what happens once cancels out. What is not the library's happens once.
//!
//!     instructions CASE LEVEL PRECISION COUNT
//!
//! Without arguments, as `cargo bench` runs it, it does nothing.

#[expect(dead_code, reason = "each bench uses a part of it")]
mod quad;
#[path = "../scenes/mod.rs"]
#[expect(dead_code, reason = "each bench uses a part of it")]
mod scenes;

use std::f64::consts::TAU;
use std::hint::black_box;

use hyperspan::depth::DepthBounds;
use hyperspan::polygon::Vertex;
use hyperspan::shade::BLOCK;
use hyperspan::simd::Simd;
use hyperspan::space::Viewport;
use hyperspan::target::Plane;
use hyperspan::texture::Texture;
use hyperspan::tiler::{Precision, Tiler};
use quad::{Bits, Quad, Slope};
use scenes::TEXTURE_SIDE;
use scenes::draw::{Coloured, Stage, Textured};

const SIZE: (u32, u32) = (1920, 1080);
/// Rows of blocks are drawn, `COUNT` in each.
const ROWS: u32 = 64;
const MOST_BLOCKS: u32 = 96;
const MOST_TRIANGLES: u32 = 4000;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [case, level, precision, count] = &arguments[..] else { return };
    let simd = Simd::by_name(level).expect("an instruction set of this machine");
    let precision = match precision.as_str() {
        "fast" => Precision::Fast,
        "exact" => Precision::Exact,
        other => panic!("fast or exact, not {other}"),
    };
    let count = count.parse().expect("a number");
    let mut tiler = Tiler::new(Viewport::new(0, 0, SIZE.0, SIZE.1).expect("a small picture"));
    tiler.set_simd(simd).set_precision(precision);
    match case.as_str() {
        "texture" => texture(&mut tiler, count),
        "attributes" => attributes(&mut tiler, count),
        "hidden" => hidden(&mut tiler, count),
        "triangle" => triangles(&mut tiler, count),
        "quad" => polygons(&mut tiler, 4, count),
        "octagon" => polygons(&mut tiler, 8, count),
        "sliver" => slivers(&mut tiler, count),
        scene => frames(scene, precision, simd, count),
    }
}

/// Frames of a scene of tests/scenes; the depth buffer has bounds if the name ends in `+bounds`.
fn frames(name: &str, precision: Precision, simd: Simd, count: u32) {
    let (name, bounded) = match name.strip_suffix("+bounds") {
        Some(name) => (name, true),
        None => (name, false),
    };
    let all = scenes::all((960, 540));
    let scene = all.iter().find(|scene| scene.name == name).expect("a case or a scene");
    let mut stage = Stage::new(scene, precision, simd);
    stage.bounds = bounded.then(DepthBounds::new);
    (0..count).for_each(|_| stage.draw());
    black_box(stage.colour);
}

/// Some rows of a picture, of which `width` pixels are drawn.
struct Crop {
    width: u32,
    colour: Vec<[u8; 4]>,
    depth: Vec<f32>,
}

impl Crop {
    fn new(tiler: &mut Tiler, count: u32, depth: f32) -> Self {
        assert!(count <= MOST_BLOCKS);
        tiler.set_origin(320, 480);
        let area = (MOST_BLOCKS * ROWS) as usize * BLOCK;
        let width = count * BLOCK as u32;
        Self { width, colour: vec![[0; 4]; area], depth: vec![depth; area] }
    }

    fn planes(&mut self) -> (Plane<'_, [u8; 4]>, Plane<'_, f32>) {
        let stride = MOST_BLOCKS as usize * BLOCK;
        let colour = Plane::with_stride(&mut self.colour, self.width, ROWS, stride);
        let depth = Plane::with_stride(&mut self.depth, self.width, ROWS, stride);
        (colour.expect("its size"), depth.expect("its size"))
    }

    fn pixels(&self) -> u64 {
        u64::from(self.width * ROWS)
    }
}

/// Nearest texels with depth, as on a floor: 8 texels for each 10 pixels.
fn texture(tiler: &mut Tiler, count: u32) {
    let texel = |i: u32| [i as u8, (i >> 8) as u8, 9, 255];
    let rows: Vec<_> = (0..TEXTURE_SIDE * TEXTURE_SIDE).map(texel).collect();
    let texture = Texture::new(TEXTURE_SIDE, TEXTURE_SIDE, &rows).expect("its size");
    let mut crop = Crop::new(tiler, count, 1.0);
    let quad = Quad::new(Slope::Both, [6.0, 3.4]);
    let (mut target, mut depth) = crop.planes();
    tiler.draw(&black_box(quad).0, &mut Textured(&texture), &mut target, Some(&mut depth));
    assert_eq!(tiler.stats().pixels_shaded, crop.pixels());
    black_box(crop.colour);
}

/// Four attributes, all read.
fn attributes(tiler: &mut Tiler, count: u32) {
    let mut crop = Crop::new(tiler, count, 1.0);
    let quad = Quad::new(Slope::Both, [1.0, 0.3, 7.0, 100.0]);
    tiler.draw(&black_box(quad).0, &mut Bits::<4>, &mut crop.planes().0, None);
    assert_eq!(tiler.stats().pixels_shaded, crop.pixels());
    black_box(crop.colour);
}

/// Behind what is there.
fn hidden(tiler: &mut Tiler, count: u32) {
    let mut crop = Crop::new(tiler, count, 0.0);
    let quad = Quad::new(Slope::Both, [6.0, 3.4]);
    let (mut target, mut depth) = crop.planes();
    tiler.draw(&black_box(quad).0, &mut Bits::<2>, &mut target, Some(&mut depth));
    let stats = tiler.stats();
    assert_eq!((stats.pixels_covered, stats.pixels_shaded), (crop.pixels(), 0));
    black_box(crop.colour);
}

/// Triangles of 10 pixels with colours and depth, side by side.
fn triangles(tiler: &mut Tiler, count: u32) {
    const STEP: u32 = 12;
    const PER_ROW: u32 = SIZE.0 / STEP - 1;
    // Of ten pixels: half the square of 4.47 pixels.
    const SIDE: f64 = 4.472;
    let triangle = |i: u32| {
        // Turned and shifted in steps that come back only after thousands of triangles.
        let [turn, right, down] = [0.618_034, 0.754_878, 0.569_840].map(|g| f64::from(i) * g % 1.0);
        let (cos, sin) = (libm::cos(turn * TAU), libm::sin(turn * TAU));
        let [x, y] = [i % PER_ROW, i / PER_ROW].map(|c| f64::from((c + 1) * STEP));
        let corner = |across: f64, up: f64, k: u32| {
            let at = [x + right + across * cos - up * sin, y + down + across * sin + up * cos];
            let w = (2.0 + 98.0 * right) * (1.0 + 0.03 * f64::from(k));
            let half = [SIZE.0, SIZE.1].map(|side| f64::from(side) / 2.0);
            let position = [(at[0] / half[0] - 1.0) * w, (1.0 - at[1] / half[1]) * w, w - 1.0, w];
            let colour = [right as f32, down as f32, k as f32 / 2.0];
            Vertex::new(position, colour)
        };
        [corner(0.0, 0.0, 0), corner(SIDE, 0.0, 1), corner(0.0, SIDE, 2)]
    };
    let triangles: Vec<[Vertex<3, [f64; 4]>; 3]> = (0..MOST_TRIANGLES).map(triangle).collect();
    let area = (SIZE.0 * SIZE.1) as usize;
    let (mut colour, mut depth) = (vec![[0; 4]; area], vec![1.0; area]);
    let mut target = Plane::new(&mut colour, SIZE.0, SIZE.1).expect("its size");
    let mut depth = Plane::new(&mut depth, SIZE.0, SIZE.1).expect("its size");
    for triangle in &triangles[..count as usize] {
        tiler.draw(black_box(triangle), &mut Coloured, &mut target, Some(&mut depth));
    }
    let pixels = tiler.stats().pixels_shaded as f64 / f64::from(count);
    assert!((9.5..10.5).contains(&pixels), "{pixels} pixels each");
    black_box(colour);
}

/// Takes a place in the picture to clip space, at `w`.
fn unproject(at: [f64; 2], w: f64) -> [f64; 4] {
    let half = [SIZE.0, SIZE.1].map(|side| f64::from(side) / 2.0);
    [(at[0] / half[0] - 1.0) * w, (1.0 - at[1] / half[1]) * w, w - 1.0, w]
}

/// Draws the first `count` with colours and depth.
fn draw_all(tiler: &mut Tiler, polygons: &[Vec<Vertex<3, [f64; 4]>>], count: u32) {
    let area = (SIZE.0 * SIZE.1) as usize;
    let (mut colour, mut depth) = (vec![[0; 4]; area], vec![1.0; area]);
    let mut target = Plane::new(&mut colour, SIZE.0, SIZE.1).expect("its size");
    let mut depth = Plane::new(&mut depth, SIZE.0, SIZE.1).expect("its size");
    for polygon in &polygons[..count as usize] {
        let polygon = black_box(polygon.as_slice());
        tiler.draw(polygon, &mut Coloured, &mut target, Some(&mut depth));
    }
    black_box(colour);
}

/// Flat polygons of `n` corners and some 40 pixels, side by side, with colours that are affine.
fn polygons(tiler: &mut Tiler, n: u32, count: u32) {
    const STEP: u32 = 16;
    const PER_ROW: u32 = SIZE.0 / STEP - 1;
    let polygon = |i: u32| {
        let [turn, right, down] = [0.618_034, 0.754_878, 0.569_840].map(|g| f64::from(i) * g % 1.0);
        let [x, y] = [i % PER_ROW, i / PER_ROW].map(|c| f64::from((c + 1) * STEP));
        let corner = |k: u32| {
            let angle = (turn + f64::from(k) / f64::from(n)) * TAU;
            let [across, up] = [4.5 * libm::cos(angle), 3.5 * libm::sin(angle)];
            // 1/w is affine in the picture.
            let w = (2.0 + 98.0 * right) / (1.0 + 0.02 * across + 0.03 * up);
            let position = unproject([x + right + across, y + down + up], w);
            let colour = [right + across * w * 1e-4, down + up * w * 1e-4, w / 100.0];
            Vertex::new(position, colour.map(|c| c as f32))
        };
        (0..n).map(corner).collect()
    };
    draw_all(tiler, &(0..MOST_TRIANGLES).map(polygon).collect::<Vec<_>>(), count);
    assert_eq!(tiler.stats().polygons, u64::from(count));
}

/// Triangles a pixel thick and 100 long, at a w ratio of 10^4, over 10 rows.
fn slivers(tiler: &mut Tiler, count: u32) {
    let sliver = |i: u32| {
        let [right, down] = [0.754_878, 0.569_840].map(|g| f64::from(i) * g % 1.0);
        let [x, y] = [100.0 + 1600.0 * right, 20.0 + 1000.0 * down];
        let corners = [([x, y], 1.0), ([x + 100.0, y + 10.0], 1e4), ([x, y + 1.0], 80.0)];
        let corner = |(k, (at, w)): (u32, ([f64; 2], f64))| {
            Vertex::new(unproject(at, w), [right as f32, down as f32, k as f32 / 2.0])
        };
        (0..).zip(corners).map(corner).collect()
    };
    draw_all(tiler, &(0..MOST_TRIANGLES).map(sliver).collect::<Vec<_>>(), count);
    assert_eq!(tiler.stats().polygons, u64::from(count));
}
