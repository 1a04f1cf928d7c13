//! Scenes that need no files: the benches draw them large, tests/same_hash.rs small.
//!
//! Made of `+ - * /`, `sqrt` and `libm` alone, so that they are the same on every machine; like
//! those that docs/benchmarks.md measures other renderers on, in kind and number. The number of
//! small polygons goes with the picture's area, so that their size in pixels stays.

pub(crate) mod draw;
mod large;
mod random;
mod small;

use glam::{DMat4, DVec3};
use hyperspan::camera::{
    DepthConvention, DepthPlanes, look_at, multiply, orthographic, perspective,
};
use hyperspan::space::DepthRange;

use random::Random;

/// The side of all textures, in texels.
pub(crate) const TEXTURE_SIDE: u32 = 256;

/// A vertex in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    pub(crate) position: [f64; 3],
    /// Red, green, blue; or u, v.
    pub(crate) attributes: [f32; 3],
}

/// What a face's pixels are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// The colours at its vertices.
    Coloured,
    /// The nearest texel of one of the scene's textures.
    Textured(usize),
}

/// A convex polygon: `indices[start..end]` of a scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    pub(crate) start: usize,
    pub(crate) end: usize,
    pub(crate) look: Look,
}

/// What is drawn, and from where. Depth is "standard": near is 0, the nearer wins.
#[derive(Debug)]
pub(crate) struct Scene {
    pub(crate) name: &'static str,
    /// (width, height) of the picture.
    pub(crate) size: (u32, u32),
    /// From world to clip space.
    pub(crate) camera: DMat4,
    /// The least w in view.
    pub(crate) near: f64,
    pub(crate) corners: Vec<Corner>,
    pub(crate) indices: Vec<u32>,
    pub(crate) faces: Vec<Face>,
    /// Rows from the top.
    pub(crate) textures: Vec<Vec<[u8; 4]>>,
}

/// Every scene, for a picture of this size.
pub(crate) fn all(size: (u32, u32)) -> Vec<Scene> {
    vec![
        large::floor(size),
        large::floor_roll(size),
        large::room(size),
        large::walls(size),
        small::mesh(size),
        small::mesh_full(size),
        small::soup(size),
        large::layers_ftb(size),
        large::layers_btf(size),
        small::ngons(size),
        small::clip(size),
        small::hairs(size),
        small::boxes(size),
        large::board(size),
    ]
}

/// A camera at `eye` that looks towards `target`.
#[derive(Clone, Copy, Debug)]
struct View {
    eye: [f64; 3],
    target: [f64; 3],
    up: [f64; 3],
    fov_y_degrees: f64,
    near: f64,
    far: f64,
}

impl View {
    /// From the origin along -z.
    fn ahead(near: f64, far: f64) -> Self {
        let (eye, target) = ([0.0; 3], [0.0, 0.0, -1.0]);
        Self { eye, target, up: [0.0, 1.0, 0.0], fov_y_degrees: 60.0, near, far }
    }

    /// From `eye`, `yaw` degrees to the right of -z and `pitch` degrees up.
    fn turned(eye: [f64; 3], yaw: f64, pitch: f64) -> Self {
        let target = add(eye, direction(yaw, pitch));
        Self { eye, target, ..Self::ahead(0.1, 1000.0) }
    }

    fn planes(&self) -> DepthPlanes {
        DepthPlanes {
            near: self.near,
            far: self.far,
            convention: DepthConvention::Standard,
            range: DepthRange::ZeroToOne,
        }
    }

    fn matrix(&self, size: (u32, u32)) -> DMat4 {
        let [eye, target, up] = [self.eye, self.target, self.up].map(DVec3::from_array);
        let aspect = f64::from(size.0) / f64::from(size.1);
        let camera = perspective(self.fov_y_degrees, aspect, self.planes());
        multiply(camera.expect("a lens"), look_at(eye, target, up).expect("a direction"))
    }

