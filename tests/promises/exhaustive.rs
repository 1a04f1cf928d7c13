//! P1 where all cases can be tried: every triangle on a lattice round a few pixels, its vertices in
//! every order, by the way of small triangles and by the way of spans, on every instruction set.
//! The usual run has 10 x 10 points, so a million triangles on each lattice;
//! `EXHAUSTIVE_SIDE=22 cargo test --release --test promises exhaustive -- --nocapture` has 113 million.

use crate::oracle::coverage::{framebuffer, snap, steps, winding};
use crate::oracle::shapes::unproject;
use hyperspan::placed::Placed;
use hyperspan::polygon::{Indexed, Vertex};
use hyperspan::shade::Solid;
use hyperspan::simd::Simd;
use hyperspan::space::{Grid, Viewport};
use hyperspan::target::Target;
use hyperspan::tiler::Tiler;

/// Pixels in a side of the picture: a bit for each of its pixels fits into a word.
const SIDE: u32 = 8;

/// Which pixels are drawn.
#[derive(Debug, Default)]
struct Bits {
    drawn: u64,
    twice: u64,
}

impl Target for Bits {
    type Pixel = ();

    fn size(&self) -> (u32, u32) {
        (SIDE, SIDE)
    }

    fn write(&mut self, x: u32, y: u32, run: &[()]) {
        assert!(x + run.len() as u32 <= SIDE && y < SIDE, "outside of the picture");
        let bits = ((1 << run.len()) - 1) << (SIDE * y + x);
        self.twice |= self.drawn & bits;
        self.drawn |= bits;
    }
}

/// All pixels for which `holds`.
fn pixels(holds: impl Fn(i32, i32) -> bool) -> u64 {
    let bit = |i: u32| u64::from(holds((i % SIDE) as i32, (i / SIDE) as i32)) << i;
    (0..SIDE * SIDE).map(bit).sum()
}

/// What the crossing oracle says of every triangle, from what it says of some.
struct Right<'a> {
    grid: Grid,
    points: &'a [[i64; 2]],
    /// Of the triangle of point 0 and any two others.
    of_first: Vec<u64>,
}

impl<'a> Right<'a> {
    fn new(grid: Grid, points: &'a [[i64; 2]]) -> Self {
        let covered = |i: usize, j: usize| {
            let triangle = [points[0], points[i], points[j]];
            pixels(|x, y| winding(grid, &triangle, x, y) != 0)
        };
        let of_first = (0..points.len()).flat_map(|i| (0..points.len()).map(move |j| (i, j)));
        Self { grid, points, of_first: of_first.map(|(i, j)| covered(i, j)).collect() }
    }

    /// A triangle winds round a point once or not at all, and what the edges to point 0 add to the
    /// sum of the three is 0: so parities tell.
    fn triangle(&self, [i, j, k]: [usize; 3]) -> u64 {
        let n = self.points.len();
        self.of_first[i * n + j] ^ self.of_first[j * n + k] ^ self.of_first[k * n + i]
    }

    /// Twice the area, with its sign.
    fn area(&self, triangle: [usize; 3]) -> i64 {
        let [p, q, r] = triangle.map(|i| self.points[i]);
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    }

    /// Pixels whose centres lie on an edge, its ends left out.
    fn on_edge(&self, i: usize, j: usize) -> u64 {
        let ([p, q], step) = ([self.points[i], self.points[j]], steps(self.grid));
        let centre = |c: i32| i64::from(c) * step + step / 2;
        pixels(|x, y| {
            let c = [centre(x), centre(y)];
            let (to, off) = ([q[0] - p[0], q[1] - p[1]], [c[0] - p[0], c[1] - p[1]]);
            let along = to[0] * off[0] + to[1] * off[1];
            to[0] * off[1] == to[1] * off[0] && 0 < along && along < to[0] * to[0] + to[1] * to[1]
        })
    }
}

