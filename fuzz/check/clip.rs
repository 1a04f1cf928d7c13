//! The clipper alone, on a polygon of up to eight vertices and up to eight user planes, or ten
//! times as many, all finite. Nothing panics, and where no number is beyond 1e100:
//!
//! - what is found `Inside` is untouched, what is found `Outside` has no middle that is seen;
//! - a convex polygon leaves at most N + planes vertices, and no more of those that differ by more
//!   than rounding than N + the planes that it crosses; any other one at most twice as many for
//!   each plane;
//! - a convex polygon stays convex, and its area (along any two axes) does not grow: it is the area
//!   that a naive clipper in rationals leaves;
//! - no vertex that is inside every plane is lost;
//! - every vertex that is left is inside every plane but for rounding, and its numbers lie in
//!   their range over the vertices as given, but for rounding;
//! - the reversed list leaves the same vertices, bit for bit, and so does a rotated one;
//! - an edge alone leaves the same vertices, bit for bit, as it does in its polygon, so that the
//!   polygon on its other side has them too;
//! - a plane and its complement cut the same new vertices out of the polygon, bit for bit.

use hyperspan::clip::{ClipPlane, Clipped, Clipper, VertexArrays};
use hyperspan::space::{DepthRange, Viewport};

use super::bytes::Bytes;
use super::shape::Shape;
use crate::oracle::Poly;
use crate::oracle::clipper as naive;
use crate::oracle::exact::{approximate, q};

/// A polygon and what it is clipped by.
struct Case {
    viewport: Viewport,
    /// The user's.
    planes: Vec<ClipPlane>,
    shape: Shape,
    /// Has the attribute no perspective?
    linear: bool,
}

pub(crate) fn clip(data: &[u8]) {
    let bytes = &mut Bytes(data);
    let range = bytes.pick(&[DepthRange::ZeroToOne, DepthRange::MinusOneToOne]);
    let sides = bytes.pick(&[(64, 64), (1, 1), (16384, 16384), (7, 16384), (0, 0)]);
    let viewport = Viewport::new(bytes.small(), bytes.small(), sides.0, sides.1)
        .expect("sides of 16384 at most")
        .with_depth_range(range);
    let tame = bytes.below(4) != 0;
    let mut shape = Shape::new(bytes, 1, viewport, (0, 0));
    let mut planes: Vec<ClipPlane> = Vec::new();
    for _ in 0..bytes.below(9) {
        planes.push(shape.plane(bytes, &planes));
    }
    // More than there are bits for.
    if bytes.below(16) == 15 {
        planes = planes.iter().cycle().take(planes.len() * 10).copied().collect();
    }
    let limit = if tame { 1e100 } else { f64::MAX };
    let numbers = shape.positions.iter_mut().chain(&mut planes).flatten();
    for number in numbers {
        // The clipper is promised finite numbers.
        if number.is_nan() || number.abs() > limit {
            *number = 0.75;
            shape.flat = false;
        }
    }
    for value in &mut shape.attributes {
        if !value.is_finite() {
            *value = 0.25;
        }
    }
    let first = 1 + usize::from(bytes.below(7));
    let case = Case { viewport, planes, shape, linear: bytes.below(2) == 1 };
    let shape = &case.shape;

    let mut clipper = Clipper::new(viewport);
    clipper.set_user_planes(&case.planes);
    let (found, cut) = case.run(&mut clipper, shape);
    if !tame {
        // Products overflow: no panic is all that is asked for.
        return;
    }
    match found {
        Clipped::Inside => assert_eq!(sorted(&cut), sorted(&case.arrays(shape))),
        Clipped::Outside => check_outside(&case),
        Clipped::Crossed => {
            let most = shape.positions.len() << clipper.plane_count().min(20);
            assert!(cut.len() <= most, "{} vertices left", cut.len());
            check_cut(&case, &cut);
            check_convex(&case, &cut);
        }
    }
    for other in [reversed(shape), shape.rotated(first)] {
        let (found_other, cut_other) = case.run(&mut clipper, &other);
        assert_eq!(found, found_other);
        assert_eq!(sorted(&cut), sorted(&cut_other), "another order of the vertices");
    }
    if found != Clipped::Outside {
        check_edges(&case, &mut clipper, &cut);
    }
    check_complement(&case);
}

