//! Where arithmetic takes subnormal numbers for 0, nothing is drawn: run by tests/flushed.sh, which
//! makes it so.

use hyperspan::draw::{Frame, Polygons, Screen, With};
use hyperspan::polygon::Vertex;
use hyperspan::shade::Solid;
use hyperspan::space::Viewport;
use hyperspan::target::Plane;
use hyperspan::tiler::{Outcome, Tiler};

#[test]
#[ignore = "tests/flushed.sh runs it with arithmetic that flushes"]
fn flushing_arithmetic_is_refused() {
    let triangle = [[-1.0, -1.0], [3.0, -1.0], [-1.0, 3.0]]
        .map(|[x, y]| Vertex::new([x, y, 0.5, 1.0_f32], []));
    let mut picture = [0_u32; 64];
    let mut target = Plane::new(&mut picture, 8, 8).expect("8 x 8");
    let mut tiler = Tiler::new(Viewport::new(0, 0, 8, 8).expect("small"));
    let outcome = tiler.draw(&triangle, &mut Solid(1), &mut target, None);
    assert_eq!(outcome, Outcome::Refused);
    assert_eq!((tiler.stats().culled.refused, tiler.stats().pixels_covered), (1, 0));
    let screen = Screen { target, depth: None, clear: None };
    let mut frame = Frame::new(tiler);
    frame.draw(screen, &[&Polygons::new(vec![triangle], With(Solid(1)))]);
    assert_eq!((frame.stats().culled.refused, frame.stats().pixels_covered), (1, 0));
    assert_eq!(picture, [0; 64]);
}
