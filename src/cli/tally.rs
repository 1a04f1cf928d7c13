//! Counts by face: the tiler counts polygons, and a face that is not convex, flat or affine is
//! drawn as several.

use hyperspan::stats::Stats;
use hyperspan::tiler::Tiler;

use crate::model::Piece;

/// Finds out what was counted more than once.
#[derive(Debug, Default)]
pub(crate) struct FaceTally {
    open: Option<OpenFace>,
    /// What was counted too often.
    surplus: Stats,
}

/// A face of several pieces that is being drawn.
#[derive(Debug)]
struct OpenFace {
    face: u32,
    /// Counts before its first piece.
    before: Stats,
    /// And after it.
    first: Option<Stats>,
}

impl FaceTally {
    /// Piece `i` is going to be drawn.
    #[inline]
    pub(crate) fn before(&mut self, tiler: &Tiler, pieces: &[Piece], i: usize) {
        let face = pieces[i].face;
        match &mut self.open {
            Some(open) if open.face == face => {
                open.first.get_or_insert_with(|| tiler.stats());
                return;
            }
            Some(_) => self.close(tiler),
            None => {}
        }
        if pieces.get(i + 1).is_some_and(|next| next.face == face) {
            self.open = Some(OpenFace { face, before: tiler.stats(), first: None });
        }
    }

    /// The open face has been drawn.
    fn close(&mut self, tiler: &Tiler) {
        let Some(OpenFace { before, first: Some(first), .. }) = self.open.take() else { return };
        let after = tiler.stats();
        let surplus = &mut self.surplus;
        surplus.polygons += after.polygons - before.polygons - 1;
        let once = |more: u64| more - more.min(1);
        surplus.clipped += once(after.clipped - before.clipped);
        let (w, before_w) = (after.constant_w, before.constant_w);
        surplus.constant_w.polygon += once(w.polygon - before_w.polygon);
        surplus.constant_w.row += once(w.row - before_w.row);
        surplus.constant_w.column += once(w.column - before_w.column);

        // It counts as drawn if any of it was, else as its first piece does.
        let sum = |stats: &Stats| {
            let culled = stats.culled;
            culled.outside + culled.backface + culled.degenerate + culled.refused + culled.hidden
        };
        let drawn = sum(&after) - sum(&before) < after.polygons - before.polygons;
        let from = if drawn { before.culled } else { first.culled };
        let (culled, after) = (&mut surplus.culled, after.culled);
        culled.outside += after.outside - from.outside;
        culled.backface += after.backface - from.backface;
        culled.degenerate += after.degenerate - from.degenerate;
        culled.refused += after.refused - from.refused;
        culled.hidden += after.hidden - from.hidden;
    }

    /// The counts of all that was drawn, by face.
    pub(crate) fn settle(mut self, tiler: &Tiler) -> Stats {
        self.close(tiler);
        let mut stats = tiler.stats();
        let surplus = self.surplus;
        stats.polygons -= surplus.polygons;
        stats.clipped -= surplus.clipped;
        stats.constant_w.polygon -= surplus.constant_w.polygon;
        stats.constant_w.row -= surplus.constant_w.row;
        stats.constant_w.column -= surplus.constant_w.column;
        stats.culled.outside -= surplus.culled.outside;
        stats.culled.backface -= surplus.culled.backface;
        stats.culled.degenerate -= surplus.culled.degenerate;
        stats.culled.refused -= surplus.culled.refused;
        stats.culled.hidden -= surplus.culled.hidden;
        stats
    }
}
