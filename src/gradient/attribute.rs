//! Set-up of the attributes: for each, how it runs over the polygon, and from what.

use super::frame::{Bounded, Frame, U, nearby};
use super::triple::{self, AffineFrame};
use super::{
    ConstantAlong, Field, Gradients, Strict, Subject, TRUSTED, WORTH_EXACT_SETUP, exact_values,
    fits,
};
use crate::across::Carried;
use crate::exact::Dyadic;
use crate::varying::{CANONICAL_NAN, Interpolation};

impl Gradients {
    /// Sets up the attributes.
    #[inline(always)]
    pub(crate) fn set_attributes(&mut self, subject: &Subject<'_>) {
        self.has_attributes = true;
        subject.attributes.gather(subject.wanted.attributes, &mut self.values);
        self.attributes.clear();
        self.attributes.reserve(subject.wanted.attributes);
        for k in 0..subject.wanted.attributes {
            if let Some(field) = self.usual_in_view(k, subject) {
                self.attributes.push(field);
                continue;
            }
            let is_flat = subject.interpolation_of(k) == Interpolation::Flat;
            let field = match constant_attribute(self.values_of(k, subject), is_flat) {
                Ok(value) => Field::Constant(value),
                Err(range) => match self.carried_across(subject, k, range) {
                    Some(carried) => Field::Across(carried, range),
                    None => self.attribute_field(subject, k, range),
                },
            };
            self.attributes.push(field);
        }
        if self.constant == ConstantAlong::Polygon && !self.strict {
            self.divide_once();
        }
        self.divides = self
            .attributes
            .iter()
            .any(|field| matches!(field, Field::Plain(plain) if plain.over_w));
    }

    /// Divides what is plain by Q, which is the same all over: one rounding for each value is left,
    /// and no product.
    #[inline(always)]
    fn divide_once(&mut self) {
        for field in &mut self.attributes {
            if let Field::Plain(plain) = field
                && plain.over_w
            {
                plain.numerator = plain.numerator.scaled(1.0 / self.unit_q.c);
                plain.over_w = false;
            }
        }
    }

    /// Attribute `k`, which is affine and not constant.
    #[inline(always)]
    fn attribute_field(&mut self, subject: &Subject<'_>, k: usize, range: [f32; 2]) -> Field {
        let over_w = subject.interpolation_of(k) == Interpolation::Perspective;
        let values = self.triple_values(k, subject);
        let size = f64::from(range[0].abs().max(range[1].abs()));
        let may_be_plain = !self.strict && fits(size);
        if self.view.is_some() && may_be_plain {
            return self.attribute_in_view(values, over_w, range);
        }
        if !self.exact_plane {
            let bounded;
            let frame = if self.view.is_some() {
                bounded = Frame::new(&self.anchor, self.corners, self.reach);
                &bounded
            } else {
                &self.frame
            };
            let [b, c] = self.differences(values, over_w);
            let input_error = 3.0 * U * b.abs().max(c.abs());
            let combined = |base: f64| frame.combine([base, b, c], input_error);
            if may_be_plain {
                let combined = combined(if over_w { values[0] } else { 0.0 });
                if let Some(field) = self.plain_attribute(combined, values[0], over_w, range, size)
                {
                    return field;
                }
            } else {
                let limit = if subject.wanted.exact { WORTH_EXACT_SETUP } else { TRUSTED };
                let strict = self.strict_attribute(combined(0.0), values[0], over_w, range);
                if strict.error <= limit * size * if over_w { self.least_q } else { 1.0 } {
                    return Field::Strict(strict);
                }
            }
        }
        Self::exact_frame(&mut self.exact, &self.anchor, self.corners);
        let combine = |terms: &[Dyadic; 3]| {
            let combined = self.exact.as_deref().map(|frame| frame.combine(terms));
            nearby(&combined.unwrap_or_default(), self.reach)
        };
        let [base, b, c] = exact_values(&self.corners, values, over_w);
        let zero = Dyadic::default();
        if may_be_plain {
            let base = if over_w { base } else { zero.clone() };
            let combined = combine(&[base, b.clone(), c.clone()]);
            if let Some(field) = self.plain_attribute(combined, values[0], over_w, range, size) {
                return field;
            }
        }
        let combined = combine(&[zero, b, c]);
        Field::Strict(self.strict_attribute(combined, values[0], over_w, range))
    }

    /// The differences of b's and c's values to a's, times w if not over w.
    #[inline(always)]
    pub(super) fn differences(&self, values: [f64; 3], over_w: bool) -> [f64; 2] {
        let weight = |i: usize| if over_w { 1.0 } else { self.corners[i][3] };
        [weight(1) * (values[1] - values[0]), weight(2) * (values[2] - values[0])]
    }

    /// An attribute of magnitude `size` as it comes, if that is good enough: over w from
    /// N = `combined`, else from D = `combined` and `base`.
    #[inline(always)]
    fn plain_attribute(
        &self,
        combined: Bounded,
        base: f64,
        over_w: bool,
        range: [f32; 2],
        size: f64,
    ) -> Option<Field> {
        if over_w {
            return (combined.error <= TRUSTED * size * self.least_q)
                .then(|| Field::plain(combined.linear.scaled(self.unit), true, range));
        }
        let Bounded { mut linear, error } = combined.scaled(1.0 / self.det, self.reach);
        linear.c += base;
        (error <= TRUSTED * size).then(|| Field::plain(linear, false, range))
    }

