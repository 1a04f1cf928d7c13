//! Small polygons: from snapped vertices to covered pixels, 16 at a time.
//!
//! A polygon of a few pixels costs more in edges and spans than in pixels. Here its bounding
//! box is cut into *patches*, as many whole rows as 16 lanes hold, and a lane is covered if its
//! centre is on the inner side of all edge functions (Pineda 1988). From one centre to the next
//! they change by whole pixels' worth, so that what is less than a pixel's worth of the first never
//! decides: `i32` has the rest exactly, and the rule is that of the Y loop: a centre on a left or a
//! top edge is in.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over arrays are unrolled, iterators are not"
)]

use fearless_simd::{Simd, SimdBase, SimdMask, i32x8, i32x16};

use crate::lanes::low_bits;
use crate::shade::BLOCK;
use crate::space::PixelRect;

/// Patches of a polygon, at most.
pub(crate) const MOST: usize = 16;

/// The covered pixels of a small polygon.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Patches {
    /// The first patch's first pixel, in the framebuffer.
    first: [i32; 2],
    /// 1 to 16.
    columns: u16,
    /// Rows of a patch.
    rows: u16,
    /// Columns times rows, without those of the last patch that are not in the box.
    pixels_of_box: u32,
    count: usize,
    masks: [u16; MOST],
}

/// Some whole rows of the bounding box: lane i is column i mod `columns` of row i / `columns`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    /// Lane 0, in the framebuffer.
    pub(crate) first: [i32; 2],
    pub(crate) columns: u16,
    /// The covered lanes.
    pub(crate) mask: u16,
}

impl Patch {
    /// Where lane `lane` is from the target's first pixel, which is at `origin`; far beyond any
    /// target if it is left of it or above.
    #[inline(always)]
    pub(crate) fn place(self, lane: usize, origin: [i32; 2]) -> [u32; 2] {
        let [column, row] = self.offsets()[lane];
        let [x, y] = [self.first[0].wrapping_sub(origin[0]), self.first[1].wrapping_sub(origin[1])];
        [x.wrapping_add(column.into()).cast_unsigned(), y.wrapping_add(row.into()).cast_unsigned()]
    }

    /// Each lane's column and row.
    #[inline(always)]
    pub(crate) fn offsets(self) -> &'static [[u8; 2]; BLOCK] {
        &OFFSETS[usize::from(self.columns)]
    }

    /// Where lane 0 is in rows of `stride` pixels, the first of which is at `origin`. It may wrap around: that
    /// lane may lie outside where covered ones do not.
    #[inline(always)]
    pub(crate) fn first_in(self, origin: [i32; 2], stride: usize) -> usize {
        let [x, y] = [self.first[0].wrapping_sub(origin[0]), self.first[1].wrapping_sub(origin[1])];
        let from_start = |c: i32| (c as isize).cast_unsigned();
        from_start(y).wrapping_mul(stride).wrapping_add(from_start(x))
    }
}

impl Patches {
    /// The patches of `bounds`, if they are few; nothing is covered yet.
    #[inline(always)]
    pub(crate) fn of(bounds: PixelRect) -> Option<Self> {
        let width = u16::try_from(bounds.x1.wrapping_sub(bounds.x0)).ok()?;
        let height = u16::try_from(bounds.y1.wrapping_sub(bounds.y0)).ok()?;
        let columns = usize::from(width);
        if !(1..=BLOCK).contains(&columns) || height == 0 {
            return None;
        }
        let rows = ROWS[columns];
        let count = patches_of(height, columns);
        if count > MOST {
            return None;
        }
        let first = [bounds.x0, bounds.y0];
        let pixels_of_box = u32::from(width) * u32::from(height);
        Some(Self { first, columns: width, rows, pixels_of_box, count, masks: [0; MOST] })
    }

    /// Is there but one pixel in the box?
    #[inline(always)]
    pub(crate) fn is_pixel(&self) -> bool {
        self.pixels_of_box == 1
    }

