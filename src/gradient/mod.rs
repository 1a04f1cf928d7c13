//! Set-up: from a polygon's plane to what changes from pixel to pixel, and what does not.
//!
//! Over a flat polygon every attribute is s = s_a + D/Q with D and Q = det/w linear in the
//! framebuffer; depth and 1/w are linear themselves. They come from the unsnapped vertices as
//! given, before clipping, so that they are as good at w < 0 as anywhere. Here they are found in
//! `f64` with a bound of their error; in pairs of `f64`s where the bound asks for it; and exactly
//! where even those cannot tell. What is constant is found out and costs nothing later; attributes are set up when the first pixel asks for them.
//!
//! Nothing here depends on a crop or on where the list of vertices begins.

pub(crate) mod frame;
mod fine;
pub(crate) mod triple;
mod flat;
mod twofold;
mod attribute;
mod derived;
pub(crate) mod enclosure;
mod value;
mod view;
pub(crate) mod small;
pub(crate) mod small_quad;
pub(crate) mod small_strict;

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::cmp::Ordering;

use fearless_simd::Simd;

use crate::across::Carried;
use crate::divide::ScreenVertex;
use crate::fixed::{exponent_of, power_of_two};
use crate::number::Number;
use crate::polygon::Polygon;
use crate::space::Viewport;
use crate::varying::Interpolation;

use flat::Places;

use view::View;

use fine::FineFrame;
use frame::{Anchor, Bounded, ExactFrame, Frame, Linear, Reach, U, nearby};

/// How a quantity runs over the polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Field {
    /// The same at every pixel.
    Constant(f32),
    /// Within the bound of `Fast` as it comes.
    Plain(Plain),
    /// base + D/Q, or base + D/det; each value must be shown to be rounded right.
    Strict(Strict),
    /// Not affine: along the edges and across the span; clamped to the range.
    Across(Carried, [f32; 2]),
}

impl Field {
    #[inline(always)]
    fn plain(numerator: Linear, over_w: bool, range: [f32; 2]) -> Self {
        Self::Plain(Plain { numerator, over_w, doubtful_below: 0.0, range })
    }
}

/// A quantity that is N/Q, both times [`Gradients::unit`], or, if not `over_w`, N itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain {
    /// N.
    pub(crate) numerator: Linear,
    pub(crate) over_w: bool,
    /// Magnitudes below which the value must be shown to be rounded right; 0 if there are none.
    pub(crate) doubtful_below: f64,
    /// What the value is clamped to: finite, and no zero in it is negative.
    pub(crate) range: [f32; 2],
}

/// A quantity that is base + D/Q or, if not `over_w`, base + D `scale`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strict {
    /// D.
    pub(crate) numerator: Linear,
    /// No negative zero.
    pub(crate) base: f64,
    /// 1/det where 1/Q does not change from pixel to pixel, else 1.
    pub(crate) scale: f64,
    /// Bound of D's error at any pixel, times `scale`.
    pub(crate) error: f64,
    pub(crate) over_w: bool,
    /// As [`Plain::range`].
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

impl ConstantAlong {
    /// Of a Q that does not change along rows, or along columns.
    #[inline(always)]
    pub(crate) fn of(rows: bool, columns: bool) -> Self {
        match (rows, columns) {
            (true, true) => Self::Polygon,
            (true, false) => Self::Row,
            (false, true) => Self::Column,
            (false, false) => Self::Nothing,
        }
    }
}

/// A polygon's attributes, whatever holds them: so that what comes after is compiled once.
pub(crate) trait Attributes {
    /// Attribute `k` of vertex `i`.
    fn attribute(&self, i: usize, k: usize) -> f32;

    /// The number of attributes.
    fn count(&self) -> usize;

    /// The first `count` attributes of all vertices, one after the other.
    fn gather(&self, count: usize, out: &mut Vec<f32>);
}

/// The attributes of a [`Polygon`].
#[derive(Debug)]
pub(crate) struct AttributesOf<'a, V: ?Sized>(pub(crate) &'a V);

impl<V: Polygon + ?Sized> Attributes for AttributesOf<'_, V> {
    fn attribute(&self, i: usize, k: usize) -> f32 {
        self.0.attribute(i, k)
    }

    fn count(&self) -> usize {
        self.0.attribute_count()
    }

    fn gather(&self, count: usize, out: &mut Vec<f32>) {
        out.clear();
        let n = self.0.len();
        out.reserve(n * count);
        for k in 0..count {
            out.extend((0..n).map(|i| self.0.attribute(i, k)));
        }
    }
}

