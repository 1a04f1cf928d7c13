//! Counts of what was drawn and what was skipped.

use crate::gradient::ConstantAlong;

/// What became of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// It went to the spans (and may still cover no pixel centre).
    Drawn,
    /// Nothing of it lies in the view volume.
    Outside,
    /// It faces the way that is left out.
    Backface,
    /// Fewer than three vertices, or no area once snapped.
    Degenerate,
    /// A position is not finite; or the thread's arithmetic takes subnormal numbers for 0 (FTZ, DAZ),
    /// so that bits would differ.
    Refused,
    /// All of it lies behind what was drawn before, as the depth buffer's bounds show.
    Hidden,
}

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
    /// All of it lies behind what was drawn before, as the depth buffer's bounds show. Its pixels
    /// are not counted: most often nobody has found out which they are.
    pub hidden: u64,
}

impl Culled {
    /// Where a polygon counts that comes to `outcome`, unless it is drawn.
    #[inline(always)]
    fn of(&mut self, outcome: Outcome) -> Option<&mut u64> {
        match outcome {
            Outcome::Drawn => None,
            Outcome::Outside => Some(&mut self.outside),
            Outcome::Backface => Some(&mut self.backface),
            Outcome::Degenerate => Some(&mut self.degenerate),
            Outcome::Refused => Some(&mut self.refused),
            Outcome::Hidden => Some(&mut self.hidden),
        }
    }
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
    /// Pixels that were drawn and had never been cleared, since they pass against anything cleared (see
    /// [`Canvas::clear_later`](crate::draw::Canvas::clear_later)).
    pub pixels_not_cleared: u64,
    /// Values for which `f64` could not tell the correctly rounded `f32`, so that exact
    /// arithmetic did. Which they are depends on the way that a polygon is drawn, and so, in
    /// `Exact`, on whether those beside it in a list have as many attributes.
    pub exact_values: u64,
    /// The most bytes that the tiler's own buffers held; they never shrink.
    pub peak_bytes: u64,
}

impl Stats {
    /// One more polygon, which came to `outcome`.
    #[inline(always)]
    pub(crate) fn count(&mut self, outcome: Outcome) {
        self.polygons += 1;
        if let Some(count) = self.culled.of(outcome) {
            *count += 1;
        }
    }

    /// Adds the counts of `other`, and its bytes.
    pub(crate) fn add(&mut self, other: &Self) {
        self.polygons += other.polygons;
        self.culled.outside += other.culled.outside;
        self.culled.backface += other.culled.backface;
        self.culled.degenerate += other.culled.degenerate;
        self.culled.refused += other.culled.refused;
        self.culled.hidden += other.culled.hidden;
        self.clipped += other.clipped;
        self.constant_w.polygon += other.constant_w.polygon;
        self.constant_w.row += other.constant_w.row;
        self.constant_w.column += other.constant_w.column;
        self.spans += other.spans;
        self.pixels_covered += other.pixels_covered;
        self.pixels_shaded += other.pixels_shaded;
        self.pixels_hidden += other.pixels_hidden;
        self.pixels_not_cleared += other.pixels_not_cleared;
        self.exact_values += other.exact_values;
        self.peak_bytes += other.peak_bytes;
    }
}

/// Counts polygons, and the parts of a face as one.
#[derive(Debug)]
pub(crate) struct FaceCount {
    /// What became of the face so far.
    outcome: Outcome,
    /// What drawing had counted before the face, and up to now.
    before: (u64, ConstantW),
    now: (u64, ConstantW),
}

impl FaceCount {
    /// To go on from what is counted.
    pub(crate) fn new(stats: &Stats) -> Self {
        let now = (stats.clipped, stats.constant_w);
        Self { outcome: Outcome::Drawn, before: now, now }
    }

    /// A polygon came to `outcome`, which is a part of the face before it if it `continues` that.
    #[inline(always)]
    pub(crate) fn count(&mut self, stats: &mut Stats, outcome: Outcome, continues: bool) {
        if continues {
            self.count_part(stats, outcome);
        } else {
            stats.count(outcome);
            (self.outcome, self.before) = (outcome, self.now);
        }
        self.now = (stats.clipped, stats.constant_w);
    }

    /// A face counts as drawn if any part of it is, else as its first part does; what happened to
    /// any part happened to it once.
    fn count_part(&mut self, stats: &mut Stats, outcome: Outcome) {
        if self.outcome != Outcome::Drawn && outcome == Outcome::Drawn {
            if let Some(count) = stats.culled.of(self.outcome) {
                *count -= 1;
            }
            self.outcome = outcome;
        }
        let (clipped, w) = self.before;
        let once = |now: &mut u64, before: u64| *now = before + (*now - before).min(1);
        once(&mut stats.clipped, clipped);
        once(&mut stats.constant_w.polygon, w.polygon);
        once(&mut stats.constant_w.row, w.row);
        once(&mut stats.constant_w.column, w.column);
    }
}
