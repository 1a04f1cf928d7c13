//! Set-ups of small triangles and quadrilaterals within the view volume, up to eight at a time: a lane is
//! one of them. Those of triangles in `Fast` are here, with the bits of [`Gradients`](super::Gradients).
#![expect(
    clippy::needless_range_loop,
    reason = "loops over arrays are unrolled, iterators are not"
)]

use alloc::vec::Vec;

use super::frame::{Linear, Projection, Reach};
use super::small_strict::StrictLanes;
use super::view::{View, usual_range};
use super::{ConstantAlong, nearest_f32};
use crate::number::{EIGHT, Lanes, Number};
use crate::space::Viewport;

/// The greatest w is at least the first, and below the second: else positions are scaled.
const MODERATE: [f64; 2] = [1.0 / 18_446_744_073_709_551_616.0, 36_893_488_147_419_103_232.0];

/// The polygons that are set up.
#[derive(Debug, Default)]
pub(crate) struct SmallCorners {
    /// Clip positions of the corners: a triangle's in its order; a quadrilateral's triple, and the fourth.
    pub(crate) positions: [[Lanes; 4]; 4],
    /// Column and row of the pixel that offsets count from, and how far others are from it at most.
    pub(crate) anchor: [Lanes; 2],
    pub(crate) reach: Lanes,
    /// How far beyond those of its corners a triangle's depths may lie: times their range.
    pub(crate) beyond: Lanes,
}

impl SmallCorners {
    /// The positions of a triangle, or of the triple.
    #[inline(always)]
    pub(crate) fn load<F: Number>(&self, level: F::Level) -> [[F; 4]; 3] {
        let [a, b, c, _] = &self.positions;
        [load_position(level, a), load_position(level, b), load_position(level, c)]
    }

    /// That of the fourth corner.
    #[inline(always)]
    pub(crate) fn load_fourth<F: Number>(&self, level: F::Level) -> [F; 4] {
        load_position(level, &self.positions[3])
    }

    /// Around the pixels that offsets count from.
    #[inline(always)]
    pub(crate) fn projection<F: Number>(
        &self,
        level: F::Level,
        viewport: Viewport,
    ) -> Projection<F> {
        let [column, row] = &self.anchor;
        Projection::new(viewport, [F::load(level, column), F::load(level, row)])
    }

    /// How far others are from these.
    #[inline(always)]
    pub(super) fn reach<F: Number>(&self, level: F::Level) -> Reach<F> {
        let reach = F::load(level, &self.reach);
        Reach { u: reach, v: reach }
    }
}

/// What is known of their pixels.
#[derive(Debug, Default)]
pub(crate) struct SmallSetups {
    /// A bit for each lane: can it be painted from this?
    pub(super) usual: u8,
    /// The same: does Q not change along rows, or along columns?
    still: [u8; 2],
    /// The same: is depth 0 all over?
    flat_zero: u8,
    unit_q: LinearLanes,
    pub(super) depth: LinearLanes,
    pub(super) doubtful_below: Lanes,
    pub(super) strict: StrictLanes,
    /// The first so many are set.
    pub(super) count: usize,
    pub(super) attributes: Vec<AttributeLanes>,
}

/// Linear functions.
#[derive(Debug, Default)]
pub(super) struct LinearLanes([Lanes; 3]);

/// An attribute.
#[derive(Debug, Default)]
pub(crate) struct AttributeLanes {
    /// At the corners, in the order of their positions.
    pub(crate) values: [Lanes; 4],
    /// Over Q, times the unit; in `Fast`, where Q does not change, divided by it.
    pub(super) numerator: LinearLanes,
    pub(super) range: [Lanes; 2],
    /// A bit for each lane: is it the same all over?
    pub(super) same: u8,
    /// In `Exact`, what is added to the quotient, and what the sum is off by beside what goes by the
    /// value.
    pub(super) base: Lanes,
    pub(super) error: Lanes,
}

impl AttributeLanes {
    /// The first `N` values.
    #[inline(always)]
    pub(super) fn load<F: Number, const N: usize>(&self, level: F::Level) -> [F; N] {
        let mut values = [F::load(level, &self.values[0]); N];
        for i in 1..N {
            values[i] = F::load(level, &self.values[i]);
        }
        values
    }