    /// How many lanes may be covered: of several patches all that they have.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> usize {
        match self.count {
            1 => self.pixels_of_box as usize,
            count => count * BLOCK,
        }
    }

    /// Finds what the convex polygon of `edges` covers within `window`. Returns pixels and spans.
    #[inline(always)]
    pub(crate) fn cover<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        edges: [Edge; N],
        window: PixelRect,
    ) -> (u64, u64) {
        // A bit that is set in any of them is that of a negative number.
        if self.is_pixel() {
            let mut inside = edges[0].start;
            for i in 1..N {
                inside |= edges[i].start;
            }
            self.masks[0] = u16::from(inside >= 0 && window.contains(self.bounds()));
            return (self.masks[0].into(), self.masks[0].into());
        }
        let columns = usize::from(self.columns);
        let in_rows = u16::MAX >> (16 - self.columns * self.rows);
        let seen_whole = window.contains(self.bounds());
        if self.pixels_of_box <= HALF {
            let mut any = edges[0].half(simd, columns);
            for i in 1..N {
                any |= edges[i].half(simd, columns);
            }
            let outside = any.simd_lt(i32x8::splat(simd, 0));
            let mut mask = !low_bits(outside.to_bitmask()) & u16::MAX >> (16 - self.pixels_of_box);
            if !seen_whole {
                mask &= self.seen(0, window);
            }
            self.masks[0] = mask;
            return (mask.count_ones().into(), runs_of(mask, columns).into());
        }
        let mut at = [edges[0].lanes(simd, columns); N];
        for i in 1..N {
            at[i] = edges[i].lanes(simd, columns);
        }
        let (mut pixels, mut spans, mut row) = (0, 0, 0);
        for i in 0..self.count {
            let mut any = at[0] + i32x16::splat(simd, row * edges[0].step_y);
            for k in 1..N {
                any |= at[k] + i32x16::splat(simd, row * edges[k].step_y);
            }
            let outside = any.simd_lt(i32x16::splat(simd, 0));
            let mut mask = !low_bits(outside.to_bitmask()) & in_rows;
            if !seen_whole {
                mask &= self.seen(row, window);
            }
            self.masks[i] = mask;
            pixels += mask.count_ones();
            spans += runs_of(mask, columns);
            row += i32::from(self.rows);
        }
        (pixels.into(), spans.into())
    }

    /// All pixels that the patches have, those of the last one that are not in the box included.
    fn bounds(&self) -> PixelRect {
        let rows = match self.pixels_of_box {
            1 => 1,
            _ => u32::try_from(self.count).unwrap_or(0) * u32::from(self.rows),
        };
        PixelRect::new(self.first[0], self.first[1], u32::from(self.columns), rows)
    }

    /// The lanes of the patch that begins `row` rows below the first one that lie in `window`.
    #[cold]
    fn seen(&self, row: i32, window: PixelRect) -> u16 {
        let [x, y] = [self.first[0], self.first[1].saturating_add(row)];
        // Columns and rows of the patch: the bits from one number to another.
        let between = |start: i32, end: i32, at: i32, most: u16| {
            let [start, end] = [start, end].map(|c| c.saturating_sub(at).clamp(0, most.into()));
            (1_u32 << end).wrapping_sub(1 << start.min(end))
        };
        let columns = between(window.x0, window.x1, x, self.columns);
        let rows = between(window.y0, window.y1, y, self.rows);
        let first_lanes = u32::from(FIRST_LANES[usize::from(self.columns)]);
        let mut lanes = columns * first_lanes;
        // Of rows all lanes or none: those from the first one's first to the last one's last.
        let lane_of = |row: u32| row * u32::from(self.columns);
        lanes &= match rows {
            0 => 0,
            _ => {
                let (first, last) = (rows.trailing_zeros(), 32 - rows.leading_zeros());
                (1_u32 << lane_of(last)).wrapping_sub(1 << lane_of(first))
            }
        };
        (lanes & 0xFFFF) as u16
    }

    /// Patch `i`.
    #[inline(always)]
    pub(crate) fn patch(&self, i: usize) -> Patch {
        let Self { first: [x, y], columns, rows, .. } = *self;
        let above = i as i32 * i32::from(rows);
        Patch { first: [x, y.wrapping_add(above)], columns, mask: self.masks[i] }
    }

    /// Those that cover anything.
    pub(crate) fn covered(&self) -> impl Iterator<Item = Patch> {
        (0..self.count()).map(|i| self.patch(i)).filter(|patch| patch.mask != 0)
    }

    /// How many there are; some may cover nothing.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count.min(MOST)
    }
}

/// An edge function, over a pixel's side: not negative at the centres on the inner side. Of a
/// polygon that has patches, no number here reaches 2^28.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// At the first pixel's centre, rounded down.
    pub(crate) start: i32,
    /// A column to the right, a row down: 16 fraction bits.
    pub(crate) step_x: i32,
    pub(crate) step_y: i32,
}

impl Edge {
    /// At the lanes of a patch of so many columns that begins with the first pixel.
    #[inline(always)]
    fn lanes<S: Simd>(self, simd: S, columns: usize) -> i32x16<S> {
        let across = i32x16::load_array_ref(simd, &LANE_COLUMNS[columns]);
        let down = i32x16::load_array_ref(simd, &LANE_ROWS_DOWN[columns]);
        across * self.step_x + down * self.step_y + self.start
    }

