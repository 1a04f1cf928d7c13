//! Walking along spans: what a polygon's rows and blocks have in common is computed once.
//!
//! Plain quantities of polygons that are wider than a block go by blocks (see
//! [`along`](crate::along)). What all blocks of a polygon need is prepared, if they have enough in
//! common; else each is looked at by itself, with the same operations on the same numbers. What is
//! not plain, and narrow polygons, go the walker's way.

use alloc::vec::Vec;

use fearless_simd::{Simd, SimdBase, SimdMask, f64x4, mask32x16};

use crate::along::{
    AHEAD, MIDDLE, Middles, OnRow, always_near, least_for_depth, least_for_numerator, least_for_q,
    least_for_row, middles_from, off_middle,
};
use crate::doubt::{Doubt, LARGEST_Q};
use crate::edge::Span;
use crate::gradient::frame::Linear;
use crate::gradient::{Field, Gradients, Plain, Quantity, Strict};
use crate::lanes::{Narrow, Wide, WideMask, bits_of, clamp_numbers};
use crate::settle::Walked;
use crate::shade::BLOCK;
use crate::span::{InRow, Values, Walker};

/// Q and the numerators of so many attributes, less one, are prepared; of polygons with more, none
/// is.
pub(crate) const FUNCTIONS: usize = 8;

/// Its bits.
const NEGATIVE_ZERO: u32 = (-0.0_f32).to_bits();

/// What the depth test compares.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tested<S: Simd> {
    function: Linear,
    on_row: OnRow,
    /// For what is strict: Q, and what it must be.
    q: Linear,
    q_on_row: OnRow,
    least_q: f64,
    kind: Kind<S>,
    low: Narrow<S>,
    high: Narrow<S>,
}

/// How what is tested is found.
#[derive(Clone, Copy, Debug)]
enum Kind<S: Simd> {
    Plain {
        off_middle: Narrow<S>,
        /// Where the middle is within these, all lanes are near each other, and none needs to be
        /// clamped.
        within: [f64; 2],
    },
    /// Each lane by itself: 1/w has to scale with w, down to where `f32` holds no small part of it.
    Each,
    /// Times so much; what is less than `least` is undecided.
    Strict { scale: f64, least: f32 },
}

impl<S: Simd> Tested<S> {
    #[inline(always)]
    fn new(simd: S, gradients: &Gradients, quantity: Quantity) -> Option<Self> {
        let (function, range, kind) = match gradients.field(quantity)? {
            Field::Plain(plain) if quantity == Quantity::InvW => {
                (plain.numerator, plain.range, Kind::Each)
            }
            Field::Plain(plain) => {
                // Room for what rounds.
                const ROOM: f64 = 1.0 / 1_048_576.0;
                let function = plain.numerator;
                let [low, high] = plain.range.map(f64::from);
                let reach = MIDDLE * function.x.abs() + high * ROOM;
                let (near, inside) = (least_for_depth(plain), low + reach);
                let within = [if near > inside { near } else { inside }, high - reach];
                let off_middle = off_middle(simd, function.x);
                (function, plain.range, Kind::Plain { off_middle, within })
            }
            Field::Strict(strict) if !strict.over_w => {
                let least = Doubt::of_scaled(strict, gradients.det_relative_error)?.least(0.0);
                let kind = Kind::Strict { scale: strict.scale, least };
                (strict.numerator, strict.range, kind)
            }
            _ => return None,
        };
        let [low, high] = range.map(|end| Narrow::splat(simd, end));
        let (q, least_q) = match kind {
            Kind::Strict { .. } => (gradients.unit_q, Doubt::least_q(gradients)?),
            _ => (Linear::default(), 0.0),
        };
        let (on_row, q_on_row) = (OnRow::of(&function, 0.0), OnRow::of(&q, 0.0));
        Some(Self { function, on_row, q, q_on_row, least_q, kind, low, high })
    }

