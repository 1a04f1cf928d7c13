//! Draw calls: polygons, and what they are drawn with.

use core::ops::Range;

use fearless_simd::dispatch;

use super::bins::{Bins, Entries, Entry};
use super::canvas::{Canvas, Paint};
use super::occlude::{Limits, Role, Surveying};
use crate::batch::Batch;
use crate::depth::Occluders;
use crate::number::EIGHT;
use crate::shade::Shader;
use crate::space::PixelRect;
use crate::stats::{FaceCount, Outcome, Stats};
use crate::subnormal;
use crate::target::{DepthBuffer, Target};
use crate::tiler::Tiler;
use crate::tiler::keep::{Keep, Kept};
use crate::tiler::small::{BUNCH, Several};

/// Polygons that are drawn in the same way on canvases of the type `C`; [`Polygons`] is one.
pub trait Call<C: Canvas>: Sync {
    /// The number of polygons.
    fn len(&self) -> usize;

    /// Is there none?
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Draws all on the whole canvas.
    #[doc(hidden)]
    fn draw(&self, tiler: &mut Tiler, canvas: &mut C);

    /// What its polygons are to others, and the size of its depth buffer, if that has bounds and
    /// there is a target for all of it.
    #[doc(hidden)]
    fn role(&self, canvas: &mut C) -> (Role, Option<(u32, u32)>);

    /// Lists what may hold large polygons.
    #[doc(hidden)]
    fn survey(&self, surveying: Surveying<'_>);

    /// Lists the large ones of `polygons`.
    #[doc(hidden)]
    fn list_large(&self, surveying: Surveying<'_>, polygons: Range<usize>);

    /// Finds what polygon `i` hides.
    #[doc(hidden)]
    fn occlude(&self, surveying: Surveying<'_>, i: usize);

    /// Hands what hides others over to the bounds of the canvas's depths.
    #[doc(hidden)]
    fn limit(&self, canvas: &mut C, limits: Limits<'_>);

    /// Sorts `polygons` into the bands of what is to be drawn.
    #[doc(hidden)]
    fn sort(&self, sorting: Sorting<'_>, polygons: Range<usize>);

    /// Draws polygons on a band.
    #[doc(hidden)]
    fn paint(&self, painting: Painting<'_>, canvas: &mut C);
}

/// What polygons are sorted with.
#[derive(Debug)]
pub struct Sorting<'a> {
    pub(super) tiler: &'a mut Tiler,
    pub(super) bins: &'a mut Bins,
    pub(super) window: PixelRect,
    pub(super) occluders: Option<&'a Occluders>,
}

/// What polygons of a band are drawn with.
#[derive(Debug)]
pub struct Painting<'a> {
    pub(super) tiler: &'a mut Tiler,
    pub(super) keep: &'a mut Keep,
    /// Where the numbers begin of those that were kept by the thread that sorted them.
    pub(super) first_kept: u32,
    pub(super) band: u32,
    /// Are these the band's first rows?
    pub(super) is_top: bool,
    /// The first polygon of the chunk.
    pub(super) first: usize,
    pub(super) entries: Entries<'a>,
}

/// The polygons of a batch, and what they are drawn with.
#[derive(Clone, Copy, Debug)]
pub struct Polygons<B, P> {
    batch: B,
    paint: P,
}

impl<B: Batch, P> Polygons<B, P> {
    /// `batch` (it may be borrowed), drawn with `paint`.
    pub fn new(batch: B, paint: P) -> Self {
        Self { batch, paint }
    }
}

impl<B: Batch, P> Polygons<B, P> {
    /// The next polygons of `next..end` that may be seen; those before them are counted, and all of
    /// them where arithmetic cannot be trusted.
    fn seen(
        &self,
        next: usize,
        end: usize,
        stats: &mut Stats,
        faces: &mut FaceCount,
    ) -> Range<usize> {
        if !subnormal::are_kept() {
            for i in next..end {
                faces.count(stats, Outcome::Refused, self.batch.continues(i));
            }
            return end..end;
        }
        let Some(clusters) = self.batch.clusters() else { return next..end };
        // What is beyond the boxes draws nothing either: they are the caller's to get right.
        let seen = clusters.walk(next..end).next().unwrap_or_default();
        let of_batch = |i: usize| i.saturating_sub(clusters.first).clamp(next, end);
        let (first, last) = (of_batch(seen.start), of_batch(seen.end));
        let first = if first < last { first } else { end };
        for i in next..first {
            faces.count(stats, Outcome::Outside, self.batch.continues(i));
        }
        first..last.max(first)
    }
}

/// Polygons of a batch, from the first on.
struct Run<'a, B: ?Sized> {
    batch: &'a B,
    first: usize,
}

impl<B: Batch + ?Sized> Several for Run<'_, B> {
    type Polygon<'p>
        = B::Polygon<'p>
    where
        Self: 'p;

    #[inline(always)]
    fn polygon(&self, k: usize) -> B::Polygon<'_> {
        self.batch.polygon(self.first + k)
    }
}

/// Polygons of a chunk of a batch that were sorted.
struct Sorted<'a, B: ?Sized> {
    batch: &'a B,
    /// Of the chunk.
    first: usize,
    entries: &'a [Entry],
}

impl<B: Batch + ?Sized> Several for Sorted<'_, B> {
    type Polygon<'p>
        = B::Polygon<'p>
    where
        Self: 'p;

    #[inline(always)]
    fn polygon(&self, k: usize) -> B::Polygon<'_> {
        self.batch.polygon(self.first + self.entries[k].polygon)
    }
}

impl<C: Canvas, B: Batch, P: Paint<C>> Call<C> for Polygons<B, P> {
    fn len(&self) -> usize {
        self.batch.len()
    }

