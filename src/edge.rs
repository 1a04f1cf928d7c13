//! The Y loop: from snapped vertices to spans.
//!
//! An edge owns the rows whose centres lie in its half-open range of y; on each of them the
//! column of the first centre at or right of it is stepped exactly, by quotient, remainder and
//! error term, so that the state at a row does not depend on where the loop began. A row's
//! spans are where the edges' directions, summed from the left, are not 0. For a convex polygon
//! that is one span, between the two chains; snapping can make it concave by a hair, and then,
//! as for any other polygon, a row may hold several.

use alloc::vec::Vec;
use core::ops::Range;

use crate::divide::ScreenVertex;
use crate::fixed::Subpixel;

/// Covered pixels of one row: columns `start..end`, from the viewport's corner as all rows and
/// columns here; not empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The row.
    pub row: i32,
    /// First covered column.
    pub start: i32,
    /// Column after the last covered one; before the scissor, as `start` is.
    pub end: i32,
    /// The vertex where the edge begins that bounds it on the left, and the one where it ends,
    /// from the top: numbers in the list that the outline was made from.
    pub left: [u32; 2],
    /// The same on the right.
    pub right: [u32; 2],
}

/// An edge that owns at least one row, seen from its upper end.
#[derive(Clone, Copy, Debug)]
struct Edge {
    rows: [i32; 2],
    /// Does the polygon's boundary go down along it?
    down: bool,
    /// Upper and lower vertex.
    vertices: [u32; 2],
    /// x and y of the upper end, 16 fraction bits.
    upper: [i64; 2],
    /// From the upper end to the lower, 16 fraction bits.
    delta: [i64; 2],
}

impl Edge {
    /// The edge from one vertex to the next, if it owns a row; `numbers` are theirs.
    #[inline(always)]
    fn between(numbers: [usize; 2], from: [Subpixel; 2], to: [Subpixel; 2]) -> Option<Self> {
        let down = from[1] <= to[1];
        let ([upper, lower], [i, j]) =
            if down { ([from, to], numbers) } else { ([to, from], [numbers[1], numbers[0]]) };
        let rows = [upper[1].first_centre(), lower[1].first_centre()];
        if rows[0] >= rows[1] {
            return None;
        }
        // 32 bits of vertices are more than memory holds.
        let number = |i: usize| u32::try_from(i).unwrap_or(u32::MAX);
        let (x0, y0) = (upper[0].wide(), upper[1].wide());
        let delta = [lower[0].wide() - x0, lower[1].wide() - y0];
        Some(Self { rows, down, vertices: [number(i), number(j)], upper: [x0, y0], delta })
    }
}

/// Where an edge crosses the current row.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    edge: Edge,
    /// First column whose centre is at or right of the edge.
    column: i64,
    /// What the division left, in 1/`denominator` columns: 0 <= `error` < `denominator`.
    error: i64,
    denominator: i64,
    step_column: i64,
    step_error: i64,
}

impl Crossing {
    /// The crossing with `row`, which the edge owns.
    ///
    /// The edge is at x = x0 + (yc - y0) dx/dy in the row's centre yc; the column is
    /// ceil(x - 1/2), in 16 fraction bits ceil((x - 2^15) / 2^16). The numerator over
    /// 2^16 dy stays within `i64` for every edge on the grid, if not all of its terms.
    #[inline(always)]
    fn at(edge: Edge, row: i32) -> Self {
        let ([x0, y0], [dx, dy]) = (edge.upper, edge.delta);
        let denominator = dy << Subpixel::FRACTION_BITS;
        let x0 = x0 - Subpixel::centre_of(0);
        let numerator = x0
            .wrapping_mul(dy)
            .wrapping_add((Subpixel::centre_of(row) - y0).wrapping_mul(dx))
            .wrapping_add(denominator - 1);
        let (column, error) = divide_down(numerator, denominator);
        // Not for an edge of one row.
        let (step_column, step_error) =
            if row + 1 < edge.rows[1] { divide_down(dx, dy) } else { (0, 0) };
        let step_error = step_error << Subpixel::FRACTION_BITS;
        Self { edge, column, error, denominator, step_column, step_error }
    }

    #[inline(always)]
    fn step(&mut self) {
        self.column += self.step_column;
        self.error += self.step_error;
        if self.error >= self.denominator {
            self.error -= self.denominator;
            self.column += 1;
        }
    }
}

/// Quotient, rounded down, and remainder of `n` over a positive `d`.
#[inline(always)]
fn divide_down(n: i64, d: i64) -> (i64, i64) {
    let (quotient, remainder) = (n / d, n % d);
    if remainder < 0 { (quotient - 1, remainder + d) } else { (quotient, remainder) }
}

