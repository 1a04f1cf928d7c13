//! Values: dEQP's functional.rasterization.interpolation with w from 0.2 to 4, triangles below a
//! subpixel, and how far a reversed depth tells two walls apart.

use hyperspan::depth::DepthTest;
use hyperspan::shade::Solid;
use hyperspan::space::Viewport;
use hyperspan::target::Plane;
use hyperspan::tiler::Tiler;

use crate::case::{Case, Rule, check};
use crate::oracle::Poly;
use crate::oracle::shapes::unproject;

const SIZE: [u32; 2] = [64, 64];

fn viewport() -> Viewport {
    Viewport::new(0, 0, SIZE[0], SIZE[1]).expect("small")
}

/// Colours at the corners, and one that rises above 1.
const COLOURS: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, -2.0], [0.0, 1.0, 0.0, 3.5], [0.0, 0.0, 1.0, 0.125], [1.0, 1.0, 0.5, 9.0]];

fn coloured(points: &[([f64; 2], f64)]) -> Poly {
    let place = |&(at, w): &([f64; 2], f64)| unproject(viewport(), at, 0.25, w);
    let colours = COLOURS[..points.len()].iter().map(|list| list.to_vec());
    Poly { positions: points.iter().map(place).collect(), attributes: colours.collect() }
}

/// Every attribute, depth and w at every pixel is the correctly rounded value of P2.
#[test]
fn conformance_interpolation_with_w_from_a_fifth_to_4() {
    let mut cases = Vec::new();
    let ws = [0.2, 0.5, 1.0, 2.0, 4.0];
    let corners = [[3.2, 60.4], [61.7, 50.1], [20.9, 2.5]];
    for (i, a) in ws.into_iter().enumerate() {
        for (j, b) in ws.into_iter().enumerate() {
            let c = ws[(i + 2 * j) % ws.len()];
            let points = [(corners[0], a), (corners[1], b), (corners[2], c)];
            let name = format!("triangle, w = {a}, {b}, {c}");
            cases.push(Case::new(name, SIZE, vec![coloured(&points)], Rule::Each));
        }
    }
    // A strip of two, and a fan of three about a corner in common.
    for w in ws {
        let [a, b, c, d] = [[4.0, 5.0], [59.0, 9.0], [7.0, 58.0], [62.0, 61.0]];
        let strip = [[(a, 1.0), (b, w), (c, 0.7)], [(b, w), (d, 2.1), (c, 0.7)]];
        let polys = strip.map(|points| coloured(&points)).to_vec();
        cases.push(Case::new(format!("strip, w = {w}"), SIZE, polys, Rule::Each));
        let fan = [[(a, w), (c, 1.0), (d, 4.0)], [(a, w), (d, 4.0), (b, 0.3)]];
        let polys = fan.map(|points| coloured(&points)).to_vec();
        cases.push(Case::new(format!("fan, w = {w}"), SIZE, polys, Rule::Each));
    }
    check(&cases);
}

/// Triangles that are smaller than a step of the grid have no area once snapped, wherever they lie;
/// those of a few steps show the centre that they hold, or nothing.
#[test]
fn conformance_triangles_below_a_subpixel() {
    let step = 1.0 / 65536.0;
    let at = |middle: [f64; 2], size: f64| {
        let place = |[x, y]: [f64; 2]| {
            unproject(viewport(), [middle[0] + size * x, middle[1] + size * y], 0.5, 1.0)
        };
        Poly::bare(&[[-0.4, -0.4], [0.45, -0.3], [0.0, 0.45]].map(place))
    };
    let mut polys = Vec::new();
    for i in 0..16 {
        let shift = [f64::from(i % 4), f64::from(i / 4)].map(|c| c * 15.0 + 0.5);
        polys.push(at(shift, 0.9 * step));
    }
    // In f32 and on the grid, 20.5 has 1/65536 to spare.
    let mut cases = vec![Case::new("below a step", SIZE, polys, Rule::Nothing)];
    for size in [8.0, 64.0, 1024.0, 32768.0] {
        let name = format!("{size} steps about a centre");
        cases.push(Case::new(name, SIZE, vec![at([32.5, 32.5], size * step)], Rule::Each));
        let name = format!("{size} steps about a corner");
        cases.push(Case::new(name, SIZE, vec![at([32.0, 32.0], size * step)], Rule::Nothing));
    }
    check(&cases);
}

/// A wall at distance `d`, with near = 0.1 and no far plane: z is 0.1 everywhere.
fn wall(d: f32) -> Poly {
    let corner = |[x, y]: [f32; 2]| [x * d, y * d, 0.1, d].map(f64::from);
    Poly::bare(&[[-1.0, -1.0], [3.0, -1.0], [-1.0, 3.0]].map(corner))
}

/// Two walls, one 2^-21 of the distance behind the other: a reversed depth without a far plane
/// tells them apart at any distance, in either order; so does `tile --depth reversed`.
#[test]
fn conformance_reversed_depth_resolves_at_any_distance() {
    for exponent in -3..30 {
        let near = 1.7 * 2.0_f32.powi(exponent);
        let far = near * (1.0 + 2.0_f32.powi(-21));
        assert!(near < far);
        for order in [[near, far], [far, near]] {
            let walls = order.map(wall);
            let mut depths = vec![0.0_f32; 64 * 64];
            let mut ids = vec![9.0_f32; 64 * 64];
            let mut tiler = Tiler::new(viewport());
            tiler.set_depth_test(DepthTest::REVERSED);
            for (wall, d) in walls.iter().zip(order) {
                let mut depth = Plane::new(&mut depths, SIZE[0], SIZE[1]).expect("its size");
                let mut target = Plane::new(&mut ids, SIZE[0], SIZE[1]).expect("its size");
                tiler.draw(wall, &mut Solid(d), &mut target, Some(&mut depth));
            }
            assert!(ids.iter().all(|d| *d == near), "{order:?}");
            // Correctly rounded, in `Fast` too: 0.1/d, where 0.1 is that of f32.
            let right = (f64::from(0.1_f32) / f64::from(near)) as f32;
            assert!(depths.iter().all(|depth| *depth == right), "{order:?}");
            #[cfg(feature = "cli")]
            {
                let folder =
                    crate::harness::Folder::with(&[("t.poly", &crate::tile::text(&walls, false))]);
                folder.good("tile t.poly --size 64x64 --depth reversed --aov id=id.npy");
                let front = u32::from(order[1] == near);
                assert!(folder.npy("id.npy").integers().iter().all(|id| *id == front), "{order:?}");
            }
        }
    }
}
