//! The X loop: from a span to blocks of values.
//!
//! Blocks of 16 pixels begin at columns that are multiples of 16, wherever the span begins; a
//! value depends on its pixel alone, so that any number of lanes at a time gives the same bits.
//! A pixel costs the common denominator Q and one reciprocal, and for each attribute a numerator
//! and a multiplication; none where 1/w does not change.
//!
//! The quotient in `f64` comes with a bound of its error. `Fast` rounds it once. `Exact` looks
//! whether both ends of the bound round to the same `f32` (Ziv's test): then that is the
//! correctly rounded value, else exact arithmetic finds it. docs/precision.md, "The X loop",
//! derives the bound.

use alloc::vec::Vec;

use fearless_simd::{Simd, SimdBase};

use crate::edge::Span;
use crate::gradient::frame::{Linear, U};
use crate::gradient::{Affine, ConstantAlong, Field, Quantity};
use crate::lanes::{Wide, clamp_lanes, same_bits};
use crate::settle::{SECOND_ORDER, SUM_ERROR, Walked};
use crate::shade::BLOCK;

/// t = D scale / Q: two conversions, a reciprocal and two products, relatively.
const QUOTIENT_ERROR: f64 = 5.0 * U;

/// How far Q may be off, relatively, for the bound to hold.
const CERTAIN: f64 = 1.0 / 256.0;

/// A block's reciprocals.
#[derive(Clone, Copy, Debug)]
struct Reciprocals<S: Simd> {
    /// 1/Q.
    r: Wide<S>,
    /// The relative error of each, if that is asked for.
    relative_error: Wide<S>,
    /// Lanes at which 1/w is surely positive, and the error small; or that need not be looked at.
    certain: u16,
}

/// Finds the values of a polygon's quantities, block by block.
pub(crate) struct SpanWalker<'a, S: Simd> {
    pub(crate) simd: S,
    polygon: Walked<'a>,
    /// Offset of all lanes from the anchor.
    us: Wide<S>,
    vs: f64,
    reciprocals: Reciprocals<S>,
    /// Are they this block's?
    has_reciprocals: bool,
}

