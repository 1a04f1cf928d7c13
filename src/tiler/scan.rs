//! Any polygon, up to its spans: taken in, clipped, divided, culled, scan-converted.

use alloc::vec::Vec;

use super::{Outcome, Scratch, Tiler};
use crate::clip::Clipped;
use crate::divide::{ScreenVertex, divide, snapped_area};
use crate::edge::Span;
use crate::fixed::{exponent_of, power_of_two};
use crate::gradient::{Attributes, Field, Gradients, Subject, Wanted};
use crate::polygon::Polygon;
use crate::space::{PixelRect, Viewport};
use crate::varying::Interpolation;

/// A polygon in the framebuffer, of which the scratch holds the vertices.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Taken {
    /// The positions were multiplied by two to minus this.
    pub(super) exponent: i32,
    /// Least and greatest w of the clipped vertices.
    pub(super) w: [f64; 2],
    /// The pixels that it may cover in the viewport; it may be empty.
    pub(super) seen: PixelRect,
    /// Does nothing clip it?
    pub(super) whole: bool,
    /// See [`Subject::short`].
    pub(super) short: bool,
}

/// Pixels that are covered in a window, and in how many spans.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    pub(super) pixels: u64,
    pub(super) spans: u64,
    /// Where they lie in the framebuffer.
    pub(super) within: PixelRect,
}

impl Taken {
    /// What gradients are made of, of a polygon that is not small or not in view: its `positions` as
    /// they were taken, and the clipped ones on the `screen`.
    #[inline(always)]
    pub(super) fn subject<'a>(
        &self,
        attributes: &'a dyn Attributes,
        positions: &'a [[f64; 4]],
        screen: &'a [ScreenVertex],
        viewport: Viewport,
        interpolation: &'a [Interpolation],
        wanted: Wanted,
    ) -> Subject<'a> {
        let Self { exponent, w, seen, short, .. } = *self;
        Subject {
            attributes,
            viewport,
            positions,
            exponent,
            screen,
            in_view: false,
            interpolation,
            clipped_w: w,
            columns: [seen.x0, seen.x1 - 1],
            rows: [seen.y0, seen.y1 - 1],
            short,
            wanted,
        }
    }
}

impl Tiler {
    /// 1 to 4: from `polygon` to its clipped vertices in the framebuffer.
    pub(super) fn take<V: Polygon + ?Sized>(&mut self, polygon: &V) -> Result<Taken, Outcome> {
        // 1. The polygon, at a size where nothing overflows.
        let exponent = take_in(polygon, &mut self.scratch.given)?;
        self.clip_and_divide(exponent)
    }

    fn clip_and_divide(&mut self, exponent: i32) -> Result<Taken, Outcome> {
        let Scratch { given, clipped, screen, outline, .. } = &mut self.scratch;

        // 2. Clip, against the crossed planes only.
        let outcodes = self.clipper.classify(given.iter().copied());
        if outcodes.hidden {
            return Err(Outcome::Outside);
        }
        let visible: &[[f64; 4]] = if outcodes.accepted() {
            given
        } else {
            clipped.reset(0);
            given.iter().for_each(|p| clipped.push(*p, []));
            if self.clipper.clip(clipped) == Clipped::Outside || clipped.is_empty() {
                return Err(Outcome::Outside);
            }
            self.stats.clipped += 1;
            clipped.bare_positions()
        };

        // 3. Divide by w, through the viewport, onto the subpixel grid.
        divide(visible.iter().copied(), self.viewport, screen);

        // 4. Which way it faces, exactly; and whether a pixel's centre is near.
        let area = snapped_area(screen);
        let bounds = bounds(screen, self.viewport);
        if area == 0 && (bounds.is_empty() || !outline.set(screen).covers_anything()) {
            return Err(Outcome::Degenerate);
        }
        if !self.cull.keeps(area > 0) {
            return Err(Outcome::Backface);
        }
        let seen = bounds.intersect(self.viewport.rect());
        let (whole, w) = (outcodes.accepted(), range_of_w(screen, visible));
        Ok(Taken { exponent, w, seen, whole, short: is_short(area, bounds, seen) })
    }

    /// 5. Edges: the Y loop, from what was taken to its spans within `window`.
    pub(super) fn scan(&mut self, window: PixelRect) -> Counts {
        let Scratch { taken, screen, outline, spans, .. } = &mut self.scratch;
        let mut pixels = 0;
        spans.clear();
        let within = taken.seen.intersect(window);
        if !within.is_empty() {
            let corner = self.viewport.rect();
            let (x0, x1) = (window.x0 - corner.x0, window.x1 - corner.x0);
            let rows = window.y0 - corner.y0..window.y1 - corner.y0;
            outline.set(screen).for_each_span(rows, |span| {
                let (start, end) = (span.start.max(x0), span.end.min(x1));
                if start < end {
                    pixels += u64::from(end.abs_diff(start));
                    spans.push(Span { start, end, ..span });
                }
            });
        }
        Counts { pixels, spans: spans.len() as u64, within }
    }
}