    /// What is tested in the middles of the block around `middle` and the next ones, and in how many
    /// of them it can be used.
    #[inline(always)]
    pub(crate) fn look_ahead(&self, simd: S, middle: f64) -> (Middles, usize) {
        let middles = middles_from(simd, middle);
        let Kind::Plain { within, .. } = self.kind else {
            let q = self.q_on_row.at_all(simd, middles);
            let least = self.least_q + MIDDLE * self.q_on_row.step.abs();
            let good = q.simd_ge(f64x4::splat(simd, least));
            return (Middles::none(), good.to_bitmask().trailing_ones() as usize);
        };
        let values = self.on_row.at_all(simd, middles);
        let [low, high] = within.map(|end| f64x4::splat(simd, end));
        let good = values.simd_ge(low) & values.simd_le(high);
        (Middles::of(values), good.to_bitmask().trailing_ones() as usize)
    }

    /// For [`Middles::lanes`], if that is all.
    #[inline(always)]
    pub(crate) fn off_middle(&self) -> Option<Narrow<S>> {
        if let Kind::Plain { off_middle, .. } = self.kind { Some(off_middle) } else { None }
    }

    /// What is tested in block `i` of those, around `middle`; and the lanes that are undecided.
    #[inline(always)]
    pub(crate) fn lanes(
        &self,
        simd: S,
        ahead: &Middles,
        i: usize,
        middle: f64,
    ) -> (Narrow<S>, u16) {
        match self.kind {
            Kind::Plain { off_middle, .. } => (ahead.lanes(simd, i, off_middle), 0),
            Kind::Each => {
                let value = self.on_row.wide(simd, middle).narrow();
                (clamp_numbers(value, self.low, self.high), 0)
            }
            Kind::Strict { scale, least } => {
                let value = self.on_row.wide(simd, middle) * Wide::splat(simd, scale);
                let rounded = value.narrow();
                let decided = rounded.abs().simd_ge(Narrow::splat(simd, least));
                let undecided = value.near_tie(simd).bits() | !bits_of(simd, decided);
                (rounded.max(self.low).min(self.high), undecided)
            }
        }
    }
}

/// How numerators become values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Divided {
    /// They are values.
    Not,
    /// Once for each row, in `f64`.
    ByRow,
    ByLane,
}

/// The attributes of a polygon, if all are plain or constant, and all or none over w.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prepared<S: Simd> {
    divided: Divided,
    /// Q, and the numerators; as coefficients, and on the row.
    functions: [Linear; FUNCTIONS],
    starts: [f64; FUNCTIONS],
    steps: [f64; FUNCTIONS],
    off_middle: [Narrow<S>; FUNCTIONS],
    low: [Narrow<S>; FUNCTIONS],
    high: [Narrow<S>; FUNCTIONS],
    /// What Q must be in a block's middle.
    least_q: f64,
    /// Are all constant? They were filled in.
    filled: bool,
    /// What strict attributes have beside; nothing of it is for plain ones.
    strict: bool,
    bases: [f64; FUNCTIONS],
    doubts: [Doubt; FUNCTIONS],
    /// 1/Q or 1/det, unless it differs from lane to lane.
    r: f64,
}

impl<S: Simd> Prepared<S> {
    #[inline(always)]
    fn none(simd: S) -> Self {
        let zeros = [Narrow::splat(simd, 0.0); FUNCTIONS];
        Self {
            divided: Divided::Not,
            functions: [Linear::default(); FUNCTIONS],
            starts: [0.0; FUNCTIONS],
            steps: [0.0; FUNCTIONS],
            off_middle: zeros,
            low: zeros,
            high: zeros,
            least_q: 0.0,
            filled: false,
            strict: false,
            bases: [0.0; FUNCTIONS],
            doubts: [Doubt::default(); FUNCTIONS],
            r: 1.0,
        }
    }

