//! Compares the values along runs of pixels with P2: first with what plain `f64` tells, with a
//! bound of its own error, and wherever that leaves doubt with the reference.

use hyperspan::polygon::Polygon as _;
use hyperspan::tiler::Precision;

use super::super::reference::run::Run;
use super::super::reference::{Reference, Value};
use super::scene::{FIRST_ATTRIBUTE, LANES, Piece};

/// What has a bound of its own.
pub(crate) const QUANTITIES: [&str; 4] = ["depth", "w", "1/w", "attribute"];

/// What came of the values that were compared.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Compared {
    /// In `Fast` and in `Exact`.
    pub(crate) values: [u64; 2],
    /// Of them, those that the reference itself had to judge.
    pub(crate) doubtful: u64,
    /// Beside them, those without a right value: beyond the plane's horizon.
    pub(crate) left_out: u64,
    /// The largest error over its bound, in `Fast` and in `Exact`, for each of [`QUANTITIES`].
    pub(crate) worst: [[f64; 4]; 2],
}

impl Compared {
    /// Adds what came of others.
    pub(crate) fn add(&mut self, other: &Self) {
        for (p, of) in other.worst.iter().enumerate() {
            self.values[p] += other.values[p];
            for (worst, part) in self.worst[p].iter_mut().zip(of) {
                *worst = worst.max(*part);
            }
        }
        self.doubtful += other.doubtful;
        self.left_out += other.left_out;
    }
}

/// A value beyond its bound.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Beyond {
    pub(crate) at: [i32; 2],
    pub(crate) what: String,
}

/// The right values of a polygon.
#[derive(Debug)]
pub(crate) struct Values<'a> {
    reference: &'a Reference,
    precision: Precision,
    /// The greatest magnitude of each attribute at the vertices.
    most: Vec<f64>,
}

/// How far a value may be off.
#[derive(Clone, Copy, Debug)]
enum Bound {
    /// 4u |value| + 3u M
    Fast { most: f64 },
    /// 7u |value|
    InvW,
    /// So many units in the last place.
    Units(f64),
}

const U: f64 = 1.0 / (1_u64 << 24) as f64;

impl Bound {
    /// Of a right value.
    fn of(self, right: Value) -> f64 {
        match self {
            Self::Fast { most } => 4.0 * U * right.high.abs() + 3.0 * U * most,
            Self::InvW => 7.0 * U * right.high.abs(),
            Self::Units(units) => units * right.unit(),
        }
    }

    /// Where the right value is near `value`, and `computed` is not far off: at most this.
    #[inline(always)]
    fn near(self, value: f64, computed: f32) -> f64 {
        match self {
            Self::Fast { most } => 4.0 * U * value.abs() + 3.0 * U * most,
            Self::InvW => 7.0 * U * value.abs(),
            Self::Units(units) => {
                // The distance of the neighbour nearer to zero: no unit next to it is smaller.
                let bits = computed.to_bits() & 0x7FFF_FFFF;
                let below = f32::from_bits(bits.saturating_sub(1));
                units * (f64::from(f32::from_bits(bits)) - f64::from(below))
            }
        }
    }
}

impl<'a> Values<'a> {
    pub(crate) fn new(piece: &Piece, reference: &'a Reference, precision: Precision) -> Self {
        let most = |k: usize| {
            let all = (0..piece.positions.len()).map(|i| piece.attribute(i, k).abs());
            all.fold(0.0, |a: f64, b| a.max(f64::from(b)))
        };
        Self { reference, precision, most: (0..piece.count).map(most).collect() }
    }

    /// Compares a run of pixels from (`x`, `y`) to the right.
    pub(crate) fn compare(
        &self,
        x: i32,
        y: i32,
        pixels: &[[f32; LANES]],
        compared: &mut Compared,
    ) -> Result<(), Beyond> {
        let runs = self.reference.runs(x, y, pixels.len());
        let fast = self.precision == Precision::Fast;
        let bound = |in_fast| if fast { in_fast } else { Bound::Units(0.5) };
        let mut each =
            |lane: usize, run: &Run, bound| self.run([x, y], pixels, lane, run, bound, compared);
        each(0, &runs.depth, bound(Bound::Units(1.0)))?;
        if let (Some(w), Some(inv_w)) = (&runs.w, &runs.inv_w) {
            each(1, w, Bound::Units(0.5))?;
            each(2, inv_w, bound(Bound::InvW))?;
        }
        for (k, run) in runs.attributes.iter().enumerate() {
            let in_fast = Bound::Fast { most: self.most[k] };
            // A constant comes out as itself: no other f32 is within half a unit.
            let bound = if run.is_constant() { Bound::Units(0.5) } else { bound(in_fast) };
            each(FIRST_ATTRIBUTE + k, run, bound)?;
        }
        Ok(())
    }

    fn run(
        &self,
        [x, y]: [i32; 2],
        pixels: &[[f32; LANES]],
        lane: usize,
        run: &Run,
        bound: Bound,
        compared: &mut Compared,
    ) -> Result<(), Beyond> {
        let p = usize::from(self.precision == Precision::Exact);
        let (mut worst, mut left_out) = (0.0, 0);
        for (i, pixel) in pixels.iter().enumerate() {
            let (near, computed) = (run.at(i), pixel[lane]);
            let off = (f64::from(computed) - near.value).abs();
            let part = (off + near.error) / bound.near(near.value, computed);
            // Not where either is no number, or the error is a part of the bound that would show.
            let told =
                part <= 1.0 && near.error <= 1e-3 * off.max(bound.near(near.value, computed));
            if told {
                worst = if part > worst { part } else { worst };
                continue;
            }
            compared.doubtful += 1;
            let at = [x + i as i32, y];
            let Some(right) = self.right(lane, at) else {
                left_out += 1;
                continue;
            };
            let off = (right.distance(computed) - right.error).max(0.0);
            let part = if off == 0.0 { 0.0 } else { off / bound.of(right) };
            if part > 1.0 {
                let name = QUANTITIES[lane.min(FIRST_ATTRIBUTE)];
                let right = right.high;
                let what =
                    format!("{name} is {computed:e}, right is {right:e}: {part} of its bound");
                return Err(Beyond { at, what });
            }
            worst = if part > worst { part } else { worst };
        }
        compared.values[p] += pixels.len() as u64 - left_out;
        compared.left_out += left_out;
        let of_all = &mut compared.worst[p][lane.min(FIRST_ATTRIBUTE)];
        *of_all = of_all.max(worst);
        Ok(())
    }

    fn right(&self, lane: usize, [x, y]: [i32; 2]) -> Option<Value> {
        match lane {
            0 => self.reference.depth(x, y),
            1 => self.reference.w(x, y),
            2 => self.reference.inv_w(x, y),
            k => self.reference.attribute(k - FIRST_ATTRIBUTE, x, y),
        }
    }
}
