//! Models: files read, materials and textures found, and faces made ready to draw.
//!
//! A face that is flat, convex and affine is one piece: itself. Any other one becomes several
//! pieces, which keep its number. Pieces with the same material and the same kinds of
//! attributes follow each other in runs. Nothing is transformed or drawn here.

mod face;
mod mtl;
mod obj;
mod picture;
mod shelf;
mod triangulate;

use std::collections::BTreeMap;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;
use hyperspan::texture::Texture;

use self::face::{Judge, Verdict};
use self::obj::{ABSENT, Corners};
pub(crate) use self::picture::TextureLimit;
use self::shelf::Shelf;
use crate::camera::Subject;
use crate::failure::{Failure, Place};
use crate::progress::Progress;
use crate::text::Lines;

/// A model, ready to draw.
#[derive(Debug)]
pub(crate) struct Model {
    /// In world space.
    pub(crate) positions: Vec<[f64; 3]>,
    /// One for each position, or none at all.
    pub(crate) colors: Vec<[f32; 3]>,
    /// As in the file, not wrapped.
    pub(crate) uvs: Vec<[f32; 2]>,
    /// As in the file, not normalised.
    pub(crate) normals: Vec<[f32; 3]>,
    /// Corners of all pieces, and of the faces that were cut into them.
    pub(crate) corners: Corners,
    /// What is drawn, in file order.
    pub(crate) pieces: Vec<Piece>,
    /// All pieces, in runs.
    pub(crate) runs: Vec<Run>,
    /// The unit normal of each face, if they were asked for.
    pub(crate) face_normals: Vec<[f32; 3]>,
    /// The materials that faces use; the first is what is drawn without one.
    pub(crate) materials: Vec<Material>,
    /// The textures that materials use.
    pub(crate) textures: Vec<TextureFile>,
    /// What kinds of faces there are.
    pub(crate) census: Census,
}

/// A convex polygon: a face, or a part of one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Its first corner in `corners`; the others follow.
    pub(crate) start: u32,
    /// How many corners it has.
    pub(crate) len: u32,
    /// The number of its face, in file order.
    pub(crate) face: u32,
}

impl Piece {
    /// Its corners' places in `corners`.
    pub(crate) fn corners(self) -> Range<usize> {
        let start = self.start as usize;
        start..start + self.len as usize
    }
}

/// Pieces that are drawn in the same way.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Run {
    /// Which pieces.
    pub(crate) pieces: Range<usize>,
    /// How they look.
    pub(crate) look: Look,
}

/// What decides how a face is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Look {
    /// Index into `materials`.
    pub(crate) material: usize,
    /// Do all corners have texture coordinates?
    pub(crate) has_uvs: bool,
    /// Do all corners have normals?
    pub(crate) has_normals: bool,
}

/// How faces with a material look.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Material {
    /// Its name; empty for what is drawn without one.
    pub(crate) name: String,
    /// `Kd`
    pub(crate) diffuse: [f32; 3],
    /// Index into `textures`.
    pub(crate) texture: Option<usize>,
}

/// A texture, and where it came from.
#[derive(Debug)]
pub(crate) struct TextureFile {
    /// The file.
    pub(crate) path: PathBuf,
    /// What is in it.
    pub(crate) texture: Texture,
}

/// How many faces are of what kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Census {
    /// Number of faces by number of vertices.
    pub(crate) by_vertices: BTreeMap<usize, u64>,
    /// With a vertex that is NaN or infinite: refused when drawn.
    pub(crate) not_finite: u64,
    /// Without area; of the rest:
    pub(crate) degenerate: u64,
    /// not flat,
    pub(crate) not_flat: u64,
    /// not convex,
    pub(crate) not_convex: u64,
    /// with attributes that are not affine.
    pub(crate) not_affine: u64,
}

impl Census {
    fn count(&mut self, vertices: usize, verdict: Verdict) {
        *self.by_vertices.entry(vertices).or_default() += 1;
        let Verdict { finite, degenerate, flat, convex, affine } = verdict;
        if !finite {
            self.not_finite += 1;
        } else if degenerate {
            self.degenerate += 1;
        } else {
            self.not_flat += u64::from(!flat);
            self.not_convex += u64::from(!convex);
            self.not_affine += u64::from(!affine);
        }
    }

    /// All faces.
    pub(crate) fn faces(&self) -> u64 {
        self.by_vertices.values().sum()
    }
}

/// What drawing will ask of a model.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Needs {
    /// The normals of faces.
    pub(crate) face_normals: bool,
    /// Which faces are lit: light is not affine over them even where normals are.
    pub(crate) lit: Lit,
    /// What a texture may take.
    pub(crate) texture_limit: TextureLimit,
}

/// Which faces are lit at their vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Lit {
    /// None is.
    #[default]
    None,
    /// Those that have neither a texture nor vertex colours.
    Bare,
    /// All are.
    All,
}

