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

use crate::across::Carried;
use crate::clip::VertexArrays;
use crate::exact::{Dyadic, round_quotient};
use crate::fixed::{FixedPlane, power_of_two};
use crate::polygon::Polygon;
use crate::space::{DepthRange, Viewport};
use crate::varying::{CANONICAL_NAN, Interpolation};

use triple::AffineFrame;

use frame::{Anchor, ExactFrame, Frame, Reach, U, exact_at, exact_to_fixed};

/// How a quantity runs over the polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Field {
    /// The same at every pixel.
    Constant(f32),
    /// base + D/Q, or base + D/det.
    Affine(Affine),
    /// det/Q, clamped to the range: w itself.
    W([f32; 2]),
    /// Not affine: along the edges and across the span; clamped to the range.
    Across(Carried, [f32; 2]),
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
    /// Which quantities are wanted.
    pub(crate) wanted: Wanted,
}

/// Which quantities a polygon is drawn for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    pub(crate) depth: bool,
    pub(crate) inv_w: bool,
    pub(crate) w: bool,
    /// The first so many, of as many as there are.
    pub(crate) attributes: usize,
}

/// What the tests of flatness found.
#[derive(Clone, Copy, Debug)]
struct Shape {
    /// The plane of (x, y, w), and that of the framebuffer where all w > 0; nothing for a
    /// triangle's, over which everything is affine.
    plane: Option<AffineFrame>,
    framebuffer: Option<AffineFrame>,
    flat: bool,
    in_front: bool,
}

