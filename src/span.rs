//! The X loop: from a span to blocks of values.
//!
//! Blocks of 16 pixels begin at columns that are multiples of 16, wherever the span begins. A
//! quantity's numerator D and the common denominator Q are fixed-point accumulators; a pixel
//! costs one addition each, one reciprocal, and a multiplication for each attribute. The
//! quotient in `f64` comes with a bound of its error; where both ends of it round to the same
//! `f32`, that is the correctly rounded value (Ziv's test), else exact arithmetic finds it. So
//! the bits depend on nothing but the polygon and the pixel.
//! docs/precision.md, "The X loop", derives the bound.

use alloc::vec::Vec;
use core::cmp::Ordering;

use crate::across::{Carried, Corners};
use crate::clip::{Clipped, Clipper, VertexArrays};
use crate::divide::{ScreenVertex, divide};
use crate::edge::Span;
use crate::fixed::power_of_two;
use crate::gradient::frame::U;
use crate::gradient::{
    Affine, ConstantAlong, Field, Gradients, Quantity, Subject, nearest_f32, widen,
};
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

/// 16 lanes of `f64`.
type Wide = [f64; BLOCK];

/// A block's reciprocals: 1/Q and the relative error of each, in a polygon's fixed-point units.
#[derive(Clone, Copy, Debug)]
struct Reciprocals {
    r: Wide,
    relative_error: Wide,
    /// Lanes at which 1/w is surely positive, and the error small.
    certain: u16,
}

/// Finds the values of a polygon's quantities, block by block.
#[derive(Debug)]
pub(crate) struct SpanWalker<'a, V: ?Sized> {
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
    reciprocals: Reciprocals,
}

impl<'a, V: Polygon + ?Sized> SpanWalker<'a, V> {
    pub(crate) fn new(
        subject: &'a Subject<'a, V>,
        gradients: &'a mut Gradients,
        clipper: &'a mut Clipper,
    ) -> Self {
        let none = Reciprocals { r: [0.0; BLOCK], relative_error: [0.0; BLOCK], certain: 0 };
        Self {
            subject,
            gradients,
            clipper,
            exact_values: 0,
            corners: None,
            u: 0,
            v: i32::MIN,
            reciprocals: none,
        }
    }

    /// Goes to the block that begins at framebuffer column `x` of row `y`.
    #[inline]
    pub(crate) fn seek(&mut self, x: i32, y: i32) {
        let [anchor_x, anchor_y] = self.gradients.anchor.pixel;
        let (u, v) = (x - anchor_x, y - anchor_y);
        // What was found for the last block may hold for this one.
        let same = match self.gradients.constant {
            ConstantAlong::Polygon => self.v != i32::MIN,
            ConstantAlong::Row => self.v == v,
            ConstantAlong::Column => self.u == u && self.v != i32::MIN,
            ConstantAlong::Nothing => false,
        };
        (self.u, self.v) = (u, v);
        if !same {
            self.reciprocals = self.find_reciprocals();
        }
    }

    fn find_reciprocals(&self) -> Reciprocals {
        let gradients = &*self.gradients;
        let mut found = Reciprocals { r: [0.0; BLOCK], relative_error: [0.0; BLOCK], certain: 0 };
        let mut q = gradients.q.at(self.u, self.v);
        if gradients.q.d_dx == 0 {
            let r = 1.0 / widen(q);
            found.r = [r; BLOCK];
        } else {
            for r in &mut found.r {
                *r = 1.0 / widen(q);
                q = q.wrapping_add(gradients.q.d_dx);
            }
        }
        for lane in 0..BLOCK {
            let error = gradients.q_error * found.r[lane].abs();
            found.relative_error[lane] = error;
            // Also refuses what is no number.
            let certain = found.r[lane] * gradients.q_sign > 0.0 && error < CERTAIN;
            found.certain |= u16::from(certain) << lane;
        }
        found
    }

    /// Is attribute `k` the same all over?
    #[inline]
    pub(crate) fn is_constant(&self, k: usize) -> bool {
        matches!(self.gradients.attributes.get(k), Some(Field::Constant(_)))
    }

