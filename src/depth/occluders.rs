//! What hides the tiles of a frame, known before anything is drawn.

use alloc::vec::Vec;

use super::{Compare, DepthTest, SIDE, TileRows};

/// For each tile of a depth buffer a bound of what its pixels hold once a list is drawn: a hair
/// behind the nearest of the polygons of the list that are known to fill it. What lies behind is
/// seen nowhere in the tile, whether it comes before that polygon or after it.
#[derive(Debug, Default)]
pub(crate) struct Occluders {
    /// Of the buffer, in pixels.
    size: (u32, u32),
    /// Tiles in a row of them.
    columns: usize,
    /// Greatest depths, or least ones if near depths are `raised`.
    bounds: Vec<f32>,
    raised: bool,
    /// How many tiles nothing fills so far; and once there is none, the farthest bound, or one
    /// behind it.
    unfilled: usize,
    farthest: Option<f32>,
    /// Bounds that have changed since that was found.
    changed: usize,
}

impl Occluders {
    /// Is there such a bound with this test? What is drawn must replace what is behind it.
    pub(crate) fn serve(test: DepthTest) -> bool {
        test.write && test.compare.lowers() != test.compare.raises()
    }

    /// Forgets all, for a buffer of this size and depths that are compared so.
    pub(crate) fn reset(&mut self, (width, height): (u32, u32), compare: Compare) {
        (self.size, self.raised) = ((width, height), compare.raises());
        self.columns = width.div_ceil(SIDE) as usize;
        self.bounds.clear();
        self.unfilled = self.columns * height.div_ceil(SIDE) as usize;
        self.bounds.resize(self.unfilled, self.unknown());
        (self.farthest, self.changed) = (None, 0);
    }

    /// (width, height) of the buffer, in pixels.
    pub(crate) fn size(&self) -> (u32, u32) {
        self.size
    }

    /// A depth that is nearer than any other.
    pub(crate) fn nearest(compare: Compare) -> f32 {
        if compare.raises() { f32::INFINITY } else { f32::NEG_INFINITY }
    }

    fn unknown(&self) -> f32 {
        if self.raised { f32::NEG_INFINITY } else { f32::INFINITY }
    }

    /// A polygon within `depths` fills the tile `place`. Did nothing, before?
    pub(crate) fn fill(&mut self, [x, y]: [u32; 2], depths: [f32; 2]) -> bool {
        let (raised, unknown) = (self.raised, self.unknown());
        let at = y as usize * self.columns + x as usize;
        let Some(bound) = self.bounds.get_mut(at) else { return false };
        // What is as deep as the polygon may be drawn in its stead.
        let behind = if raised { depths[0].next_down() } else { depths[1].next_up() };
        if !is_nearer(behind, *bound, raised) {
            return false;
        }
        let is_first = *bound == unknown;
        *bound = behind;
        self.changed += 1;
        self.unfilled -= usize::from(is_first);
        is_first
    }

    /// To be called once a polygon has filled its tiles.
    pub(crate) fn filled(&mut self) {
        // A look at all is worth it when as many have changed.
        if self.unfilled == 0 && self.changed >= self.bounds.len() {
            self.changed = 0;
            let raised = self.raised;
            let farther = |a: f32, b: f32| if is_nearer(a, b, raised) { b } else { a };
            self.farthest = self.bounds.iter().copied().reduce(farther);
        }
    }

    /// Do all tiles hide what has `depth` or is behind it?
    pub(crate) fn all_hide(&self, depth: f32) -> bool {
        self.farthest.is_some_and(|farthest| is_nearer(farthest, depth, self.raised))
    }

    /// Does the tile `place` hide what has `depth` or is behind it?
    #[inline(always)]
    pub(crate) fn tile_hides(&self, [x, y]: [u32; 2], depth: f32) -> bool {
        let bound = self.bounds.get(y as usize * self.columns + x as usize);
        bound.is_some_and(|bound| is_nearer(*bound, depth, self.raised))
    }

    /// Lowers the bounds of some rows of the buffer, the first of which is row `row` of tiles, to
    /// what is known here.
    pub(crate) fn limit(&self, row: u32, rows: &mut TileRows<'_>) {
        let known = self.bounds.get(row as usize * self.columns..).unwrap_or_default();
        let far = usize::from(!self.raised);
        for (tile, bound) in rows.tiles_mut().iter_mut().zip(known) {
            if is_nearer(*bound, tile.depths[far], self.raised) {
                tile.depths[far] = *bound;
            }
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.bounds.capacity() * size_of::<f32>()
    }
}

/// Is `a` nearer than `b`, where near depths are `raised`, or not?
#[inline(always)]
fn is_nearer(a: f32, b: f32, raised: bool) -> bool {
    if raised { a > b } else { a < b }
}
