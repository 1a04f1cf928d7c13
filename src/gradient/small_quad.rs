//! Set-ups of small quadrilaterals within the view volume, up to eight at a time: a lane is one of them.
//!
//! Its plane is that of the three vertices that [`triple::choose`](super::triple::choose) names, and so its
//! functions are those of their triangle; the fourth vertex tells whether it is flat, whether attributes are
//! affine, and what values lie between. What is not usual is drawn as other polygons are.

use super::flat::{Basis, FLATNESS, off_affine};
use super::frame::{Bounded, Frame, Plane, Projection, Reach, U};
use super::small::{AttributeLanes, SmallCorners, SmallSetups, moderate};
use super::triple::projective;
use super::{FITS, TRUSTED, WITHIN_ULP, trusted_of};
use crate::number::{Number, range_of};
use crate::space::Viewport;

/// So much the least Q may differ, relatively, from what is found in the framebuffer for any polygon, unless it
/// is the same all over: there a vertex's place is off by 2^-42 of a pixel, while Q changes by no more than its
/// half over a snap's reach.
const LEAST_Q_ERROR: f64 = 1.0 / 1_048_576.0;

/// The fourth vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fourth<F: Number> {
    /// Where it is in the plane of the triple.
    place: [F; 2],
    /// |Q| there, where it is positive.
    q: F,
    /// Is the quadrilateral flat, and 1/w positive there?
    pub(super) usual: F::Truth,
}

impl<F: Number> Fourth<F> {
    /// Of the vertex `d` and the triple, whose plane is `plane`.
    #[inline(always)]
    pub(super) fn new(
        projection: &Projection<F>,
        plane: &Plane<F>,
        [a, b, c]: &[[F; 4]; 3],
        d: [F; 4],
    ) -> Self {
        let basis = Basis::new([projective(*a), projective(*b), projective(*c)]);
        let (place, mut height) = basis.place(projective(d));
        // That of the triple is rounding.
        for corner in [a, b, c] {
            let (_, rounding) = basis.place(projective(*corner));
            height = height.greater(rounding);
        }
        let zero = a[0].like(0.0);
        let mut diameter_squared = zero;
        for k in 0..4 {
            let [low, high] = range_of(&[a[k], b[k], c[k], d[k]]);
            diameter_squared = diameter_squared + (high - low) * (high - low);
        }
        let tolerance_squared = diameter_squared * (FLATNESS * FLATNESS);
        let [x, y, w] = projection.project(d);
        let q = (plane.q.x * x + plane.q.y * y + plane.q.c * w) / w;
        let q = F::select(plane.det.lt(zero), zero - q, q);
        let fourth = Self { place, q, usual: zero.lt(q) };
        let usual = fourth.usual
            & zero.lt(basis.square)
            & basis.squared(height).le(tolerance_squared)
            & fourth.is_within(tolerance_squared, &[a[2], b[2], c[2], d[2]]);
        Self { usual, ..fourth }
    }

    /// The least |Q| at any vertex, where it is `at_greatest_w` at one of the triple's.
    #[inline(always)]
    pub(super) fn least_q(&self, at_greatest_w: F) -> F {
        at_greatest_w.lesser(self.q)
    }

    /// Do the `values` of all four agree with the affine function of the first three, but for their range's
    /// part that is left?
    #[inline(always)]
    pub(super) fn is_affine(&self, values: &[F; 4], [low, high]: [F; 2]) -> F::Truth {
        let tolerance = (high - low) * FLATNESS;
        self.is_within(tolerance * tolerance, values)
    }

    #[inline(always)]
    fn is_within(&self, tolerance_squared: F, &[a, b, c, d]: &[F; 4]) -> F::Truth {
        let (zero, one) = (a.like(0.0), a.like(1.0));
        // Of what is infinite the tolerance is, too.
        (d * 0.0).eq(zero)
            & off_affine([a, b, c], self.place, d).le(tolerance_squared)
            & off_affine([a, b, c], [one, zero], b).le(tolerance_squared)
            & off_affine([a, b, c], [zero, one], c).le(tolerance_squared)
    }
}

