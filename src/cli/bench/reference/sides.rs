//! Which centres lie in what is seen of a convex polygon, without clipping it: a pixel's ray goes
//! through the polygon if it is on the inner side of the plane through the eye and each edge, and
//! what it meets there is seen if its depth is within 0..1.

use std::cmp::Ordering;

use super::{Reference, cross, dot};

/// a i + b j + c k >= 0 inside, for the whole numbers of [`Reference`] that tell a pixel.
pub(crate) type Side = [f64; 3];

impl Reference {
    /// The sides of what is seen. Nothing if the polygon is not convex.
    pub(crate) fn sides(&self) -> Option<Vec<Side>> {
        let n = self.points.len();
        let sum = |i: usize| self.points.iter().map(|p| p[i]).sum();
        let inner = [0, 1, 2].map(sum);
        let (mut sides, mut turn) = (Vec::new(), Ordering::Equal);
        for (i, from) in self.points.iter().enumerate() {
            let edge = cross(*from, self.points[(i + 1) % n]);
            let way = dot(&edge, inner).sign();
            if turn == Ordering::Equal {
                turn = way;
            }
            if way != turn || way == Ordering::Equal {
                return None;
            }
            let sign = if turn == Ordering::Less { -1.0 } else { 1.0 };
            sides.push(edge.map(|e| e.pair().high * sign));
        }
        let [a, b, c] = self.depth.pairs.map(|pair| pair.high);
        let area = self.place(0, 0)[2];
        let one = self.determinant.0.high / area;
        sides.extend([[a, b, c], [-a, -b, one - c]]);
        Some(sides)
    }

    /// A side's distance at pixel (`x`, `y`), and by how much it changes from there to the next
    /// column and row.
    pub(crate) fn distance(&self, side: Side, x: i32, y: i32) -> (f64, [f64; 2]) {
        let [place, right, below] = [[0, 0], [1, 0], [0, 1]].map(|[i, j]| self.place(x + i, y + j));
        let step = |to: [f64; 3]| (0..3).map(|i| side[i] * (to[i] - place[i])).sum();
        let here = (0..3).map(|i| side[i] * place[i]).sum();
        (here, [step(right), step(below)])
    }
}
