//! What a frame asks of the allocator: nothing, once there was one like it.

use allocation_counter::measure;
use hyperspan::depth::DepthBounds;
use hyperspan::draw::{Frame, Polygons, Screen, With};
use hyperspan::order::DrawOrder;
use hyperspan::polygon::Vertex;
use hyperspan::shade::{BLOCK, Block, Inputs, Shader};
use hyperspan::space::Viewport;
use hyperspan::target::Plane;
use hyperspan::tiler::{Precision, Tiler};

const SIZE: [u32; 2] = [256, 256];

/// The sum of two attributes.
#[derive(Clone, Debug)]
struct Sum;

impl Shader for Sum {
    type Pixel = f32;
    const INPUTS: Inputs = Inputs::attributes(2);
    const KEEPS_ALL: bool = true;

    fn shade(&mut self, block: &Block<'_>, out: &mut [f32; BLOCK]) -> u16 {
        for (lane, pixel) in out.iter_mut().enumerate() {
            *pixel = block.attributes[0][lane] + block.attributes[1][lane];
        }
        block.mask
    }
}

/// Large and small ones, some of them clipped, with up to 6 vertices.
fn polygons() -> Vec<Vec<Vertex<2, [f64; 4]>>> {
    let polygon = |i: u32| {
        let (n, size) = (3 + i % 4, if i.is_multiple_of(3) { 1.5 } else { 0.02 });
        let vertex = |k: u32| {
            let angle = f64::from(k) / f64::from(n) * std::f64::consts::TAU;
            let (x, y) = (libm::cos(angle) * size, libm::sin(angle) * size);
            let z = 0.3 + 0.5 * x;
            Vertex::new([x + f64::from(i) * 0.01, y, z, 1.0 + 0.1 * x], [x as f32, y as f32])
        };
        (0..n).map(vertex).collect()
    };
    (0..50).map(polygon).collect()
}

#[test]
fn allocations_of_a_second_frame_are_none() {
    let polygons = polygons();
    let (mut colour, mut depths) = (vec![0.0; 1 << 16], vec![0.0; 1 << 16]);
    for precision in [Precision::Fast, Precision::Exact] {
        let mut tiler = Tiler::new(Viewport::new(0, 0, SIZE[0], SIZE[1]).expect("small"));
        tiler.set_precision(precision);
        let mut frame = Frame::new(tiler);
        let mut bounds = DepthBounds::new();
        let mut orders = [DrawOrder::new(), DrawOrder::new()];
        let mut draw = || {
            let screen = Screen {
                target: Plane::new(&mut colour, SIZE[0], SIZE[1]).expect("its size"),
                depth: Some(
                    Plane::new(&mut depths, SIZE[0], SIZE[1])
                        .expect("its size")
                        .with_bounds(&mut bounds),
                ),
                clear: Some((0.0, 1.0)),
            };
            let [back, front] = &mut orders;
            let painters = Polygons::new(back.back_to_front(&polygons), With(Sum));
            let nearest = Polygons::new(front.front_to_back(&polygons), With(Sum));
            frame.draw(screen, &[&Polygons::new(&polygons, With(Sum)), &painters, &nearest]);
        };
        let first = measure(&mut draw).count_total;
        assert!(first > 0, "the first frame has no buffers yet");
        assert_eq!(measure(&mut draw).count_total, 0, "{precision:?}");
        assert!(frame.stats().culled.hidden > 0);
        assert!(frame.stats().clipped > 5 && frame.stats().pixels_shaded > 10_000);
    }
}
