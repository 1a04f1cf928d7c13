//! P1, where planes cut: polygons that were clipped share their edges without crack and overlap,
//! and cover what the exact clipper leaves.

use std::collections::BTreeMap;

use crate::oracle::Poly;
use crate::oracle::clipper::{self, Side};
use crate::oracle::coverage::is_unclipped;
use crate::oracle::exact::{Q, q, sum};
use crate::oracle::judge::{self, TOLERANCE};
use crate::oracle::probe::{self, View};
use crate::oracle::shapes::{Tally, check, clipped_polygons, scenes};
use hyperspan::space::{DepthRange, PixelRect, Viewport};
use proptest::prelude::*;

/// A net of quads and triangles on a plane that reaches behind the eye, before the near plane,
/// beyond the far one, and out of the guard band.
#[derive(Clone, Debug)]
struct Net {
    view: View,
    /// (columns + 1) x (rows + 1) clip positions.
    points: Vec<[f64; 4]>,
    columns: usize,
    pieces: Vec<(bool, usize, bool)>,
}

impl Net {
    /// The cells, each a quad or two triangles, their lists begun anywhere, in either direction.
    fn polygons(&self) -> Vec<Poly> {
        let mut all = Vec::new();
        let rows = self.points.len() / (self.columns + 1) - 1;
        for cell in 0..self.columns * rows {
            let corner = cell / self.columns * (self.columns + 1) + cell % self.columns;
            let next = corner + self.columns + 1;
            let [a, b, c, d] = [corner, corner + 1, next + 1, next].map(|i| self.points[i]);
            let (split, turn, over) = self.pieces[cell % self.pieces.len()];
            let parts =
                if split { vec![vec![a, b, c], vec![a, c, d]] } else { vec![vec![a, b, c, d]] };
            for part in parts {
                let poly = Poly::bare(&part).rotated(turn % part.len());
                all.push(if over { poly.reversed() } else { poly });
            }
        }
        all
    }

    /// The whole net as one polygon.
    fn outline(&self) -> Poly {
        let last = self.points.len() - 1;
        let corners = [0, self.columns, last, last - self.columns];
        Poly::bare(&corners.map(|i| self.points[i]))
    }
}

/// Nets: `origin` + i `right` + j `down`, all in clip space, so that the net is flat and its
/// image's size and place are anything.
fn nets() -> impl Strategy<Value = Net> {
    let vector = |most: f64| [-most..most, -most..most, -most..most, -most..most];
    let shape = (1..=4_usize, 1..=4_usize);
    let vectors = prop_oneof![
        2 => (vector(1.0), vector(3.0), vector(3.0)),
        1 => (vector(1.0), vector(1e4), vector(3.0)),
        1 => (vector(0.3), vector(1e3), vector(1e5)),
        1 => (vector(1.0), Just([1.0, 0.0, 0.0, 0.0]), Just([0.0, 1.0, -1.5, 2.0])),
    ];
    // Little enough to leave every cell convex.
    let shift = prop::collection::vec(-0.2..0.2_f64, 50);
    let pieces = prop::collection::vec((any::<bool>(), 0..4_usize, any::<bool>()), 1..16);
    (shape, vectors, shift, pieces, 1..60_u32, 1..60_u32, any::<bool>()).prop_map(
        |((columns, rows), (middle, right, down), shift, pieces, w, h, gl)| {
            let range = if gl { DepthRange::MinusOneToOne } else { DepthRange::ZeroToOne };
            let viewport = Viewport::new(0, 0, w, h).expect("small").with_depth_range(range);
            let mut points = Vec::new();
            for j in 0..=rows {
                for i in 0..=columns {
                    // Inner points are moved aside; those of the outline stay on its sides.
                    let k = 2 * (j * (columns + 1) + i);
                    let free = |at: usize, of: usize, by: f64| {
                        let moved = if at > 0 && at < of { at as f64 + by } else { at as f64 };
                        moved / of as f64 - 0.5
                    };
                    let (s, t) = (free(i, columns, shift[k]), free(j, rows, shift[k + 1]));
                    let seen = [middle[0], middle[1], middle[2].abs() + 0.2, middle[3].abs() + 0.4];
                    points.push([0, 1, 2, 3].map(|c| seen[c] + s * right[c] + t * down[c]));
                }
            }
            Net { view: View::whole(viewport), points, columns, pieces }
        },
    )
}

#[test]
fn clipping_of_a_clipped_net_has_no_crack_and_no_overlap() {
    let (clipped, pixels) = (Tally::default(), Tally::default());
    let cases = check(file!(), "coverage_of_a_clipped_net", 4000, &nets(), |net| {
        let view = &net.view;
        let mut counts = BTreeMap::new();
        for part in net.polygons() {
            for pixel in probe::coverage(view, &part) {
                *counts.entry(pixel).or_insert(0) += 1;
            }
            clipped.add(usize::from(!is_unclipped(view.viewport, &part)));
        }
        pixels.add(counts.len());
        let twice = counts.iter().find(|(_, c)| **c != 1);
        prop_assert_eq!(twice, None, "drawn twice");
        let corners = clipper::clip(&net.outline(), &clipper::planes(view.viewport));
        let outline = clipper::outline(view.viewport, &corners);
        for (x, y) in centres(view.visible()) {
            let drawn = counts.contains_key(&(x, y));
            match clipper::side(&outline, x, y, TOLERANCE) {
                Side::Inside => prop_assert!(drawn, "a crack at {:?}", (x, y)),
                Side::Outside => prop_assert!(!drawn, "too much at {:?}", (x, y)),
                Side::Near => {}
            }
        }
        Ok(())
    });
    clipped.report("clipped polygons", 3 * cases);
    pixels.report("covered pixels", 100 * cases);
}

