//! The clipper: from vertices in clip space to those of what can be drawn.
//!
//! Outcodes first: all vertices outside one plane reject, all inside every plane accept; else
//! Sutherland and Hodgman's algorithm against the crossed planes only, in homogeneous space,
//! before any division, in `f64`, on the whole array of a vertex at once (Heckbert 1990).
//!
//! Near, far and the user's planes are real planes. x and y are clipped only at the *guard
//! band*, the reach of the subpixel grid; what sticks out of the viewport is the scissor's.
//! `w > 0` needs no plane of its own: either depth range implies w >= 0, and of the points with
//! w = 0 the guard band leaves only (0, 0, 0, 0), which names no place and falls out in the
//! division.
//!
//! A new vertex lies at (a |d_b| + b |d_a|) / (|d_a| + |d_b|), where d is the clip distance: an
//! expression that is symmetric in a and b, bit for bit. So a shared edge gives the same vertex
//! in either direction and from either side of the plane. Along the plane's own axis, where ends
//! far outside on both sides would cancel, the vertex is put onto the plane.

use alloc::vec::Vec;
use core::cmp::Ordering;

use crate::fixed::{Subpixel, exponent_of, power_of_two};
use crate::space::{DepthRange, Viewport};

/// Vertices as arrays of `stride` numbers: x, y, z, w, and then attributes.
#[derive(Clone, Debug, Default)]
pub struct VertexArrays {
    stride: usize,
    numbers: Vec<f64>,
    /// Attributes that run linearly in the framebuffer, by number.
    noperspective: Vec<usize>,
}

impl VertexArrays {
    /// No vertices yet, of `attributes` attributes each.
    pub fn new(attributes: usize) -> Self {
        Self { stride: 4 + attributes, ..Self::default() }
    }

    /// Drops all vertices; those to come have `attributes` attributes.
    pub fn reset(&mut self, attributes: usize) {
        self.stride = 4 + attributes;
        self.numbers.clear();
        self.noperspective.clear();
    }

    /// Says that attribute `k`, below the number of attributes, has no perspective: at a new
    /// vertex it is taken linearly in the framebuffer, not in clip space, unless an end of the
    /// edge has w <= 0.
    pub fn set_noperspective(&mut self, k: usize) {
        if k + 4 < self.stride {
            self.noperspective.push(k);
        }
    }

    /// Appends a vertex; attributes that are missing are 0, those beyond the number are dropped.
    pub fn push(&mut self, position: [f64; 4], attributes: impl IntoIterator<Item = f64>) {
        let end = self.numbers.len() + self.stride;
        self.numbers.extend(position);
        self.numbers.extend(attributes.into_iter().take(self.stride - 4));
        self.numbers.resize(end, 0.0);
    }

    /// The number of vertices.
    pub fn len(&self) -> usize {
        self.numbers.len().checked_div(self.stride).unwrap_or(0)
    }

    /// Is there no vertex?
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// (x, y, z, w) of vertex `i`, below `len()`.
    #[inline]
    pub fn position(&self, i: usize) -> [f64; 4] {
        let at = i * self.stride;
        [self.numbers[at], self.numbers[at + 1], self.numbers[at + 2], self.numbers[at + 3]]
    }

    /// (x, y, z, w) of all vertices.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = [f64; 4]> + Clone {
        (0..self.len()).map(|i| self.position(i))
    }

    /// The positions as a slice, if there are no attributes between them.
    pub(crate) fn bare_positions(&self) -> &[[f64; 4]] {
        if self.stride == 4 { self.numbers.as_chunks().0 } else { &[] }
    }

    /// The attributes of vertex `i`, below `len()`.
    #[inline]
    pub fn attributes(&self, i: usize) -> &[f64] {
        &self.numbers[i * self.stride + 4..(i + 1) * self.stride]
    }

    /// The order of vertices `i` and `j`, by position (zeros of either sign are the same), then by
    /// attributes.
    pub(crate) fn compare(&self, i: usize, j: usize) -> Ordering {
        let order = self.position(i).partial_cmp(&self.position(j));
        order.unwrap_or(Ordering::Equal).then_with(|| {
            let pairs = self.attributes(i).iter().zip(self.attributes(j));
            pairs
                .map(|(a, b)| a.total_cmp(b))
                .find(|order| order.is_ne())
                .unwrap_or(Ordering::Equal)
        })
    }

    /// All numbers of vertex `i`.
    fn array(&self, i: usize) -> &[f64] {
        &self.numbers[i * self.stride..(i + 1) * self.stride]
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.numbers.capacity() * size_of::<f64>()
    }
}