    /// The same at the first half of them.
    #[inline(always)]
    fn half<S: Simd>(self, simd: S, columns: usize) -> i32x8<S> {
        let across = i32x8::from_slice(simd, &LANE_COLUMNS[columns][..BLOCK / 2]);
        let down = i32x8::from_slice(simd, &LANE_ROWS_DOWN[columns][..BLOCK / 2]);
        across * self.step_x + down * self.step_y + self.start
    }
}

/// The lanes of a half of a patch.
const HALF: u32 = BLOCK as u32 / 2;

/// How many runs of pixels of a row `mask` has, of a patch of so many columns.
#[inline(always)]
fn runs_of(mask: u16, columns: usize) -> u32 {
    // One begins where the lane before is not set, or is in the row above.
    (mask & !(mask << 1 & !FIRST_LANES[columns])).count_ones()
}

/// For each number of columns: how many whole rows 16 lanes hold.
const ROWS: [u16; BLOCK + 1] = {
    let mut rows = [0; BLOCK + 1];
    let mut columns = 1;
    while columns <= BLOCK {
        rows[columns] = (BLOCK / columns) as u16;
        columns += 1;
    }
    rows
};

/// How many patches of so many columns have `height` rows: exact up to 4096 of them, and of more not
/// less than that says. A division would be felt.
#[inline(always)]
fn patches_of(height: u16, columns: usize) -> usize {
    let rounded_up = u64::from(height) + u64::from(ROWS[columns]) - 1;
    ((rounded_up * INVERSE_ROWS[columns]) >> 16) as usize
}

/// 1/[`ROWS`], rounded up: 16 fraction bits.
const INVERSE_ROWS: [u64; BLOCK + 1] = {
    let mut inverses = [0; BLOCK + 1];
    let mut columns = 1;
    while columns <= BLOCK {
        inverses[columns] = (1_u64 << 16).div_ceil(ROWS[columns] as u64);
        columns += 1;
    }
    inverses
};

/// For each number of columns: the lanes that begin a row.
const FIRST_LANES: [u16; BLOCK + 1] = {
    let mut lanes = [0; BLOCK + 1];
    let mut columns = 1;
    while columns <= BLOCK {
        let mut lane = 0;
        while lane < BLOCK {
            lanes[columns] |= 1 << lane;
            lane += columns;
        }
        columns += 1;
    }
    lanes
};

/// For each number of columns: each lane's column.
pub(crate) static COLUMNS: [[f64; BLOCK]; BLOCK + 1] = places(false);

/// For each number of columns: each lane's row.
pub(crate) static LANE_ROWS: [[f64; BLOCK]; BLOCK + 1] = places(true);

/// The same as whole numbers.
static LANE_COLUMNS: [[i32; BLOCK]; BLOCK + 1] = whole(false);
static LANE_ROWS_DOWN: [[i32; BLOCK]; BLOCK + 1] = whole(true);

const fn whole(rows: bool) -> [[i32; BLOCK]; BLOCK + 1] {
    let mut places = [[0; BLOCK]; BLOCK + 1];
    let mut columns = 1;
    while columns <= BLOCK {
        let mut lane = 0;
        while lane < BLOCK {
            places[columns][lane] = (if rows { lane / columns } else { lane % columns }) as i32;
            lane += 1;
        }
        columns += 1;
    }
    places
}

/// For each number of columns: each lane's column and row.
static OFFSETS: [[[u8; 2]; BLOCK]; BLOCK + 1] = {
    let mut offsets = [[[0; 2]; BLOCK]; BLOCK + 1];
    let mut columns = 1;
    while columns <= BLOCK {
        let mut lane = 0;
        while lane < BLOCK {
            offsets[columns][lane] = [(lane % columns) as u8, (lane / columns) as u8];
            lane += 1;
        }
        columns += 1;
    }
    offsets
};

const fn places(rows: bool) -> [[f64; BLOCK]; BLOCK + 1] {
    let whole = whole(rows);
    let mut places = [[0.0; BLOCK]; BLOCK + 1];
    let mut columns = 1;
    while columns <= BLOCK {
        let mut lane = 0;
        while lane < BLOCK {
            places[columns][lane] = whole[columns][lane] as f64;
            lane += 1;
        }
        columns += 1;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_are_counted_without_a_division() {
        for (columns, rows) in ROWS.into_iter().enumerate().skip(1) {
            for height in 1..=u16::MAX {
                let exact = usize::from(height).div_ceil(usize::from(rows));
                let found = patches_of(height, columns);
                assert!(if height > 4096 { found > MOST } else { found == exact }, "{height}");
            }
        }
    }
}
