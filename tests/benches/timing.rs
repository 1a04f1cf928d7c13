//! How long, and how often: a whole `cargo bench` is to take minutes.

use std::time::{Duration, Instant};

use criterion::Criterion;
use hyperspan::simd::Simd;

/// Short measurements: what matters here is ratios within one run.
pub(crate) fn criterion() -> Criterion {
    Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600))
        .configure_from_args()
}

/// Every instruction set of the machine, the plainest first. On x86-64 `scalar` is SSE2 already.
pub(crate) fn levels() -> Vec<(&'static str, Simd)> {
    Simd::all().filter(|(name, _)| *name != "sse2").collect()
}

/// The time of `count` calls of `work`, without that of `before`.
pub(crate) fn time_only<T>(
    count: u64,
    state: &mut T,
    before: impl Fn(&mut T),
    work: impl Fn(&mut T),
) -> Duration {
    (0..count)
        .map(|_| {
            before(state);
            let start = Instant::now();
            work(state);
            start.elapsed()
        })
        .sum()
}
