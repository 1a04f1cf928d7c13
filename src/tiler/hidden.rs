//! Whole polygons, and parts of spans, that bounds of the stored depths show to be hidden.

use alloc::vec::Vec;

use fearless_simd::Simd as Lanes;

use super::{Scratch, Tiler, positions_of};
use crate::depth::{DepthSource, DepthTest, Occluders, SIDE};
use crate::edge::Span;
use crate::fixed::{Subpixel, power_of_two};
use crate::gradient::enclosure::{Enclosure, outward, within};
use crate::gradient::{Gradients, Quantity, Subject, nearest_f32};
use crate::hidden::Area;
use crate::paint::Placement;
use crate::placed::PlacedVertex;
use crate::polygon::Polygon;
use crate::space::{DepthRange, PixelRect, Viewport};
use crate::target::DepthBuffer;
use crate::triangle::InView;

/// Bounds that any depth keeps.
const ANY_DEPTH: [f32; 2] = [0.0, f32::INFINITY];

/// How thick a polygon must be, in the reach of the snap, for its corners to tell its depths.
const THICK: f64 = 512.0;

/// By how much of the corners' range depths may lie beyond it, then.
const BEYOND: f64 = 1.0 / 64.0;

/// Corners of a polygon with all w > 0 that nothing clips: positions, times 2^-`exponent`, and
/// places on the grid.
struct Corners<'a, const N: usize> {
    positions: &'a [[f64; 4]; N],
    bits: [[i32; 2]; N],
    exponent: i32,
}

impl<const N: usize> Corners<'_, N> {
    /// What the depths of the pixels lie between: of a triangle or a quadrilateral. docs/precision.md,
    /// "What is hidden", has the proof.
    #[inline(always)]
    fn depths(&self, source: DepthSource, viewport: Viewport) -> [f32; 2] {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut depths = [0.0; N];
        for (depth, position) in depths.iter_mut().zip(self.positions) {
            *depth = right_depth(*position, source, viewport);
            low = if *depth < low { *depth } else { low };
            high = if *depth > high { *depth } else { high };
        }
        let beyond = match source {
            DepthSource::Z => self.beyond(&depths, high - low, viewport.grid().snap_reach()),
            // It is clamped to the range of the vertices.
            DepthSource::InvW => {
                let scale = power_of_two(-self.exponent);
                (low, high) = (low * scale, high * scale);
                0.0
            }
        };
        within(outward([low - beyond, high + beyond]), ANY_DEPTH)
    }

    /// How far a pixel's depth may lie beyond those of the corners, which differ by `difference`;
    /// infinite where that is not known.
    #[inline(always)]
    fn beyond(&self, depths: &[f64; N], difference: f64, reach: f64) -> f64 {
        let pixels = |bits: i32| f64::from(bits) / f64::from(1 << Subpixel::FRACTION_BITS);
        let place = |i: usize| self.bits[i].map(pixels);
        let [x, y] = place(0);
        let from_first = |i: usize| {
            let [px, py] = place(i);
            [px - x, py - y]
        };
        let (mut low, mut high) = ([0.0; 2], [0.0; 2]);
        for i in 1..N {
            let p = from_first(i);
            for k in 0..2 {
                low[k] = if p[k] < low[k] { p[k] } else { low[k] };
                high[k] = if p[k] > high[k] { p[k] } else { high[k] };
            }
        }
        let size = high[0] - low[0] + high[1] - low[1] + 2.0 * reach;
        let cross = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2]| ax * by - ay * bx;
        // Twice the areas of the triangles without one corner.
        let (least_area, defect) = match N {
            3 => (cross(from_first(1), from_first(2)).abs(), 0.0),
            4 => {
                let [p, q, r] = [from_first(1), from_first(2), from_first(3)];
                let [a, b, c] = [cross(q, r), cross(p, r), cross(p, q)];
                let first = a - b + c;
                let defect = b * (depths[2] - depths[0])
                    - a * (depths[1] - depths[0])
                    - c * (depths[3] - depths[0]);
                let mut least = first.abs();
                for area in [a, b, c] {
                    least = if area.abs() < least { area.abs() } else { least };
                }
                (least, defect.abs())
            }
            _ => return f64::INFINITY,
        };
        if least_area >= THICK * reach * size {
            defect / least_area * (1.0 + BEYOND) + difference * BEYOND
        } else {
            f64::INFINITY
        }
    }
}

