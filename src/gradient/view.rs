//! Set-up of a small triangle within the view volume, in `Fast`: one bound for all its errors.
//!
//! Where every vertex is in view, all that the set-up computes is bounded by the greatest w, the
//! triangle's size in pixels and the viewport's; so one comparison with det tells that every
//! quantity is good enough, and nothing else is asked. docs/precision.md, "In view", derives the
//! numbers.

use super::frame::{Anchor, Linear, Plane, Reach, U};
use super::{
    ConstantAlong, FITS, Field, Gradients, Plain, Subject, TRUSTED, WITHIN_ULP, constant_along,
};
use crate::fixed::{exponent_of, power_of_two};
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

/// The plane of a triangle that the one bound is good enough for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    /// Q and the weights, all times det; a slope of Q that cannot be told from 0 is 0.
    plane: Plane,
    /// The power of two that brings the least Q into 1..2, negative where Q is; and Q times that.
    unit: f64,
    pub(crate) unit_q: Linear,
    pub(crate) constant: ConstantAlong,
    /// W^2 D S.
    square: f64,
}

impl View {
    /// Of `corners`, whose least and greatest w are `w`; nothing if the bound is not good enough.
    #[inline(always)]
    pub(crate) fn new(
        anchor: &Anchor,
        corners: [[f64; 4]; 3],
        [w_low, w_high]: [f64; 2],
        reach: Reach,
        viewport: Viewport,
    ) -> Option<Self> {
        let mut plane = Plane::new(anchor, corners);
        let size = reach.u.max(reach.v) + 2.0;
        let [half_w, half_h] = viewport.half_size();
        let view = 2.0 * half_w.max(half_h) + 1.0;
        let square = w_high * w_high * size * view;
        let det = plane.det.abs();
        let least_q = det / w_high;

        let slope_error = SLOPE_ERROR * w_high * w_high * view;
        if plane.q.x.abs() <= slope_error {
            plane.q.x = 0.0;
        }
        if plane.q.y.abs() <= slope_error {
            plane.q.y = 0.0;
        }
        let beyond = (plane.q.x.abs() + plane.q.y.abs()) * viewport.grid().snap_reach();
        let good = ATTRIBUTE_ERROR * square * w_high <= TRUSTED * det
            && beyond <= least_q / 2.0
            && w_high <= w_low * FITS;
        let unit = power_of_two(-exponent_of(least_q).unwrap_or(0)).copysign(plane.det);
        let unit_q = plane.q.scaled(unit);
        let constant = constant_along(plane.q);
        good.then_some(Self { plane, unit, unit_q, constant, square })
    }

    /// z/w as a linear function, of `z` at the corners, and the magnitude below which it is in doubt.
    #[inline(always)]
    pub(crate) fn depth(&self, z: [f64; 3]) -> (Linear, f64) {
        let (b, c) = (z[1] - z[0], z[2] - z[0]);
        let scale = 1.0 / self.plane.det;
        let numerator = self.plane.combine([z[0], b, c]).scaled(scale);
        let greatest = z[0].abs().max(z[1].abs()).max(z[2].abs());
        let [by_z, by_difference] = DEPTH_ERRORS;
        let error = self.square * (by_z * greatest + by_difference * (b.abs() + c.abs()));
        (numerator, error * scale.abs() * WITHIN_ULP)
    }

    /// The numerator over Q, times the unit, of an attribute with these values at the corners.
    #[inline(always)]
    pub(crate) fn numerator(&self, [a, b, c]: [f64; 3]) -> Linear {
        self.plane.combine([a, b - a, c - a]).scaled(self.unit)
    }
}

/// Least and greatest of an attribute's three values, if it is what attributes usually are:
/// finite, not the same all over, and of a magnitude that fits.
#[inline(always)]
pub(crate) fn usual_range([p, q, r]: [f32; 3]) -> Option<[f32; 2]> {
    let (low, high) = if p < q { (p, q) } else { (q, p) };
    let low = if r < low { r } else { low };
    let high = if r > high { r } else { high };
    // What is no number makes no number of this.
    let finite = p * 0.0 + q * 0.0 + r * 0.0 == 0.0;
    let magnitude = f64::from(if -low > high { -low } else { high });
    (finite && low < high && super::fits(magnitude)).then_some([low + 0.0, high + 0.0])
}

impl Gradients {
    /// Sets up all but the attributes, if the bound is good enough; says whether it is.
    #[inline(always)]
    pub(super) fn set_in_view(&mut self, subject: &Subject<'_>) -> bool {
        if subject.exponent.abs() > LARGEST_EXPONENT {
            return false;
        }
        let (w, viewport) = (subject.clipped_w, subject.viewport);
        let Some(view) = View::new(&self.anchor, self.corners, w, self.reach, viewport) else {
            return false;
        };
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
        let range = usual_range(*self.values_of(k, subject).first_chunk()?)?;
        let over_w = subject.interpolation_of(k) == Interpolation::Perspective;
        let numerator = self.view.as_ref()?.numerator(self.triple_values(k, subject));
        over_w.then(|| Field::plain(numerator, true, range))
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
