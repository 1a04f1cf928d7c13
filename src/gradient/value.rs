//! The value at one pixel, correctly rounded: what the X loop cannot tell.

use alloc::boxed::Box;
use core::cmp::Ordering;

use fearless_simd::{Level, dispatch};

use super::fine::{FineFrame, Terms, round_fine_quotient};
use super::frame::{Anchor, ExactFrame, exact_at};
use super::twofold::Twofold;
use super::{Gradients, Quantity, Subject};
use crate::exact::{Dyadic, round_quotient};
use crate::varying::Interpolation;

impl Gradients {
    /// The exact frame, made when it is first needed.
    pub(super) fn exact_frame<'a>(
        exact: &'a mut Option<Box<ExactFrame>>,
        anchor: &Anchor,
        corners: [[f64; 4]; 3],
    ) -> &'a ExactFrame {
        exact.get_or_insert_with(|| Box::new(ExactFrame::new(anchor, corners)))
    }

    /// The correctly rounded value of `quantity` at the pixel `pixel` from the anchor; not
    /// clamped. Nothing where the plane is edge-on or 1/w <= 0.
    pub(crate) fn exact_value(
        &mut self,
        subject: &Subject<'_>,
        quantity: Quantity,
        pixel: [i32; 2],
    ) -> Option<f32> {
        let fine = self.fine_value(subject, quantity, pixel);
        fine.or_else(|| self.value_without_error(subject, quantity, pixel))
    }

    /// The same in pairs of `f64`s, which nearly always leave no doubt.
    fn fine_value(
        &mut self,
        subject: &Subject<'_>,
        quantity: Quantity,
        pixel: [i32; 2],
    ) -> Option<f32> {
        let (anchor, corners, reach) = (&self.anchor, self.corners, self.reach);
        let make =
            || dispatch!(Level::baseline(), simd => FineFrame::new(simd, anchor, corners, reach));
        self.fine.get_or_insert_with(make);
        let here = self.fine.as_ref()?.at(pixel.map(f64::from));
        if !here.in_front() {
            return None;
        }
        match quantity {
            Quantity::InvW => round_fine_quotient(here.q(), here.det(), -subject.exponent),
            Quantity::W => round_fine_quotient(here.det(), here.q(), subject.exponent),
            Quantity::Depth => {
                let z = here.combine(&self.fine_depths(subject));
                round_fine_quotient(z, here.det(), 0)
            }
            Quantity::Attribute(k) => {
                let over_w = subject.interpolation_of(k) == Interpolation::Perspective;
                let terms = fine_values(&self.corners, self.triple_values(k, subject), over_w);
                if over_w {
                    round_fine_quotient(here.combine(&terms), here.q(), 0)
                } else {
                    round_fine_quotient(here.combine_over_det(terms), here.det(), 0)
                }
            }
        }
    }

    /// The same without any error.
    #[cold]
    fn value_without_error(
        &mut self,
        subject: &Subject<'_>,
        quantity: Quantity,
        [u, v]: [i32; 2],
    ) -> Option<f32> {
        Self::exact_frame(&mut self.exact, &self.anchor, self.corners);
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
                let values = self.triple_values(k, subject);
                let [base, b, c] = exact_values(&self.corners, values, over_w);
                let differences = frame.combine(&[Dyadic::default(), b, c]);
                let denominator = if over_w { &q } else { &frame.det };
                let numerator = exact_at(&differences, u, v).add(&base.mul(denominator));
                round_quotient(&numerator, denominator)
            }
        })
    }
}

/// base, b and c of a [`ExactFrame::combine`] for an attribute over Q, or over det.
pub(super) fn exact_values(corners: &[[f64; 4]; 3], values: [f64; 3], over_w: bool) -> [Dyadic; 3] {
    let [a, b, c] = values.map(Dyadic::from_f64);
    let weigh = |value: Dyadic, i: usize| {
        if over_w { value } else { value.mul(&Dyadic::from_f64(corners[i][3])) }
    };
    [a.clone(), weigh(b.sub(&a), 1), weigh(c.sub(&a), 2)]
}

/// The same of a [`FineFrame::combine`].
#[inline(always)]
pub(super) fn fine_values(corners: &[[f64; 4]; 3], [a, b, c]: [f64; 3], over_w: bool) -> Terms {
    let weigh = |value: Twofold, i: usize| {
        if over_w { value } else { value.times_number(corners[i][3]) }
    };
    let difference = Twofold::difference;
    [Twofold::from_f64(a), weigh(difference(b, a), 1), weigh(difference(c, a), 2)]
}
