//! Walking along spans: what a polygon's rows and blocks have in common is computed once.
//!
//! Plain quantities of polygons whose spans are long go by blocks (see
//! [`along`](crate::along)). What all blocks of a polygon need is prepared, if they have enough in
//! common (see [`prepared`](crate::prepared)); else each is looked at by itself. What is not plain,
//! and polygons with short spans, go the walker's way: lane by lane.

use fearless_simd::{Simd, SimdBase};

use crate::aligned::LaneMemory;
use crate::along::{
    AHEAD, MIDDLE, OnRow, always_near, least_for_depth, least_for_numerator, least_for_q,
    least_for_row, near_zero_up_to,
};
use crate::edge::Span;
use crate::gradient::{Field, Plain, Quantity};
use crate::lanes::{Narrow, clamp_numbers};
use crate::prepared::Prepared;
use crate::settle::Walked;
use crate::shade::BLOCK;
use crate::span::{InRow, Values, Walker};
use crate::tested::Tested;

/// What is known of the attributes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Attributes {
    /// Nothing: no pixel has asked yet.
    Unknown,
    /// They are prepared, but for another row.
    Elsewhere,
    /// They are prepared, for this row.
    Here,
    /// They cannot be prepared.
    General,
}

/// Finds values along spans, block by block.
pub(crate) struct AlongSpans<'a, S: Simd> {
    walker: Walker<'a, S, InRow>,
    /// See [`Subject::short`](crate::gradient::Subject::short).
    pub(crate) short: bool,
    pub(crate) tested: Option<Tested<S>>,
    pub(crate) prepared: Prepared<S>,
    attributes: Attributes,
}

impl<'a, S: Simd> AlongSpans<'a, S> {
    /// `tested` is what the depth test will ask for.
    #[inline(always)]
    pub(crate) fn new(simd: S, polygon: Walked<'a>, tested: Option<Quantity>) -> Self {
        let tested = tested.and_then(|quantity| Tested::new(simd, polygon.gradients, quantity));
        let short = polygon.subject.short;
        Self {
            walker: Walker::along_spans(simd, polygon),
            short,
            tested,
            prepared: Prepared::none(simd),
            attributes: Attributes::Unknown,
        }
    }

    /// Goes to the 16 pixels from framebuffer column `x` of row `y` on.
    #[inline(always)]
    pub(crate) fn seek(&mut self, [x, y]: [i32; 2]) {
        self.walker.seek(x, y);
        if let Some(tested) = &mut self.tested {
            tested.seek(self.walker.place.v);
        }
        if self.attributes == Attributes::Here {
            self.attributes = Attributes::Elsewhere;
        }
    }

    /// The lanes of `mask` of what is tested, so many blocks to the right, where it is undecided.
    #[inline(never)]
    pub(crate) fn decide(
        &mut self,
        blocks: i32,
        quantity: Quantity,
        span: &Span,
        mask: u16,
        out: &mut [f32; BLOCK],
    ) {
        self.walker.advance(blocks);
        self.evaluate(quantity, Some(span), mask, out);
        self.walker.advance(-blocks);
    }

    /// The same for some attributes, a bit for each.
    #[inline(never)]
    pub(crate) fn decide_attributes(
        &mut self,
        blocks: i32,
        span: &Span,
        mask: u16,
        attributes: u16,
        out: &mut [[f32; BLOCK]],
    ) {
        self.walker.advance(blocks);
        for (k, out) in out.iter_mut().enumerate() {
            if attributes >> k & 1 != 0 {
                self.walker.evaluate(Quantity::Attribute(k), Some(span), mask, out);
            }
        }
        self.walker.advance(-blocks);
    }

