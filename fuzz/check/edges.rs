//! The Y loop alone, on any outline of up to twelve vertices anywhere on the subpixel grid, its
//! corners included. Nothing panics, and on any range of rows:
//!
//! - spans come from the top and from the left, do not overlap, and are not empty;
//! - they are what the crossings say, each found by one division in 128-bit integers, and sorted;
//! - at both of its ends a span has the centres that the winding number gives it;
//! - the edges that a span names cross its row, and bound it;
//! - the list of vertices rotated or turned round gives the same pixels, and so does a range that
//!   begins in the middle;
//! - something is said to be covered if and only if there is a span.

use std::ops::Range;

use hyperspan::divide::{ScreenVertex, snapped_area};
use hyperspan::edge::{Outline, Span};
use hyperspan::fixed::Subpixel;
use hyperspan::space::Grid;

use super::bytes::Bytes;
use crate::oracle::coverage::{doubled_area, winding};

/// The grid's reach, 16 fraction bits.
const REACH: i32 = Subpixel::REACH << 16;

pub(crate) fn edges(data: &[u8]) {
    let bytes = &mut Bytes(data);
    let n = usize::from(bytes.below(13));
    let mut points = Vec::new();
    if bytes.below(2) == 0 {
        for _ in 0..n {
            let point = point(bytes, &points);
            points.push(point);
        }
    } else {
        points = round(bytes, n);
    }
    let vertices = placed(&points);
    let mut outline = Outline::default();
    outline.set(&vertices);
    let all = outline.rows();
    // From a row near a vertex, or above them all.
    let row = match points.get(usize::from(bytes.below(16))) {
        Some(point) => (point[1] >> 16) as i32 + bytes.small() / 8,
        None => bytes.pick(&[all.start, all.end.saturating_sub(1), -32767, 0, i32::MIN]),
    };
    let rows = row..row.saturating_add(1 + i32::from(bytes.below(40)));
    let spans = spans(&mut outline, rows.clone());

    check_order(&spans, &rows);
    for row in rows.clone().filter(|row| (-32800..32800).contains(row)) {
        check_row(&points, row, spans.iter().filter(|span| span.row == row).copied());
    }
    assert_eq!(snapped_area(&vertices), doubled_area(&points));

    let later = rows.start.saturating_add(i32::from(bytes.below(40)))..rows.end;
    let right: Vec<Span> = spans.iter().filter(|span| later.contains(&span.row)).copied().collect();
    assert_eq!(self::spans(&mut outline, later.clone()), right, "from row {}", later.start);
    let mut fresh = Outline::default();
    fresh.set(&vertices);
    assert_eq!(self::spans(&mut fresh, later), right, "from a row of a fresh outline");

    let mut turned = points.clone();
    turned.rotate_left(usize::from(bytes.below(12)) % points.len().max(1));
    let pixels = pixels(&spans);
    assert_eq!(self::pixels(&of(&turned, rows.clone())), pixels, "another first vertex");
    turned.reverse();
    assert_eq!(self::pixels(&of(&turned, rows)), pixels, "the other way round");

    if all.len() < 200 {
        let any = !self::spans(&mut outline, i32::MIN..i32::MAX).is_empty();
        assert_eq!(outline.covers_anything(), any);
    }
}

/// On the grid, 16 fraction bits: in small steps, near a centre, or far away; often where others
/// are, or between them.
fn point(bytes: &mut Bytes<'_>, others: &[[i64; 2]]) -> [i64; 2] {
    let earlier = |bytes: &mut Bytes<'_>| match others.len() {
        0 => [0, 0],
        n => others[usize::from(bytes.byte()) % n],
    };
    let on_grid = |c: i64| c.clamp((-REACH).into(), REACH.into());
    let point = match bytes.below(8) {
        0 | 1 => [(); 2].map(|()| i64::from(bytes.small()) << 13),
        2 => [(); 2]
            .map(|()| (i64::from(bytes.small() / 4) << 16) + 32768 + i64::from(bytes.small() / 16)),
        3 => [(); 2].map(|()| i64::from(i32::from_le_bytes(bytes.array()))),
        4 => {
            let corner =
                [(); 2].map(|()| bytes.pick(&[-REACH, REACH, 0, REACH - 32768, 1 - REACH]));
            corner.map(|c| i64::from(c) + i64::from(bytes.small() / 32))
        }
        5 => earlier(bytes),
        6 => {
            let mut point = earlier(bytes);
            point[usize::from(bytes.below(2))] += i64::from(bytes.small());
            point
        }
        _ => {
            let (p, q) = (earlier(bytes), earlier(bytes));
            let t = i64::from(bytes.small());
            [0, 1].map(|k| p[k] + (q[k] - p[k]) * t / 64)
        }
    };
    point.map(on_grid)
}