impl SmallSetups {
    /// All of them in `Fast`, with the bits of [`Gradients`](super::Gradients), of `corners` and of attributes
    /// whose values have been set, in the triple's order and then the fourth; `lanes` are quadrilaterals, a
    /// bit for each, and others hold anything.
    #[inline(always)]
    pub(crate) fn set_quads<F: Number>(
        &mut self,
        level: F::Level,
        corners: &SmallCorners,
        lanes: u8,
        viewport: Viewport,
    ) {
        let (triple, d) = (corners.load::<F>(level), corners.load_fourth::<F>(level));
        let [a, b, c] = &triple;
        let [low, high] = range_of(&[a[3], b[3], c[3], d[3]]);
        let projection = corners.projection::<F>(level, viewport);
        let reach = corners.reach(level);
        let frame = Frame::new(&projection, triple, reach);
        let (q, det) = (frame.plane.q, frame.plane.det);
        let fourth = Fourth::new(&projection, &frame.plane, &triple, d);

        // 1. The plane, if it may be trusted.
        let zero = low.like(0.0);
        let steepness = q.x.abs() + q.y.abs();
        let least_q = fourth.least_q(det.abs() / high);
        let room = least_q * LEAST_Q_ERROR;
        let room = room.zero_if(steepness.eq(zero));
        let (least_q, most_q) = (least_q - room, least_q + room);
        let unit = least_q.inverse_power(det);
        let det_error = frame.det_error / det.abs() + 2.0 * U;
        // A hair less than trusted: it is compared in another order elsewhere.
        let limit = least_q * (TRUSTED * (1.0 - LEAST_Q_ERROR));
        // None holds for what is no number.
        let trusted = (frame.q_error + det_error * least_q).le(limit)
            & (steepness * viewport.grid().snap_reach()).le(least_q * 0.5)
            & det.abs().le(least_q * low * FITS)
            & unit.eq(most_q.inverse_power(det));
        self.usual = F::bits(trusted & fourth.usual) & moderate(&triple, low, high);
        let unit_q = q.scaled(unit);
        let divided = self.set_q(unit_q);

        // 2. Depth.
        let range = viewport.depth_range();
        let z = [range.numerator(*a), range.numerator(*b), range.numerator(*c)];
        self.set_flat_zero(z);
        let depth = depth_of(&frame, z, reach);
        self.usual &= F::bits(depth.error.lt(low.like(1.0)));
        self.depth.store(depth.linear);
        (depth.error * WITHIN_ULP).store(&mut self.doubtful_below);

        // 3. Attributes.
        let divides = F::bits(divided) != 0;
        // As for any polygon: one rounding is left where w is the same all over.
        let divisor = F::select(divided, unit_q.c.reciprocal(), low.like(1.0));
        for attribute in self.attributes.iter_mut().take(self.count) {
            let values = attribute.load::<F, 4>(level);
            let same = attribute.set_same(&values);
            let [a, b, c, _] = values;
            if attribute.same & lanes == lanes {
                a.store(&mut attribute.range[0]);
                continue;
            }
            let [low, high] = range_of(&values);
            let [low, high] = [low + 0.0, high + 0.0];
            let size = low.abs().greater(high.abs());
            let fits = size.like(1.0 / FITS).le(size) & size.lt(size.like(FITS));
            let part = part_of(&frame, [a, b, c], a);
            let good = part.error.le(trusted_of([low, high]) * size * least_q);
            let linear = part.linear.scaled(unit);
            attribute.numerator.store(if divides { linear.scaled(divisor) } else { linear });
            let usual = low.lt(high) & fits & good & fourth.is_affine(&values, [low, high]);
            attribute.set_range(same, a, [low, high]);
            self.usual &= F::bits(usual | same);
        }
    }
}

/// z/w as a linear function, of `z` at the corners.
#[inline(always)]
pub(super) fn depth_of<F: Number>(frame: &Frame<F>, z: [F; 3], reach: Reach<F>) -> Bounded<F> {
    let size = z[0].abs().greater(z[1].abs()).greater(z[2].abs());
    // The sum and the difference, each rounded.
    let depth = frame.combine([z[0], z[1] - z[0], z[2] - z[0]], size * (4.0 * U));
    depth.scaled(frame.plane.det.reciprocal(), reach)
}

/// `base` Q and what an attribute with the values `a`, `b` and `c` at the triple has beyond a's, times Q.
#[inline(always)]
pub(super) fn part_of<F: Number>(frame: &Frame<F>, [a, b, c]: [F; 3], base: F) -> Bounded<F> {
    let (to_b, to_c) = (b - a, c - a);
    let input_error = to_b.abs().greater(to_c.abs()) * (3.0 * U);
    frame.combine([base, to_b, to_c], input_error)
}

impl AttributeLanes {
    /// What values lie between; where it is the `same` all over, `value`, whose zero keeps its sign.
    #[inline(always)]
    pub(super) fn set_range<F: Number>(&mut self, same: F::Truth, value: F, [low, high]: [F; 2]) {
        F::select(same, value, low).store(&mut self.range[0]);
        high.store(&mut self.range[1]);
    }
}