impl Model {
    /// Reads the model at `path`, and what it names.
    pub(crate) fn read(path: &Path, needs: Needs) -> Result<Self, Failure> {
        let is_obj = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
        let size = match fs::metadata(path) {
            Err(e) => return Err(Failure::io(path, "read", &e)),
            Ok(found) if found.is_dir() => {
                return Err(Failure::at(Place::file(path), "this is a folder: name a model in it"));
            }
            Ok(found) => found.len(),
        };
        if !is_obj {
            return Err(Failure::at(
                Place::file(path),
                "models of this kind cannot be read: give a Wavefront OBJ file (.obj)",
            ));
        }
        let mut progress = Progress::new("reading");
        let obj = obj::parse(Lines::open(path)?, path, |done| progress.set(done, size))?;
        drop(progress);
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut shelf = Shelf::new(folder, needs.texture_limit);
        let material_of = shelf.materials(path, &obj)?;
        let Shelf { materials, textures, .. } = shelf;
        let mut model = Self {
            positions: obj.positions,
            colors: obj.colors,
            uvs: obj.uvs,
            normals: obj.normals,
            corners: obj.corners,
            pieces: Vec::with_capacity(obj.face_ends.len()),
            runs: Vec::new(),
            face_normals: Vec::new(),
            materials,
            textures,
            census: Census::default(),
        };
        model.prepare(path, &obj.face_ends, &obj.material_uses, &material_of, needs)?;
        Ok(model)
    }

    /// Makes pieces of faces.
    fn prepare(
        &mut self,
        path: &Path,
        face_ends: &[u32],
        material_uses: &[(usize, usize)],
        material_of: &[usize],
        needs: Needs,
    ) -> Result<(), Failure> {
        const PROGRESS_FACES: usize = 1 << 12;
        let mut progress = Progress::new("preparing faces");
        let mut judge = Judge::default();
        let mut uses = material_uses.iter().peekable();
        let mut material = 0;
        let mut start = 0;
        for (face, &end) in face_ends.iter().enumerate() {
            if face.is_multiple_of(PROGRESS_FACES) {
                progress.set(face as u64, face_ends.len() as u64);
            }
            while let Some((_, name)) = uses.next_if(|(first, _)| *first <= face) {
                material = material_of[*name];
            }
            let corners = start..end as usize;
            start = end as usize;
            let look = Look {
                material,
                has_uvs: self.corners.uv[corners.clone()].iter().all(|i| *i != ABSENT),
                has_normals: self.corners.normal[corners.clone()].iter().all(|i| *i != ABSENT),
            };
            let first_piece = self.pieces.len();
            let number = u32::try_from(face).map_err(|_| too_large(path))?;
            if needs.face_normals {
                let positions = self.corners.position[corners.clone()].iter();
                let positions = positions.map(|i| self.positions[*i as usize]);
                self.face_normals.push(judge.unit_normal(positions));
            }
            self.cut(&mut judge, number, corners, look, needs.lit)
                .ok_or_else(|| too_large(path))?;
            match self.runs.last_mut() {
                Some(run) if run.look == look => run.pieces.end = self.pieces.len(),
                _ => self.runs.push(Run { pieces: first_piece..self.pieces.len(), look }),
            }
        }
        Ok(())
    }

    /// Adds the pieces of a face; nothing if corners cannot be counted any more.
    fn cut(
        &mut self,
        judge: &mut Judge,
        face: u32,
        corners: Range<usize>,
        look: Look,
        lit: Lit,
    ) -> Option<()> {
        let n = corners.len();
        let verdict = self.judge(judge, corners.clone(), look);
        self.census.count(n, verdict);
        let Verdict { finite, degenerate, flat, convex, affine } = verdict;
        // What has no area, or no place, is the tiler's to leave out.
        let can_be_cut = n > 3 && finite && !degenerate;
        if can_be_cut && !(flat && convex) {
            let triangles = triangulate::triangulate(judge.projected());
            if !triangles.is_empty() {
                for triangle in triangles {
                    self.add(face, triangle.map(|corner| corners.start + corner))?;
                }
                return Some(());
            }
        }
        if can_be_cut && (!affine || self.light_varies(corners.clone(), look, lit)) {
            let least = corners.clone().min_by_key(|corner| self.corners.position[*corner])?;
            let around = |i: usize| corners.start + (least - corners.start + i) % n;
            for i in 1..n - 1 {
                self.add(face, [least, around(i), around(i + 1)])?;
            }
            return Some(());
        }
        let (start, len) = (u32::try_from(corners.start).ok()?, u32::try_from(n).ok()?);
        self.pieces.push(Piece { start, len, face });
        Some(())
    }

