//! What all blocks of a polygon have in common of its attributes: prepared once, and for each row
//! once more.
//!
//! Attributes that go by blocks (see [`along`](crate::along)), and strict ones by their quick test
//! (see [`doubt`](crate::doubt)): the same operations on the same numbers as where each block is
//! looked at by itself, or another way to values that are correctly rounded in either.

mod ahead;
mod strict;

use fearless_simd::{Simd, SimdBase, f64x4};

use crate::along::{
    AHEAD, MIDDLE, Middles, NEVER_NEAR_ZERO, OnRow, always_near, least_for_numerator, least_for_q,
    least_for_row, near_zero_of, near_zero_up_to, off_middle, steps_off_middle,
};
use crate::doubt::Doubt;
use crate::gradient::frame::Linear;
use crate::gradient::{Field, Gradients, Plain, nearest_f32};
use crate::lanes::{Narrow, Wide, clamp_numbers};
use crate::shade::BLOCK;
use crate::within::{Columns, inner_range};

/// Q and the numerators of so many attributes, less one, are prepared; of polygons with more, none
/// is.
pub(crate) const FUNCTIONS: usize = 12;

/// From the middle of the first of [`AHEAD`] blocks to the last lane of all.
const LAST_OF_ALL: f64 = (AHEAD * BLOCK) as f64 - MIDDLE - 1.0;

/// Its bits.
const NEGATIVE_ZERO: u32 = (-0.0_f32).to_bits();

/// Those of functions that are found together, four at a time.
#[derive(Clone, Copy, Debug, Default)]
struct Coefficients {
    x: [f64; FUNCTIONS],
    y: [f64; FUNCTIONS],
    c: [f64; FUNCTIONS],
}

/// So many functions are found together.
const FOUR: usize = 4;

impl Coefficients {
    #[inline(always)]
    fn set(&mut self, i: usize, Linear { x, y, c }: Linear) {
        (self.x[i], self.y[i], self.c[i]) = (x, y, c);
    }
}

/// `start` + `step` `u`, of the functions from `first` on.
#[inline(always)]
fn four_of<S: Simd>(
    simd: S,
    start: &[f64; FUNCTIONS],
    step: &[f64; FUNCTIONS],
    u: f64,
    first: usize,
) -> f64x4<S> {
    let four = first..first + FOUR;
    let (start, step) = (&start[four.clone()], &step[four]);
    f64x4::from_slice(simd, start) + f64x4::from_slice(simd, step) * f64x4::splat(simd, u)
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
    functions: Coefficients,
    starts: [f64; FUNCTIONS],
    steps: [f64; FUNCTIONS],
    off_middle: [Narrow<S>; FUNCTIONS],
    low: [Narrow<S>; FUNCTIONS],
    high: [Narrow<S>; FUNCTIONS],
    /// What Q must be in a block's middle for a function to go by the block; and the largest of these,
    /// or what Q must be at all for strict attributes.
    least: [f64; FUNCTIONS],
    least_q: f64,
    /// Up to which magnitude in a block's middle an attribute's numerator does not go by the block.
    near_zero: [f64; FUNCTIONS],
    /// Is there such a magnitude for any?
    meets_zero: bool,
    /// The values of an attribute that need not be clamped; and the columns of this row where none has to
    /// be.
    inner: [[f64; 2]; FUNCTIONS],
    unclamped: Columns,
    /// Are the polygon's spans short? Then each lane is found by itself.
    short: bool,
    /// Are all constant? They were filled in.
    filled: bool,
    /// What strict attributes have beside; nothing of it is for plain ones.
    strict: bool,
    steps_off_middle: [Wide<S>; FUNCTIONS],
    bases: [f64; FUNCTIONS],
    doubts: [Doubt; FUNCTIONS],
    /// 1/Q or 1/det, unless it differs from lane to lane.
    r: f64,
}

impl<S: Simd> Prepared<S> {
    #[inline(always)]
    pub(crate) fn none(simd: S) -> Self {
        let zeros = [Narrow::splat(simd, 0.0); FUNCTIONS];
        Self {
            divided: Divided::Not,
            functions: Coefficients::default(),
            starts: [0.0; FUNCTIONS],
            steps: [0.0; FUNCTIONS],
            off_middle: zeros,
            low: zeros,
            high: zeros,
            least: [0.0; FUNCTIONS],
            least_q: 0.0,
            near_zero: [NEVER_NEAR_ZERO; FUNCTIONS],
            meets_zero: false,
            inner: [[0.0; 2]; FUNCTIONS],
            unclamped: Columns::NONE,
            short: false,
            filled: false,
            strict: false,
            steps_off_middle: [Wide::splat(simd, 0.0); FUNCTIONS],
            bases: [0.0; FUNCTIONS],
            doubts: [Doubt::default(); FUNCTIONS],
            r: 1.0,
        }
    }