/// The edges of a polygon, in the order of its boundary.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    edges: Vec<Edge>,
    active: Vec<Crossing>,
    /// Half-open.
    rows: [i32; 2],
    /// Where the boundary turns from one way to the other.
    turns: usize,
    /// The first edge down after one up, and the number of those down.
    first_down: usize,
    downs: usize,
}

impl Outline {
    /// Takes the edges of the closed polygon `vertices`.
    #[inline(always)]
    pub fn set(&mut self, vertices: &[ScreenVertex]) -> &mut Self {
        self.edges.clear();
        (self.rows, self.turns, self.first_down, self.downs) = ([i32::MAX, i32::MIN], 0, 0, 0);
        let Some(last) = vertices.last() else { return self };
        self.edges.reserve(vertices.len());
        let (mut before, mut from) = (vertices.len() - 1, last.snapped);
        let mut down_before = false;
        for (i, to) in vertices.iter().enumerate() {
            if let Some(edge) = Edge::between([before, i], from, to.snapped) {
                self.rows = [self.rows[0].min(edge.rows[0]), self.rows[1].max(edge.rows[1])];
                let turned = edge.down != down_before;
                self.turns += usize::from(turned && !self.edges.is_empty());
                if edge.down {
                    self.first_down = if turned { self.edges.len() } else { self.first_down };
                    self.downs += 1;
                }
                down_before = edge.down;
                self.edges.push(edge);
            }
            (before, from) = (i, to.snapped);
        }
        // From the last edge to the first.
        if let Some(first) = self.edges.first()
            && first.down != down_before
        {
            self.turns += 1;
            self.first_down = if first.down { 0 } else { self.first_down };
        }
        self
    }

    /// The rows that have crossings: half-open, empty if there are none.
    #[inline(always)]
    pub fn rows(&self) -> Range<i32> {
        if self.edges.is_empty() { 0..0 } else { self.rows[0]..self.rows[1] }
    }

    /// Is any pixel centre covered, in the reach of the grid?
    pub fn covers_anything(&mut self) -> bool {
        let mut covers = false;
        self.for_each_span(i32::MIN..i32::MAX, |_| covers = true);
        covers
    }

    /// Hands over the spans of `rows`, from the top, and in a row from the left. Rows before
    /// them cost nothing. Every span goes through the same function, whatever the outline.
    #[inline(always)]
    pub fn for_each_span(&mut self, rows: Range<i32>, mut emit: impl FnMut(Span)) {
        let all = self.rows();
        let rows = rows.start.max(all.start)..rows.end.min(all.end);
        if rows.is_empty() {
            return;
        }
        // One way down and one up: every row has two crossings.
        if self.turns == 2 {
            self.convex_spans(rows, &mut emit);
        } else {
            self.winding_spans(rows, &mut emit);
        }
    }

    /// Two crossings a row: the next edge of a chain begins where the last one ends.
    #[inline(always)]
    fn convex_spans(&self, rows: Range<i32>, emit: &mut impl FnMut(Span)) {
        let mut row = rows.start;
        let n = self.edges.len();
        // From the top: down edges in the order of the boundary, up edges against it.
        let last_up = if self.first_down > 0 { self.first_down - 1 } else { n - 1 };
        let edges = self.edges.as_slice();
        let mut downs = Chain { edges, next: self.first_down, left: self.downs, forward: true };
        let mut ups = Chain { edges, next: last_up, left: n - self.downs, forward: false };
        let (Some(mut one), Some(mut two)) = (downs.crossing_at(row), ups.crossing_at(row)) else {
            return;
        };
        loop {
            let (left, right) = if one.column <= two.column { (&one, &two) } else { (&two, &one) };
            emit_span(row, left, right, emit);
            row += 1;
            if row >= rows.end {
                return;
            }
            if !(downs.advance(&mut one, row) && ups.advance(&mut two, row)) {
                return;
            }
        }
    }

