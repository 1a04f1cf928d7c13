//! Fill rules. dEQP (functional.rasterization.fill_rules) tiles a part of the picture with
//! triangles, turned a little further each time, and adds a constant for each: a pixel in which
//! two of them meet must have got it once. Here a pixel of the outline must be drawn once, and none
//! beside it; and piglit's orthoPosRandTris does the same with random triangles.

use hyperspan::space::Viewport;

use crate::case::{Case, Rule, check};
use crate::oracle::Poly;
use crate::oracle::shapes::unproject;

/// In pixels, and w there.
type Place = ([f64; 2], f64);

/// A grid of quads in the framebuffer, each cut into two triangles.
struct Grid {
    size: [u32; 2],
    /// Cells in a row and a column.
    cells: [usize; 2],
    /// From 0..1.
    place: Box<dyn Fn([f64; 2]) -> Place>,
    /// The lists of the triangles run the other way round.
    reversed: bool,
}

impl Grid {
    fn vertex(&self, [i, j]: [usize; 2]) -> [f64; 4] {
        let viewport = Viewport::new(0, 0, self.size[0], self.size[1]).expect("small");
        let [columns, rows] = self.cells;
        let (at, w) = (self.place)([i as f64 / columns as f64, j as f64 / rows as f64]);
        // What the outline and the cells have is the same in f32, too.
        unproject(viewport, at, 0.5, w).map(|c| f64::from(c as f32))
    }

    fn triangles(&self) -> Vec<Poly> {
        let mut all = Vec::new();
        let [columns, rows] = self.cells;
        for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
            let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            let [a, b, c, d] = corners.map(|corner| self.vertex(corner));
            let parts =
                if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
            for part in parts {
                let poly = Poly::bare(&part).rotated((i + 2 * j) % 3);
                all.push(if self.reversed { poly.reversed() } else { poly });
            }
        }
        all
    }

    /// All vertices of the rim.
    fn outline(&self) -> Poly {
        let [columns, rows] = self.cells;
        let top = (0..columns).map(|i| [i, 0]);
        let right = (0..rows).map(|j| [columns, j]);
        let bottom = (1..=columns).rev().map(|i| [i, rows]);
        let left = (1..=rows).rev().map(|j| [0, j]);
        let rim: Vec<_> =
            top.chain(right).chain(bottom).chain(left).map(|corner| self.vertex(corner)).collect();
        Poly::bare(&rim)
    }

    fn case(&self, name: String, everywhere: bool) -> Case {
        let rule = if everywhere { Rule::Everywhere } else { Rule::Once(self.outline()) };
        Case::new(name, self.size, self.triangles(), rule)
    }
}

/// A square with sides of `side` pixels, turned by `degrees` round `middle`.
fn turned(middle: [f64; 2], side: f64, degrees: u32) -> impl Fn([f64; 2]) -> [f64; 2] {
    let (s, c) = f64::from(degrees).to_radians().sin_cos();
    move |[u, v]| {
        let [x, y] = [(u - 0.5) * side, (v - 0.5) * side];
        [middle[0] + c * x - s * y, middle[1] + s * x + c * y]
    }
}

#[test]
fn conformance_fill_of_turned_quads() {
    let mut cases = Vec::new();
    for degrees in (0..360).step_by(10) {
        for reversed in [false, true] {
            let turn = turned([32.0, 32.0], 40.0, degrees);
            let place = Box::new(move |p| (turn(p), 1.0));
            let grid = Grid { size: [64, 64], cells: [4, 4], place, reversed };
            cases.push(grid.case(format!("quads turned by {degrees}, {reversed}"), false));
        }
    }
    check(&cases);
}

/// The grid sticks out of the picture on all sides.
#[test]
fn conformance_fill_of_quads_that_are_clipped_all_round() {
    let mut cases = Vec::new();
    for degrees in (0..90).step_by(9) {
        for side in [120.0, 1e4, 1e7] {
            let turn = turned([31.0, 33.0], side, degrees);
            let place = Box::new(move |p| (turn(p), 1.0));
            let grid = Grid { size: [64, 64], cells: [3, 3], place, reversed: degrees % 2 == 1 };
            cases.push(grid.case(format!("{side} pixels, turned by {degrees}"), true));
        }
    }
    check(&cases);
}

/// It sticks out on one side.
#[test]
fn conformance_fill_of_quads_that_are_clipped_partly() {
    let mut cases = Vec::new();
    for degrees in (0..90).step_by(15) {
        for middle in [[0.0, 32.0], [64.0, 20.0], [32.0, 0.0], [20.0, 64.0], [64.0, 64.0]] {
            let turn = turned(middle, 50.0, degrees);
            let place = Box::new(move |p| (turn(p), 1.0));
            let grid = Grid { size: [64, 64], cells: [4, 4], place, reversed: false };
            cases.push(grid.case(format!("quads round {middle:?}, turned by {degrees}"), false));
        }
    }
    check(&cases);
}

/// w is different at every vertex: the same framebuffer positions by other clip positions.
#[test]
fn conformance_fill_of_projected_quads() {
    let mut cases = Vec::new();
    for degrees in (0..180).step_by(12) {
        let turn = turned([32.0, 32.0], 44.0, degrees);
        let place = Box::new(move |p: [f64; 2]| (turn(p), 0.2 + 3.8 * (7.0 * p[0] + p[1]) / 8.0));
        let grid = Grid { size: [64, 64], cells: [5, 4], place, reversed: degrees % 24 == 0 };
        cases.push(grid.case(format!("projected quads turned by {degrees}"), false));
    }
    check(&cases);
}

/// All vertices on centres of pixels, and the edges through others.
#[test]
fn conformance_fill_of_quads_on_centres() {
    let mut cases = Vec::new();
    for (steps, name) in [([4.0, 0.0], "straight"), ([4.0, 2.0], "aslant"), ([3.0, 3.0], "on end")]
    {
        for shift in [0.0, 0.5] {
            let place = move |[u, v]: [f64; 2]| {
                let [i, j] = [4.0 * u - 2.0, 4.0 * v - 2.0];
                let [x, y] = [i * steps[0] - j * steps[1], i * steps[1] + j * steps[0]];
                ([32.0 + shift + x, 32.0 + shift + y], 1.0)
            };
            let place = Box::new(place);
            let grid = Grid { size: [64, 64], cells: [4, 4], place, reversed: false };
            cases.push(grid.case(format!("{name}, {shift}"), false));
        }
    }
    check(&cases);
}

/// Random triangles over all of the picture (piglit's orthoPosRandTris).
#[test]
fn conformance_fill_of_random_triangles() {
    let mut cases = Vec::new();
    for seed in 0..8_u32 {
        let place = move |[u, v]: [f64; 2]| {
            let shift = |k: f64, at: f64| {
                let free = at > 0.01 && at < 0.99;
                let noise = (12.9898 * u + 78.233 * v + k + f64::from(seed)).sin() * 43758.5453;
                if free { 0.2 * (noise - noise.floor() - 0.5) / 10.0 } else { 0.0 }
            };
            ([(u + shift(1.0, u)) * 64.0, (v + shift(2.0, v)) * 64.0], 1.0)
        };
        let place = Box::new(place);
        let grid = Grid { size: [64, 64], cells: [10, 10], place, reversed: seed % 2 == 0 };
        cases.push(grid.case(format!("random triangles {seed}"), true));
    }
    check(&cases);
}
