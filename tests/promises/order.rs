//! Orders to draw in: without a depth buffer the painter's gives the picture that depth gives.

use std::cell::Cell;

use crate::oracle::probe::One;
use hyperspan::batch::Batch;
use hyperspan::draw::{Frame, Polygons, Screen, With};
use hyperspan::order::DrawOrder;
use hyperspan::polygon::Vertex;
use hyperspan::space::Viewport;
use hyperspan::target::Plane;
use hyperspan::tiler::Tiler;
use proptest::prelude::*;

type Triangle = [Vertex<1, [f64; 4]>; 3];

const SIDE: u32 = 48;

/// The polygons' attribute, which is their number.
fn picture<B: Batch>(batch: B, with_depth: bool) -> Vec<u32> {
    let area = (SIDE * SIDE) as usize;
    let (mut picture, mut depths) = (vec![u32::MAX; area], vec![1.0; area]);
    let target = Plane::new(&mut picture, SIDE, SIDE).expect("its size");
    let depth = Plane::new(&mut depths, SIDE, SIDE).expect("its size");
    let screen = Screen { target, depth: with_depth.then_some(depth), clear: None };
    let mut frame = Frame::new(Tiler::new(Viewport::new(0, 0, SIDE, SIDE).expect("small")));
    frame.draw(screen, &[&Polygons::new(batch, With(One(0)))]);
    picture
}

/// Triangles, each at a distance of its own.
fn triangles() -> impl Strategy<Value = Vec<Triangle>> {
    let corner = (-1.3..1.3_f64, -1.3..1.3_f64);
    prop::collection::vec((0_u32..1000, [corner.clone(), corner.clone(), corner]), 1..40).prop_map(
        |list| {
            let next = Cell::new(0.0);
            let triangle = |w: u32, corners: [(f64, f64); 3]| {
                let w = 1.0 + f64::from(w) / 100.0;
                let number = next.replace(next.get() + 1.0);
                corners.map(|(x, y)| Vertex::new([x * w, y * w, w - 0.9, w], [number]))
            };
            let mut seen = Vec::new();
            let mut once = |w: u32| {
                !seen.contains(&w) && {
                    seen.push(w);
                    true
                }
            };
            list.into_iter().filter(|(w, _)| once(*w)).map(|(w, c)| triangle(w, c)).collect()
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(
            prop::test_runner::FileFailurePersistence::WithSource("regressions"),
        )),
        ..ProptestConfig::default()
    })]

    #[test]
    fn order_from_the_back_needs_no_depth_buffer(triangles in triangles()) {
        let mut order = DrawOrder::new();
        let expected = picture(&triangles, true);
        prop_assert_eq!(&picture(order.back_to_front(&triangles), false), &expected);
        prop_assert_eq!(&picture(order.front_to_back(&triangles), true), &expected);
    }
}

/// Three parts of two faces: the second face is nearer, and its parts stay in their order.
struct Faces(Vec<Triangle>);

impl Batch for Faces {
    type Polygon<'a> = &'a Triangle;

    fn len(&self) -> usize {
        self.0.len()
    }

    fn polygon(&self, i: usize) -> &Triangle {
        &self.0[i]
    }

    fn continues(&self, i: usize) -> bool {
        i == 2
    }
}

#[test]
fn order_keeps_faces_together() {
    let at = |w: f64| {
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| Vertex::new([x, y, 0.5, w], [0.0]))
    };
    let faces = Faces(vec![at(2.0), at(1.0), at(3.0), at(1.5)]);
    let mut order = DrawOrder::new();
    let originals = |ordered: hyperspan::order::Ordered<'_, &Faces>| {
        (0..4).map(|i| ordered.original(i)).collect::<Vec<_>>()
    };
    assert_eq!(originals(order.back_to_front(&faces)), [1, 2, 0, 3]);
    assert_eq!(originals(order.front_to_back(&faces)), [1, 2, 3, 0]);
}
