//! How faces look: which attributes they need at their vertices, and what a pixel's colour is.
//!
//! One type for each kind, so that it can be compiled into a loop of its own. Unlit: the texel,
//! else (vertex colour or white) times `Kd`. Lit: the same times the light at the vertices
//! (Gouraud).

use glam::DVec3;
use hyperspan::shade::{BLOCK, Block, ROW};
use hyperspan::texture::Texture;

use crate::camera::Camera;
use crate::model::{Look, Model, Piece};
use crate::shaders::{Colour, Reads};

/// A corner of a face: its number in the model, and that of its position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    pub(crate) number: usize,
    pub(crate) position: usize,
}

/// A kind of look: the vertices' side of it; a pixel's is [`Colour`].
pub(crate) trait Surface: Colour {
    /// Attribute `k` at `corner`.
    fn attribute(&self, corner: Corner, k: usize) -> f32;

    /// A pixel's side.
    fn colour(&self) -> &dyn Colour;

    /// Which attributes are texture coordinates, if any are: from this one on.
    fn uv(&self) -> Option<usize> {
        None
    }
}

/// One colour.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain {
    /// `Kd`
    pub(crate) diffuse: [f32; 3],
}

impl Reads for Plain {
    const ATTRIBUTES: usize = 0;
}

impl Colour for Plain {
    #[inline(always)]
    fn rgb(&self, _attributes: &[[f32; BLOCK]], _lane: usize) -> [f32; 3] {
        self.diffuse
    }
}

impl Surface for Plain {
    fn colour(&self) -> &dyn Colour {
        self
    }

    #[inline(always)]
    fn attribute(&self, _corner: Corner, _k: usize) -> f32 {
        0.0
    }
}

/// Colours that differ from vertex to vertex: those of the file, those of light, or both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shaded<'a> {
    /// `Kd`
    pub(crate) diffuse: [f32; 3],
    /// By position; empty if the file has none.
    pub(crate) colors: &'a [[f32; 3]],
    /// By corner; empty if nothing is lit.
    pub(crate) light: &'a [f32],
}

impl Reads for Shaded<'_> {
    const ATTRIBUTES: usize = 3;
}

impl Colour for Shaded<'_> {
    #[inline(always)]
    fn rgb(&self, attributes: &[[f32; BLOCK]], lane: usize) -> [f32; 3] {
        let [r, g, b] = self.diffuse;
        [attributes[0][lane] * r, attributes[1][lane] * g, attributes[2][lane] * b]
    }
}

impl Surface for Shaded<'_> {
    fn colour(&self) -> &dyn Colour {
        self
    }

    #[inline(always)]
    fn attribute(&self, corner: Corner, k: usize) -> f32 {
        let color = self.colors.get(corner.position).map_or(1.0, |color| color[k]);
        self.light.get(corner.number).map_or(color, |light| light * color)
    }
}

/// A texture, as it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Textured<'a> {
    /// What is looked up: opaque.
    pub(crate) texture: &'a Texture,
    /// Texture coordinates.
    pub(crate) uvs: &'a [[f32; 2]],
    /// Those of each corner.
    pub(crate) indices: &'a [u32],
}

impl Textured<'_> {
    #[inline]
    fn texel(&self, attributes: &[[f32; BLOCK]], lane: usize) -> [u8; 3] {
        let [r, g, b, _] = self.texture.nearest(attributes[0][lane], attributes[1][lane]);
        [r, g, b]
    }
}

impl Reads for Textured<'_> {
    const ATTRIBUTES: usize = 2;
}