    /// Goes to the right by so many blocks.
    #[inline(always)]
    pub(crate) fn advance(&mut self, blocks: i32) {
        self.walker.advance(blocks);
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

    /// Where the block's middle is from the anchor.
    #[inline(always)]
    pub(crate) fn middle(&self) -> f64 {
        self.walker.place.u + MIDDLE
    }

    /// Prepares the attributes for this row; says whether they can be.
    #[inline(always)]
    pub(crate) fn prepare(&mut self, lanes: &mut LaneMemory) -> bool {
        if self.attributes == Attributes::Unknown {
            self.prepare_polygon(lanes);
        }
        if self.attributes == Attributes::Elsewhere {
            let count = self.attribute_count();
            self.prepared.seek(self.walker.simd, count, self.walker.place.v);
            self.attributes = Attributes::Here;
        }
        self.attributes == Attributes::Here
    }

    /// Prepares the attributes for the polygon, if they can be: once, and so out of line, where it is
    /// compiled for all shaders.
    #[inline(never)]
    fn prepare_polygon(&mut self, lanes: &mut LaneMemory) {
        let simd = self.walker.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                self.walker.need_attributes(lanes);
                let gradients = &*self.walker.polygon.gradients;
                self.attributes = if self.prepared.set(simd, gradients, self.short) {
                    lanes.make_room(AHEAD * self.attribute_count());
                    Attributes::Elsewhere
                } else {
                    Attributes::General
                };
            },
        );
    }

    /// Depth, which is plain, and the lanes at which it is good enough.
    #[inline(always)]
    fn depth(&mut self, plain: &Plain, out: &mut [f32; BLOCK]) -> u16 {
        let (simd, middle) = (self.walker.simd, self.middle());
        let on_row = OnRow::of(&plain.numerator, self.walker.place.v);
        if on_row.at(middle).abs() < least_for_depth(plain) {
            return self.walker.plain(plain, out);
        }
        clamped(simd, on_row.lanes(simd, middle, true), plain.range).store_array(out);
        u16::MAX
    }

    /// The attributes of a wide polygon, each by itself.
    #[inline(always)]
    fn each_attribute(&mut self, span: Option<&Span>, mask: u16, lanes: &mut LaneMemory) {
        self.walker.need_attributes(lanes);
        let (simd, middle, v) = (self.walker.simd, self.middle(), self.walker.place.v);
        let gradients = &self.walker.polygon.gradients;
        let q_step = gradients.unit_q.x;
        let q_row = OnRow::of(&gradients.unit_q, v);
        let q = q_row.at(middle);
        let by_row = q_step == 0.0;
        let r = if gradients.divides && !by_row {
            Narrow::splat(simd, 1.0) / q_row.lanes(simd, middle, q >= least_for_q(q_step))
        } else {
            Narrow::splat(simd, 1.0)
        };
        let mut others = false;
        for (field, out) in gradients.attributes.iter().zip(lanes.iter_mut()) {
            let Field::Plain(plain) = field else {
                others |= !matches!(field, Field::Constant(_));
                continue;
            };
            let on_row = OnRow::of(&plain.numerator, v);
            let (on_row, near) = if !plain.over_w {
                (on_row, always_near(plain))
            } else if by_row {
                (on_row.times(1.0 / q), q >= least_for_row(plain))
            } else {
                (on_row, q >= least_for_numerator(plain, q_step))
            };
            let near = near && on_row.at(middle).abs() > near_zero_up_to(plain, on_row.step);
            let value = on_row.lanes(simd, middle, near);
            let value = if plain.over_w && !by_row { value * r } else { value };
            clamped(simd, value, plain.range).store_array(out);
        }
        if others {
            self.walker.evaluate_others(span, mask, lanes);
        }
    }
}

/// See [`clamp_numbers`].
#[inline(always)]
fn clamped<S: Simd>(simd: S, value: Narrow<S>, [low, high]: [f32; 2]) -> Narrow<S> {
    clamp_numbers(value, Narrow::splat(simd, low), Narrow::splat(simd, high))
}

impl<S: Simd> Values for AlongSpans<'_, S> {
    fn evaluate(
        &mut self,
        quantity: Quantity,
        span: Option<&Span>,
        mask: u16,
        out: &mut [f32; BLOCK],
    ) {
        let simd = self.walker.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                let field = self.walker.polygon.gradients.field(quantity).copied();
                let by_blocks = !self.short && quantity == Quantity::Depth;
                let Some(Field::Plain(plain)) = field.filter(|_| by_blocks) else {
                    return self.walker.evaluate(quantity, span, mask, out);
                };
                let doubtful = mask & !self.depth(&plain, out);
                if doubtful != 0 {
                    self.walker.polygon.settle_lanes(quantity, span, doubtful, out);
                }
            },
        );
    }

    #[inline(always)]
    fn attribute_count(&self) -> usize {
        self.walker.attribute_count()
    }

    fn evaluate_attributes(&mut self, span: Option<&Span>, mask: u16, lanes: &mut LaneMemory) {
        let simd = self.walker.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                if self.short {
                    self.walker.evaluate_attributes(span, mask, lanes);
                } else {
                    self.each_attribute(span, mask, lanes);
                }
            },
        );
    }
}