impl Case {
    fn arrays(&self, shape: &Shape) -> VertexArrays {
        let mut arrays = VertexArrays::new(1);
        if self.linear {
            arrays.set_noperspective(0);
        }
        for (position, attribute) in shape.positions.iter().zip(&shape.attributes) {
            arrays.push(*position, [f64::from(*attribute)]);
        }
        arrays
    }

    fn run(&self, clipper: &mut Clipper, shape: &Shape) -> (Clipped, VertexArrays) {
        let mut arrays = self.arrays(shape);
        let found = clipper.clip(&mut arrays);
        (found, arrays)
    }

    /// Near and far.
    fn depth_planes(&self) -> [ClipPlane; 2] {
        let near = match self.viewport.depth_range() {
            DepthRange::ZeroToOne => [0.0, 0.0, 1.0, 0.0],
            DepthRange::MinusOneToOne => [0.0, 0.0, 1.0, 1.0],
        };
        [near, [0.0, 0.0, -1.0, 1.0]]
    }

    /// All planes, in their order.
    fn all_planes(&self) -> Vec<ClipPlane> {
        let fixed = naive::planes(self.viewport);
        let fixed = fixed.iter().map(|plane| [0, 1, 2, 3].map(|k| approximate(&plane[k])));
        fixed.chain(self.planes.iter().copied()).collect()
    }
}

fn reversed(shape: &Shape) -> Shape {
    let mut reversed = shape.clone();
    reversed.positions.reverse();
    reversed.attributes.reverse();
    reversed
}

fn vertex(arrays: &VertexArrays, i: usize) -> Vec<f64> {
    [&arrays.position(i), arrays.attributes(i)].concat()
}

/// The numbers of all vertices; the sign of a zero is of no account.
fn bits(arrays: &VertexArrays) -> Vec<Vec<u64>> {
    let bits = |i| vertex(arrays, i).into_iter().map(|v| (v + 0.0).to_bits()).collect();
    (0..arrays.len()).map(bits).collect()
}

fn sorted(arrays: &VertexArrays) -> Vec<Vec<u64>> {
    let mut all = bits(arrays);
    all.sort_unstable();
    all
}

/// What rounding may do, relative to the largest number involved.
const ROUNDING: f64 = 1e-13;

/// Products of two numbers above it do not underflow, divided by a plane's largest either.
const UNDERFLOW: f64 = 1e-100;

fn terms(plane: &ClipPlane, p: [f64; 4]) -> [f64; 4] {
    [0, 1, 2, 3].map(|k| plane[k] * p[k])
}

/// How a plane lies to the polygon.
struct Distances {
    /// The largest term of any vertex's distance.
    size: f64,
    least: f64,
    most: f64,
    /// The least magnitude.
    nearest: f64,
}

impl Distances {
    fn new(plane: &ClipPlane, positions: &[[f64; 4]]) -> Self {
        let of = |p: &[f64; 4]| {
            let [x, y, z, w] = terms(plane, *p);
            (x + y) + (z + w)
        };
        let all = positions.iter().map(of);
        Self {
            size: positions.iter().flat_map(|p| terms(plane, *p)).map(f64::abs).fold(0.0, f64::max),
            least: all.clone().fold(f64::INFINITY, f64::min),
            most: all.clone().fold(f64::NEG_INFINITY, f64::max),
            nearest: all.map(f64::abs).fold(f64::INFINITY, f64::min),
        }
    }
}

/// The middle of what is not seen is not seen.
fn check_outside(case: &Case) {
    let n = case.shape.positions.len() as f64;
    let middle = [0, 1, 2, 3].map(|k| case.shape.positions.iter().map(|p| p[k] / n).sum());
    let sides =
        [[1.0, 0.0, 0.0, 1.0], [-1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, -1.0, 0.0, 1.0]];
    let mut planes = case.planes.iter().chain(&sides).copied().chain(case.depth_planes());
    let beyond = planes.any(|plane| {
        let size = Distances::new(&plane, &case.shape.positions).size;
        terms(&plane, middle).iter().sum::<f64>() <= ROUNDING * size.max(UNDERFLOW)
    });
    assert!(beyond || n == 0.0, "{middle:?} is inside of every plane");
}