    /// Prepares the polygon's attributes, if they can be.
    #[inline(always)]
    pub(crate) fn set(&mut self, simd: S, gradients: &Gradients, short: bool) -> bool {
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
        self.short = short;
        self.divided = match (over_w, q.x == 0.0) {
            (false, _) => Divided::Not,
            (true, true) => Divided::ByRow,
            (true, false) => Divided::ByLane,
        };
        self.least_q = match (self.strict, self.divided) {
            (false, Divided::ByLane) => least_for_q(q.x),
            (false, _) => f64::NEG_INFINITY,
            (true, _) => match Doubt::least_q(gradients) {
                Some(least) => least,
                None => return false,
            },
        };
        self.least[0] = self.least_q;
        self.set_function(simd, 0, *q, [0.0; 2]);
        if self.strict {
            self.steps_off_middle[0] = steps_off_middle(simd, q.x);
        }
        for (i, field) in (1..).zip(fields) {
            let set = match field {
                Field::Plain(plain) if plain.over_w == over_w && !self.strict => {
                    self.set_plain(simd, i, plain, q.x);
                    true
                }
                Field::Strict(strict) if strict.over_w == over_w => {
                    self.set_strict(simd, i, strict, gradients)
                }
                // It is clamped to its value.
                Field::Constant(value) if !value.is_nan() && value.to_bits() != NEGATIVE_ZERO => {
                    (self.bases[i], self.doubts[i]) = (0.0, Doubt::default());
                    self.steps_off_middle[i] = Wide::splat(simd, 0.0);
                    (self.least[i], self.near_zero[i]) = (f64::NEG_INFINITY, NEVER_NEAR_ZERO);
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
    fn set_plain(&mut self, simd: S, i: usize, plain: &Plain, q_step: f64) {
        self.set_function(simd, i, plain.numerator, plain.range);
        let least = match self.divided {
            Divided::Not if always_near(plain) => f64::NEG_INFINITY,
            Divided::Not => f64::INFINITY,
            Divided::ByRow => least_for_row(plain),
            Divided::ByLane => least_for_numerator(plain, q_step),
        };
        (self.least[i], self.near_zero[i]) = (least, near_zero_up_to(plain, plain.numerator.x));
        self.meets_zero |= self.near_zero[i] != NEVER_NEAR_ZERO;
        self.least_q = if least > self.least_q { least } else { self.least_q };
    }

    #[inline(always)]
    fn set_function(&mut self, simd: S, i: usize, function: Linear, [low, high]: [f32; 2]) {
        self.functions.set(i, function);
        self.steps[i] = function.x;
        if self.divided != Divided::ByRow && !self.strict && !self.short {
            self.off_middle[i] = off_middle(simd, function.x);
        }
        (self.low[i], self.high[i]) = (Narrow::splat(simd, low), Narrow::splat(simd, high));
        self.inner[i] = inner_range([low, high]);
    }

    /// Goes to the row `v` from the anchor, with `count` attributes.
    #[inline(always)]
    pub(crate) fn seek(&mut self, simd: S, count: usize, v: f64) {
        if self.filled {
            return;
        }
        let Coefficients { c, y, .. } = &self.functions;
        for first in (0..=count.min(FUNCTIONS - 1)).step_by(FOUR) {
            four_of(simd, c, y, v, first).store_slice(&mut self.starts[first..first + FOUR]);
        }
        if self.divided == Divided::ByRow {
            self.divide_row(simd, count);
        }
        if !self.short {
            self.find_unclamped(count);
        }
    }

    /// Finds out where on this row no value has to be clamped.
    #[inline(always)]
    fn find_unclamped(&mut self, count: usize) {
        let one = OnRow { start: 1.0, step: 0.0 };
        let q = if self.divided == Divided::ByLane { self.on_row(0) } else { one };
        // What is plain is divided, if it is by row, and has no base.
        let scale = if self.strict && self.divided != Divided::ByLane { self.r } else { 1.0 };
        self.unclamped = Columns::ALL;
        for i in 1..=count.min(FUNCTIONS - 1) {
            let (d, base) = (self.on_row(i).times(scale), q.times(self.bases[i]));
            let n = OnRow { start: d.start + base.start, step: d.step + base.step };
            self.unclamped = self.unclamped.where_within(n, q, self.inner[i]);
        }
    }

    /// Divides what is divided once for each row.
    #[inline(always)]
    fn divide_row(&mut self, simd: S, count: usize) {
        if self.short && !self.strict {
            // As where each lane has its own.
            self.r = f64::from(1.0 / nearest_f32(self.starts[0]));
            return;
        }
        self.r = 1.0 / self.starts[0];
        if self.strict {
            return;
        }
        for i in 1..=count.min(FUNCTIONS - 1) {
            let on_row = OnRow { start: self.starts[i], step: self.functions.x[i] };
            let on_row = on_row.times(self.r);
            (self.starts[i], self.steps[i]) = (on_row.start, on_row.step);
            if self.near_zero[i] != NEVER_NEAR_ZERO {
                self.near_zero[i] = near_zero_of(on_row.step);
            }
            self.off_middle[i] = off_middle(simd, on_row.step);
        }
    }

    /// See [`near_zero_up_to`]: is function `i` so small in the block around `middle`?
    #[inline(always)]
    fn is_near_zero(&self, i: usize, middle: f64) -> bool {
        self.on_row(i).at(middle).abs() <= self.near_zero[i]
    }

    /// What [`find_some`](Self::find_some) finds, of one block, and the attributes that are undecided; nothing
    /// if it is not good.
    #[inline(always)]
    pub(crate) fn find_one(
        &self,
        simd: S,
        count: usize,
        middle: f64,
        mask: u16,
        lanes: &mut [[f32; BLOCK]],
    ) -> Option<u16> {
        if self.filled {
            return Some(0);
        }
        if self.strict {
            // What is less usual here is a function of its own, which all shaders share.
            return simd.vectorize(
                #[inline(always)]
                || self.find_one_strict(simd, count, middle, mask, lanes),
            );
        }
        if !self.short {
            simd.vectorize(
                #[inline(always)]
                || self.find_by_block(simd, count, middle, lanes),
            );
            return Some(0);
        }
        let mut r = Narrow::splat(simd, nearest_f32(self.r));
        if self.divided == Divided::ByLane {
            r /= self.on_row(0).wide(simd, middle).narrow();
        }
        for (i, lanes) in (1..FUNCTIONS).zip(lanes).take(count) {
            let value = self.on_row(i).wide(simd, middle).narrow() * r;
            clamp_numbers(value, self.low[i], self.high[i]).store_array(lanes);
        }
        Some(0)
    }

    /// The same where spans are long.
    #[inline(always)]
    fn find_by_block(&self, simd: S, count: usize, middle: f64, lanes: &mut [[f32; BLOCK]]) {
        let q = self.on_row(0).at(middle);
        let mut apart = q < self.least_q;
        if self.meets_zero {
            for i in 1..=count.min(FUNCTIONS - 1) {
                apart |= self.is_near_zero(i, middle);
            }
        }
        if apart {
            return self.find_each(simd, count, middle, q, lanes);
        }
        let four = four_of(simd, &self.starts, &self.steps, middle, 0);
        let at_middle = if count < FOUR {
            Middles::of(four)
        } else {
            Middles::of_two(four, four_of(simd, &self.starts, &self.steps, middle, FOUR))
        };
        let mut further = Middles::none();
        if count >= 2 * FOUR {
            further = Middles::of(four_of(simd, &self.starts, &self.steps, middle, 2 * FOUR));
        }
        let mut r = Narrow::splat(simd, 1.0);
        if self.divided == Divided::ByLane {
            r /= at_middle.lanes(simd, 0, self.off_middle[0]);
        }
        for (i, lanes) in (1..FUNCTIONS).zip(lanes).take(count) {
            let off_middle = self.off_middle[i];
            let value = if i < 2 * FOUR {
                at_middle.lanes(simd, i, off_middle)
            } else {
                further.lanes(simd, i - 2 * FOUR, off_middle)
            };
            clamp_numbers(value * r, self.low[i], self.high[i]).store_array(lanes);
        }
    }

    /// The same where not all go by their block: `q` is too small for some.
    #[inline(always)]
    fn find_each(&self, simd: S, count: usize, middle: f64, q: f64, lanes: &mut [[f32; BLOCK]]) {
        let mut r = Narrow::splat(simd, 1.0);
        if self.divided == Divided::ByLane {
            r /= self.lanes_of(simd, 0, middle, q);
        }
        for (i, lanes) in (1..FUNCTIONS).zip(lanes).take(count) {
            let value = self.lanes_of(simd, i, middle, q) * r;
            clamp_numbers(value, self.low[i], self.high[i]).store_array(lanes);
        }
    }

    /// Function `i` around `middle`, where Q is `q`.
    #[inline(always)]
    fn lanes_of(&self, simd: S, i: usize, middle: f64, q: f64) -> Narrow<S> {
        let on_row = self.on_row(i);
        if q < self.least[i] || self.is_near_zero(i, middle) {
            on_row.wide(simd, middle).narrow()
        } else {
            on_row.near(simd, middle, self.off_middle[i])
        }
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
