//! Values found one at a time: exactly, along edges and across spans, or at the nearest corner.
//!
//! What the X loop cannot tell comes here. Most of it does not depend on the instruction set, and is
//! compiled once.

use alloc::vec::Vec;

use fearless_simd::{Level, Simd, SimdBase, dispatch};

use crate::across::{Carried, Corners, Row};
use crate::aligned::LaneMemory;
use crate::clip::{Clipped, Clipper, VertexArrays};
use crate::divide::{ScreenVertex, divide};
use crate::edge::Span;
use crate::fixed::power_of_two;
use crate::gradient::{
    Field, Gradients, Plain, QUOTIENT_ROOM, Quantity, SUM_ERROR, Strict, Subject, nearest_f32,
};
use crate::lanes::Wide;
use crate::shade::BLOCK;
use crate::varying::{CANONICAL_NAN, Interpolation};

/// A span's row, from the anchor, and its edges on the left and on the right.
type SpanEnds = (i32, [u32; 2], [u32; 2]);

/// A polygon that is walked, and where.
pub(crate) struct Walked<'a> {
    pub(crate) subject: &'a Subject<'a>,
    pub(crate) gradients: &'a mut Gradients,
    clipper: &'a mut Clipper,
    /// Values that exact arithmetic found.
    pub(crate) exact_values: u64,
    /// The clipped polygon with all its attributes, made when first needed.
    corners: Option<(VertexArrays, Vec<ScreenVertex>)>,
    /// An edge on the left and one on the right, as the outline names them, and by which they
    /// are carried.
    carriers: [([u32; 2], [u32; 2]); 2],
    /// What runs across the last span, by number: on which row and between which edges, and how.
    rows_across: Vec<Option<(SpanEnds, Row)>>,
    /// Offset of the block's first lane from the anchor.
    pub(crate) u: i32,
    pub(crate) v: i32,
    /// After so many lanes the next row begins.
    pub(crate) columns: u16,
}

impl<'a> Walked<'a> {
    pub(crate) fn new(
        subject: &'a Subject<'a>,
        gradients: &'a mut Gradients,
        clipper: &'a mut Clipper,
    ) -> Self {
        Self {
            subject,
            gradients,
            clipper,
            exact_values: 0,
            corners: None,
            carriers: [([0; 2], [0; 2]); 2],
            rows_across: Vec::new(),
            u: 0,
            v: 0,
            columns: 16,
        }
    }

    /// The last resort, for some pixels.
    #[cold]
    #[inline(never)]
    pub(crate) fn settle_lanes(
        &mut self,
        quantity: Quantity,
        span: Option<&Span>,
        mask: u16,
        out: &mut [f32; BLOCK],
    ) {
        let [u, v] = [self.u, self.v];
        for lane in (0..16_u16).filter(|lane| mask >> lane & 1 != 0) {
            let (column, row) = (lane % self.columns, lane / self.columns);
            let pixel = [u + i32::from(column), v + i32::from(row)];
            out[usize::from(lane)] = self.settle(quantity, span, pixel);
        }
    }

    /// Sets the attributes up, and fills in those that are constant.
    #[inline(never)]
    pub(crate) fn set_attributes(&mut self, level: Level, lanes: &mut LaneMemory) {
        dispatch!(level, simd => self.gradients.set_attributes(simd, self.subject));
        let lanes = lanes.make_room(self.gradients.attributes.len());
        for (lanes, field) in lanes.iter_mut().zip(&self.gradients.attributes) {
            if let Field::Constant(value) = field {
                *lanes = [*value; BLOCK];
            }
        }
    }

    /// Along the edges of `span` and across it; and the lanes at which that is surely rounded
    /// right.
    #[inline(always)]
    pub(crate) fn across<S: Simd>(
        &mut self,
        simd: S,
        carried: Carried,
        range: [f32; 2],
        span: Option<&Span>,
        out: &mut [f32; BLOCK],
    ) -> u16 {
        // Only polygons that are drawn by spans carry anything across them.
        let Some(span) = span else { return 0 };
        let [x, y] = self.centre([self.u, self.v]);
        let row = self.row_across(carried, span, y);
        let [low, high] = Wide::count_from(simd, x).halves();
        let ((low, low_error), (high, high_error)) = (row.at(low), row.at(high));
        let scale = power_of_two(self.subject.exponent);
        let scale = match carried {
            Carried::W => scale,
            Carried::InvW => 1.0 / scale,
            _ => 1.0,
        };
        let scale = Wide::splat(simd, scale);
        // No negative zero.
        let value = Wide::of_halves(low, high) * scale + Wide::splat(simd, 0.0);
        let error = Wide::of_halves(low_error, high_error) * scale;
        let error =
            error * Wide::splat(simd, QUOTIENT_ROOM) + value.abs() * Wide::splat(simd, SUM_ERROR);
        let (rounded, certain) = value.round_within(error, range);
        rounded.store_array(out);
        // Where the bound is no number, so is all that comes of it.
        certain & error.below(Wide::splat(simd, f64::INFINITY))
    }

