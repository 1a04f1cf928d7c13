//! Strategies that make polygons, viewports and windows, and how properties are run.

use hyperspan::space::{DepthRange, PixelRect, Viewport};
use hyperspan::varying::Interpolation;
use proptest::prelude::*;
use proptest::test_runner::{Config, FileFailurePersistence, TestRunner};

use super::Poly;
use super::coverage::framebuffer;
use super::probe::View;

/// Runs a property on about `cases` inputs (PROPTEST_CASES / 256 as many, where it is set);
/// inputs that failed are kept beside `file`, with the extension `regressions`, and tried first.
/// Returns the number of cases.
pub(crate) fn check<S: Strategy>(
    file: &'static str,
    name: &'static str,
    cases: u32,
    strategy: &S,
    property: impl Fn(S::Value) -> Result<(), TestCaseError>,
) -> u64 {
    let scale = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(256);
    let cases = (cases * scale / 256).max(1);
    let mut config = Config::with_cases(cases);
    config.source_file = Some(file);
    config.test_name = Some(name);
    config.failure_persistence = Some(Box::new(FileFailurePersistence::WithSource("regressions")));
    config.max_shrink_iters = 4000;
    if let Err(failure) = TestRunner::new(config).run(strategy, property) {
        panic!("{name}: {failure}");
    }
    u64::from(cases)
}

/// Counts what a property looked at, so that it cannot pass by looking at nothing.
#[derive(Debug, Default)]
pub(crate) struct Tally(std::cell::Cell<u64>);

impl Tally {
    pub(crate) fn add(&self, count: usize) {
        self.0.set(self.0.get() + count as u64);
    }

    pub(crate) fn count(&self) -> u64 {
        self.0.get()
    }

    /// Says how many there were; there must be `least`.
    #[expect(clippy::print_stdout, reason = "what a test looked at is part of its result")]
    pub(crate) fn report(&self, what: &str, least: u64) {
        println!("{what}: {}", self.0.get());
        assert!(self.0.get() >= least, "only {} {what}; expected {least}", self.0.get());
    }
}

/// Sides from 1 to 8192 pixels.
fn side() -> impl Strategy<Value = u32> {
    prop_oneof![Just(1), 2_u32..64, Just(64), 65_u32..1024, Just(1920), Just(8192), 8000_u32..8192]
}

/// Viewports, most of them with their corner at the origin, and of either range of depth.
pub(crate) fn viewport() -> impl Strategy<Value = Viewport> {
    let range = prop_oneof![Just(DepthRange::ZeroToOne), Just(DepthRange::MinusOneToOne)];
    let corner = prop_oneof![3 => Just(0), 1 => -300_i32..300, 1 => -2_000_000_i32..2_000_000];
    (corner.clone(), corner, side(), side(), range).prop_map(|(x, y, w, h, range)| {
        Viewport::new(x, y, w, h).expect("sides up to 8192").with_depth_range(range)
    })
}

/// Three points in the framebuffer, as pixels from the viewport's corner, for a viewport of
/// (w, h) pixels.
pub(crate) fn corners(w: u32, h: u32) -> impl Strategy<Value = [[f64; 2]; 3]> {
    let (w, h) = (f64::from(w), f64::from(h));
    let near = || [-0.3..1.3, -0.3..1.3].prop_map(move |[x, y]: [f64; 2]| [x * w, y * h]);
    let far = || [-32_000.0..32_000.0, -32_000.0..32_000.0];
    let step = |most: f64| [-most..most, -most..most];
    let add = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
    let centre = |p: [f64; 2]| p.map(|c| c.floor() + 0.5);
    prop_oneof![
        4 => [near(), near(), near()],
        1 => [far(), far(), far()],
        1 => (near(), far(), far()).prop_map(|(a, b, c)| [a, b, c]),
        // Slivers: two corners within a hair.
        1 => (near(), near(), step(0.01)).prop_map(move |(a, b, d)| [a, b, add(b, d)]),
        1 => (far(), far(), step(1.0)).prop_map(move |(a, b, d)| [a, b, add(b, d)]),
        // Small ones.
        1 => (near(), step(4.0), step(4.0)).prop_map(move |(a, d, e)| [a, add(a, d), add(a, e)]),
        1 => [near(), near(), near()].prop_map(move |p| p.map(centre)),
        1 => (near(), step(6.0), step(6.0))
            .prop_map(move |(a, d, e)| [a, add(a, d), add(a, e)].map(centre)),
    ]
}

/// The clip position with the given w and z/w that lands on `at`, in pixels from the viewport's
/// corner.
pub(crate) fn unproject(viewport: Viewport, at: [f64; 2], depth: f64, w: f64) -> [f64; 4] {
    let (half_w, half_h) = (f64::from(viewport.width()) / 2.0, f64::from(viewport.height()) / 2.0);
    [(at[0] - half_w) / half_w * w, (half_h - at[1]) / half_h * w, depth * w, w]
}

