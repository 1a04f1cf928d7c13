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
use core::cmp::Ordering;

use fearless_simd::{Simd, SimdBase};

use crate::across::{Carried, Corners};
use crate::clip::{Clipped, Clipper, VertexArrays};
use crate::divide::{ScreenVertex, divide};
use crate::edge::Span;
use crate::fixed::power_of_two;
use crate::gradient::frame::{Linear, U};
use crate::gradient::{Affine, ConstantAlong, Field, Gradients, Quantity, Subject, nearest_f32};
use crate::lanes::{Wide, clamp_lanes, same_bits};
use crate::polygon::Polygon;
use crate::shade::BLOCK;
use crate::varying::{CANONICAL_NAN, Interpolation};

/// t = D scale / Q: two conversions, a reciprocal and two products, relatively.
const QUOTIENT_ERROR: f64 = 5.0 * U;

/// base + t, and the two ends of Ziv's test, relatively.
const SUM_ERROR: f64 = 3.0 * U;

/// Room for what a bound of first order leaves out, where Q is off by 1/256 at most.
const SECOND_ORDER: f64 = 1.01;

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
#[derive(Debug)]
pub(crate) struct SpanWalker<'a, S: Simd, V: ?Sized> {
    simd: S,
    subject: &'a Subject<'a, V>,
    gradients: &'a mut Gradients,
    clipper: &'a mut Clipper,
    /// Values that exact arithmetic found.
    pub(crate) exact_values: u64,
    /// The clipped polygon with all its attributes, made when first needed.
    corners: Option<(VertexArrays, Vec<ScreenVertex>)>,
    /// Offset of the block's first lane from the anchor.
    u: i32,
    v: i32,
    /// The same, of all lanes.
    us: Wide<S>,
    vs: f64,
    reciprocals: Reciprocals<S>,
    /// Are they this block's?
    has_reciprocals: bool,
}

impl<'a, S: Simd, V: Polygon + ?Sized> SpanWalker<'a, S, V> {
    #[inline(always)]
    pub(crate) fn new(
        simd: S,
        subject: &'a Subject<'a, V>,
        gradients: &'a mut Gradients,
        clipper: &'a mut Clipper,
    ) -> Self {
        let zero = Wide::splat(simd, 0.0);
        Self {
            simd,
            subject,
            gradients,
            clipper,
            exact_values: 0,
            corners: None,
            u: 0,
            v: 0,
            us: zero,
            vs: 0.0,
            reciprocals: Reciprocals { r: zero, relative_error: zero, certain: 0 },
            has_reciprocals: false,
        }
    }

    /// Goes to the block that begins at framebuffer column `x` of row `y`.
    #[inline(always)]
    pub(crate) fn seek(&mut self, x: i32, y: i32) {
        let [anchor_x, anchor_y] = self.gradients.anchor.pixel;
        let (u, v) = (x - anchor_x, y - anchor_y);
        // What was found for another block may hold for this one.
        self.has_reciprocals &= match self.gradients.constant {
            ConstantAlong::Polygon => true,
            ConstantAlong::Row => self.v == v,
            ConstantAlong::Column => self.u == u,
            ConstantAlong::Nothing => false,
        };
        (self.u, self.v) = (u, v);
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
        let (simd, gradients) = (self.simd, &*self.gradients);
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
        matches!(self.gradients.attributes.get(k), Some(Field::Constant(_)))
    }

