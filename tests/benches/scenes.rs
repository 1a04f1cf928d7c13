//! Whole frames, 1920 x 1080, one thread: clear, transform and every polygon; and the crates
//! that a user might pick instead, on the same scenes. Throughput counts pixels of the picture.

mod peers;
#[path = "../scenes/mod.rs"]
mod scenes;
#[expect(dead_code, reason = "each bench uses a part of it")]
mod timing;

use criterion::{Criterion, Throughput};
use hyperspan::simd::Simd;
use hyperspan::tiler::Precision;
use scenes::draw::Stage;

const SIZE: (u32, u32) = (1920, 1080);

fn frames(c: &mut Criterion) {
    for scene in scenes::all(SIZE) {
        let mut group = c.benchmark_group(scene.name);
        group.throughput(Throughput::Elements(u64::from(SIZE.0) * u64::from(SIZE.1)));
        for (name, precision) in [("fast", Precision::Fast), ("exact", Precision::Exact)] {
            let mut stage = Stage::new(&scene, precision, Simd::auto());
            group.bench_function(name, |b| b.iter(|| stage.draw()));
        }
        let mut euc = peers::euc::Renderer::new(&scene);
        group.bench_function("euc", |b| b.iter(|| euc.draw()));
        let mut retrofire = peers::retrofire::Renderer::new(&scene);
        group.bench_function("retrofire", |b| b.iter(|| retrofire.draw()));
        group.finish();
    }
}

fn main() {
    let mut criterion = timing::criterion();
    frames(&mut criterion);
    criterion.final_summary();
}