/// Without the hair by which rounding has put z out of its range.
pub(crate) fn in_range([x, y, z, w]: [f64; 4]) -> [f64; 4] {
    let z = z.clamp(-w, w);
    [x, y, if z < 0.0 && z > -1e-12 * w { 0.0 } else { z }, w]
}

/// Points of a convex polygon as weights of a triangle's corners: on the ellipse within, at
/// angles that `jitter` (0 to 1) disturbs; the corners themselves if there are three.
fn inscribed(jitter: &[f64]) -> Vec<[f64; 3]> {
    if jitter.len() == 3 {
        return vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    }
    let weights = |(i, j): (usize, &f64)| {
        let angle = (i as f64 + 0.9 * j) * std::f64::consts::TAU / jitter.len() as f64;
        let (s, c) = (0.4 * angle.sin(), 0.4 * angle.cos());
        let (e, f) = (c / 2.0_f64.sqrt(), s / 6.0_f64.sqrt());
        [1.0 / 3.0 + e + f, 1.0 / 3.0 - e + f, 1.0 / 3.0 - 2.0 * f]
    };
    jitter.iter().enumerate().map(weights).collect()
}

/// An attribute: how it is interpolated, and its values at the triangle's corners.
#[derive(Clone, Debug)]
struct Varying {
    mode: Interpolation,
    corners: [f64; 3],
}

fn varying() -> impl Strategy<Value = Varying> {
    use Interpolation::{Flat, NoPerspective, Perspective};
    let mode = prop_oneof![6 => Just(Perspective), 2 => Just(NoPerspective), 1 => Just(Flat)];
    let three = |r: std::ops::Range<f64>| [r.clone(), r.clone(), r];
    let values = prop_oneof![
        4 => three(-1.0..1.0),
        2 => three(0.0..1.0),
        2 => three(0.0..1000.0),
        1 => three(-1e6..1e6),
        1 => (three(-1.0..1.0), -140..120_i32).prop_map(|(v, e)| v.map(|s| s * 2.0_f64.powi(e))),
        1 => (-9.0..9.0).prop_map(|s| [s, s, s]),
        1 => three(-9.0..9.0).prop_map(|v| v.map(f64::round)),
    ];
    (mode, values).prop_map(|(mode, corners)| Varying { mode, corners })
}

/// A flat polygon in front of the eye, with affine attributes, and where to look at it.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) viewport: Viewport,
    /// At most some 1000 pixels, on the polygon or near it.
    pub(crate) window: PixelRect,
    pub(crate) interpolation: Vec<Interpolation>,
    pub(crate) poly: Poly,
}

impl Scene {
    /// What to draw it through, in `Exact`.
    pub(crate) fn view(&self) -> View {
        let interpolation = self.interpolation.clone();
        View { window: self.window, interpolation, ..View::whole(self.viewport) }
    }
}

/// Flat polygons of 3 to 12 vertices with up to 5 attributes; at the corners of the triangle
/// around it, w is a power of two up to 2^`exponent`.
pub(crate) fn scenes(exponent: f64) -> impl Strategy<Value = Scene> {
    let depths = prop_oneof![
        6 => [0.0..=1.0, 0.0..=1.0, 0.0..=1.0],
        1 => (0.0..=1.0).prop_map(|d| [d, d, d]),
        1 => Just([0.0, 0.0, 1.0]),
    ];
    let ws = prop_oneof![
        6 => [0.0..exponent, 0.0..exponent, 0.0..exponent],
        1 => (0.0..exponent).prop_map(|e| [e, e, e]),
        1 => (0.0..exponent).prop_map(|e| [0.0, 0.0, e]),
    ];
    let shape = viewport().prop_flat_map(|v| (Just(v), corners(v.width(), v.height())));
    let jitter = prop_oneof![
        2 => prop::collection::vec(0.0..1.0, 3),
        3 => prop::collection::vec(0.0..1.0, 4..=12),
    ];
    let varyings = prop::collection::vec(varying(), 0..=5);
    (shape, ws, depths, jitter, varyings, look()).prop_map(
        |((viewport, corners), ws, depths, jitter, varyings, look)| {
            let ws = ws.map(f64::exp2);
            let mut poly = Poly::default();
            for b in inscribed(&jitter) {
                let at = [0, 1].map(|i| mean(&b, &corners.map(|c| c[i])));
                // On the plane through the corners, 1/w is linear in the framebuffer.
                let l = [0, 1, 2].map(|k| b[k] / ws[k]);
                let sum = l[0] + l[1] + l[2];
                let depth = mean(&b, &depths);
                let depth = match viewport.depth_range() {
                    DepthRange::ZeroToOne => depth,
                    DepthRange::MinusOneToOne => 2.0 * depth - 1.0,
                };
                poly.positions.push(in_range(unproject(viewport, at, depth, 1.0 / sum)));
                let value = |v: &Varying| match v.mode {
                    Interpolation::NoPerspective => mean(&b, &v.corners) as f32,
                    _ => (mean(&l, &v.corners) / sum) as f32,
                };
                poly.attributes.push(varyings.iter().map(value).collect());
            }
            let window = look.window(viewport, &poly);
            let interpolation = varyings.iter().map(|v| v.mode).collect();
            Scene { viewport, window, interpolation, poly }
        },
    )
}

