//! What all rungs but the product's own have in common: a polygon's spans, from the library's
//! public stages, and its functions of the framebuffer, in plain `f64`.

use hyperspan::clip::{Clipper, VertexArrays};
use hyperspan::divide::{ScreenVertex, divide};
use hyperspan::edge::{Outline, Span};
use hyperspan::space::Viewport;

use crate::bench::scenes::Facet;

/// x u + y v + c, where (u, v) is how far a pixel lies from the anchor.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Linear {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) c: f64,
}

impl Linear {
    /// The part that a row has in common.
    #[inline(always)]
    pub(crate) fn row(&self, v: f64) -> f64 {
        self.c + self.y * v
    }

    /// `a` of `p`, `b` of `q` and `c` of `r`.
    fn combined([a, b, c]: [f64; 3], [p, q, r]: [Self; 3]) -> Self {
        Self {
            x: a * p.x + b * q.x + c * r.x,
            y: a * p.y + b * q.y + c * r.y,
            c: a * p.c + b * q.c + c * r.c,
        }
    }
}

/// A polygon before its spans are walked.
#[derive(Debug)]
pub(crate) struct Prepared {
    viewport: Viewport,
    clipper: Clipper,
    outline: Outline,
    /// With attributes for the rungs that go along edges.
    pub(crate) clipped: VertexArrays,
    pub(crate) screen: Vec<ScreenVertex>,
    /// Cut at the sides of the picture.
    pub(crate) spans: Vec<Span>,
    /// Three vertices, as given.
    pub(crate) corners: [usize; 3],
    /// The pixel from which functions count.
    pub(crate) anchor: [i32; 2],
    /// 1/w.
    pub(crate) inv_w: Linear,
    /// Each attribute over w.
    pub(crate) over_w: Vec<Linear>,
    /// z/w.
    pub(crate) depth: Linear,
    /// Least and greatest of each attribute.
    pub(crate) ranges: Vec<[f32; 2]>,
}

impl Prepared {
    /// For polygons in `viewport`, whose corner is at (0, 0).
    pub(crate) fn new(viewport: Viewport) -> Self {
        Self {
            viewport,
            clipper: Clipper::new(viewport),
            outline: Outline::default(),
            clipped: VertexArrays::new(0),
            screen: Vec::new(),
            spans: Vec::new(),
            corners: [0; 3],
            anchor: [0; 2],
            inv_w: Linear::default(),
            over_w: Vec::new(),
            depth: Linear::default(),
            ranges: Vec::new(),
        }
    }

    /// Finds the spans of `facet`, and its functions for the first `wanted` attributes. With
    /// `carried` attributes at each clipped vertex.
    pub(crate) fn set(&mut self, facet: &Facet, wanted: usize, carried: usize) {
        let stride = facet.attributes.len() / facet.positions.len().max(1);
        self.clipped.reset(carried);
        for (i, position) in facet.positions.iter().enumerate() {
            let attributes = &facet.attributes[i * stride..i * stride + carried];
            self.clipped.push(*position, attributes.iter().copied().map(f64::from));
        }
        self.clipper.clip(&mut self.clipped);
        divide(self.clipped.positions(), self.viewport, &mut self.screen);
        let (width, height) = (self.viewport.width(), self.viewport.height());
        let (width, height) = (width.cast_signed(), height.cast_signed());
        self.spans.clear();
        let spans = &mut self.spans;
        self.outline.set(&self.screen).for_each_span(0..height, |span| {
            let (start, end) = (span.start.max(0), span.end.min(width));
            if start < end {
                spans.push(Span { start, end, ..span });
            }
        });
        self.set_functions(facet, stride, wanted);
    }

    /// Cramer's rule, from the pixel in the middle of the rows: with p = (X, Y, w) of three
    /// vertices, the weight of a is (b x c) . (u, v, 1) / det.
    fn set_functions(&mut self, facet: &Facet, stride: usize, wanted: usize) {
        let Some(span) = self.spans.get(self.spans.len() / 2) else { return };
        self.anchor = [i32::midpoint(span.start, span.end), span.row];
        let points = self.seen_from(facet, self.anchor);
        self.corners = best_corners(&points);
        let weights = weights(self.corners.map(|i| points[i]));
        self.inv_w = Linear::combined([1.0; 3], weights);
        self.depth = Linear::combined(self.corners.map(|i| facet.positions[i][2]), weights);
        self.over_w.clear();
        self.ranges.clear();
        for k in 0..wanted {
            let value = |i: usize| facet.attributes[i * stride + k];
            let values = self.corners.map(|i| f64::from(value(i)));
            self.over_w.push(Linear::combined(values, weights));
            let mut range = [value(0); 2];
            for i in 1..facet.positions.len() {
                range = [range[0].min(value(i)), range[1].max(value(i))];
            }
            self.ranges.push(range);
        }
    }

    /// The vertices as (X, Y, w): w times their place in the framebuffer from the centre of
    /// `pixel`.
    pub(crate) fn seen_from(&self, facet: &Facet, pixel: [i32; 2]) -> Vec<[f64; 3]> {
        let half_w = f64::from(self.viewport.width()) / 2.0;
        let half_h = f64::from(self.viewport.height()) / 2.0;
        let to_centre =
            [half_w - (f64::from(pixel[0]) + 0.5), half_h - (f64::from(pixel[1]) + 0.5)];
        let place = |[x, y, _, w]: &[f64; 4]| {
            [x * half_w + w * to_centre[0], w * to_centre[1] - y * half_h, *w]
        };
        facet.positions.iter().map(place).collect()
    }

    /// How far `column` of `row` lies from the anchor.
    #[inline(always)]
    pub(crate) fn offset(&self, column: i32, row: i32) -> [f64; 2] {
        [f64::from(column - self.anchor[0]), f64::from(row - self.anchor[1])]
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The first vertex, the one farthest from it in direction, and the one farthest from their plane.
fn best_corners(points: &[[f64; 3]]) -> [usize; 3] {
    let farthest = |distance: &dyn Fn(usize) -> f64| {
        (1..points.len()).max_by(|i, j| distance(*i).total_cmp(&distance(*j))).unwrap_or(0)
    };
    if points.len() == 3 {
        return [0, 1, 2];
    }
    let b = farthest(&|i| {
        let normal = cross(points[0], points[i]);
        dot(normal, normal)
    });
    let normal = cross(points[0], points[b]);
    [0, b, farthest(&|i| dot(normal, points[i]).abs())]
}

/// The weights of three points as functions of the framebuffer; their sum is 1/w.
pub(crate) fn weights([a, b, c]: [[f64; 3]; 3]) -> [Linear; 3] {
    // Through the edges: the points may be far away compared with their distances.
    let edge = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    let (e, f) = (edge(b), edge(c));
    let normal = cross(e, f);
    let determinant = dot(a, normal);
    let (of_b, of_c) = (cross(f, a), cross(a, e));
    let linear = |n: [f64; 3]| Linear {
        x: n[0] / determinant,
        y: n[1] / determinant,
        c: n[2] / determinant,
    };
    let of_a = [0, 1, 2].map(|i: usize| normal[i] - of_b[i] - of_c[i]);
    [linear(of_a), linear(of_b), linear(of_c)]
}
