//! Distance, ids and normals as data, in one pass, through a camera.
//!
//! A pentagonal prism: seven polygons, none of them cut into triangles. What comes out is not a
//! picture but numbers for each pixel, as training data or measurements want them.

use glam::DVec3;
use hyperspan::camera::{self, DepthPlanes};
use hyperspan::depth::DepthTest;
use hyperspan::polygon::Vertex;
use hyperspan::shade::Fragment;
use hyperspan::space::Viewport;
use hyperspan::target::Plane;
use hyperspan::tiler::{Cull, Tiler};

const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;
const NOTHING: u32 = u32::MAX;

fn main() -> Result<(), hyperspan::error::Error> {
    let aspect = f64::from(WIDTH) / f64::from(HEIGHT);
    let planes = DepthPlanes {
        near: 0.1,
        far: f64::INFINITY,
        convention: camera::DepthConvention::Reversed,
        range: hyperspan::space::DepthRange::ZeroToOne,
    };
    let eye = DVec3::new(2.0, 1.5, 4.0);
    let matrix = camera::multiply(
        camera::perspective(40.0, aspect, planes)?,
        camera::look_at(eye, DVec3::ZERO, DVec3::Y)?,
    );

    let size = (WIDTH * HEIGHT) as usize;
    let mut distances = vec![0.0_f32; size];
    let mut ids = vec![NOTHING; size];
    let mut normals = vec![[0.0_f32; 3]; size];
    let mut depths = vec![0.0_f32; size]; // reversed: cleared to 0, which is infinity
    let mut target = (
        Plane::new(&mut distances, WIDTH, HEIGHT)?,
        Plane::new(&mut ids, WIDTH, HEIGHT)?,
        Plane::new(&mut normals, WIDTH, HEIGHT)?,
    );
    let mut depth = Plane::new(&mut depths, WIDTH, HEIGHT)?;

    let mut tiler = Tiler::new(Viewport::new(0, 0, WIDTH, HEIGHT)?);
    tiler.set_depth_test(DepthTest::REVERSED).set_cull(Cull::Back);
    for (id, (corners, normal)) in (0..).zip(prism()) {
        let polygon: Vec<Vertex<3, [f64; 4]>> = corners
            .iter()
            .map(|corner| Vertex::new(camera::transform(matrix, *corner), normal))
            .collect();
        // An attribute that is equal at all vertices comes out as exactly that value.
        let mut shader =
            |pixel: &Fragment<'_>| (pixel.w(), id, [0, 1, 2].map(|axis| pixel.attribute(axis)));
        tiler.draw(&polygon[..], &mut shader, &mut target, Some(&mut depth));
    }

    // Two sides and the top can be seen from here.
    let stats = tiler.stats();
    assert_eq!((stats.polygons, stats.culled.backface), (7, 4));
    let mut seen: Vec<u32> = ids.iter().copied().filter(|id| *id != NOTHING).collect();
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen.len(), 3, "{seen:?}");
    for (pixel, id) in ids.iter().enumerate() {
        if *id == NOTHING {
            assert_eq!((distances[pixel], depths[pixel]), (0.0, 0.0));
        } else {
            assert_eq!(normals[pixel], prism()[*id as usize].1);
            assert!((3.0..6.0).contains(&distances[pixel]));
        }
    }
    Ok(())
}

/// The faces of a pentagonal prism, counter-clockwise from outside, with their normals.
fn prism() -> Vec<(Vec<DVec3>, [f32; 3])> {
    // Counter-clockwise from above; nothing needs these to be regular.
    let ring = [(0.0, 1.0), (0.95, 0.3), (0.6, -0.8), (-0.6, -0.8), (-0.95, 0.3)];
    let at = |(x, z): (f64, f64), y: f64| DVec3::new(x, y, z);
    let mut faces = vec![
        (ring.map(|p| at(p, 1.0)).to_vec(), [0.0, 1.0, 0.0]),
        (ring.iter().rev().map(|p| at(*p, -1.0)).collect(), [0.0, -1.0, 0.0]),
    ];
    for (i, p) in ring.iter().enumerate() {
        let q = ring[(i + 1) % ring.len()];
        let corners = vec![at(*p, -1.0), at(q, -1.0), at(q, 1.0), at(*p, 1.0)];
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[1]).normalize();
        faces.push((corners, normal.as_vec3().to_array()));
    }
    faces
}
