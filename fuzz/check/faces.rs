//! What becomes of a model's faces, of up to 24 vertices anywhere with up to three attributes: how
//! they are judged, and cut into triangles. Nothing panics, and:
//!
//! - the verdict is the same wherever the list of vertices begins, but for `convex`: rounding may
//!   decide that one;
//! - a face that is not finite is nothing else; a triangle that has an area is flat and convex, and
//!   affine;
//! - a power of two changes nothing;
//! - triangles have corners of the face, each another, and are no more than N - 2, but for those
//!   that put vertices back;
//! - those of a face that is judged convex have its area.

use super::bytes::Bytes;
use crate::face::{Judge, Verdict, signed_area};
use crate::triangulate::triangulate;

pub(crate) fn faces(data: &[u8]) {
    let bytes = &mut Bytes(data);
    let n = 3 + usize::from(bytes.below(22));
    let stride = usize::from(bytes.below(4));
    let mut points: Vec<[f64; 3]> = Vec::new();
    let level = bytes.below(3) == 0;
    for _ in 0..n {
        let mut point = point(bytes, &points);
        if level {
            point[2] = 0.25;
        }
        points.push(point);
    }
    let even = bytes.below(2) == 0;
    let attributes: Vec<f32> = (0..n * stride)
        .map(|i| if even { points[i / stride][i % 3] as f32 } else { bytes.number_f32() })
        .collect();

    let mut judge = Judge::default();
    let verdict = run(&mut judge, &points, &attributes, stride);
    let Verdict { finite, degenerate, flat, convex, affine } = verdict;
    assert_eq!(finite, points.iter().flatten().all(|c| c.is_finite()));
    assert!(finite || verdict == Verdict::default(), "{verdict:?}");
    assert!(!degenerate || !(flat || convex || affine), "{verdict:?}");
    assert!(n > 3 || !finite || degenerate || (flat && convex), "{verdict:?}");
    check_triangles(judge.projected(), flat && convex);

    let first = usize::from(bytes.byte()) % n;
    let (mut turned, mut values) = (points.clone(), attributes.clone());
    turned.rotate_left(first);
    values.rotate_left(first * stride);
    let found = run(&mut judge, &turned, &values, stride);
    let found = Verdict { convex: verdict.convex, ..found };
    assert_eq!(found, verdict, "from vertex {first} of {points:?}");
    let factor = 2.0_f64.powi(bytes.small());
    let scaled: Vec<[f64; 3]> = points.iter().map(|p| p.map(|c| c * factor)).collect();
    let exact = points.iter().flatten().zip(scaled.iter().flatten()).all(|(a, b)| b / factor == *a);
    if exact {
        assert_eq!(run(&mut judge, &scaled, &attributes, stride), verdict, "times a power of two");
    }
    let normal = judge.unit_normal(points.iter().copied());
    let length = normal.map(f64::from).map(|c| c * c).iter().sum::<f64>().sqrt();
    assert!(length == 0.0 || (length - 1.0).abs() < 1e-6, "a normal of length {length}");
}

fn run(judge: &mut Judge, points: &[[f64; 3]], attributes: &[f32], stride: usize) -> Verdict {
    judge.judge(points.iter().copied(), attributes.iter().copied(), stride)
}

/// In small steps, of any bits, where others are, or between them.
fn point(bytes: &mut Bytes<'_>, others: &[[f64; 3]]) -> [f64; 3] {
    let earlier = |bytes: &mut Bytes<'_>| match others.len() {
        0 => [0.0; 3],
        n => others[usize::from(bytes.byte()) % n],
    };
    match bytes.below(6) {
        0 | 1 => [(); 3].map(|()| f64::from(bytes.small()) / 8.0),
        2 => [(); 3].map(|()| bytes.number()),
        3 => earlier(bytes),
        4 => {
            let mut point = earlier(bytes);
            point[usize::from(bytes.below(3))] = bytes.number();
            point
        }
        _ => {
            let (p, q) = (earlier(bytes), earlier(bytes));
            let t = f64::from(bytes.small()) / 64.0;
            [0, 1, 2].map(|k| p[k] + (q[k] - p[k]) * t)
        }
    }
}

fn check_triangles(points: &[[f64; 2]], convex: bool) {
    let triangles = triangulate(points);
    let n = points.len();
    assert!(triangles.len() <= 2 * n, "{} triangles of {n} vertices", triangles.len());
    for [a, b, c] in &triangles {
        assert!(*a < n && *b < n && *c < n);
        assert!(a != b && b != c && c != a, "a corner twice: {a}, {b}, {c}");
    }
    if convex && !triangles.is_empty() {
        let area = |t: &[usize; 3]| signed_area(&t.map(|i| points[i]));
        let (sum, whole) = (triangles.iter().map(area).sum::<f64>(), signed_area(points));
        // Nearly convex ones turn back by a hair here and there.
        assert!((sum - whole).abs() <= 0.02, "{sum} of {whole}");
    }
}
