//! Draws a scene with the library: the transform, the clear and every polygon.

use glam::DVec3;
use hyperspan::camera::transform;
use hyperspan::depth::{DepthBounds, DepthTest};
use hyperspan::polygon::Polygon;
use hyperspan::shade::{BLOCK, Block, Inputs, ROW, Shader, unorm8};
use hyperspan::simd::Simd;
use hyperspan::space::Viewport;
use hyperspan::target::Plane;
use hyperspan::texture::Texture;
use hyperspan::tiler::{Precision, Tiler};

use super::{Corner, Face, Look, Scene, TEXTURE_SIDE};

/// A face in clip space, with its first `N` attributes.
pub(crate) struct Placed<'a, const N: usize> {
    indices: &'a [u32],
    clip: &'a [[f64; 4]],
    corners: &'a [Corner],
}

impl<'a, const N: usize> Placed<'a, N> {
    pub(crate) fn new(scene: &'a Scene, clip: &'a [[f64; 4]], face: Face) -> Self {
        Self { indices: &scene.indices[face.start..face.end], clip, corners: &scene.corners }
    }
}

impl<const N: usize> Polygon for Placed<'_, N> {
    #[inline]
    fn len(&self) -> usize {
        self.indices.len()
    }

    #[inline]
    fn attribute_count(&self) -> usize {
        N
    }

    #[inline]
    fn position(&self, i: usize) -> [f64; 4] {
        self.clip[self.indices[i] as usize]
    }

    #[inline]
    fn attribute(&self, i: usize, k: usize) -> f32 {
        self.corners[self.indices[i] as usize].attributes[k]
    }
}

/// Attributes 0 to 2 as a colour.
#[derive(Debug)]
pub(crate) struct Coloured;

impl Shader for Coloured {
    type Pixel = [u8; 4];
    const INPUTS: Inputs = Inputs::attributes(3);
    const KEEPS_ALL: bool = true;

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, out: &mut [[u8; 4]; BLOCK]) -> u16 {
        let [red, green, blue] = block.attributes else { return 0 };
        for lane in 0..BLOCK {
            out[lane] = [unorm8(red[lane]), unorm8(green[lane]), unorm8(blue[lane]), 255];
        }
        block.mask
    }
}

/// Attributes 0 and 1 as a place on a texture.
#[derive(Debug)]
pub(crate) struct Textured<'a>(pub(crate) &'a Texture);

impl Shader for Textured<'_> {
    type Pixel = [u8; 4];
    const INPUTS: Inputs = Inputs::attributes(2);
    const KEEPS_ALL: bool = true;

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, out: &mut [[u8; 4]; BLOCK]) -> u16 {
        let [u, v] = block.attributes else { return 0 };
        self.0.nearest_block(u, v, block.mask, out);
        block.mask
    }

    #[inline(always)]
    fn shade_row(&mut self, blocks: &[Block<'_>; ROW], out: &mut [[[u8; 4]; BLOCK]; ROW]) {
        self.0.nearest_row(blocks, [0, 1], out);
    }
}

/// A scene ready to be drawn, with what is kept from one frame to the next.
pub(crate) struct Stage<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) tiler: Tiler,
    pub(crate) textures: Vec<Texture>,
    pub(crate) clip: Vec<[f64; 4]>,
    pub(crate) colour: Vec<[u8; 4]>,
    pub(crate) depth: Vec<f32>,
    /// Of the depths of whole frames, if they are to have any.
    pub(crate) bounds: Option<DepthBounds>,
}

impl<'a> Stage<'a> {
    pub(crate) fn new(scene: &'a Scene, precision: Precision, simd: Simd) -> Self {
        let (width, height) = scene.size;
        let mut tiler = Tiler::new(Viewport::new(0, 0, width, height).expect("a small picture"));
        tiler.set_depth_test(DepthTest::STANDARD).set_precision(precision).set_simd(simd);
        let texture = |rows: &Vec<_>| Texture::new(TEXTURE_SIDE, TEXTURE_SIDE, rows);
        let area = width as usize * height as usize;
        Self {
            scene,
            tiler,
            textures: scene.textures.iter().map(|t| texture(t).expect("its size")).collect(),
            clip: vec![[0.0; 4]; scene.corners.len()],
            colour: vec![[0; 4]; area],
            depth: vec![0.0; area],
            bounds: None,
        }
    }

    /// A frame.
    pub(crate) fn draw(&mut self) {
        self.clear();
        self.transform();
        let (width, height) = self.scene.size;
        self.draw_part([0, 0], [width, height]);
    }

    pub(crate) fn clear(&mut self) {
        self.colour.fill([0; 4]);
        self.depth.fill(1.0);
        if let Some(bounds) = &mut self.bounds {
            bounds.clear();
        }
    }

    pub(crate) fn transform(&mut self) {
        for (clip, corner) in self.clip.iter_mut().zip(&self.scene.corners) {
            *clip = transform(self.scene.camera, DVec3::from_array(corner.position));
        }
    }

    /// The pixels of a rectangle, as a crop of the picture.
    pub(crate) fn draw_part(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2]) {
        let Self { scene, tiler, textures, clip, colour, depth, bounds } = self;
        let stride = scene.size.0 as usize;
        let first = y as usize * stride + x as usize;
        let mut target = Plane::with_stride(&mut colour[first..], width, height, stride)
            .expect("a part of the picture");
        let mut depth = Plane::with_stride(&mut depth[first..], width, height, stride)
            .expect("a part of the picture");
        if let Some(bounds) = bounds.as_mut().filter(|_| (width, height) == scene.size) {
            depth = depth.with_bounds(bounds);
        }
        tiler.set_origin(x.cast_signed(), y.cast_signed());
        for face in &scene.faces {
            let depth = Some(&mut depth);
            match face.look {
                Look::Coloured => {
                    let face = Placed::<3>::new(scene, clip, *face);
                    tiler.draw(&face, &mut Coloured, &mut target, depth);
                }
                Look::Textured(texture) => {
                    let face = Placed::<2>::new(scene, clip, *face);
                    tiler.draw(&face, &mut Textured(&textures[texture]), &mut target, depth);
                }
            }
        }
    }
}
