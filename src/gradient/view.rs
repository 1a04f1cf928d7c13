//! Set-up of a small triangle within the view volume, in `Fast`: one bound for all its errors.
//!
//! Where every vertex is in view, all that the set-up computes is bounded by the greatest w, the
//! triangle's size in pixels and the viewport's; so one comparison with det tells that every
//! quantity is good enough, and nothing else is asked. docs/precision.md, "In view", derives the
//! numbers.

use super::frame::{Linear, Plane, Projection, U};
use super::{FITS, Field, Gradients, Plain, Subject, TRUSTED, WITHIN_ULP, nearest_f32};
use crate::fixed::power_of_two;
use crate::number::Number;
use crate::space::Viewport;
use crate::varying::Interpolation;

/// Times W^3 D S, over det: the error of an attribute, by its magnitude, is below a half of this.
const ATTRIBUTE_ERROR: f64 = 2400.0 * U;

/// Times W^2 S: what a slope of Q may be off by.
const SLOPE_ERROR: f64 = 24.0 * U;

/// Times W^2 D S: Q's error, and over det det's.
const PLANE_ERROR: f64 = 200.0 * U;

/// Times W^2 D S: depth's error by the greatest z, and by the differences of z.
const DEPTH_ERRORS: [f64; 2] = [500.0 * U, 250.0 * U];

/// Beyond this, 1/w might leave the range of `f64`.
const LARGEST_EXPONENT: i32 = 900;

/// The plane of a triangle that the one bound is good enough for, or of eight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View<F = f64> {
    /// Q and the weights, all times det; a slope of Q that cannot be told from 0 is 0.
    pub(super) plane: Plane<F>,
    /// The power of two that brings the least Q into 1..2, negative where Q is; and Q times that.
    unit: F,
    pub(super) unit_q: Linear<F>,
    /// W^2 D S.
    square: F,
}

impl<F: Number> View<F> {
    /// Of `corners`, whose least and greatest w are `w` and whose pixels are `reach` columns or rows
    /// from the anchor, at most; and whether the bound is good enough.
    #[inline(always)]
    pub(super) fn new(
        projection: &Projection<F>,
        corners: [[F; 4]; 3],
        [w_low, w_high]: [F; 2],
        reach: F,
        viewport: Viewport,
    ) -> (Self, F::Truth) {
        let mut plane = Plane::new(projection, corners);
        let size = reach + 2.0;
        let [half_w, half_h] = viewport.half_size();
        let view = 2.0 * half_w.max(half_h) + 1.0;
        let square = w_high * w_high * size * view;
        let det = plane.det.abs();
        let least_q = det / w_high;

        let slope_error = w_high * SLOPE_ERROR * w_high * view;
        plane.q.x = plane.q.x.zero_if(plane.q.x.abs().le(slope_error));
        plane.q.y = plane.q.y.zero_if(plane.q.y.abs().le(slope_error));
        let beyond = (plane.q.x.abs() + plane.q.y.abs()) * viewport.grid().snap_reach();
        let good = (square * ATTRIBUTE_ERROR * w_high).le(det * TRUSTED)
            & beyond.le(least_q * 0.5)
            & w_high.le(w_low * FITS);
        let unit = least_q.inverse_power(plane.det);
        let unit_q = plane.q.scaled(unit);
        (Self { plane, unit, unit_q, square }, good)
    }

    /// z/w as a linear function, of `z` at the corners, and the magnitude below which it is in doubt.
    #[inline(always)]
    pub(super) fn depth(&self, z: [F; 3]) -> (Linear<F>, F) {
        let (b, c) = (z[1] - z[0], z[2] - z[0]);
        let scale = self.plane.det.reciprocal();
        let numerator = self.plane.combine([z[0], b, c]).scaled(scale);
        let greatest = z[0].abs().greater(z[1].abs()).greater(z[2].abs());
        let [by_z, by_difference] = DEPTH_ERRORS;
        let error = self.square * (greatest * by_z + (b.abs() + c.abs()) * by_difference);
        (numerator, error * scale.abs() * WITHIN_ULP)
    }

    /// The numerator over Q, times the unit, of an attribute with these values at the corners.
    #[inline(always)]
    pub(super) fn numerator(&self, [a, b, c]: [F; 3]) -> Linear<F> {
        self.plane.combine([a, b - a, c - a]).scaled(self.unit)
    }
}

/// Least and greatest of an attribute's three values, and whether it is what attributes usually are:
/// finite, not the same all over, and of a magnitude that fits. No zero in it is negative.
#[inline(always)]
pub(super) fn usual_range<F: Number>([p, q, r]: [F; 3]) -> ([F; 2], F::Truth) {
    let low = p.lesser(q).lesser(r);
    let high = p.greater(q).greater(r);
    // What is no number makes no number of this.
    let finite = (p * 0.0 + q * 0.0 + r * 0.0).eq(p.like(0.0));
    let magnitude = low.abs().greater(high.abs());
    let fits = p.like(1.0 / FITS).le(magnitude) & magnitude.lt(p.like(FITS));
    ([low + 0.0, high + 0.0], finite & low.lt(high) & fits)
}

impl Gradients {
    /// Sets up all but the attributes, if the bound is good enough; says whether it is.
    #[inline(always)]
    pub(super) fn set_in_view(&mut self, subject: &Subject<'_>) -> bool {
        if subject.exponent.abs() > LARGEST_EXPONENT {
            return false;
        }
        let (w, viewport) = (subject.clipped_w, subject.viewport);
        let reach = self.reach.u.max(self.reach.v);
        let (view, good) = View::new(&self.anchor.projection, self.corners, w, reach, viewport);
        if !good {
            return false;
        }
        let det = view.plane.det;
        self.q_error = PLANE_ERROR * view.square;
        self.det_relative_error = PLANE_ERROR * view.square * w[1] / det.abs();
        self.w_scale = det * power_of_two(subject.exponent);
        self.q_sign = 1.0_f64.copysign(det);
        self.strict = false;
        self.take_trusted_plane(view.plane.q, det, det.abs() / w[1]);
        self.frame.plane = view.plane;
        self.view = Some(view);
        self.set_derived(subject, |_, z| Self::depth_in_view(&view, z));
        true
    }

    /// Depth.
    #[inline(always)]
    pub(super) fn depth_in_view(view: &View, z: [f64; 3]) -> Field {
        let (numerator, doubtful_below) = view.depth(z);
        Field::Plain(Plain { numerator, over_w: false, doubtful_below, range: [0.0, 1.0] })
    }

    /// Attribute `k`, if it is usual and has perspective.
    #[inline(always)]
    pub(super) fn usual_in_view(&self, k: usize, subject: &Subject<'_>) -> Option<Field> {
        let values = self.triple_values(k, subject);
        let (range, usual) = usual_range(values);
        let over_w = subject.interpolation_of(k) == Interpolation::Perspective;
        let numerator = self.view.as_ref()?.numerator(values);
        (usual && over_w).then(|| Field::plain(numerator, true, range.map(nearest_f32)))
    }

    /// An attribute whose magnitude fits.
    #[inline(always)]
    pub(super) fn attribute_in_view(
        &self,
        values: [f64; 3],
        over_w: bool,
        range: [f32; 2],
    ) -> Field {
        let [b, c] = self.differences(values, over_w);
        if over_w {
            let combined = self.frame.plane.combine([values[0], b, c]);
            return Field::plain(combined.scaled(self.unit), true, range);
        }
        let Linear { x, y, c } = self.frame.plane.combine([0.0, b, c]).scaled(1.0 / self.det);
        Field::plain(Linear { x, y, c: c + values[0] }, false, range)
    }
}
