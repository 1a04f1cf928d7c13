//! Random scenes, drawn by euc, by retrofire-core and by ours; where they disagree, an oracle says
//! who is wrong, and by how much. `cargo run --release --example differential [SCENES]`.
//!
//! The oracle of coverage is the rule itself: vertices snapped to 1/65536 of a pixel, crossings in
//! 128-bit integers. How far a centre is from the nearest side tells why it was decided otherwise.
//! The oracle of values is the inverse of the transform, in f64: some 10^-13 off, where f32 has 6 10^-8.

use std::cell::Cell;

use euc::Pipeline;
use euc::buffer::Buffer2d;
use euc::rasterizer::{BackfaceCullingDisabled, Triangles};
use hyperspan::{polygon::Vertex, shade::Fragment, space::Viewport, target::Plane, tiler::Tiler};
use retrofire_core::geom::{Tri, vertex};
use retrofire_core::math::{Color4, ProjVec3, Vary, pt2, rgba, viewport};
use retrofire_core::render::raster::Scanline;
use retrofire_core::render::{Context, Frag, FragmentShader, Target, render, shader};

const SIDE: usize = 64;
const PIXELS: usize = SIDE * SIDE;

/// What a renderer made of a triangle: for each pixel how often it was drawn, and the value.
type Picture = Vec<(u32, f32)>;

/// Clip space (x, y, z, w), and an attribute.
type Corner = ([f32; 4], f32);

fn ours(triangle: &[Corner; 3]) -> Picture {
    let vertices = triangle.map(|(position, value)| Vertex::new(position, [value]));
    let mut picture = vec![(0, 0.0); PIXELS];
    let side = SIDE as u32;
    let mut target = Plane::new(&mut picture, side, side).expect("its size");
    let mut shader = |pixel: &Fragment<'_>| (1, pixel.attribute(0));
    let viewport = Viewport::new(0, 0, side, side).expect("small");
    Tiler::new(viewport).draw(&vertices, &mut shader, &mut target, None);
    picture
}

struct Euc;

impl Pipeline for Euc {
    type Vertex = Corner;
    type VsOut = f32;
    type Pixel = (u32, f32);

    fn vert(&self, corner: &Corner) -> ([f32; 4], f32) {
        *corner
    }

    fn frag(&self, value: &f32) -> (u32, f32) {
        (1, *value)
    }
}

fn euc(triangle: &[Corner; 3]) -> Picture {
    let mut target = Buffer2d::new([SIDE; 2], (0, 0.0));
    type Filled<'a> = Triangles<'a, Buffer2d<f32>, BackfaceCullingDisabled>;
    Euc.draw::<Filled<'_>, _>(triangle, &mut target, None);
    target.as_ref().to_vec()
}

/// A target of retrofire's that counts; its fragment shader leaves the value in `value`.
struct Counter<'a> {
    picture: Picture,
    value: &'a Cell<f32>,
}

impl Target for Counter<'_> {
    fn rasterize<V: Vary, U: Copy, S: FragmentShader<V, U>>(
        &mut self,
        mut line: Scanline<V>,
        shader: &S,
        uniform: U,
        _: &Context,
    ) {
        let (y, xs) = (line.y, line.xs.clone());
        for (x, fragment) in xs.zip(line.fragments()) {
            shader.shade_fragment(fragment, uniform);
            // It would write outside of the picture, and panic, where rounding carries it there.
            if x < SIDE && y < SIDE {
                let (count, value) = &mut self.picture[y * SIDE + x];
                (*count, *value) = (*count + 1, self.value.get());
            }
        }
    }
}

fn retrofire(triangle: &[Corner; 3]) -> Picture {
    let value = Cell::new(0.0);
    let mut target = Counter { picture: vec![(0, 0.0); PIXELS], value: &value };
    let shader = shader::new(
        // Its y points down, and its depth runs from -w to w.
        |([x, y, z, w], value): Corner, (): ()| {
            vertex(ProjVec3::new([x, -y, 2.0 * z - w, w]), value)
        },
        |fragment: Frag<f32>, (): ()| -> Color4 {
            value.set(fragment.var);
            rgba(0, 0, 0, 0)
        },
    );
    let screen = viewport(pt2(0, 0)..pt2(SIDE as u32, SIDE as u32));
    let context =
        Context { face_cull: None, color_clear: None, depth_clear: None, ..Context::default() };
    render([Tri([0, 1, 2])], triangle, &shader, (), screen, &mut target, &context);
    target.picture
}