    /// Finds out where its values are the same.
    #[inline(always)]
    pub(super) fn set_same<F: Number, const N: usize>(&mut self, values: &[F; N]) -> F::Truth {
        let first = values[0];
        let mut same = (first * 0.0).eq(first.like(0.0));
        for i in 1..N {
            same = same & first.same_bits(values[i]);
        }
        self.same = F::bits(same);
        same
    }
}

/// How an attribute runs over a small triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SmallField {
    Constant(f32),
    /// From a numerator, and between these.
    Linear(Linear, [f32; 2]),
}

/// By how much the corners of triangles are turned, so that the least one comes first.
struct Turn<F: Number> {
    by_one: F::Truth,
    by_two: F::Truth,
    /// Is any turned at all?
    any: bool,
}

impl<F: Number> Turn<F> {
    /// Of these corners, in `lanes`, and whether their positions alone tell, as they nearly always do.
    #[inline(always)]
    fn new(corners: &[[F; 4]; 3], lanes: u8) -> (Self, F::Truth) {
        let (turn, known) = Self::by_axes::<1>(corners);
        // Edges that are upright in the picture have ends of the same x.
        if F::bits(known) & lanes == lanes { (turn, known) } else { Self::by_axes::<4>(corners) }
    }

    /// By the first `AXES` of x, y, z and w.
    #[inline(always)]
    fn by_axes<const AXES: usize>([p, q, r]: &[[F; 4]; 3]) -> (Self, F::Truth) {
        let by_none = is_less::<F, AXES>(p, q) & is_less::<F, AXES>(p, r);
        let by_one = is_less::<F, AXES>(q, r) & is_less::<F, AXES>(q, p);
        let by_two = is_less::<F, AXES>(r, p) & is_less::<F, AXES>(r, q);
        let any = F::bits(by_one | by_two) != 0;
        (Self { by_one, by_two, any }, by_none | by_one | by_two)
    }

    #[inline(always)]
    fn turned(&self, [p, q, r]: [F; 3]) -> [F; 3] {
        let Self { by_one, by_two, any } = *self;
        if !any {
            return [p, q, r];
        }
        [
            F::select(by_two, r, F::select(by_one, q, p)),
            F::select(by_two, p, F::select(by_one, r, q)),
            F::select(by_two, q, F::select(by_one, p, r)),
        ]
    }

    #[inline(always)]
    fn turned_positions(&self, [p, q, r]: [[F; 4]; 3]) -> [[F; 4]; 3] {
        let [ax, bx, cx] = self.turned([p[0], q[0], r[0]]);
        let [ay, by, cy] = self.turned([p[1], q[1], r[1]]);
        let [az, bz, cz] = self.turned([p[2], q[2], r[2]]);
        let [aw, bw, cw] = self.turned([p[3], q[3], r[3]]);
        [[ax, ay, az, aw], [bx, by, bz, bw], [cx, cy, cz, cw]]
    }
}

impl LinearLanes {
    #[inline(always)]
    pub(super) fn store<F: Number>(&mut self, linear: Linear<F>) {
        let Self([x, y, c]) = self;
        linear.x.store(x);
        linear.y.store(y);
        linear.c.store(c);
    }

    #[inline(always)]
    fn of(&self, lane: usize) -> Linear {
        let Self([x, y, c]) = self;
        let lane = lane % EIGHT;
        Linear { x: x[lane], y: y[lane], c: c[lane] }
    }
}