/// A polygon on its way through the set-up.
pub(crate) struct Subject<'a> {
    pub(crate) attributes: &'a dyn Attributes,
    pub(crate) viewport: Viewport,
    /// The positions as given, times 2^-`exponent`.
    pub(crate) positions: &'a [[f64; 4]],
    pub(crate) exponent: i32,
    /// Is it a triangle within the view volume, and small?
    pub(crate) in_view: bool,
    /// The clipped polygon's vertices in the framebuffer, if it has more than three.
    pub(crate) screen: &'a [ScreenVertex],
    pub(crate) interpolation: &'a [Interpolation],
    /// Least and greatest w of the clipped polygon, scaled as `positions` are.
    pub(crate) clipped_w: [f64; 2],
    /// Framebuffer columns and rows that may be covered within the viewport: first and last.
    pub(crate) columns: [i32; 2],
    pub(crate) rows: [i32; 2],
    /// Are its spans so short, on the average, that few blocks lie in one? Then each lane is found by itself, and
    /// blocks begin where spans do.
    pub(crate) short: bool,
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
    /// Every value correctly rounded?
    pub(crate) exact: bool,
}

impl Subject<'_> {
    /// How attribute `k` is interpolated.
    pub(crate) fn interpolation_of(&self, k: usize) -> Interpolation {
        self.interpolation.get(k).copied().unwrap_or_default()
    }

    /// z as depth has it, before the division.
    pub(crate) fn depth_numerator(&self, position: [f64; 4]) -> f64 {
        self.viewport.depth_range().numerator(position)
    }
}

/// From what a polygon is set up: the first that is good enough.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Source {
    /// [`Frame`], in `f64`.
    #[default]
    Double,
    /// [`FineFrame`], in pairs of them.
    Fine,
    /// [`ExactFrame`].
    Exact,
}

/// What the tests of flatness found of a polygon of more than three vertices.
#[derive(Clone, Copy, Debug)]
struct Shape {
    flat: bool,
    /// Are all w > 0?
    in_front: bool,
}

/// What the X loop needs of a polygon.
#[derive(Debug, Default)]
pub(crate) struct Gradients {
    pub(crate) anchor: Anchor,
    reach: Reach,
    triple: [usize; 3],
    corners: [[f64; 4]; 3],
    frame: Frame,
    /// A small triangle's, if one bound is good enough for all: then nothing of `frame` but the
    /// plane was found.
    view: Option<View>,
    /// Made when first needed: their being there says nothing about the polygon, since which pixels
    /// need them depends on the crop.
    fine: Option<FineFrame>,
    exact: Option<Box<ExactFrame>>,
    /// What the plane was taken from.
    source: Source,
    shape: Option<Shape>,
    /// In the plane of (x, y, w); and in the framebuffer, if that has been asked for.
    places: Places,
    framebuffer_places: Places,
    has_framebuffer_places: bool,
    /// Q = det/w, its error, and the sign it has where 1/w > 0; 0 if that is not known, or the
    /// polygon is edge-on.
    pub(crate) q: Linear,
    pub(crate) q_error: f64,
    pub(crate) q_sign: f64,
    /// The least |Q| over the clipped polygon.
    least_q: f64,
    /// The power of two that brings it into 1..2, so that a `f32` holds Q and every N; negative
    /// where Q is.
    pub(crate) unit: f64,
    /// Q times that.
    pub(crate) unit_q: Linear,
    det: f64,
    /// w times Q, and the relative error of det.
    w_scale: f64,
    pub(crate) det_relative_error: f64,
    /// Is Q in doubt at some pixel, or must everything be exact?
    pub(crate) strict: bool,
    pub(crate) constant: ConstantAlong,
    pub(crate) depth: Option<Field>,
    pub(crate) inv_w: Option<Field>,
    pub(crate) w: Option<Field>,
    pub(crate) attributes: Vec<Field>,
    /// The first so many attributes: each of all vertices.
    values: Vec<f32>,
    /// Is any of them plain and over w?
    pub(crate) divides: bool,
    /// Have the attributes been set up for this polygon?
    pub(crate) has_attributes: bool,
}

/// How far Q may be off, relatively, for bounds of quotients to hold.
pub(crate) const CERTAIN: f64 = 1.0 / 256.0;

/// Room for what a quotient's bound of first order leaves out, then.
pub(crate) const QUOTIENT_ROOM: f64 = 1.01;

/// base + t, and the two ends of Ziv's test, relatively.
pub(crate) const SUM_ERROR: f64 = 3.0 * U;

/// base + D/Q by a reciprocal that is a division in `f32` and a step of Newton's: that, two products
/// and two sums, relatively.
pub(crate) const QUICK_QUOTIENT_ERROR: f64 = 1.25 / 70_368_744_177_664.0;

