//! Spans of a polygon that is set up, by tiles of the depth buffer: which of them bounds of the stored
//! depths show to be hidden, and which they fill.

use alloc::vec::Vec;

use super::scan::Counts;
use crate::depth::{DepthSource, Occluders, SIDE};
use crate::edge::Span;
use crate::gradient::enclosure::Enclosure;
use crate::gradient::{Gradients, Quantity, Subject};
use crate::hidden::Area;
use crate::paint::Placement;
use crate::space::{PixelRect, Viewport};
use crate::target::DepthBuffer;

/// What is compared at a polygon's pixels, where the polygon is drawn by spans.
pub(super) struct TestedSpans {
    pub(super) depths: Enclosure,
    place: Placement,
    /// How many are covered, and where.
    pixels: u64,
    within: PixelRect,
}

/// What covers fewer pixels is looked at as a whole: it fills few tiles, if any.
pub(super) const SMALL: u64 = 4 * (SIDE * SIDE) as u64;

/// Spans in a row of tiles.
struct Band<'a> {
    spans: &'a [Span],
    /// The first column and the one after the last, in the buffer.
    columns: [u32; 2],
    /// The first and the last row, from the anchor.
    v: [f64; 2],
    /// The first column, from the anchor.
    u: f64,
    /// The row of tiles.
    tile_row: u32,
}

impl Band<'_> {
    /// The first and the last tile.
    fn tiles(&self) -> [u32; 2] {
        [self.columns[0] / SIDE, (self.columns[1] - 1) / SIDE]
    }

    /// The columns that are covered in each row, of all of a tile's: first, and after the last.
    fn filled(&self, rows: u32) -> Option<[i32; 2]> {
        let follow = self.spans.windows(2).all(|pair| pair[0].row + 1 == pair[1].row);
        if !follow || self.spans.len() != rows as usize {
            return None;
        }
        let start = self.spans.iter().map(|span| span.start).max()?;
        let end = self.spans.iter().map(|span| span.end).min()?;
        (start < end).then_some([start, end])
    }

    /// Columns of tile `x`, from the anchor: first and last.
    #[inline(always)]
    fn columns_of(&self, x: u32) -> [f64; 2] {
        let [start, end] = self.columns;
        let (first, last) = ((x * SIDE).max(start), (x * SIDE + SIDE - 1).min(end - 1));
        [self.u + f64::from(first - start), self.u + f64::from(last - start)]
    }
}

/// A bit for each tile of the longest row: of a viewport's width.
type TileBits = [u64; Viewport::MAX_SIDE as usize / SIDE as usize / 64 + 1];

/// The next tile after `tile` with another bit, or the first one that has none.
#[inline]
fn end_of_run(bits: &TileBits, tile: usize) -> usize {
    let (first, mut shift) = (tile / 64, tile % 64);
    let flip = if bits[first] >> shift & 1 != 0 { u64::MAX } else { 0 };
    for (i, word) in bits.iter().enumerate().skip(first) {
        let others = (word ^ flip) >> shift;
        if others != 0 {
            return i * 64 + shift + others.trailing_zeros() as usize;
        }
        shift = 0;
    }
    bits.len() * 64
}

impl TestedSpans {
    /// Of a polygon that has been set up, and covers these pixels.
    pub(super) fn new(
        gradients: &Gradients,
        subject: &Subject<'_>,
        place: Placement,
        Counts { pixels, within, .. }: Counts,
    ) -> Self {
        let quantity = match place.test.source {
            DepthSource::Z => Quantity::Depth,
            DepthSource::InvW => Quantity::InvW,
        };
        let depths = gradients.enclosure(quantity, subject);
        Self { depths, place, pixels, within }
    }

    /// The pixels that all lie in, and what their depths lie between.
    fn whole(&self) -> Option<(Area, [f32; 2])> {
        let area = Area::new(self.within, self.place.origin)?;
        Some((area, self.depths.over_pixels(self.within)))
    }

    /// Takes what is surely hidden out of `spans`, and says whether that is all; `spare` is
    /// overwritten.
    pub(super) fn hide(
        &self,
        spans: &mut Vec<Span>,
        spare: &mut Vec<Span>,
        buffer: &mut DepthBuffer<'_>,
    ) -> bool {
        if self.pixels < SMALL {
            let whole = self.whole();
            return whole
                .is_some_and(|(area, depths)| buffer.hides(area, depths, self.place.test.compare));
        }
        self.cut(spans, spare, buffer);
        spans.is_empty()
    }

    /// The row of tiles that `span` lies in.
    #[inline(always)]
    fn tile_row(&self, span: &Span) -> u32 {
        (span.row + self.place.corner[1]).abs_diff(self.place.origin[1]) / SIDE
    }

    /// The buffer's column of the column `x` of a span.
    #[inline(always)]
    fn column(&self, x: i32) -> u32 {
        (x + self.place.corner[0]).abs_diff(self.place.origin[0])
    }