/// The depth at a corner.
#[inline(always)]
pub(super) fn right_depth([_, _, z, w]: [f64; 4], source: DepthSource, viewport: Viewport) -> f64 {
    match (source, viewport.depth_range()) {
        (DepthSource::InvW, _) => 1.0 / w,
        (DepthSource::Z, DepthRange::ZeroToOne) => z / w,
        (DepthSource::Z, DepthRange::MinusOneToOne) => (z + w) / 2.0 / w,
    }
}

impl Tiler {
    /// Is all that was taken surely hidden, as far as its corners tell?
    pub(super) fn is_hidden(
        &self,
        window: PixelRect,
        buffer: Option<&mut DepthBuffer<'_>>,
    ) -> bool {
        let Scratch { taken, given, screen, .. } = &self.scratch;
        let Some(buffer) = buffer.filter(|buffer| buffer.has_bounds()) else { return false };
        let Some(area) = Area::new(taken.seen.intersect(window), self.origin) else { return false };
        // Those that the division left out named no place.
        if !taken.whole || screen.len() != given.len() {
            return false;
        }
        let bits = |i: usize| screen[i].snapped.map(Subpixel::bits);
        let (source, viewport, exponent) = (self.depth_test.source, self.viewport, taken.exponent);
        let depths = match *given.as_slice() {
            [a, b, c] => {
                let bits = [bits(0), bits(1), bits(2)];
                Corners { positions: &[a, b, c], bits, exponent }.depths(source, viewport)
            }
            [a, b, c, d] => {
                let bits = [bits(0), bits(1), bits(2), bits(3)];
                Corners { positions: &[a, b, c, d], bits, exponent }.depths(source, viewport)
            }
            _ => return false,
        };
        buffer.hides(area, depths, self.depth_test.compare)
    }