impl<V: Polygon + ?Sized> Subject<'_, V> {
    /// How attribute `k` is interpolated.
    pub(crate) fn interpolation_of(&self, k: usize) -> Interpolation {
        self.interpolation.get(k).copied().unwrap_or_default()
    }

    /// z as depth has it, before the division.
    pub(crate) fn depth_numerator(&self, [_, _, z, w]: [f64; 4]) -> f64 {
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
    /// w times the units of Q, and the relative error of det.
    pub(crate) w_scale: f64,
    pub(crate) det_relative_error: f64,
    pub(crate) constant: ConstantAlong,
    pub(crate) depth: Option<Field>,
    pub(crate) inv_w: Option<Field>,
    pub(crate) w: Option<Field>,
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
    /// Sets up what is wanted of `subject`.
    pub(crate) fn set<V: Polygon + ?Sized>(&mut self, subject: &Subject<'_, V>) {
        self.triple = triple::choose(subject.positions, subject.polygon);
        self.corners = self.triple.map(|i| subject.positions.position(i));
        self.exact = None;
        let shape = self.shape(subject);
        let middle = [subject.columns, subject.rows].map(|[first, last]| first.midpoint(last));
        self.anchor = Anchor::new(subject.viewport, middle);
        let reach =
            |[first, last]: [i32; 2], middle: i32| f64::from((middle - first).max(last - middle));
        let reach =
            Reach { u: reach(subject.columns, middle[0]), v: reach(subject.rows, middle[1]) };

        let frame = Frame::new(&self.anchor, self.corners);
        let share = self.fill(subject, &shape, &Source::Near(&frame), reach);
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
                self.fill(subject, &shape, &Source::Exact(&frame), reach);
            }
            self.exact = Some(Box::new(frame));
        }
    }

    /// Is it flat, and what would have to be affine over what?
    fn shape<V: ?Sized>(&self, subject: &Subject<'_, V>) -> Shape {
        let positions = subject.positions;
        let in_front = (0..positions.len()).all(|i| positions.position(i)[3] > 0.0);
        if positions.len() == 3 {
            return Shape { plane: None, framebuffer: None, flat: true, in_front };
        }
        let plane = AffineFrame::new(self.triple, |i| triple::projective(positions, i));
        let framebuffer =
            in_front.then(|| AffineFrame::new(self.triple, |i| triple::divided(positions, i)));
        Shape { plane: Some(plane), framebuffer, flat: plane.is_flat(positions), in_front }
    }

    /// Everything from one source; returns how many values a pixel has, at the most, for which
    /// the bounds do not tell the rounding.
    fn fill<V: Polygon + ?Sized>(
        &mut self,
        subject: &Subject<'_, V>,
        shape: &Shape,
        source: &Source<'_>,
        reach: Reach,
    ) -> f64 {
        let (det, det_error) = self.fill_q(source, reach);
        self.det_relative_error = det_error / det.abs() + 2.0 * U;
        let det_is_certain = self.det_relative_error < 1.0 / 256.0;
        // Where the sign is unknown every value is ambiguous, and found exactly.
        self.q_sign = if det_is_certain { 1.0_f64.copysign(det) } else { 0.0 };
        let scale = power_of_two(subject.exponent);
        self.w_scale = det * power_of_two(self.q.fraction_bits) * scale;
        let [w_low, w_high] = subject.clipped_w;
        // det/w in the units of Q where w is greatest.
        let least_q = det.abs() / w_high * power_of_two(self.q.fraction_bits);
        // A sum, so that what is no number stays none.
        let mut ambiguous = self.q_error / least_q + self.det_relative_error;

        let wanted = subject.wanted;
        let range = [w_low * scale, w_high * scale].map(nearest_f32);
        self.w = wanted.w.then_some(if shape.flat {
            Field::W(range)
        } else {
            Field::Across(Carried::W, range)
        });
        let range = [1.0 / (w_high * scale), 1.0 / (w_low * scale)].map(nearest_f32);
        self.inv_w = wanted.inv_w.then_some(if shape.flat {
            Field::Affine(Affine {
                plane: self.q,
                base: 0.0,
                scale: 1.0 / self.w_scale,
                error: self.q_error / self.w_scale.abs(),
                over_w: false,
                range,
            })
        } else {
            Field::Across(Carried::InvW, range)
        });
        self.depth = wanted.depth.then(|| {
            if shape.flat {
                let (depth, error) = self.depth_field(subject, source, reach, det);
                ambiguous += error;
                depth
            } else {
                let range = subject.viewport.depth_range();
                Field::Across(Carried::Depth(range), [0.0, 1.0])
            }
        });
        self.attributes.clear();
        for k in 0..wanted.attributes {
            let field = match self.constant_attribute(subject, k) {
                Ok(value) => Field::Constant(value),
                Err(range) => match self.carried_across(subject, shape, k, range) {
                    Some(carried) => Field::Across(carried, range),
                    None => {
                        let affine = self.attribute_field(subject, source, reach, det, k, range);
                        let size = f64::from(range[0].abs().max(range[1].abs()));
                        let least = if affine.over_w { least_q } else { 1.0 };
                        ambiguous += affine.error / least / size;
                        Field::Affine(affine)
                    }
                },
            };
            self.attributes.push(field);
        }
        ambiguous * AMBIGUITY
    }

    /// Depth over a flat polygon, and its error relative to the depth in the middle, for want
    /// of a least one.
    fn depth_field<V: Polygon + ?Sized>(
        &self,
        subject: &Subject<'_, V>,
        source: &Source<'_>,
        reach: Reach,
        det: f64,
    ) -> (Field, f64) {
        let near = |frame: &Frame| {
            let z = self.corners.map(|p| subject.depth_numerator(p));
            let size = z.iter().fold(0.0, |a: f64, z| a.max(z.abs()));
            // The sum and the difference, each rounded.
            frame.combine([z[0], z[1] - z[0], z[2] - z[0]], 4.0 * U * size).to_fixed(reach)
        };
        let exactly =
            |frame: &ExactFrame| exact_to_fixed(&frame.combine(&self.exact_depths(subject)), reach);
        let (plane, error) = linear(source, near, exactly);
        let scale = power_of_two(-plane.fraction_bits) / det;
        let error = error * scale.abs();
        let middle = (widen(plane.c) * scale).abs();
        let field = Affine { plane, base: 0.0, scale, error, over_w: false, range: [0.0, 1.0] };
        (Field::Affine(field), error / middle.max(1e-12))
    }

    /// Attribute `k`, which is affine and not constant.
    fn attribute_field<V: Polygon + ?Sized>(
        &self,
        subject: &Subject<'_, V>,
        source: &Source<'_>,
        reach: Reach,
        det: f64,
        k: usize,
        range: [f32; 2],
    ) -> Affine {
        let over_w = subject.interpolation_of(k) == Interpolation::Perspective;
        let values = self.triple.map(|i| f64::from(subject.polygon.attribute(i, k)));
        let near = |frame: &Frame| {
            let [b, c] = [1, 2].map(|i| {
                let weight = if over_w { 1.0 } else { self.corners[i][3] };
                weight * (values[i] - values[0])
            });
            frame.combine([0.0, b, c], 3.0 * U * b.abs().max(c.abs())).to_fixed(reach)
        };
        let exactly = |frame: &ExactFrame| {
            let [_, b, c] = self.exact_values(values, over_w);
            exact_to_fixed(&frame.combine(&[Dyadic::default(), b, c]), reach)
        };
        let (plane, error) = linear(source, near, exactly);
        let scale = if over_w {
            power_of_two(self.q.fraction_bits - plane.fraction_bits)
        } else {
            power_of_two(-plane.fraction_bits) / det
        };
        Affine { plane, base: values[0], scale, error: error * scale.abs(), over_w, range }
    }

    /// How attribute `k`, which is not constant, runs if it is not affine.
    fn carried_across<V: Polygon + ?Sized>(
        &self,
        subject: &Subject<'_, V>,
        shape: &Shape,
        k: usize,
        range: [f32; 2],
    ) -> Option<Carried> {
        let positions = subject.positions;
        let value = |i: usize| f64::from(subject.polygon.attribute(i, k));
        let range = f64::from(range[1]) - f64::from(range[0]);
        let n = positions.len();
        if subject.interpolation_of(k) == Interpolation::Perspective {
            let point = |i: usize| triple::projective(positions, i);
            let affine = shape.flat
                && shape.plane.is_none_or(|plane| plane.is_affine(n, range, point, value));
            (!affine).then_some(Carried::Perspective(k))
        } else {
            let point = |i: usize| triple::divided(positions, i);
            let affine = shape.in_front
                && shape.framebuffer.is_none_or(|plane| plane.is_affine(n, range, point, value));
            (!affine).then_some(Carried::Linear(k))
        }
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

    /// How `quantity` runs, if it was asked for.
    pub(crate) fn field(&self, quantity: Quantity) -> Option<Field> {
        match quantity {
            Quantity::Depth => self.depth,
            Quantity::InvW => self.inv_w,
            Quantity::W => self.w,
            Quantity::Attribute(k) => self.attributes.get(k).copied(),
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
