//! The soak of `hyperspan bench --soak`: its oracles are quick, and so are held to account by the
//! slow ones of tests/oracle here; and what is spoilt on purpose must be noticed.

use crate::bench::reference::Reference;
use crate::bench::soak;
use crate::bench::soak::check::{Desk, Tally};
use crate::bench::soak::cut::{Cut, tolerance};
use crate::bench::soak::outline::Outline;
use crate::bench::soak::scene::{Piece, Scene};
use crate::oracle::Poly;
use crate::oracle::clipper::{self, Side};
use crate::oracle::coverage::{covered, is_unclipped, snapped};

fn pool() -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(soak::POOL).build().expect("three threads")
}

fn poly(piece: &Piece) -> Poly {
    Poly { positions: piece.positions.clone(), attributes: piece.lists() }
}

/// The scenes of a seed whose target is small enough for slow oracles.
fn small_scenes(seed: u64, count: u64) -> impl Iterator<Item = Scene> {
    let all = (0..count).map(move |number| soak::scene(seed, number).expect("good viewports"));
    all.filter(|scene| scene.size().0 * scene.size().1 < 6000)
}

/// Rows by exact crossings against winding numbers, pixel by pixel.
#[test]
fn soak_outlines_are_the_crossing_oracles() {
    let mut pixels = 0;
    for scene in small_scenes(2, 3000) {
        let visible = scene.visible();
        for piece in scene.pieces.iter().take(20) {
            let Some(outline) = Outline::new(scene.viewport, &piece.positions) else { continue };
            assert!(is_unclipped(scene.viewport, &poly(piece)));
            let points = snapped(scene.viewport, &poly(piece));
            let right = covered(scene.viewport.grid(), &points, visible);
            let (rows, mut spans, mut found) = (outline.rows(), Vec::new(), Vec::new());
            for y in rows.start.max(visible.y0)..rows.end.min(visible.y1) {
                outline.row(y, &mut spans);
                let inside = spans.iter().flat_map(|s| s[0].max(visible.x0)..s[1].min(visible.x1));
                found.extend(inside.map(|x| (x, y)));
            }
            assert_eq!(found, right, "{}", scene.text(0));
            pixels += right.len();
        }
    }
    assert!(pixels > 300_000, "{pixels}");
}

/// Sides in homogeneous coordinates against the exact clipper.
#[test]
fn soak_cuts_are_the_exact_clippers() {
    let (mut cuts, mut sure) = (0, 0);
    for scene in small_scenes(3, 2500) {
        let visible = scene.visible();
        for piece in &scene.pieces {
            let poly = poly(piece);
            if is_unclipped(scene.viewport, &poly) || piece.positions.len() > 4 {
                continue;
            }
            let reference = Reference::new(&poly.positions, &poly.attributes, &scene.viewport);
            let cut = reference
                .and_then(|r| Cut::new(&r, [visible.x0, visible.y0], scene.viewport.grid()));
            let Some(cut) = cut else { continue };
            let corners = clipper::clip(&poly, &clipper::planes(scene.viewport));
            let outline = clipper::outline(scene.viewport, &corners);
            cuts += 1;
            let tolerance = tolerance(scene.viewport.grid());
            for y in (visible.y0..visible.y1).step_by(3) {
                let row = cut.row(y, visible.x0..visible.x1);
                for x in visible.x0..visible.x1 {
                    let within = |[start, end]: [i32; 2]| start <= x && x < end;
                    match clipper::side(&outline, x, y, 3.0 * tolerance) {
                        Side::Inside => assert!(within(row.surely), "{x} {y} {row:?}"),
                        Side::Outside => assert!(!within(row.perhaps), "{x} {y} {row:?}"),
                        Side::Near => {}
                    }
                    if within(row.surely) {
                        let side = clipper::side(&outline, x, y, tolerance / 2.0);
                        assert_eq!(side, Side::Inside, "{x} {y} {row:?}");
                        sure += 1;
                    }
                }
            }
        }
    }
    assert!(cuts > 100 && sure > 10_000, "{cuts} {sure}");
}

