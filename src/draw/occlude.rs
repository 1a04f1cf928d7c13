//! What of a list hides the rest of it, found before anything is drawn: then what is drawn over
//! later is not drawn, in whatever order it comes.
//!
//! ```text
//! calls -> runs that may hold large polygons -> those polygons -> tiles that they fill
//! ```
//!
//! Of runs and of polygons the nearest come first. It costs little where it finds little: it ends
//! when what it finds does not pay for what it looks at, and fills nothing unless large polygons
//! cover more than the canvas.

use alloc::vec::Vec;
use core::ops::Range;

use fearless_simd::dispatch;

use super::call::Call;
use super::canvas::Canvas;
use crate::batch::Batch;
use crate::depth::Occluders;
use crate::gradient::nearest_f32;
use crate::space::PixelRect;
use crate::tiler::Tiler;

/// What a look at a polygon costs, and setting one up; what a large one is worth that is found, for
/// each so many pixels; and a tile that is filled and was not: in some 50 ns.
const LOOK: u32 = 1;
const SET_UP: u32 = 40;
const PIXELS: u64 = 1024;
const TILE: u32 = 4;

/// What may be spent before anything is found: so much, and of what there is a part.
const CREDIT: u32 = 2048;
const PART: u32 = 4;

/// A box that has fewer pixels than this for each of its polygons holds small ones.
const PIXELS_EACH: u64 = 64;

/// Of a batch without boxes no more polygons than these are looked at: all of them or none.
const MOST_ALONE: usize = 1024;

/// What a call's polygons are to others of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// They have to be drawn: what is drawn over them may leave something of them.
    Stays,
    /// They may be left out where they are hidden, but have holes.
    Hidden,
    /// They may be left out, and hide what is behind them.
    Hides,
}

/// The search for what hides others; its buffers are kept.
#[derive(Debug, Default)]
pub(super) struct Search {
    occluders: Occluders,
    /// Where large polygons may be.
    runs: Vec<Run>,
    /// Runs of one polygon, which is large.
    large: Vec<Run>,
    /// What they cover, about, of pixels.
    area: u64,
    /// What may still be spent.
    credit: u32,
}

/// Polygons of a call that follow each other.
#[derive(Clone, Copy, Debug)]
struct Run {
    call: u32,
    first: usize,
    end: usize,
    /// The nearest depth that any may have, about.
    nearest: f32,
}

/// The nearest first; `raised`: where that is the greatest depth.
fn sort(runs: &mut [Run], raised: bool) {
    runs.sort_unstable_by(|a, b| {
        let order = a.nearest.total_cmp(&b.nearest);
        let order = if raised { order.reverse() } else { order };
        order.then((a.call, a.first).cmp(&(b.call, b.first)))
    });
}

impl Search {
    /// Finds what hides others of what `calls` draw on `canvas`, within `window`; nothing if it is not
    /// worth it.
    pub(super) fn run<C: Canvas>(
        &mut self,
        tiler: &mut Tiler,
        canvas: &mut C,
        calls: &[&dyn Call<C>],
        window: PixelRect,
    ) -> Option<&Occluders> {
        let compare = tiler.depth_test().compare;
        let mut roles = calls.iter().map(|call| call.role(canvas));
        let (first, size) = roles.next()?;
        let (width, height) = size?;
        let is_shared = |(role, its)| role != Role::Stays && its == size;
        let all = is_shared((first, size)) && roles.all(is_shared);
        let [x, y] = tiler.origin();
        let window = window.intersect(PixelRect::new(x, y, width, height));
        if !all || window.is_empty() || !tiler.finds_occluders() {
            return None;
        }
        self.runs.clear();
        self.large.clear();
        for (i, call) in (0..).zip(calls) {
            if call.role(canvas).0 == Role::Hides {
                call.survey(Surveying { call: i, tiler, window, search: self });
            }
        }
        sort(&mut self.runs, compare.raises());
        let all: usize = self.runs.iter().map(|run| run.end - run.first).sum();
        let worth_a_look = u32::try_from(all).unwrap_or(u32::MAX) / PART;
        (self.area, self.credit) = (0, CREDIT.saturating_add(worth_a_look));
        self.each_run(calls, |search, run, call| {
            let surveying = Surveying { call: run.call, tiler, window, search };
            call.list_large(surveying, run.first..run.end);
        });
        // A layer and a quarter: less would hide too little.
        if self.area < window.area() / 4 * 5 {
            return None;
        }
        core::mem::swap(&mut self.runs, &mut self.large);
        sort(&mut self.runs, compare.raises());
        self.occluders.reset((width, height), compare);
        self.credit = CREDIT;
        self.each_run(calls, |search, run, call| {
            let surveying = Surveying { call: run.call, tiler, window, search };
            call.occlude(surveying, run.first);
        });
        // Each keeps the room that it has, for the next frame.
        core::mem::swap(&mut self.runs, &mut self.large);
        Some(&self.occluders)
    }

