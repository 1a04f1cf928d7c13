//! Draw calls: polygons, and what they are drawn with.

use core::ops::Range;

use super::bins::{Entries, Entry};
use super::canvas::{Canvas, Paint};
use super::listed::{Listed, Pass, Sorting, seen};
use super::occlude::{Limits, Role, Surveying};
use super::scattered::is_scattered;
use crate::batch::Batch;
use crate::shade::Shader;
use crate::space::PixelRect;
use crate::stats::FaceCount;
use crate::target::{DepthBuffer, Target};
use crate::tiler::Tiler;
use crate::tiler::bunch::BUNCH;

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

    /// May a canvas be cleared later that it draws on?
    #[doc(hidden)]
    fn clears(&self) -> bool;

    /// Clears what is left to be cleared.
    #[doc(hidden)]
    fn clear_rest(&self, canvas: &mut C);

    /// Are the polygons worth being sorted to be drawn in `window` by one thread?
    #[doc(hidden)]
    fn is_scattered(&self, tiler: &Tiler, window: PixelRect) -> bool;

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

/// What polygons of a band are drawn with.
#[derive(Debug)]
pub struct Painting<'a> {
    pub(super) tiler: &'a mut Tiler,
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

    fn clears(&self) -> bool {
        P::CLEARS
    }

    fn clear_rest(&self, canvas: &mut C) {
        let (_, mut target, depth) = self.paint.open(canvas);
        if let Some(mut depth) = depth {
            depth.clear_rest(&mut target);
        }
    }

    fn is_scattered(&self, tiler: &Tiler, window: PixelRect) -> bool {
        is_scattered(&self.batch, tiler, window)
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
        let mut faces = FaceCount::new(tiler.stats_mut());
        let (batch, end) = (&self.batch, self.batch.len());
        let mut next = 0;
        while next < end {
            let seen = seen(batch, next..end, tiler.stats_mut(), &mut faces);
            next = seen.end;
            for some in Listed::all(batch, seen) {
                let pass = &mut Pass::Only(&mut faces);
                some.draw(tiler, pass, window, &mut shader, &mut target, depth.as_mut());
            }
        }
    }

    fn sort(&self, sorting: Sorting<'_>, polygons: Range<usize>) {
        sorting.sort(&self.batch, polygons);
    }

    fn paint(&self, painting: Painting<'_>, canvas: &mut C) {
        let Painting { tiler, is_top, first, mut entries } = painting;
        let (mut shader, mut target, mut depth) = self.paint.open(canvas);
        let window = tiler.window(target.size(), depth.as_ref());
        let mut pass = Pass::Band { is_top };
        let mut take = || {
            let mut some = [Entry::default(); BUNCH];
            let mut count = 0;
            for (place, entry) in some.iter_mut().zip(&mut entries) {
                *place = entry;
                count += 1;
            }
            (some, count)
        };
        let batch = &self.batch;
        let (mut some, mut count) = take();
        while count > 0 {
            let (next, next_count) = take();
            Listed { batch, first, count: next_count, entries: &next }.fetch();
            let now = Listed { batch, first, count, entries: &some };
            now.draw(tiler, &mut pass, window, &mut shader, &mut target, depth.as_mut());
            (some, count) = (next, next_count);
        }
    }
}
