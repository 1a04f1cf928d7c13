//! What is not affine over a polygon: along the edges and across the span.
//!
//! On a row with centre yc the span's left and right edges are the two that the row's snapped
//! outline crosses there. On an edge from (x0, y0) to (x1, y1), the clipped polygon's vertices in
//! the framebuffer as `f64`, not snapped, t = clamp((yc - y0) / (y1 - y0), 0, 1), and x, 1/w, s/w
//! and z/w (or s, without perspective) are linear in t; across, tau = clamp((xc - xl) / (xr - xl),
//! 0, 1), they are linear in tau, and s is (s/w) / (1/w).

use hyperspan::space::Viewport;
use hyperspan::varying::Interpolation;

use super::Poly;
use super::clipper::{self, mix};
use super::coverage::{framebuffer, snap, steps};
use super::exact::{Q, approximate, fraction, power_of_two, q, round_to_f32};
use super::plane::{clamp, depth_numerator, range};

/// A vertex of the clipped polygon.
struct Vertex {
    /// In the framebuffer, in pixels.
    place: [Q; 2],
    snapped: [i64; 2],
    inv_w: Q,
    depth: Q,
    /// Where `linear`: as it is, else over w.
    attributes: Vec<Q>,
}

/// The right values of one polygon, at every pixel.
pub(crate) struct Edges {
    viewport: Viewport,
    vertices: Vec<Vertex>,
    linear: Vec<bool>,
    /// Over the vertices as given.
    ranges: Vec<(Q, Q)>,
    /// Do all clipped vertices have a place that rounding cannot move much?
    is_sound: bool,
}

impl Edges {
    /// The oracle of a polygon, all finite; attributes that are not finite count as 0.
    pub(crate) fn new(poly: &Poly, viewport: Viewport, listed: &[Interpolation]) -> Self {
        let count = poly.attributes[0].len();
        let finite = |s: f32| if s.is_finite() { q(f64::from(s)) } else { Q::ZERO };
        let values: Vec<Vec<Q>> =
            (0..count).map(|k| poly.attributes.iter().map(|a| finite(a[k])).collect()).collect();
        let mode = |k: usize| listed.get(k).copied().unwrap_or_default();
        let linear: Vec<bool> = (0..count).map(|k| mode(k) != Interpolation::Perspective).collect();
        let mut corners = clipper::clip(poly, &clipper::planes(viewport));
        let least = corners.iter().map(|c| approximate(&c.position[3])).fold(f64::MAX, f64::min);
        let size = poly.positions.iter().flatten().fold(0.0, |a: f64, c| a.max(c.abs()));
        let is_sound = least > 1e-6 * size && !corners.iter().any(|c| c.by_infinity);
        // As f64: those of the polygon as given are such, new ones are rounded.
        let place = |corner: &clipper::Corner| {
            framebuffer(viewport, [0, 1, 2, 3].map(|i| approximate(&corner.position[i])))
        };
        corners.retain(|corner| {
            corner.position[3] != Q::ZERO && place(corner).iter().all(|c| c.is_finite())
        });
        let vertex = |corner: &clipper::Corner| {
            let place = place(corner);
            let w = &corner.position[3];
            let attribute = |k: usize| {
                let value = corner.mean(&values[k], linear[k]);
                if linear[k] { value } else { value / w }
            };
            Vertex {
                place: place.map(q),
                snapped: snap(viewport.grid(), place),
                inv_w: Q::ONE / w,
                depth: depth_numerator(viewport.depth_range(), &corner.position) / w,
                attributes: (0..count).map(attribute).collect(),
            }
        };
        let vertices = corners.iter().map(vertex).collect();
        let ranges = values.iter().map(|v| range(v)).collect();
        Self { viewport, vertices, linear, ranges, is_sound }
    }

    /// The place of pixel (`x`, `y`) between the edges, if its row crosses just two.
    pub(crate) fn at(&self, x: i32, y: i32) -> Option<At<'_>> {
        let steps = steps(self.viewport.grid());
        let row = i64::from(y) * steps + steps / 2;
        let n = self.vertices.len();
        let mut crossings = Vec::new();
        for (i, from) in self.vertices.iter().enumerate() {
            let to = &self.vertices[(i + 1) % n];
            let (top, bottom) =
                if from.snapped[1] <= to.snapped[1] { (from, to) } else { (to, from) };
            if top.snapped[1] <= row && row < bottom.snapped[1] {
                let t = fraction(row - top.snapped[1], bottom.snapped[1] - top.snapped[1]);
                let ends = [top, bottom].map(|v| fraction(v.snapped[0], 1));
                crossings.push((mix(&ends[0], &ends[1], &t), [top, bottom]));
            }
        }
        crossings.sort_by(|a, b| a.0.cmp(&b.0));
        let [(_, left), (_, right)] = crossings.try_into().ok()?;
        let centre = [x, y].map(|c| fraction(2 * i64::from(c) + 1, 2));
        let along = [left, right].map(|[top, bottom]| {
            let t = part(&top.place[1], &bottom.place[1], &centre[1]);
            (mix(&top.place[0], &bottom.place[0], &t), t)
        });
        let across = part(&along[0].0, &along[1].0, &centre[0]);
        let thin = &along[1].0 - &along[0].0 < power_of_two(-10);
        let short =
            |[top, bottom]: [&Vertex; 2]| &bottom.place[1] - &top.place[1] < power_of_two(-10);
        let is_sound = self.is_sound && !thin && !short(left) && !short(right);
        let [(_, left_part), (_, right_part)] = along;
        Some(At { edges: self, left, right, along: [left_part, right_part], across, is_sound })
    }
}

/// How far `at` is on the way from `from` to `to`: 0 to 1.
fn part(from: &Q, to: &Q, at: &Q) -> Q {
    if at <= from {
        Q::ZERO
    } else if at >= to {
        Q::ONE
    } else {
        (at - from) / (to - from)
    }
}

/// The right values at one pixel.
pub(crate) struct At<'a> {
    edges: &'a Edges,
    left: [&'a Vertex; 2],
    right: [&'a Vertex; 2],
    along: [Q; 2],
    across: Q,
    is_sound: bool,
}

impl At<'_> {
    /// Is it so that rounding new vertices cannot move the values much?
    pub(crate) fn is_sound(&self) -> bool {
        self.is_sound
    }

    fn run(&self, value: impl Fn(&Vertex) -> &Q) -> Q {
        let left = mix(value(self.left[0]), value(self.left[1]), &self.along[0]);
        let right = mix(value(self.right[0]), value(self.right[1]), &self.along[1]);
        mix(&left, &right, &self.across)
    }

    /// 1/w.
    pub(crate) fn inv_w(&self) -> f32 {
        round_to_f32(&self.run(|v| &v.inv_w))
    }

    /// w.
    pub(crate) fn w(&self) -> f32 {
        round_to_f32(&(Q::ONE / self.run(|v| &v.inv_w)))
    }

    /// z/w, or (z/w + 1)/2.
    pub(crate) fn depth(&self) -> f32 {
        round_to_f32(&clamp(self.run(|v| &v.depth), &(Q::ZERO, Q::ONE)))
    }

    /// Attribute `k`.
    pub(crate) fn attribute(&self, k: usize) -> f32 {
        let numerator = self.run(|v| &v.attributes[k]);
        let value =
            if self.edges.linear[k] { numerator } else { numerator / self.run(|v| &v.inv_w) };
        round_to_f32(&clamp(value, &self.edges.ranges[k]))
    }
}