    /// Works on one run after the other, until there is nothing left to spend.
    fn each_run<C: Canvas>(
        &mut self,
        calls: &[&dyn Call<C>],
        mut work: impl FnMut(&mut Self, Run, &dyn Call<C>),
    ) {
        for i in 0..self.runs.len() {
            let run = self.runs[i];
            if let Some(call) = calls.get(run.call as usize) {
                work(self, run, *call);
            }
            if self.credit == 0 {
                return;
            }
        }
    }

    fn earn(&mut self, worth: u32) {
        self.credit = self.credit.saturating_add(worth);
    }

    fn spend(&mut self, cost: u32) {
        self.credit = self.credit.saturating_sub(cost);
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        let runs = self.runs.capacity() + self.large.capacity();
        self.occluders.bytes() + runs * size_of::<Run>()
    }
}

/// What was found, for the rows of a canvas from row `row` of tiles on.
#[derive(Clone, Copy, Debug)]
pub struct Limits<'a> {
    pub(super) occluders: &'a Occluders,
    pub(super) row: u32,
}

/// What large polygons are searched with.
#[derive(Debug)]
pub struct Surveying<'a> {
    call: u32,
    tiler: &'a mut Tiler,
    window: PixelRect,
    search: &'a mut Search,
}

impl Surveying<'_> {
    /// Lists the runs of `batch` that may hold something large.
    pub(super) fn survey<B: Batch + ?Sized>(self, batch: &B) {
        let Self { call, tiler, window, search } = self;
        let test = tiler.depth_test();
        // Of the two bounds of a depth.
        let nearer = usize::from(test.compare.raises());
        let Some(clusters) = batch.clusters() else {
            if batch.len() <= MOST_ALONE {
                search.runs.extend((0..batch.len()).map(|i| {
                    let nearest = tiler.nearest_depth(&batch.polygon(i));
                    Run { call, first: i, end: i + 1, nearest }
                }));
            }
            return;
        };
        let mut walk = clusters.walk(0..batch.len());
        loop {
            let mut last = None;
            let run = walk.next_run(|bounds, polygons| {
                last = clusters.view.project(bounds, test.source);
                // What reaches the eye may be large.
                last.is_some_and(|(pixels, _)| {
                    pixels.intersect(window).area() < PIXELS_EACH * polygons.len() as u64
                })
            });
            let Some(run) = run else { return };
            let nearest = match last {
                Some((_, depths)) => nearest_f32(depths[nearer]),
                None => Occluders::nearest(test.compare),
            };
            let (first, end) = (run.start - clusters.first, run.end - clusters.first);
            search.runs.push(Run { call, first, end, nearest });
        }
    }

    /// Lists the large ones of some polygons of `batch`.
    pub(super) fn list_large<B: Batch + ?Sized>(self, batch: &B, polygons: Range<usize>) {
        let Self { call, tiler, window, search } = self;
        dispatch!(tiler.simd().0, simd => {
            for i in polygons {
                let polygon = batch.polygon(i);
                let area = tiler.large_area(simd, &polygon, window);
                search.spend(LOOK);
                if area > 0 {
                    let nearest = tiler.nearest_depth(&polygon);
                    search.large.push(Run { call, first: i, end: i + 1, nearest });
                    search.area = search.area.saturating_add(area);
                    search.earn(u32::try_from(area / PIXELS).unwrap_or(u32::MAX));
                }
                if search.credit == 0 {
                    return;
                }
            }
        });
    }

    /// Fills tiles with polygon `i` of `batch`.
    pub(super) fn occlude<B: Batch + ?Sized>(self, batch: &B, i: usize) {
        let Self { tiler, window, search, .. } = self;
        let Search { occluders, .. } = search;
        match tiler.occlude(&batch.polygon(i), window, occluders) {
            Some(filled) => {
                search.spend(SET_UP);
                search.earn(filled * TILE);
            }
            None => search.spend(LOOK),
        }
    }
}
