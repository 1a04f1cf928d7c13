//! Fixed point: the subpixel grid, and powers of two. Every shift lives here.

use crate::space::Grid;

/// A coordinate in pixels from the viewport's upper left corner, snapped: 16 fraction bits.
/// With the n.8 grid the lower 8 of them are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Subpixel(i32);

impl Subpixel {
    /// Fraction bits.
    pub const FRACTION_BITS: u32 = 16;
    /// Half a pixel: where the centre of pixel 0 lies.
    const HALF: i32 = 1 << (Self::FRACTION_BITS - 1);
    /// How far the grid reaches from the viewport's corner to either side, in whole pixels.
    /// A pixel less than `i32` allows, so that a vertex on the guard band may round outward.
    pub const REACH: i32 = 32767;

    /// Snaps a framebuffer coordinate (pixels), round to nearest even, where the viewport's
    /// corner is at `corner`. What lies beyond the grid's reach (a hair, behind the guard
    /// band) goes to its end; NaN to 0.
    #[inline(always)]
    pub fn snap(framebuffer: f64, corner: i32, grid: Grid) -> Self {
        let steps = grid.steps_per_pixel();
        let whole = round_to_even(framebuffer * f64::from(steps));
        let step = i64::from((1_u32 << Self::FRACTION_BITS) / steps);
        let limit = i64::from(Self::REACH) << Self::FRACTION_BITS;
        let offset =
            whole.saturating_mul(step).saturating_sub(i64::from(corner) << Self::FRACTION_BITS);
        Self(i32::try_from(offset.clamp(-limit, limit)).unwrap_or(0))
    }

    /// The coordinate with 16 fraction bits.
    pub fn bits(self) -> i32 {
        self.0
    }

    /// The coordinate with 16 fraction bits, to compute with.
    pub(crate) fn wide(self) -> i64 {
        i64::from(self.0)
    }

    /// The first row (or column) whose centre is at or beyond this: ceil(c - 1/2).
    ///
    /// ```text
    ///     row 0       row 1        c in (-1/2, 1/2] -> 0, c in (1/2, 3/2] -> 1:
    ///  |----o----|----o----|       an edge from y0 to y1 owns the rows
    ///  0   1/2   1   3/2   2       first_centre(y0) .. first_centre(y1)
    /// ```
    #[inline(always)]
    pub fn first_centre(self) -> i32 {
        Self::first_centre_of(self.0)
    }

    /// The same of the bits of a coordinate.
    #[inline(always)]
    pub(crate) fn first_centre_of(bits: i32) -> i32 {
        // Without overflow: the reach leaves a pixel.
        (bits + (Self::HALF - 1)) >> Self::FRACTION_BITS
    }

    /// The centre of a row (or column), with 16 fraction bits.
    pub(crate) fn centre_of(index: i32) -> i64 {
        (i64::from(index) << Self::FRACTION_BITS) + i64::from(Self::HALF)
    }
}

/// The nearest whole number, ties to even; 0 for NaN; `value` below 2^51 in magnitude
/// (beyond it, what comes out is as large).
#[inline(always)]
fn round_to_even(value: f64) -> i64 {
    let limit = 2_251_799_813_685_248.0;
    let rounded = if value.abs() < limit { (value + WHOLE) - WHOLE } else { value };
    #[expect(clippy::cast_possible_truncation, reason = "whole already; saturates beyond i64")]
    let whole = rounded as i64;
    whole
}

/// A sum with this has no room for a fraction: it rounds, half to even, and its low bits are the whole
/// number, of what is below 2^51 in magnitude.
pub(crate) const WHOLE: f64 = 6_755_399_441_055_744.0;

/// The whole number that `sum` is with [`WHOLE`].
#[expect(clippy::cast_possible_truncation, reason = "the low half")]
#[inline(always)]
pub(crate) fn whole_of(sum: f64) -> i32 {
    (sum.to_bits() as u32).cast_signed()
}

/// 2^`exponent` for -1022 <= `exponent` <= 1023; what lies beyond becomes 0 or infinity.
#[inline(always)]
pub(crate) fn power_of_two(exponent: i32) -> f64 {
    match exponent {
        ..-1022 => 0.0,
        #[expect(clippy::cast_sign_loss, reason = "1..=2046")]
        -1022..=1023 => f64::from_bits(((exponent + 1023) as u64) << 52),
        _ => f64::INFINITY,
    }
}

/// The exponent e of 2^e <= |`value`| < 2^(e + 1), subnormals included; `None` for 0, NaN and
/// infinity.
#[inline(always)]
pub(crate) fn exponent_of(value: f64) -> Option<i32> {
    let bits = value.to_bits();
    let biased = i32::try_from(bits >> 52 & 0x7FF).unwrap_or(0);
    match biased {
        0x7FF => None,
        0 => {
            let fraction = bits << 12 >> 12;
            let top = fraction.checked_ilog2()?;
            Some(i32::try_from(top).unwrap_or(0) - 1074)
        }
        _ => Some(biased - 1023),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snap_rounds_half_to_even() {
        let at = |x: f64| Subpixel::snap(x / 65536.0, 0, Grid::Sixteen).bits();
        assert_eq!([at(0.5), at(1.5), at(2.5), at(-0.5), at(-1.5)], [0, 2, 2, 0, -2]);
        assert_eq!(Subpixel::snap(1.0 / 512.0, 0, Grid::Eight).bits(), 0);
        assert_eq!(Subpixel::snap(3.0 / 512.0, 0, Grid::Eight).bits(), 2 * 256);
        assert_eq!(Subpixel::snap(1e300, 0, Grid::Sixteen).bits(), 32767 << 16);
        assert_eq!(Subpixel::snap(-7.25, -10, Grid::Sixteen).bits(), 11 << 14);
    }

    #[test]
    fn snap_owns_rows_half_open() {
        let first = |x: f64| Subpixel::snap(x, 0, Grid::Sixteen).first_centre();
        assert_eq!([first(0.5), first(0.50002), first(-0.5), first(-0.49998)], [0, 1, -1, 0]);
        assert_eq!([first(32767.0), first(-32767.0)], [32767, -32767]);
    }

    #[test]
    fn exponents_are_found() {
        assert_eq!(exponent_of(1.0), Some(0));
        assert_eq!(exponent_of(-0.75), Some(-1));
        assert_eq!(exponent_of(f64::from_bits(1)), Some(-1074));
        assert_eq!(exponent_of(f64::MIN_POSITIVE / 2.0), Some(-1023));
        assert_eq!(exponent_of(0.0), None);
        assert_eq!(power_of_two(-3), 0.125);
    }
}
