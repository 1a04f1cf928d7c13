//! Draw lists: many polygons, sorted into bands of rows whose colour and depth fit the cache,
//! and drawn band by band, on one thread or on many.
//!
//! ```text
//! calls -> sorted, chunk by chunk -> bins, one for each band -> cleared and drawn, band by band
//! ```
//!
//! What covers no pixel never reaches a band; a band is cleared when it is drawn. In a band
//! polygons are drawn in the order in which they were submitted, and a pixel's value is a function
//! of its polygon and its place, so the bytes are those of [`Tiler::draw`], whatever the number of
//! threads (feature `parallel`).

mod bins;
mod call;
mod canvas;
mod run;

use alloc::vec::Vec;

use bins::{Bins, CHUNK};
pub use call::{Call, Polygons};
pub use canvas::{Canvas, Paint, Rows, Screen, With};

use crate::space::PixelRect;
use crate::stats::Stats;
use crate::tiler::Tiler;
use crate::tiler::keep::Keep;

/// Bytes of a band's colour and depth, about: what fits into a second-level cache beside polygons
/// and textures.
const BAND_BYTES: u32 = 1 << 19;

/// Rows of a band are a multiple of this.
const ROW_STEP: u32 = 16;

/// Draws lists of polygons; keeps its buffers from one frame to the next, so that a frame like the
/// one before allocates nothing.
#[derive(Debug)]
pub struct Frame {
    settings: Tiler,
    threads: usize,
    /// One for each thread.
    workers: Vec<run::Worker>,
    chunks: Vec<Chunk>,
    stats: Stats,
}

/// What a thread has of its own.
#[derive(Debug)]
struct Hand {
    tiler: Tiler,
    keep: Keep,
    bins: Bins,
}

/// Polygons that are sorted at a time.
#[derive(Clone, Copy, Debug)]
struct Chunk {
    call: usize,
    first: usize,
    end: usize,
}

/// The bands of a canvas.
#[derive(Clone, Copy, Debug)]
struct Bands {
    count: usize,
    /// Of each but the last.
    rows: u32,
    /// The framebuffer position of the canvas.
    origin: [i32; 2],
}

impl Frame {
    /// A frame with the settings of `tiler`: its viewport, its origin, how it draws. All that was
    /// set is taken over each time from what [`settings`](Self::settings) gives.
    pub fn new(tiler: Tiler) -> Self {
        Self {
            settings: tiler,
            threads: 1,
            workers: Vec::new(),
            chunks: Vec::new(),
            stats: Stats::default(),
        }
    }

    /// How polygons are drawn.
    pub fn settings(&mut self) -> &mut Tiler {
        &mut self.settings
    }

    /// How many threads draw: 1 unless set, and 0 for as many as the pool of `rayon` has in which
    /// [`draw`](Self::draw) is called; there are never more. Without the feature `parallel` there
    /// is one. No bit depends on it.
    pub fn set_threads(&mut self, threads: usize) -> &mut Self {
        self.threads = threads;
        self
    }

    /// Counts of the last frame; its bytes are those of all threads.
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// Clears `canvas` and draws `calls` on it, one after the other.
    pub fn draw<C: Canvas>(&mut self, canvas: C, calls: &[&dyn Call<C>]) {
        let (width, height) = canvas.size();
        let bands = Bands::of(width, height, self.settings.origin());
        self.chunks.clear();
        for (call, polygons) in calls.iter().enumerate() {
            let starts = (0..polygons.len()).step_by(CHUNK);
            let chunk = |first: usize| Chunk { call, first, end: polygons.len().min(first + CHUNK) };
            self.chunks.extend(starts.map(chunk));
        }
        let threads = run::threads(self.threads);
        while self.workers.len() < threads {
            let viewport = self.settings.viewport();
            let (tiler, keep, bins) = (Tiler::new(viewport), Keep::default(), Bins::default());
            self.workers.push(run::Worker::new(Hand { tiler, keep, bins }));
        }
        for worker in &mut self.workers {
            let Hand { tiler, bins, .. } = run::hand(worker);
            tiler.set_as(&self.settings);
            tiler.reset_stats();
            bins.reset(bands.count, bands.origin[1], bands.rows);
        }
        let window = self.settings.viewport().rect().intersect(PixelRect::new(
            bands.origin[0],
            bands.origin[1],
            width,
            height,
        ));
        let threads = if threads > 1 { self.workers.len() } else { 1 };
        run::sort(&self.workers[..threads], &self.chunks, calls, window);

        let mut kept = 0;
        for worker in &mut self.workers {
            let Hand { bins, .. } = run::hand(worker);
            bins.finish();
            kept += bins.kept() as usize;
        }
        for worker in &mut self.workers {
            run::hand(worker).keep.reset(kept);
        }
        run::paint(&mut self.workers, threads, &self.chunks, calls, canvas, bands);

        self.stats = Stats::default();
        for worker in &mut self.workers {
            let Hand { tiler, keep, bins } = run::hand(worker);
            self.stats.add(&tiler.stats());
            self.stats.peak_bytes += (keep.bytes() + bins.bytes()) as u64;
        }
        self.stats.peak_bytes += (self.chunks.capacity() * size_of::<Chunk>()) as u64;
    }
}

impl Bands {
    fn of(width: u32, height: u32, origin: [i32; 2]) -> Self {
        let bytes_of_row = width.saturating_mul(8).max(1);
        let rows = (BAND_BYTES / bytes_of_row / ROW_STEP).max(1) * ROW_STEP;
        Self { count: height.div_ceil(rows) as usize, rows, origin }
    }
}