impl SmallSetups {
    /// All of them, of `corners` and of attributes whose values have been set; `lanes` are triangles, a
    /// bit for each, and others hold anything.
    #[inline(always)]
    pub(crate) fn set<F: Number>(
        &mut self,
        level: F::Level,
        corners: &SmallCorners,
        lanes: u8,
        viewport: Viewport,
    ) {
        let given = corners.load::<F>(level);
        let (turn, turned) = Turn::new(&given, lanes);
        let [a, b, c] = turn.turned_positions(given);
        let low = a[3].lesser(b[3]).lesser(c[3]);
        let high = a[3].greater(b[3]).greater(c[3]);
        let projection = corners.projection::<F>(level, viewport);
        let Reach { u: reach, .. } = corners.reach(level);
        let (view, good) = View::new(&projection, [a, b, c], [low, high], reach, viewport);
        self.usual = F::bits(good & turned) & moderate(&[a, b, c], low, high);
        let q = view.unit_q;
        let divided = self.set_q(q);
        let range = viewport.depth_range();
        let z = [range.numerator(a), range.numerator(b), range.numerator(c)];
        self.set_flat_zero(z);
        let (depth, doubtful_below) = view.depth(z);
        self.depth.store(depth);
        doubtful_below.store(&mut self.doubtful_below);

        let divides = F::bits(divided) != 0;
        // As for any polygon: one rounding is left where w is the same all over.
        let divisor = F::select(divided, q.c.reciprocal(), low.like(1.0));
        for attribute in self.attributes.iter_mut().take(self.count) {
            let [a, b, c] = turn.turned(attribute.load::<F, 3>(level));
            let same = attribute.set_same(&[a, b, c]);
            if attribute.same & lanes == lanes {
                a.store(&mut attribute.range[0]);
                continue;
            }
            let ([low, high], usual) = usual_range([a, b, c]);
            let numerator = view.numerator([a, b, c]);
            attribute.numerator.store(if divides { numerator.scaled(divisor) } else { numerator });
            attribute.set_range(same, a, [low, high]);
            self.usual &= F::bits(usual | same);
        }
    }

    /// Takes Q, times the unit. Where does it not change at all?
    #[inline(always)]
    pub(super) fn set_q<F: Number>(&mut self, q: Linear<F>) -> F::Truth {
        let zero = q.c.like(0.0);
        let (rows, columns) = (q.x.eq(zero), q.y.eq(zero));
        self.still = [F::bits(rows), F::bits(columns)];
        self.unit_q.store(q);
        rows & columns
    }

    /// Finds out where depth is 0 all over, from what it is of at the corners.
    #[inline(always)]
    pub(super) fn set_flat_zero<F: Number>(&mut self, [a, b, c]: [F; 3]) {
        self.flat_zero = F::bits((a.abs() + b.abs() + c.abs()).eq(a.like(0.0)));
    }

    /// The first `count` attributes, whose values are to be set.
    #[inline(always)]
    pub(crate) fn attributes_mut(&mut self, count: usize) -> &mut [AttributeLanes] {
        self.count = count;
        if self.attributes.len() < count {
            self.attributes.resize_with(count, AttributeLanes::default);
        }
        self.attributes.get_mut(..count).unwrap_or_default()
    }

    /// Can `lane` be painted from this?
    #[inline(always)]
    pub(crate) fn is_usual(&self, lane: usize) -> bool {
        self.usual >> (lane % EIGHT) & 1 != 0
    }

    /// Says that these lanes cannot: a bit for each.
    #[inline(always)]
    pub(crate) fn give_up(&mut self, lanes: u8) {
        self.usual &= !lanes;
    }

    /// How many attributes there are.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Does Q change neither along rows nor along columns?
    #[inline(always)]
    pub(crate) fn is_divided(&self, lane: usize) -> bool {
        let [rows, columns] = self.still;
        (rows & columns) >> (lane % EIGHT) & 1 != 0
    }

    /// Along what Q does not change.
    #[inline(always)]
    pub(crate) fn constant(&self, lane: usize) -> ConstantAlong {
        let [rows, columns] = self.still.map(|lanes| lanes >> (lane % EIGHT) & 1 != 0);
        ConstantAlong::of(rows, columns)
    }

    /// Depth, and the magnitude below which it is in doubt; nothing if it is 0 all over.
    #[inline(always)]
    pub(crate) fn depth(&self, lane: usize) -> Option<(Linear, f32)> {
        let lane = lane % EIGHT;
        // A hair above it, so that what rounds to a `f32` below is among them.
        let limit = nearest_f32(self.doubtful_below[lane] * 1.001);
        (self.flat_zero >> lane & 1 == 0).then_some((self.depth.of(lane), limit))
    }

