//! The pipeline's stages, one by one or in differences: what a small triangle costs, what each
//! attribute adds, what a constant w saves on each instruction set, what a hidden pixel costs.

mod quad;
#[path = "../scenes/mod.rs"]
#[expect(dead_code, reason = "each bench uses a part of it")]
mod scenes;
mod timing;

use std::hint::black_box;

use criterion::{Criterion, Throughput};
use hyperspan::clip::{Clipper, VertexArrays};
use hyperspan::divide::divide;
use hyperspan::edge::Outline;
use hyperspan::shade::{Shader, Solid};
use hyperspan::simd::Simd;
use hyperspan::space::Viewport;
use hyperspan::target::{Plane, Target};
use hyperspan::texture::Texture;
use hyperspan::tiler::{Precision, Tiler};
use quad::{Bits, Canvas, Quad, Slope};
use scenes::draw::{Placed, Stage, Textured};
use scenes::{Scene, TEXTURE_SIDE};

const SIZE: (u32, u32) = (1920, 1080);

fn viewport() -> Viewport {
    Viewport::new(0, 0, SIZE.0, SIZE.1).expect("a small picture")
}

fn scene(name: &str) -> Scene {
    scenes::all(SIZE).into_iter().find(|scene| scene.name == name).expect("one of them")
}

/// A scene with its positions in clip space.
fn staged(scene: &Scene) -> Stage<'_> {
    let mut stage = Stage::new(scene, Precision::Fast, Simd::auto());
    stage.transform();
    stage
}

/// Stages that can be used alone, over all polygons of a scene; per polygon.
fn alone(c: &mut Criterion) {
    let [soup, clip] = ["soup", "clip"].map(scene);
    let mut group = c.benchmark_group("stage, each polygon");

    let stage = staged(&clip);
    group.throughput(Throughput::Elements(clip.faces.len() as u64));
    let (mut clipper, mut arrays) = (Clipper::new(viewport()), VertexArrays::default());
    group.bench_function("clip, crossing", |b| {
        b.iter(|| {
            for face in &clip.faces {
                arrays.reset(3);
                for i in &clip.indices[face.start..face.end] {
                    let attributes = clip.corners[*i as usize].attributes;
                    arrays.push(stage.clip[*i as usize], attributes.map(f64::from));
                }
                black_box(clipper.clip(&mut arrays));
            }
        });
    });

    let stage = staged(&soup);
    let triangles = stage.clip.as_chunks::<3>().0;
    group.throughput(Throughput::Elements(triangles.len() as u64));
    group.bench_function("clip, not crossing", |b| {
        b.iter(|| {
            for triangle in triangles {
                black_box(clipper.classify(triangle.iter().copied()));
            }
        });
    });
    let mut screen = Vec::new();
    group.bench_function("divide", |b| {
        b.iter(|| {
            for triangle in triangles {
                divide(triangle.iter().copied(), viewport(), &mut screen);
                black_box(&screen);
            }
        });
    });
    let screens: Vec<_> = triangles
        .iter()
        .map(|triangle| {
            divide(triangle.iter().copied(), viewport(), &mut screen);
            screen.clone()
        })
        .collect();
    let mut outline = Outline::default();
    group.bench_function("edges, 10 pixels", |b| {
        b.iter(|| {
            for screen in &screens {
                let spans = outline.set(screen);
                spans.for_each_span(0..1080, |span| _ = black_box(span));
            }
        });
    });
    group.finish();
}

/// Triangles of 10 pixels, with what is asked for in steps; per triangle.
fn small_triangles(c: &mut Criterion) {
    let soup = scene("soup");
    let mut group = c.benchmark_group("triangle of 10 pixels");
    group.throughput(Throughput::Elements(soup.faces.len() as u64));
    let mut stage = staged(&soup);
    group.bench_function("transform", |b| b.iter(|| stage.transform()));
    group.bench_function("coverage", |b| {
        b.iter(|| draw_all::<0, _>(&mut stage, false, &mut Solid([9; 4])));
    });
    group.bench_function("coverage, depth", |b| {
        // Later triangles are hidden as often as they would be in a frame of their own.
        b.iter(|| draw_all::<0, _>(&mut stage, true, &mut Solid([9; 4])));
    });
    group.bench_function("one attribute", |b| {
        b.iter(|| draw_all::<1, _>(&mut stage, false, &mut Bits::<1>));
    });
    group.bench_function("three attributes", |b| {
        b.iter(|| draw_all::<3, _>(&mut stage, false, &mut Bits::<3>));
    });
    for (name, precision) in [("fast", Precision::Fast), ("exact", Precision::Exact)] {
        let mut stage = Stage::new(&soup, precision, Simd::auto());
        let clear = Stage::clear;
        let draw = |stage: &mut Stage<'_>| {
            stage.transform();
            stage.draw_part([0, 0], [SIZE.0, SIZE.1]);
        };
        group.bench_function(format!("all: transform, colours, depth, {name}"), |b| {
            b.iter_custom(|n| timing::time_only(n, &mut stage, clear, draw));
        });
    }
    group.finish();
}

