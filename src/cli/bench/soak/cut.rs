//! Which columns of a row a convex polygon covers that planes cut. What the clipper makes are
//! vertices in `f64`, snapped again: centres within [`tolerance`] of a side may go either way, all
//! others may not.

use std::ops::Range;

use hyperspan::space::Grid;

use super::super::reference::Reference;
use super::outline::Span;

/// What clipping and snapping may move a side by, in pixels.
pub(crate) fn tolerance(grid: Grid) -> f64 {
    match grid {
        Grid::Sixteen => 1.0 / 16384.0,
        Grid::Eight => 1.0 / 256.0,
    }
}

/// A side, in the pixels of a window: its distance is `here` at the first.
#[derive(Clone, Copy, Debug)]
struct Line {
    here: f64,
    steps: [f64; 2],
}

/// What is seen of a polygon.
#[derive(Clone, Debug)]
pub(crate) struct Cut {
    lines: Vec<Line>,
    first: [i32; 2],
    tolerance: f64,
}

/// The columns of a row that are surely covered, and those that may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Covered {
    pub(crate) surely: Span,
    pub(crate) perhaps: Span,
}

impl Cut {
    /// Near pixel `first`. Nothing if the polygon is not convex.
    pub(crate) fn new(reference: &Reference, first: [i32; 2], grid: Grid) -> Option<Self> {
        let line = |side| {
            let (here, steps) = reference.distance(side, first[0], first[1]);
            Line { here, steps }
        };
        let lines = reference.sides()?.into_iter().map(line).collect();
        Some(Self { lines, first, tolerance: tolerance(grid) })
    }

    /// In row `y`, of `columns`.
    pub(crate) fn row(&self, y: i32, columns: Range<i32>) -> Covered {
        let down = f64::from(y - self.first[1]);
        let span = |sign: f64| {
            // Columns from `first` on.
            let mut ends = [columns.start, columns.end].map(|x| f64::from(x - self.first[0]));
            for Line { here, steps: [right, below] } in &self.lines {
                let aside = sign * self.tolerance * (right.abs() + below.abs());
                // here + below down + right x >= aside
                let least = aside - (here + below * down);
                if *right > 0.0 {
                    ends[0] = ends[0].max((least / right).ceil());
                } else if *right < 0.0 {
                    ends[1] = ends[1].min((least / right).floor() + 1.0);
                } else if least > 0.0 {
                    ends[1] = ends[0];
                }
            }
            let [start, end] = ends.map(|x| x.clamp(-1e9, 1e9) as i32 + self.first[0]);
            if start < end { [start, end] } else { [columns.start; 2] }
        };
        Covered { surely: span(1.0), perhaps: span(-1.0) }
    }
}
