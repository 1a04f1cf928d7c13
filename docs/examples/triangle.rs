//! The smallest program: a triangle that leans away from the eye, and one attribute as data.
use hyperspan::{Error, Fragment, Plane, Tiler, Vertex, Viewport};

fn main() -> Result<(), Error> {
    let triangle = [
        Vertex::new([-1.0, -1.0, 0.0, 1.0], [0.0]), // clip space (x, y, z, w), one attribute
        Vertex::new([1.0, -1.0, 0.0, 1.0], [0.0]),
        Vertex::new([0.0, 3.0, 0.0, 3.0], [1.0]),
    ];
    let mut data = [9.0; 16]; // 4 x 4 pixels; 9 where nothing is drawn
    let mut shader = |pixel: &Fragment<'_>| pixel.attribute(0);
    let mut target = Plane::new(&mut data, 4, 4)?;
    Tiler::new(Viewport::new(0, 0, 4, 4)?).draw(&triangle, &mut shader, &mut target, None);
    assert_eq!(data[4..8], [9.0, 5.0 / 14.0, 5.0 / 14.0, 9.0]); // with perspective
    Ok(())
}
