//! Set-up of what follows from the plane alone: depth, 1/w and w.

use fearless_simd::Simd;

use super::fine::Terms;
use super::frame::{Linear, U, nearby};
use super::twofold::Twofold;
use super::{Field, Gradients, Plain, Source, Strict, Subject, WITHIN_ULP, nearest_f32};
use crate::across::Carried;
use crate::exact::Dyadic;
use crate::fixed::power_of_two;
use crate::space::DepthRange;

impl Gradients {
    /// Depth, 1/w and w; `depth_of` finds depth over a flat polygon from z at the triple.
    #[inline(always)]
    pub(super) fn set_derived(
        &mut self,
        subject: &Subject<'_>,
        depth_of: impl FnOnce(&mut Self, [f64; 3]) -> Field,
    ) {
        let wanted = subject.wanted;
        let flat = self.shape.is_none_or(|shape| shape.flat);
        (self.depth, self.inv_w, self.w) = (None, None, None);
        if wanted.depth {
            self.depth = Some(if flat {
                let z = |i: usize| subject.depth_numerator(self.corners[i]);
                let z = [z(0), z(1), z(2)];
                // Seen from the side, it is another vertex that counts.
                let zero = z == [0.0; 3] && self.det != 0.0;
                if zero { Field::Constant(0.0) } else { depth_of(self, z) }
            } else {
                Field::Across(Carried::Depth(subject.viewport.depth_range()), [0.0, 1.0])
            });
        }
        if !(wanted.inv_w || wanted.w) {
            return;
        }
        let scale = power_of_two(subject.exponent);
        let [w_low, w_high] = subject.clipped_w.map(|w| w * scale);
        if wanted.w {
            let range = [w_low, w_high].map(nearest_f32);
            // det/Q: a numerator that does not change. Always strict: what is plain in `f32` at
            // one power of two need not be at another.
            self.w = Some(if flat {
                Field::Strict(Strict {
                    numerator: Linear { x: 0.0, y: 0.0, c: self.w_scale },
                    base: 0.0,
                    scale: 1.0,
                    error: self.w_scale.abs() * self.det_relative_error,
                    over_w: true,
                    range,
                })
            } else {
                Field::Across(Carried::W, range)
            });
        }
        if wanted.inv_w {
            let range = [1.0 / w_high, 1.0 / w_low].map(nearest_f32);
            let per_w = 1.0 / self.w_scale;
            self.inv_w = Some(if !flat {
                Field::Across(Carried::InvW, range)
            } else if self.strict {
                let error = self.q_error * per_w.abs();
                Field::Strict(Strict {
                    numerator: self.q,
                    base: 0.0,
                    scale: per_w,
                    error,
                    over_w: false,
                    range,
                })
            } else {
                Field::plain(self.q.scaled(per_w), false, range)
            });
        }
    }

    /// Depth over a flat polygon that is not in view, from `z` at the triple.
    #[inline(always)]
    pub(super) fn depth_field<S: Simd>(
        &mut self,
        simd: S,
        subject: &Subject<'_>,
        z: [f64; 3],
    ) -> Field {
        let bounded = if self.source == Source::Double {
            let size = z[0].abs().max(z[1].abs()).max(z[2].abs());
            // The sum and the difference, each rounded.
            self.frame.combine([z[0], z[1] - z[0], z[2] - z[0]], 4.0 * U * size)
        } else {
            let terms = self.fine_depths(subject);
            let fine = self.fine.as_ref().filter(|_| self.source == Source::Fine);
            fine.and_then(|frame| frame.combine(simd, &terms)).unwrap_or_else(|| {
                let terms = self.exact_depths(subject);
                let frame = Self::exact_frame(&mut self.exact, &self.anchor, self.corners);
                nearby(&frame.combine(&terms), self.reach)
            })
        };
        let scale = 1.0 / self.det;
        let range = [0.0, 1.0];
        let plain = bounded.scaled(scale, self.reach);
        // Also where the error is no number.
        if self.strict || plain.error.is_nan() || plain.error >= 1.0 {
            let error = bounded.error * scale.abs();
            let numerator = bounded.linear;
            return Field::Strict(Strict {
                numerator,
                base: 0.0,
                scale,
                error,
                over_w: false,
                range,
            });
        }
        Field::Plain(Plain {
            numerator: plain.linear,
            over_w: false,
            doubtful_below: plain.error * WITHIN_ULP,
            range,
        })
    }

    /// base, b and c of a [`fine::FineFrame::combine`](super::fine::FineFrame::combine) for depth.
    #[inline(always)]
    pub(super) fn fine_depths(&self, subject: &Subject<'_>) -> Terms {
        let [a, b, c] = self.corners.map(|[_, _, z, w]| match subject.viewport.depth_range() {
            DepthRange::ZeroToOne => Twofold::from_f64(z),
            // z + w, without error.
            DepthRange::MinusOneToOne => Twofold::difference(z, -w).times_number(0.5),
        });
        [a, b.add(a.negated()), c.add(a.negated())]
    }

    /// base, b and c of a [`frame::ExactFrame::combine`] for depth.
    pub(super) fn exact_depths(&self, subject: &Subject<'_>) -> [Dyadic; 3] {
        let [a, b, c] = self.corners.map(|[_, _, z, w]| match subject.viewport.depth_range() {
            DepthRange::ZeroToOne => Dyadic::from_f64(z),
            DepthRange::MinusOneToOne => {
                Dyadic::from_f64(z).add(&Dyadic::from_f64(w)).mul(&Dyadic::from_f64(0.5))
            }
        });
        [a.clone(), b.sub(&a), c.sub(&a)]
    }
}
