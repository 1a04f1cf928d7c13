//! A textured floor to the horizon, as a picture that can be read in a terminal.
//!
//! The floor is one quad with `uv` that repeat. The shader is a closure that looks a texel up.

use glam::DVec3;
use hyperspan::camera::{self, DepthConvention, DepthPlanes};
use hyperspan::polygon::Vertex;
use hyperspan::shade::Fragment;
use hyperspan::space::{DepthRange, Viewport};
use hyperspan::target::Plane;
use hyperspan::texture::Texture;
use hyperspan::tiler::Tiler;

const WIDTH: u32 = 64;
const HEIGHT: u32 = 20;

fn main() -> Result<(), hyperspan::error::Error> {
    // 2 x 2 texels, rows from the top; v = 0 is the bottom.
    let (dark, light) = ([32, 48, 80, 255], [232, 220, 180, 255]);
    let texture = Texture::new(2, 2, &[dark, light, light, dark])?;

    let planes = DepthPlanes {
        near: 0.1,
        far: f64::INFINITY,
        convention: DepthConvention::Reversed,
        range: DepthRange::ZeroToOne,
    };
    let matrix = camera::multiply(
        // Characters are twice as high as wide.
        camera::perspective(50.0, f64::from(WIDTH) / f64::from(2 * HEIGHT), planes)?,
        camera::look_at(DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.0, 0.7, -1.0), DVec3::Y)?,
    );
    // Reaches far behind the eye: the near plane cuts it.
    let corner = |x: f64, z: f64| {
        let uv = [x as f32 / 2.0, z as f32 / 2.0];
        Vertex::new(camera::transform(matrix, DVec3::new(x, 0.0, z)), uv)
    };
    let floor =
        [corner(-50.0, 10.0), corner(50.0, 10.0), corner(50.0, -100.0), corner(-50.0, -100.0)];

    let mut pixels = vec![[0; 4]; (WIDTH * HEIGHT) as usize];
    let mut target = Plane::new(&mut pixels, WIDTH, HEIGHT)?;
    let mut shader = |pixel: &Fragment<'_>| texture.nearest(pixel.attribute(0), pixel.attribute(1));
    let mut tiler = Tiler::new(Viewport::new(0, 0, WIDTH, HEIGHT)?);
    tiler.draw(&floor, &mut shader, &mut target, None);

    let character = |pixel: &[u8; 4]| match *pixel {
        p if p == light => '#',
        p if p == dark => '.',
        _ => ' ',
    };
    let rows: Vec<String> =
        pixels.chunks(WIDTH as usize).map(|row| row.iter().map(character).collect()).collect();
    show(&rows);

    assert_eq!(tiler.stats().clipped, 1);
    assert!(rows[0].trim().is_empty(), "sky above");
    let below = &rows[HEIGHT as usize - 1];
    assert!(below.contains("####") && below.contains("....") && !below.contains(' '));
    Ok(())
}

#[expect(clippy::print_stdout, reason = "this is what the example is for")]
fn show(rows: &[String]) {
    for row in rows {
        println!("{row}");
    }
}