impl<'a, S: Simd> SpanWalker<'a, S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, polygon: Walked<'a>) -> Self {
        let zero = Wide::splat(simd, 0.0);
        Self {
            simd,
            polygon,
            us: zero,
            vs: 0.0,
            reciprocals: Reciprocals { r: zero, relative_error: zero, certain: 0 },
            has_reciprocals: false,
        }
    }

    /// Values that exact arithmetic found.
    #[inline(always)]
    pub(crate) fn exact_values(&self) -> u64 {
        self.polygon.exact_values
    }

    /// Goes to the block that begins at framebuffer column `x` of row `y`.
    #[inline(always)]
    pub(crate) fn seek(&mut self, x: i32, y: i32) {
        let polygon = &mut self.polygon;
        let [anchor_x, anchor_y] = polygon.gradients.anchor.pixel;
        let (u, v) = (x - anchor_x, y - anchor_y);
        // What was found for another block may hold for this one.
        self.has_reciprocals &= match polygon.gradients.constant {
            ConstantAlong::Polygon => true,
            ConstantAlong::Row => polygon.v == v,
            ConstantAlong::Column => polygon.u == u,
            ConstantAlong::Nothing => false,
        };
        (polygon.u, polygon.v) = (u, v);
        (self.us, self.vs) = (Wide::count_from(self.simd, f64::from(u)), f64::from(v));
    }

    /// A linear function at this block's pixels.
    #[inline(always)]
    fn linear(&self, function: Linear) -> Wide<S> {
        Wide::splat(self.simd, function.row(self.vs)) + Wide::splat(self.simd, function.x) * self.us
    }

    /// Sees to it that the reciprocals are this block's.
    #[inline(always)]
    fn find_reciprocals(&mut self) {
        if self.has_reciprocals {
            return;
        }
        self.has_reciprocals = true;
        let (simd, gradients) = (self.simd, &*self.polygon.gradients);
        let r = if gradients.q.x == 0.0 {
            Wide::splat(simd, 1.0 / gradients.q.row(self.vs))
        } else {
            self.linear(gradients.q).reciprocal(simd)
        };
        self.reciprocals.r = r;
        self.reciprocals.certain = u16::MAX;
        if gradients.strict {
            let error = Wide::splat(simd, gradients.q_error) * r.abs();
            let positive = Wide::splat(simd, 0.0).below(r * Wide::splat(simd, gradients.q_sign));
            self.reciprocals.relative_error = error;
            // Neither holds for what is no number.
            self.reciprocals.certain = positive & error.below(Wide::splat(simd, CERTAIN));
        }
    }

    /// Is attribute `k` the same all over?
    #[inline(always)]
    pub(crate) fn is_constant(&self, k: usize) -> bool {
        matches!(self.polygon.gradients.attributes.get(k), Some(Field::Constant(_)))
    }

    /// Sets the attributes up for the polygon's first pixel, and fills in those that are
    /// constant.
    #[inline(always)]
    pub(crate) fn prepare_attributes(&mut self, lanes: &mut Vec<[f32; BLOCK]>) {
        if self.polygon.gradients.has_attributes {
            return;
        }
        self.polygon.gradients.set_attributes(self.polygon.subject);
        lanes.clear();
        lanes.extend(self.polygon.gradients.attributes.iter().map(|field| match field {
            Field::Constant(value) => [*value; BLOCK],
            _ => [0.0; BLOCK],
        }));
    }

    /// The values of `quantity` at the lanes of `mask`, within `span`, clamped to its range.
    #[inline(always)]
    pub(crate) fn evaluate(
        &mut self,
        quantity: Quantity,
        span: &Span,
        mask: u16,
        out: &mut [f32; BLOCK],
    ) {
        let certain = match self.polygon.gradients.field(quantity) {
            Some(Field::Affine(affine)) => {
                let affine = *affine;
                if affine.over_w || affine.strict {
                    self.find_reciprocals();
                }
                self.affine(&affine, out)
            }
            Some(Field::Constant(value)) => {
                *out = [*value; BLOCK];
                return;
            }
            Some(Field::Across(carried, range)) => {
                let (carried, range) = (*carried, *range);
                self.polygon.across(carried, range, span, out)
            }
            None => return,
        };
        if mask & !certain != 0 {
            self.polygon.settle_lanes(quantity, span, mask & !certain, out);
        }
    }

    /// base + D r, and the lanes at which it is good enough.
    #[inline(always)]
    fn affine(&self, affine: &Affine, out: &mut [f32; BLOCK]) -> u16 {
        let simd = self.simd;
        let d = self.linear(affine.numerator);
        let r = if affine.over_w { self.reciprocals.r } else { Wide::splat(simd, affine.scale) };
        let t = d * r;
        let value = t + Wide::splat(simd, affine.base);
        if affine.strict {
            let error = Wide::splat(simd, affine.error);
            let (error, relative) = if affine.over_w {
                (error * r.abs(), self.reciprocals.relative_error)
            } else {
                (error, Wide::splat(simd, self.polygon.gradients.det_relative_error))
            };
            let error = error + t.abs() * (relative + Wide::splat(simd, QUOTIENT_ERROR));
            return round_surely(simd, value, error, affine.range, out) & self.reciprocals.certain;
        }
        clamp_lanes(value.narrow(), affine.range).store_array(out);
        if affine.doubtful_below > 0.0 {
            return !t.abs().below(Wide::splat(simd, affine.doubtful_below));
        }
        u16::MAX
    }
}

/// Rounds `value` to `f32`, and tells at which lanes any number within `error` of it rounds to
/// the same, once clamped to `range`.
#[inline(always)]
fn round_surely<S: Simd>(
    simd: S,
    value: Wide<S>,
    error: Wide<S>,
    range: [f32; 2],
    out: &mut [f32; BLOCK],
) -> u16 {
    // The bound is of first order, and the sums below round too.
    let error =
        error * Wide::splat(simd, SECOND_ORDER) + value.abs() * Wide::splat(simd, SUM_ERROR);
    // An exact zero is +0: the last addition turns the sign of a negative one.
    let zero = Wide::splat(simd, 0.0);
    let low = clamp_lanes((value - error + zero).narrow(), range);
    let high = clamp_lanes((value + error + zero).narrow(), range);
    low.store_array(out);
    same_bits(low, high) & error.below(Wide::splat(simd, f64::INFINITY))
}
