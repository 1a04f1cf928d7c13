//! Along the edges and across the span: how what is not affine over a polygon is interpolated.
//!
//! Blinn's tiler (1992) and Heckbert's `poly_scan` (1990) interpolate whatever stands at the
//! vertices of an N-gon: on each row along the two edges that bound the span, then between
//! them. Over a flat polygon with affine attributes that is the plane; over any other it is a
//! definition, and one that turns with the picture:
//!
//! ```text
//!   on an edge from (x0, y0) down to (x1, y1):  t   = clamp((yc - y0) / (y1 - y0), 0, 1)
//!   across, from the left edge to the right:    tau = clamp((xc - xl) / (xr - xl), 0, 1)
//! ```
//!
//! x, 1/w, s/w and z/w run linearly in t and then in tau, and s is their quotient; what has no
//! perspective runs linearly itself. Vertices are the clipped polygon's, not snapped; which
//! edges bound the span the snapped outline says. Here in `f64` with a bound of the error
//! (docs/precision.md, "Along edges and across spans"), and exactly.

use core::cmp::Ordering;

use crate::clip::VertexArrays;
use crate::divide::ScreenVertex;
use crate::edge::Span;
use crate::exact::{Dyadic, round_quotient};
use crate::number::Number;
use crate::space::DepthRange;

/// The rounding of `f64`.
const U: f64 = f64::EPSILON / 2.0;

/// x, 1/w and s/w where the row meets an edge, by the magnitudes they are made of.
const END_ERROR: f64 = 10.0 * U;

/// How far the ends are from the pixel: the ends' x, and the subtraction.
const OFFSET_ERROR: f64 = 12.0 * U;

/// The two products across, their sum, the reciprocal and its product, by the numerator's magnitude.
const ACROSS_ERROR: f64 = 6.0 * U + END_ERROR;

/// The same for the denominator, relatively.
const DENOMINATOR_ERROR: f64 = 10.0 * U + END_ERROR;

/// The ends may move by the span's width over this for the bound to hold.
const NARROW: f64 = 256.0;

/// What runs along an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Carried {
    /// z/w, or (z/w + 1)/2.
    Depth(DepthRange),
    /// 1/w.
    InvW,
    /// w, as 1 / (1/w).
    W,
    /// Attribute k with perspective: (s/w) / (1/w).
    Perspective(usize),
    /// Attribute k itself.
    Linear(usize),
}

/// The clipped polygon with all its attributes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corners<'a> {
    pub(crate) arrays: &'a VertexArrays,
    pub(crate) screen: &'a [ScreenVertex],
}

/// Where the row meets an edge, each off by its bound: see `Corners::end`.
#[derive(Clone, Copy, Debug)]
struct End {
    x: f64,
    /// The greatest magnitude that x was made of.
    x_size: f64,
    q: f64,
    n: f64,
    /// As `n`, of magnitudes.
    n_size: f64,
}

