//! Which of a model's positions a view needs: those of pieces that it does not see are not
//! transformed.

use std::ops::Range;

use hyperspan::cull::{Hierarchy, ViewVolume};

use crate::model::Model;

/// Pieces that are looked at together.
const STEP: usize = 32;

/// The positions of runs of pieces, from the first to the last: few, where a file lists positions
/// next to the faces that have them.
#[derive(Debug)]
pub(crate) struct Needed {
    runs: Vec<Range<u32>>,
    /// Those of a view, in their order; kept from frame to frame.
    ranges: Vec<Range<u32>>,
}

impl Needed {
    /// Of all pieces of `model`.
    pub(crate) fn new(model: &Model) -> Self {
        let runs = model.pieces.chunks(STEP).map(|pieces| {
            let corners = pieces.iter().flat_map(|piece| piece.corners());
            join(corners.map(|corner| {
                let position = model.corners.position[corner];
                position..position + 1
            }))
        });
        Self { runs: runs.collect(), ranges: Vec::new() }
    }

    /// The positions that `view` needs, as ranges that do not overlap.
    pub(crate) fn of<'a>(
        &'a mut self,
        hierarchy: &Hierarchy,
        view: &ViewVolume,
    ) -> impl Iterator<Item = Range<usize>> + 'a {
        let Self { runs, ranges } = self;
        ranges.clear();
        for seen in hierarchy.visible(view) {
            let runs = runs.get(seen.start / STEP..seen.end.div_ceil(STEP)).unwrap_or_default();
            ranges.push(join(runs.iter().cloned()));
        }
        ranges.sort_unstable_by_key(|range| range.start);
        let mut done = 0;
        ranges.iter().map(move |range| {
            let start = range.start.max(done);
            done = done.max(range.end);
            start as usize..range.end.max(start) as usize
        })
    }
}

/// From the first of all to the last.
fn join(ranges: impl Iterator<Item = Range<u32>>) -> Range<u32> {
    ranges.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_joined_from_the_first_to_the_last() {
        assert_eq!(join([5..7, 2..3, 6..9].into_iter()), 2..9);
        assert_eq!(join([].into_iter()), 0..0);
    }
}