    /// An attribute as base + D/Q or base + D/det, from D = `combined`.
    #[inline(always)]
    fn strict_attribute(
        &self,
        combined: Bounded,
        base: f64,
        over_w: bool,
        range: [f32; 2],
    ) -> Strict {
        let scale = if over_w { 1.0 } else { 1.0 / self.det };
        let error = combined.error * scale.abs();
        // No negative zero: so that no sum with it is one.
        Strict { numerator: combined.linear, base: base + 0.0, scale, error, over_w, range }
    }

    /// Attribute `k` of all vertices.
    #[inline(always)]
    pub(super) fn values_of(&self, k: usize, subject: &Subject<'_>) -> &[f32] {
        let n = subject.positions.len();
        &self.values[k * n..(k + 1) * n]
    }

    /// Attribute `k` of the triple.
    #[inline(always)]
    pub(super) fn triple_values(&self, k: usize, subject: &Subject<'_>) -> [f64; 3] {
        let values = self.values_of(k, subject);
        let [a, b, c] = self.triple;
        [f64::from(values[a]), f64::from(values[b]), f64::from(values[c])]
    }

    /// How attribute `k`, which is not constant, runs if it is not affine.
    #[inline(always)]
    fn carried_across(&self, subject: &Subject<'_>, k: usize, range: [f32; 2]) -> Option<Carried> {
        let positions = subject.positions;
        let perspective = subject.interpolation_of(k) == Interpolation::Perspective;
        let Some(shape) = self.shape else {
            let affine = perspective || positions.iter().all(|p| p[3] > 0.0);
            return (!affine).then_some(Carried::Linear(k));
        };
        let values = self.values_of(k, subject);
        let value = |i: usize| f64::from(values[i]);
        let range = f64::from(range[1]) - f64::from(range[0]);
        let is_affine = |plane: AffineFrame, point: fn([f64; 4]) -> [f64; 3]| {
            plane.is_affine(positions.len(), range, |i| point(positions[i]), value)
        };
        if perspective {
            let affine =
                shape.flat && shape.plane.is_none_or(|plane| is_affine(plane, triple::projective));
            (!affine).then_some(Carried::Perspective(k))
        } else {
            let affine = shape.in_front
                && shape.framebuffer.is_none_or(|plane| is_affine(plane, triple::divided));
            (!affine).then_some(Carried::Linear(k))
        }
    }
}

/// The value of an attribute if it is the same all over, else its range. `values` are those of
/// the vertices.
#[inline(always)]
fn constant_attribute(values: &[f32], is_flat: bool) -> Result<f32, [f32; 2]> {
    let Some(first) = values.first().copied() else { return Ok(CANONICAL_NAN) };
    let (mut low, mut high, mut same) = (first, first, true);
    let mut finite = first.is_finite();
    for value in values[1..].iter().copied() {
        same &= value.to_bits() == first.to_bits();
        finite &= value.is_finite();
        low = if value < low { value } else { low };
        high = if value > high { value } else { high };
    }
    let flat = same || is_flat;
    if flat && !first.is_nan() {
        Ok(first)
    } else if flat || !finite {
        Ok(CANONICAL_NAN)
    } else if low == high {
        // Zeros of both signs.
        Ok(0.0)
    } else {
        // No bound is a negative zero: a real number that is clamped to 0 is +0.
        Err([low + 0.0, high + 0.0])
    }
}

#[cfg(test)]
mod tests {
    use alloc::format;

    use super::*;
    use crate::gradient::{AttributesOf, Quantity, Wanted};
    use crate::polygon::Vertex;
    use crate::space::Viewport;

    /// Which pixels are found exactly depends on the crop, and attributes are set up after.
    #[test]
    fn attributes_do_not_depend_on_what_was_found_exactly() {
        let vertices = [
            Vertex::new([-0.7, -0.63, 0.31, 1.1_f64], [0.1, 1e30]),
            Vertex::new([1.9, -0.57, 0.73, 2.3], [0.7, -3e30]),
            Vertex::new([0.13, 0.41, 0.17, 0.59], [-0.3, 7e29]),
        ];
        let positions = vertices.map(|vertex| vertex.position);
        for in_view in [false, true] {
            let subject = Subject {
                attributes: &AttributesOf(&vertices),
                viewport: Viewport::new(0, 0, 640, 480).expect("small"),
                positions: &positions,
                exponent: 0,
                in_view,
                screen: &[],
                interpolation: &[],
                clipped_w: [0.59, 2.3],
                columns: [100, 500],
                rows: [40, 400],
                wanted: Wanted { depth: true, inv_w: true, w: true, attributes: 2, exact: false },
            };
            let set_up = |settled: bool| {
                let mut gradients = Gradients::default();
                gradients.set(&subject);
                if settled {
                    assert!(gradients.exact_value(&subject, Quantity::Depth, [3, 5]).is_some());
                }
                gradients.set_attributes(&subject);
                format!("{:?}", gradients.attributes)
            };
            assert_eq!(set_up(true), set_up(false), "in view: {in_view}");
        }
    }
}