/// Exponents of the largest number up to which a polygon stays as it is: no product of a few
/// numbers leaves the range of `f64`, so a power of two changes no bit but the exponents.
const MODERATE: i32 = 64;

/// Copies the positions and, if they are huge or tiny, brings the largest number into 1..2 by a
/// power of two, whose negated exponent it returns: so that no product overflows, no subnormal
/// is left, and scaled polygons give the same bits.
#[inline(always)]
pub(super) fn take_in<V: Polygon + ?Sized>(
    polygon: &V,
    given: &mut Vec<[f64; 4]>,
) -> Result<i32, Outcome> {
    let n = polygon.len();
    if n < 3 {
        return Err(Outcome::Degenerate);
    }
    given.clear();
    given.reserve(n);
    let (mut largest, mut finite) = (0.0_f64, true);
    for i in 0..n {
        let position = polygon.position(i);
        for component in position {
            let size = component.abs();
            finite &= size < f64::INFINITY;
            largest = if size > largest { size } else { largest };
        }
        given.push(position);
    }
    if !finite {
        return Err(Outcome::Refused);
    }
    let Some(exponent) = exponent_of(largest) else { return Err(Outcome::Degenerate) };
    Ok(moderate(given, exponent))
}

/// Positions of a small polygon, as [`take_in`] leaves them, and the negated exponent. Nothing
/// if they are none that could have been placed within the view.
#[inline(always)]
pub(super) fn take_in_view<const N: usize>(
    positions: &[[f64; 4]; N],
) -> Option<([[f64; 4]; N], i32)> {
    let (mut sum, mut largest) = (0.0, 0.0);
    for [x, y, z, w] in positions {
        sum += x + y + z + w;
        largest = if *w > largest { *w } else { largest };
    }
    // What is no number makes no number of this.
    let exponent = exponent_of(largest).filter(|_| sum * 0.0 == 0.0)?;
    let mut polygon = *positions;
    let exponent = moderate(&mut polygon, exponent);
    Some((polygon, exponent))
}

/// Multiplies `positions` by 2^-`exponent`, if that is much, and returns the exponent, else 0.
#[inline(always)]
fn moderate(positions: &mut [[f64; 4]], exponent: i32) -> i32 {
    if exponent.abs() <= MODERATE {
        return 0;
    }
    // In two steps: the power alone may lie outside the range.
    let half = exponent / 2;
    let (first, second) = (power_of_two(-half), power_of_two(half - exponent));
    for component in positions.as_flattened_mut() {
        *component = *component * first * second;
    }
    exponent
}

/// Can all but the attributes be found without spans?
#[inline(always)]
pub(super) fn may_be_packed(gradients: &Gradients) -> bool {
    let across = |field: &Option<Field>| matches!(field, Some(Field::Across(..)));
    !across(&gradients.depth) && !across(&gradients.inv_w) && !across(&gradients.w)
}

/// The pixels of the framebuffer whose centres the snapped vertices may enclose.
pub(super) fn bounds(screen: &[ScreenVertex], viewport: Viewport) -> PixelRect {
    let Some(first) = screen.first() else { return PixelRect::default() };
    let (mut low, mut high) = (first.snapped, first.snapped);
    for vertex in &screen[1..] {
        let [x, y] = vertex.snapped;
        low = [low[0].min(x), low[1].min(y)];
        high = [high[0].max(x), high[1].max(y)];
    }
    let corner = viewport.rect();
    PixelRect {
        x0: low[0].first_centre().saturating_add(corner.x0),
        y0: low[1].first_centre().saturating_add(corner.y0),
        x1: high[0].first_centre().saturating_add(corner.x0),
        y1: high[1].first_centre().saturating_add(corner.y0),
    }
}

/// Spans that are shorter than this on the average have few blocks.
const SHORT: u128 = 192;

/// So have polygons of fewer pixels, or columns, all in all.
const FEW_PIXELS: u128 = 2048;
const FEW_COLUMNS: i32 = 64;

/// Has a polygon of this `area` within `bounds`, of which `seen` lies in the viewport, short spans?
fn is_short(area: i128, bounds: PixelRect, seen: PixelRect) -> bool {
    let rows = u128::from(bounds.y1.abs_diff(bounds.y0));
    // Twice an area, with 32 fraction bits.
    let limit = (2 * FEW_PIXELS.max(SHORT * rows)) << 32;
    area.unsigned_abs() < limit || seen.x1.saturating_sub(seen.x0) <= FEW_COLUMNS
}

/// Least and greatest w of the vertices that the division kept.
fn range_of_w(screen: &[ScreenVertex], positions: &[[f64; 4]]) -> [f64; 2] {
    let (mut low, mut high) = (f64::INFINITY, 0.0);
    for vertex in screen {
        let w = positions[vertex.vertex as usize][3];
        low = if w < low { w } else { low };
        high = if w > high { w } else { high };
    }
    [low, high]
}
