//! Set-up: from a polygon's plane to what changes from pixel to pixel, and what does not.
//!
//! Over a flat polygon every attribute is s = D/Q + s_a with D and Q = det/w linear in the
//! framebuffer; depth and 1/w are linear themselves. They come from the unsnapped vertices as
//! given, before clipping, so that they are as good at w < 0 as anywhere. Here they are found in
//! `f64` with a bound of their error, or exactly where the bound says so; then put into fixed
//! point. What is constant is found out and costs nothing later.

pub(crate) mod frame;
pub(crate) mod triple;

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::cmp::Ordering;

use crate::clip::VertexArrays;
use crate::exact::{Dyadic, round_quotient};
use crate::fixed::{FixedPlane, power_of_two};
use crate::polygon::Polygon;
use crate::space::{DepthRange, Viewport};
use crate::varying::{CANONICAL_NAN, Interpolation};

use frame::{Anchor, ExactFrame, Frame, Reach, U, exact_at, exact_to_fixed};

/// How a quantity runs over the polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Field {
    /// The same at every pixel.
    Constant(f32),
    /// base + D/Q, or base + D/det.
    Affine(Affine),
}

/// A quantity that is base + D `scale` / Q or, if not `over_w`, base + D `scale`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Affine {
    /// D.
    pub(crate) plane: FixedPlane,
    pub(crate) base: f64,
    /// From units of D (over units of Q) to the quantity.
    pub(crate) scale: f64,
    /// Bound of D's error at any pixel, times `scale`.
    pub(crate) error: f64,
    pub(crate) over_w: bool,
    /// What the value is clamped to: finite, and no zero in it is negative.
    pub(crate) range: [f32; 2],
}

/// A quantity, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Depth,
    InvW,
    W,
    Attribute(usize),
}

/// Along what 1/w does not change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum ConstantAlong {
    #[default]
    Nothing,
    Polygon,
    Row,
    Column,
}

/// A polygon on its way through the set-up.
#[derive(Debug)]
pub(crate) struct Subject<'a, V: ?Sized> {
    pub(crate) polygon: &'a V,
    pub(crate) viewport: Viewport,
    /// The positions as given, times 2^-`exponent`.
    pub(crate) positions: &'a VertexArrays,
    pub(crate) exponent: i32,
    pub(crate) interpolation: &'a [Interpolation],
    /// Least and greatest w of the clipped polygon, scaled as `positions` are.
    pub(crate) clipped_w: [f64; 2],
    /// The covered pixels lie in these columns and rows of the framebuffer: first and last.
    pub(crate) columns: [i32; 2],
    pub(crate) rows: [i32; 2],
    /// How many they are.
    pub(crate) pixels: u64,
}

impl<V: Polygon + ?Sized> Subject<'_, V> {
    /// How attribute `k` is interpolated.
    fn interpolation_of(&self, k: usize) -> Interpolation {
        self.interpolation.get(k).copied().unwrap_or_default()
    }

    /// z as depth has it, before the division.
    fn depth_numerator(&self, [_, _, z, w]: [f64; 4]) -> f64 {
        match self.viewport.depth_range() {
            DepthRange::ZeroToOne => z,
            DepthRange::MinusOneToOne => (z + w) / 2.0,
        }
    }
}

/// What the X loop needs of a polygon.
#[derive(Debug, Default)]
pub(crate) struct Gradients {
    pub(crate) anchor: Anchor,
    triple: [usize; 3],
    corners: [[f64; 4]; 3],
    /// Made when first needed.
    exact: Option<Box<ExactFrame>>,
    /// Q = det/w in fixed point, its error in units, and the sign it has where 1/w > 0; 0 if
    /// the polygon is edge-on.
    pub(crate) q: FixedPlane,
    pub(crate) q_error: f64,
    pub(crate) q_sign: f64,
    /// w times the units of Q, the relative error of det, and the range of w.
    pub(crate) w_scale: f64,
    pub(crate) det_relative_error: f64,
    pub(crate) w_range: [f32; 2],
    pub(crate) constant: ConstantAlong,
    pub(crate) depth: Option<Field>,
    pub(crate) inv_w: Option<Field>,
    pub(crate) attributes: Vec<Field>,
}

/// Ambiguous values for which a set-up in `f64` is not worth its price: an exact one costs as
/// much as so many exact values.
const EXACT_SETUP_COST: f64 = 8.0;

