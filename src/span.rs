//! The X loop: from places in the framebuffer to blocks of values.
//!
//! A block is 16 pixels of one row, or a patch; a value is a function of its
//! pixel alone, so that neither blocks nor the number of lanes at a time can change a bit. A
//! pixel costs the common denominator Q and one reciprocal, and for each attribute a numerator
//! and a multiplication; none where 1/w does not change.
//!
//! `Fast` rounds numerator and denominator to `f32` and divides those: four roundings. `Exact`,
//! and `Fast` where the set-up's bounds ask for it, divides in `f64` with a bound of the error,
//! and looks whether both ends of the bound round to the same `f32` (Ziv's test): then that is
//! the correctly rounded value, else exact arithmetic finds it. docs/precision.md, "The X loop",
//! derives the bounds.

use fearless_simd::{Simd, SimdBase};

use crate::aligned::LaneMemory;
use crate::edge::Span;
use crate::gradient::frame::{Linear, U};
use crate::gradient::{
    CERTAIN, ConstantAlong, Field, Gradients, Plain, QUOTIENT_ROOM, Quantity, SUM_ERROR, Strict,
    nearest_f32,
};
use crate::lanes::{Narrow, Wide, clamp_numbers};
use crate::patch::{COLUMNS, LANE_ROWS, Patch};
use crate::settle::Walked;
use crate::shade::BLOCK;

/// t = D scale / Q: two conversions, a reciprocal and two products, relatively.
const QUOTIENT_ERROR: f64 = 5.0 * U;

/// Where the lanes of a block are.
pub(crate) trait Place<S: Simd>: Copy {
    /// What the lanes of a row have in common is computed once.
    fn linear(self, simd: S, function: Linear) -> Wide<S>;

    /// 1/Q in `f32`, where Q does not change along a row.
    fn reciprocals_of_rows(self, simd: S, q: Linear) -> Narrow<S>;
}

/// Lanes of one row, as offsets from the anchor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InRow {
    /// Of the first lane.
    pub(crate) u: f64,
    pub(crate) v: f64,
}

impl<S: Simd> Place<S> for InRow {
    #[inline(always)]
    fn linear(self, simd: S, function: Linear) -> Wide<S> {
        let us = Wide::count_from(simd, self.u);
        Wide::splat(simd, function.row(self.v)) + Wide::splat(simd, function.x) * us
    }

    #[inline(always)]
    fn reciprocals_of_rows(self, simd: S, q: Linear) -> Narrow<S> {
        Narrow::splat(simd, 1.0 / nearest_f32(q.row(self.v)))
    }
}

/// Lanes anywhere, as offsets from the anchor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InPatch<S: Simd> {
    us: Wide<S>,
    vs: Wide<S>,
}

impl<S: Simd> InPatch<S> {
    /// The lanes of `patch`.
    #[inline(always)]
    pub(crate) fn new(simd: S, patch: Patch, [anchor_x, anchor_y]: [i32; 2]) -> Self {
        let columns = usize::from(patch.columns);
        let (u, v) = (patch.first[0] - anchor_x, patch.first[1] - anchor_y);
        Self {
            us: Wide::load(simd, &COLUMNS[columns]) + Wide::splat(simd, f64::from(u)),
            vs: Wide::load(simd, &LANE_ROWS[columns]) + Wide::splat(simd, f64::from(v)),
        }
    }

    /// The lanes of `patch`, of which there are `LANES` at most; of a half those of the first half, twice: what is
    /// computed from them is computed once.
    #[inline(always)]
    pub(crate) fn of<const LANES: usize>(simd: S, patch: Patch, anchor: [i32; 2]) -> Self {
        let Self { us, vs } = Self::new(simd, patch, anchor);
        match LANES {
            ..=8 => Self { us: us.first_half(), vs: vs.first_half() },
            _ => Self { us, vs },
        }
    }

    /// `function` at the lanes.
    #[inline(always)]
    pub(crate) fn at(self, simd: S, function: Linear) -> Wide<S> {
        let row = Wide::splat(simd, function.c) + Wide::splat(simd, function.y) * self.vs;
        row + Wide::splat(simd, function.x) * self.us
    }
}

impl<S: Simd> Place<S> for InPatch<S> {
    #[inline(always)]
    fn linear(self, simd: S, function: Linear) -> Wide<S> {
        self.at(simd, function)
    }

    #[inline(always)]
    fn reciprocals_of_rows(self, simd: S, q: Linear) -> Narrow<S> {
        reciprocal(simd, self.linear(simd, q).narrow())
    }
}