fn mean(weights: &[f64; 3], values: &[f64; 3]) -> f64 {
    weights[0] * values[0] + weights[1] * values[1] + weights[2] * values[2]
}

/// Where a window is laid: at a mean of three vertices, aside by some pixels.
#[derive(Clone, Debug)]
pub(crate) struct Look {
    vertices: [prop::sample::Index; 3],
    weights: [f64; 3],
    aside: [i32; 2],
    size: [u32; 2],
}

/// Windows of some 100 to 1000 pixels.
pub(crate) fn look() -> impl Strategy<Value = Look> {
    let index = any::<prop::sample::Index>;
    let weights = prop_oneof![[0.0..1.0, 0.0..1.0, 0.0..1.0], [0.0..1.0, 0.0..1e-3, 0.0..1e-3]];
    let size = prop_oneof![Just([40, 24]), Just([17, 9]), Just([100, 3]), Just([2, 60])];
    ([index(), index(), index()], weights, [-9_i32..9, -9_i32..9], size)
        .prop_map(|(vertices, weights, aside, size)| Look { vertices, weights, aside, size })
}

impl Look {
    /// The window on `poly`, all of whose vertices have w > 0; the whole viewport if it is small.
    pub(crate) fn window(&self, viewport: Viewport, poly: &Poly) -> PixelRect {
        let rect = viewport.rect();
        if viewport.width() * viewport.height() <= 1000 {
            return rect;
        }
        let sum: f64 = self.weights.iter().sum::<f64>() + 1e-9;
        let mut at = [0.0; 2];
        for (index, weight) in self.vertices.iter().zip(self.weights) {
            let vertex = framebuffer(viewport, poly.positions[index.index(poly.positions.len())]);
            at = [0, 1].map(|i| at[i] + vertex[i] * weight / sum);
        }
        let begin = |i: usize, low: i32, high: i32| {
            let size = i32::try_from(self.size[i]).expect("small");
            (at[i] as i32 + self.aside[i] - size / 2).clamp(low, (high - size).max(low))
        };
        let (x, y) = (begin(0, rect.x0, rect.x1), begin(1, rect.y0, rect.y1));
        PixelRect::new(x, y, self.size[0], self.size[1]).intersect(rect)
    }
}

/// Polygons on a plane through `middle`, in clip space, that reach behind the eye, before the
/// near plane, beyond the far one and out of the guard band; attributes are affine on it.
pub(crate) fn clipped_polygons() -> impl Strategy<Value = (View, Poly)> {
    let vector = |most: f64| [-most..most, -most..most, -most..most, -most..most];
    let vectors = prop_oneof![
        3 => (vector(1.0), vector(3.0), vector(3.0)),
        1 => (vector(1.0), vector(1e4), vector(3.0)),
        1 => (vector(0.3), vector(1e3), vector(1e5)),
        1 => (vector(1.0), Just([1.0, 0.0, 0.0, 0.0]), Just([0.0, 1.0, -1.5, 2.0])),
    ];
    let affine = [-1.0..1.0, -1.0..1.0, -1.0..1.0_f64];
    let attributes = prop::collection::vec((affine, -3..9_i32), 0..4);
    let jitter = prop::collection::vec(0.0..1.0_f64, 3..=9);
    let side = || prop_oneof![1..40_u32, Just(64)];
    (vectors, attributes, jitter, side(), side(), any::<bool>()).prop_map(
        |((middle, right, down), attributes, jitter, w, h, gl)| {
            let range = if gl { DepthRange::MinusOneToOne } else { DepthRange::ZeroToOne };
            let viewport = Viewport::new(0, 0, w, h).expect("small").with_depth_range(range);
            let seen = [middle[0], middle[1], middle[2].abs() + 0.2, middle[3].abs() + 0.4];
            let mut poly = Poly::default();
            for (i, j) in jitter.iter().enumerate() {
                let angle = (i as f64 + 0.9 * j) * std::f64::consts::TAU / jitter.len() as f64;
                let (s, t) = (angle.cos(), angle.sin());
                poly.positions.push([0, 1, 2, 3].map(|c| seen[c] + s * right[c] + t * down[c]));
                let value = |([a, b, c], e): &([f64; 3], i32)| {
                    ((a * s + b * t + c) * 10.0_f64.powi(*e)) as f32
                };
                poly.attributes.push(attributes.iter().map(value).collect());
            }
            (View::whole(viewport), poly)
        },
    )
}

