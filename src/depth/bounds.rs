//! Bounds of the depths that are stored, by tiles of 16 x 16 pixels.
//!
//! A tile keeps a least and a greatest depth. They are always true and not always tight: what is
//! written widens them at once, and they are looked up again in the buffer only when that may
//! hide something. A tile that a polygon fills whole gets that polygon's bounds, and nothing is
//! looked up at all.
//!
//! A stored NaN counts for nothing: no compare function that can be skipped lets a pixel pass
//! against it.

use alloc::vec::Vec;

use super::{Compare, Unclear};

/// The side of a tile, in pixels.
pub(crate) const SIDE: u32 = 16;

/// So many pixels must have been written to a tile for its depths to be worth another look: as
/// many as it has. After a look that hid nothing, twice as many as before.
const WORTH_A_LOOK: u32 = SIDE * SIDE;

/// Bounds that say nothing.
const ANYTHING: [f32; 2] = [f32::NEG_INFINITY, f32::INFINITY];

/// A least and a greatest depth for each tile of a depth buffer: 16 bytes for 1 KiB of it. With
/// them polygons, and parts of them, that are hidden are left out before they are set up
/// ([`DepthBuffer::with_bounds`](crate::target::Plane::with_bounds)); no byte that is drawn depends on it.
///
/// Keep them from one draw call to the next, as long as the depth buffer itself.
#[derive(Clone, Debug, Default)]
pub struct DepthBounds {
    width: u32,
    height: u32,
    tiles: Vec<Tile>,
    /// For each row, where it has not been cleared yet: see [`Unclear`].
    unclear: Vec<[u32; 2]>,
}

/// The bounds of a depth buffer, or of some of its rows.
#[derive(Debug)]
pub(crate) struct TileRows<'a> {
    /// Tiles in a row of them.
    columns: usize,
    tiles: &'a mut [Tile],
    pub(crate) unclear: Unclear<'a>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    /// No stored depth that is a number is below the first or above the second, or none will be once
    /// the list is drawn that is being drawn ([`Occluders`](super::Occluders)).
    pub(crate) depths: [f32; 2],
    /// So many pixels, or about as many, are to be written before another look at them.
    wait: u32,
    /// The same when they were looked at last.
    patience: u32,
}

impl Tile {
    /// Just cleared: until something is drawn, nothing is hidden.
    const CLEARED: Self = Self { depths: ANYTHING, wait: WORTH_A_LOOK, patience: WORTH_A_LOOK };
    /// Nothing is known.
    const UNKNOWN: Self = Self { wait: 0, ..Self::CLEARED };

    /// Might all of `depths` fail, as far as is known or a look might tell?
    #[inline(always)]
    pub(crate) fn may_hide(&self, depths: [f32; 2], compare: Compare) -> bool {
        compare.fails_all(depths, self.depths) || self.is_worth_a_look(depths, compare)
    }

    /// Is a look worth it, if it might tell that all of `depths` fail?
    #[inline(always)]
    pub(crate) fn is_worth_a_look(&self, depths: [f32; 2], compare: Compare) -> bool {
        self.wait == 0 && compare.may_fail_all(depths, self.depths)
    }

    /// About `count` pixels may have been written, with `depths` that passed `compare`.
    #[inline(always)]
    pub(crate) fn widen(&mut self, depths: [f32; 2], compare: Compare, count: u64) {
        // What passed against a stored depth may be bounded by that.
        if compare.lowers() && depths[0] < self.depths[0] {
            self.depths[0] = depths[0];
        }
        if compare.raises() && depths[1] > self.depths[1] {
            self.depths[1] = depths[1];
        }
        self.wait = self.wait.saturating_sub(u32::try_from(count).unwrap_or(u32::MAX));
    }

    /// They were looked at: whether that `hid` what was asked for.
    #[inline(always)]
    pub(crate) fn looked(&mut self, depths: [f32; 2], hid: bool) {
        let patience = if hid { WORTH_A_LOOK } else { self.patience.saturating_mul(2) };
        // What is known of the end may be nearer than what is stored.
        let [least, greatest] = self.depths;
        let least = if depths[0] > least { depths[0] } else { least };
        let greatest = if depths[1] < greatest { depths[1] } else { greatest };
        *self = Self { depths: [least, greatest], wait: patience, patience };
    }
}

