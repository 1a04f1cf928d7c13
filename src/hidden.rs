//! Depth buffers with bounds: which pixels are surely hidden, and what was written.

use crate::cull::{BoundingBox, ViewVolume};
use crate::depth::{Compare, DepthTest, Occluders, SIDE};
use crate::gradient::enclosure::{outward, within};
use crate::space::PixelRect;
use crate::target::DepthBuffer;

impl DepthBuffer<'_> {
    /// Does no pixel of `pixels` with a depth from the first to the second of `depths` pass, for
    /// certain? Pixels count from the buffer's first one. Without bounds nothing is certain.
    pub fn surely_hides(&mut self, pixels: PixelRect, depths: [f32; 2], compare: Compare) -> bool {
        self.surely_hides_at(pixels, [0, 0], depths, compare)
    }

    /// Would no point of `bounds` be seen in `view`, for certain? The buffer's first pixel is at
    /// `origin` in the framebuffer.
    ///
    /// That is what the box is for: to ask before drawing what it holds. One thing is not in it: a
    /// polygon thinner than some 1/128 of a pixel, or one that is not flat by as little as
    /// counts for flat, has depths at its pixels' centres that may lie beyond its own vertices.
    pub fn surely_hides_box(
        &mut self,
        view: &ViewVolume,
        bounds: &BoundingBox,
        origin: [i32; 2],
        test: DepthTest,
    ) -> bool {
        match view.project(bounds, test.source) {
            Some((pixels, depths)) => {
                let depths = within(outward(depths), [0.0, f32::INFINITY]);
                self.surely_hides_at(pixels, origin, depths, test.compare)
            }
            None => false,
        }
    }

    fn surely_hides_at(
        &mut self,
        pixels: PixelRect,
        origin: [i32; 2],
        depths: [f32; 2],
        compare: Compare,
    ) -> bool {
        let (width, height) = self.dimensions();
        let mine = PixelRect::new(origin[0], origin[1], width, height);
        let area = Area::new(pixels.intersect(mine), origin);
        area.is_none_or(|area| self.hides(area, depths, compare))
    }

    /// Does every pixel of the tile `place` with a depth within `depths` fail?
    #[inline(always)]
    pub(crate) fn tile_hides(
        &mut self,
        place: [u32; 2],
        depths: [f32; 2],
        compare: Compare,
    ) -> bool {
        let Some(tile) = self.bounds_mut().and_then(|bounds| bounds.tile_mut(place)) else {
            return false;
        };
        if compare.fails_all(depths, tile.depths) {
            return true;
        }
        tile.is_worth_a_look(depths, compare)
            // What has not been cleared says nothing.
            && !self.is_unclear([place[1] * SIDE, place[1] * SIDE + SIDE - 1])
            && self.look(place, depths, compare)
    }

    /// The same, by a look at all that is stored.
    #[inline(never)]
    fn look(&mut self, place: [u32; 2], depths: [f32; 2], compare: Compare) -> bool {
        let [x, y] = place.map(|c| c * SIDE);
        let (width, height) = self.dimensions();
        let columns = x as usize..width.min(x + SIDE) as usize;
        let (mut least, mut greatest) = ([f32::INFINITY; 16], [f32::NEG_INFINITY; 16]);
        for row in y..height.min(y + SIDE) {
            let lanes = &self.row(row)[columns.clone()];
            // Of 16 the compiler makes vectors.
            if let Ok(lanes) = <&[f32; 16]>::try_from(lanes) {
                take_in(lanes, &mut least, &mut greatest);
            } else {
                take_in(lanes, &mut least[..lanes.len()], &mut greatest[..lanes.len()]);
            }
        }
        let stored = [
            least.into_iter().fold(f32::INFINITY, lesser),
            greatest.into_iter().fold(f32::NEG_INFINITY, greater),
        ];
        let hides = compare.fails_all(depths, stored);
        if let Some(tile) = self.bounds_mut().and_then(|bounds| bounds.tile_mut(place)) {
            tile.looked(stored, hides);
        }
        hides
    }

    /// Might every pixel of `area` with a depth within `depths` fail? Quickly, and not surely.
    #[inline(always)]
    pub(crate) fn may_hide(&mut self, area: Area, depths: [f32; 2], compare: Compare) -> bool {
        let [[x, _], [y, _]] = area.tiles();
        let tile = self.bounds_mut().and_then(|bounds| bounds.tile_mut([x, y]));
        tile.is_some_and(|tile| tile.may_hide(depths, compare))
    }

    /// Does every pixel of `area` with a depth within `depths` fail?
    #[inline]
    pub(crate) fn hides(&mut self, area: Area, depths: [f32; 2], compare: Compare) -> bool {
        if !self.has_bounds() {
            return false;
        }
        let [columns, rows] = area.tiles();
        for y in rows[0]..rows[1] + 1 {
            for x in columns[0]..columns[1] + 1 {
                if !self.tile_hides([x, y], depths, compare) {
                    return false;
                }
            }
        }
        true
    }

    /// Does every pixel of `area` with a depth within `depths` fail (if it is asked whether it `hides`
    /// them)? If not, about `count` of them may be written, where some are.
    #[inline(always)]
    pub(crate) fn hides_or_takes(
        &mut self,
        area: Area,
        depths: [f32; 2],
        compare: Compare,
        hides: bool,
        count: Option<u64>,
    ) -> bool {
        let [[left, right], [top, bottom]] = area.tiles();
        // Of small polygons it is most often one, which hides nothing.
        if left == right
            && top == bottom
            && let Some(tile) = self.bounds_mut().and_then(|bounds| bounds.tile_mut([left, top]))
            && !(hides && tile.may_hide(depths, compare))
        {
            if let Some(count) = count {
                tile.widen(depths, compare, count);
            }
            return false;
        }
        if hides && self.may_hide(area, depths, compare) && self.hides(area, depths, compare) {
            return true;
        }
        if let (Some(bounds), Some(count)) = (self.bounds_mut(), count) {
            for y in top..bottom + 1 {
                for x in left..right + 1 {
                    bounds.widen([x, y], depths, compare, count);
                }
            }
        }
        false
    }
}