/// Triangles with vertices anywhere, most of them crossed by planes: before the near plane,
/// beyond the far one, behind the eye.
fn wild_triangles() -> impl Strategy<Value = (View, Poly)> {
    let coordinate = prop_oneof![4 => -2.0..2.0, 1 => -1e3..1e3, 1 => -1e6..1e6];
    let whole = (-2..=2_i32).prop_map(f64::from);
    let coordinate = prop_oneof![4 => coordinate, 1 => whole].boxed();
    let positive = (0.01..2.0_f64).boxed();
    let any_vertex =
        [coordinate.clone(), coordinate.clone(), coordinate.clone(), coordinate.clone()];
    let seen_vertex = [coordinate.clone(), coordinate.clone(), coordinate, positive];
    let vertices = prop_oneof![
        [any_vertex.clone(), any_vertex.clone(), seen_vertex.clone()],
        [any_vertex, seen_vertex.clone(), seen_vertex.clone()],
        [seen_vertex.clone(), seen_vertex.clone(), seen_vertex],
    ];
    (vertices, 1..60_u32, 1..60_u32, any::<bool>()).prop_map(|(vertices, w, h, gl)| {
        let range = if gl { DepthRange::MinusOneToOne } else { DepthRange::ZeroToOne };
        let viewport = Viewport::new(0, 0, w, h).expect("small").with_depth_range(range);
        (View::whole(viewport), Poly::bare(&vertices))
    })
}

#[test]
fn clipping_of_clipped_triangles_is_that_of_the_exact_clipper() {
    let (clipped, pixels) = (Tally::default(), Tally::default());
    let cases = check(file!(), "coverage_of_clipped", 30000, &wild_triangles(), |(view, poly)| {
        let (_, picture, stats) = probe::draw(&view, &poly);
        if stats.clipped > 0 {
            clipped.add(usize::from(!picture.is_empty()));
            pixels.add(picture.len());
        }
        judge::coverage(&view, &poly, &picture).map_err(TestCaseError::fail)?;
        Ok(())
    });
    clipped.report("clipped triangles in sight", cases / 6);
    pixels.report("their pixels", 30 * cases);
}

/// Triangles that reach out of the guard band, up to 10^8 times w: beyond that an
/// edge from one giant to another is known in f64 to less than the tolerance here
/// (docs/precision.md). Covers of any size are in tests/promises/nasty.rs.
fn giants() -> impl Strategy<Value = (View, Poly)> {
    let exponents =
        prop_oneof![Just([0_i32, 7, 7]), [0..3_i32, 0..6, 0..8], [0..8_i32, 0..8, 0..8]];
    let mantissas = [-3.0..3.0, -3.0..3.0, 0.0..1.0, 0.1..1.0_f64];
    let vertices = [mantissas.clone(), mantissas.clone(), mantissas];
    (exponents, vertices, any::<bool>()).prop_map(|(exponents, vertices, through)| {
        let place = |(e, [x, y, z, w]): (i32, [f64; 4])| {
            let size = 10.0_f64.powi(e);
            [x * size, y * size, z * w, w]
        };
        let mut positions: Vec<_> = exponents.into_iter().zip(vertices).map(place).collect();
        if through {
            // An edge that goes through the middle of the picture, or near it.
            positions[2] = [-positions[1][0], -positions[1][1], 0.25, 0.5];
        }
        (View::whole(Viewport::new(0, 0, 40, 30).expect("small")), Poly::bare(&positions))
    })
}

#[test]
fn clipping_of_giants_is_that_of_the_exact_clipper() {
    let (clipped, pixels) = (Tally::default(), Tally::default());
    let cases = check(file!(), "coverage_of_giants", 10_000, &giants(), |(view, poly)| {
        let (_, picture, stats) = probe::draw(&view, &poly);
        judge::coverage(&view, &poly, &picture).map_err(TestCaseError::fail)?;
        clipped.add(usize::from(stats.clipped > 0 && !picture.is_empty()));
        pixels.add(picture.len());
        Ok(())
    });
    clipped.report("clipped triangles in sight", cases / 4);
    pixels.report("pixels", 100 * cases);
}