impl Corners<'_> {
    /// Numerator and w of a corner: the quantity is their quotient, over 1/w or not.
    fn numbers(&self, carried: Carried, corner: u32) -> (f64, f64, &ScreenVertex) {
        let vertex = &self.screen[corner as usize];
        let i = vertex.vertex as usize;
        let [_, _, z, w] = self.arrays.position(i);
        let (n, w) = match carried {
            Carried::Depth(DepthRange::ZeroToOne) => (z, w),
            Carried::Depth(DepthRange::MinusOneToOne) => ((z + w) / 2.0, w),
            Carried::InvW | Carried::W => (1.0, w),
            Carried::Perspective(k) => (self.arrays.attributes(i)[k], w),
            Carried::Linear(k) => (self.arrays.attributes(i)[k], 1.0),
        };
        (n, w, vertex)
    }

    /// Along one edge: `n`, `q` and `x` within [`END_ERROR`] of `n_size`, `q` and `x_size`.
    fn end(&self, carried: Carried, edge: [u32; 2], centre_y: f64) -> End {
        let [(n0, w0, v0), (n1, w1, v1)] = edge.map(|corner| self.numbers(carried, corner));
        let [y0, y1] = [v0, v1].map(|v| v.framebuffer[1]);
        let (h0, h1) = ((centre_y - y0).max(0.0), (y1 - centre_y).max(0.0));
        let height = h0 + h1;
        let (a, b) = (h1 / height, h0 / height);
        let [x0, x1] = [v0, v1].map(|v| v.framebuffer[0]);
        let (p0, p1) = (a / w0, b / w1);
        End {
            x: x0 * a + x1 * b,
            x_size: x0.abs().max(x1.abs()),
            q: if carried.is_over_w() { p0 + p1 } else { 1.0 },
            n: n0 * p0 + n1 * p1,
            n_size: n0.abs() * p0 + n1.abs() * p1,
        }
    }

    /// Of the edges that coincide with `edge` on the grid and go the same way, the least by the
    /// position and the attributes of its vertices.
    pub(crate) fn least_like(&self, edge: [u32; 2]) -> [u32; 2] {
        let n = self.screen.len();
        let next = |i: usize| if i + 1 == n { 0 } else { i + 1 };
        let down = next(edge[0] as usize) == edge[1] as usize;
        let snapped = |edge: [u32; 2]| edge.map(|i| self.screen[i as usize].snapped);
        let from = (0_u32..).zip(0..n).map(|(i, at)| {
            let to = u32::try_from(next(at)).unwrap_or(u32::MAX);
            if down { [i, to] } else { [to, i] }
        });
        let numbers = |i: u32| self.screen[i as usize].vertex as usize;
        let order = |a: &[u32; 2], b: &[u32; 2]| {
            let compare = |k: usize| self.arrays.compare(numbers(a[k]), numbers(b[k]));
            compare(0).then_with(|| compare(1))
        };
        from.filter(|other| snapped(*other) == snapped(edge)).min_by(order).unwrap_or(edge)
    }

    /// The two ends of `span`, whose row has its centre at framebuffer `centre_y`.
    pub(crate) fn row(&self, carried: Carried, span: &Span, centre_y: f64) -> Row {
        let left = self.end(carried, span.left, centre_y);
        let right = self.end(carried, span.right, centre_y);
        Row { left, right, reciprocal: carried == Carried::W }
    }

    /// The correctly rounded value at a pixel's centre.
    pub(crate) fn exact_value(
        &self,
        carried: Carried,
        span: &Span,
        [centre_x, centre_y]: [f64; 2],
        scale_exponent: i32,
    ) -> f32 {
        let (x, y) = (Dyadic::from_f64(centre_x), Dyadic::from_f64(centre_y));
        let left = self.exact_end(carried, span.left, &y);
        let right = self.exact_end(carried, span.right, &y);
        // From the left end to the centre, and from there to the right, times each height.
        let g0 = x.mul(&left.height).sub(&left.x);
        let g1 = right.x.sub(&x.mul(&right.height));
        let zero = Dyadic::default;
        let one = || Dyadic::from_f64(1.0);
        let (g0, g1) = match (g0.sign(), g1.sign()) {
            (Ordering::Less | Ordering::Equal, _) => (zero(), one()),
            (_, Ordering::Less | Ordering::Equal) => (one(), zero()),
            _ => (g0, g1),
        };
        let weigh = |l: &Dyadic, r: &Dyadic| l.mul(&right.w).mul(&g1).add(&r.mul(&left.w).mul(&g0));
        let numerator = weigh(&left.n, &right.n);
        if carried.is_over_w() {
            return round_quotient(&numerator, &weigh(&left.q, &right.q));
        }
        let length = g0.mul(&right.height).add(&g1.mul(&left.height));
        let length = length.mul(&left.w).mul(&right.w);
        match carried {
            Carried::InvW => round_quotient(&numerator, &length.scaled(scale_exponent)),
            Carried::W => round_quotient(&length.scaled(scale_exponent), &numerator),
            _ => round_quotient(&numerator, &length),
        }
    }

    fn exact_end(&self, carried: Carried, edge: [u32; 2], centre_y: &Dyadic) -> ExactEnd {
        let [(n0, w0, v0), (n1, w1, v1)] = edge.map(|corner| {
            let (n, w, vertex) = self.numbers(carried, corner);
            let n = match carried {
                Carried::Depth(DepthRange::MinusOneToOne) => {
                    let [_, _, z, w] = self.arrays.position(vertex.vertex as usize);
                    Dyadic::from_f64(z).add(&Dyadic::from_f64(w)).mul(&Dyadic::from_f64(0.5))
                }
                _ => Dyadic::from_f64(n),
            };
            (n, Dyadic::from_f64(w), vertex.framebuffer.map(Dyadic::from_f64))
        });
        let (h0, h1) = (centre_y.sub(&v0[1]), v1[1].sub(centre_y));
        let one = || Dyadic::from_f64(1.0);
        let (h0, h1) = match (h0.sign(), h1.sign()) {
            (Ordering::Less | Ordering::Equal, _) => (Dyadic::default(), one()),
            (_, Ordering::Less | Ordering::Equal) => (one(), Dyadic::default()),
            _ => (h0, h1),
        };
        let (p0, p1) = (h1.mul(&w1), h0.mul(&w0));
        ExactEnd {
            x: v0[0].mul(&h1).add(&v1[0].mul(&h0)),
            n: n0.mul(&p0).add(&n1.mul(&p1)),
            q: p0.add(&p1),
            height: h0.add(&h1),
            w: w0.mul(&w1),
        }
    }
}

