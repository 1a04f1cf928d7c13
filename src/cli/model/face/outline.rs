//! Closed lines in two dimensions, as lists of points: how they turn, their hull, their area.

/// Do all turns go the same way, and round once? Exactly, but for the rounding of products.
pub(super) fn turns_one_way_once(points: &[[f64; 2]]) -> bool {
    let n = points.len();
    let edge = |i: usize| {
        let (p, q) = (points[i], points[(i + 1) % n]);
        [q[0] - p[0], q[1] - p[1]]
    };
    let edges = (0..n).map(edge).filter(|e| *e != [0.0; 2]);
    let (mut left, mut right) = (false, false);
    // How often the edges change from going right to going left, and back: twice for a polygon
    // that goes round once.
    let mut changes = 0;
    let mut heading = None;
    let mut before: Option<[f64; 2]> = None;
    for e in edges.clone().chain(edges.take(1)) {
        if let Some([x, y]) = before {
            let turn = x * e[1] - y * e[0];
            let forward = x * e[0] + y * e[1] > 0.0;
            left |= turn > 0.0;
            right |= turn < 0.0;
            // Straight back on itself.
            if turn == 0.0 && !forward {
                return false;
            }
        }
        before = Some(e);
        let now = if e[0] == 0.0 { e[1] > 0.0 } else { e[0] > 0.0 };
        changes += usize::from(heading.is_some_and(|heading| heading != now));
        heading = Some(now);
    }
    left != right && changes <= 2
}

/// The corners of the convex hull of `points`, counter-clockwise, without collinear ones
/// (Andrew's monotone chain).
pub(super) fn convex_hull(points: &[[f64; 2]], hull: &mut Vec<usize>) {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|i, j| {
        let ([a, b], [c, d]) = (points[*i], points[*j]);
        a.total_cmp(&c).then(b.total_cmp(&d)).then(i.cmp(j))
    });
    order.dedup_by_key(|i| points[*i].map(f64::to_bits));
    hull.clear();
    let left_of = |hull: &[usize], i: usize| match hull {
        [.., p, q] => {
            let (p, q, r) = (points[*p], points[*q], points[i]);
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) > 0.0
        }
        _ => true,
    };
    for &i in &order {
        while !left_of(hull, i) {
            hull.pop();
        }
        hull.push(i);
    }
    let lower = hull.len();
    for &i in order.iter().rev().skip(1) {
        while hull.len() > lower && !left_of(hull, i) {
            hull.pop();
        }
        hull.push(i);
    }
    hull.pop();
}

/// Twice the area, positive if counter-clockwise.
pub(crate) fn signed_area(points: &[[f64; 2]]) -> f64 {
    let Some(&o) = points.first() else { return 0.0 };
    let pairs = points.iter().zip(points.iter().skip(1));
    pairs.map(|(p, q)| (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0])).sum()
}