/// What is right of a triangle.
struct Right {
    /// Snapped, in 1/65536 of a pixel; nothing if planes cut it.
    snapped: Option<[[i64; 2]; 3]>,
    /// Weights of the corners: a x + b y + c in the pixels' centres.
    weights: [[f64; 3]; 3],
    /// z and w - z, in the same way.
    depths: [[f64; 3]; 2],
    values: [f64; 3],
    has_area: bool,
}

impl Right {
    fn new(triangle: &[Corner; 3]) -> Self {
        let half = SIDE as f64 / 2.0;
        let corners = triangle.map(|(p, _)| p.map(f64::from));
        // x and y times w, in pixels.
        let p = corners.map(|[x, y, _, w]| [x * half + w * half, w * half - y * half, w]);
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let rows = [cross(p[1], p[2]), cross(p[2], p[0]), cross(p[0], p[1])];
        let det: f64 = (0..3).map(|i| rows[0][i] * p[0][i]).sum();
        let weights = rows.map(|row| row.map(|c| c / det));
        let mean = |v: [f64; 3]| [0, 1, 2].map(|i| (0..3).map(|k| weights[k][i] * v[k]).sum());
        let z: [f64; 3] = mean(corners.map(|c| c[2]));
        let place = |[x, y, _, w]: [f64; 4]| [x / w * half + half, half - y / w * half];
        let snap = |c: [f64; 4]| place(c).map(|c| (c * 65536.0).round_ties_even() as i64);
        let is_seen = |[_, _, z, w]: &[f64; 4]| 0.0 <= *z && z <= w && *w > 0.0;
        Self {
            snapped: corners.iter().all(is_seen).then(|| corners.map(snap)),
            weights,
            depths: [z, [-z[0], -z[1], 1.0 - z[2]]],
            values: triangle.map(|(_, value)| f64::from(value)),
            has_area: det != 0.0,
        }
    }

    /// How far the centre of a pixel lies within, or without if negative, in pixels.
    fn inside(&self, [x, y]: [f64; 2]) -> f64 {
        let sides = self.weights.iter().chain(&self.depths);
        let distance = |[a, b, c]: &[f64; 3]| {
            let slope = (a * a + b * b).sqrt();
            let value = a * x + b * y + c;
            if slope > 0.0 { value / slope } else { value * f64::INFINITY }
        };
        sides.map(distance).fold(f64::INFINITY, f64::min)
    }

    /// Is a pixel covered?
    fn covers(&self, x: usize, y: usize) -> Option<bool> {
        let centre = [x, y].map(|c| c as f64 + 0.5);
        let Some(points) = self.snapped else {
            // Clipping makes vertices, which are rounded.
            let inside = self.inside(centre);
            return (inside.abs() > 1.0 / 16384.0).then_some(inside > 0.0);
        };
        let [xc, yc] = [x, y].map(|c| c as i64 * 65536 + 32768);
        let mut winding = 0;
        for (i, from) in points.iter().enumerate() {
            let to = &points[(i + 1) % 3];
            let (top, bottom, way) = if from[1] <= to[1] { (from, to, 1) } else { (to, from, -1) };
            let run = i128::from(yc - top[1]) * i128::from(bottom[0] - top[0]);
            let reach = i128::from(xc - top[0]) * i128::from(bottom[1] - top[1]);
            if top[1] <= yc && yc < bottom[1] && run <= reach {
                winding += way;
            }
        }
        Some(winding != 0)
    }

    fn value(&self, [x, y]: [f64; 2]) -> f64 {
        let weights = self.weights.map(|[a, b, c]| a * x + b * y + c);
        let sum: f64 = weights.iter().sum();
        (0..3).map(|k| weights[k] * self.values[k]).sum::<f64>() / sum
    }
}

/// Why a pixel was decided otherwise than the oracle does, by how far its centre is from a side.
const CAUSES: [&str; 5] = [
    "on a side",
    "within 1/65536 pixel of one",
    "within 1/256",
    "farther",
    "of a triangle without area",
];