    /// Sets the attributes up for the polygon's first pixel, and fills in those that are
    /// constant.
    #[inline(always)]
    pub(crate) fn prepare_attributes(&mut self, lanes: &mut Vec<[f32; BLOCK]>) {
        if self.gradients.has_attributes {
            return;
        }
        self.gradients.set_attributes(self.subject);
        lanes.clear();
        lanes.extend(self.gradients.attributes.iter().map(|field| match field {
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
        let certain = match self.gradients.field(quantity) {
            None => return,
            Some(Field::Constant(value)) => {
                *out = [*value; BLOCK];
                return;
            }
            Some(Field::Affine(affine)) => {
                let affine = *affine;
                if affine.over_w || affine.strict {
                    self.find_reciprocals();
                }
                self.affine(&affine, out)
            }
            Some(Field::W(range)) => {
                let range = *range;
                self.find_reciprocals();
                self.w(range, out)
            }
            Some(Field::Across(carried, range)) => {
                let (carried, range) = (*carried, *range);
                self.across(carried, range, span, out)
            }
        };
        if mask & !certain != 0 {
            self.settle_lanes(quantity, span, mask & !certain, out);
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
                (error, Wide::splat(simd, self.gradients.det_relative_error))
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

    /// w = det/Q.
    #[inline(always)]
    fn w(&self, range: [f32; 2], out: &mut [f32; BLOCK]) -> u16 {
        let (simd, gradients) = (self.simd, &*self.gradients);
        let t = self.reciprocals.r * Wide::splat(simd, gradients.w_scale);
        if !gradients.strict {
            clamp_lanes(t.narrow(), range).store_array(out);
            return u16::MAX;
        }
        let relative = gradients.det_relative_error + QUOTIENT_ERROR;
        let error = t.abs() * (self.reciprocals.relative_error + Wide::splat(simd, relative));
        round_surely(simd, t, error, range, out) & self.reciprocals.certain
    }

    /// The last resort, for some pixels.
    #[cold]
    #[inline(never)]
    fn settle_lanes(&mut self, quantity: Quantity, span: &Span, mask: u16, out: &mut [f32; BLOCK]) {
        let mut left = mask;
        while left != 0 {
            let lane = left.trailing_zeros();
            left &= left - 1;
            let u = self.u + i32::try_from(lane).unwrap_or(0);
            out[lane as usize] = self.settle(quantity, span, u);
        }
    }

    /// Along the edges of `span` and across it.
    #[inline(never)]
    fn across(
        &mut self,
        carried: Carried,
        range: [f32; 2],
        span: &Span,
        out: &mut [f32; BLOCK],
    ) -> u16 {
        let [x, y] = self.centre(self.u);
        let scale = power_of_two(self.subject.exponent);
        let row = self.corners().row(carried, span, y);
        let (mut value, mut error) = ([0.0; BLOCK], [0.0; BLOCK]);
        for (lane, offset) in (0_i32..).enumerate().take(BLOCK) {
            (value[lane], error[lane]) = row.at(x + f64::from(offset));
        }
        let scale = match carried {
            Carried::W => scale,
            Carried::InvW => 1.0 / scale,
            _ => 1.0,
        };
        let simd = self.simd;
        let [value, error] =
            [value, error].map(|lanes| Wide::load(simd, &lanes) * Wide::splat(simd, scale));
        round_surely(simd, value, error, range, out)
    }

    /// The centre of the pixel in column `u` from the anchor of this row.
    fn centre(&self, u: i32) -> [f64; 2] {
        let [anchor_x, anchor_y] = self.gradients.anchor.pixel;
        [u + anchor_x, self.v + anchor_y].map(|c| f64::from(c) + 0.5)
    }

    /// The correctly rounded value at one pixel.
    fn settle(&mut self, quantity: Quantity, span: &Span, u: i32) -> f32 {
        self.exact_values += 1;
        match self.gradients.field(quantity).copied() {
            None => CANONICAL_NAN,
            Some(Field::Constant(value)) => value,
            Some(Field::Across(carried, range)) => {
                let (centre, exponent) = (self.centre(u), self.subject.exponent);
                clamp(self.corners().exact_value(carried, span, centre, exponent), range)
            }
            Some(Field::Affine(Affine { range, .. }) | Field::W(range)) => {
                let value = self.gradients.exact_value(self.subject, quantity, u, self.v);
                clamp(value.unwrap_or_else(|| self.nearest_corner(quantity, u)), range)
            }
        }
    }

    /// The clipped polygon with all its attributes.
    fn corners(&mut self) -> Corners<'_> {
        let (subject, clipper) = (self.subject, &mut *self.clipper);
        let (arrays, screen) = self.corners.get_or_insert_with(|| {
            let attributes = subject.wanted.attributes;
            let mut arrays = VertexArrays::new(attributes);
            for k in 0..attributes {
                if subject.interpolation_of(k) == Interpolation::NoPerspective {
                    arrays.set_noperspective(k);
                }
            }
            for (i, position) in subject.positions.iter().enumerate() {
                let values = (0..attributes).map(|k| f64::from(subject.polygon.attribute(i, k)));
                arrays.push(*position, values);
            }
            let mut screen = Vec::new();
            if clipper.clip(&mut arrays) != Clipped::Outside {
                divide(arrays.positions(), subject.viewport, &mut screen);
            }
            (arrays, screen)
        });
        Corners { arrays, screen }
    }

    /// The value at the clipped vertex nearest to the pixel's centre; of two, at the least by
    /// position.
    fn nearest_corner(&mut self, quantity: Quantity, u: i32) -> f32 {
        let (centre, subject) = (self.centre(u), self.subject);
        let Corners { arrays, screen } = self.corners();
        let distance = |vertex: &ScreenVertex| {
            let [x, y] = [0, 1].map(|k| vertex.framebuffer[k] - centre[k]);
            x * x + y * y
        };
        let order = |a: &&ScreenVertex, b: &&ScreenVertex| {
            let position = |v: &ScreenVertex| arrays.position(v.vertex as usize);
            distance(a)
                .total_cmp(&distance(b))
                .then_with(|| position(a).partial_cmp(&position(b)).unwrap_or(Ordering::Equal))
        };
        let Some(nearest) = screen.iter().min_by(order) else { return 0.0 };
        let i = nearest.vertex as usize;
        let [_, _, _, w] = arrays.position(i);
        let scale = power_of_two(subject.exponent);
        nearest_f32(match quantity {
            Quantity::W => w * scale,
            Quantity::InvW => 1.0 / (w * scale),
            Quantity::Depth => subject.depth_numerator(arrays.position(i)) / w,
            Quantity::Attribute(k) => arrays.attributes(i)[k],
        })
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

/// `value` within `range`: see [`clamp_lanes`].
fn clamp(value: f32, [low, high]: [f32; 2]) -> f32 {
    let value = if value > low { value } else { low };
    if value > high { high } else { value }
}