/// A plane in clip space: (x, y, z, w) is inside if `a x + b y + c z + d w >= 0`.
pub type ClipPlane = [f64; 4];

/// The signed distance of a point from a plane, negative outside.
#[inline]
fn clip_distance(plane: &ClipPlane, p: [f64; 4]) -> f64 {
    (plane[0] * p[0] + plane[1] * p[1]) + (plane[2] * p[2] + plane[3] * p[3])
}

/// What the clipper found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clipped {
    /// All vertices are outside of one plane of the view volume: nothing can be seen.
    Outside,
    /// No plane is crossed: the polygon as it is.
    Inside,
    /// Planes were crossed: the polygon is what the clipper left (possibly nothing).
    Crossed,
}

/// The planes of a viewport and the user's, in the order in which they clip: near, far, guard
/// left, right, bottom, top, user.
#[derive(Clone, Debug)]
pub struct Clipper {
    depth_range: DepthRange,
    planes: Vec<ClipPlane>,
    scratch: Vec<f64>,
}

/// Planes before the user's.
const FIXED_PLANES: usize = 6;

/// Which of them are the guard band's.
const GUARD: core::ops::Range<usize> = 2..FIXED_PLANES;

/// The planes from here on share a bit of the outcodes.
const SHARED_BIT: usize = 63;

/// On which side of the planes the vertices of a polygon lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcodes {
    /// All are outside of one plane of the view volume (or of one of the user's).
    pub hidden: bool,
    /// The planes that some vertex is outside of, a bit for each.
    crossed: u64,
}

impl Outcodes {
    /// All are inside of every plane but the sides of the viewport.
    pub fn accepted(self) -> bool {
        self.crossed == 0
    }
}

impl Clipper {
    /// The planes of `viewport`, with its depth range and its guard band.
    pub fn new(viewport: Viewport) -> Self {
        let [half_w, half_h] = viewport.half_size();
        let reach = f64::from(Subpixel::REACH);
        let (near, far) = match viewport.depth_range() {
            DepthRange::ZeroToOne => ([0.0, 0.0, 1.0, 0.0], [0.0, 0.0, -1.0, 1.0]),
            DepthRange::MinusOneToOne => ([0.0, 0.0, 1.0, 1.0], [0.0, 0.0, -1.0, 1.0]),
        };
        let planes = Vec::from([
            near,
            far,
            [half_w, 0.0, 0.0, reach + half_w],
            [-half_w, 0.0, 0.0, reach - half_w],
            [0.0, half_h, 0.0, reach - half_h],
            [0.0, -half_h, 0.0, reach + half_h],
        ]);
        Self { depth_range: viewport.depth_range(), planes, scratch: Vec::new() }
    }

    /// Sets the user's planes, which clip after the others. One with a coefficient that is not
    /// finite leaves everything inside.
    pub fn set_user_planes(&mut self, planes: &[ClipPlane]) {
        self.planes.truncate(FIXED_PLANES);
        self.planes.extend(planes.iter().map(|plane| {
            let largest = plane.iter().fold(0.0, |a: f64, b| if b.abs() > a { b.abs() } else { a });
            match exponent_of(largest) {
                // A power of two moves no plane, and no distance overflows.
                Some(exponent) if plane.iter().all(|c| c.is_finite()) => {
                    let half = exponent / 2;
                    plane.map(|c| c * power_of_two(-half) * power_of_two(half - exponent))
                }
                _ => [0.0; 4],
            }
        }));
    }