/// The error, relative to the least |Q| or to an attribute's magnitude, with which `f64` may be
/// trusted to keep `Fast` within its bound without looking at each value; docs/precision.md,
/// "Fast".
const TRUSTED: f64 = 1.0 / 134_217_728.0;

/// The same for an attribute of this range: one that comes to 0 has values beside which an error that is
/// small beside its magnitude may be large.
#[inline(always)]
fn trusted_of<F: Number>([low, high]: [F; 2]) -> F {
    let zero = low.like(0.0);
    F::select(low.le(zero) & zero.le(high), low.like(TRUSTED / 8.0), low.like(TRUSTED))
}

/// Is 0 among what lies in `range`?
#[inline(always)]
pub(crate) fn contains_zero([low, high]: [f32; 2]) -> bool {
    low <= 0.0 && 0.0 <= high
}

/// The error above which, even if each value is looked at, a set-up in pairs is cheaper than what
/// it saves: one value in 4096 would be undecided.
const WORTH_FINE_SETUP: f64 = 1.0 / 137_438_953_472.0;

/// The same of a polygon with many pixels: the quick test would leave all values undecided that are below
/// 1/64 of the greatest.
const WORTH_FINE_SETUP_OF_MANY: f64 = 1.0 / 17_592_186_044_416.0;

/// So many pixels of the bounding box are many: what is undecided costs as much as the set-up then.
const MANY_PIXELS: f64 = 1024.0;

/// The largest ratio of w, and the largest magnitude of an attribute (the least is its inverse),
/// for which Q and N are sure to fit into `f32`.
const FITS: f64 = 1_152_921_504_606_846_976.0;

/// Times the bound of a depth's error: what is at least as large is within 1 ulp once rounded.
const WITHIN_ULP: f64 = 67_108_864.0;

impl Gradients {
    /// Sets up all but the attributes of `subject`.
    #[inline(always)]
    pub(crate) fn set<S: Simd>(&mut self, simd: S, subject: &Subject<'_>) {
        self.triple = triple::choose(subject.positions, subject.attributes);
        let [a, b, c] = self.triple;
        self.corners = [subject.positions[a], subject.positions[b], subject.positions[c]];
        (self.fine, self.exact, self.source) = (None, None, Source::Double);
        self.has_attributes = false;
        self.has_framebuffer_places = false;
        self.shape = (subject.positions.len() > 3).then(|| self.shape_of(subject.positions));
        let (column, u) = middle(subject.columns);
        let (row, v) = middle(subject.rows);
        self.anchor = Anchor::new(subject.viewport, [column, row]);
        self.reach = Reach { u, v };
        self.view = None;
        if subject.in_view && !subject.wanted.exact && self.set_in_view(subject) {
            return;
        }
        self.frame = Frame::new(&self.anchor.projection, self.corners, self.reach);
        let Frame { plane, q_error, det_error, .. } = self.frame;
        let q = Bounded { linear: plane.q, error: q_error };
        self.take_plane(subject, q, plane.det, det_error);
        let error = self.q_error / self.least_q + self.det_relative_error;
        // Also where the bound is no number.
        let good = error <= self.worth_fine(subject);
        if !good || self.strict && !subject.wanted.exact {
            self.take_finer_plane(simd, subject);
        }
        self.set_derived(subject, |gradients, z| gradients.depth_field(simd, subject, z));
    }

    /// The error above which a set-up in pairs is worth its cost.
    #[inline(always)]
    fn worth_fine(&self, subject: &Subject<'_>) -> f64 {
        let Reach { u, v } = self.reach;
        let many = (2.0 * u + 1.0) * (2.0 * v + 1.0) >= MANY_PIXELS;
        match (subject.wanted.exact, self.constant) {
            (false, _) => TRUSTED,
            // With less error 1/w might turn out to change along rows by hardly anything, and cost a division
            // for each pixel.
            (true, ConstantAlong::Nothing | ConstantAlong::Column) if many => {
                WORTH_FINE_SETUP_OF_MANY
            }
            (true, _) => WORTH_FINE_SETUP,
        }
    }