impl Colour for Textured<'_> {
    #[inline(always)]
    fn rgb(&self, attributes: &[[f32; BLOCK]], lane: usize) -> [f32; 3] {
        self.texel(attributes, lane).map(|byte| f32::from(byte) / 255.0)
    }

    fn rgb_lanes(&self, attributes: &[[f32; BLOCK]], mask: u16, out: &mut [[f32; BLOCK]; 3]) {
        let mut texels = [[0; 4]; BLOCK];
        self.rgba8(attributes, mask, &mut texels);
        for (k, out) in out.iter_mut().enumerate() {
            for (out, texel) in out.iter_mut().zip(&texels) {
                *out = f32::from(texel[k]) / 255.0;
            }
        }
    }

    /// Texels pass as they are: what `rgb` gives rounds to the same bytes.
    #[inline(always)]
    fn rgba8(&self, attributes: &[[f32; BLOCK]], mask: u16, out: &mut [[u8; 4]; BLOCK]) {
        self.texture.nearest_block(&attributes[0], &attributes[1], mask, out);
    }

    #[inline(always)]
    fn rgba8_row(&self, blocks: &[Block<'_>; ROW], out: &mut [[[u8; 4]; BLOCK]; ROW]) {
        self.texture.nearest_row(blocks, [0, 1], out);
    }
}

impl Surface for Textured<'_> {
    fn colour(&self) -> &dyn Colour {
        self
    }

    fn uv(&self) -> Option<usize> {
        Some(0)
    }

    #[inline(always)]
    fn attribute(&self, corner: Corner, k: usize) -> f32 {
        self.uvs[self.indices[corner.number] as usize][k]
    }
}

/// A texture, lit at the vertices: three attributes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LitTexture<'a> {
    /// Without the light.
    pub(crate) textured: Textured<'a>,
    /// By corner.
    pub(crate) light: &'a [f32],
}

impl Colour for LitTexture<'_> {
    #[inline(always)]
    fn rgb(&self, attributes: &[[f32; BLOCK]], lane: usize) -> [f32; 3] {
        self.textured.rgb(attributes, lane).map(|part| part * attributes[2][lane])
    }

    fn rgb_lanes(&self, attributes: &[[f32; BLOCK]], mask: u16, out: &mut [[f32; BLOCK]; 3]) {
        self.textured.rgb_lanes(attributes, mask, out);
        for out in out {
            for (out, light) in out.iter_mut().zip(&attributes[2]) {
                *out *= light;
            }
        }
    }
}

impl Surface for LitTexture<'_> {
    fn colour(&self) -> &dyn Colour {
        self
    }

    fn uv(&self) -> Option<usize> {
        Some(0)
    }

    #[inline(always)]
    fn attribute(&self, corner: Corner, k: usize) -> f32 {
        if k < 2 { self.textured.attribute(corner, k) } else { self.light[corner.number] }
    }
}

/// Light at the corners of `piece`, into `light`, which has a place for every corner: from over
/// the viewer's left shoulder, on whichever side is seen.
pub(crate) fn light_piece(
    model: &Model,
    camera: &Camera,
    look: Look,
    piece: Piece,
    light: &mut [f32],
) {
    const AMBIENT: f64 = 0.2;
    /// Towards the light: how far to the viewer, to the right, up.
    const DIRECTION: [f64; 3] = [0.8, -0.36, 0.48];

    let [back, right, up] = camera.axes;
    let towards = back * DIRECTION[0] + right * DIRECTION[1] + up * DIRECTION[2];
    let normal = |corner: usize| {
        let normal = if look.has_normals {
            model.normals[model.corners.normal[corner] as usize]
        } else {
            model.face_normals[piece.face as usize]
        };
        DVec3::from_array(normal.map(f64::from))
    };
    // A piece is seen from one side, whatever the normals of its corners say singly.
    let facing: f64 = piece
        .corners()
        .map(|corner| {
            let position = model.positions[model.corners.position[corner] as usize];
            let to_eye = camera.eye.map_or(back, |eye| eye - DVec3::from_array(position));
            dot(normal(corner), to_eye)
        })
        .sum();
    let side = if facing < 0.0 { -1.0 } else { 1.0 };
    for corner in piece.corners() {
        let n = normal(corner);
        let length = dot(n, n).sqrt();
        let lambert = if length > 0.0 { side * dot(n, towards) / length } else { 0.0 };
        #[expect(clippy::cast_possible_truncation, reason = "attributes are f32")]
        let sum = (AMBIENT + (1.0 - AMBIENT) * lambert.max(0.0)) as f32;
        light[corner] = sum;
    }
}

fn dot(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}
