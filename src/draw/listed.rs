//! Polygons of a batch, some at a time: sorted, or drawn.
//!
//! What depends on neither paint nor canvas is compiled once for each type of batch, and drawing once
//! for all ways to it.

use core::ops::Range;

use fearless_simd::dispatch;

use super::bins::{Bins, Entry};
use crate::batch::Batch;
use crate::depth::Occluders;
use crate::number::EIGHT;
use crate::polygon::Polygon;
use crate::shade::Shader;
use crate::space::PixelRect;
use crate::stats::{FaceCount, Outcome, Stats};
use crate::subnormal;
use crate::target::{DepthBuffer, Target};
use crate::tiler::Tiler;
use crate::tiler::ahead::AHEAD;
use crate::tiler::bunch::{BUNCH, Several};

/// Polygons of a batch, [`BUNCH`] at most.
pub(super) struct Listed<'a, B: ?Sized> {
    pub(super) batch: &'a B,
    /// What their numbers count from.
    pub(super) first: usize,
    /// So many of these.
    pub(super) count: usize,
    pub(super) entries: &'a [Entry; BUNCH],
}

/// One polygon in so many is few of them.
const FEW_OF: usize = 4;

/// One after the other.
static IN_ORDER: [Entry; BUNCH] = {
    let mut entries = [Entry { polygon: 0, is_first_band: true }; BUNCH];
    let mut k = 0;
    while k < BUNCH {
        entries[k].polygon = k;
        k += 1;
    }
    entries
};

/// What polygons are sorted with.
#[derive(Debug)]
pub struct Sorting<'a> {
    pub(super) tiler: &'a mut Tiler,
    pub(super) bins: &'a mut Bins,
    pub(super) window: PixelRect,
    pub(super) occluders: Option<&'a Occluders>,
}

/// Which pass over a batch this is.
pub(super) enum Pass<'a> {
    /// The only one: every polygon is counted.
    Only(&'a mut FaceCount),
    /// That over what was sorted into a band.
    Band {
        /// Are these the band's first rows?
        is_top: bool,
    },
}

impl<B: Batch + ?Sized> Several for Listed<'_, B> {
    type Polygon<'p>
        = B::Polygon<'p>
    where
        Self: 'p;

    #[inline(always)]
    fn polygon(&self, k: usize) -> B::Polygon<'_> {
        self.batch.polygon(self.first + self.entries[k % BUNCH].polygon)
    }
}

impl<'a, B: Batch + ?Sized> Listed<'a, B> {
    /// All of `polygons`, some at a time.
    pub(super) fn all(batch: &'a B, polygons: Range<usize>) -> impl Iterator<Item = Self> {
        let end = polygons.end;
        polygons.step_by(BUNCH).map(move |first| Self {
            batch,
            first,
            count: BUNCH.min(end - first),
            entries: &IN_ORDER,
        })
    }

    /// Asks for the memory of their vertices, if they are few of many: what lies side by side is fetched anyway.
    #[inline(never)]
    pub(super) fn fetch(&self) {
        let entries = self.entries.get(..self.count).unwrap_or_default();
        let (Some(first), Some(last)) = (entries.first(), entries.last()) else { return };
        if last.polygon.saturating_sub(first.polygon) < FEW_OF * self.count {
            return;
        }
        for entry in entries {
            let polygon = self.batch.polygon(self.first + entry.polygon);
            let placed = polygon.placed();
            for i in 0..polygon.len() {
                if let Some(placed) = placed {
                    placed.fetch(polygon.placed_index(i));
                }
                polygon.fetch(i);
            }
        }
    }