/// Pixels of a buffer: the first and the last column, the first and the last row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Area([[u32; 2]; 2]);

impl Area {
    /// Of `pixels` of the framebuffer, all of which lie in a buffer whose first one is at `origin`.
    #[inline(always)]
    pub(crate) fn new(pixels: PixelRect, origin: [i32; 2]) -> Option<Self> {
        let PixelRect { x0, y0, x1, y1 } = pixels;
        if pixels.is_empty() {
            return None;
        }
        let [x, y] = origin;
        let from = |c: i32, first: i32| c.wrapping_sub(first).cast_unsigned();
        Some(Self([[from(x0, x), from(x1 - 1, x)], [from(y0, y), from(y1 - 1, y)]]))
    }

    /// Is its first tile's part hidden, of `depth` or behind it?
    #[inline(always)]
    pub(crate) fn is_first_behind(self, occluders: &Occluders, depth: f32) -> bool {
        let [[left, _], [top, _]] = self.tiles();
        occluders.tile_hides([left, top], depth)
    }

    /// Is all of it hidden, of `depth` or behind it?
    pub(crate) fn is_behind(self, occluders: &Occluders, depth: f32) -> bool {
        let [[left, right], [top, bottom]] = self.tiles();
        occluders.all_hide(depth)
            || (top..bottom + 1)
                .all(|y| (left..right + 1).all(|x| occluders.tile_hides([x, y], depth)))
    }

    /// The tiles that they lie in, likewise.
    #[inline(always)]
    fn tiles(self) -> [[u32; 2]; 2] {
        let Self([[x0, x1], [y0, y1]]) = self;
        [[x0 / SIDE, x1 / SIDE], [y0 / SIDE, y1 / SIDE]]
    }
}

#[inline(always)]
fn take_in(lanes: &[f32], least: &mut [f32], greatest: &mut [f32]) {
    for ((depth, least), greatest) in lanes.iter().zip(least).zip(greatest) {
        (*least, *greatest) = (lesser(*least, *depth), greater(*greatest, *depth));
    }
}

/// The lesser of the two, or `a` if `b` is no number.
#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// The greater of the two, or `a` if `b` is no number.
#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}