/// The planes +d and -d of the user part every polygon that does not lie in the plane: each of
/// its pixels belongs to exactly one of the parts, and none to two. (A part has new vertices on
/// the polygon's sides, which are snapped: pixels within the tolerance of a side may go.)
#[test]
fn clipping_of_complementary_user_planes_is_a_partition() {
    let any_plane = [-2.0..2.0, -2.0..2.0, -2.0..2.0, -2.0..2.0_f64];
    let whole = (-2..=2_i32).prop_map(f64::from);
    let whole_plane = [whole.clone(), whole.clone(), whole.clone(), whole];
    let plane = prop_oneof![2 => any_plane, 1 => whole_plane];
    let flat = prop_oneof![clipped_polygons(), scenes(4.0).prop_map(|s| (s.view(), s.poly))];
    let (parted, pixels) = (Tally::default(), Tally::default());
    let strategy = (flat, prop::collection::vec(plane, 1..4));
    let cases = check(file!(), "coverage_of_user_planes", 6000, &strategy, |(flat, planes)| {
        let poly = Poly::bare(&flat.1.positions);
        let view = View { interpolation: Vec::new(), ..flat.0 };
        let visible = clipper::clip(&poly, &clipper::planes(view.viewport));
        let outline = clipper::outline(view.viewport, &visible);
        let distance = |p: &[f64; 4], v: &[f64; 4]| sum((0..4).map(|i| q(p[i]) * q(v[i])));
        let holds = |p: &[f64; 4]| poly.positions.iter().all(|v| distance(p, v) == Q::ZERO);
        if area(&outline) < 1.0 || planes.iter().any(holds) {
            return Ok(());
        }
        // All combinations of signs.
        let mut counts = BTreeMap::new();
        let mut parts = 0;
        for signs in 0..1_u32 << planes.len() {
            let side = |(i, plane): (usize, &[f64; 4])| {
                let sign = if signs >> i & 1 == 1 { -1.0 } else { 1.0 };
                plane.map(|c| c * sign)
            };
            let sides: Vec<[f64; 4]> = planes.iter().enumerate().map(side).collect();
            let mut tiler = view.tiler();
            tiler.set_clip_planes(&sides);
            let part = probe::draw_with(&mut tiler, &view, &poly).1;
            parts += usize::from(!part.is_empty());
            for (y, x) in part.into_keys() {
                *counts.entry((x, y)).or_insert(0) += 1;
            }
        }
        parted.add(usize::from(parts > 1));
        pixels.add(counts.len());
        let wrong = counts.iter().find(|(_, count)| **count != 1);
        prop_assert_eq!(wrong, None, "drawn twice");
        for place in centres(view.visible()) {
            match (clipper::side(&outline, place.0, place.1, TOLERANCE), counts.get(&place)) {
                (Side::Inside, None) => prop_assert!(false, "a crack at {:?}", place),
                (Side::Outside, Some(_)) => prop_assert!(false, "too much at {:?}", place),
                _ => {}
            }
        }
        Ok(())
    });
    parted.report("polygons that were parted", cases / 10);
    pixels.report("their pixels", 30 * cases);
}

/// Of a polygon in the framebuffer, in pixels.
fn area(outline: &[[f64; 2]]) -> f64 {
    let next = |i: usize| outline[(i + 1) % outline.len()];
    let cross = |(i, a): (usize, &[f64; 2])| a[0] * next(i)[1] - a[1] * next(i)[0];
    outline.iter().enumerate().map(cross).sum::<f64>().abs() / 2.0
}

/// Row by row.
fn centres(rect: PixelRect) -> impl Iterator<Item = (i32, i32)> {
    (rect.y0..rect.y1).flat_map(move |y| (rect.x0..rect.x1).map(move |x| (x, y)))
}

/// User planes against the definition: what lies on its inner side is drawn.
#[test]
fn clipping_of_user_planes_is_that_of_the_exact_clipper() {
    let plane = || [-2.0..2.0, -2.0..2.0, -2.0..2.0, -2.0..2.0_f64];
    let strategy = (clipped_polygons(), prop::collection::vec(plane(), 0..70));
    let pixels = Tally::default();
    let cases =
        check(file!(), "coverage_of_one_side", 3000, &strategy, |((view, poly), planes)| {
            // Mostly a few; now and then more than there are bits in a word.
            let count = if planes.len() > 65 { planes.len() } else { planes.len() % 4 };
            let mut planes = planes[..count].to_vec();
            if count > 65 {
                planes.iter_mut().for_each(|p| p[3] = p[3].abs() + 4.0);
            }
            let poly = Poly::bare(&poly.positions);
            let mut tiler = view.tiler();
            tiler.set_clip_planes(&planes);
            let picture = probe::draw_with(&mut tiler, &view, &poly).1;
            pixels.add(picture.len());
            let mut all = clipper::planes(view.viewport);
            all.extend(planes.iter().map(|p| p.map(q)));
            let outline = clipper::outline(view.viewport, &clipper::clip(&poly, &all));
            for (x, y) in centres(view.visible()) {
                match (clipper::side(&outline, x, y, TOLERANCE), picture.contains_key(&(y, x))) {
                    (Side::Inside, drawn) => prop_assert!(drawn, "not drawn: {:?}", (x, y)),
                    (Side::Outside, drawn) => prop_assert!(!drawn, "drawn: {:?}", (x, y)),
                    _ => {}
                }
            }
            Ok(())
        });
    pixels.report("pixels", 30 * cases);
}