    /// Prepares the polygon's attributes, if they can be.
    #[inline(always)]
    fn set(&mut self, simd: S, gradients: &Gradients) -> bool {
        let (fields, q) = (&gradients.attributes, &gradients.unit_q);
        if fields.len() >= FUNCTIONS {
            return false;
        }
        let over_w = |field: &Field| match field {
            Field::Plain(plain) => plain.over_w,
            Field::Strict(strict) => strict.over_w,
            _ => false,
        };
        let over_w = fields.iter().any(over_w);
        self.filled = fields.iter().all(|field| matches!(field, Field::Constant(_)));
        self.strict = fields.iter().any(|field| matches!(field, Field::Strict(_)));
        self.divided = match (over_w, q.x == 0.0) {
            (false, _) => Divided::Not,
            (true, true) => Divided::ByRow,
            (true, false) => Divided::ByLane,
        };
        self.least_q = match (self.strict, self.divided) {
            (false, Divided::Not) => f64::NEG_INFINITY,
            (false, _) => least_for_q(q.x),
            (true, _) => match Doubt::least_q(gradients) {
                Some(least) => least,
                None => return false,
            },
        };
        self.set_function(simd, 0, *q, [0.0; 2]);
        for (i, field) in (1..).zip(fields) {
            let set = match field {
                Field::Plain(plain) if plain.over_w == over_w && !self.strict => {
                    self.set_plain(simd, i, plain, q.x)
                }
                Field::Strict(strict) if strict.over_w == over_w => {
                    self.set_strict(simd, i, strict, gradients)
                }
                // It is clamped to its value.
                Field::Constant(value) if !value.is_nan() && value.to_bits() != NEGATIVE_ZERO => {
                    (self.bases[i], self.doubts[i]) = (0.0, Doubt::default());
                    self.set_function(simd, i, Linear::default(), [*value; 2]);
                    true
                }
                _ => false,
            };
            if !set {
                return false;
            }
        }
        true
    }

    #[inline(always)]
    fn set_plain(&mut self, simd: S, i: usize, plain: &Plain, q_step: f64) -> bool {
        self.set_function(simd, i, plain.numerator, plain.range);
        let least_q = match self.divided {
            Divided::Not if always_near(plain) => f64::NEG_INFINITY,
            Divided::Not => return false,
            Divided::ByRow => least_for_row(plain),
            Divided::ByLane => least_for_numerator(plain, q_step),
        };
        self.least_q = if least_q > self.least_q { least_q } else { self.least_q };
        true
    }

    #[inline(always)]
    fn set_strict(&mut self, simd: S, i: usize, strict: &Strict, gradients: &Gradients) -> bool {
        let doubt = if strict.over_w {
            Some(Doubt::of_quotient(strict, gradients))
        } else {
            self.r = strict.scale;
            Doubt::of_scaled(strict, gradients.det_relative_error)
        };
        let Some(doubt) = doubt else { return false };
        let scale = if strict.over_w { gradients.unit } else { 1.0 };
        self.set_function(simd, i, strict.numerator.scaled(scale), strict.range);
        (self.bases[i], self.doubts[i]) = (strict.base, doubt);
        true
    }

    #[inline(always)]
    fn set_function(&mut self, simd: S, i: usize, function: Linear, [low, high]: [f32; 2]) {
        self.functions[i] = function;
        self.steps[i] = function.x;
        if self.divided != Divided::ByRow && !self.strict {
            self.off_middle[i] = off_middle(simd, function.x);
        }
        (self.low[i], self.high[i]) = (Narrow::splat(simd, low), Narrow::splat(simd, high));
    }

    /// Goes to the row `v` from the anchor, with `count` attributes. Says whether the row is good.
    #[inline(always)]
    fn seek(&mut self, simd: S, count: usize, v: f64) -> bool {
        if self.filled {
            return true;
        }
        for i in 0..=count {
            self.starts[i] = self.functions[i].row(v);
        }
        if self.divided == Divided::ByRow {
            let q = self.starts[0];
            if q < self.least_q {
                return false;
            }
            let r = 1.0 / q;
            if self.strict {
                self.r = r;
                return true;
            }
            for i in 1..=count {
                let on_row = OnRow::of(&self.functions[i], v).times(r);
                (self.starts[i], self.steps[i]) = (on_row.start, on_row.step);
                self.off_middle[i] = off_middle(simd, on_row.step);
            }
        }
        true
    }