/// Polygons that are neither flat nor have affine attributes, nor keep their order, on the
/// screen and out of it.
pub(crate) fn loose_polygons() -> impl Strategy<Value = (View, Poly)> {
    let coordinate = || prop_oneof![4 => -1.5..1.5_f64, 1 => -100.0..100.0];
    let behind = prop::bool::weighted(0.1);
    let vertex = ([coordinate(), coordinate(), coordinate(), coordinate()], behind);
    let attributes = prop::collection::vec(-9.0..9.0_f32, 3);
    let vertices = prop::collection::vec((vertex, attributes), 3..=5);
    let modes = prop::collection::vec(varying().prop_map(|v| v.mode), 3);
    let side = || 1..28_u32;
    (vertices, modes, side(), side()).prop_map(|(vertices, interpolation, w, h)| {
        let viewport = Viewport::new(0, 0, w, h).expect("small");
        let mut poly = Poly::default();
        for (([x, y, z, w], behind), attributes) in vertices {
            // Most in front of the eye, and between the planes.
            let w = if behind { w } else { w.abs() + 0.1 };
            poly.positions.push([x, y, if behind { z } else { z.abs().min(w) }, w]);
            poly.attributes.push(attributes);
        }
        (View { interpolation, ..View::whole(viewport) }, poly)
    })
}

/// Triangles and parallelograms with corners on centres of pixels, whose attributes are 0 along
/// lines through centres: what `Fast` has there is nothing but its rounding errors, so that
/// any other order of operations shows. A few are stretched, so that their spans are long.
pub(crate) fn vanishing_polygons() -> impl Strategy<Value = (View, Poly)> {
    let steps = [-20..20_i32, -20..20_i32, -20..20_i32, -20..20_i32];
    let line = ([-2..=2_i32, -2..=2_i32], [0..40_i32, 0..40_i32]);
    let attributes = prop::collection::vec((line, any::<bool>()), 1..4);
    // Of 12 bits, so that an attribute times w is an f32.
    let ws = [1..4096_u16, 1..4096, 1..4096];
    let side = || 33..70_u32;
    let stretch = prop_oneof![2 => Just(1_u16), 1 => 12..40_u16];
    let sides = (side(), side(), stretch);
    (sides, [5..30_i32, 5..30_i32], steps, (ws, any::<bool>()), attributes).prop_map(
        |((width, height, stretch), a, [bx, by, cx, cy], (mut ws, parallelogram), attributes)| {
            let viewport = Viewport::new(0, 0, width * u32::from(stretch), height).expect("small");
            let mut corners = vec![a, [a[0] + bx, a[1] + by], [a[0] + cx, a[1] + cy]];
            if parallelogram {
                corners.insert(2, [a[0] + bx + cx, a[1] + by + cy]);
                ws = [ws[0]; 3];
            }
            let stretched = |[x, y]: [i32; 2]| [x * i32::from(stretch), y];
            let corners: Vec<[i32; 2]> = corners.into_iter().map(stretched).collect();
            // Of what is wide a few rows will do.
            let (first, rows) = if stretch == 1 { (0, height) } else { (a[1], 4) };
            let window =
                PixelRect::new(0, first, viewport.width(), rows).intersect(viewport.rect());
            let mut poly = Poly::default();
            for (corner, w) in corners.iter().zip(ws.iter().cycle()) {
                let w = f64::from(*w);
                let at = corner.map(|c| f64::from(c) + 0.5);
                poly.positions.push(unproject(viewport, at, 0.5, w));
                let value = |((slope, zero), linear): &(([i32; 2], [i32; 2]), bool)| {
                    let zero = stretched(*zero);
                    let [x, y] = [0, 1].map(|k| slope[k] * (corner[k] - zero[k]));
                    // With perspective, it is s/w that is linear on the screen.
                    (x + y) as f32 * if *linear { 1.0 } else { w as f32 }
                };
                poly.attributes.push(attributes.iter().map(value).collect());
            }
            let mode = |linear: bool| {
                if linear { Interpolation::NoPerspective } else { Interpolation::Perspective }
            };
            let interpolation = attributes.iter().map(|(_, linear)| mode(*linear)).collect();
            (View { interpolation, window, ..View::whole(viewport) }, poly)
        },
    )
}
