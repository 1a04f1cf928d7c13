//! What the machine can do: an idealised loop of a textured pixel with perspective and depth,
//! and filling memory; beside them, ours on the same pixels. Figures are for ratios.
//!
//! The loop has its spans and the functions to interpolate for nothing, promises no accuracy (`f32`,
//! start + k * step from the row's start), and takes texels one by one, as safe code must.

#[path = "../scenes/mod.rs"]
#[expect(dead_code, reason = "each bench uses a part of it")]
mod scenes;
mod timing;

use criterion::{Criterion, Throughput};
use fearless_simd::{
    Level, Select as _, Simd as Lanes, SimdBase, SimdFloat, SimdMask, dispatch, f32x16, u32x16,
};
use hyperspan::simd::Simd;
use hyperspan::tiler::Precision;
use scenes::draw::Stage;
use scenes::{Scene, TEXTURE_SIDE};
use timing::time_only;

const SIZE: (u32, u32) = (1920, 1080);
const LANES: usize = 16;

/// A sum with this has no room for a fraction: its low bits are a whole number's.
const WHOLE: f32 = 12_582_912.0;

/// a x + b y + c at the centre of pixel (x, y).
#[derive(Clone, Copy, Default)]
struct Affine([f64; 3]);

impl Affine {
    fn at(self, x: usize, y: usize) -> f32 {
        let [a, b, c] = self.0;
        (a * (x as f64 + 0.5) + b * (y as f64 + 0.5) + c) as f32
    }
}

/// The floor, ready to be painted: what set-up would have to find.
struct Floor {
    /// 1/w, u/w, v/w in texels, z/w.
    functions: [Affine; 4],
    /// First column and the one after the last, of each row.
    spans: Vec<(usize, usize)>,
    texels: Vec<[u8; 4]>,
    colour: Vec<[u8; 4]>,
    depth: Vec<f32>,
}

impl Floor {
    /// Its pixels are those that our tiler draws.
    fn new(scene: &Scene) -> Self {
        let mut stage = Stage::new(scene, Precision::Exact, Simd::auto());
        stage.draw();
        let width = scene.size.0 as usize;
        let spans = stage.colour.chunks(width).map(|row| {
            let covered = |pixel: &[u8; 4]| pixel[3] != 0;
            let start = row.iter().position(covered).unwrap_or(0);
            (start, row.iter().rposition(covered).map_or(start, |last| last + 1))
        });
        let side = TEXTURE_SIDE as usize;
        Self {
            functions: Self::functions(scene, &stage.clip),
            spans: spans.collect(),
            texels: scene.textures[0].rchunks_exact(side).flatten().copied().collect(),
            colour: vec![[0; 4]; stage.colour.len()],
            depth: vec![1.0; stage.depth.len()],
        }
    }

    /// By Cramer's rule from three vertices: with p = (x, y, w), what is s at them is
    /// sum s_k (p_i x p_j) / det, times the pixel's (X, Y, 1), over w.
    fn functions(scene: &Scene, clip: &[[f64; 4]]) -> [Affine; 4] {
        let (half_w, half_h) = (f64::from(scene.size.0) / 2.0, f64::from(scene.size.1) / 2.0);
        let points = [0, 1, 2].map(|k| [clip[k][0], clip[k][1], clip[k][3]]);
        let minor = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let [p, q, r] = points;
        let weights = [minor(q, r), minor(r, p), minor(p, q)];
        let determinant = (0..3).map(|i| p[i] * weights[0][i]).sum::<f64>();
        let texels = |k: usize, c: usize| {
            f64::from(scene.corners[k].attributes[c]) * f64::from(TEXTURE_SIDE)
        };
        let function = |values: [f64; 3]| {
            let [a, b, c] = [0, 1, 2]
                .map(|i| (0..3).map(|k| values[k] * weights[k][i]).sum::<f64>() / determinant);
            // X = x / half_w - 1, Y = 1 - y / half_h.
            Affine([a / half_w, -b / half_h, c - a + b])
        };
        [
            function([1.0; 3]),
            function([0, 1, 2].map(|k| texels(k, 0))),
            function([0, 1, 2].map(|k| texels(k, 1))),
            function([0, 1, 2].map(|k| clip[k][2])),
        ]
    }

    fn clear(&mut self) {
        self.colour.fill([0; 4]);
        self.depth.fill(1.0);
    }

    fn pixels(&self) -> u64 {
        self.spans.iter().map(|(start, end)| (end - start) as u64).sum()
    }

    fn paint(&mut self, level: Level) {
        dispatch!(level, simd => self.paint_with(simd));
    }

