//! Walking along spans: what a row has in common is computed once, and plain quantities cost
//! a sum, a product and a rounding more.
//!
//! The same operations as the walker's own on the same numbers: the bits are the same, and
//! what is not plain goes that way.

use alloc::vec::Vec;

use fearless_simd::{Simd, SimdBase};

use crate::edge::Span;
use crate::gradient::{Field, Plain, Quantity};
use crate::lanes::{Narrow, Wide, clamp_numbers};
use crate::settle::Walked;
use crate::shade::BLOCK;
use crate::span::{InRow, Values, Walker};

/// So many attributes are prepared; of polygons with more, none is.
const PREPARED: usize = 4;

/// A span of so many columns is over before what is prepared for its row has paid.
const SHORT: i32 = 2 * BLOCK as i32;

/// A plain quantity on a row.
#[derive(Clone, Copy, Debug)]
struct PlainRow<S: Simd> {
    /// The numerator at the anchor's column, and its step.
    start: Wide<S>,
    step: Wide<S>,
    low: Narrow<S>,
    high: Narrow<S>,
}

impl<S: Simd> PlainRow<S> {
    #[inline(always)]
    fn none(simd: S) -> Self {
        let (wide, narrow) = (Wide::splat(simd, 0.0), Narrow::splat(simd, 0.0));
        Self { start: wide, step: wide, low: narrow, high: narrow }
    }

    /// `v`: the row's offset from the anchor.
    #[inline(always)]
    fn new(simd: S, plain: &Plain, v: f64) -> Self {
        Self {
            start: Wide::splat(simd, plain.numerator.row(v)),
            step: Wide::splat(simd, plain.numerator.x),
            low: Narrow::splat(simd, plain.range[0]),
            high: Narrow::splat(simd, plain.range[1]),
        }
    }

    /// N at the columns `us` from the anchor.
    #[inline(always)]
    fn numerators(&self, us: Wide<S>) -> Narrow<S> {
        (self.start + self.step * us).narrow()
    }

    #[inline(always)]
    fn clamped(&self, value: Narrow<S>) -> Narrow<S> {
        clamp_numbers(value, self.low, self.high)
    }
}

/// What is known of the attributes on a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Attributes {
    /// Nothing: no pixel has asked yet.
    Unknown,
    Prepared,
    /// Some are not plain, there are too many, or the span is short.
    General,
}

/// Finds values along spans, block by block.
pub(crate) struct AlongSpans<'a, S: Simd> {
    walker: Walker<'a, S, InRow<S>>,
    /// What the depth test compares, if it is plain, and nowhere on the span in doubt.
    tested: Option<PlainRow<S>>,
    attributes: [PlainRow<S>; PREPARED],
    attributes_are: Attributes,
}

impl<'a, S: Simd> AlongSpans<'a, S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, polygon: Walked<'a>) -> Self {
        Self {
            walker: Walker::along_spans(simd, polygon),
            tested: None,
            attributes: [PlainRow::none(simd); PREPARED],
            attributes_are: Attributes::Unknown,
        }
    }

    /// Goes to the 16 pixels from framebuffer column `x` of row `y` on, to follow a span of the
    /// columns `start..end`. `tested` is what the depth test will ask for.
    #[inline(always)]
    pub(crate) fn seek(&mut self, [x, y]: [i32; 2], columns: [i32; 2], tested: Option<Quantity>) {
        self.walker.seek(x, y);
        self.tested = None;
        if columns[1] - x <= SHORT {
            self.attributes_are = Attributes::General;
            return;
        }
        self.attributes_are = Attributes::Unknown;
        let gradients = &self.walker.polygon.gradients;
        if let Some(Field::Plain(plain)) = tested.and_then(|quantity| gradients.field(quantity))
            && !plain.over_w
        {
            let v = self.walker.place.v;
            // Rounding keeps the order, so the span's ends bound what lies between.
            let at = |column: i32| {
                let u = f64::from(column - gradients.anchor.pixel[0]);
                plain.numerator.row(v) + plain.numerator.x * u
            };
            let (first, last) = (at(columns[0]), at(columns[1] - 1));
            let least = if first < last { first } else { last };
            let greatest = if first < last { last } else { first };
            let doubtful = plain.doubtful_below;
            if doubtful <= 0.0 || least >= doubtful || greatest <= -doubtful {
                self.tested = Some(PlainRow::new(self.walker.simd, plain, v));
            }
        }
    }

    /// Goes 16 columns to the right.
    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        self.walker.advance();
    }

    /// Values that exact arithmetic found.
    #[inline(always)]
    pub(crate) fn exact_values(&self) -> u64 {
        self.walker.exact_values()
    }

    #[inline(always)]
    pub(crate) fn simd(&self) -> S {
        self.walker.simd
    }

    /// What the depth test compares.
    #[inline(always)]
    pub(crate) fn tested(
        &mut self,
        quantity: Quantity,
        span: &Span,
        mask: u16,
        out: &mut [f32; BLOCK],
    ) {
        if let Some(row) = &self.tested {
            row.clamped(row.numerators(self.walker.place.us)).store_array(out);
        } else {
            self.walker.evaluate(quantity, Some(span), mask, out);
        }
    }

    /// Looks whether all of `count` attributes are plain, and all or none over w, and prepares them.
    #[inline(always)]
    fn prepare(&mut self, count: usize, lanes: &mut Vec<[f32; BLOCK]>) {
        self.walker.need_attributes(lanes);
        self.attributes_are = Attributes::General;
        let gradients = &self.walker.polygon.gradients;
        let (fields, over_w) = (&gradients.attributes, gradients.divides);
        if fields.len() != count {
            return;
        }
        for (row, field) in self.attributes.iter_mut().zip(fields) {
            let Field::Plain(plain) = field else { return };
            if plain.over_w != over_w {
                return;
            }
            *row = PlainRow::new(self.walker.simd, plain, self.walker.place.v);
        }
        self.attributes_are = Attributes::Prepared;
    }
}

impl<S: Simd> Values for AlongSpans<'_, S> {
    #[inline(always)]
    fn evaluate(
        &mut self,
        quantity: Quantity,
        span: Option<&Span>,
        mask: u16,
        out: &mut [f32; BLOCK],
    ) {
        self.walker.evaluate(quantity, span, mask, out);
    }

    #[inline(always)]
    fn evaluate_attributes(
        &mut self,
        count: usize,
        span: Option<&Span>,
        mask: u16,
        lanes: &mut Vec<[f32; BLOCK]>,
    ) {
        if count <= PREPARED {
            if self.attributes_are == Attributes::Unknown {
                self.prepare(count, lanes);
            }
            if self.attributes_are == Attributes::Prepared
                && let Some(lanes) = lanes.get_mut(..count)
            {
                let us = self.walker.place.us;
                if self.walker.polygon.gradients.divides {
                    let r = self.walker.reciprocals();
                    for (row, lanes) in self.attributes[..count].iter().zip(lanes) {
                        row.clamped(row.numerators(us) * r).store_array(lanes);
                    }
                } else {
                    for (row, lanes) in self.attributes[..count].iter().zip(lanes) {
                        row.clamped(row.numerators(us)).store_array(lanes);
                    }
                }
                return;
            }
        }
        self.walker.evaluate_attributes(count, span, mask, lanes);
    }
}
