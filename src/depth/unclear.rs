//! Where a canvas has not been cleared yet.
//!
//! What a polygon covers need not be cleared before, if all of it passes against what it would be cleared to.
//! So a clear can be put off until something is drawn: what lies in a row beside the polygon is cleared then,
//! or left for the next one. Of each row one piece can be left, the rest of it is clear.

/// The pieces of some rows that have not been cleared, of depths and colours alike.
#[derive(Debug)]
pub(crate) struct Unclear<'a> {
    /// For each row the first column and the one after the last.
    rows: &'a mut [[u32; 2]],
    /// What depths are to be cleared to.
    depth: f32,
    /// In the rows from the first to before the second nothing is left.
    clear: [u32; 2],
    /// How many pixels were drawn that had not been cleared.
    drawn: u64,
}

impl<'a> Unclear<'a> {
    /// All is clear; `rows` may hold anything.
    pub(super) fn nothing(rows: &'a mut [[u32; 2]]) -> Self {
        Self { rows, depth: 0.0, clear: [0, u32::MAX], drawn: 0 }
    }

    /// All is clear.
    pub(super) fn forget(&mut self) {
        self.clear = [0, u32::MAX];
    }

    /// The same, borrowed for a while.
    pub(super) fn reborrow(&mut self) -> Unclear<'_> {
        Unclear { rows: self.rows, drawn: 0, ..*self }
    }

    /// Those above `row` and the others.
    pub(super) fn split_at_row(self, row: u32) -> (Self, Self) {
        let Self { rows, depth, clear, drawn } = self;
        let (above, below) = rows.split_at_mut((row as usize).min(rows.len()));
        // What else is clear is seen in the rows.
        let clear = if clear == [0, u32::MAX] { clear } else { [0, 0] };
        (Self { rows: above, depth, clear, drawn }, Self { rows: below, depth, clear, drawn: 0 })
    }

    /// Nothing has been cleared: `width` columns of every row are to be, their depths to `depth`.
    pub(crate) fn put_off(&mut self, width: u32, depth: f32) {
        self.rows.fill([0, width]);
        (self.depth, self.clear) = (depth, [0, 0]);
    }

    /// What depths are to be cleared to.
    pub(crate) fn depth(&self) -> f32 {
        self.depth
    }

    /// Is anything left to be cleared from row `first` to row `last`, as far as is known at a glance?
    #[inline(always)]
    pub(crate) fn may_reach(&self, [first, last]: [u32; 2]) -> bool {
        first < self.clear[0] || last >= self.clear[1]
    }

    /// Is anything left to be cleared in any of these rows?
    pub(crate) fn reaches(&self, [first, last]: [u32; 2]) -> bool {
        let rows = self.rows.get(first as usize..=last as usize).unwrap_or(self.rows);
        self.may_reach([first, last]) && rows.iter().any(|[start, end]| start < end)
    }

    /// Takes all that is left in the rows from `first` to `last`, and in those between them and others that
    /// are known to be clear: `clear` is called with each row and its columns.
    pub(crate) fn take_rows(
        &mut self,
        [first, last]: [u32; 2],
        mut clear: impl FnMut(u32, [u32; 2]),
    ) {
        let end = u32::try_from(self.rows.len()).unwrap_or(u32::MAX);
        let wanted = [first.min(end), last.saturating_add(1).min(end)];
        let known = if self.clear[0] < self.clear[1] { self.clear } else { [wanted[0]; 2] };
        self.clear = [known[0].min(wanted[0]), known[1].max(wanted[1])];
        for y in (self.clear[0]..known[0]).chain(known[1]..self.clear[1]) {
            self.take_row(y, |columns| clear(y, columns));
        }
    }

    /// Takes all that is left of row `y`.
    pub(crate) fn take_row(&mut self, y: u32, clear: impl FnOnce([u32; 2])) {
        let left = self.rows.get_mut(y as usize).map(core::mem::take).unwrap_or_default();
        if left[0] < left[1] {
            clear(left);
        }
    }

    /// Takes the columns from `start` to before `end` of row `y`: they are drawn now. True if none of them has
    /// been cleared; else `clear` is called with those that have not. It is called too with what is not left for
    /// others.
    pub(crate) fn take(
        &mut self,
        y: u32,
        [start, end]: [u32; 2],
        mut clear: impl FnMut([u32; 2]),
    ) -> bool {
        let Some(row) = self.rows.get_mut(y as usize) else { return false };
        let [first, last] = *row;
        if end <= first || start >= last {
            return false;
        }
        let is_all = first <= start && end <= last;
        if is_all {
            self.drawn += u64::from(end - start);
        } else {
            clear([start.max(first), end.min(last)]);
        }
        let (before, after) = ([first, start.max(first)], [end.min(last), last]);
        let length = |piece: [u32; 2]| piece[1] - piece[0];
        let (rest, others) =
            if length(before) > length(after) { (before, after) } else { (after, before) };
        if length(others) > 0 {
            clear(others);
        }
        *row = rest;
        is_all
    }

    /// How many pixels were drawn that had not been cleared, since the last time.
    pub(crate) fn take_drawn(&mut self) -> u64 {
        core::mem::take(&mut self.drawn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns of a row are drawn or cleared, once.
    #[test]
    fn unclear_columns_are_drawn_or_cleared_once() {
        let mut state = 7_u32;
        let mut random = |end: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) % end
        };
        for _ in 0..2000 {
            let mut rows = [[0; 2]; 3];
            let mut unclear = Unclear::nothing(&mut rows);
            assert!(!unclear.may_reach([0, 2]) && !unclear.reaches([0, 2]));
            unclear.put_off(20, 1.0);
            assert!(unclear.may_reach([1, 1]) && unclear.reaches([0, 2]));
            let (mut touched, mut drawn) = ([[0_u32; 20]; 3], 0);
            for _ in 0..random(6) {
                let (y, a, b) = (random(3), random(20), random(20));
                let span = [a.min(b), a.max(b) + 1];
                let mut cleared = [false; 20];
                let is_all = unclear.take(y, span, |[start, end]| {
                    (start..end).for_each(|x| cleared[x as usize] = true);
                });
                let columns = &mut touched[y as usize];
                for x in span[0]..span[1] {
                    assert!(!is_all || columns[x as usize] == 0, "a column that is not clear");
                    assert!(is_all || columns[x as usize] > 0 || cleared[x as usize]);
                    columns[x as usize] += u32::from(is_all);
                }
                drawn += if is_all { u64::from(span[1] - span[0]) } else { 0 };
                for (column, cleared) in columns.iter_mut().zip(cleared) {
                    *column += u32::from(cleared);
                }
            }
            assert_eq!((unclear.take_drawn(), unclear.take_drawn()), (drawn, 0));
            let first = random(3);
            let mut take = |unclear: &mut Unclear<'_>, rows| {
                unclear.take_rows(rows, |y, [start, end]| {
                    (start..end).for_each(|x| touched[y as usize][x as usize] += 1);
                });
                assert!(!unclear.may_reach(rows) && !unclear.reaches(rows));
            };
            take(&mut unclear, [first, first]);
            take(&mut unclear, [0, 2]);
            assert_eq!(touched, [[1; 20]; 3], "all, once");
        }
    }
}