    /// The values of `count` attributes in the block around `middle` and the next ones: those of
    /// which any lane is set in `masks`. Returns how many are good. `lanes`: `count` for each.
    /// `undecided`: lanes whose values have yet to be found.
    #[inline(always)]
    pub(crate) fn find_some(
        &self,
        simd: S,
        count: usize,
        middle: f64,
        masks: &[u16],
        lanes: &mut [[f32; BLOCK]],
        undecided: &mut [u16; AHEAD],
    ) -> usize {
        if self.filled {
            return AHEAD;
        }
        if self.strict {
            return self.find_strict(simd, count, middle, masks, lanes, undecided);
        }
        let middles = middles_from(simd, middle);
        let values = |i: usize| self.on_row(i).at_all(simd, middles);
        let q = values(0);
        let good = q.simd_ge(f64x4::splat(simd, self.least_q));
        let mut ahead = [Middles::none(); FUNCTIONS];
        ahead[0] = Middles::of(q);
        for (i, ahead) in ahead.iter_mut().enumerate().skip(1).take(count) {
            *ahead = Middles::of(values(i));
        }
        for ((block, mask), lanes) in masks.iter().enumerate().zip(lanes.chunks_exact_mut(count)) {
            if *mask == 0 {
                continue;
            }
            let at = |i: usize| ahead[i].lanes(simd, block, self.off_middle[i]);
            let one = Narrow::splat(simd, 1.0);
            let r = if self.divided == Divided::ByLane { one / at(0) } else { one };
            for (i, lanes) in (1..FUNCTIONS).zip(lanes).take(count) {
                clamp_numbers(at(i) * r, self.low[i], self.high[i]).store_array(lanes);
            }
        }
        good.to_bitmask().trailing_ones() as usize
    }

    /// The same of strict attributes.
    #[inline(always)]
    fn find_strict(
        &self,
        simd: S,
        count: usize,
        middle: f64,
        masks: &[u16],
        lanes: &mut [[f32; BLOCK]],
        undecided: &mut [u16; AHEAD],
    ) -> usize {
        // The least Q of each block, where it is 1/w times something positive.
        let q = self.on_row(0).at_all(simd, middles_from(simd, middle));
        let least = q - f64x4::splat(simd, MIDDLE * self.steps[0].abs());
        let good = least.simd_ge(f64x4::splat(simd, self.least_q))
            & q.simd_lt(f64x4::splat(simd, LARGEST_Q));
        let mut greatest_r = [0.0; AHEAD];
        (f64x4::splat(simd, 1.0) / least).store_array(&mut greatest_r);
        for ((block, mask), lanes) in masks.iter().enumerate().zip(lanes.chunks_exact_mut(count)) {
            if *mask == 0 {
                continue;
            }
            let middle = middle + (block * BLOCK) as f64;
            let r = if self.divided == Divided::ByLane {
                self.on_row(0).wide(simd, middle).quick_reciprocal(simd)
            } else {
                Wide::splat(simd, self.r)
            };
            let mut near_tie = WideMask::none(simd);
            let mut large = mask32x16::splat(simd, true);
            for (i, lanes) in (1..FUNCTIONS).zip(lanes).take(count) {
                let d = self.on_row(i).wide(simd, middle);
                let value = d * r + Wide::splat(simd, self.bases[i]);
                near_tie = near_tie | value.near_tie(simd);
                let rounded = value.narrow();
                let least = self.doubts[i].least(greatest_r[block % AHEAD]);
                large = large & rounded.abs().simd_ge(Narrow::splat(simd, least));
                rounded.max(self.low[i]).min(self.high[i]).store_array(lanes);
            }
            undecided[block % AHEAD] = near_tie.bits() | !bits_of(simd, large);
        }
        good.to_bitmask().trailing_ones() as usize
    }

    #[inline(always)]
    fn on_row(&self, i: usize) -> OnRow {
        OnRow { start: self.starts[i], step: self.steps[i] }
    }

    /// How far the values of one block are from those of the one before.
    #[inline(always)]
    pub(crate) fn stride(&self, count: usize) -> usize {
        if self.filled { 0 } else { count }
    }
}

