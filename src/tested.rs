//! What the depth test compares, along rows: prepared once for a polygon, and for each row once more.
//!
//! By blocks (see [`along`](crate::along)), or, where it is strict, by the quick test of
//! [`doubt`](crate::doubt).

use fearless_simd::{Simd, SimdBase, SimdMask, f64x4};

use crate::along::{
    AHEAD, MIDDLE, Middles, OnRow, least_for_depth, middles_from, off_middle, steps_off_middle,
};
use crate::doubt::Doubt;
use crate::gradient::frame::Linear;
use crate::gradient::{Field, Gradients, Quantity};
use crate::lanes::{Narrow, Ties, Wide, clamp_numbers};

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
        /// From here on lanes are near each other.
        near: f64,
        /// Below this a value has yet to be found.
        doubtful_below: f64,
    },
    /// Each lane by itself: 1/w has to scale with w, down to where `f32` holds no small part of it.
    Each,
    /// A block in whose middle it is less than `least` is undecided.
    Strict { steps_off_middle: Wide<S>, least: f64 },
}

/// What is tested in the middles of [`AHEAD`] blocks: what is plain in two `f32`s, what is strict in a `f64`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ahead {
    pub(crate) middles: Middles,
    values: [f64; AHEAD],
}

impl<S: Simd> Tested<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, gradients: &Gradients, quantity: Quantity) -> Option<Self> {
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
                let kind =
                    Kind::Plain { off_middle, within, near, doubtful_below: plain.doubtful_below };
                (function, plain.range, kind)
            }
            Field::Strict(strict) if !strict.over_w => {
                let doubt = Doubt::of_scaled(strict, gradients.det_relative_error)?;
                let function = strict.numerator.scaled(strict.scale);
                let least = doubt.least_of_scaled() + MIDDLE * function.x.abs();
                let steps_off_middle = steps_off_middle(simd, function.x);
                (function, strict.range, Kind::Strict { steps_off_middle, least })
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

    /// Goes to the row `v` from the anchor.
    #[inline(always)]
    pub(crate) fn seek(&mut self, v: f64) {
        self.on_row = OnRow::of(&self.function, v);
        self.q_on_row = OnRow::of(&self.q, v);
    }

    /// What is tested in the middles of the block around `middle` and the next ones, and in how many
    /// of them it can be used.
    #[inline(always)]
    pub(crate) fn look_ahead(&self, simd: S, middle: f64) -> (Ahead, usize) {
        let middles = middles_from(simd, middle);
        let values = self.on_row.at_all(simd, middles);
        let mut ahead = Ahead { middles: Middles::none(), values: [0.0; AHEAD] };
        let good = if let Kind::Plain { within, .. } = self.kind {
            ahead.middles = Middles::of(values);
            let [low, high] = within.map(|end| f64x4::splat(simd, end));
            values.simd_ge(low) & values.simd_le(high)
        } else {
            values.store_array(&mut ahead.values);
            let q = self.q_on_row.at_all(simd, middles);
            let least = self.least_q + MIDDLE * self.q_on_row.step.abs();
            q.simd_ge(f64x4::splat(simd, least))
        };
        (ahead, good.to_bitmask().trailing_ones() as usize)
    }

    /// What is tested around `middle`: each lane by itself if spans are `short` or the lanes are not near
    /// each other, else by its block. Nothing where it cannot be used; and the lanes that are undecided.
    #[inline(always)]
    pub(crate) fn find_one(&self, simd: S, middle: f64, short: bool) -> Option<(Narrow<S>, u16)> {
        match self.kind {
            Kind::Plain { off_middle, near, doubtful_below, .. } => {
                let is_near = self.on_row.at(middle).abs() >= near;
                if is_near && !short {
                    let value = self.on_row.near(simd, middle, off_middle);
                    return Some((clamp_numbers(value, self.low, self.high), 0));
                }
                let value = self.on_row.wide(simd, middle);
                let mut undecided = 0;
                if !is_near && doubtful_below > 0.0 {
                    undecided = value.abs().below(Wide::splat(simd, doubtful_below));
                }
                Some((clamp_numbers(value.narrow(), self.low, self.high), undecided))
            }
            Kind::Each => Some((self.each(simd, middle), 0)),
            Kind::Strict { steps_off_middle, least } => {
                let q = self.q_on_row;
                let is_good = q.at(middle) >= self.least_q + MIDDLE * q.step.abs();
                let at_middle = self.on_row.at(middle);
                is_good.then(|| self.strict(simd, at_middle, steps_off_middle, least))
            }
        }
    }

    /// What each lane is off the middle, if that and the middles are all that it takes.
    #[inline(always)]
    pub(crate) fn off_middle(&self) -> Option<Narrow<S>> {
        if let Kind::Plain { off_middle, .. } = self.kind { Some(off_middle) } else { None }
    }

    /// What is tested in block `i` of those, around `middle`; and the lanes that are undecided.
    #[inline(always)]
    pub(crate) fn lanes(&self, simd: S, ahead: &Ahead, i: usize, middle: f64) -> (Narrow<S>, u16) {
        match self.kind {
            Kind::Plain { off_middle, .. } => (ahead.middles.lanes(simd, i, off_middle), 0),
            Kind::Each => (self.each(simd, middle), 0),
            Kind::Strict { steps_off_middle, least } => {
                self.strict(simd, ahead.values[i % AHEAD], steps_off_middle, least)
            }
        }
    }

    #[inline(always)]
    fn each(&self, simd: S, middle: f64) -> Narrow<S> {
        clamp_numbers(self.on_row.wide(simd, middle).narrow(), self.low, self.high)
    }

    #[inline(always)]
    fn strict(
        &self,
        simd: S,
        at_middle: f64,
        steps_off_middle: Wide<S>,
        least: f64,
    ) -> (Narrow<S>, u16) {
        let value = Wide::splat(simd, at_middle) + steps_off_middle;
        let is_near_tie = Ties::none(simd).and(simd, value).any(simd);
        let is_decided = at_middle.abs() >= least && !is_near_tie;
        let value = value.narrow().max(self.low).min(self.high);
        (value, if is_decided { 0 } else { u16::MAX })
    }
}