/// See [`clamp_numbers`].
#[inline(always)]
fn clamped<S: Simd>(simd: S, value: Narrow<S>, [low, high]: [f32; 2]) -> Narrow<S> {
    clamp_numbers(value, Narrow::splat(simd, low), Narrow::splat(simd, high))
}

#[inline(always)]
fn reciprocal<S: Simd>(simd: S, q: Narrow<S>) -> Narrow<S> {
    Narrow::splat(simd, 1.0) / q
}

/// 1/Q for strict quantities.
#[derive(Clone, Copy, Debug)]
struct StrictReciprocals<S: Simd> {
    r: Wide<S>,
    /// What an error in D is worth, and one in the quotient: both with room for what first order
    /// leaves out.
    by_numerator: Wide<S>,
    by_quotient: Wide<S>,
    /// Lanes at which 1/w is surely positive, and the error small.
    certain: u16,
    /// Are they this block's?
    found: bool,
}

impl<S: Simd> StrictReciprocals<S> {
    #[inline(always)]
    fn none(simd: S) -> Self {
        let zero = Wide::splat(simd, 0.0);
        Self { r: zero, by_numerator: zero, by_quotient: zero, certain: 0, found: false }
    }

    #[inline(always)]
    fn find(&mut self, simd: S, gradients: &Gradients, place: impl Place<S>) {
        if self.found {
            return;
        }
        let r = place.linear(simd, gradients.q).reciprocal(simd);
        let by_numerator = r.abs() * Wide::splat(simd, QUOTIENT_ROOM);
        let relative_error = Wide::splat(simd, gradients.q_error) * r.abs();
        let positive = Wide::splat(simd, 0.0).below(r * Wide::splat(simd, gradients.q_sign));
        // Neither holds for what is no number.
        let certain = positive & relative_error.below(Wide::splat(simd, CERTAIN));
        let by_quotient = relative_error * Wide::splat(simd, QUOTIENT_ROOM)
            + Wide::splat(simd, QUOTIENT_ERROR * QUOTIENT_ROOM + SUM_ERROR);
        *self = Self { r, by_numerator, by_quotient, certain, found: true };
    }
}

/// What is found at the pixels of a block.
pub(crate) trait Values {
    /// The values of `quantity` at the lanes of `mask`, clamped to its range. `span` is where
    /// they lie, unless they lie in a patch.
    fn evaluate(
        &mut self,
        quantity: Quantity,
        span: Option<&Span>,
        mask: u16,
        out: &mut [f32; BLOCK],
    );

    /// The number of attributes, once they are set up; 0 before.
    fn attribute_count(&self) -> usize;

    /// The values of all attributes, as [`evaluate`](Self::evaluate) does. They are set up for the
    /// polygon's first pixel, and those that are constant filled in.
    fn evaluate_attributes(&mut self, span: Option<&Span>, mask: u16, lanes: &mut LaneMemory);
}

/// Finds the values of a polygon's quantities, block by block.
pub(crate) struct Walker<'a, S: Simd, P> {
    pub(crate) simd: S,
    pub(crate) polygon: Walked<'a>,
    pub(crate) place: P,
    /// 1/Q in `f32`, for plain quantities, and whether it is this block's.
    reciprocals: Narrow<S>,
    has_reciprocals: bool,
    /// Does a block of a row have those of the one before?
    along_row: bool,
    strict: StrictReciprocals<S>,
}

impl<'a, S: Simd> Walker<'a, S, InRow> {
    /// To go along spans.
    #[inline(always)]
    pub(crate) fn along_spans(simd: S, polygon: Walked<'a>) -> Self {
        Self::new(simd, polygon, InRow { u: 0.0, v: 0.0 })
    }

    /// Goes to the 16 pixels from framebuffer column `x` of row `y` on.
    #[inline(always)]
    pub(crate) fn seek(&mut self, x: i32, y: i32) {
        let polygon = &mut self.polygon;
        let [anchor_x, anchor_y] = polygon.gradients.anchor.pixel;
        let (u, v) = (x - anchor_x, y - anchor_y);
        // What was found for another block may hold for this one.
        let constant = polygon.gradients.constant;
        self.keep_reciprocals_if(match constant {
            ConstantAlong::Polygon => true,
            ConstantAlong::Row => self.polygon.v == v,
            ConstantAlong::Column => self.polygon.u == u,
            ConstantAlong::Nothing => false,
        });
        (self.polygon.u, self.polygon.v) = (u, v);
        self.place = InRow { u: f64::from(u), v: f64::from(v) };
    }

