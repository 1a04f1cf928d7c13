//! Set-up of a small triangle within the view volume, in `Fast`: one bound for all its errors.
//!
//! Where every vertex is in view, all that the set-up computes is bounded by the greatest w, the
//! triangle's size in pixels and the viewport's; so one comparison with det tells that every
//! quantity is good enough, and nothing else is asked. docs/precision.md, "In view", derives the
//! numbers.

use super::frame::{Linear, Plane, U};
use super::{FITS, Field, Gradients, Plain, Subject, TRUSTED, WITHIN_ULP};
use crate::fixed::power_of_two;
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

impl Gradients {
    /// Sets up all but the attributes, if the bound is good enough; says whether it is.
    #[inline(always)]
    pub(super) fn set_in_view(&mut self, subject: &Subject<'_>) -> bool {
        let mut plane = Plane::new(&self.anchor, self.corners);
        let [w_low, w_high] = subject.clipped_w;
        let size = self.reach.u.max(self.reach.v) + 2.0;
        let [half_w, half_h] = subject.viewport.half_size();
        let view = 2.0 * half_w.max(half_h) + 1.0;
        let square = w_high * w_high * size * view;
        let det = plane.det.abs();
        let least_q = det / w_high;

        let slope_error = SLOPE_ERROR * w_high * w_high * view;
        // A slope that cannot be told from 0 is 0.
        for slope in [&mut plane.q.x, &mut plane.q.y] {
            if slope.abs() <= slope_error {
                *slope = 0.0;
            }
        }
        let beyond = (plane.q.x.abs() + plane.q.y.abs()) * subject.viewport.grid().snap_reach();
        let good = ATTRIBUTE_ERROR * square * w_high <= TRUSTED * det
            && beyond <= least_q / 2.0
            && subject.exponent.abs() <= LARGEST_EXPONENT
            && w_high <= w_low * FITS;
        if !good {
            return false;
        }
        self.q_error = PLANE_ERROR * square;
        self.det_relative_error = PLANE_ERROR * square * w_high / det;
        self.w_scale = plane.det * power_of_two(subject.exponent);
        self.q_sign = 1.0_f64.copysign(plane.det);
        self.strict = false;
        self.take_trusted_plane(plane.q, plane.det, least_q);
        self.frame.plane = plane;
        self.set_derived(subject);
        true
    }

    /// Depth.
    #[inline(always)]
    pub(super) fn depth_in_view(&self, z: [f64; 3]) -> Field {
        let (b, c) = (z[1] - z[0], z[2] - z[0]);
        let scale = 1.0 / self.det;
        let numerator = self.frame.plane.combine([z[0], b, c]).scaled(scale);
        let greatest = z[0].abs().max(z[1].abs()).max(z[2].abs());
        // q_error is PLANE_ERROR of W^2 D S.
        let [by_z, by_difference] = DEPTH_ERRORS.map(|error| error / PLANE_ERROR);
        let error = self.q_error * (by_z * greatest + by_difference * (b.abs() + c.abs()));
        let doubtful_below = error * scale.abs() * WITHIN_ULP;
        Field::Plain(Plain { numerator, over_w: false, doubtful_below, range: [0.0, 1.0] })
    }

    /// Attribute `k`, if it is what attributes usually are: finite, with perspective, and not
    /// the same all over.
    #[inline(always)]
    pub(super) fn usual_in_view(&self, k: usize, subject: &Subject<'_>) -> Option<Field> {
        let [p, q, r] = *self.values_of(k, subject).first_chunk()?;
        let (low, high) = if p < q { (p, q) } else { (q, p) };
        let low = if r < low { r } else { low };
        let high = if r > high { r } else { high };
        // What is no number makes no number of this.
        let finite = p * 0.0 + q * 0.0 + r * 0.0 == 0.0;
        let over_w = subject.interpolation_of(k) == Interpolation::Perspective;
        let magnitude = f64::from(if -low > high { -low } else { high });
        if !(finite && over_w && low < high && super::fits(magnitude)) {
            return None;
        }
        let [a, b, c] = self.triple_values(k, subject);
        let combined = self.frame.plane.combine([a, b - a, c - a]);
        Some(Field::plain(combined.scaled(self.unit), true, [low + 0.0, high + 0.0]))
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
