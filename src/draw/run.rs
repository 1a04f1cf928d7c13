//! Who does what: chunks are sorted and bands are drawn by one thread, or by those of a pool.

use super::bins::{Bins, Entries};
use super::call::{Call, Painting};
use super::canvas::Canvas;
use super::listed::Sorting;
use super::occlude::Limits;
use super::{Bands, Chunk, Hand, ROW_STEP, clear};
use crate::depth::Occluders;
use crate::space::PixelRect;

/// A thread's own, which it takes for as long as it works on a chunk or a band.
#[cfg(feature = "parallel")]
pub(super) type Worker = std::sync::Mutex<Hand>;
#[cfg(not(feature = "parallel"))]
pub(super) type Worker = core::cell::RefCell<Hand>;

/// What nobody else has now.
pub(super) fn hand(worker: &mut Worker) -> &mut Hand {
    #[cfg(feature = "parallel")]
    return worker.get_mut().unwrap_or_else(std::sync::PoisonError::into_inner);
    #[cfg(not(feature = "parallel"))]
    return worker.get_mut();
}

/// How many threads there are, if all of them are to work.
pub(super) fn threads(parallel: bool) -> usize {
    #[cfg(feature = "parallel")]
    if parallel {
        return rayon::current_num_threads();
    }
    let _ = parallel;
    1
}

/// Lets `work` have the hand of the thread that it runs on.
fn with_hand<R>(workers: &[Worker], work: impl FnOnce(&mut Hand) -> R) -> Option<R> {
    #[cfg(feature = "parallel")]
    {
        let index = rayon::current_thread_index().filter(|i| *i < workers.len()).unwrap_or(0);
        let guard = workers.get(index)?.lock();
        return Some(work(&mut guard.unwrap_or_else(std::sync::PoisonError::into_inner)));
    }
    #[cfg(not(feature = "parallel"))]
    Some(work(&mut *workers.first()?.try_borrow_mut().ok()?))
}

/// Both, at the same time if there are threads.
#[cfg(feature = "parallel")]
fn both(workers: &[Worker], a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    if workers.len() > 1 {
        rayon::join(a, b);
    } else {
        a();
        b();
    }
}

/// Both, one after the other.
#[cfg(not(feature = "parallel"))]
fn both(_workers: &[Worker], a: impl FnOnce(), b: impl FnOnce()) {
    a();
    b();
}

/// What all chunks are sorted with.
pub(super) struct Sorter<'a, C> {
    pub(super) workers: &'a [Worker],
    pub(super) calls: &'a [&'a dyn Call<C>],
    pub(super) window: PixelRect,
    /// What hides others of what is drawn.
    pub(super) occluders: Option<&'a Occluders>,
}

impl<C: Canvas> Sorter<'_, C> {
    /// Sorts `chunks`, the first of which has the number `first`.
    pub(super) fn sort(&self, chunks: &[Chunk], first: usize) {
        if let [chunk] = chunks {
            with_hand(self.workers, |hand| {
                let Hand { tiler, bins, .. } = hand;
                bins.start_chunk(u32::try_from(first).unwrap_or(u32::MAX));
                let Self { window, occluders, .. } = *self;
                let sorting = Sorting { tiler, bins, window, occluders };
                self.calls[chunk.call].sort(sorting, chunk.first..chunk.end);
            });
        } else if !chunks.is_empty() {
            let (a, b) = chunks.split_at(chunks.len() / 2);
            both(self.workers, || self.sort(a, first), || self.sort(b, first + a.len()));
        }
    }
}

/// What all bands are drawn with.
pub(super) struct Painter<'a, C> {
    pub(super) workers: &'a [Worker],
    /// What each of them sorted.
    pub(super) bins: &'a [Bins],
    pub(super) chunks: &'a [Chunk],
    pub(super) calls: &'a [&'a dyn Call<C>],
    /// What hides others of what they draw.
    pub(super) occluders: Option<&'a Occluders>,
    pub(super) bands: Bands,
    /// More than this is too much for one thread, if others wait: not much less, since what is cut is gone
    /// through by each part.
    pub(super) fair: usize,
}