    fn role(&self, canvas: &mut C) -> (Role, Option<(u32, u32)>) {
        let (_, target, depth) = self.paint.open(canvas);
        let depth = depth.filter(|depth| {
            let ((width, height), (w, h)) = (target.size(), depth.dimensions());
            depth.has_bounds() && width >= w && height >= h
        });
        let role = match (P::REPLACES, <P::Shader<'_> as Shader>::KEEPS_ALL) {
            (false, _) => Role::Stays,
            (true, false) => Role::Hidden,
            (true, true) => Role::Hides,
        };
        (role, depth.map(|depth| depth.dimensions()))
    }

    fn survey(&self, surveying: Surveying<'_>) {
        surveying.survey(&self.batch);
    }

    fn list_large(&self, surveying: Surveying<'_>, polygons: Range<usize>) {
        surveying.list_large(&self.batch, polygons);
    }

    fn occlude(&self, surveying: Surveying<'_>, i: usize) {
        surveying.occlude(&self.batch, i);
    }

    fn limit(&self, canvas: &mut C, limits: Limits<'_>) {
        let (_, _, mut depth) = self.paint.open(canvas);
        if let Some(rows) = depth.as_mut().and_then(DepthBuffer::bounds_mut) {
            limits.occluders.limit(limits.row, rows);
        }
    }

    fn draw(&self, tiler: &mut Tiler, canvas: &mut C) {
        let (mut shader, mut target, mut depth) = self.paint.open(canvas);
        let window = tiler.window(target.size(), depth.as_ref());
        dispatch!(tiler.simd().0, simd => {
            let mut faces = FaceCount::new(tiler.stats_mut());
            let (mut next, end) = (0, self.batch.len());
            while next < end {
                let seen = self.seen(next, end, tiler.stats_mut(), &mut faces);
                next = seen.end;
                for first in seen.clone().step_by(BUNCH) {
                    let count = BUNCH.min(seen.end - first);
                    let polygons = Run { batch: &self.batch, first };
                    tiler.look_at::<EIGHT, _, _>(simd, &polygons, count, window);
                    for k in 0..count {
                        shader.start(first + k);
                        let outcome = tiler.draw_next::<EIGHT, _, _, _, _>(
                            simd, &polygons, k, window, &mut shader, &mut target, depth.as_mut(),
                        );
                        let continues = self.batch.continues(first + k);
                        faces.count(tiler.stats_mut(), outcome, continues);
                    }
                }
            }
        });
    }

    fn sort(&self, sorting: Sorting<'_>, polygons: Range<usize>) {
        let Sorting { tiler, bins, window, occluders } = sorting;
        // A face belongs to the chunk where it begins.
        let begin = |mut i: usize| {
            while i < self.batch.len() && i > 0 && self.batch.continues(i) {
                i += 1;
            }
            i
        };
        let (start, end) = (begin(polygons.start), begin(polygons.end));
        dispatch!(tiler.simd().0, simd => {
            let mut faces = FaceCount::new(tiler.stats_mut());
            let mut next = start;
            while next < end {
                let seen = self.seen(next, end, tiler.stats_mut(), &mut faces);
                next = seen.end;
                for first in seen.clone().step_by(EIGHT) {
                    let count = EIGHT.min(seen.end - first);
                    let eight = Run { batch: &self.batch, first };
                    tiler.look_from_outside::<EIGHT, _, _>(simd, &eight, 0..count, window);
                    for lane in 0..count {
                        let i = first + lane;
                        let polygon = self.batch.polygon(i);
                        let (outcome, rows) =
                            tiler.sort_next(simd, &polygon, lane, window, occluders);
                        if let Some(rows) = rows {
                            bins.add(i - polygons.start, rows);
                        }
                        faces.count(tiler.stats_mut(), outcome, self.batch.continues(i));
                    }
                }
            }
        });
    }

    fn paint(&self, painting: Painting<'_>, canvas: &mut C) {
        let Painting { tiler, keep, first_kept, band, is_top, first, entries } = painting;
        let (mut shader, mut target, mut depth) = self.paint.open(canvas);
        let window = tiler.window(target.size(), depth.as_ref());
        dispatch!(tiler.simd().0, simd => {
            let mut entries = entries;
            let mut some = [Entry::default(); BUNCH];
            loop {
                let mut count = 0;
                for (place, entry) in some.iter_mut().zip(&mut entries) {
                    *place = entry;
                    count += 1;
                }
                if count == 0 {
                    break;
                }
                let some = &some[..count];
                let polygons = Sorted { batch: &self.batch, first, entries: some };
                tiler.look_at::<EIGHT, _, _>(simd, &polygons, count, window);
                for (k, entry) in some.iter().enumerate() {
                    let i = first + entry.polygon;
                    shader.start(i);
                    let Stats { clipped, constant_w, .. } = *tiler.stats_mut();
                    if let Some((number, last_band)) = entry.kept {
                        let kept = Kept { number: first_kept + number, last_band };
                        let known = (&mut *keep, kept, band);
                        let polygon = self.batch.polygon(i);
                        tiler.draw_kept(
                            &polygon, window, known, &mut shader, &mut target, depth.as_mut(),
                        );
                    } else {
                        tiler.draw_next::<EIGHT, _, _, _, _>(
                            simd, &polygons, k, window, &mut shader, &mut target, depth.as_mut(),
                        );
                    }
                    // A polygon counts once: what was clipped, when it was sorted.
                    let stats = tiler.stats_mut();
                    stats.clipped = clipped;
                    if !(entry.is_first_band && is_top) || i > 0 && self.batch.continues(i) {
                        stats.constant_w = constant_w;
                    }
                }
            }
        });
    }
}