#[derive(Clone, Copy, Default)]
struct Tally {
    covered: u64,
    /// Drawn but not covered, and covered but not drawn, by cause.
    extra: [u64; 5],
    missing: [u64; 5],
    /// Drawn more than once in one triangle.
    again: u64,
    values: u64,
    /// Off by more than P2 allows `Fast`, and by more than a thousand times that.
    beyond: u64,
    far_beyond: u64,
    /// The largest error, in parts of what P2 allows.
    worst: f64,
}

impl Tally {
    fn add(&mut self, right: &Right, picture: &Picture) {
        const U: f64 = 1.0 / 16_777_216.0;
        let most = right.values.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        for (at, &(count, value)) in picture.iter().enumerate() {
            let (x, y) = (at % SIDE, at / SIDE);
            let centre = [x, y].map(|c| c as f64 + 0.5);
            let Some(covered) = right.covers(x, y) else { continue };
            self.covered += u64::from(covered);
            self.again += u64::from(count.saturating_sub(1));
            let inside = right.inside(centre);
            if covered != (count > 0) {
                let limits = [1e-9, 1.0 / 65536.0, 1.0 / 256.0];
                let farther = limits.iter().filter(|limit| inside.abs() > **limit).count();
                let cause = if right.has_area { farther } else { 4 };
                (if covered { &mut self.missing } else { &mut self.extra })[cause] += 1;
            } else if covered && inside > 1.0 / 16384.0 {
                let exact = right.value(centre);
                let part =
                    (f64::from(value) - exact).abs() / (4.0 * U * exact.abs() + 3.0 * U * most);
                let part = if part.is_nan() { f64::INFINITY } else { part };
                self.values += 1;
                self.beyond += u64::from(part > 1.0);
                self.far_beyond += u64::from(part > 1000.0);
                self.worst = self.worst.max(part);
            }
        }
    }
}

/// Numbers that look random: splitmix64.
struct Random(u64);