/// Bands, or a part of one: the rows `first_row..end_row` of the canvas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) first_band: usize,
    pub(super) end_band: usize,
    pub(super) first_row: u32,
    pub(super) end_row: u32,
}

impl<C: Canvas> Painter<'_, C> {
    /// Words in band `band`, and something for its clear.
    fn weight(&self, band: usize) -> usize {
        64 + self.bins.iter().map(|bins| bins.weight(band)).sum::<usize>()
    }

    /// Draws `part`, whose rows are those of `canvas`.
    pub(super) fn paint(&self, part: Part, canvas: C) {
        let Some((above, below)) = self.cut(part) else {
            with_hand(self.workers, |hand| self.paint_rows(hand, part, canvas));
            return;
        };
        let (upper, lower) = canvas.split_at_row(above.end_row - above.first_row);
        both(self.workers, || self.paint(above, upper), || self.paint(below, lower));
    }

    /// Two parts of about as much work, unless `part` is for one thread.
    fn cut(&self, part: Part) -> Option<(Part, Part)> {
        let Part { first_band, end_band, first_row, end_row } = part;
        if end_band - first_band > 1 {
            let all: usize = (first_band..end_band).map(|band| self.weight(band)).sum();
            let (mut middle, mut above) = (first_band + 1, self.weight(first_band));
            while middle + 1 < end_band && above + self.weight(middle) / 2 < all / 2 {
                above += self.weight(middle);
                middle += 1;
            }
            let row = u32::try_from(middle).ok()? * self.bands.rows;
            return Some((
                Part { end_band: middle, end_row: row, ..part },
                Part { first_band: middle, first_row: row, ..part },
            ));
        }
        // A part of a band is a part of the work, and whole steps of rows.
        let steps = (end_row - first_row).div_ceil(ROW_STEP);
        let all_steps = (self.bands.rows / ROW_STEP).max(1);
        let share = self.weight(first_band) * steps as usize / all_steps as usize;
        if self.workers.len() > 1 && share > self.fair && steps > 1 {
            let row = first_row + steps / 2 * ROW_STEP;
            return Some((Part { end_row: row, ..part }, Part { first_row: row, ..part }));
        }
        None
    }

    /// Draws `part`, of one band.
    fn paint_rows(&self, hand: &mut Hand, part: Part, mut canvas: C) {
        let band = part.first_band;
        let [x, y] = self.bands.origin;
        let is_top = u32::try_from(band).is_ok_and(|band| part.first_row == band * self.bands.rows);
        let rest = clear(&mut canvas, self.calls, hand.tiler.skips_hidden());
        if let (Some(occluders), Some(call)) = (self.occluders, self.calls.first()) {
            call.limit(&mut canvas, Limits { occluders, row: part.first_row / ROW_STEP });
        }
        let Hand { tiler, cursors, .. } = hand;
        tiler.set_origin(x, y.saturating_add_unsigned(part.first_row));
        cursors.clear();
        cursors.resize(self.bins.len(), 0);
        // Each has its runs in the order of their chunks; so are they all together.
        loop {
            let mut next: Option<(u32, usize, Entries<'_>)> = None;
            for (i, bins) in self.bins.iter().enumerate() {
                if let Some((chunk, entries)) = bins.run(band, cursors[i])
                    && next.is_none_or(|(least, ..)| chunk < least)
                {
                    next = Some((chunk, i, entries));
                }
            }
            let Some((chunk, i, entries)) = next else { break };
            cursors[i] += 1;
            let Chunk { call, first, .. } = self.chunks[chunk as usize];
            let painting = Painting { tiler: &mut *tiler, is_top, first, entries };
            self.calls[call].paint(painting, &mut canvas);
        }
        if let Some(call) = rest {
            call.clear_rest(&mut canvas);
        }
    }
}
