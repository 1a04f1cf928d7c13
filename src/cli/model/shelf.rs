//! Finds what a model names: material files, materials, textures. What is missing is warned
//! about and left out; what is there but cannot be read is an error.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::mtl::{self, Definition};
use super::obj::Obj;
use super::picture::{self, TextureLimit};
use super::{Material, TextureFile};
use crate::failure::{Failure, Place, warn};
use crate::text::{Lines, path_from_bytes, quoted, words};

/// Finds materials and textures by their names.
#[derive(Debug)]
pub(super) struct Shelf<'a> {
    folder: &'a Path,
    limit: TextureLimit,
    /// Those that were found; the first is what is drawn without one.
    pub(super) materials: Vec<Material>,
    /// Those that the materials use.
    pub(super) textures: Vec<TextureFile>,
    /// Texture files that were looked for, and what became of them.
    seen: HashMap<PathBuf, Option<usize>>,
}

impl<'a> Shelf<'a> {
    /// What a model in `folder` names is looked for there.
    pub(super) fn new(folder: &'a Path, limit: TextureLimit) -> Self {
        let plain = Material { name: String::new(), diffuse: [1.0; 3], texture: None };
        Self { folder, limit, materials: vec![plain], textures: Vec::new(), seen: HashMap::new() }
    }

    /// The material (an index into `materials`) for each name that `obj` uses. What is missing
    /// is warned about and drawn without.
    pub(super) fn materials(&mut self, path: &Path, obj: &Obj) -> Result<Vec<usize>, Failure> {
        let libraries = self.libraries(path, obj)?;
        let mut definitions = HashMap::new();
        for (all, library) in &libraries {
            for definition in all {
                // The first one counts.
                definitions.entry(definition.name.as_slice()).or_insert((definition, library));
            }
        }
        let mut all = Vec::with_capacity(obj.material_names.len());
        for (name, line) in &obj.material_names {
            let Some((definition, library)) = definitions.get(name.as_slice()) else {
                let message = format!("there is no material {}: drawn white", quoted(name));
                warn(&Place::line(path, *line), &message);
                all.push(0);
                continue;
            };
            let texture = match &definition.map {
                Some((file, line)) => self.texture(file, &Place::line(library, *line))?,
                None => None,
            };
            all.push(self.materials.len());
            self.materials.push(Material {
                name: String::from_utf8_lossy(name).into_owned(),
                diffuse: definition.diffuse,
                texture,
            });
        }
        Ok(all)
    }

    /// What is in the material files that `obj` names, each read once.
    fn libraries(
        &self,
        path: &Path,
        obj: &Obj,
    ) -> Result<Vec<(Vec<Definition>, PathBuf)>, Failure> {
        let mut read = Vec::new();
        let mut seen = HashSet::new();
        for (names, line) in &obj.libraries {
            for library in self.library_paths(names) {
                if !seen.insert(library.clone()) {
                    continue;
                }
                match fs::metadata(&library) {
                    Err(e) if picture::is_missing(&e) => {
                        let name = library.display();
                        let message = format!("there is no {name}: drawn without its materials");
                        warn(&Place::line(path, *line), &message);
                    }
                    Err(e) => return Err(Failure::io(&library, "read", &e)),
                    Ok(found) if !found.is_file() => {
                        return Err(Failure::at(Place::file(&library), "this is no regular file"));
                    }
                    Ok(_) => read.push((mtl::parse(Lines::open(&library)?, warn)?, library)),
                }
            }
        }
        Ok(read)
    }

    /// The files that an `mtllib` line names. The format has no quotes: it is one name with
    /// spaces in it if there is such a file, else each name ends in `.mtl`.
    fn library_paths(&self, names: &[u8]) -> Vec<PathBuf> {
        let whole = self.find(names);
        if names.is_empty() || whole.is_file() {
            return if names.is_empty() { Vec::new() } else { vec![whole] };
        }
        let mut all = Vec::new();
        let mut name: Vec<u8> = Vec::new();
        for word in words(names) {
            if !name.is_empty() {
                name.push(b' ');
            }
            name.extend_from_slice(word);
            if word.to_ascii_lowercase().ends_with(b".mtl") {
                all.push(self.find(&std::mem::take(&mut name)));
            }
        }
        if !name.is_empty() {
            all.push(self.find(&name));
        }
        all
    }

    /// The file called `name`: beside the model, also if it was named where folders are
    /// divided by backslashes.
    fn find(&self, name: &[u8]) -> PathBuf {
        let path = self.folder.join(path_from_bytes(name));
        if path.exists() || !name.contains(&b'\\') {
            return path;
        }
        let slashes: Vec<u8> =
            name.iter().map(|byte| if *byte == b'\\' { b'/' } else { *byte }).collect();
        let other = self.folder.join(path_from_bytes(&slashes));
        if other.exists() { other } else { path }
    }

    /// The texture in the file called `name`, which `place` asks for; each file is read once.
    fn texture(&mut self, name: &[u8], place: &Place) -> Result<Option<usize>, Failure> {
        let path = self.find(name);
        if let Some(known) = self.seen.get(&path) {
            return Ok(*known);
        }
        let found = picture::read(&path, self.limit)?.map(|texture| {
            self.textures.push(TextureFile { path: path.clone(), texture });
            self.textures.len() - 1
        });
        if found.is_none() {
            warn(place, &format!("there is no {}: drawn without it", path.display()));
        }
        self.seen.insert(path, found);
        Ok(found)
    }
}
