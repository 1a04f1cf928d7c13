//! Cuts what is not convex or not flat into triangles, by a library (ear clipping), and puts
//! right what that leaves undone.
//!
//! Ear clipping drops vertices that lie on a straight line between others. The neighbouring
//! face has them, so that a crack could open along that side once positions are snapped; and
//! in a face that is not flat they are not on the line at all. So they are put back.

use std::collections::HashMap;

use super::face::signed_area;

/// Steps in 1, which is about the size of a face: ears are clipped between whole steps. Vertices that
/// are nearer to each other turn every way, and the library loses its own.
const STEPS: f64 = (1_u64 << 40) as f64;

/// Triangles of the simple polygon `points`, which are about 1 from 0 at most, as numbers of its vertices, wound as the polygon
/// is. Every side of the polygon is the side of a triangle. Empty if nothing can be made of it.
pub(super) fn triangulate(points: &[[f64; 2]]) -> Vec<[usize; 3]> {
    let rounded: Vec<f64> = points.as_flattened().iter().map(|c| (c * STEPS).round()).collect();
    let Ok(corners) = earcutr::earcut(&rounded, &[], 2) else { return Vec::new() };
    let mut triangles: Vec<[usize; 3]> = corners
        .as_chunks()
        .0
        .iter()
        .copied()
        .filter(|triangle| triangle.iter().all(|corner| *corner < points.len()))
        .collect();
    let turns_left = signed_area(points) > 0.0;
    for triangle in &mut triangles {
        if (signed_area(&triangle.map(|corner| points[corner])) > 0.0) != turns_left {
            triangle.reverse();
        }
    }
    put_back(&mut triangles, points.len());
    triangles
}

/// Divides triangles until each of the polygon's `n` vertices is a corner of one.
fn put_back(triangles: &mut Vec<[usize; 3]>, n: usize) {
    let mut used = vec![false; n];
    for corner in triangles.iter().flatten() {
        used[*corner] = true;
    }
    if used.iter().all(|used| *used) {
        return;
    }
    // Which triangle has a side: there is at most one that goes this way.
    let mut owner: HashMap<[usize; 2], usize> = HashMap::new();
    for (t, [a, b, c]) in triangles.iter().enumerate() {
        owner.extend([([*a, *b], t), ([*b, *c], t), ([*c, *a], t)]);
    }
    let kept: Vec<usize> = (0..n).filter(|i| used[*i]).collect();
    for (i, &from) in kept.iter().enumerate() {
        let to = kept[(i + 1) % kept.len()];
        let dropped = (to + n - from - 1) % n;
        if dropped == 0 {
            continue;
        }
        let Some(&t) = owner.get(&[from, to]) else { continue };
        let Some(&apex) = triangles[t].iter().find(|corner| **corner != from && **corner != to)
        else {
            continue;
        };
        // It becomes a fan about its third corner; its other two sides stay whole.
        triangles[t] = [from, (from + 1) % n, apex];
        triangles.extend((1..=dropped).map(|d| [(from + d) % n, (from + d + 1) % n, apex]));
        owner.insert([to, apex], triangles.len() - 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(points: &[[f64; 2]]) {
        for backwards in [false, true] {
            let mut points = points.to_vec();
            if backwards {
                points.reverse();
            }
            let triangles = triangulate(&points);
            let area = |t: &[usize; 3]| signed_area(&t.map(|i| points[i]));
            let whole = signed_area(&points);
            let sum: f64 = triangles.iter().map(area).sum();
            assert!((sum - whole).abs() < 1e-12 * whole.abs(), "{sum} of {whole}");
            assert!(triangles.iter().all(|t| area(t) * whole >= 0.0), "all turn the same way");
            let sides: Vec<_> =
                triangles.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]).collect();
            for i in 0..points.len() {
                let side = (i, (i + 1) % points.len());
                assert_eq!(sides.iter().filter(|s| **s == side).count(), 1, "side {side:?}");
            }
        }
    }

    #[test]
    fn triangles_fill_the_polygon_and_keep_every_side() {
        check(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]]);
        // Vertices on straight sides, several in a row, also round the start of the list.
        check(&[
            [1.0, 0.0],
            [2.0, 0.0],
            [3.0, 0.0],
            [4.0, 0.0],
            [4.0, 2.0],
            [4.0, 4.0],
            [2.0, 1.0],
            [0.0, 4.0],
            [0.0, 3.0],
            [0.0, 1.0],
            [0.0, 0.0],
        ]);
        let comb = (0..200).map(|i| [f64::from(i), if i % 2 == 0 { 0.0 } else { 50.0 }]);
        let mut points: Vec<_> = comb.collect();
        points.extend([[199.0, 60.0], [0.0, 60.0]]);
        check(&points);
    }

    /// A fuzzer's: of the triangle itself nothing was left.
    #[test]
    fn triangles_fill_a_polygon_with_many_vertices_nearly_at_one_place() {
        let (a, b) = (8.978549240895584e-20, 2.0328790734103208e-20);
        let points = [
            [0.0, 0.0],
            [a, a],
            [0.0, 8.470329472543003e-22],
            [0.0, b],
            [-2.625802136488331e-20, -2.625802136488331e-20],
            [-8.216219588366713e-20, 2.541098841762901e-20],
            [a, a],
            [0.0, 8.470341589446508e-22],
            [1.9375, 1.9375],
            [1.9375, 0.0],
            [2.710505431213761e-20, a],
            [0.0, 0.0],
        ];
        let area = |t: &[usize; 3]| signed_area(&t.map(|i| points[i]));
        let sum: f64 = triangulate(&points).iter().map(area).sum();
        assert!((sum - signed_area(&points)).abs() < 1e-9, "{sum}");
    }

    #[test]
    fn triangles_of_what_is_no_simple_polygon_do_no_harm() {
        for points in [
            vec![],
            vec![[0.0; 2]; 5],
            vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]],
            vec![[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]],
        ] {
            let n = points.len();
            assert!(triangulate(&points).iter().flatten().all(|i| *i < n));
        }
    }
}