    /// Without perspective, `height` units high.
    fn flat_matrix(&self, size: (u32, u32), height: f64) -> DMat4 {
        let [eye, target, up] = [self.eye, self.target, self.up].map(DVec3::from_array);
        let aspect = f64::from(size.0) / f64::from(size.1);
        let half = height / 2.0;
        let sides = [-half * aspect, half * aspect, -half, half];
        let camera = orthographic(sides[0], sides[1], sides[2], sides[3], self.planes());
        multiply(camera.expect("a lens"), look_at(eye, target, up).expect("a direction"))
    }

    /// For one from [`ahead`](Self::ahead): the world position at pixel (x, y), `depth` away
    /// along the view axis.
    fn at(&self, size: (u32, u32), [x, y]: [f64; 2], depth: f64) -> [f64; 3] {
        let (width, height) = (f64::from(size.0), f64::from(size.1));
        let half = libm::tan(self.fov_y_degrees.to_radians() / 2.0);
        let ray = [
            (2.0 * x / width - 1.0) * half * width / height,
            (1.0 - 2.0 * y / height) * half,
            -1.0,
        ];
        scaled(ray, depth)
    }
}

impl Scene {
    fn new(name: &'static str, size: (u32, u32), view: &View) -> Self {
        Self {
            name,
            size,
            camera: view.matrix(size),
            near: view.near,
            corners: Vec::new(),
            indices: Vec::new(),
            faces: Vec::new(),
            textures: Vec::new(),
        }
    }

    /// A face with vertices of its own.
    fn face<const N: usize>(&mut self, look: Look, corners: &[([f64; 3], [f32; N])]) {
        let start = self.indices.len();
        for (position, given) in corners {
            let mut attributes = [0.0; 3];
            attributes[..N].copy_from_slice(given);
            self.indices.push(index(self.corners.len()));
            self.corners.push(Corner { position: *position, attributes });
        }
        self.faces.push(Face { start, end: self.indices.len(), look });
    }

    /// A triangle of vertices that are there.
    fn triangle(&mut self, corners: [usize; 3]) {
        let start = self.indices.len();
        self.indices.extend(corners.map(index));
        self.faces.push(Face { start, end: start + 3, look: Look::Coloured });
    }

    /// A checkerboard of two colours with some noise; returns its number.
    fn texture(&mut self, random: &mut Random, light: [u8; 3], dark: [u8; 3]) -> usize {
        let texel = |i: u32| {
            let (x, y) = (i % TEXTURE_SIDE, i / TEXTURE_SIDE);
            let base = if (x / 32 + y / 32) % 2 == 1 { light } else { dark };
            let noise = (random.bits() >> 58) as u8;
            let [r, g, b] = base.map(|c| c.saturating_add(noise));
            [r, g, b, 255]
        };
        self.textures.push((0..TEXTURE_SIDE * TEXTURE_SIDE).map(texel).collect());
        self.textures.len() - 1
    }
}

/// As many of `full`, which are those of 1920 x 1080, as there is room for.
fn in_proportion(size: (u32, u32), full: usize) -> usize {
    // In 64 bits also where `usize` has 32.
    (full as u64 * u64::from(size.0 * size.1) / (1920 * 1080)) as usize
}

fn index(i: usize) -> u32 {
    u32::try_from(i).expect("few vertices")
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn scaled(a: [f64; 3], by: f64) -> [f64; 3] {
    a.map(|c| c * by)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    scaled(a, 1.0 / dot(a, a).sqrt())
}

/// (cos, sin).
fn turn(angle: f64) -> [f64; 2] {
    [libm::cos(angle), libm::sin(angle)]
}

/// `yaw` degrees to the right of -z, `pitch` degrees up.
fn direction(yaw: f64, pitch: f64) -> [f64; 3] {
    let ([cos_yaw, sin_yaw], [cos_pitch, sin_pitch]) =
        (turn(yaw.to_radians()), turn(pitch.to_radians()));
    [sin_yaw * cos_pitch, sin_pitch, -cos_yaw * cos_pitch]
}