    /// Adds a triangle whose corners are copies of `corners`.
    fn add(&mut self, face: u32, corners: [usize; 3]) -> Option<()> {
        let start = u32::try_from(self.corners.len()).ok()?;
        for corner in corners {
            self.corners.repeat(corner);
        }
        self.pieces.push(Piece { start, len: 3, face });
        Some(())
    }

    fn judge(&self, judge: &mut Judge, corners: Range<usize>, look: Look) -> Verdict {
        let positions = self.corners.position[corners.clone()].iter();
        let positions = positions.map(|i| self.positions[*i as usize]);
        let has_colors = !self.colors.is_empty();
        let stride = usize::from(look.has_uvs) * 2
            + usize::from(has_colors) * 3
            + usize::from(look.has_normals) * 3;
        // A triangle is flat, convex and affine whatever its attributes are.
        let stride = if corners.len() == 3 { 0 } else { stride };
        let attributes = corners.filter(|_| stride > 0).flat_map(|corner| {
            let uv = look.has_uvs.then(|| self.uvs[self.corners.uv[corner] as usize]);
            let color = has_colors.then(|| self.colors[self.corners.position[corner] as usize]);
            let normal =
                look.has_normals.then(|| self.normals[self.corners.normal[corner] as usize]);
            uv.into_iter()
                .flatten()
                .chain(color.into_iter().flatten())
                .chain(normal.into_iter().flatten())
        });
        judge.judge(positions, attributes, stride)
    }

    /// Is the face lit, and by normals of its own at its corners?
    fn light_varies(&self, corners: Range<usize>, look: Look, lit: Lit) -> bool {
        let normals = &self.corners.normal[corners];
        self.is_lit(look, lit)
            && look.has_normals
            && normals
                .windows(2)
                .any(|pair| self.normals[pair[0] as usize] != self.normals[pair[1] as usize])
    }

    /// The texture of faces that look so, if they can be drawn with one.
    pub(crate) fn texture(&self, look: Look) -> Option<&Texture> {
        let texture = self.materials[look.material].texture.filter(|_| look.has_uvs)?;
        Some(&self.textures[texture].texture)
    }

    /// Are faces that look so lit?
    pub(crate) fn is_lit(&self, look: Look, lit: Lit) -> bool {
        match lit {
            Lit::None => false,
            Lit::Bare => self.colors.is_empty() && self.texture(look).is_none(),
            Lit::All => true,
        }
    }

    /// Least and greatest coordinates of what faces use, as far as it is finite; nothing if
    /// nothing is.
    pub(crate) fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        let mut used = vec![false; self.positions.len()];
        for position in &self.corners.position {
            used[*position as usize] = true;
        }
        let finite = self
            .positions
            .iter()
            .zip(used)
            .filter(|(position, used)| *used && position.iter().all(|x| x.is_finite()));
        finite.map(|(position, _)| *position).fold(None, |bounds, position| {
            let [least, greatest] = bounds.unwrap_or([position; 2]);
            Some([
                [0, 1, 2].map(|axis| least[axis].min(position[axis])),
                [0, 1, 2].map(|axis| greatest[axis].max(position[axis])),
            ])
        })
    }

    /// What a camera is to see: all that faces use, as far as it is finite.
    pub(crate) fn subject(&self) -> Subject<impl Iterator<Item = DVec3> + Clone> {
        let [least, greatest] = self.bounds().unwrap_or_default();
        let middle = [0, 1, 2].map(|axis| f64::midpoint(least[axis], greatest[axis]));
        let centre = DVec3::from_array(middle);
        let used = self.corners.position.iter();
        let points = used
            .map(|position| DVec3::from_array(self.positions[*position as usize]))
            .filter(|point| point.is_finite());
        let distance = |point: DVec3| {
            let [x, y, z] = (point - centre).to_array();
            (x * x + y * y + z * z).sqrt()
        };
        let radius = points.clone().map(distance).fold(0.0, f64::max);
        Subject { centre, radius: if radius > 0.0 { radius } else { 1.0 }, points }
    }

    /// Bytes that the model's own lists and textures hold.
    pub(crate) fn bytes(&self) -> u64 {
        let texels = |file: &TextureFile| {
            let (width, height) = file.texture.size();
            u64::from(width) * u64::from(height) * 4
        };
        let lists = size_of_val(self.positions.as_slice())
            + size_of_val(self.colors.as_slice())
            + size_of_val(self.uvs.as_slice())
            + size_of_val(self.normals.as_slice())
            + self.corners.len() * 3 * size_of::<u32>()
            + size_of_val(self.pieces.as_slice())
            + size_of_val(self.runs.as_slice())
            + size_of_val(self.face_normals.as_slice());
        lists as u64 + self.textures.iter().map(texels).sum::<u64>()
    }
}

fn too_large(path: &Path) -> Failure {
    Failure::at(
        Place::file(path),
        "the model has more than 4 294 967 294 corners once cut into convex pieces: split it",
    )
}
