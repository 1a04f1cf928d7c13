//! Draw lists: many polygons, drawn by one thread in the order in which they come, or sorted into
//! bands of rows and drawn band by band, by the threads of a pool or by one if they lie far apart.
//!
//! ```text
//! calls -> sorted, chunk by chunk -> bins, one for each band -> cleared and drawn, band by band
//! ```
//!
//! What covers no pixel never reaches a band; a band is cleared when it is drawn, and in short lists
//! only where large polygons do not cover it. In a band
//! polygons are drawn in the order in which they were submitted, and a pixel's value is a function
//! of its polygon and its place, so the bytes are those of [`Tiler::draw`], whatever the number of
//! threads (feature `parallel`).

mod bins;
mod call;
mod canvas;
mod listed;
mod occlude;
mod run;
mod scattered;

use alloc::vec::Vec;

use bins::{Bins, CHUNK};
use occlude::{Limits, Search};
use run::{Painter, Part, Sorter};

pub use call::{Call, Polygons};
pub use canvas::{Canvas, Paint, Rows, Screen, With};

use crate::depth::Occluders;
use crate::space::PixelRect;
use crate::stats::Stats;
use crate::tiler::Tiler;

/// Bands for each thread: enough that none has to wait for long at the end.
const BANDS_PER_THREAD: usize = 8;

/// Pixels of a band that one thread draws: 3 MiB of colours and depths.
const BAND_PIXELS: u32 = 3 << 17;

/// Rows of a band are a multiple of this, so that none cuts a tile of depth bounds.
const ROW_STEP: u32 = 16;

/// Of more polygons most are small, or cover little that others have not covered: nothing is won by a clear
/// that is put off for them.
const FEW: usize = 256;

/// Draws lists of polygons; keeps its buffers from one frame to the next, so that a frame like the
/// one before allocates nothing.
#[derive(Debug)]
pub struct Frame {
    settings: Tiler,
    parallel: bool,
    /// One for each thread; and what each has sorted.
    workers: Vec<run::Worker>,
    bins: Vec<Bins>,
    chunks: Vec<Chunk>,
    search: Search,
    stats: Stats,
}

/// What a thread has of its own.
#[derive(Debug)]
struct Hand {
    tiler: Tiler,
    /// While it sorts.
    bins: Bins,
    /// How far it is with what each thread has sorted.
    cursors: Vec<usize>,
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
    /// A frame with the settings of `tiler`: its viewport, its origin, how it draws.
    pub fn new(tiler: Tiler) -> Self {
        Self {
            settings: tiler,
            parallel: false,
            workers: Vec::new(),
            bins: Vec::new(),
            chunks: Vec::new(),
            search: Search::default(),
            stats: Stats::default(),
        }
    }

    /// How polygons are drawn: what is set here holds for the frames that follow.
    pub fn settings(&mut self) -> &mut Tiler {
        &mut self.settings
    }

    /// Whether all threads of the pool of `rayon` draw in which [`draw`](Self::draw) is called (the
    /// caller's own, by its `install`, or else the global one), or just the caller. No bit depends
    /// on it. Without the feature `parallel` there is but one thread. Shaders must not wait for work of
    /// the same pool: a thread that has a band would be given another one.
    pub fn set_parallel(&mut self, parallel: bool) -> &mut Self {
        self.parallel = parallel;
        self
    }

    /// Counts of the last frame; its bytes are those of all threads.
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// Clears `canvas` and draws `calls` on it, one after the other.
    pub fn draw<C: Canvas>(&mut self, mut canvas: C, calls: &[&dyn Call<C>]) {
        let threads = run::threads(self.parallel);
        let (width, height) = canvas.size();
        self.prepare(threads);
        let [x, y] = self.settings.origin();
        let window = PixelRect::new(x, y, width, height);
        let window = self.settings.viewport().rect().intersect(window);
        let mut search = core::mem::take(&mut self.search);
        if let Some(worker) = self.workers.first_mut() {
            let tiler = &mut run::hand(worker).tiler;
            let occluders = search.run(tiler, &mut canvas, calls, window);
            let sorts = threads > 1 || are_scattered(calls, tiler, window);
            if sorts && !window.is_empty() {
                let bands = Bands::of([width, height], threads, [x, y]);
                self.draw_in_bands(canvas, calls, bands, window, occluders);
            } else {
                // All in the order in which it comes.
                let rest = clear(&mut canvas, calls, tiler.skips_hidden());
                if let (Some(occluders), Some(call)) = (occluders, calls.first()) {
                    call.limit(&mut canvas, Limits { occluders, row: 0 });
                }
                for call in calls {
                    call.draw(tiler, &mut canvas);
                }
                if let Some(call) = rest {
                    call.clear_rest(&mut canvas);
                }
            }
        }
        self.search = search;
        self.count();
    }

