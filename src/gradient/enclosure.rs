//! Bounds of a quantity over a rectangle of pixels, rounded outward.
//!
//! A linear function has its extremes at corners. What a pixel gets is within a unit in the last
//! place of the right value, which is off by the set-up's bound: docs/precision.md, "What is
//! hidden".

use super::frame::Linear;
use super::{Field, Gradients, Quantity, Subject, WITHIN_ULP, nearest_f32};
use crate::number::Number;
use crate::space::PixelRect;

/// Two units in the last place, relatively, and of the smallest numbers: one for the value, one
/// for the rounding here.
const OUTWARD: [f64; 2] = [1.0 / 4_194_304.0, 3e-45];

/// The greatest relative error of det that [`OUTWARD`] has room for.
const GOOD: f64 = 1.0 / 268_435_456.0;

/// What a quantity's values lie between.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Enclosure {
    linear: Linear,
    /// How far a value may be from it; infinite if nothing is known but the range.
    slack: f64,
    range: [f32; 2],
    /// The pixel that it counts from, in the framebuffer.
    pub(crate) anchor: [i32; 2],
}

impl Enclosure {
    /// Of values between `range` and no more.
    #[inline(always)]
    fn whole(range: [f32; 2]) -> Self {
        Self { linear: Linear::default(), slack: f64::INFINITY, range, anchor: [0; 2] }
    }

    /// At `pixels` of the framebuffer; there is at least one.
    #[inline(always)]
    pub(crate) fn over_pixels(&self, pixels: PixelRect) -> [f32; 2] {
        let PixelRect { x0, y0, x1, y1 } = pixels;
        let from_anchor = |c: i32, k: usize| f64::from(c.wrapping_sub(self.anchor[k]));
        let (u, v) = (
            [from_anchor(x0, 0), from_anchor(x1 - 1, 0)],
            [from_anchor(y0, 1), from_anchor(y1 - 1, 1)],
        );
        self.over(u, v)
    }

    /// At the pixels from the first to the second of `u` columns and `v` rows from the anchor.
    #[inline(always)]
    pub(crate) fn over(&self, u: [f64; 2], v: [f64; 2]) -> [f32; 2] {
        let Linear { x, y, .. } = self.linear;
        let ([u0, u1], [v0, v1]) =
            (if x < 0.0 { [u[1], u[0]] } else { u }, if y < 0.0 { [v[1], v[0]] } else { v });
        let low = self.linear.row(v0) + x * u0 - self.slack;
        let high = self.linear.row(v1) + x * u1 + self.slack;
        within(outward([low, high]), self.range)
    }
}

/// The same of values that are clamped to `range`, as they are; that, if the bounds are no numbers.
#[inline(always)]
pub(crate) fn within([low, high]: [f32; 2], [least, greatest]: [f32; 2]) -> [f32; 2] {
    let low = if low > least { low } else { least };
    let high = if high < greatest { high } else { greatest };
    [if low < greatest { low } else { greatest }, if high > least { high } else { least }]
}

/// Bounds of right values, as bounds of what pixels get.
#[inline(always)]
pub(crate) fn outward(bounds: [f64; 2]) -> [f32; 2] {
    let [low, high] = widened(bounds);
    [nearest_f32(low), nearest_f32(high)]
}

/// The same before they are rounded, which then brings none of them nearer than it was.
#[inline(always)]
pub(crate) fn widened<F: Number>([low, high]: [F; 2]) -> [F; 2] {
    let [relative, least] = OUTWARD;
    [low - (low.abs() * relative + least), high + (high.abs() * relative + least)]
}

impl Gradients {
    /// Of depth or 1/w, once set up.
    #[inline(always)]
    pub(crate) fn enclosure(&self, quantity: Quantity, subject: &Subject<'_>) -> Enclosure {
        let anchor = self.anchor.pixel;
        match self.field(quantity) {
            Some(Field::Constant(value)) => Enclosure::whole([*value; 2]),
            Some(Field::Plain(plain)) if !plain.over_w => {
                // Twice the error.
                let slack = plain.doubtful_below * (2.0 / WITHIN_ULP);
                Enclosure { linear: plain.numerator, slack, range: plain.range, anchor }
            }
            Some(Field::Strict(strict)) if !strict.over_w => {
                // Beyond the plane's horizon it is a vertex's value.
                let reach = subject.viewport.grid().snap_reach();
                let beyond = (self.q.x.abs() + self.q.y.abs()) * reach + self.q_error;
                let good = beyond <= self.least_q / 2.0 && self.det_relative_error <= GOOD;
                let slack = if good { 2.0 * strict.error } else { f64::INFINITY };
                Enclosure {
                    linear: strict.numerator.scaled(strict.scale),
                    slack,
                    range: strict.range,
                    anchor,
                }
            }
            Some(Field::Across(_, range)) => Enclosure::whole(*range),
            Some(Field::Plain(_) | Field::Strict(_)) | None => {
                Enclosure::whole([f32::NEG_INFINITY, f32::INFINITY])
            }
        }
    }
}
