//! Boxes over runs of polygons, in the order in which they are drawn, and boxes over those.

use alloc::vec::Vec;
use core::ops::Range;

use super::{BoundingBox, Inclusion, ViewVolume};

/// Polygons of a run.
const RUN: usize = 32;

/// Boxes under a box.
const WIDTH: usize = 8;

/// Levels, at most: of more polygons than there can be.
const LEVELS: usize = 22;

/// Boxes over a list of polygons that do not move: one for each 32 that follow each other, and
/// one for each 8 of those, and so on. Made in one pass; about 1.7 bytes a polygon.
///
/// What is seen comes out as ranges of polygons, in their order, so that what is drawn is what
/// would be drawn of the whole list.
#[derive(Clone, Debug, Default)]
pub struct Hierarchy {
    count: usize,
    /// Level by level, from the runs' up to one box over all.
    boxes: Vec<BoundingBox>,
    /// Where each level begins.
    levels: Vec<usize>,
}

impl Hierarchy {
    /// Of `count` polygons; `add` adds the vertices of one to a box.
    pub fn new(count: usize, mut add: impl FnMut(usize, &mut BoundingBox)) -> Self {
        let mut boxes = Vec::with_capacity(count.div_ceil(RUN) * WIDTH / (WIDTH - 1) + LEVELS);
        for start in (0..count).step_by(RUN) {
            let mut bounds = BoundingBox::EMPTY;
            for polygon in start..count.min(start + RUN) {
                add(polygon, &mut bounds);
            }
            boxes.push(bounds);
        }
        let mut levels = Vec::with_capacity(LEVELS);
        levels.push(0);
        let mut start = 0;
        while boxes.len() - start > 1 {
            let end = boxes.len();
            for first in (start..end).step_by(WIDTH) {
                let mut bounds = BoundingBox::EMPTY;
                for below in &boxes[first..end.min(first + WIDTH)] {
                    bounds.join(below);
                }
                boxes.push(bounds);
            }
            levels.push(end);
            start = end;
        }
        Self { count, boxes, levels }
    }

    /// A box over all.
    pub fn bounds(&self) -> BoundingBox {
        self.boxes.last().copied().unwrap_or(BoundingBox::EMPTY)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.boxes.capacity() * size_of::<BoundingBox>()
            + self.levels.capacity() * size_of::<usize>()
    }

    /// The ranges of polygons that `view` may see, in their order; what is in none of them draws
    /// nothing.
    pub fn visible<'a>(&'a self, view: &'a ViewVolume) -> Walk<'a> {
        self.visible_of(view, 0..self.count)
    }

    /// The same of some polygons.
    pub fn visible_of<'a>(&'a self, view: &'a ViewVolume, polygons: Range<usize>) -> Walk<'a> {
        let end = polygons.end.min(self.count);
        let first = polygons.start.min(end);
        Walk { hierarchy: self, view, polygons: first..end, next: first / RUN, inside_to: 0 }
    }
}

/// Boxes over the polygons of a batch, and the view in which they are drawn: whole runs of them
/// that draw nothing are left out.
#[derive(Clone, Copy, Debug)]
pub struct Clusters<'a> {
    /// The boxes.
    pub hierarchy: &'a Hierarchy,
    /// What is seen: of the picture, or of a crop.
    pub view: &'a ViewVolume,
    /// Which of the hierarchy's polygons is the batch's first one.
    pub first: usize,
}

impl<'a> Clusters<'a> {
    /// Goes through what is seen of some polygons of the batch; the ranges are the hierarchy's.
    pub(crate) fn walk(&self, polygons: Range<usize>) -> Walk<'a> {
        let Self { hierarchy, view, first } = *self;
        let of_all = |i: usize| first.saturating_add(i);
        hierarchy.visible_of(view, of_all(polygons.start)..of_all(polygons.end))
    }
}

/// Goes through what is seen of a [`Hierarchy`].
#[derive(Clone, Debug)]
pub struct Walk<'a> {
    hierarchy: &'a Hierarchy,
    view: &'a ViewVolume,
    /// Those that are asked for.
    polygons: Range<usize>,
    /// The run to go on with.
    next: usize,
    /// Runs below this are known to lie inside.
    inside_to: usize,
}

impl Walk<'_> {
    /// The next run of 32 polygons, or what is left, of which something may be seen. Boxes for
    /// which `skips` says so are left out, with all the polygons that are under them, whose numbers
    /// it is told: it is asked just before, so that what has been drawn meanwhile hides what is to
    /// come.
    pub fn next_run(
        &mut self,
        mut skips: impl FnMut(&BoundingBox, Range<usize>) -> bool,
    ) -> Option<Range<usize>> {
        let Hierarchy { boxes, levels, .. } = self.hierarchy;
        let Range { start: first, end: last } = self.polygons;
        let runs = if first < last { last.div_ceil(RUN) } else { 0 };
        while self.next < runs {
            // From the highest box that begins here downward.
            let mut level = 0;
            let mut width = 1;
            while level + 1 < levels.len() && self.next.is_multiple_of(width * WIDTH) {
                (level, width) = (level + 1, width * WIDTH);
            }
            loop {
                let bounds = &boxes[levels[level] + self.next / width];
                let end = runs.min(self.next + width);
                let inside = end <= self.inside_to;
                let inclusion = if inside { Inclusion::Inside } else { self.view.include(bounds) };
                let polygons = (self.next * RUN).max(first)..last.min(end * RUN);
                if inclusion == Inclusion::Outside || skips(bounds, polygons.clone()) {
                    self.next = end;
                    break;
                }
                if inclusion == Inclusion::Inside {
                    self.inside_to = self.inside_to.max(end);
                }
                if level == 0 {
                    self.next += 1;
                    return Some(polygons);
                }
                (level, width) = (level - 1, width / WIDTH);
            }
        }
        None
    }
}

impl Iterator for Walk<'_> {
    type Item = Range<usize>;

    /// The next range: as many runs as follow each other.
    fn next(&mut self) -> Option<Range<usize>> {
        let mut range = self.next_run(|_, _| false)?;
        while let Some(more) = self.next_run(|_, _| false) {
            if more.start != range.end {
                // It begins the range to come.
                self.next = more.start / RUN;
                break;
            }
            range.end = more.end;
        }
        Some(range)
    }
}
