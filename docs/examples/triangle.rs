//! The smallest program: a triangle that leans away from the eye, and one attribute, exactly.

use hyperspan::{polygon::Vertex, shade::Fragment, space::Viewport, target::Plane, tiler::Tiler};

fn main() -> Result<(), hyperspan::error::Error> {
    // Clip space (x, y, z, w): the base is at distance w = 1, the apex at w = 3.
    let triangle = [
        Vertex::new([-1.0, -1.0, 0.0, 1.0], [0.0]),
        Vertex::new([1.0, -1.0, 0.0, 1.0], [0.0]),
        Vertex::new([0.0, 3.0, 0.0, 3.0_f32], [1.0]),
    ];
    let mut data = [[9.0; 4]; 4]; // 4 x 4 pixels; 9 where nothing is drawn
    let mut target = Plane::new(data.as_flattened_mut(), 4, 4)?;
    let mut shader = |pixel: &Fragment<'_>| pixel.attribute(0);
    Tiler::new(Viewport::new(0, 0, 4, 4)?).draw(&triangle, &mut shader, &mut target, None);
    // With perspective: halfway up the picture is not halfway up the triangle.
    let (far, middle, near) = (5.0 / 14.0, 1.0 / 6.0, 1.0 / 22.0);
    let expected: [[f32; 4]; 4] =
        [[9.0; 4], [9.0, far, far, 9.0], [9.0, middle, middle, 9.0], [near; 4]];
    assert_eq!(data, expected);
    Ok(())
}