fn check_cut(case: &Case, cut: &VertexArrays) {
    let Case { viewport, planes, shape, .. } = case;
    let depth = case.depth_planes();
    for plane in &case.all_planes() {
        let largest = shape.positions.iter().flat_map(|p| terms(plane, *p));
        let allowed = ROUNDING * largest.map(f64::abs).fold(UNDERFLOW, f64::max);
        for i in 0..cut.len() {
            let distance: f64 = terms(plane, cut.position(i)).iter().sum();
            assert!(distance >= -allowed, "vertex {i} is {distance:e} from {plane:?}");
        }
    }
    let given = case.arrays(shape);
    let left = sorted(cut);
    for (i, vertex) in bits(&given).into_iter().enumerate() {
        let p = given.position(i);
        let visible = p[0].abs() <= p[3] && p[1].abs() <= p[3];
        let inside = planes.iter().chain(&depth).all(|plane| {
            let [x, y, z, w] = terms(plane, p);
            (x + y) + (z + w) >= 0.0
        });
        // Where products underflow, a distance may round to either side.
        let small = |numbers: &[f64]| numbers.iter().any(|c| *c != 0.0 && c.abs() < UNDERFLOW);
        let unsure = small(&p) || planes.iter().any(|plane| small(plane));
        assert!(unsure || !(visible && inside) || left.contains(&vertex), "vertex {i} is lost");
    }
    for k in 0..5 {
        let column = || (0..given.len()).map(|i| vertex(&given, i)[k]);
        let least = column().fold(f64::INFINITY, f64::min);
        let most = column().fold(f64::NEG_INFINITY, f64::max);
        let mut slack = ROUNDING * least.abs().max(most.abs());
        if let Some(side) = [viewport.width(), viewport.height()].get(k) {
            // On the guard band x and y are some reach times w, and as good as w.
            let reach = 32767.0 / (f64::from(*side) / 2.0) + 1.0;
            let w = shape.positions.iter().map(|p| p[3].abs()).fold(0.0, f64::max);
            slack += ROUNDING * w * if reach.is_finite() { reach } else { 0.0 };
        }
        for i in 0..cut.len() {
            let value = vertex(cut, i)[k];
            let inside = least - slack <= value && value <= most + slack;
            assert!(inside, "number {k} of vertex {i}: {value:e} not in {least:e}..={most:e}");
        }
    }
}

/// Twice the area of a polygon along two axes.
fn area(positions: &[[f64; 4]], axes: [usize; 2]) -> f64 {
    let Some(origin) = positions.first() else { return 0.0 };
    let side = |p: &[f64; 4]| axes.map(|k| p[k] - origin[k]);
    let pairs = positions.iter().zip(positions.iter().skip(1));
    let cross = |(p, q): (&[f64; 4], &[f64; 4])| {
        let (p, q) = (side(p), side(q));
        p[0] * q[1] - p[1] * q[0]
    };
    pairs.map(cross).sum()
}