/// A convex outline, but for rounding.
fn round(bytes: &mut Bytes<'_>, n: usize) -> Vec<[i64; 2]> {
    let middle = [(); 2].map(|()| f64::from(i16::from_le_bytes(bytes.array())) * 65536.0);
    let radius = [(); 2].map(|()| f64::from(u32::from_le_bytes(bytes.array()) >> bytes.below(31)));
    let lean = f64::from(bytes.small()) / 32.0;
    let on_grid = |c: f64| (c as i64).clamp((-REACH).into(), REACH.into());
    let at = |i: usize| {
        let t = ((2 * i + 1) as f64 / n as f64 - 1.0) * 0.999;
        let t = t / (1.0 - t * t);
        let [c, s] = [(1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t)];
        let [x, y] = [radius[0] * c, radius[1] * s];
        [middle[0] + x + lean * y, middle[1] + y].map(on_grid)
    };
    (0..n).map(at).collect()
}

fn placed(points: &[[i64; 2]]) -> Vec<ScreenVertex> {
    let vertex = |(i, point): (u32, &[i64; 2])| {
        let framebuffer = point.map(|c| c as f64 / 65536.0);
        let snapped = framebuffer.map(|c| Subpixel::snap(c, 0, Grid::Sixteen));
        assert_eq!(snapped.map(|c| i64::from(c.bits())), *point);
        ScreenVertex { framebuffer, snapped, vertex: i }
    };
    (0..).zip(points).map(vertex).collect()
}

fn spans(outline: &mut Outline, rows: Range<i32>) -> Vec<Span> {
    let mut spans = Vec::new();
    outline.for_each_span(rows, |span| spans.push(span));
    spans
}

fn of(points: &[[i64; 2]], rows: Range<i32>) -> Vec<Span> {
    let mut outline = Outline::default();
    spans(outline.set(&placed(points)), rows)
}

/// (row, first column, column after the last); what touches is one.
fn pixels(spans: &[Span]) -> Vec<(i32, i32, i32)> {
    let mut runs: Vec<(i32, i32, i32)> = Vec::new();
    for span in spans {
        match runs.last_mut() {
            Some((row, _, end)) if *row == span.row && *end == span.start => *end = span.end,
            _ => runs.push((span.row, span.start, span.end)),
        }
    }
    runs
}

fn check_order(spans: &[Span], rows: &Range<i32>) {
    for span in spans {
        assert!(rows.contains(&span.row) && span.start < span.end, "{span:?}");
    }
    for pair in spans.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        assert!(a.row < b.row || (a.row == b.row && a.end <= b.start), "{a:?} before {b:?}");
    }
}

/// The first column whose centre is at or right of the edge in `row`, if the edge owns the row;
/// and 1 or -1, as it goes down or up.
fn crossing(from: [i64; 2], to: [i64; 2], row: i32) -> Option<(i128, i32)> {
    let ([top, bottom], way) = if from[1] <= to[1] { ([from, to], 1) } else { ([to, from], -1) };
    let centre = (i128::from(row) << 16) + 32768;
    let [[x0, y0], [x1, y1]] = [top, bottom].map(|p| p.map(i128::from));
    if y0 > centre || centre >= y1 {
        return None;
    }
    // ceil((x - 2^15) / 2^16) of x = x0 + (centre - y0) (x1 - x0) / (y1 - y0)
    let numerator = (x0 - 32768) * (y1 - y0) + (centre - y0) * (x1 - x0);
    let denominator = (y1 - y0) << 16;
    Some((-(-numerator).div_euclid(denominator), way))
}

fn check_row(points: &[[i64; 2]], row: i32, spans: impl Iterator<Item = Span> + Clone) {
    let n = points.len();
    let edge = |i: usize| crossing(points[i], points[(i + 1) % n], row);
    let mut crossings: Vec<(i128, i32)> = (0..n).filter_map(edge).collect();
    crossings.sort_unstable();
    let mut right: Vec<(i32, i32, i32)> = Vec::new();
    let mut sum = 0;
    for pair in crossings.windows(2) {
        sum += pair[0].1;
        let [start, end] = [pair[0].0 as i32, pair[1].0 as i32];
        if sum != 0 && start < end {
            match right.last_mut() {
                Some((_, _, before)) if *before == start => *before = end,
                _ => right.push((row, start, end)),
            }
        }
    }
    let found: Vec<Span> = spans.collect();
    assert_eq!(pixels(&found), right, "row {row} of {points:?}");

    for span in found {
        let inside = |x: i32| winding(Grid::Sixteen, points, x, row) != 0;
        assert!(inside(span.start) && inside(span.end - 1), "{span:?} has too much");
        for (ends, column) in [(span.left, span.start), (span.right, span.end)] {
            // From the top, whichever way the outline goes.
            let [top, bottom] = ends.map(|i| points[i as usize]);
            let next = ends[0].abs_diff(ends[1]) as usize;
            assert!(next == 1 || next == n - 1, "{ends:?} is no edge");
            let at = crossing(top, bottom, row).expect("crosses its row");
            assert_eq!(at, (column.into(), 1), "{ends:?} bounds {span:?}");
        }
    }
    for (_, start, end) in right {
        let outside = |x: i32| winding(Grid::Sixteen, points, x, row) == 0;
        assert!(outside(start - 1) && outside(end), "row {row} goes on beyond {start}..{end}");
    }
}