    /// `spans`, by rows of tiles.
    fn bands<'a>(&self, spans: &'a [Span]) -> impl Iterator<Item = Band<'a>> {
        spans.chunk_by(|a, b| self.tile_row(a) == self.tile_row(b)).filter_map(|spans| {
            let (first, last) = (spans.first()?, spans.last()?);
            let start = spans.iter().map(|span| span.start).min()?;
            let end = spans.iter().map(|span| span.end).max()?;
            let from_anchor =
                |c: i32, k: usize| f64::from(c + self.place.corner[k] - self.depths.anchor[k]);
            Some(Band {
                spans,
                columns: [self.column(start), self.column(start) + start.abs_diff(end)],
                v: [from_anchor(first.row, 1), from_anchor(last.row, 1)],
                u: from_anchor(start, 0),
                tile_row: self.tile_row(first),
            })
        })
    }

    /// The same of tiles.
    fn cut(&self, spans: &mut Vec<Span>, spare: &mut Vec<Span>, buffer: &mut DepthBuffer<'_>) {
        spare.clear();
        let (mut done, mut any) = (0, false);
        for band in self.bands(spans) {
            match self.hidden_tiles(&band, buffer) {
                Some(hidden) => {
                    if !any {
                        spare.extend_from_slice(&spans[..done]);
                    }
                    any = true;
                    let [first, last] = band.tiles();
                    if end_of_run(&hidden, 0) <= (last - first) as usize {
                        band.spans.iter().for_each(|s| self.cut_span(s, &band, &hidden, spare));
                    }
                }
                None if any => spare.extend_from_slice(band.spans),
                None => {}
            }
            done += band.spans.len();
        }
        if any {
            core::mem::swap(spans, spare);
        }
    }

    /// Which tiles of `band` hide what lies in them, from its first one on; nothing if none does.
    fn hidden_tiles(&self, band: &Band<'_>, buffer: &mut DepthBuffer<'_>) -> Option<TileBits> {
        let [first, last] = band.tiles();
        let mut hidden: TileBits = [0; _];
        let mut any = false;
        for (i, x) in (first..=last).enumerate() {
            let depths = self.depths.over(band.columns_of(x), band.v);
            if buffer.tile_hides([x, band.tile_row], depths, self.place.test.compare) {
                hidden[i / 64] |= 1 << (i % 64);
                any = true;
            }
        }
        any.then_some(hidden)
    }

    /// The pieces of `span` that are not hidden. They end where blocks do, as blocks count.
    fn cut_span(&self, span: &Span, band: &Band<'_>, hidden: &TileBits, out: &mut Vec<Span>) {
        let (start, end) = (self.column(span.start), self.column(span.end));
        let [first_tile, _] = band.tiles();
        // From a column of the buffer to the next one at which a block begins, and to the last.
        let phase = self.place.origin[0].cast_unsigned() % SIDE;
        let next_block = |x: u32| x + (SIDE - (x + phase) % SIDE) % SIDE;
        let this_block = |x: u32| x.saturating_sub((x + phase) % SIDE);
        let mut push = |from: u32, to: u32| {
            if from < to {
                let at = |x: u32| span.start + (x - start).cast_signed();
                out.push(Span { start: at(from), end: at(to), ..*span });
            }
        };
        let (mut from, mut x) = (start, start);
        while x < end {
            let (run_start, tile) = (x, (x / SIDE - first_tile) as usize);
            x = end.min((first_tile + end_of_run(hidden, tile) as u32) * SIDE);
            if hidden[tile / 64] >> (tile % 64) & 1 != 0 {
                let first = if run_start == start { start } else { next_block(run_start) };
                let last = if x == end { end } else { this_block(x) };
                if first < last {
                    push(from, first);
                    from = last;
                }
            }
        }
        push(from, end);
    }

    /// Notes which tiles of the depth buffer `spans` fill, and returns how many of them were not
    /// filled before.
    pub(super) fn occlude(&self, spans: &[Span], occluders: &mut Occluders) -> u32 {
        let (width, height) = occluders.size();
        let mut count = 0;
        for band in self.bands(spans) {
            let rows = SIDE.min(height.saturating_sub(band.tile_row * SIDE));
            let Some(columns) = band.filled(rows) else { continue };
            let [from, to] = columns.map(|x| self.column(x));
            let end = if to == width { to.div_ceil(SIDE) } else { to / SIDE };
            for x in from.div_ceil(SIDE)..end {
                let depths = self.depths.over(band.columns_of(x), band.v);
                count += u32::from(occluders.fill([x, band.tile_row], depths));
            }
        }
        occluders.filled();
        count
    }

    /// Keeps the bounds true of what was painted of `spans`: `shaded` of their pixels, and all
    /// of these if that is what the shader keeps.
    pub(super) fn wrote(
        &self,
        spans: &[Span],
        buffer: &mut DepthBuffer<'_>,
        shaded: u64,
        keeps_all: bool,
    ) {
        let test = self.place.test;
        if shaded == 0 || !test.write {
            return;
        }
        if self.pixels < SMALL {
            if let Some((area, depths)) = self.whole() {
                buffer.hides_or_takes(area, depths, test.compare, false, Some(shaded));
            }
            return;
        }
        let pixels = |spans: &[Span]| -> u64 {
            spans.iter().map(|span| u64::from(span.start.abs_diff(span.end))).sum()
        };
        let all = keeps_all && shaded == pixels(spans);
        let (width, height) = buffer.dimensions();
        let Some(bounds) = buffer.bounds_mut() else { return };
        for band in self.bands(spans) {
            let rows = SIDE.min(height - band.tile_row * SIDE);
            let filled = if all { band.filled(rows) } else { None };
            let filled = filled.map(|columns| columns.map(|x| self.column(x)));
            let [first, last] = band.tiles();
            let count = pixels(band.spans) / u64::from(last - first + 1) + 1;
            for x in first..=last {
                let depths = self.depths.over(band.columns_of(x), band.v);
                let (start, end) = (x * SIDE, (x * SIDE + SIDE).min(width));
                if filled.is_some_and(|[from, to]| from <= start && end <= to) {
                    bounds.fill([x, band.tile_row], depths, test.compare);
                } else {
                    bounds.widen([x, band.tile_row], depths, test.compare, count);
                }
            }
        }
    }
}
