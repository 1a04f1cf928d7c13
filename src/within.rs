//! Where along a row no value has to be clamped: between two columns, since numerator and denominator are
//! linear. docs/precision.md, "What need not be clamped", has why the margin is enough.

use crate::along::OnRow;

/// Of an attribute's magnitude: some ten times what a lane may be off, and a million times what `f64` may
/// be where blocks are good enough.
const MARGIN: f64 = 1.0 / 1_048_576.0;

/// Values that lie between the ends of `range` by more than any error.
#[inline(always)]
pub(crate) fn inner_range([low, high]: [f32; 2]) -> [f64; 2] {
    let margin = MARGIN * f64::from(if -low > high { -low } else { high });
    [f64::from(low) + margin, f64::from(high) - margin]
}

/// Columns of a row, as offsets from the anchor: the first and the last, which may be beyond any.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Columns {
    first: f64,
    last: f64,
}

impl Columns {
    pub(crate) const ALL: Self = Self { first: f64::NEG_INFINITY, last: f64::INFINITY };
    pub(crate) const NONE: Self = Self { first: f64::INFINITY, last: f64::NEG_INFINITY };

    /// Are the columns from `first` to `last` among them?
    #[inline(always)]
    pub(crate) fn contain(self, first: f64, last: f64) -> bool {
        self.first <= first && last <= self.last
    }

    /// Those of them where N/Q lies in `inner`, if Q is positive.
    #[inline(always)]
    #[must_use]
    pub(crate) fn where_within(self, n: OnRow, q: OnRow, [least, greatest]: [f64; 2]) -> Self {
        let above = OnRow { start: n.start - least * q.start, step: n.step - least * q.step };
        let below = OnRow { start: greatest * q.start - n.start, step: greatest * q.step - n.step };
        self.where_not_negative(above).where_not_negative(below)
    }

    #[inline(always)]
    fn where_not_negative(self, OnRow { start, step }: OnRow) -> Self {
        let Self { mut first, mut last } = self;
        let zero = -start / step;
        if step > 0.0 {
            first = if zero > first { zero } else { first };
        } else if step < 0.0 {
            last = if zero < last { zero } else { last };
        } else if start < 0.0 {
            last = f64::NEG_INFINITY;
        }
        Self { first, last }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_end_where_a_value_leaves_its_range() {
        let one = OnRow { start: 1.0, step: 0.0 };
        let rising = OnRow { start: 1.0, step: 0.5 };
        let columns = Columns::ALL.where_within(rising, one, [-1.0, 3.0]);
        assert!(columns.contain(-4.0, 4.0));
        assert!(!columns.contain(-4.5, 0.0) && !columns.contain(0.0, 4.5));
        // N/Q = 2 - 1/Q, where Q is 1 + u/4.
        let q = OnRow { start: 1.0, step: 0.25 };
        let n = OnRow { start: 1.0, step: 0.5 };
        let columns = columns.where_within(n, q, [0.0, 1.5]);
        assert!(columns.contain(-2.0, 4.0) && !columns.contain(-2.25, 0.0));
        // The same all over, in the range or not.
        let constant = OnRow { start: 2.0, step: 0.0 };
        assert!(columns.where_within(constant, one, [1.0, 2.0]).contain(-2.0, 4.0));
        assert!(!columns.where_within(constant, one, [0.0, 1.0]).contain(0.0, 0.0));
        assert!(!Columns::NONE.contain(0.0, 0.0));
    }

    #[test]
    fn inner_ranges_lie_within() {
        let [least, greatest] = inner_range([-2.0, 1.0]);
        assert!(-2.0 < least && least < -1.999 && 0.999 < greatest && greatest < 1.0);
        let [least, greatest] = inner_range([5.0, 5.0]);
        assert!(least > greatest);
    }
}