    /// Takes over the planes of `other`.
    pub(crate) fn set_as(&mut self, other: &Self) {
        self.depth_range = other.depth_range;
        self.planes.clone_from(&other.planes);
    }

    /// Are there planes beside the view volume's?
    pub(crate) fn has_user_planes(&self) -> bool {
        self.planes.len() > FIXED_PLANES
    }

    /// The number of planes.
    pub fn plane_count(&self) -> usize {
        self.planes.len()
    }

    /// Sorts vertices by their positions, which must be finite: what is to be done with them?
    #[inline(always)]
    pub fn classify(&self, positions: impl Iterator<Item = [f64; 4]> + Clone) -> Outcodes {
        let (mut beyond_all, mut beyond_any) = (0b11_1111_u32, 0_u32);
        for p in positions.clone() {
            let [x, y, z, w] = p;
            // A vertex with w < 0 is outside both sides of an axis.
            let outside = u32::from(x < -w)
                | u32::from(x > w) << 1
                | u32::from(y < -w) << 2
                | u32::from(y > w) << 3
                | u32::from(self.is_before_near(z, w)) << 4
                | u32::from(z > w) << 5;
            beyond_all &= outside;
            beyond_any |= outside;
        }
        if beyond_all != 0 {
            return Outcodes { hidden: true, crossed: 0 };
        }
        // The guard band lies outside of the viewport.
        if beyond_any == 0 && self.planes.len() == FIXED_PLANES {
            return Outcodes { hidden: false, crossed: 0 };
        }
        let (mut outside_all, mut crossed) = (u64::MAX, 0_u64);
        for p in positions {
            let mut outside = 0_u64;
            for (k, plane) in self.planes.iter().enumerate() {
                outside |= u64::from(clip_distance(plane, p) < 0.0) << k.min(SHARED_BIT);
            }
            crossed |= outside;
            outside_all &= outside;
        }
        Outcodes { crossed, hidden: outside_all & !(1 << SHARED_BIT) != 0 }
    }

    #[inline(always)]
    fn is_before_near(&self, z: f64, w: f64) -> bool {
        match self.depth_range {
            DepthRange::ZeroToOne => z < 0.0,
            DepthRange::MinusOneToOne => z < -w,
        }
    }

    /// Clips `vertices` in place, against the planes that they cross. All positions must be
    /// finite. A convex polygon of N vertices leaves at most one vertex more for each plane that it
    /// crosses, so at most N + [`Self::plane_count`], of those that differ by more than rounding:
    /// where planes that nearly coincide meet in a vertex, it may be left several times.
    pub fn clip(&mut self, vertices: &mut VertexArrays) -> Clipped {
        let outcodes = self.classify(vertices.positions());
        if outcodes.hidden {
            return Clipped::Outside;
        }
        if outcodes.crossed == 0 {
            return Clipped::Inside;
        }
        for (k, plane) in self.planes.iter().enumerate() {
            if outcodes.crossed >> k.min(SHARED_BIT) & 1 != 0 {
                clip_to_plane(vertices, plane, GUARD.contains(&k), &mut self.scratch);
            }
        }
        Clipped::Crossed
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.scratch.capacity() * size_of::<f64>() + self.planes.capacity() * size_of::<ClipPlane>()
    }
}

