//! Set-up of the attributes: for each, how it runs over the polygon, and from what.

use fearless_simd::Simd;

use super::fine::FineFrame;
use super::flat::{FLATNESS, Places};
use super::frame::{Bounded, Frame, U, nearby};
use super::triple;
use super::twofold::Twofold;
use super::value::{exact_values, fine_values};
use super::{ConstantAlong, Field, Gradients, Source, Strict, Subject, fits, trusted_of};
use crate::across::Carried;
use crate::exact::Dyadic;
use crate::varying::{CANONICAL_NAN, Interpolation};

impl Gradients {
    /// Sets up the attributes.
    #[inline(always)]
    pub(crate) fn set_attributes<S: Simd>(&mut self, simd: S, subject: &Subject<'_>) {
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
                    None => self.attribute_field(simd, subject, k, range),
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
    fn attribute_field<S: Simd>(
        &mut self,
        simd: S,
        subject: &Subject<'_>,
        k: usize,
        range: [f32; 2],
    ) -> Field {
        let over_w = subject.interpolation_of(k) == Interpolation::Perspective;
        let values = self.triple_values(k, subject);
        let size = f64::from(range[0].abs().max(range[1].abs()));
        let may_be_plain = !self.strict && fits(size);
        if self.view.is_some() && may_be_plain {
            return self.attribute_in_view(values, over_w, range);
        }
        if self.source == Source::Double {
            let bounded;
            let frame = if self.view.is_some() {
                bounded = Frame::new(&self.anchor.projection, self.corners, self.reach);
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
                let limit = self.worth_fine(subject);
                let strict = self.strict_attribute(combined(0.0), values[0], over_w, range);
                if strict.error <= limit * size * if over_w { self.least_q } else { 1.0 } {
                    return Field::Strict(strict);
                }
            }
        }
        // N, or D if there is no division by Q, and what else it may be found from.
        let whole = self.combine_finely(simd, values, over_w, over_w);
        if may_be_plain
            && let Some(field) = self.plain_attribute(whole, values[0], over_w, range, size)
        {
            return field;
        }
        if !over_w {
            return Field::Strict(self.strict_attribute(whole, values[0], over_w, range));
        }
        // N where that is small, as that of an attribute is which vanishes where Q is large: else
        // D, whose error goes by the attribute's range.
        let part = self.combine_finely(simd, values, over_w, false);
        let base = part.error + U * values[0].abs() * self.least_q;
        let (combined, base) = if whole.error <= base { (whole, 0.0) } else { (part, values[0]) };
        Field::Strict(self.strict_attribute(combined, base, over_w, range))
    }

    /// D of an attribute with these `values` at the triple, or N = base Q + D, nearly as good as
    /// exact arithmetic makes it.
    #[inline(always)]
    fn combine_finely<S: Simd>(
        &mut self,
        simd: S,
        values: [f64; 3],
        over_w: bool,
        with_base: bool,
    ) -> Bounded {
        let (anchor, corners, reach) = (&self.anchor, self.corners, self.reach);
        if self.source != Source::Exact {
            let make = || FineFrame::new(simd, anchor, corners, reach);
            let mut terms = fine_values(&corners, values, over_w);
            if !with_base {
                terms[0] = Twofold::default();
            }
            if let Some(combined) = self.fine.get_or_insert_with(make).combine(simd, &terms) {
                return combined;
            }
        }
        let mut terms = exact_values(&corners, values, over_w);
        if !with_base {
            terms[0] = Dyadic::default();
        }
        nearby(&Self::exact_frame(&mut self.exact, anchor, corners).combine(&terms), reach)
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
        let trusted = trusted_of(range.map(f64::from)) * size;
        if over_w {
            return (combined.error <= trusted * self.least_q)
                .then(|| Field::plain(combined.linear.scaled(self.unit), true, range));
        }
        let Bounded { mut linear, error } = combined.scaled(1.0 / self.det, self.reach);
        linear.c += base;
        (error <= trusted).then(|| Field::plain(linear, false, range))
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
    fn carried_across(
        &mut self,
        subject: &Subject<'_>,
        k: usize,
        range: [f32; 2],
    ) -> Option<Carried> {
        let positions = subject.positions;
        let perspective = subject.interpolation_of(k) == Interpolation::Perspective;
        let Some(shape) = self.shape else {
            let affine = perspective || positions.iter().all(|p| p[3] > 0.0);
            return (!affine).then_some(Carried::Linear(k));
        };
        let tolerance = FLATNESS * (f64::from(range[1]) - f64::from(range[0]));
        if !(perspective || self.has_framebuffer_places) && shape.in_front {
            self.framebuffer_places.set(positions, self.triple, triple::divided);
            self.has_framebuffer_places = true;
        }
        let values = self.values_of(k, subject);
        let affine =
            |places: &Places| places.are_affine(tolerance * tolerance, |i| f64::from(values[i]));
        if perspective {
            let affine = shape.flat && affine(&self.places);
            (!affine).then_some(Carried::Perspective(k))
        } else {
            let affine = shape.in_front && affine(&self.framebuffer_places);
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

    use fearless_simd::{Level, dispatch};

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
                short: false,
                wanted: Wanted { depth: true, inv_w: true, w: true, attributes: 2, exact: false },
            };
            let set_up = |settled: bool| {
                let mut gradients = Gradients::default();
                let level = Level::baseline();
                dispatch!(level, simd => gradients.set(simd, &subject));
                if settled {
                    assert!(gradients.exact_value(&subject, Quantity::Depth, [3, 5]).is_some());
                }
                dispatch!(level, simd => gradients.set_attributes(simd, &subject));
                format!("{:?}", gradients.attributes)
            };
            assert_eq!(set_up(true), set_up(false), "in view: {in_view}");
        }
    }
}