    /// Goes to the right by so many blocks.
    #[inline(always)]
    pub(crate) fn advance(&mut self, blocks: i32) {
        self.keep_reciprocals_if(self.along_row);
        self.polygon.u += 16 * blocks;
        self.place.u += f64::from(16 * blocks);
    }
}

impl<'a, S: Simd> Walker<'a, S, InPatch<S>> {
    /// To go from patch to patch.
    #[inline(always)]
    pub(crate) fn over_patches(simd: S, polygon: Walked<'a>) -> Self {
        let zero = Wide::splat(simd, 0.0);
        Self::new(simd, polygon, InPatch { us: zero, vs: zero })
    }

    /// Goes to `patch`.
    #[inline(always)]
    pub(crate) fn seek(&mut self, patch: Patch) {
        let (simd, polygon) = (self.simd, &mut self.polygon);
        let [anchor_x, anchor_y] = polygon.gradients.anchor.pixel;
        let (u, v) = (patch.first[0] - anchor_x, patch.first[1] - anchor_y);
        let same = polygon.gradients.constant == ConstantAlong::Polygon;
        (polygon.u, polygon.v, polygon.columns) = (u, v, patch.columns);
        self.place = InPatch::new(simd, patch, [anchor_x, anchor_y]);
        self.keep_reciprocals_if(same);
    }
}

impl<'a, S: Simd, P: Place<S>> Walker<'a, S, P> {
    #[inline(always)]
    fn new(simd: S, polygon: Walked<'a>, place: P) -> Self {
        let reciprocals = Narrow::splat(simd, 0.0);
        let strict = StrictReciprocals::none(simd);
        let constant = polygon.gradients.constant;
        let along_row = matches!(constant, ConstantAlong::Polygon | ConstantAlong::Row);
        Self { simd, polygon, place, reciprocals, has_reciprocals: false, along_row, strict }
    }

    /// Values that exact arithmetic found.
    #[inline(always)]
    pub(crate) fn exact_values(&self) -> u64 {
        self.polygon.exact_values
    }

    #[inline(always)]
    fn keep_reciprocals_if(&mut self, same: bool) {
        if !same {
            (self.has_reciprocals, self.strict.found) = (false, false);
        }
    }

    /// Sets the attributes up, if they have not been.
    #[inline(always)]
    pub(crate) fn need_attributes(&mut self, lanes: &mut LaneMemory) {
        if !self.polygon.gradients.has_attributes {
            self.polygon.set_attributes(self.simd.level(), lanes);
        }
    }

    /// Sets the attributes up, if they have not been. Does any of them run across spans?
    #[inline(always)]
    pub(crate) fn needs_spans(&mut self, lanes: &mut LaneMemory) -> bool {
        self.need_attributes(lanes);
        let fields = &self.polygon.gradients.attributes;
        fields.iter().any(|field| matches!(field, Field::Across(..)))
    }

    /// The attributes that are neither plain nor constant.
    #[inline(always)]
    pub(crate) fn evaluate_others(
        &mut self,
        span: Option<&Span>,
        mask: u16,
        lanes: &mut [[f32; BLOCK]],
    ) {
        for (k, out) in lanes.iter_mut().enumerate() {
            let field = self.polygon.gradients.attributes.get(k);
            if matches!(field, Some(Field::Strict(_) | Field::Across(..))) {
                self.evaluate(Quantity::Attribute(k), span, mask, out);
            }
        }
    }

    /// N r or N, and the lanes at which it is good enough.
    #[inline(always)]
    pub(crate) fn plain(&mut self, plain: &Plain, out: &mut [f32; BLOCK]) -> u16 {
        let n = self.place.linear(self.simd, plain.numerator);
        let value = n.narrow();
        let value = if plain.over_w { value * self.reciprocals() } else { value };
        clamped(self.simd, value, plain.range).store_array(out);
        if plain.doubtful_below > 0.0 {
            return !n.abs().below(Wide::splat(self.simd, plain.doubtful_below));
        }
        u16::MAX
    }

    /// This block's reciprocals in `f32`.
    #[inline(always)]
    fn reciprocals(&mut self) -> Narrow<S> {
        if !self.has_reciprocals {
            self.has_reciprocals = true;
            let (simd, q) = (self.simd, self.polygon.gradients.unit_q);
            self.reciprocals = if q.x == 0.0 {
                self.place.reciprocals_of_rows(simd, q)
            } else {
                reciprocal(simd, self.place.linear(simd, q).narrow())
            };
        }
        self.reciprocals
    }
}