    /// The values of `quantity` at the lanes of `mask`, within `span`, clamped to its range.
    #[inline]
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
                *out = [value; BLOCK];
                return;
            }
            Some(Field::Affine(affine)) => self.affine(&affine, out) & self.reciprocals.certain,
            Some(Field::W(range)) => self.w(range, out) & self.reciprocals.certain,
            Some(Field::Across(carried, range)) => self.across(carried, range, span, out),
        };
        let mut left = mask & !certain;
        while left != 0 {
            let lane = left.trailing_zeros();
            left &= left - 1;
            let u = self.u + i32::try_from(lane).unwrap_or(0);
            out[lane as usize] = self.settle(quantity, span, u);
        }
    }

    /// base + D r, and the lanes at which it is surely rounded right.
    #[inline]
    fn affine(&self, affine: &Affine, out: &mut [f32; BLOCK]) -> u16 {
        let plane = &affine.plane;
        let mut d = plane.at(self.u, self.v);
        let mut t: Wide = [0.0; BLOCK];
        for t in &mut t {
            *t = widen(d) * affine.scale;
            d = d.wrapping_add(plane.d_dx);
        }
        let mut error: Wide = [affine.error; BLOCK];
        if affine.over_w {
            for lane in 0..BLOCK {
                let r = self.reciprocals.r[lane];
                t[lane] *= r;
                error[lane] = affine.error * r.abs()
                    + t[lane].abs() * (self.reciprocals.relative_error[lane] + QUOTIENT_ERROR);
            }
        } else {
            for lane in 0..BLOCK {
                error[lane] += t[lane].abs() * (self.gradients.det_relative_error + QUOTIENT_ERROR);
            }
        }
        for t in &mut t {
            *t += affine.base;
        }
        round(&t, &error, affine.range, out)
    }

    /// w = det/Q.
    fn w(&self, range: [f32; 2], out: &mut [f32; BLOCK]) -> u16 {
        let t = self.reciprocals.r.map(|r| r * self.gradients.w_scale);
        let mut error: Wide = [0.0; BLOCK];
        for lane in 0..BLOCK {
            let relative = self.reciprocals.relative_error[lane]
                + self.gradients.det_relative_error
                + QUOTIENT_ERROR;
            error[lane] = t[lane].abs() * relative;
        }
        round(&t, &error, range, out)
    }

    /// Along the edges of `span` and across it.
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
        let (mut value, mut error): (Wide, Wide) = ([0.0; BLOCK], [0.0; BLOCK]);
        for (lane, offset) in (0_i32..).enumerate().take(BLOCK) {
            (value[lane], error[lane]) = row.at(x + f64::from(offset));
        }
        let scale = match carried {
            Carried::W => scale,
            Carried::InvW => 1.0 / scale,
            _ => 1.0,
        };
        round(&value.map(|v| v * scale), &error.map(|e| e * scale), range, out)
    }

    /// The centre of the pixel in column `u` from the anchor of this row.
    fn centre(&self, u: i32) -> [f64; 2] {
        let [anchor_x, anchor_y] = self.gradients.anchor.pixel;
        [u + anchor_x, self.v + anchor_y].map(|c| f64::from(c) + 0.5)
    }

    /// The last resort, for one pixel.
    #[cold]
    fn settle(&mut self, quantity: Quantity, span: &Span, u: i32) -> f32 {
        self.exact_values += 1;
        match self.gradients.field(quantity) {
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
            for i in 0..subject.positions.len() {
                let values = (0..attributes).map(|k| f64::from(subject.polygon.attribute(i, k)));
                arrays.push(subject.positions.position(i), values);
            }
            let mut screen = Vec::new();
            if clipper.clip(&mut arrays) != Clipped::Outside {
                divide(&arrays, subject.viewport, &mut screen);
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
#[inline]
fn round(value: &Wide, error: &Wide, range: [f32; 2], out: &mut [f32; BLOCK]) -> u16 {
    let mut certain = 0;
    for lane in 0..BLOCK {
        // The bound is of first order, and the sums below round too.
        let error = error[lane] * SECOND_ORDER + SUM_ERROR * value[lane].abs();
        // An exact zero is +0: the last addition turns the sign of a negative one.
        let low = clamp(nearest_f32(value[lane] - error + 0.0), range);
        let high = clamp(nearest_f32(value[lane] + error + 0.0), range);
        out[lane] = low;
        let same = low.to_bits() == high.to_bits() && error < f64::INFINITY;
        certain |= u16::from(same) << lane;
    }
    certain
}

/// `value` within `range`, whose lower end, if it is 0, is +0: a number below it becomes that.
#[inline]
fn clamp(value: f32, [low, high]: [f32; 2]) -> f32 {
    let value = if value > low { value } else { low };
    if value > high { high } else { value }
}
