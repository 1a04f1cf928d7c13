//! euc 0.5. It has no clipper: what reaches behind the near plane is cut before anything is
//! measured.

use euc::buffer::Buffer2d;
use euc::rasterizer::{BackfaceCullingDisabled, Triangles};
use euc::{Pipeline, Target};

use super::{byte, fan, position, rows, runs};
use crate::scenes::{Corner, Look, Scene, TEXTURE_SIDE};

type Filled<'a> = Triangles<'a, Buffer2d<f32>, BackfaceCullingDisabled>;

/// World position, attributes.
type Vertex = ([f32; 3], [f32; 3]);

fn transform(m: &[[f32; 4]; 4], [x, y, z]: [f32; 3]) -> [f32; 4] {
    [0, 1, 2, 3].map(|i| m[i][0] * x + m[i][1] * y + m[i][2] * z + m[i][3])
}

struct Textured<'a> {
    camera: [[f32; 4]; 4],
    /// Rows from the bottom.
    texels: &'a [[u8; 4]],
}

impl Pipeline for Textured<'_> {
    type Vertex = Vertex;
    type VsOut = (f32, f32);
    type Pixel = [u8; 4];

    #[inline(always)]
    fn vert(&self, (position, [u, v, _]): &Vertex) -> ([f32; 4], (f32, f32)) {
        (transform(&self.camera, *position), (*u, *v))
    }

    #[inline(always)]
    fn frag(&self, (u, v): &(f32, f32)) -> [u8; 4] {
        let [x, y] = [u, v].map(|c| (c * TEXTURE_SIDE as f32).floor() as i32 as u32 % TEXTURE_SIDE);
        self.texels[(y * TEXTURE_SIDE + x) as usize]
    }
}

struct Coloured {
    camera: [[f32; 4]; 4],
}

impl Pipeline for Coloured {
    type Vertex = Vertex;
    type VsOut = ((f32, f32), f32);
    type Pixel = [u8; 4];

    #[inline(always)]
    fn vert(&self, (position, [r, g, b]): &Vertex) -> ([f32; 4], Self::VsOut) {
        (transform(&self.camera, *position), ((*r, *g), *b))
    }

    #[inline(always)]
    fn frag(&self, ((r, g), b): &Self::VsOut) -> [u8; 4] {
        [byte(*r), byte(*g), byte(*b), 255]
    }
}

/// A scene as euc takes it.
pub(crate) struct Renderer {
    camera: [[f32; 4]; 4],
    /// Three vertices a triangle.
    runs: Vec<(Look, Vec<Vertex>)>,
    textures: Vec<Vec<[u8; 4]>>,
    colour: Buffer2d<[u8; 4]>,
    depth: Buffer2d<f32>,
}

impl Renderer {
    pub(crate) fn new(scene: &Scene) -> Self {
        let side = TEXTURE_SIDE as usize;
        let flipped = |rows: &Vec<[u8; 4]>| rows.rchunks_exact(side).flatten().copied().collect();
        let size = [scene.size.0 as usize, scene.size.1 as usize];
        let runs = runs(scene).map(|(look, faces)| {
            let triangles = faces.iter().flat_map(|face| fan(scene, *face));
            let corners = triangles.map(|t| t.map(|i| scene.corners[i as usize]));
            (look, corners.flat_map(|corners| before_the_eye(scene, corners)).collect())
        });
        Self {
            camera: rows(scene),
            runs: runs.collect(),
            textures: scene.textures.iter().map(flipped).collect(),
            colour: Buffer2d::new(size, [0; 4]),
            depth: Buffer2d::new(size, 1.0),
        }
    }

    /// A frame.
    pub(crate) fn draw(&mut self) {
        let Self { camera, runs, textures, colour, depth } = self;
        colour.clear([0; 4]);
        depth.clear(1.0);
        for (look, vertices) in runs {
            match look {
                Look::Textured(i) => Textured { camera: *camera, texels: &textures[*i] }
                    .draw::<Filled<'_>, _>(vertices, colour, Some(depth)),
                Look::Coloured => Coloured { camera: *camera }.draw::<Filled<'_>, _>(
                    vertices,
                    colour,
                    Some(depth),
                ),
            }
        }
    }
}

/// The part of a triangle with w >= near, as triangles.
fn before_the_eye(scene: &Scene, corners: [Corner; 3]) -> Vec<Vertex> {
    let w = scene.camera.row(3);
    let distance = |c: &Corner| {
        let [x, y, z] = c.position;
        w.x * x + w.y * y + w.z * z + w.w - scene.near
    };
    let mut kept: Vec<Corner> = Vec::new();
    for (i, corner) in corners.iter().enumerate() {
        let next = &corners[(i + 1) % 3];
        let (d, e) = (distance(corner), distance(next));
        if d >= 0.0 {
            kept.push(*corner);
        }
        if (d >= 0.0) != (e >= 0.0) {
            let t = d / (d - e);
            let [p, q] = [corner, next].map(|c| c.position);
            let [r, s] = [corner, next].map(|c| c.attributes);
            kept.push(Corner {
                position: [0, 1, 2].map(|k| p[k] + t * (q[k] - p[k])),
                attributes: [0, 1, 2].map(|k| r[k] + t as f32 * (s[k] - r[k])),
            });
        }
    }
    let fan = (1..kept.len().max(2) - 1).flat_map(|i| [kept[0], kept[i], kept[i + 1]]);
    fan.map(|corner| (position(&corner), corner.attributes)).collect()
}