impl<S: Simd, P: Place<S>> Values for Walker<'_, S, P> {
    #[inline(always)]
    fn evaluate(
        &mut self,
        quantity: Quantity,
        span: Option<&Span>,
        mask: u16,
        out: &mut [f32; BLOCK],
    ) {
        let Some(Field::Plain(plain)) = self.polygon.gradients.field(quantity) else {
            // Out of line, but compiled for the instruction set.
            let Self { simd, polygon, place, strict, .. } = self;
            return simd.vectorize(
                #[inline(always)]
                || evaluate_field(*simd, polygon, *place, strict, quantity, span, mask, out),
            );
        };
        let plain = *plain;
        let certain = self.plain(&plain, out);
        if mask & !certain != 0 {
            self.polygon.settle_lanes(quantity, span, mask & !certain, out);
        }
    }

    #[inline(always)]
    fn attribute_count(&self) -> usize {
        let gradients = &self.polygon.gradients;
        if gradients.has_attributes { gradients.attributes.len() } else { 0 }
    }

    #[inline(always)]
    fn evaluate_attributes(&mut self, span: Option<&Span>, mask: u16, lanes: &mut LaneMemory) {
        self.need_attributes(lanes);
        let (simd, place) = (self.simd, self.place);
        let divides = self.polygon.gradients.divides;
        let r = if divides { self.reciprocals() } else { self.reciprocals };
        let mut others = false;
        for (field, out) in self.polygon.gradients.attributes.iter().zip(lanes.iter_mut()) {
            match field {
                Field::Plain(plain) => {
                    let n = place.linear(simd, plain.numerator).narrow();
                    let value = if plain.over_w { n * r } else { n };
                    clamped(simd, value, plain.range).store_array(out);
                }
                Field::Constant(_) => {}
                Field::Strict(_) | Field::Across(..) => others = true,
            }
        }
        if others {
            self.evaluate_others(span, mask, lanes);
        }
    }
}

/// The values of a quantity that is not plain.
#[expect(clippy::too_many_arguments, reason = "the walker's parts: it stays in registers itself")]
#[inline(always)]
fn evaluate_field<S: Simd>(
    simd: S,
    polygon: &mut Walked<'_>,
    place: impl Place<S>,
    reciprocals: &mut StrictReciprocals<S>,
    quantity: Quantity,
    span: Option<&Span>,
    mask: u16,
    out: &mut [f32; BLOCK],
) {
    let certain = match polygon.gradients.field(quantity) {
        Some(Field::Strict(strict)) => {
            reciprocals.find(simd, polygon.gradients, place);
            let d = place.linear(simd, strict.numerator);
            evaluate_strict(simd, d, strict, reciprocals, polygon.gradients, out)
        }
        Some(Field::Constant(value)) => {
            *out = [*value; BLOCK];
            return;
        }
        Some(Field::Across(carried, range)) => {
            let (carried, range) = (*carried, *range);
            polygon.across(simd, carried, range, span, out)
        }
        Some(Field::Plain(_)) | None => return,
    };
    if mask & !certain != 0 {
        polygon.settle_lanes(quantity, span, mask & !certain, out);
    }
}

/// base + `d` r, and the lanes at which it is surely rounded right.
#[inline(always)]
fn evaluate_strict<S: Simd>(
    simd: S,
    d: Wide<S>,
    strict: &Strict,
    reciprocals: &StrictReciprocals<S>,
    gradients: &Gradients,
    out: &mut [f32; BLOCK],
) -> u16 {
    let (r, error, by_quotient) = if strict.over_w {
        let error = Wide::splat(simd, strict.error) * reciprocals.by_numerator;
        (reciprocals.r, error, reciprocals.by_quotient)
    } else {
        let relative = gradients.det_relative_error + QUOTIENT_ERROR;
        let by_quotient = relative * QUOTIENT_ROOM + SUM_ERROR;
        let error = Wide::splat(simd, strict.error * QUOTIENT_ROOM);
        (Wide::splat(simd, strict.scale), error, Wide::splat(simd, by_quotient))
    };
    let t = d * r;
    let value = t + Wide::splat(simd, strict.base);
    // The last sum's part goes by |t| + |base|, which is no less than |value|.
    let error = error + t.abs() * by_quotient + Wide::splat(simd, strict.base.abs() * SUM_ERROR);
    // No zero here is negative: base is none.
    let (rounded, certain) = value.round_within(error, strict.range);
    rounded.store_array(out);
    // Where the bound is no number, so is all that comes of it.
    let bounded = if strict.error < f64::INFINITY { u16::MAX } else { 0 };
    certain & reciprocals.certain & bounded
}