    #[inline(always)]
    fn paint_with<S: Lanes>(&mut self, simd: S) {
        let count = f32x16::from_slice(simd, &std::array::from_fn::<_, LANES, _>(|k| k as f32));
        let width = SIZE.0 as usize;
        let rows = self.colour.chunks_exact_mut(width).zip(self.depth.chunks_exact_mut(width));
        let texels: &[[u8; 4]; 1 << 16] = self.texels.as_slice().try_into().expect("256 x 256");
        for (y, ((colours, depths), (start, end))) in rows.zip(&self.spans).enumerate() {
            let [q, u, v, z] = &self.functions;
            let (q, u) = (start_and_step(simd, q, *start, y), start_and_step(simd, u, *start, y));
            let (v, z) = (start_and_step(simd, v, *start, y), start_and_step(simd, z, *start, y));
            let blocks = (*start..*end).step_by(LANES);
            for (k, x) in blocks.enumerate() {
                let lanes = (*end - x).min(LANES);
                // The last block of a row again, whole: these pixels are hidden by now.
                let x = if lanes == LANES { x } else { end.saturating_sub(LANES) };
                let (Some(colours), Some(depths)) = (
                    colours[x..].first_chunk_mut::<LANES>(),
                    depths[x..].first_chunk_mut::<LANES>(),
                ) else {
                    continue;
                };
                let at = if lanes == LANES { (k * LANES) as f32 } else { (x - start) as f32 };
                let along = count + f32x16::splat(simd, at);
                let old = f32x16::from_slice(simd, depths);
                let new = along * z.1 + z.0;
                let passes = new.simd_lt(old);
                let mask = passes.to_bitmask();
                if mask == 0 {
                    continue;
                }
                passes.select(new, old).store_slice(depths);
                let w = f32x16::splat(simd, 1.0) / (along * q.1 + q.0);
                let column = low_byte_of_floor((along * u.1 + u.0) * w);
                let row = low_byte_of_floor((along * v.1 + v.0) * w);
                let mut index = [0_u32; LANES];
                ((row << 8) | column).store_slice(&mut index);
                if mask == 0xFFFF {
                    for (pixel, i) in colours.iter_mut().zip(index) {
                        *pixel = texels[i as u16 as usize];
                    }
                } else {
                    for (lane, (pixel, i)) in colours.iter_mut().zip(index).enumerate() {
                        if mask >> lane & 1 == 1 {
                            *pixel = texels[i as u16 as usize];
                        }
                    }
                }
            }
        }
    }
}

/// The value at a pixel, and what is added from one to the next.
#[inline(always)]
fn start_and_step<S: Lanes>(
    simd: S,
    function: &Affine,
    x: usize,
    y: usize,
) -> (f32x16<S>, f32x16<S>) {
    let step = function.0[0] as f32;
    (f32x16::splat(simd, function.at(x, y)), f32x16::splat(simd, step))
}

/// The nearest whole number of what is half less: floor, but for a rounding.
#[inline(always)]
fn low_byte_of_floor<S: Lanes>(value: f32x16<S>) -> u32x16<S> {
    ((value - 0.5) + WHOLE).to_bits() & 255
}

/// The instruction sets of the machine, as `fearless_simd` has them.
#[cfg(target_arch = "x86_64")]
fn level(name: &str) -> Option<Level> {
    let best = Level::new();
    match name {
        "scalar" => Some(Level::baseline()),
        "sse4.2" => best.as_sse4_2().map(Lanes::level),
        "avx2" => best.as_avx2().map(Lanes::level),
        "avx512" => best.as_avx512().map(Lanes::level),
        _ => None,
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn level(name: &str) -> Option<Level> {
    Some(if name == "scalar" { Level::baseline() } else { Level::new() })
}

fn textured_pixel(c: &mut Criterion) {
    let scene = scenes::all(SIZE).swap_remove(0);
    let mut floor = Floor::new(&scene);
    let mut group = c.benchmark_group("textured pixel with depth");
    group.throughput(Throughput::Elements(floor.pixels()));
    for (name, simd) in timing::levels() {
        if let Some(level) = level(name) {
            group.bench_function(format!("yardstick/{name}"), |b| {
                b.iter_custom(|n| time_only(n, &mut floor, Floor::clear, |f| f.paint(level)));
            });
        }
        for (precision, kind) in [(Precision::Fast, "fast"), (Precision::Exact, "exact")] {
            let mut stage = Stage::new(&scene, precision, simd);
            stage.transform();
            group.bench_function(format!("{kind}/{name}"), |b| {
                let draw = |stage: &mut Stage<'_>| stage.draw_part([0, 0], [SIZE.0, SIZE.1]);
                b.iter_custom(|n| time_only(n, &mut stage, Stage::clear, draw));
            });
        }
    }
    group.finish();
    agrees(&scene, &mut floor);
}

/// The yardstick is of use only if it draws the same picture, but for its rounding.
fn agrees(scene: &Scene, floor: &mut Floor) {
    let mut stage = Stage::new(scene, Precision::Exact, Simd::auto());
    stage.draw();
    floor.clear();
    floor.paint(Level::new());
    let differ = floor.colour.iter().zip(&stage.colour).filter(|(a, b)| a != b).count();
    assert!(differ < floor.colour.len() / 20, "{differ} pixels differ");
}

fn memory(c: &mut Criterion) {
    let area = (SIZE.0 * SIZE.1) as usize;
    let mut group = c.benchmark_group("fill");
    group.throughput(Throughput::Elements(area as u64));
    let mut colour = vec![[0_u8; 4]; area];
    let mut depth = vec![0.0_f32; area];
    group.bench_function("colour", |b| {
        b.iter(|| std::hint::black_box(&mut colour).fill([7; 4]));
    });
    group.bench_function("colour and depth", |b| {
        b.iter(|| {
            std::hint::black_box(&mut colour).fill([7; 4]);
            std::hint::black_box(&mut depth).fill(1.0);
        });
    });
    group.finish();
}

fn main() {
    let mut criterion = timing::criterion();
    memory(&mut criterion);
    textured_pixel(&mut criterion);
    criterion.final_summary();
}
