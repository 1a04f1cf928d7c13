//! Draws a frame as often as asked, and says how long it took and what it counted: `--repeat`
//! and `--stats`.

use std::path::Path;
use std::time::{Duration, Instant};

use hyperspan::stats::Stats;
use serde_json::json;

use crate::failure::{Place, warn};
use crate::flags::{DrawFlags, PrecisionFlag};
use crate::progress::Progress;

/// What frames took, and what the last one counted.
#[derive(Debug)]
pub(crate) struct Timings {
    /// Whole frames, the shortest first; at least one.
    sorted: Vec<Duration>,
    stats: Stats,
}

impl Timings {
    /// Draws `repeat` frames; `frame` draws one, the clear included, and gives its counts.
    pub(crate) fn measure(repeat: u32, mut frame: impl FnMut(&mut Progress) -> Stats) -> Self {
        let mut progress = Progress::new("frames");
        let mut sorted = Vec::new();
        let mut stats = Stats::default();
        for number in 0..repeat {
            let start = Instant::now();
            stats = if repeat == 1 { frame(&mut progress) } else { frame(&mut Progress::silent()) };
            sorted.push(start.elapsed());
            if repeat > 1 {
                progress.set(u64::from(number) + 1, u64::from(repeat));
            }
        }
        sorted.sort_unstable();
        Self { sorted, stats }
    }

    /// Tells of polygons of the file at `path` that were refused.
    pub(crate) fn report_refused(&self, path: &Path) {
        let refused = self.stats.culled.refused;
        if refused > 0 {
            let message = format!("NaN or infinite positions: {refused} polygons are not drawn");
            warn(&Place::file(path), &message);
        }
    }

    /// The object that `--stats` writes.
    pub(crate) fn json(&self, flags: &DrawFlags) -> String {
        let ms = |i: usize| self.sorted.get(i).map_or(0.0, |time| time.as_secs_f64() * 1e3);
        let n = self.sorted.len();
        // Of an even number of frames the mean of the middle two.
        let median = f64::midpoint(ms(n.saturating_sub(1) / 2), ms(n / 2));
        let stats = &self.stats;
        let object = json!({
            "frames": n,
            "min_ms": ms(0),
            "median_ms": median,
            "threads": flags.threads(),
            "simd": flags.simd.name,
            "precision": match flags.precision {
                PrecisionFlag::Fast => "fast",
                PrecisionFlag::Exact => "exact",
            },
            "polygons": stats.polygons,
            "culled": {
                "outside": stats.culled.outside,
                "backface": stats.culled.backface,
                "degenerate": stats.culled.degenerate,
                "refused": stats.culled.refused,
                "hidden": stats.culled.hidden,
            },
            "clipped": stats.clipped,
            "constant_w": {
                "polygon": stats.constant_w.polygon,
                "row": stats.constant_w.row,
                "column": stats.constant_w.column,
            },
            "spans": stats.spans,
            "pixels_covered": stats.pixels_covered,
            "pixels_shaded": stats.pixels_shaded,
            "pixels_hidden": stats.pixels_hidden,
            "peak_bytes": stats.peak_bytes,
        });
        format!("{object:#}\n")
    }
}