/// What is known of the attributes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Attributes {
    /// Nothing: no pixel has asked yet.
    Unknown,
    /// They are prepared, but for another row.
    Elsewhere,
    /// They are prepared, for this row.
    Here,
    /// They are prepared, but this row is not good.
    NotHere,
    /// They cannot be prepared.
    General,
}

/// Finds values along spans, block by block.
pub(crate) struct AlongSpans<'a, S: Simd> {
    walker: Walker<'a, S, InRow>,
    /// Is the polygon wider than a block?
    wide: bool,
    pub(crate) tested: Option<Tested<S>>,
    pub(crate) prepared: Prepared<S>,
    attributes: Attributes,
}

impl<'a, S: Simd> AlongSpans<'a, S> {
    /// `tested` is what the depth test will ask for.
    #[inline(always)]
    pub(crate) fn new(simd: S, polygon: Walked<'a>, tested: Option<Quantity>) -> Self {
        let [first, last] = polygon.subject.columns;
        let wide = last - first >= BLOCK as i32;
        let tested = tested.filter(|_| wide);
        let tested = tested.and_then(|quantity| Tested::new(simd, polygon.gradients, quantity));
        Self {
            walker: Walker::along_spans(simd, polygon),
            wide,
            tested,
            prepared: Prepared::none(simd),
            attributes: if wide { Attributes::Unknown } else { Attributes::General },
        }
    }

    /// Goes to the 16 pixels from framebuffer column `x` of row `y` on.
    #[inline(always)]
    pub(crate) fn seek(&mut self, [x, y]: [i32; 2]) {
        self.walker.seek(x, y);
        if let Some(tested) = &mut self.tested {
            let v = self.walker.place.v;
            (tested.on_row, tested.q_on_row) =
                (OnRow::of(&tested.function, v), OnRow::of(&tested.q, v));
        }
        if matches!(self.attributes, Attributes::Here | Attributes::NotHere) {
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

    /// The same for all attributes.
    #[inline(never)]
    pub(crate) fn decide_attributes(
        &mut self,
        blocks: i32,
        span: &Span,
        mask: u16,
        out: &mut [[f32; BLOCK]],
    ) {
        self.walker.advance(blocks);
        self.walker.evaluate_others(Some(span), mask, out);
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
    pub(crate) fn prepare(&mut self, lanes: &mut Vec<[f32; BLOCK]>) -> bool {
        if matches!(self.attributes, Attributes::Unknown | Attributes::Elsewhere) {
            self.prepare_row(lanes);
        }
        self.attributes == Attributes::Here
    }

    #[inline(always)]
    fn prepare_row(&mut self, lanes: &mut Vec<[f32; BLOCK]>) {
        let simd = self.walker.simd;
        if self.attributes == Attributes::Unknown {
            self.walker.need_attributes(lanes);
            if !self.prepared.set(simd, self.walker.polygon.gradients) {
                self.attributes = Attributes::General;
                return;
            }
            lanes.resize(AHEAD * self.attribute_count(), [0.0; BLOCK]);
        }
        let count = self.attribute_count();
        let good = self.prepared.seek(simd, count, self.walker.place.v);
        self.attributes = if good { Attributes::Here } else { Attributes::NotHere };
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
    fn each_attribute(&mut self, span: Option<&Span>, mask: u16, lanes: &mut Vec<[f32; BLOCK]>) {
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
            let value = if !plain.over_w {
                on_row.lanes(simd, middle, always_near(plain))
            } else if by_row {
                on_row.times(1.0 / q).lanes(simd, middle, q >= least_for_row(plain))
            } else {
                on_row.lanes(simd, middle, q >= least_for_numerator(plain, q_step)) * r
            };
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
                let by_blocks = self.wide && quantity == Quantity::Depth;
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

    fn evaluate_attributes(
        &mut self,
        span: Option<&Span>,
        mask: u16,
        lanes: &mut Vec<[f32; BLOCK]>,
    ) {
        let simd = self.walker.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                if self.wide {
                    self.each_attribute(span, mask, lanes);
                } else {
                    self.walker.evaluate_attributes(span, mask, lanes);
                }
            },
        );
    }
}
