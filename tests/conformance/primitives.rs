//! Lists, strips and fans of triangles (dEQP, functional.rasterization.primitives), and culling in
//! all windings (functional.rasterization.culling). Whoever takes strips and fans makes triangles
//! of them: in a strip every second one runs the other way round.

use hyperspan::shade::Solid;
use hyperspan::space::Viewport;
use hyperspan::tiler::{Cull, Outcome};

use crate::case::{Case, Rule, check};
use crate::oracle::Poly;
use crate::oracle::coverage::{doubled_area, snapped};
use crate::oracle::probe::Sheet;
use crate::oracle::shapes::unproject;

const SIZE: [u32; 2] = [64, 64];

fn viewport() -> Viewport {
    Viewport::new(0, 0, SIZE[0], SIZE[1]).expect("small")
}

fn place([x, y]: [f64; 2], w: f64) -> [f64; 4] {
    unproject(viewport(), [x, y], 0.5, w)
}

/// Ten points, from left to right, up and down.
fn zigzag(w: impl Fn(u32) -> f64) -> Vec<[f64; 4]> {
    let at = |i: u32| [4.0 + 6.1 * f64::from(i), if i.is_multiple_of(2) { 11.3 } else { 52.9 }];
    (0..10).map(|i| place(at(i), w(i))).collect()
}

/// A middle and eleven points round it.
fn wheel(w: impl Fn(u32) -> f64) -> Vec<[f64; 4]> {
    let at = |i: u32| {
        let (s, c) = (f64::from(i) * std::f64::consts::TAU / 11.0).sin_cos();
        [33.0 + 27.0 * c, 31.0 + 25.0 * s]
    };
    let middle = place([30.7, 33.2], w(0));
    [middle].into_iter().chain((1..12).map(|i| place(at(i), w(i)))).collect()
}

fn list(points: &[[f64; 4]]) -> Vec<Poly> {
    points.chunks_exact(3).map(Poly::bare).collect()
}

fn strip(points: &[[f64; 4]]) -> Vec<Poly> {
    let triangle = |(i, window): (usize, &[[f64; 4]])| {
        let [a, b, c] = [window[0], window[1], window[2]];
        Poly::bare(&if i % 2 == 0 { [a, b, c] } else { [b, a, c] })
    };
    points.windows(3).enumerate().map(triangle).collect()
}

fn fan(points: &[[f64; 4]]) -> Vec<Poly> {
    points[1..].windows(2).map(|pair| Poly::bare(&[points[0], pair[0], pair[1]])).collect()
}

/// The outline of a strip: one side there, the other back.
fn rim(points: &[[f64; 4]]) -> Poly {
    let there = points.iter().step_by(2);
    let back = points.iter().skip(1).step_by(2).rev();
    Poly::bare(&there.chain(back).copied().collect::<Vec<_>>())
}

/// The w of a point by its number.
type WOf = fn(u32) -> f64;

/// With w = 1 everywhere, and different everywhere.
fn ws() -> [(&'static str, WOf); 2] {
    [("w = 1", |_| 1.0), ("w from 0.2 to 4", |i| 0.2 + 3.8 * f64::from(i * 5 % 12) / 11.0)]
}

#[test]
fn conformance_lists_strips_and_fans() {
    let mut cases = Vec::new();
    for (name, w) in ws() {
        let (zigzag, wheel) = (zigzag(w), wheel(w));
        let closed: Vec<_> = wheel.iter().chain([&wheel[1]]).copied().collect();
        cases.extend([
            Case::new(format!("list, {name}"), SIZE, list(&zigzag), Rule::Each),
            Case::new(format!("list of one, {name}"), SIZE, list(&zigzag[..3]), Rule::Each),
            Case::new(format!("strip, {name}"), SIZE, strip(&zigzag), Rule::Once(rim(&zigzag))),
            Case::new(format!("fan, {name}"), SIZE, fan(&wheel[..9]), Rule::Each),
            Case::new(
                format!("closed fan, {name}"),
                SIZE,
                fan(&closed),
                Rule::Once(Poly::bare(&wheel[1..])),
            ),
            // Two vertices, or the rest of a list.
            Case::new(format!("no triangle, {name}"), SIZE, list(&zigzag[..2]), Rule::Nothing),
        ]);
    }
    check(&cases);
}

/// Front faces are counter-clockwise with y up: what is left of a list, a strip and a fan.
#[test]
fn conformance_culling_in_all_windings() {
    let mut kinds = Vec::new();
    for (name, w) in ws() {
        kinds.push((format!("list, {name}"), list(&zigzag(w))));
        kinds.push((format!("strip, {name}"), strip(&zigzag(w))));
        kinds.push((format!("fan, {name}"), fan(&wheel(w))));
    }
    let (mut seen, mut culled) = (0, 0);
    for (name, polygons) in kinds {
        for over in [false, true] {
            let turned = polygons.iter().map(|p| if over { p.reversed() } else { p.clone() });
            let turned: Vec<Poly> = turned.collect();
            for poly in &turned {
                let front = doubled_area(&snapped(viewport(), poly)) > 0;
                for (cull, shown) in
                    [(Cull::None, true), (Cull::Back, front), (Cull::Front, !front)]
                {
                    let mut sheet = Sheet::new(SIZE[0], SIZE[1]);
                    let mut tiler = hyperspan::tiler::Tiler::new(viewport());
                    let outcome = tiler.set_cull(cull).draw(poly, &mut Solid(1), &mut sheet, None);
                    let expected = if shown { Outcome::Drawn } else { Outcome::Backface };
                    assert_eq!(outcome, expected, "{name}, {cull:?}");
                    assert_eq!(sheet.pixels.iter().any(Option::is_some), shown, "{name}, {cull:?}");
                    *(if shown { &mut seen } else { &mut culled }) += 1;
                }
            }
            // `tile` never culls: either way round it is the same picture.
            check(&[Case::new(format!("{name}, {over}"), SIZE, turned, Rule::Each)]);
        }
    }
    // Of each polygon one of the three leaves nothing.
    assert!(seen == 2 * culled && culled > 50, "{seen} {culled}");
}