    /// Draws them.
    #[inline(never)]
    pub(super) fn draw<S: Shader, T: Target<Pixel = S::Pixel>>(
        &self,
        tiler: &mut Tiler,
        pass: &mut Pass<'_>,
        window: PixelRect,
        shader: &mut S,
        target: &mut T,
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) {
        dispatch!(tiler.simd().0, simd => {
            let Self { batch, first, count, entries } = *self;
            let asked = tiler.asked::<S>(depth.as_deref());
            tiler.look_at::<EIGHT, _, _>(simd, self, count, window);
            tiler.clear_under_small(target, depth.as_deref_mut());
            let are_far_apart = tiler.are_far_apart();
            if are_far_apart {
                for k in 0..AHEAD {
                    tiler.fetch_small(k, window, target, depth.as_deref());
                }
            }
            for (k, entry) in entries.iter().enumerate().take(count) {
                let i = first + entry.polygon;
                if are_far_apart {
                    tiler.fetch_small(k + AHEAD, window, target, depth.as_deref());
                }
                if tiler.may_be_far(k + 1) {
                    let next = self.polygon(k + 1);
                    tiler.fetch_next(simd, &next, window, target, depth.as_deref());
                }
                shader.start(i);
                let before = match pass {
                    Pass::Only(_) => None,
                    Pass::Band { .. } => Some(*tiler.stats_mut()),
                };
                let next =
                    tiler.next::<EIGHT, _, _>(simd, self, k, window, asked, depth.as_deref_mut());
                let drawn = depth.as_deref_mut();
                let outcome = tiler.follow(simd, next, self, k, window, shader, target, drawn);
                let stats = tiler.stats_mut();
                match pass {
                    Pass::Only(faces) => faces.count(stats, outcome, batch.continues(i)),
                    Pass::Band { is_top } => {
                        let Some(Stats { clipped, constant_w, .. }) = before else { continue };
                        // A polygon counts once: what was clipped, when it was sorted.
                        stats.clipped = clipped;
                        if !(entry.is_first_band && *is_top) || i > 0 && batch.continues(i) {
                            stats.constant_w = constant_w;
                        }
                    }
                }
            }
        });
    }
}

/// The next of `polygons` that may be seen; those before them are counted, and all of them where
/// arithmetic cannot be trusted.
pub(super) fn seen<B: Batch + ?Sized>(
    batch: &B,
    polygons: Range<usize>,
    stats: &mut Stats,
    faces: &mut FaceCount,
) -> Range<usize> {
    let Range { start: next, end } = polygons;
    if !subnormal::are_kept() {
        for i in next..end {
            faces.count(stats, Outcome::Refused, batch.continues(i));
        }
        return end..end;
    }
    let Some(clusters) = batch.clusters() else { return next..end };
    // What is beyond the boxes draws nothing either: they are the caller's to get right.
    let seen = clusters.walk(next..end).next().unwrap_or_default();
    let of_batch = |i: usize| i.saturating_sub(clusters.first).clamp(next, end);
    let (first, last) = (of_batch(seen.start), of_batch(seen.end));
    let first = if first < last { first } else { end };
    for i in next..first {
        faces.count(stats, Outcome::Outside, batch.continues(i));
    }
    first..last.max(first)
}

impl Sorting<'_> {
    /// Sorts `polygons` of `batch` into the bands of what is to be drawn.
    pub(super) fn sort<B: Batch + ?Sized>(self, batch: &B, polygons: Range<usize>) {
        let Self { tiler, bins, window, occluders } = self;
        // A face belongs to the chunk where it begins.
        let begin = |mut i: usize| {
            while i < batch.len() && i > 0 && batch.continues(i) {
                i += 1;
            }
            i
        };
        let (start, end) = (begin(polygons.start), begin(polygons.end));
        dispatch!(tiler.simd().0, simd => {
            let mut faces = FaceCount::new(tiler.stats_mut());
            let mut next = start;
            while next < end {
                let seen = seen(batch, next..end, tiler.stats_mut(), &mut faces);
                next = seen.end;
                for first in seen.clone().step_by(EIGHT) {
                    let count = EIGHT.min(seen.end - first);
                    let eight = Listed { batch, first, count, entries: &IN_ORDER };
                    tiler.look_from_outside::<EIGHT, _, _>(simd, &eight, 0..count, window);
                    for lane in 0..count {
                        let i = first + lane;
                        let polygon = batch.polygon(i);
                        let (outcome, rows) =
                            tiler.sort_next(simd, &polygon, lane, window, occluders);
                        if let Some(rows) = rows {
                            bins.add(i - polygons.start, rows);
                        }
                        faces.count(tiler.stats_mut(), outcome, batch.continues(i));
                    }
                }
            }
        });
    }
}
