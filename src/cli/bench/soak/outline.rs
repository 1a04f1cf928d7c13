//! Which columns of a row a polygon covers that no plane cuts: P1 once more, a row at a time.
//! It shares no code with the library, and none with the oracle of tests/oracle, which counts
//! crossings pixel by pixel and holds this one to account (tests/promises/soak.rs).

use std::ops::Range;

use hyperspan::space::{DepthRange, Grid, Viewport};

/// Columns `[0]..[1]`.
pub(crate) type Span = [i32; 2];

/// The guard band reaches this far from the viewport's corner, in pixels, with one to spare.
const GUARD: f64 = 32766.0;

/// Snapped vertices, in steps of the grid from the framebuffer's origin.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    points: Vec<[i64; 2]>,
    steps: i64,
}

impl Outline {
    /// Nothing if a plane may cut the polygon.
    pub(crate) fn new(viewport: Viewport, positions: &[[f64; 4]]) -> Option<Self> {
        let steps: i32 = match viewport.grid() {
            Grid::Sixteen => 65536,
            Grid::Eight => 256,
        };
        let corner = [viewport.rect().x0, viewport.rect().y0].map(f64::from);
        let half = [viewport.width(), viewport.height()].map(|side| f64::from(side) / 2.0);
        let mut points = Vec::with_capacity(positions.len());
        for &[x, y, z, w] in positions {
            let near = if viewport.depth_range() == DepthRange::ZeroToOne { 0.0 } else { -w };
            let place = [
                (x / w) * half[0] + (corner[0] + half[0]),
                (corner[1] + half[1]) - (y / w) * half[1],
            ];
            let in_guard = |i: usize| (place[i] - corner[i]).abs() < GUARD;
            if !(w > 0.0 && near <= z && z <= w && in_guard(0) && in_guard(1)) {
                return None;
            }
            points.push(place.map(|c| (c * f64::from(steps)).round_ties_even() as i64));
        }
        Some(Self { points, steps: i64::from(steps) })
    }

    /// All rows that may be covered.
    pub(crate) fn rows(&self) -> Range<i32> {
        let ends = || self.points.iter().map(|p| p[1].div_euclid(self.steps) as i32);
        match (ends().min(), ends().max()) {
            (Some(first), Some(last)) => first..last + 1,
            _ => 0..0,
        }
    }

    /// The columns that are covered in row `y`, from the left, into `spans`.
    pub(crate) fn row(&self, y: i32, spans: &mut Vec<Span>) {
        spans.clear();
        let yc = i64::from(y) * self.steps + self.steps / 2;
        // Of each crossing the first column at or right of it, and the edge's direction.
        let mut crossings: [(i64, i64); 8] = [(0, 0); 8];
        let mut more = Vec::new();
        let mut count = 0;
        for (i, from) in self.points.iter().enumerate() {
            let to = &self.points[if i + 1 < self.points.len() { i + 1 } else { 0 }];
            let (top, bottom, way) = if from[1] <= to[1] { (from, to, 1) } else { (to, from, -1) };
            if top[1] <= yc && yc < bottom[1] {
                let crossing = (self.column(yc, *top, *bottom), way);
                match crossings.get_mut(count) {
                    Some(place) => *place = crossing,
                    None => more.push(crossing),
                }
                count += 1;
            }
        }
        let crossings = if more.is_empty() {
            &mut crossings[..count]
        } else {
            more.extend_from_slice(&crossings);
            &mut more[..]
        };
        crossings.sort_unstable();
        let (mut winding, mut start) = (0, 0);
        for &(column, way) in crossings.iter() {
            if winding == 0 {
                start = column;
            }
            winding += way;
            if winding == 0 && start < column {
                spans.push([start as i32, column as i32]);
            }
        }
    }

    /// The first column whose centre is at or right of the edge in the row with centre `yc`.
    fn column(&self, yc: i64, top: [i64; 2], bottom: [i64; 2]) -> i64 {
        let [dx, dy] = [bottom[0] - top[0], bottom[1] - top[1]];
        // (yc - top.y) dx <= (xc - top.x) dy, where xc = steps column + steps / 2.
        let least = i128::from(yc - top[1]) * i128::from(dx)
            + i128::from(top[0] - self.steps / 2) * i128::from(dy);
        let of_column = i128::from(self.steps) * i128::from(dy);
        match (i64::try_from(least), i64::try_from(of_column)) {
            (Ok(least), Ok(of_column)) if least > i64::MIN => -((-least).div_euclid(of_column)),
            _ => -((-least).div_euclid(of_column)) as i64,
        }
    }
}