/// One pass of Sutherland and Hodgman: keeps what is inside, `scratch` is overwritten. A plane
/// of the `guard` band has one axis and w.
fn clip_to_plane(
    vertices: &mut VertexArrays,
    plane: &ClipPlane,
    guard: bool,
    scratch: &mut Vec<f64>,
) {
    scratch.clear();
    let n = vertices.len();
    let distance = |i: usize| clip_distance(plane, vertices.position(i));
    let mut from = n.wrapping_sub(1);
    let mut from_distance = if n > 0 { distance(from) } else { 0.0 };
    for to in 0..n {
        let to_distance = distance(to);
        if (from_distance < 0.0) != (to_distance < 0.0) {
            let (near_weight, far_weight) = (to_distance.abs(), from_distance.abs());
            let sum = near_weight + far_weight;
            let (a, b) = (near_weight / sum, far_weight / sum);
            scratch.extend(
                vertices.array(from).iter().zip(vertices.array(to)).map(|(p, q)| p * a + q * b),
            );
            let new = scratch.len() - vertices.stride;
            straighten(vertices, [from, to], [a, b], &mut scratch[new..]);
            if guard && let Some(axis) = (0..3).find(|axis| plane[*axis] != 0.0) {
                // Between giants the sum cancels: but where on its axis the plane is, is known.
                scratch[new + axis] = -plane[3] / plane[axis] * scratch[new + 3];
            }
        }
        if to_distance >= 0.0 {
            scratch.extend_from_slice(vertices.array(to));
        }
        (from, from_distance) = (to, to_distance);
    }
    core::mem::swap(&mut vertices.numbers, scratch);
}

/// Puts right, in the array `new` of a vertex that is `weights` of two others, what runs linearly
/// in the framebuffer.
fn straighten(vertices: &VertexArrays, ends: [usize; 2], weights: [f64; 2], new: &mut [f64]) {
    let [p, q] = ends.map(|i| vertices.array(i));
    if vertices.noperspective.is_empty() || p[3] <= 0.0 || q[3] <= 0.0 {
        return;
    }
    // A point's place on the edge in the framebuffer goes by weight times w.
    let (a, b) = (weights[0] * p[3], weights[1] * q[3]);
    let (a, b) = (a / (a + b), b / (a + b));
    for k in &vertices.noperspective {
        new[4 + k] = p[4 + k] * a + q[4 + k] * b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clip(points: &[[f64; 4]], range: DepthRange) -> (Clipped, VertexArrays) {
        let viewport = Viewport::new(0, 0, 64, 64).expect("small").with_depth_range(range);
        let mut arrays = VertexArrays::new(1);
        for (i, p) in (0..).zip(points) {
            arrays.push(*p, [f64::from(i)]);
        }
        let found = Clipper::new(viewport).clip(&mut arrays);
        (found, arrays)
    }

    #[test]
    fn clip_accepts_rejects_and_cuts() {
        let inside = [[-0.5, -0.5, 0.5, 1.0], [0.5, -0.5, 0.5, 1.0], [0.0, 0.6, 0.5, 1.0]];
        assert_eq!(clip(&inside, DepthRange::ZeroToOne).0, Clipped::Inside);
        let negated = inside.map(|p| p.map(|c: f64| -c));
        assert_eq!(clip(&negated, DepthRange::ZeroToOne).0, Clipped::Outside);
        let behind = [inside[0], inside[1], [0.0, 0.6, -0.5, 1.0]];
        let (found, cut) = clip(&behind, DepthRange::ZeroToOne);
        assert_eq!((found, cut.len()), (Clipped::Crossed, 4));
        assert!((0..4).all(|i| cut.position(i)[2] >= 0.0));
        assert_eq!(clip(&behind, DepthRange::MinusOneToOne).0, Clipped::Inside);
    }

    #[test]
    fn clip_gives_the_same_vertex_in_either_direction() {
        let (a, b) = ([0.3, -0.7, 0.9, 1.1], [1e20, 3.0, -7.5, -0.1]);
        let (c, d) = ([0.1, 0.2, 0.3, 0.4], [-0.1, 0.2, 0.3, 0.4]);
        let (_, one) = clip(&[a, b, c], DepthRange::ZeroToOne);
        let (_, other) = clip(&[b, a, d], DepthRange::ZeroToOne);
        let shared = |v: &VertexArrays| {
            let mut all: Vec<[u64; 4]> =
                (0..v.len()).map(|i| v.position(i).map(f64::to_bits)).collect();
            all.sort_unstable();
            all
        };
        let (one, other) = (shared(&one), shared(&other));
        assert!(one.iter().filter(|p| other.contains(p)).count() >= 2);
    }
}
