//! The smallest program: a triangle that leans away from the eye, with one attribute.

use hyperspan::{polygon::Vertex, shade::Fragment, space::Viewport, target::Plane, tiler::Tiler};

fn main() -> Result<(), hyperspan::error::Error> {
    // Clip space (x, y, z, w): the base is at distance w = 1, the apex at w = 3.
    let base = [-1.0, 1.0].map(|x| Vertex::new([x, -1.0, 0.0, 1.0], [0.0]));
    let triangle = [base[0], base[1], Vertex::new([0.0, 3.0, 0.0, 3.0_f32], [1.0])];
    let mut data = [[9.0; 4]; 4]; // a picture of 4 x 4 numbers
    let mut target = Plane::new(data.as_flattened_mut(), 4, 4)?;
    let mut shader = |pixel: &Fragment<'_>| pixel.attribute(0);
    Tiler::new(Viewport::new(0, 0, 4, 4)?).draw(&triangle, &mut shader, &mut target, None);
    // Halfway up the picture is not halfway up the triangle: that is perspective.
    let (far, middle, near) = (5.0 / 14.0, 1.0 / 6.0, 1.0 / 22.0);
    assert_eq!(data, [[9.0; 4], [9.0, far, far, 9.0], [9.0, middle, middle, 9.0], [near; 4]]);
    Ok(())
}
