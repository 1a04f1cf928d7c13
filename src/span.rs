//! The X loop: from a span to blocks of values.
//!
//! Blocks of 16 pixels begin at columns that are multiples of 16, wherever the span begins. A
//! quantity's numerator D and the common denominator Q are fixed-point accumulators; a pixel
//! costs one addition each, one reciprocal, and a multiplication for each attribute. The
//! quotient in `f64` comes with a bound of its error; where both ends of it round to the same
//! `f32`, that is the correctly rounded value (Ziv's test), else exact arithmetic finds it. So
//! the bits depend on nothing but the polygon and the pixel.
//! docs/precision.md, "The X loop", derives the bound.

use crate::clip::{Clipped, Clipper, VertexArrays};
use crate::divide::{ScreenVertex, divide};
use crate::gradient::frame::U;
use crate::gradient::{
    Affine, ConstantAlong, Field, Gradients, Quantity, Subject, nearest_f32, widen,
};
use crate::polygon::Polygon;
use crate::shade::BLOCK;
use crate::space::DepthRange;

use alloc::vec::Vec;

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
    pub(crate) subject: &'a Subject<'a, V>,
    pub(crate) gradients: &'a mut Gradients,
    pub(crate) clipper: &'a mut Clipper,
    /// Values that exact arithmetic found.
    pub(crate) exact_values: u64,
    /// The clipped polygon with all its attributes, made when first needed.
    pub(crate) corners: Option<(VertexArrays, Vec<ScreenVertex>)>,
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
            let certain = found.r[lane] * gradients.q_sign > 0.0 && error < 1.0 / 256.0;
            found.certain |= u16::from(certain) << lane;
        }
        found
    }

    /// Is attribute `k` the same all over?
    #[inline]
    pub(crate) fn is_constant(&self, k: usize) -> bool {
        matches!(self.gradients.attributes.get(k), Some(Field::Constant(_)))
    }

    /// The values of `quantity` at the lanes of `mask`, clamped to its range.
    #[inline]
    pub(crate) fn evaluate(&mut self, quantity: Quantity, mask: u16, out: &mut [f32; BLOCK]) {
        let gradients = &*self.gradients;
        let field = match quantity {
            Quantity::Depth => gradients.depth,
            Quantity::InvW => gradients.inv_w,
            Quantity::Attribute(k) => gradients.attributes.get(k).copied(),
            Quantity::W => None,
        };
        let rounded = match field {
            Some(Field::Constant(value)) => {
                *out = [value; BLOCK];
                return;
            }
            Some(Field::Affine(affine)) => self.affine(&affine, out),
            None => self.w(out),
        };
        let mut left = mask & !(rounded & self.reciprocals.certain);
        while left != 0 {
            let lane = left.trailing_zeros();
            left &= left - 1;
            out[lane as usize] = self.settle(quantity, self.u + i32::try_from(lane).unwrap_or(0));
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
                    + t[lane].abs() * (self.reciprocals.relative_error[lane] + 5.0 * U);
            }
        } else {
            for lane in 0..BLOCK {
                error[lane] += t[lane].abs() * (self.gradients.det_relative_error + 5.0 * U);
            }
        }
        for t in &mut t {
            *t += affine.base;
        }
        round(&t, &error, affine.range, out)
    }

    /// w = det/Q.
    fn w(&self, out: &mut [f32; BLOCK]) -> u16 {
        let t = self.reciprocals.r.map(|r| r * self.gradients.w_scale);
        let mut error: Wide = [0.0; BLOCK];
        for lane in 0..BLOCK {
            let relative =
                self.reciprocals.relative_error[lane] + self.gradients.det_relative_error + 5.0 * U;
            error[lane] = t[lane].abs() * relative;
        }
        round(&t, &error, self.gradients.w_range, out)
    }

    /// The last resort, for one pixel.
    #[cold]
    fn settle(&mut self, quantity: Quantity, u: i32) -> f32 {
        self.exact_values += 1;
        let value = match self.gradients.exact_value(self.subject, quantity, u, self.v) {
            Some(value) => value,
            None => self.nearest_corner(quantity, u),
        };
        clamp(value, self.gradients.range(quantity))
    }

    /// The value at the clipped vertex nearest to the pixel's centre; of two, at the least by
    /// position.
    fn nearest_corner(&mut self, quantity: Quantity, u: i32) -> f32 {
        let [anchor_x, anchor_y] = self.gradients.anchor.pixel;
        let centre = [u + anchor_x, self.v + anchor_y].map(|c| f64::from(c) + 0.5);
        let subject = self.subject;
        let clipper = &mut *self.clipper;
        let (arrays, screen) = self.corners.get_or_insert_with(|| {
            let attributes = subject.polygon.attribute_count();
            let mut arrays = VertexArrays::new(attributes);
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
        let distance = |vertex: &ScreenVertex| {
            let [x, y] = [0, 1].map(|k| vertex.framebuffer[k] - centre[k]);
            x * x + y * y
        };
        let order = |a: &&ScreenVertex, b: &&ScreenVertex| {
            let position = |v: &ScreenVertex| arrays.position(v.vertex as usize);
            distance(a).total_cmp(&distance(b)).then_with(|| {
                position(a).partial_cmp(&position(b)).unwrap_or(core::cmp::Ordering::Equal)
            })
        };
        let Some(nearest) = screen.iter().min_by(order) else { return 0.0 };
        let i = nearest.vertex as usize;
        let [_, _, z, w] = arrays.position(i);
        let scale = crate::fixed::power_of_two(subject.exponent);
        nearest_f32(match quantity {
            Quantity::W => w * scale,
            Quantity::InvW => 1.0 / (w * scale),
            Quantity::Depth => match subject.viewport.depth_range() {
                DepthRange::ZeroToOne => z / w,
                DepthRange::MinusOneToOne => (z + w) / 2.0 / w,
            },
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
        let error = error[lane] * 1.01 + 3.0 * U * value[lane].abs();
        let low = clamp(nearest_f32(value[lane] - error), range);
        let high = clamp(nearest_f32(value[lane] + error), range);
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
