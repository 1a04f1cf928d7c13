//! The right values along a run of pixels in a row, each with a bound of its error, in plain
//! `f64`: for those who have thousands of millions to compare. Where a bound is too wide to tell,
//! the reference itself does.
//!
//! A function runs from the end of the run where 1/w is least: there it is known in pairs, and
//! i steps of `step` from there it is `at + i step`, off by the rounding of `at`, of `step`, of
//! their product and of the sum: u (2 |at| + 4 |i step|) at most, u = 2^-53.

use super::{Function, Reference};

/// A value, and a bound of its error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

impl Near {
    /// Of what is told by nothing.
    const UNKNOWN: Self = Self { value: 0.0, error: f64::INFINITY };
}

/// A function along the run: at i columns from where it is known.
#[derive(Clone, Copy, Debug)]
struct Line {
    at: f64,
    step: f64,
}

/// The rounding of `f64`, and room for the terms of second order.
const U: f64 = 1.001 / (1_u64 << 53) as f64;

impl Line {
    fn new(function: &Function, place: [f64; 3], across: f64) -> Self {
        Self { at: function.at(place).0.high, step: function.pairs[0].times(across).high }
    }

    #[inline(always)]
    fn at(self, i: f64) -> Near {
        let off = self.step * i;
        Near { value: self.at + off, error: U * (2.0 * self.at.abs() + 4.0 * off.abs()) }
    }
}

/// What is interpolated along the run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    numerator: Line,
    denominator: Line,
    range: [f64; 2],
    /// The power of two that the quotient is multiplied by.
    scale: f64,
    /// Pixels from the run's first to where the lines begin.
    origin: f64,
}

impl Run {
    /// Is it the same at all vertices?
    pub(crate) fn is_constant(&self) -> bool {
        self.range[0] == self.range[1]
    }

    /// The value at pixel `i` of the run.
    #[inline(always)]
    pub(crate) fn at(&self, i: usize) -> Near {
        let i = i as f64 - self.origin;
        let (n, d) = (self.numerator.at(i), self.denominator.at(i));
        let quotient = n.value / d.value;
        let error =
            1.001 * (n.error + quotient.abs() * d.error) / d.value + 2.0 * U * quotient.abs();
        // Half of the denominator is known at least, and it is positive: else nothing is.
        let known = d.value > 2.0 * d.error;
        let [least, most] = self.range;
        let value = quotient * self.scale;
        let value = if value < least { least } else { value };
        let value = if value > most { most } else { value };
        // An end of the range may have been rounded, too.
        let near = Near { value, error: error * self.scale + U * value.abs() };
        if known { near } else { Near::UNKNOWN }
    }
}

/// All that is interpolated along a run of pixels.
#[derive(Clone, Debug)]
pub(crate) struct Runs {
    pub(crate) depth: Run,
    /// Nothing for a polygon that a plane may cut.
    pub(crate) inv_w: Option<Run>,
    pub(crate) w: Option<Run>,
    pub(crate) attributes: Vec<Run>,
}

impl Reference {
    /// Along `count` pixels from (`x`, `y`) to the right, at least one.
    pub(crate) fn runs(&self, x: i32, y: i32, count: usize) -> Runs {
        let last = x + count as i32 - 1;
        let ends = [x, last].map(|x| self.inv_w.at(self.place(x, y)).0.high.abs());
        let (origin, from) = if ends[0] <= ends[1] { (0.0, x) } else { ((count - 1) as f64, last) };
        let place = self.place(from, y);
        // `place` changes by so much from column to column.
        let across = 2.0 * f64::from(self.viewport.height());
        let line = |function: &Function| Line::new(function, place, across);
        let constant = Line { at: self.determinant.0.high, step: 0.0 };
        let run = |numerator, denominator, range| Run {
            numerator,
            denominator,
            range,
            scale: 1.0,
            origin,
        };
        let q = line(&self.inv_w);
        let w = || self.points.iter().map(|p| p[2]);
        let nearest = w().fold(f64::INFINITY, f64::min) / self.scale;
        let farthest = w().fold(0.0, f64::max) / self.scale;
        let whole = |run: Run| self.is_whole.then_some(run);
        Runs {
            depth: run(line(&self.depth), constant, [0.0, 1.0]),
            inv_w: whole(Run {
                scale: self.scale,
                ..run(q, constant, [1.0 / farthest, 1.0 / nearest])
            }),
            w: whole(Run { scale: 1.0 / self.scale, ..run(constant, q, [nearest, farthest]) }),
            attributes: self
                .attributes
                .iter()
                .map(|attribute| run(line(&attribute.numerator), q, attribute.range))
                .collect(),
        }
    }
}