/// How many of the pixels a relative error makes ambiguous: both sides of each rounding
/// boundary of `f32`, by its error.
const AMBIGUITY: f64 = 33_554_432.0;

/// Which frame the set-up goes by.
enum Source<'a> {
    Near(&'a Frame),
    Exact(&'a ExactFrame),
}

impl Gradients {
    /// Sets up the first `attributes` attributes of `subject`, and depth and 1/w if asked for.
    pub(crate) fn set<V: Polygon + ?Sized>(
        &mut self,
        subject: &Subject<'_, V>,
        attributes: usize,
        with_depth: bool,
        with_inv_w: bool,
    ) {
        self.triple = triple::choose(subject.positions, subject.polygon);
        self.corners = self.triple.map(|i| subject.positions.position(i));
        self.exact = None;
        let middle = [subject.columns, subject.rows].map(|[first, last]| first.midpoint(last));
        self.anchor = Anchor::new(subject.viewport, middle);
        let reach =
            |[first, last]: [i32; 2], middle: i32| f64::from((middle - first).max(last - middle));
        let reach =
            Reach { u: reach(subject.columns, middle[0]), v: reach(subject.rows, middle[1]) };

        let frame = Frame::new(&self.anchor, self.corners);
        let share =
            self.fill(subject, &Source::Near(&frame), reach, attributes, with_depth, with_inv_w);
        #[expect(clippy::cast_precision_loss, reason = "an estimate")]
        let ambiguous = share * subject.pixels as f64;
        // Also where the bound is no number.
        let good_enough = ambiguous <= EXACT_SETUP_COST;
        if !good_enough {
            let frame = ExactFrame::new(&self.anchor, self.corners);
            if frame.det.sign() == Ordering::Equal {
                (self.q_sign, self.det_relative_error) = (0.0, f64::NAN);
                self.constant = ConstantAlong::Nothing;
            } else {
                self.fill(
                    subject,
                    &Source::Exact(&frame),
                    reach,
                    attributes,
                    with_depth,
                    with_inv_w,
                );
            }
            self.exact = Some(Box::new(frame));
        }
    }

    /// Everything from one source; returns how many values a pixel has, at the most, for which
    /// the bounds do not tell the rounding.
    fn fill<V: Polygon + ?Sized>(
        &mut self,
        subject: &Subject<'_, V>,
        source: &Source<'_>,
        reach: Reach,
        attributes: usize,
        with_depth: bool,
        with_inv_w: bool,
    ) -> f64 {
        let (det, det_error) = self.fill_q(source, reach);
        self.det_relative_error = det_error / det.abs() + 2.0 * U;
        let det_is_certain = self.det_relative_error < 1.0 / 256.0;
        // Where the sign is unknown every value is ambiguous, and found exactly.
        self.q_sign = if det_is_certain { 1.0_f64.copysign(det) } else { 0.0 };
        let scale = power_of_two(subject.exponent);
        self.w_scale = det * power_of_two(self.q.fraction_bits) * scale;
        let [w_low, w_high] = subject.clipped_w;
        self.w_range = [w_low * scale, w_high * scale].map(nearest_f32);
        // det/w in the units of Q where w is greatest.
        let least_q = det.abs() / w_high * power_of_two(self.q.fraction_bits);
        // A sum, so that what is no number stays none.
        let mut ambiguous = self.q_error / least_q + self.det_relative_error;

        self.inv_w = with_inv_w.then(|| {
            let range = [1.0 / (w_high * scale), 1.0 / (w_low * scale)].map(nearest_f32);
            Field::Affine(Affine {
                plane: self.q,
                base: 0.0,
                scale: 1.0 / self.w_scale,
                error: self.q_error / self.w_scale.abs(),
                over_w: false,
                range,
            })
        });
        self.depth = with_depth.then(|| {
            let z = self.corners.map(|p| subject.depth_numerator(p));
            let size = z.iter().fold(0.0, |a: f64, z| a.max(z.abs()));
            let rounding = match subject.viewport.depth_range() {
                DepthRange::ZeroToOne => 2.0,
                DepthRange::MinusOneToOne => 4.0,
            };
            let near = |frame: &Frame| {
                let differences = [z[0], z[1] - z[0], z[2] - z[0]];
                frame.combine(differences, rounding * U * size).to_fixed(reach)
            };
            let exactly = |frame: &ExactFrame| {
                exact_to_fixed(&frame.combine(&self.exact_depths(subject)), reach)
            };
            let (plane, error) = linear(source, near, exactly);
            let scale = power_of_two(-plane.fraction_bits) / det;
            let error = error * scale.abs();
            // Against the depth in the middle, for want of a least one.
            ambiguous += error / (widen(plane.c) * scale).abs().max(1e-12);
            Field::Affine(Affine {
                plane,
                base: 0.0,
                scale,
                error,
                over_w: false,
                range: [0.0, 1.0],
            })
        });

        self.attributes.clear();
        for k in 0..attributes {
            let field = match self.constant_attribute(subject, k) {
                Ok(value) => Field::Constant(value),
                Err(range) => {
                    let over_w = subject.interpolation_of(k) == Interpolation::Perspective;
                    let values = self.triple.map(|i| f64::from(subject.polygon.attribute(i, k)));
                    let near = |frame: &Frame| {
                        let [b, c] = [1, 2].map(|i| {
                            let weight = if over_w { 1.0 } else { self.corners[i][3] };
                            weight * (values[i] - values[0])
                        });
                        let size = b.abs().max(c.abs());
                        frame.combine([0.0, b, c], 3.0 * U * size).to_fixed(reach)
                    };
                    let exactly = |frame: &ExactFrame| {
                        let mut parts = self.exact_values(values, over_w);
                        parts[0] = Dyadic::default();
                        exact_to_fixed(&frame.combine(&parts), reach)
                    };
                    let (plane, error) = linear(source, near, exactly);
                    let scale = if over_w {
                        power_of_two(self.q.fraction_bits - plane.fraction_bits)
                    } else {
                        power_of_two(-plane.fraction_bits) / det
                    };
                    let error = error * scale.abs();
                    let size = f64::from(range[0].abs().max(range[1].abs()));
                    let largest = if over_w { error / least_q } else { error };
                    ambiguous += largest / size;
                    Field::Affine(Affine { plane, base: values[0], scale, error, over_w, range })
                }
            };
            self.attributes.push(field);
        }
        ambiguous * AMBIGUITY
    }

    /// Q in fixed point, and what is constant; returns det and its error.
    fn fill_q(&mut self, source: &Source<'_>, reach: Reach) -> (f64, f64) {
        let (det, det_error);
        match source {
            Source::Near(frame) => {
                let mut q = frame.q;
                // What cannot be told from 0 is 0, and the bound says what that may cost.
                for k in 0..2 {
                    if q.k[k].abs() <= q.error[k] {
                        q.error[k] += q.k[k].abs();
                        q.k[k] = 0.0;
                    }
                }
                (self.q, self.q_error) =
                    q.to_fixed(reach).unwrap_or((FixedPlane::default(), f64::NAN));
                (det, det_error) = (frame.det, frame.det_error);
            }
            Source::Exact(frame) => {
                (self.q, self.q_error) = exact_to_fixed(&frame.q, reach);
                det = frame.det.to_f64_near();
                det_error = 8.0 * U * det.abs();
            }
        }
        self.constant = match (self.q.d_dx, self.q.d_dy) {
            (0, 0) => ConstantAlong::Polygon,
            (0, _) => ConstantAlong::Row,
            (_, 0) => ConstantAlong::Column,
            _ => ConstantAlong::Nothing,
        };
        (det, det_error)
    }

    /// The value of attribute `k` if it is the same all over, else its range.
    fn constant_attribute<V: Polygon + ?Sized>(
        &self,
        subject: &Subject<'_, V>,
        k: usize,
    ) -> Result<f32, [f32; 2]> {
        let first = subject.polygon.attribute(0, k);
        let (mut low, mut high, mut same) = (first, first, true);
        let mut finite = first.is_finite();
        for i in 1..subject.polygon.len() {
            let value = subject.polygon.attribute(i, k);
            same &= value.to_bits() == first.to_bits();
            finite &= value.is_finite();
            low = if value < low { value } else { low };
            high = if value > high { value } else { high };
        }
        let flat = subject.interpolation_of(k) == Interpolation::Flat;
        if first.is_nan() && (same || flat) {
            Ok(CANONICAL_NAN)
        } else if same || flat {
            Ok(first)
        } else if !finite {
            Ok(CANONICAL_NAN)
        } else if low == high {
            // Zeros of both signs.
            Ok(0.0)
        } else {
            // No bound is a negative zero: a real number that is clamped to 0 is +0.
            Err([low + 0.0, high + 0.0])
        }
    }

    /// base, b and c of a [`frame::ExactFrame::combine`] for an attribute over Q, or over det.
    fn exact_values(&self, values: [f64; 3], over_w: bool) -> [Dyadic; 3] {
        let [a, b, c] = values.map(Dyadic::from_f64);
        let weigh = |value: Dyadic, i: usize| {
            if over_w { value } else { value.mul(&Dyadic::from_f64(self.corners[i][3])) }
        };
        [a.clone(), weigh(b.sub(&a), 1), weigh(c.sub(&a), 2)]
    }

    /// The same for depth.
    fn exact_depths<V: ?Sized>(&self, subject: &Subject<'_, V>) -> [Dyadic; 3] {
        let [a, b, c] = self.corners.map(|[_, _, z, w]| match subject.viewport.depth_range() {
            DepthRange::ZeroToOne => Dyadic::from_f64(z),
            DepthRange::MinusOneToOne => {
                Dyadic::from_f64(z).add(&Dyadic::from_f64(w)).mul(&Dyadic::from_f64(0.5))
            }
        });
        [a.clone(), b.sub(&a), c.sub(&a)]
    }

    /// The correctly rounded value of `quantity` at the pixel (`u`, `v`) from the anchor; not
    /// clamped. Nothing where the plane is edge-on or 1/w <= 0.
    pub(crate) fn exact_value<V: Polygon + ?Sized>(
        &mut self,
        subject: &Subject<'_, V>,
        quantity: Quantity,
        u: i32,
        v: i32,
    ) -> Option<f32> {
        if self.exact.is_none() {
            self.exact = Some(Box::new(ExactFrame::new(&self.anchor, self.corners)));
        }
        let frame = self.exact.as_deref()?;
        let q = exact_at(&frame.q, u, v);
        let det_sign = frame.det.sign();
        if det_sign == Ordering::Equal || q.sign() != det_sign {
            return None;
        }
        let scaled_det = || frame.det.scaled(subject.exponent);
        Some(match quantity {
            Quantity::InvW => round_quotient(&q, &scaled_det()),
            Quantity::W => round_quotient(&scaled_det(), &q),
            Quantity::Depth => {
                let z = frame.combine(&self.exact_depths(subject));
                round_quotient(&exact_at(&z, u, v), &frame.det)
            }
            Quantity::Attribute(k) => {
                let over_w = subject.interpolation_of(k) == Interpolation::Perspective;
                let values = self.triple.map(|i| f64::from(subject.polygon.attribute(i, k)));
                let [base, b, c] = self.exact_values(values, over_w);
                if over_w {
                    round_quotient(&exact_at(&frame.combine(&[base, b, c]), u, v), &q)
                } else {
                    let differences = frame.combine(&[Dyadic::default(), b, c]);
                    let numerator = exact_at(&differences, u, v).add(&base.mul(&frame.det));
                    round_quotient(&numerator, &frame.det)
                }
            }
        })
    }

    /// What `quantity` is clamped to.
    pub(crate) fn range(&self, quantity: Quantity) -> [f32; 2] {
        let field = match quantity {
            Quantity::Depth => self.depth,
            Quantity::InvW => self.inv_w,
            Quantity::W => return self.w_range,
            Quantity::Attribute(k) => self.attributes.get(k).copied(),
        };
        match field {
            Some(Field::Affine(affine)) => affine.range,
            Some(Field::Constant(value)) => [value; 2],
            None => [f32::NEG_INFINITY, f32::INFINITY],
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.attributes.capacity() * size_of::<Field>()
    }
}

/// A linear function in fixed point from whichever source, and its error in units.
fn linear(
    source: &Source<'_>,
    near: impl FnOnce(&Frame) -> Option<(FixedPlane, f64)>,
    exactly: impl FnOnce(&ExactFrame) -> (FixedPlane, f64),
) -> (FixedPlane, f64) {
    match source {
        Source::Near(frame) => near(frame).unwrap_or((FixedPlane::default(), f64::INFINITY)),
        Source::Exact(frame) => exactly(frame),
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rounding to nearest is what is meant")]
pub(crate) fn nearest_f32(value: f64) -> f32 {
    value as f32
}

#[expect(clippy::cast_precision_loss, reason = "the bounds have room for the rounding")]
#[inline]
pub(crate) fn widen(units: i64) -> f64 {
    units as f64
}