    /// Q and det, from either frame.
    #[inline(always)]
    fn take_plane(&mut self, subject: &Subject<'_>, q: Bounded, det: f64, det_error: f64) {
        (self.q, self.q_error, self.det) = (q.linear, q.error, det);
        self.det_relative_error = det_error / det.abs() + 2.0 * U;
        // Where the sign is unknown every value is in doubt, and found exactly.
        let certain = self.det_relative_error < CERTAIN;
        self.q_sign = if certain { 1.0_f64.copysign(det) } else { 0.0 };
        self.w_scale = det * power_of_two(subject.exponent);
        self.least_q = det.abs() / subject.clipped_w[1];
        if subject.positions.len() > 3 {
            // Its vertices may be off the plane, by much where w is small beside the diameter.
            let [x, y] = self.anchor.pixel.map(|c| f64::from(c) + 0.5);
            for vertex in subject.screen {
                let [fx, fy] = vertex.framebuffer;
                let q = (q.linear.row(fy - y) + q.linear.x * (fx - x)) * self.q_sign;
                self.least_q = if q < self.least_q { q } else { self.least_q };
            }
        }
        // A covered centre may lie outside the unsnapped polygon, and Q be smaller there.
        let beyond = (self.q.x.abs() + self.q.y.abs()) * subject.viewport.grid().snap_reach();
        let error = self.q_error + self.det_relative_error * self.least_q;
        let fits = det.abs() <= self.least_q * subject.clipped_w[0] * FITS;
        let trusted = error <= TRUSTED * self.least_q && beyond <= self.least_q / 2.0 && fits;
        self.strict = subject.wanted.exact || !trusted;
        self.take_trusted_plane(self.q, det, self.least_q);
    }

    /// What follows from Q, det and the least |Q|.
    #[inline(always)]
    fn take_trusted_plane(&mut self, q: Linear, det: f64, least_q: f64) {
        (self.q, self.det, self.least_q) = (q, det, least_q);
        self.unit = power_of_two(-exponent_of(least_q).unwrap_or(0)).copysign(det);
        self.unit_q = q.scaled(self.unit);
        self.constant = ConstantAlong::of(q.x == 0.0, q.y == 0.0);
    }

    /// The plane without the errors of `f64`, but for a rounding of each coefficient.
    #[inline(always)]
    fn take_finer_plane<S: Simd>(&mut self, simd: S, subject: &Subject<'_>) {
        let fine = FineFrame::new(simd, &self.anchor, self.corners, self.reach);
        if let Some((q, det, det_error)) = fine.plane() {
            self.take_plane(subject, q, det, det_error);
            (self.fine, self.source) = (Some(fine), Source::Fine);
        } else {
            self.take_exact_plane(subject);
        }
    }

    /// The same from exact arithmetic.
    #[cold]
    #[inline(never)]
    fn take_exact_plane(&mut self, subject: &Subject<'_>) {
        let frame = Box::new(ExactFrame::new(&self.anchor, self.corners));
        let det = frame.det.to_f64_near();
        let edge_on = frame.det.sign() == Ordering::Equal;
        self.take_plane(subject, nearby(&frame.q, self.reach), det, 8.0 * U * det.abs());
        if edge_on {
            (self.q_sign, self.det_relative_error, self.strict) = (0.0, f64::NAN, true);
            self.constant = ConstantAlong::Nothing;
        }
        (self.exact, self.source) = (Some(frame), Source::Exact);
    }

    /// Is a polygon of more than three vertices flat?
    #[inline(always)]
    fn shape_of(&mut self, positions: &[[f64; 4]]) -> Shape {
        self.places.set(positions, self.triple, triple::projective);
        let in_front = positions.iter().all(|p| p[3] > 0.0);
        Shape { flat: self.places.are_flat(positions), in_front }
    }

    /// How `quantity` runs, if it was asked for.
    #[inline(always)]
    pub(crate) fn field(&self, quantity: Quantity) -> Option<&Field> {
        match quantity {
            Quantity::Depth => self.depth.as_ref(),
            Quantity::InvW => self.inv_w.as_ref(),
            Quantity::W => self.w.as_ref(),
            Quantity::Attribute(k) => self.attributes.get(k),
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.attributes.capacity() * size_of::<Field>()
            + self.values.capacity() * size_of::<f32>()
            + self.places.bytes()
            + self.framebuffer_places.bytes()
    }
}

/// Do numbers up to `magnitude`, and times Q, fit into `f32`, with room for the error below?
#[inline(always)]
fn fits(magnitude: f64) -> bool {
    (1.0 / FITS..FITS).contains(&magnitude)
}

/// The middle of a range that includes both its ends, and how far they are from it.
#[inline(always)]
pub(crate) fn middle([first, last]: [i32; 2]) -> (i32, f64) {
    let middle = first + (last - first) / 2;
    (middle, f64::from((middle - first).max(last - middle)))
}

#[expect(clippy::cast_possible_truncation, reason = "rounding to nearest is what is meant")]
#[inline(always)]
pub(crate) fn nearest_f32(value: f64) -> f32 {
    value as f32
}