/// What the clipper must hold of a convex polygon.
fn check_convex(case: &Case, cut: &VertexArrays) {
    let given = &case.shape.positions;
    let numbers = || given.iter().chain(&case.planes).flatten().filter(|c| **c != 0.0);
    if !case.shape.flat || given.len() < 3 || numbers().any(|c| c.abs() < UNDERFLOW) {
        return;
    }
    let scale = [0, 1, 2, 3].map(|k| given.iter().map(|p| p[k].abs()).fold(0.0, f64::max));
    let left: Vec<[f64; 4]> = cut.positions().collect();
    // How far rounding moves each plane, as a part of the polygon's size across it.
    let mut crossed = Vec::new();
    let mut moved = 0.0;
    for plane in case.all_planes() {
        let found = Distances::new(&plane, given);
        if found.least < 0.0 {
            moved += ROUNDING * found.size / (found.most - found.least);
            crossed.push(plane);
        }
    }
    // Where planes meet in a vertex, rounding leaves it several times.
    let is_near = |p: &[f64; 4], q: &[f64; 4]| {
        (0..4).all(|k| (p[k] - q[k]).abs() <= 1e3 * ROUNDING * scale[k])
    };
    let mut distinct: Vec<[f64; 4]> = Vec::new();
    for p in &left {
        if !distinct.iter().any(|q| is_near(p, q)) {
            distinct.push(*p);
        }
    }
    if moved < 1e-6 {
        let most = given.len() + crossed.len();
        assert!(distinct.len() <= most, "{} vertices of {}", distinct.len(), given.len());
        let most = given.len() + case.all_planes().len();
        assert!(left.len() <= most, "{} vertices of {}, all in all", left.len(), given.len());
    }

    let exact = (crossed.len() <= 4).then(|| {
        let planes: Vec<_> = crossed.iter().map(|plane| plane.map(q)).collect();
        let corners = naive::clip(&Poly::bare(given), &planes);
        let rounded = |c: &naive::Corner| [0, 1, 2, 3].map(|k| approximate(&c.position[k]));
        corners.iter().map(rounded).collect::<Vec<_>>()
    });
    for axes in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
        let whole = area(given, axes);
        let allowed = scale[axes[0]] * scale[axes[1]] * (16.0 * moved + 64.0 * ROUNDING);
        let part = area(&left, axes) * whole.signum();
        assert!(part <= whole.abs() + allowed, "area along {axes:?}: {part:e} of {whole:e}");
        if let Some(exact) = &exact {
            let right = area(exact, axes) * whole.signum();
            let near = (part - right).abs() <= allowed;
            assert!(near, "area along {axes:?}: {part:e}, right is {right:e}");
        }
        for i in 0..left.len() {
            // No three turn the other way.
            let three = [0, 1, 2].map(|j| left[(i + j) % left.len()]);
            let turn = area(&three, axes) * whole.signum();
            assert!(turn >= -allowed, "turns back at vertex {i} along {axes:?}: {turn:e}");
        }
    }
}

/// An edge alone leaves the vertices that it does in the polygon.
fn check_edges(case: &Case, clipper: &mut Clipper, cut: &VertexArrays) {
    let shape = &case.shape;
    let left = sorted(cut);
    let planes = case.all_planes();
    for i in 0..shape.positions.len() {
        let both = [i, (i + 1) % shape.positions.len()];
        let edge = Shape {
            positions: both.map(|i| shape.positions[i]).to_vec(),
            attributes: both.map(|i| shape.attributes[i]).to_vec(),
            ..shape.clone()
        };
        // An edge that lies on a plane is cut or not as the others of its polygon have it.
        let clear = planes.iter().all(|plane| {
            let found = Distances::new(plane, &edge.positions);
            found.nearest > 1e-9 * found.size && found.nearest > UNDERFLOW * UNDERFLOW
        });
        let (found, alone) = case.run(clipper, &edge);
        if clear && found != Clipped::Outside {
            for vertex in bits(&alone) {
                assert!(left.contains(&vertex), "edge {i} is cut elsewhere in the polygon");
            }
        }
    }
}

/// Both halves have the same new vertices, if nothing else cuts them.
fn check_complement(case: &Case) {
    let Some(plane) = case.planes.first() else { return };
    let mut alone = Clipper::new(case.viewport);
    if case.run(&mut alone, &case.shape).0 != Clipped::Inside {
        return;
    }
    let given = sorted(&case.arrays(&case.shape));
    let new = |plane: ClipPlane| -> Vec<Vec<u64>> {
        let mut clipper = Clipper::new(case.viewport);
        clipper.set_user_planes(&[plane]);
        let (found, cut) = case.run(&mut clipper, &case.shape);
        let mut new = sorted(&cut);
        new.retain(|v| found == Clipped::Crossed && !given.contains(v));
        new
    };
    let (inner, outer) = (new(*plane), new(plane.map(|c| -c)));
    if !inner.is_empty() && !outer.is_empty() {
        assert_eq!(inner, outer, "a plane and its complement");
    }
}