    /// Any number of crossings a row, sorted.
    fn winding_spans(&mut self, rows: Range<i32>, emit: &mut impl FnMut(Span)) {
        self.edges.sort_by_key(|edge| edge.rows[0]);
        self.active.clear();
        let mut waiting = self.edges.iter().peekable();
        for row in rows {
            self.active.retain_mut(|crossing| {
                crossing.step();
                row < crossing.edge.rows[1]
            });
            while let Some(edge) = waiting.next_if(|edge| edge.rows[0] <= row) {
                if row < edge.rows[1] {
                    self.active.push(Crossing::at(*edge, row));
                }
            }
            // A stable order of all that tells crossings apart: which edges bound a span must
            // not depend on where the list of vertices begins.
            self.active.sort_by_key(|c| (c.column, c.edge.down, c.edge.upper, c.edge.delta));
            let mut winding = 0_i32;
            let mut left: Option<&Crossing> = None;
            for crossing in &self.active {
                winding += if crossing.edge.down { 1 } else { -1 };
                match left {
                    None => left = Some(crossing),
                    Some(start) if winding == 0 => {
                        emit_span(row, start, crossing, emit);
                        left = None;
                    }
                    Some(_) => {}
                }
            }
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.edges.capacity() * size_of::<Edge>() + self.active.capacity() * size_of::<Crossing>()
    }
}

#[inline(always)]
fn emit_span(row: i32, left: &Crossing, right: &Crossing, emit: &mut impl FnMut(Span)) {
    if left.column < right.column {
        #[expect(clippy::cast_possible_truncation, reason = "within the reach of the grid")]
        let (start, end) = (left.column as i32, right.column as i32);
        emit(Span { row, start, end, left: left.edge.vertices, right: right.edge.vertices });
    }
}

/// One of the two chains of a convex outline, walked from the top.
struct Chain<'a> {
    edges: &'a [Edge],
    /// The next edge, and how many are left.
    next: usize,
    left: usize,
    forward: bool,
}

impl Chain<'_> {
    /// The crossing with `row` of the first edge from here on that reaches below it.
    #[inline(always)]
    fn crossing_at(&mut self, row: i32) -> Option<Crossing> {
        let n = self.edges.len();
        while self.left > 0 {
            let edge = self.edges[self.next];
            self.next = match (self.forward, self.next) {
                (true, i) if i + 1 == n => 0,
                (true, i) => i + 1,
                (false, 0) => n - 1,
                (false, i) => i - 1,
            };
            self.left -= 1;
            if row < edge.rows[1] {
                return Some(Crossing::at(edge, row));
            }
        }
        None
    }

    /// Takes the crossing one row down to `row`; no if the chain ends above it.
    #[inline(always)]
    fn advance(&mut self, crossing: &mut Crossing, row: i32) -> bool {
        if row < crossing.edge.rows[1] {
            crossing.step();
            return true;
        }
        match self.crossing_at(row) {
            Some(next) => {
                *crossing = next;
                true
            }
            None => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Grid;

    fn spans(points: &[(f64, f64)], rows: Range<i32>) -> Vec<(i32, i32, i32)> {
        let vertices: Vec<ScreenVertex> = (0..)
            .zip(points)
            .map(|(vertex, (x, y))| ScreenVertex {
                framebuffer: [*x, *y],
                snapped: [*x, *y].map(|c| Subpixel::snap(c, 0, Grid::Sixteen)),
                vertex,
            })
            .collect();
        let mut outline = Outline::default();
        outline.set(&vertices);
        let mut found = Vec::new();
        outline.for_each_span(rows, |span| found.push((span.row, span.start, span.end)));
        found
    }

    #[test]
    fn edges_own_the_centres_on_the_left_and_on_the_top() {
        let square = [(0.5, 0.5), (0.5, 2.5), (2.5, 2.5), (2.5, 0.5)];
        assert_eq!(spans(&square, 0..9), [(0, 0, 2), (1, 0, 2)]);
        let diamond = [(2.0, 0.0), (0.0, 2.0), (2.0, 4.0), (4.0, 2.0)];
        assert_eq!(spans(&diamond, 1..9), [(1, 0, 3), (2, 0, 3), (3, 1, 2)]);
    }

    #[test]
    fn edges_start_at_any_row() {
        let triangle = [(100.3, -7.2), (-3.0, 50.7), (20.1, 93.9)];
        let whole = spans(&triangle, -100..100);
        for row in -7..94 {
            let part = spans(&triangle, row..100);
            assert_eq!(part, &whole[whole.len() - part.len()..], "from row {row}");
        }
    }

    #[test]
    fn edges_of_a_zigzag_give_several_spans() {
        let w =
            [(0.0, 0.0), (2.0, 4.0), (4.0, 0.0), (6.0, 4.0), (8.0, 0.0), (6.0, 8.0), (2.0, 8.0)];
        let found = spans(&w, 0..2);
        assert!(found.iter().filter(|span| span.0 == 1).count() > 1);
    }

    #[test]
    fn edges_reach_the_corners_of_the_grid() {
        let r = 32767.0;
        let giant = [(-r, -r), (-r, r), (r, r), (r, -r)];
        assert_eq!(spans(&giant, 5..6), [(5, -32767, 32767)]);
        let diagonal = [(-r, -r), (-r, r), (r, r)];
        assert_eq!(spans(&diagonal, 5..6), [(5, -32767, 5)]);
    }
}