impl Carried {
    /// A number of its own, of all that run over one polygon: the attributes' come last.
    pub(crate) fn number(self) -> usize {
        match self {
            Self::Depth(_) => 0,
            Self::InvW => 1,
            Self::W => 2,
            Self::Perspective(k) | Self::Linear(k) => 3 + k,
        }
    }

    /// Is it a quotient by the interpolated 1/w?
    fn is_over_w(self) -> bool {
        matches!(self, Self::Perspective(_))
    }
}

/// All times `height`; `n` and `q` also times `w`, the product of both vertices' w.
struct ExactEnd {
    x: Dyadic,
    n: Dyadic,
    q: Dyadic,
    height: Dyadic,
    w: Dyadic,
}

/// A quantity on one row: what runs across the span.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    left: End,
    right: End,
    reciprocal: bool,
}

impl Row {
    /// The values at these framebuffer columns, and bounds of their errors: no number where none can be
    /// had.
    #[inline(always)]
    pub(crate) fn at<F: Number>(&self, centre_x: F) -> (F, F) {
        let (l, r) = (&self.left, &self.right);
        let zero = centre_x.like(0.0);
        let off = OFFSET_ERROR * (l.x_size + r.x_size);
        let g0 = zero.greater(centre_x - l.x);
        let g1 = zero.greater(centre_x.like(r.x) - centre_x);
        let denominator = g1 * l.q + g0 * r.q;
        let per_denominator = denominator.reciprocal();
        let value = (g1 * l.n + g0 * r.n) * per_denominator;
        // How the value moves when either end does.
        let moved = (zero + r.n - value * r.q).abs() + (zero + l.n - value * l.q).abs();
        let rounded = (g1 * l.n_size + g0 * r.n_size) * ACROSS_ERROR;
        let error = (moved * off + rounded) * per_denominator + value.abs() * DENOMINATOR_ERROR;
        // Of first order: the ends must not move by as much as the span is wide.
        let narrow = denominator.lt(zero + off * (l.q + r.q) * NARROW);
        let error = F::select(narrow, zero + f64::NAN, error);
        if self.reciprocal {
            let reciprocal = value.reciprocal();
            (reciprocal, error * 1.02 / (value * value) + (reciprocal * (2.0 * U)).abs())
        } else {
            (value, error)
        }
    }
}