/// Values along runs, in plain `f64`, are as near to the reference's as they say.
#[test]
fn soak_runs_are_the_references() {
    let mut compared = 0;
    for scene in small_scenes(4, 1500).filter(|scene| scene.values) {
        let visible = scene.visible();
        for piece in scene.pieces.iter().take(6) {
            let reference = Reference::new(&piece.positions, &piece.lists(), &scene.viewport);
            let Some(reference) = reference else { continue };
            let count = visible.x1.abs_diff(visible.x0) as usize;
            for y in (visible.y0..visible.y1).step_by(5).filter(|_| count > 0) {
                let runs = reference.runs(visible.x0, y, count);
                for i in (0..count).step_by(3) {
                    let x = visible.x0 + i as i32;
                    let first = [
                        (Some(runs.depth), reference.depth(x, y)),
                        (runs.inv_w, reference.inv_w(x, y)),
                        (runs.w, reference.w(x, y)),
                    ];
                    let attributes = runs.attributes.iter().enumerate();
                    let attributes =
                        attributes.map(|(k, r)| (Some(*r), reference.attribute(k, x, y)));
                    for (run, right) in first.into_iter().chain(attributes) {
                        let (Some(near), Some(right)) = (run.map(|run| run.at(i)), right) else {
                            continue;
                        };
                        let off = ((near.value - right.high) - right.low).abs();
                        assert!(off <= near.error + right.error, "{near:?} {right:?} at {x}, {y}");
                        compared += u64::from(near.error < 1e-9 * right.high.abs());
                    }
                }
            }
        }
    }
    assert!(compared > 100_000, "{compared}");
}

/// The scenes themselves, in the test profile: a few hundred.
#[test]
fn soak_finds_no_disagreement() {
    let (pool, mut desk, mut total) = (pool(), Desk::default(), Tally::default());
    for number in 0..300 {
        let scene = soak::scene(1, number).expect("good viewports");
        match desk.check(&scene, &pool, &|_| ()) {
            Ok(tally) => total.add(&tally),
            Err(wrong) => {
                let text = scene.text(wrong.piece);
                panic!("scene {number}, {}: {}\n{text}", scene.kind, wrong.what)
            }
        }
    }
    assert!(total.covered > 3_000_000 && total.cut > 50, "{total:?}");
    assert!(total.compared.values.iter().all(|count| *count > 1_000_000), "{total:?}");
    assert!(total.compared.left_out < 10_000, "{total:?}");
    assert!(total.compared.doubtful < total.compared.values[1] / 10, "{total:?}");
    for (p, of) in total.compared.worst.iter().enumerate() {
        assert!(of.iter().all(|part| *part > 0.1 && *part <= 1.0), "{p}: {total:?}");
    }
}

/// A pixel too many, one too few, and a value that is off: each is found.
#[test]
fn soak_notices_what_is_spoilt() {
    let (pool, mut desk) = (pool(), Desk::default());
    let (mut pixels, mut values) = (0, 0);
    for number in 0..120 {
        let scene = soak::scene(5, number).expect("good viewports");
        let visible = scene.visible();
        if scene.depth.is_some() || visible.is_empty() {
            continue;
        }
        let good = desk
            .check(&scene, &pool, &|_| ())
            .unwrap_or_else(|wrong| panic!("{}\n{}", wrong.what, scene.text(wrong.piece)));
        if good.cut > 0 || good.covered == 0 {
            continue;
        }
        let flipped = |desk: &mut Desk| {
            let (width, height) = scene.size();
            let middle = (width * height / 2) as usize;
            // Where marks are what is compared, some are set.
            if desk.marks.drawn.iter().any(|mark| *mark != 0) {
                desk.marks.drawn[middle] ^= 1;
            } else {
                desk.ids[middle] ^= 1 << 20;
            }
        };
        assert!(desk.check(&scene, &pool, &flipped).is_err(), "{}", scene.text(0));
        pixels += 1;
        if scene.pieces.len() > 1 || good.compared.values == [0, 0] {
            continue;
        }
        let raised = |desk: &mut Desk| {
            let drawn = desk.ids.iter().position(|id| *id == 0).expect("a pixel");
            // w, which is correctly rounded in both precisions.
            desk.values[drawn][1] = desk.values[drawn][1].next_up();
        };
        let wrong = desk.check(&scene, &pool, &raised).expect_err("a unit off");
        assert!(wrong.what.contains(" w is "), "{}", wrong.what);
        values += 1;
    }
    assert!(pixels > 30 && values > 5, "{pixels} {values}");
}