impl Random {
    fn within(&mut self, least: f64, most: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        least + (most - least) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The corner that lands on `at`.
    fn corner(&mut self, at: [f64; 2], w: f64) -> Corner {
        let half = SIDE as f64 / 2.0;
        let [x, y] = [(at[0] - half) / half * w, (half - at[1]) / half * w];
        let z = self.within(0.1, 0.9) * w;
        ([x, y, z, w].map(|c| c as f32), self.within(-1.0, 1.0) as f32)
    }

    fn anywhere(&mut self) -> [f64; 2] {
        [0, 1].map(|_| self.within(2.0, SIDE as f64 - 2.0))
    }
}

type Make = fn(&mut Random) -> [Corner; 3];

const KINDS: [(&str, Make); 6] = [
    ("triangles, w to 4", |random| {
        [(); 3].map(|()| {
            let (at, w) = (random.anywhere(), random.within(0.2, 4.0));
            random.corner(at, w)
        })
    }),
    ("w to 1000", |random| {
        [(); 3].map(|()| {
            let (at, w) = (random.anywhere(), 10_f64.powf(random.within(0.0, 3.0)));
            random.corner(at, w)
        })
    }),
    ("a few pixels", |random| {
        let middle = random.anywhere();
        [(); 3].map(|()| {
            let at = middle.map(|c| c + random.within(-2.0, 2.0));
            random.corner(at, 1.0)
        })
    }),
    ("corners on centres", |random| {
        [(); 3].map(|()| {
            let at = random.anywhere().map(|c| c.floor() + 0.5);
            random.corner(at, 1.0)
        })
    }),
    ("slivers", |random| {
        let (a, b) = (random.anywhere(), random.anywhere());
        let c = [0, 1].map(|i| (a[i] + b[i]) / 2.0 + random.within(-0.05, 0.05));
        [a, b, c].map(|at| random.corner(at, 1.0))
    }),
    ("behind the eye", |random| {
        let mut all = [(); 3].map(|()| {
            let (at, w) = (random.anywhere(), random.within(0.2, 4.0));
            random.corner(at, w)
        });
        // The third is the second, seen through the eye.
        all[2].0 = all[2].0.map(|c| -c);
        all
    }),
];

/// A renderer, and its name.
type Draw = fn(&[Corner; 3]) -> Picture;
type Renderer = (&'static str, Draw);

const RENDERERS: [Renderer; 3] = [("ours", ours), ("euc", euc), ("retrofire", retrofire)];

/// Triangles that cover the picture but for its rim: how often a pixel within is not drawn, and
/// how often it is drawn again.
fn net(random: &mut Random, cells: usize, on_centres: bool, draw: Draw) -> [u64; 2] {
    let step = (SIDE as f64 - 4.0) / cells as f64;
    let mut points = Vec::new();
    for i in 0..(cells + 1) * (cells + 1) {
        let at = [i % (cells + 1), i / (cells + 1)]
            .map(|c| 2.0 + step * (c as f64 + random.within(-0.2, 0.2)));
        let at = if on_centres { at.map(|c| c.floor() + 0.5) } else { at };
        let w = if on_centres { 1.0 } else { random.within(0.5, 2.0) };
        points.push(random.corner(at, w));
    }
    let mut counts = vec![0_u32; PIXELS];
    for cell in 0..cells * cells {
        let a = cell / cells * (cells + 1) + cell % cells;
        let (b, c, d) = (a + 1, a + cells + 2, a + cells + 1);
        for triangle in [[a, b, c], [a, c, d]] {
            let picture = draw(&triangle.map(|i| points[i]));
            counts.iter_mut().zip(picture).for_each(|(sum, (count, _))| *sum += count);
        }
    }
    // What lies within the rim, wherever its points are.
    let rim = 4 + (0.2 * step) as usize;
    let inner = rim..SIDE - rim;
    let all = inner.clone().flat_map(|y| inner.clone().map(move |x| y * SIDE + x));
    all.fold([0; 2], |[holes, again], at| {
        [holes + u64::from(counts[at] == 0), again + u64::from(counts[at].saturating_sub(1))]
    })
}

fn main() {
    let scenes: u64 = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(3000);
    let mut out = String::new();
    let sides = |counts: [u64; 5]| counts.map(|count| count.to_string()).join(" / ");
    out.push_str("| scenes | renderer | covered pixels | drawn, not covered | covered, not drawn | twice | values | beyond P2 | 1000 times beyond | worst |\n|---|---|---|---|---|---|---|---|---|---|\n");
    let mut of_ours = Tally::default();
    for (kind, make) in KINDS {
        let mut tallies = [Tally::default(); 3];
        let mut random = Random(7);
        for _ in 0..scenes {
            let triangle = make(&mut random);
            let right = Right::new(&triangle);
            for ((_, draw), tally) in RENDERERS.iter().zip(&mut tallies) {
                tally.add(&right, &draw(&triangle));
            }
        }
        for ((name, _), tally) in RENDERERS.iter().zip(&tallies) {
            let Tally { covered, extra, missing, again, values, beyond, far_beyond, worst } =
                *tally;
            out.push_str(&format!(
                "| {kind} | {name} | {covered} | {} | {} | {again} | {values} | {beyond} | {far_beyond} | {worst:.3} |\n",
                sides(extra), sides(missing)
            ));
        }
        let wrong = tallies[0];
        for i in 0..5 {
            of_ours.extra[i] += wrong.extra[i];
            of_ours.missing[i] += wrong.missing[i];
        }
        of_ours.beyond += wrong.beyond;
    }
    out.push_str(&format!("\nDisagreements by cause: centres {}.\n", CAUSES.join(" / ")));
    out.push_str("\n| triangles that share their edges | renderer | holes | drawn again |\n|---|---|---|---|\n");
    for (cells, on_centres) in [(3, false), (8, false), (20, false), (3, true), (8, true)] {
        let place = if on_centres { ", corners on centres" } else { "" };
        for (name, draw) in RENDERERS {
            let mut random = Random(11);
            let nets = (0..scenes.div_ceil(300)).map(|_| net(&mut random, cells, on_centres, draw));
            let [holes, again] = nets.fold([0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
            out.push_str(&format!(
                "| {cells} x {cells} cells{place} | {name} | {holes} | {again} |\n"
            ));
            assert!(name != "ours" || (holes, again) == (0, 0));
        }
    }
    assert_eq!((of_ours.extra, of_ours.missing, of_ours.beyond), ([0; 5], [0; 5], 0));
    show(&out);
}

#[expect(clippy::print_stdout, reason = "it is what the program is for")]
fn show(text: &str) {
    println!("{text}");
}