impl DepthBounds {
    /// For a depth buffer of any size: they take it when they are attached.
    pub fn new() -> Self {
        Self::default()
    }

    /// Says that the depths may have changed while the bounds were not attached to them. Depths
    /// that are cleared or written through the buffer that they are attached to need no saying.
    pub fn forget(&mut self) {
        self.tiles.fill(Tile::UNKNOWN);
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.tiles.capacity() * size_of::<Tile>() + self.unclear.capacity() * size_of::<[u32; 2]>()
    }

    /// For a buffer of this size; of any other they know nothing.
    pub(crate) fn attach(&mut self, width: u32, height: u32) -> TileRows<'_> {
        let columns = width.div_ceil(SIDE) as usize;
        if (self.width, self.height) != (width, height) {
            (self.width, self.height) = (width, height);
            self.tiles.clear();
            self.tiles.resize(columns * height.div_ceil(SIDE) as usize, Tile::UNKNOWN);
            self.unclear.clear();
            self.unclear.resize(height as usize, [0; 2]);
        }
        let unclear = Unclear::nothing(&mut self.unclear);
        TileRows { columns, tiles: &mut self.tiles, unclear }
    }

    /// Says that all depths have been cleared to one value, while the bounds were not attached.
    pub fn clear(&mut self) {
        self.tiles.fill(Tile::CLEARED);
    }
}

impl<'a> TileRows<'a> {
    /// The same, borrowed for a while.
    pub(crate) fn reborrow(&mut self) -> TileRows<'_> {
        let unclear = self.unclear.reborrow();
        TileRows { columns: self.columns, tiles: self.tiles, unclear }
    }

    /// The bounds of the rows above `row` and of the others, of `height` in all; nothing if it cuts
    /// tiles: then nothing is known of any, from now on.
    pub(crate) fn split_at_row(self, row: u32, height: u32) -> Option<(Self, Self)> {
        let Self { columns, tiles, unclear } = self;
        let at = (row.div_ceil(SIDE) as usize).saturating_mul(columns).min(tiles.len());
        if !row.is_multiple_of(SIDE) && row < height {
            tiles.fill(Tile::UNKNOWN);
            return None;
        }
        let (above, below) = tiles.split_at_mut(at);
        let (unclear, unclear_below) = unclear.split_at_row(row);
        Some((
            Self { columns, tiles: above, unclear },
            Self { columns, tiles: below, unclear: unclear_below },
        ))
    }

    /// All depths are the same now.
    pub(crate) fn clear(&mut self) {
        self.tiles.fill(Tile::CLEARED);
        self.unclear.forget();
    }

    /// The depths of row `y` may have changed.
    pub(crate) fn forget_row(&mut self, y: u32) {
        let (row, columns) = ((y / SIDE) as usize, self.columns);
        if let Some(tiles) = self.tiles.get_mut(row * columns..(row + 1) * columns) {
            tiles.fill(Tile::UNKNOWN);
        }
    }

    /// What is known of the tile `place`.
    #[inline(always)]
    pub(crate) fn tile_mut(&mut self, [x, y]: [u32; 2]) -> Option<&mut Tile> {
        self.tiles.get_mut(y as usize * self.columns + x as usize)
    }

    /// The tile `place` holds depths within `depths` and nothing else, all of which passed
    /// `compare`.
    pub(crate) fn fill(&mut self, place: [u32; 2], depths: [f32; 2], compare: Compare) {
        let Some(tile) = self.tile_mut(place) else { return };
        let ([mut least, mut greatest], old) = (depths, tile.depths);
        if !compare.lowers() && old[0] > least {
            least = old[0];
        }
        if !compare.raises() && old[1] < greatest {
            greatest = old[1];
        }
        *tile = Tile { depths: [least, greatest], ..Tile::CLEARED };
    }

    /// All tiles, row after row.
    pub(crate) fn tiles_mut(&mut self) -> &mut [Tile] {
        self.tiles
    }

    /// About `count` pixels of the tile `place` may have been written, with `depths` that passed
    /// `compare`.
    #[inline(always)]
    pub(crate) fn widen(
        &mut self,
        place: [u32; 2],
        depths: [f32; 2],
        compare: Compare,
        count: u64,
    ) {
        if let Some(tile) = self.tile_mut(place) {
            tile.widen(depths, compare, count);
        }
    }
}