    fn draw_in_bands<C: Canvas>(
        &mut self,
        canvas: C,
        calls: &[&dyn Call<C>],
        bands: Bands,
        window: PixelRect,
        occluders: Option<&Occluders>,
    ) {
        self.chunks.clear();
        for (call, polygons) in calls.iter().enumerate() {
            let n = polygons.len();
            let chunk = |first: usize| Chunk { call, first, end: n.min(first + CHUNK) };
            self.chunks.extend((0..n).step_by(CHUNK).map(chunk));
        }
        let (_, height) = canvas.size();
        let y = bands.origin[1];
        for (worker, bins) in self.workers.iter_mut().zip(&mut self.bins) {
            bins.reset(bands.count, y, bands.rows);
            run::hand(worker).bins = core::mem::take(bins);
        }
        Sorter { workers: &self.workers, calls, window, occluders }.sort(&self.chunks, 0);
        self.gather();

        let weights = |band| self.bins.iter().map(move |bins| bins.weight(band)).sum::<usize>();
        let words: usize = (0..bands.count).map(weights).sum();
        let fair = words / (2 * self.workers.len()) + 1024;
        let Self { workers, bins, chunks, .. } = self;
        let painter = Painter { workers, bins, chunks, calls, occluders, bands, fair };
        let part = Part { first_band: 0, end_band: bands.count, first_row: 0, end_row: height };
        painter.paint(part, canvas);
    }

    /// Makes `threads` workers ready.
    fn prepare(&mut self, threads: usize) {
        while self.workers.len() < threads {
            let tiler = Tiler::new(self.settings.viewport());
            let hand = Hand { tiler, bins: Bins::default(), cursors: Vec::new() };
            self.workers.push(run::Worker::new(hand));
            self.bins.push(Bins::default());
        }
        let [x, y] = self.settings.origin();
        for worker in &mut self.workers {
            let tiler = &mut run::hand(worker).tiler;
            tiler.set_as(&self.settings);
            tiler.set_origin(x, y);
            tiler.reset_stats();
        }
    }

    /// What the workers have sorted, for all to read.
    fn gather(&mut self) {
        for (worker, bins) in self.workers.iter_mut().zip(&mut self.bins) {
            *bins = core::mem::take(&mut run::hand(worker).bins);
            bins.finish();
        }
    }

    /// Adds up what the workers have counted.
    fn count(&mut self) {
        let mut bytes = self.chunks.capacity() * size_of::<Chunk>() + self.search.bytes();
        self.stats = Stats::default();
        for worker in &mut self.workers {
            self.stats.add(&run::hand(worker).tiler.stats());
        }
        bytes += self.bins.iter().map(Bins::bytes).sum::<usize>();
        self.stats.peak_bytes += bytes as u64;
    }
}

/// Is it worth sorting `calls` to be drawn by one thread? Then most of their polygons must be.
fn are_scattered<C: Canvas>(calls: &[&dyn Call<C>], tiler: &Tiler, window: PixelRect) -> bool {
    let (mut all, mut scattered) = (0_usize, 0_usize);
    for call in calls {
        all = all.saturating_add(call.len());
        if call.is_scattered(tiler, window) {
            scattered = scattered.saturating_add(call.len());
        }
    }
    scattered > all / 2
}

/// Clears `canvas`, or has it cleared later, if that `may` be: then by the call that it returns, too.
fn clear<'a, C: Canvas>(
    canvas: &mut C,
    calls: &[&'a dyn Call<C>],
    may: bool,
) -> Option<&'a dyn Call<C>> {
    let few = calls.iter().map(|call| call.len()).sum::<usize>() <= FEW;
    let call = calls.first().filter(|_| may && few && calls.iter().all(|call| call.clears()));
    let later = call.filter(|_| canvas.clear_later());
    if later.is_none() {
        canvas.clear();
    }
    later.copied()
}

impl Bands {
    fn of([width, height]: [u32; 2], threads: usize, origin: [i32; 2]) -> Self {
        let rows = match threads {
            1 => BAND_PIXELS / width.max(1),
            _ => height.div_ceil(u32::try_from(threads * BANDS_PER_THREAD).unwrap_or(u32::MAX)),
        };
        let rows = rows.clamp(1, height.max(1)).next_multiple_of(ROW_STEP);
        Self { count: height.div_ceil(rows) as usize, rows, origin }
    }
}