/// Tries all triangles of points that are `step` pixels apart, from (`from`, `from`) on.
#[expect(clippy::print_stdout, reason = "what a test looked at is part of its result")]
fn check(from: f64, step: f64, grid: Grid) {
    let side = std::env::var("EXHAUSTIVE_SIDE").ok().and_then(|n| n.parse().ok()).unwrap_or(10);
    let viewport = Viewport::new(0, 0, SIDE, SIDE).expect("small").with_grid(grid);
    let at = |i: usize| [i % side, i / side].map(|c| from + c as f64 * step);
    let positions: Vec<[f64; 4]> =
        (0..side * side).map(|i| unproject(viewport, at(i), 0.5, 1.0)).collect();
    let points: Vec<_> = positions.iter().map(|p| snap(grid, framebuffer(viewport, *p))).collect();
    let right = Right::new(grid, &points);
    let vertices: Vec<Vertex<0, [f64; 4]>> =
        positions.iter().map(|p| Vertex::new(*p, [])).collect();
    let mut placed = Placed::new(viewport);
    placed.set(&positions, Simd::auto());
    let levels: Vec<Simd> = Simd::all().map(|(_, simd)| simd).collect();
    let (mut triangles, mut with_pixels, mut edges) = (0_u64, 0_u64, 0_u64);
    for i in 0..points.len() {
        let mut small = Tiler::new(viewport);
        let mut spans = Tiler::new(viewport);
        small.set_simd(levels[i % levels.len()]);
        spans.set_simd(levels[i % levels.len()]);
        // Nothing is outside of it; but with a plane of the user's nothing goes the short way.
        spans.set_clip_planes(&[[0.0, 0.0, 0.0, 1.0]]);
        for j in 0..points.len() {
            // What is drawn on either side of the edge, and of how many triangles.
            let (mut sides, mut counts) = ([0; 2], [0_u32; 2]);
            for k in 0..points.len() {
                let expected = right.triangle([i, j, k]);
                let triangle = [i, j, k].map(|i| i as u32);
                let polygon = Indexed::new(&vertices, &triangle).expect("their numbers");
                let polygon = if k % 2 == 0 { polygon.with_placed(&placed) } else { polygon };
                for tiler in [&mut small, &mut spans] {
                    let mut bits = Bits::default();
                    tiler.draw(&polygon, &mut Solid(()), &mut bits, None);
                    let of = || [i, j, k].map(at);
                    assert_eq!(bits.drawn, expected, "{:?} {bits:x?}", of());
                    assert_eq!(bits.twice, 0, "{:?} {bits:x?}", of());
                }
                triangles += 1;
                with_pixels += u64::from(expected != 0);
                let area = right.area([i, j, k]);
                if area != 0 {
                    sides[usize::from(area > 0)] |= expected;
                    counts[usize::from(area > 0)] += 1;
                }
            }
            // Two triangles that share the edge have no pixel in common, and a centre on it
            // belongs to all that are on one side.
            assert_eq!(sides[0] & sides[1], 0, "{:?} to {:?}", at(i), at(j));
            if counts.iter().all(|count| *count > 0) {
                let on_edge = right.on_edge(i, j);
                let once = (sides[0] ^ sides[1]) & on_edge;
                assert_eq!(once, on_edge, "{:?} to {:?}", at(i), at(j));
                edges += 1;
            }
        }
        assert_eq!(small.stats().pixels_covered, spans.stats().pixels_covered);
    }
    assert!(with_pixels > triangles / 50, "{with_pixels} of {triangles}");
    println!(
        "{triangles} triangles by both ways, {with_pixels} with pixels; {edges} edges with \
         triangles on both sides"
    );
}

/// Centres, sides, corners of pixels, and what is halfway between.
#[test]
fn exhaustive_quarters_of_pixels() {
    check(1.0, 0.25, Grid::Sixteen);
}

/// About one pixel, on the grid of Direct3D; the centre is a point of it.
#[test]
fn exhaustive_sixteenths_on_the_coarse_grid() {
    check(3.25, 1.0 / 16.0, Grid::Eight);
}

/// All steps of the grid round a centre.
#[test]
fn exhaustive_steps_of_the_grid_round_a_centre() {
    check(3.5 - 5.0 / 65536.0, 1.0 / 65536.0, Grid::Sixteen);
}