    /// Depth at places from the anchors.
    #[inline(always)]
    pub(crate) fn depth_at<F: Number>(&self, level: F::Level, [u, v]: [F; 2]) -> F {
        let LinearLanes([x, y, c]) = &self.depth;
        F::load(level, c) + F::load(level, y) * v + F::load(level, x) * u
    }

    /// Q times the power of two that brings the least into 1..2.
    #[inline(always)]
    pub(crate) fn unit_q(&self, lane: usize) -> Linear {
        self.unit_q.of(lane)
    }

    /// The same, unless attributes are divided by it.
    #[inline(always)]
    pub(crate) fn divisor(&self, lane: usize) -> Option<Linear> {
        (!self.is_divided(lane)).then(|| self.unit_q(lane))
    }

    /// Attribute `k`, which was set.
    #[inline(always)]
    pub(crate) fn attribute(&self, k: usize, lane: usize) -> Option<SmallField> {
        let AttributeLanes { numerator, range: [low, high], same, .. } = self.attributes.get(k)?;
        let lane = lane % EIGHT;
        let low = nearest_f32(low[lane]);
        Some(if same >> lane & 1 != 0 {
            SmallField::Constant(low)
        } else {
            SmallField::Linear(numerator.of(lane), [low, nearest_f32(high[lane])])
        })
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.attributes.capacity() * size_of::<AttributeLanes>()
    }
}

/// Does `p` come before `q`, by the first `AXES` of its coordinates?
#[inline(always)]
fn is_less<F: Number, const AXES: usize>(p: &[F; 4], q: &[F; 4]) -> F::Truth {
    let mut less = p[AXES - 1].lt(q[AXES - 1]);
    for i in (0..AXES - 1).rev() {
        less = p[i].lt(q[i]) | p[i].eq(q[i]) & less;
    }
    less
}

#[inline(always)]
fn load_position<F: Number>(level: F::Level, [x, y, z, w]: &[Lanes; 4]) -> [F; 4] {
    [F::load(level, x), F::load(level, y), F::load(level, z), F::load(level, w)]
}

/// A bit for each triangle of which all positions are finite, and whose greatest w is moderate.
#[inline(always)]
pub(super) fn moderate<F: Number>([a, b, c]: &[[F; 4]; 3], low: F, high: F) -> u8 {
    // What is no number makes no number of this.
    let sums = a[0] + b[0] + c[0] + a[1] + b[1] + c[1] + a[2] + b[2] + c[2] + high;
    let finite = (sums * 0.0).eq(low.like(0.0));
    let moderate = low.like(MODERATE[0]).le(high) & high.lt(low.like(MODERATE[1]));
    F::bits(finite & moderate)
}

#[cfg(test)]
mod tests {
    use super::super::Attributes;
    use super::super::triple::choose;
    use super::*;

    struct Bare;

    impl Attributes for Bare {
        fn attribute(&self, _i: usize, _k: usize) -> f32 {
            0.0
        }

        fn count(&self) -> usize {
            0
        }

        fn gather(&self, _count: usize, _out: &mut Vec<f32>) {}
    }

    /// Where edges are upright, and whatever else corners have in common: the least comes first, as in triangles
    /// that are set up alone, and it is known which that is unless there are two of it.
    #[test]
    fn turns_begin_with_the_least_corner() {
        // Each of three corners has one of three values on each axis.
        for which in 0..3_usize.pow(12) {
            let value = |k: u32| (which / 3_usize.pow(k) % 3) as f64 - 1.0;
            let corner =
                |i: u32| [value(4 * i), value(4 * i + 1), value(4 * i + 2), value(4 * i + 3)];
            let corners = [corner(0), corner(1), corner(2)];
            let (turn, known) = Turn::<f64>::new(&corners, 1);
            let first = choose(&corners, &Bare)[0];
            let twice = corners.iter().filter(|corner| **corner == corners[first]).count() > 1;
            assert_eq!(known, !twice, "{corners:?}");
            if known {
                let expected = [corners[first], corners[(first + 1) % 3], corners[(first + 2) % 3]];
                assert_eq!(turn.turned_positions(corners), expected);
            }
        }
    }
}
