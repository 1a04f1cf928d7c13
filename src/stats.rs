//! Counts of what was drawn and what was skipped.

use crate::gradient::ConstantAlong;

/// Polygons that were not drawn, by the first reason found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Culled {
    /// Nothing of it lies in the view volume.
    pub outside: u64,
    /// It faces the other way; see [`Cull`](crate::tiler::Cull).
    pub backface: u64,
    /// Fewer than three vertices, or no area once snapped.
    pub degenerate: u64,
    /// A position is not finite.
    pub refused: u64,
    /// All of it lies behind what was drawn before.
    pub hidden: u64,
}

/// Polygons on which 1/w was found constant; one that counts as `polygon` is in no other row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ConstantW {
    /// All over.
    pub polygon: u64,
    /// Along rows: floors and ceilings seen without roll.
    pub row: u64,
    /// Along columns: walls seen without pitch.
    pub column: u64,
}

impl ConstantW {
    /// One more polygon.
    #[inline(always)]
    pub(crate) fn count(&mut self, along: ConstantAlong) {
        match along {
            ConstantAlong::Nothing => {}
            ConstantAlong::Polygon => self.polygon += 1,
            ConstantAlong::Row => self.row += 1,
            ConstantAlong::Column => self.column += 1,
        }
    }
}

/// What a tiler did since it was made or since the last
/// [`Tiler::reset_stats`](crate::tiler::Tiler::reset_stats). Counts may differ with crop and
/// with skips, pictures do not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Polygons submitted.
    pub polygons: u64,
    /// Of them, those that were not drawn.
    pub culled: Culled,
    /// Polygons that crossed a plane and were clipped.
    pub clipped: u64,
    /// Polygons with a constant 1/w.
    pub constant_w: ConstantW,
    /// Spans walked.
    pub spans: u64,
    /// Pixels scan-converted, over all polygons: shaded and hidden.
    pub pixels_covered: u64,
    /// Pixels that passed the depth test and went to the shader.
    pub pixels_shaded: u64,
    /// Pixels that failed the depth test.
    pub pixels_hidden: u64,
    /// Values for which `f64` could not tell the correctly rounded `f32`, so that exact
    /// arithmetic did.
    pub exact_values: u64,
    /// The most bytes that the tiler's own buffers held; they never shrink.
    pub peak_bytes: u64,
}
