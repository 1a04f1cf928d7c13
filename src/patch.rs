//! Small triangles: from three snapped vertices to covered pixels, 16 at a time.
//!
//! A triangle of a few pixels costs more in edges and spans than in pixels. Here its bounding
//! box is cut into *patches*, as many whole rows as 16 lanes hold, and a lane is covered if its
//! centre is on the inner side of three edge functions (Pineda 1988). They are whole numbers
//! below 2^53, so `f64` has them exactly, and the rule is that of the Y loop: a centre on a left
//! or a top edge is in.

use fearless_simd::{Simd, SimdBase, SimdMask, f64x8, mask64x8};

use crate::fixed::Subpixel;
use crate::lanes::low_bits;
use crate::shade::BLOCK;
use crate::space::PixelRect;

/// Patches of a triangle, at most.
const MOST: usize = 8;

/// A pixel's side, with 16 fraction bits.
const PIXEL: f64 = (1 << Subpixel::FRACTION_BITS) as f64;

/// The covered pixels of a small triangle.
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
        let [column, row] = OFFSETS[usize::from(self.columns)][lane];
        let [x, y] = [self.first[0].wrapping_sub(origin[0]), self.first[1].wrapping_sub(origin[1])];
        [x.wrapping_add(column.into()).cast_unsigned(), y.wrapping_add(row.into()).cast_unsigned()]
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
        let count = usize::from(height).div_ceil(usize::from(rows));
        if count > MOST {
            return None;
        }
        let first = [bounds.x0, bounds.y0];
        let pixels_of_box = u32::from(width) * u32::from(height);
        Some(Self { first, columns: width, rows, pixels_of_box, count, masks: [0; MOST] })
    }

    /// Finds what the triangle covers within `window`: `vertices` from the first pixel's centre,
    /// whole numbers with 16 fraction bits. `front`: counter-clockwise with y up. Returns pixels
    /// and spans.
    #[inline(always)]
    pub(crate) fn cover<S: Simd>(
        &mut self,
        simd: S,
        vertices: [[f64; 2]; 3],
        front: bool,
        window: PixelRect,
    ) -> (u64, u64) {
        let [a, b, c] = vertices;
        // The same way round for all.
        let (b, c) = if front { (c, b) } else { (b, c) };
        let edges = [Edge::new(a, b), Edge::new(b, c), Edge::new(c, a)];
        if self.pixels_of_box == 1 {
            let inside = edges[0].start >= 0.0 && edges[1].start >= 0.0 && edges[2].start >= 0.0;
            self.masks[0] = u16::from(inside && window.contains(self.bounds()));
            return (self.masks[0].into(), self.masks[0].into());
        }
        let columns = usize::from(self.columns);
        let in_rows = u16::MAX >> (16 - self.columns * self.rows);
        let seen_whole = window.contains(self.bounds());
        let few = self.count == 1 && self.pixels_of_box <= 8;
        let (mut pixels, mut spans, mut row) = (0, 0, 0.0);
        for i in 0..self.count {
            let mut mask = covered(simd, edges, columns, row, 0);
            if !few {
                mask |= covered(simd, edges, columns, row, 1) << 8;
            }
            mask &= in_rows;
            self.masks[i] = mask;
            if !seen_whole {
                self.cut(i, window);
                mask = self.masks[i];
            }
            pixels += mask.count_ones();
            // A row's run begins where the lane before is not set, or is in the row above.
            spans += (mask & !(mask << 1 & !FIRST_LANES[columns])).count_ones();
            row += f64::from(self.rows);
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

    /// Takes out of patch `i` what is not in `window`.
    #[cold]
    fn cut(&mut self, i: usize, window: PixelRect) {
        let patch = self.patch(i);
        for lane in 0..16_u16 {
            let x = patch.first[0].saturating_add(i32::from(lane % patch.columns));
            let y = patch.first[1].saturating_add(i32::from(lane / patch.columns));
            if !window.contains(PixelRect::new(x, y, 1, 1)) {
                self.masks[i] &= !(1 << lane);
            }
        }
    }

    #[inline(always)]
    fn patch(&self, i: usize) -> Patch {
        let Self { first: [x, y], columns, rows, .. } = *self;
        let above = i32::try_from(i).unwrap_or(0) * i32::from(rows);
        Patch { first: [x, y.wrapping_add(above)], columns, mask: self.masks[i] }
    }

    /// Those of which something is covered.
    #[inline(always)]
    pub(crate) fn iter(&self) -> impl Iterator<Item = Patch> {
        (0..self.count).map(|i| self.patch(i)).filter(|patch| patch.mask != 0)
    }
}

/// An edge function: not negative at the centres that are on the inner side.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// At the first pixel's centre.
    start: f64,
    /// A column to the right, a row down.
    step_x: f64,
    step_y: f64,
}

impl Edge {
    /// From `p` to `q`, with the inside on the left where y points down.
    #[inline(always)]
    fn new([px, py]: [f64; 2], [qx, qy]: [f64; 2]) -> Self {
        let (dx, dy) = (qx - px, qy - py);
        // On the edge itself: is a point a hair to the right, and a hair's hair below, inside?
        let owns = dy < 0.0 || dy == 0.0 && dx > 0.0;
        let start = dy * px - dx * py - if owns { 0.0 } else { 1.0 };
        Self { start, step_x: -dy * PIXEL, step_y: dx * PIXEL }
    }

    /// Which of the centres `xs` columns and `ys` rows from the first of row `row` are inside.
    #[inline(always)]
    fn inside<S: Simd>(self, simd: S, xs: f64x8<S>, ys: f64x8<S>, row: f64) -> mask64x8<S> {
        let start = f64x8::splat(simd, self.start + row * self.step_y);
        let in_row = f64x8::splat(simd, self.step_x) * xs;
        let value = start + in_row + f64x8::splat(simd, self.step_y) * ys;
        value.simd_ge(f64x8::splat(simd, 0.0))
    }
}

/// The lanes of one `half` of a patch, whose first row is `row`, that are inside of all `edges`.
#[inline(always)]
fn covered<S: Simd>(simd: S, edges: [Edge; 3], columns: usize, row: f64, half: usize) -> u16 {
    let xs = f64x8::from_slice(simd, &COLUMNS[columns][8 * half..8 * half + 8]);
    let ys = f64x8::from_slice(simd, &LANE_ROWS[columns][8 * half..8 * half + 8]);
    let [a, b, c] = edges;
    let inside = a.inside(simd, xs, ys, row) & b.inside(simd, xs, ys, row);
    low_bits((inside & c.inside(simd, xs, ys, row)).to_bitmask())
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
    let mut places = [[0.0; BLOCK]; BLOCK + 1];
    let mut columns = 1;
    while columns <= BLOCK {
        let mut lane = 0;
        while lane < BLOCK {
            places[columns][lane] = (if rows { lane / columns } else { lane % columns }) as f64;
            lane += 1;
        }
        columns += 1;
    }
    places
}