/// All faces with their first `N` attributes; depth, if there is any, is cleared before.
fn draw_all<const N: usize, S: Shader<Pixel = [u8; 4]>>(
    stage: &mut Stage<'_>,
    with_depth: bool,
    shader: &mut S,
) {
    let Stage { scene, tiler, clip, colour, depth, .. } = stage;
    let mut target = Plane::new(colour, SIZE.0, SIZE.1).expect("its size");
    if with_depth {
        depth.fill(1.0);
    }
    let mut depth = Plane::new(depth, SIZE.0, SIZE.1).expect("its size");
    for face in &scene.faces {
        let depth = with_depth.then_some(&mut depth);
        tiler.draw(&Placed::<N>::new(scene, clip, *face), shader, &mut target, depth);
    }
}

/// Draws `quad` over all of the picture, once for each iteration; per pixel.
fn draw_quad<const N: usize, S: Shader<Pixel = P>, P: Copy + Default + 'static>(
    tiler: &mut Tiler,
    quad: &Quad<N>,
    shader: &mut S,
    target: &mut impl Target<Pixel = P>,
) {
    tiler.draw(black_box(&quad.0), shader, target, None);
}

/// What a constant w saves: over the polygon, along rows, along columns.
fn constant_w(c: &mut Criterion) {
    let scene = scene("floor");
    let texture = Texture::new(TEXTURE_SIDE, TEXTURE_SIDE, &scene.textures[0]).expect("its size");
    for (kind, slope) in Slope::ALL {
        let mut group = c.benchmark_group(format!("w constant: {kind}"));
        group.throughput(Throughput::Elements(Canvas::PIXELS));
        let mut canvas = Canvas::new();
        // Some 8 texels for each 10 pixels.
        let quad = Quad::new(slope, [6.0, 3.4]);
        for (level, simd) in timing::levels() {
            let mut tiler = Tiler::new(viewport());
            tiler.set_simd(simd);
            group.bench_function(format!("2 attributes/{level}"), |b| {
                let mut target = canvas.target();
                b.iter(|| draw_quad(&mut tiler, &quad, &mut Bits::<2>, &mut target));
            });
            group.bench_function(format!("texture/{level}"), |b| {
                let mut target = canvas.target();
                b.iter(|| draw_quad(&mut tiler, &quad, &mut Textured(&texture), &mut target));
            });
            assert!(slope.is_found(&tiler), "{kind}: {:?}", tiler.stats().constant_w);
        }
        group.finish();
    }
}

/// `Exact` beside `Fast`, and attributes that cost nothing; per pixel.
fn attributes(c: &mut Criterion) {
    let mut group = c.benchmark_group("4 attributes");
    group.throughput(Throughput::Elements(Canvas::PIXELS));
    let mut canvas = Canvas::new();
    let quad = Quad::new(Slope::Both, [1.0, 0.3, 7.0, 100.0]);
    let same = Quad::new(Slope::Both, [0.0; 4]);
    for (level, simd) in timing::levels() {
        let mut tiler = Tiler::new(viewport());
        tiler.set_simd(simd);
        for (kind, precision) in [("fast", Precision::Fast), ("exact", Precision::Exact)] {
            tiler.set_precision(precision);
            group.bench_function(format!("{kind}/{level}"), |b| {
                let mut target = canvas.target();
                b.iter(|| draw_quad(&mut tiler, &quad, &mut Bits::<4>, &mut target));
            });
        }
        tiler.set_precision(Precision::Fast);
        group.bench_function(format!("fast, the same at all vertices/{level}"), |b| {
            let mut target = canvas.target();
            b.iter(|| draw_quad(&mut tiler, &same, &mut Bits::<4>, &mut target));
        });
        group.bench_function(format!("fast, none read/{level}"), |b| {
            let mut target = canvas.target();
            b.iter(|| draw_quad(&mut tiler, &quad, &mut Solid([9; 4]), &mut target));
        });
    }
    group.finish();
}

/// A polygon over all of the picture behind one that was drawn before; per pixel.
fn hidden(c: &mut Criterion) {
    let mut group = c.benchmark_group("hidden pixel of a big polygon");
    group.throughput(Throughput::Elements(Canvas::PIXELS));
    let mut canvas = Canvas::new();
    let quad = Quad::new(Slope::Both, [6.0, 3.4]);
    for (level, simd) in timing::levels() {
        let mut tiler = Tiler::new(viewport());
        tiler.set_simd(simd);
        group.bench_function(level, |b| {
            let (mut target, mut depth) = canvas.target_and_depth();
            depth.clear(0.0);
            b.iter(|| tiler.draw(&quad.0, &mut Bits::<2>, &mut target, Some(&mut depth)));
        });
        assert_eq!(tiler.stats().pixels_shaded, 0);
    }
    group.finish();
}

fn main() {
    let mut criterion = timing::criterion();
    for bench in [alone, small_triangles, constant_w, attributes, hidden] {
        bench(&mut criterion);
    }
    criterion.final_summary();
}