    /// What `carried` is where the row of `centre_y` meets the ends of `span`: found once for all its
    /// blocks.
    fn row_across(&mut self, carried: Carried, span: &Span, centre_y: f64) -> Row {
        let (at, slot) = ((self.v, span.left, span.right), carried.number());
        match self.rows_across.get(slot) {
            Some(Some((known, row))) if *known == at => *row,
            _ => self.new_row_across(carried, span, centre_y),
        }
    }

    #[inline(never)]
    fn new_row_across(&mut self, carried: Carried, span: &Span, centre_y: f64) -> Row {
        let (at, slot) = ((self.v, span.left, span.right), carried.number());
        let span = self.carried_by(span);
        let row = self.corners().row(carried, &span, centre_y);
        if self.rows_across.len() <= slot {
            self.rows_across.resize(slot + 1, None);
        }
        self.rows_across[slot] = Some((at, row));
        row
    }

    /// The centre of the pixel at the offset `u`, `v` from the anchor.
    fn centre(&self, [u, v]: [i32; 2]) -> [f64; 2] {
        let [anchor_x, anchor_y] = self.gradients.anchor.pixel;
        [u + anchor_x, v + anchor_y].map(|c| f64::from(c) + 0.5)
    }

    /// The correctly rounded value at the pixel at the offset `pixel` from the anchor.
    fn settle(&mut self, quantity: Quantity, span: Option<&Span>, pixel: [i32; 2]) -> f32 {
        self.exact_values += 1;
        match self.gradients.field(quantity).copied() {
            None => CANONICAL_NAN,
            Some(Field::Constant(value)) => value,
            Some(Field::Across(carried, range)) => {
                let Some(span) = span else { return CANONICAL_NAN };
                let span = self.carried_by(span);
                let (centre, exponent) = (self.centre(pixel), self.subject.exponent);
                clamp(self.corners().exact_value(carried, &span, centre, exponent), range)
            }
            Some(Field::Plain(Plain { range, .. }) | Field::Strict(Strict { range, .. })) => {
                let value = self.gradients.exact_value(self.subject, quantity, pixel);
                clamp(value.unwrap_or_else(|| self.nearest_corner(quantity, pixel)), range)
            }
        }
    }

    /// The clipped polygon with all its attributes.
    fn corners(&mut self) -> Corners<'_> {
        let (subject, clipper) = (self.subject, &mut *self.clipper);
        let (arrays, screen) = self.corners.get_or_insert_with(|| {
            let attributes = subject.wanted.attributes;
            let mut arrays = VertexArrays::new(attributes);
            for k in 0..attributes {
                if subject.interpolation_of(k) == Interpolation::NoPerspective {
                    arrays.set_noperspective(k);
                }
            }
            for (i, position) in subject.positions.iter().enumerate() {
                let values = (0..attributes).map(|k| f64::from(subject.attributes.attribute(i, k)));
                arrays.push(*position, values);
            }
            let mut screen = Vec::new();
            if clipper.clip(&mut arrays) != Clipped::Outside {
                divide(arrays.positions(), subject.viewport, &mut screen);
            }
            (arrays, screen)
        });
        Corners { arrays, screen }
    }

    /// `span` between the edges that carry values: of those that coincide on the grid and go the
    /// same way, the least by position and attributes. Which of them the outline found depends on
    /// where the list of vertices begins.
    fn carried_by(&mut self, span: &Span) -> Span {
        for (k, edge) in [span.left, span.right].into_iter().enumerate() {
            if self.carriers[k].0 != edge {
                self.carriers[k] = (edge, self.corners().least_like(edge));
            }
        }
        let [(_, left), (_, right)] = self.carriers;
        Span { left, right, ..*span }
    }

    /// The value at the clipped vertex nearest to the pixel's centre; of two, at the least by
    /// position and attributes.
    fn nearest_corner(&mut self, quantity: Quantity, pixel: [i32; 2]) -> f32 {
        let (centre, subject) = (self.centre(pixel), self.subject);
        let Corners { arrays, screen } = self.corners();
        let distance = |vertex: &ScreenVertex| {
            let [x, y] = [0, 1].map(|k| vertex.framebuffer[k] - centre[k]);
            x * x + y * y
        };
        let order = |a: &&ScreenVertex, b: &&ScreenVertex| {
            distance(a)
                .total_cmp(&distance(b))
                .then_with(|| arrays.compare(a.vertex as usize, b.vertex as usize))
        };
        let Some(nearest) = screen.iter().min_by(order) else { return 0.0 };
        let i = nearest.vertex as usize;
        let [_, _, _, w] = arrays.position(i);
        let scale = power_of_two(subject.exponent);
        nearest_f32(match quantity {
            Quantity::W => w * scale,
            Quantity::InvW => 1.0 / (w * scale),
            Quantity::Depth => subject.depth_numerator(arrays.position(i)) / w,
            Quantity::Attribute(k) => arrays.attributes(i)[k],
        })
    }
}

/// `value` within `range`: see [`Wide::round_within`](crate::lanes::Wide::round_within).
fn clamp(value: f32, [low, high]: [f32; 2]) -> f32 {
    let value = if value > low { value } else { low };
    if value > high { high } else { value }
}