    /// Is `polygon` a quadrilateral within the view that `buffer` surely hides, as far as its corners
    /// tell? Then it need not even be divided.
    #[inline(always)]
    pub(super) fn is_hidden_in_view<L: Lanes, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
        window: PixelRect,
        buffer: &mut DepthBuffer<'_>,
    ) -> bool {
        let DepthTest { compare, source, .. } = self.depth_test;
        let Some((bits, bounds)) = self.quad_in_view(simd, polygon) else { return false };
        let Some(area) = Area::new(bounds.intersect(window), self.origin) else { return false };
        let first = right_depth(polygon.position(0), source, self.viewport);
        buffer.may_hide(area, nearest_f32(first), compare)
            && buffer.hides(area, self.quad_depths(polygon, bits), compare)
    }

    /// The same, by what others of the list hide.
    #[inline(always)]
    pub(super) fn is_occluded<L: Lanes, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
        window: PixelRect,
        occluders: &Occluders,
    ) -> bool {
        let Some((bits, bounds)) = self.quad_in_view(simd, polygon) else { return false };
        let Some(area) = Area::new(bounds.intersect(window), self.origin) else { return false };
        let first = right_depth(polygon.position(0), self.depth_test.source, self.viewport);
        let nearer = usize::from(self.depth_test.compare.raises());
        area.is_first_behind(occluders, nearest_f32(first))
            && area.is_behind(occluders, self.quad_depths(polygon, bits)[nearer])
    }

    /// The corners of a quadrilateral within the view, and the pixels that it may cover.
    #[inline(always)]
    fn quad_in_view<L: Lanes, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
    ) -> Option<([[i32; 2]; 4], PixelRect)> {
        if polygon.len() != 4 {
            return None;
        }
        let a = self.vertex_place(simd, polygon, 0);
        let b = self.vertex_place(simd, polygon, 1);
        let c = self.vertex_place(simd, polygon, 2);
        let d = self.vertex_place(simd, polygon, 3);
        if !(a.within & b.within & c.within & d.within) {
            return None;
        }
        let (mut low, mut high) = (a.bits, a.bits);
        for corner in [b, c, d] {
            let [x, y] = corner.bits;
            low = [low[0].min(x), low[1].min(y)];
            high = [high[0].max(x), high[1].max(y)];
        }
        Some(([a.bits, b.bits, c.bits, d.bits], self.bounds_between(low, high)))
    }

    /// What the depths of a quadrilateral within the view lie between.
    #[inline(always)]
    fn quad_depths<V: Polygon + ?Sized>(&self, polygon: &V, bits: [[i32; 2]; 4]) -> [f32; 2] {
        let positions =
            &[polygon.position(0), polygon.position(1), polygon.position(2), polygon.position(3)];
        let corners = Corners { positions, bits, exponent: 0 };
        corners.depths(self.depth_test.source, self.viewport)
    }

    /// Is the small triangle that was `found` surely hidden? If not, it counts as drawn: what it
    /// may store widens the bounds.
    #[inline(always)]
    pub(super) fn is_hidden_small<V: Polygon + ?Sized>(
        &self,
        triangle: &V,
        placed: [PlacedVertex; 3],
        found: &InView,
        window: PixelRect,
        buffer: &mut DepthBuffer<'_>,
    ) -> bool {
        let DepthTest { compare, write, source } = self.depth_test;
        let Some(area) = Area::new(found.bounds.intersect(window), self.origin) else {
            return false;
        };
        let mut depths = ANY_DEPTH;
        let first = nearest_f32(right_depth(triangle.position(0), source, self.viewport));
        if self.hides && buffer.may_hide(area, first, compare) {
            let positions = &positions_of(triangle);
            let [a, b, c] = placed;
            let bits = [a.bits, b.bits, c.bits];
            depths = Corners { positions, bits, exponent: 0 }.depths(source, self.viewport);
            if buffer.hides(area, depths, compare) {
                return true;
            }
        }
        if write {
            buffer.wrote(area, depths, compare, found.pixels);
        }
        false
    }
}

/// What is compared at a polygon's pixels, where the polygon is drawn by spans.
pub(super) struct TestedSpans {
    depths: Enclosure,
    /// The pixel that it counts from, in the framebuffer.
    anchor: [i32; 2],
    place: Placement,
    /// How many are covered.
    pixels: u64,
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
    /// Of a polygon that has been set up, and covers so many pixels.
    pub(super) fn new(
        gradients: &Gradients,
        subject: &Subject<'_>,
        place: Placement,
        pixels: u64,
    ) -> Self {
        let quantity = match place.test.source {
            DepthSource::Z => Quantity::Depth,
            DepthSource::InvW => Quantity::InvW,
        };
        let depths = gradients.enclosure(quantity, subject);
        Self { depths, anchor: gradients.anchor.pixel, place, pixels }
    }

    /// The pixels that `spans` lie in, and what their depths lie between.
    fn whole(&self, spans: &[Span]) -> Option<(Area, [f32; 2])> {
        let (first, last) = (spans.first()?, spans.last()?);
        let (mut start, mut end) = (first.start, first.end);
        for span in spans {
            (start, end) = (start.min(span.start), end.max(span.end));
        }
        let Placement { corner, origin, .. } = self.place;
        let pixels = PixelRect {
            x0: start + corner[0],
            y0: first.row + corner[1],
            x1: end + corner[0],
            y1: last.row + corner[1] + 1,
        };
        let from_anchor = |c: i32, k: usize| f64::from(c - self.anchor[k]);
        let u = [from_anchor(pixels.x0, 0), from_anchor(pixels.x1 - 1, 0)];
        let v = [from_anchor(pixels.y0, 1), from_anchor(pixels.y1 - 1, 1)];
        Some((Area::new(pixels, origin)?, self.depths.over(u, v)))
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
            let whole = self.whole(spans);
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
                |c: i32, k: usize| f64::from(c + self.place.corner[k] - self.anchor[k]);
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
            if let Some((area, depths)) = self.whole(spans) {
                buffer.wrote(area, depths, test.compare, shaded);
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
