//! retrofire 0.4: clips, scan-converts triangles, divides at each pixel. It keeps 1/w as depth.

use std::collections::HashMap;

use retrofire_core::geom::{Tri, Vertex3, vertex};
use retrofire_core::math::{Color4, ProjMat3, Vec2, Vec3, pt2, pt3, rgba, vec3, viewport};
use retrofire_core::render::tex::{SamplerRepeatPot, Tex, uv};
use retrofire_core::render::{Colorbuf, Context, Frag, Framebuf, Model, Texture, render, shader};
use retrofire_core::util::{Buf2, Dims, pixfmt::Rgba8888};

use super::{byte, fan, position, rows, runs};
use crate::scenes::{Corner, Face, Look, Scene, TEXTURE_SIDE};

type Frame = Framebuf<Colorbuf<Buf2<[u8; 4]>, Rgba8888>, Buf2<f32>>;

/// Triangles that share their vertices.
struct Call<A> {
    triangles: Vec<Tri<usize>>,
    vertices: Vec<Vertex3<A>>,
}

impl<A> Call<A> {
    fn new(scene: &Scene, faces: &[Face], attribute: impl Fn(&Corner) -> A) -> Self {
        let (mut numbers, mut vertices) = (HashMap::new(), Vec::new());
        let mut number = |i: u32| {
            *numbers.entry(i).or_insert_with(|| {
                let corner = &scene.corners[i as usize];
                let [x, y, z] = position(corner);
                vertices.push(vertex(pt3(x, y, z), attribute(corner)));
                vertices.len() - 1
            })
        };
        let triangles = faces.iter().flat_map(|face| fan(scene, *face));
        let triangles = triangles.map(|t| Tri(t.map(&mut number))).collect();
        Self { triangles, vertices }
    }
}

enum Run {
    Textured(usize, Call<Vec2<Tex>>),
    Coloured(Call<Vec3>),
}

/// A scene as retrofire takes it.
pub(crate) struct Renderer {
    camera: ProjMat3<Model>,
    size: (u32, u32),
    runs: Vec<Run>,
    textures: Vec<Texture<Buf2<Color4>>>,
    frame: Frame,
}

impl Renderer {
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut camera = rows(scene);
        // Its y points down, and its depth runs from -w to w.
        camera[1] = camera[1].map(|c| -c);
        camera[2] = [0, 1, 2, 3].map(|k| 2.0 * camera[2][k] - camera[3][k]);
        let runs = runs(scene).map(|(look, faces)| match look {
            Look::Textured(i) => {
                let place = |c: &Corner| uv(c.attributes[0], c.attributes[1]);
                Run::Textured(i, Call::new(scene, faces, place))
            }
            // Its own colours have no perspective.
            Look::Coloured => Run::Coloured(Call::new(scene, faces, |c| {
                let [r, g, b] = c.attributes;
                vec3(r, g, b)
            })),
        });
        let side = TEXTURE_SIDE as usize;
        let texture = |rows: &Vec<[u8; 4]>| {
            let texels =
                rows.rchunks_exact(side).flatten().map(|[r, g, b, a]| rgba(*r, *g, *b, *a));
            Texture::from(Buf2::new_from(Dims(TEXTURE_SIDE, TEXTURE_SIDE), texels))
        };
        let size = Dims(scene.size.0, scene.size.1);
        Self {
            camera: ProjMat3::new(camera),
            size: scene.size,
            runs: runs.collect(),
            textures: scene.textures.iter().map(texture).collect(),
            frame: Framebuf {
                color_buf: Colorbuf::new(Buf2::new(size)),
                depth_buf: Buf2::new(size),
            },
        }
    }

    /// A frame.
    pub(crate) fn draw(&mut self) {
        let Self { camera, size, runs, textures, frame } = self;
        frame.color_buf.buf.data_mut().fill([0; 4]);
        frame.depth_buf.data_mut().fill(0.0);
        let screen = viewport(pt2(0, 0)..pt2(size.0, size.1));
        let context =
            Context { face_cull: None, color_clear: None, depth_clear: None, ..Context::default() };
        for run in runs {
            match run {
                Run::Textured(i, call) => {
                    let texture = &textures[*i];
                    let sampler = SamplerRepeatPot::new(texture);
                    let shader = shader::new(
                        |v: Vertex3<Vec2<Tex>>, m: &ProjMat3<Model>| {
                            vertex(m.apply(&v.pos), v.attrib)
                        },
                        |f: Frag<Vec2<Tex>>, _: &ProjMat3<Model>| sampler.sample(texture, f.var),
                    );
                    let Call { triangles, vertices } = call;
                    render(triangles, vertices, &shader, camera, screen, frame, &context);
                }
                Run::Coloured(call) => {
                    let shader = shader::new(
                        |v: Vertex3<Vec3>, m: &ProjMat3<Model>| vertex(m.apply(&v.pos), v.attrib),
                        |f: Frag<Vec3>, _: &ProjMat3<Model>| {
                            let [r, g, b] = f.var.0.map(byte);
                            rgba(r, g, b, 255)
                        },
                    );
                    let Call { triangles, vertices } = call;
                    render(triangles, vertices, &shader, camera, screen, frame, &context);
                }
            }
        }
    }
}
