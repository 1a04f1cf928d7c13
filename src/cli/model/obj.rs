//! The OBJ reader: from text to positions, attributes and faces, as the file has them.
//!
//! N-gons stay whole. Lines, points, curves, groups and smoothing are passed over. What a face
//! means (flat, convex, which material) is none of its business; that all of its indices name
//! something is.
//!
//! Of files in the wild it takes: any line ends, continued lines, bytes of any encoding in
//! comments and names, `v` with a weight or with a colour, texture coordinates of one to three
//! numbers, `f` with and without texture and normal indices, mixed, negative, and of vertices
//! that come later.

use std::collections::HashMap;
use std::io::BufRead;
use std::path::Path;

use crate::failure::{Failure, Place};
use crate::text::{self, Lines, quoted, words};

/// An index that is not there.
pub(crate) const ABSENT: u32 = u32::MAX;

/// A file's contents. Every index names something, or is [`ABSENT`].
#[derive(Debug, Default)]
pub(crate) struct Obj {
    /// Of `v`.
    pub(crate) positions: Vec<[f64; 3]>,
    /// Of `v`; as many as positions, or none at all. Vertices without one among others that
    /// have one are white.
    pub(crate) colors: Vec<[f32; 3]>,
    /// Of `vt`.
    pub(crate) uvs: Vec<[f32; 2]>,
    /// Of `vn`.
    pub(crate) normals: Vec<[f32; 3]>,
    /// Corners of all faces, one after the other.
    pub(crate) corners: Corners,
    /// Where in `corners` each face ends. Faces of fewer than three vertices are left out.
    pub(crate) face_ends: Vec<u32>,
    /// From which face on which material (an index into `material_names`) is used, in order.
    pub(crate) material_uses: Vec<(usize, usize)>,
    /// Of `usemtl`, and the line it is first used on.
    pub(crate) material_names: Vec<(Vec<u8>, u64)>,
    /// What follows each `mtllib`, and its line.
    pub(crate) libraries: Vec<(Vec<u8>, u64)>,
}

/// Indices into positions, texture coordinates and normals, for each corner of each face.
#[derive(Debug, Default)]
pub(crate) struct Corners {
    /// Never [`ABSENT`].
    pub(crate) position: Vec<u32>,
    /// [`ABSENT`] at corners without.
    pub(crate) uv: Vec<u32>,
    /// [`ABSENT`] at corners without.
    pub(crate) normal: Vec<u32>,
}

impl Corners {
    /// How many corners there are.
    pub(crate) fn len(&self) -> usize {
        self.position.len()
    }

    fn push(&mut self, [position, uv, normal]: [u32; 3]) {
        self.position.push(position);
        self.uv.push(uv);
        self.normal.push(normal);
    }

    /// Adds corner `i` once more.
    pub(crate) fn repeat(&mut self, i: usize) {
        self.push([self.position[i], self.uv[i], self.normal[i]]);
    }

    fn truncate(&mut self, len: usize) {
        self.position.truncate(len);
        self.uv.truncate(len);
        self.normal.truncate(len);
    }
}

/// What an index is of: positions, texture coordinates, normals.
const KINDS: [(&str, &str); 3] =
    [("position", "v"), ("texture coordinate", "vt"), ("normal", "vn")];

/// Reads a file, which messages call `path`; `progress` is told now and then how many bytes are done.
pub(crate) fn parse<R: BufRead>(
    lines: Lines<R>,
    path: &Path,
    mut progress: impl FnMut(u64),
) -> Result<Obj, Failure> {
    const PROGRESS_LINES: u64 = 1 << 14;
    let mut lines = lines.with_continuations();
    let mut reader = Reader::default();
    let mut empty = true;
    while let Some(line) = lines.next()? {
        empty &= line.trim_ascii().is_empty();
        let result = reader.statement(line);
        let number = lines.number();
        if let Err(message) = result {
            return Err(Failure::at(lines.place(), message));
        }
        reader.settle_line(number);
        if number.is_multiple_of(PROGRESS_LINES) {
            progress(lines.bytes());
        }
    }
    if empty {
        return Err(Failure::at(Place::file(path), "the file is empty: give a model"));
    }
    reader.finish(path)
}

#[derive(Debug, Default)]
struct Reader {
    obj: Obj,
    /// Where in `material_names` each name is.
    materials: HashMap<Vec<u8>, usize>,
    /// The greatest index of each kind that named nothing yet when it was read.
    forward: [Option<Forward>; 3],
    /// The same of the line at hand, whose number is not known within it.
    forward_here: [Option<u32>; 3],
}

/// An index that names something which comes later, or nothing.
#[derive(Clone, Copy, Debug)]
struct Forward {
    /// From 0.
    index: u32,
    line: u64,
}

impl Reader {
    /// Takes one line, or says what is wrong with it.
    fn statement(&mut self, line: &[u8]) -> Result<(), String> {
        let (keyword, rest) = text::keyword(line);
        // Names may have a `#` in them, and spaces; all else ends where a comment begins.
        match keyword {
            b"mtllib" => self.obj.libraries.push((rest.to_owned(), 0)),
            b"usemtl" => self.use_material(rest),
            _ => {
                let rest = text::without_comment(rest);
                match keyword {
                    b"v" => self.vertex(rest)?,
                    b"vt" => self.obj.uvs.push(uv(rest)?),
                    b"vn" => self.obj.normals.push(normal(rest)?),
                    b"f" | b"fo" => self.face(rest)?,
                    _ => ignored(keyword)?,
                }
            }
        }
        Ok(())
    }

    fn use_material(&mut self, name: &[u8]) {
        let names = &mut self.obj.material_names;
        let material = self.materials.get(name).copied().unwrap_or_else(|| {
            self.materials.insert(name.to_owned(), names.len());
            names.push((name.to_owned(), 0));
            names.len() - 1
        });
        self.obj.material_uses.push((self.obj.face_ends.len(), material));
    }

    fn vertex(&mut self, rest: &[u8]) -> Result<(), String> {
        const WHITE: [f32; 3] = [1.0; 3];
        let mut numbers = [0.0_f64; 7];
        let position_and_color = match numbers_of(rest, &mut numbers)? {
            // A fourth number is a weight, which polygons do not have; a seventh is alpha.
            3 | 4 => None,
            #[expect(clippy::cast_possible_truncation, reason = "colours are f32")]
            6 | 7 => Some([numbers[3] as f32, numbers[4] as f32, numbers[5] as f32]),
            n => {
                return Err(format!(
                    "a vertex of {n} numbers: give x y z, x y z w, or x y z red green blue"
                ));
            }
        };
        let obj = &mut self.obj;
        if let Some(color) = position_and_color {
            obj.colors.resize(obj.positions.len(), WHITE);
            obj.colors.push(color);
        } else if !obj.colors.is_empty() {
            obj.colors.push(WHITE);
        }
        obj.positions.push([numbers[0], numbers[1], numbers[2]]);
        Ok(())
    }

    fn face(&mut self, rest: &[u8]) -> Result<(), String> {
        let start = self.obj.corners.len();
        for word in words(rest) {
            let corner = self.corner(word)?;
            self.obj.corners.push(corner);
        }
        let corners = &mut self.obj.corners;
        if corners.len() - start < 3 {
            corners.truncate(start);
            return Ok(());
        }
        let too_many = "more than 4 294 967 294 corners: split the model";
        let end = u32::try_from(corners.len()).ok().filter(|end| *end != ABSENT).ok_or(too_many)?;
        self.obj.face_ends.push(end);
        Ok(())
    }

    /// `1`, `1/2`, `1//3` or `1/2/3`.
    fn corner(&mut self, word: &[u8]) -> Result<[u32; 3], String> {
        let mut corner = [ABSENT; 3];
        let mut parts = word.split(|byte| *byte == b'/');
        for (kind, index) in corner.iter_mut().enumerate() {
            match parts.next() {
                Some(b"") if kind > 0 => {}
                Some(part) => *index = self.index(part, kind, word)?,
                None => {}
            }
        }
        if parts.next().is_some() {
            return Err(format!("{} is no corner of a face: too many slashes", quoted(word)));
        }
        Ok(corner)
    }

    fn index(&mut self, part: &[u8], kind: usize, word: &[u8]) -> Result<u32, String> {
        let count = match kind {
            0 => self.obj.positions.len(),
            1 => self.obj.uvs.len(),
            _ => self.obj.normals.len(),
        } as u64;
        let given: i64 = text::number(part).ok_or_else(|| {
            format!(
                "{} is no corner of a face: give indices as in 1, 1/2, 1//3 or 1/2/3",
                quoted(word)
            )
        })?;
        if given < 0 {
            let back = given.unsigned_abs();
            return count.checked_sub(back).and_then(|i| u32::try_from(i).ok()).ok_or_else(|| {
                let (what, statement) = KINDS[kind];
                format!(
                    "{what} index {given} is out of range: {count} `{statement}` lines came before"
                )
            });
        }
        let index = u32::try_from(given - 1).ok().filter(|index| *index != ABSENT);
        let index = index.ok_or_else(|| {
            let (what, _) = KINDS[kind];
            format!("{what} index {given} is out of range: indices begin at 1")
        })?;
        if u64::from(index) >= count {
            let here = &mut self.forward_here[kind];
            *here = (*here).max(Some(index));
        }
        Ok(index)
    }

    /// Gives whatever the line at hand left its `number`.
    fn settle_line(&mut self, number: u64) {
        for (here, greatest) in self.forward_here.iter_mut().zip(&mut self.forward) {
            if let Some(index) = here.take()
                && greatest.is_none_or(|greatest| index > greatest.index)
            {
                *greatest = Some(Forward { index, line: number });
            }
        }
        for list in [&mut self.obj.material_names, &mut self.obj.libraries] {
            if let Some((_, line @ 0)) = list.last_mut() {
                *line = number;
            }
        }
    }

    fn finish(self, path: &Path) -> Result<Obj, Failure> {
        let obj = self.obj;
        let counts = [obj.positions.len(), obj.uvs.len(), obj.normals.len()];
        for ((forward, count), (what, statement)) in self.forward.iter().zip(counts).zip(KINDS) {
            if let Some(Forward { index, line }) = *forward
                && index as usize >= count
            {
                return Err(Failure::at(
                    Place::line(path, line),
                    format!(
                        "{what} index {} is out of range: the file has {count} `{statement}` \
                         lines; is it cut short?",
                        u64::from(index) + 1
                    ),
                ));
            }
        }
        if obj.face_ends.is_empty() {
            return Err(Failure::at(
                Place::file(path),
                "the model has no face (`f` with three vertices or more): there is nothing to draw",
            ));
        }
        Ok(obj)
    }
}

fn uv(rest: &[u8]) -> Result<[f32; 2], String> {
    let mut numbers = [0.0_f32; 3];
    match numbers_of(rest, &mut numbers)? {
        1..=3 => Ok([numbers[0], numbers[1]]),
        n => Err(format!("a texture coordinate of {n} numbers: give u, u v, or u v w")),
    }
}

fn normal(rest: &[u8]) -> Result<[f32; 3], String> {
    let mut numbers = [0.0_f32; 3];
    match numbers_of(rest, &mut numbers)? {
        3 => Ok(numbers),
        n => Err(format!("a normal of {n} numbers: give x y z")),
    }
}

/// Reads the numbers of a line into `numbers`, and gives how many the line has: maybe more.
fn numbers_of<T: std::str::FromStr>(rest: &[u8], numbers: &mut [T]) -> Result<usize, String> {
    let mut count = 0;
    for word in words(rest) {
        let value = text::number(word).ok_or_else(|| format!("{} is no number", quoted(word)))?;
        if let Some(number) = numbers.get_mut(count) {
            *number = value;
        }
        count += 1;
    }
    Ok(count)
}

/// Passes over a statement that draws nothing, but not over what cannot be OBJ at all.
fn ignored(keyword: &[u8]) -> Result<(), String> {
    let word = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let begins = keyword.first().is_none_or(|first| first.is_ascii_alphabetic() || *first == b'#');
    if begins && (keyword.iter().all(word) || keyword.starts_with(b"#")) {
        return Ok(());
    }
    Err(format!("{} begins no OBJ statement: is this a Wavefront OBJ file?", quoted(keyword)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Obj, String> {
        let path = Path::new("test.obj");
        parse(Lines::new(text.as_bytes(), path), path, |_| {}).map_err(|e| e.to_string())
    }

    fn good(text: &str) -> Obj {
        read_text(text).expect("a good file")
    }

    const THREE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    #[test]
    fn obj_vertices_of_all_kinds() {
        let obj =
            good("v 0 0 0\nv 1 0 0 0.5\nv 0 1 0 .25 .5 1 # c\nv -1 1e0 +0 1 1 1 1\nf 1 2 3 4");
        assert_eq!(obj.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
        assert_eq!(obj.colors, [[1.0; 3], [1.0; 3], [0.25, 0.5, 1.0], [1.0; 3]]);
        assert!(good(&format!("{THREE}f 1 2 3")).colors.is_empty());
        assert!(good("v NaN inf -inf\nv 1 0 0\nv 0 1 0\nf 1 2 3").positions[0][0].is_nan());
    }

    #[test]
    fn obj_corners_of_all_kinds() {
        let text = format!("{THREE}vt .5\nvt 1 2\nvt 1 2 3\nvn 0 0 1\nf 1 2/2 3//1 -3/-1/-1");
        let obj = good(&text);
        assert_eq!(obj.uvs, [[0.5, 0.0], [1.0, 2.0], [1.0, 2.0]]);
        assert_eq!(obj.corners.position, [0, 1, 2, 0]);
        assert_eq!(obj.corners.uv, [ABSENT, 1, ABSENT, 2]);
        assert_eq!(obj.corners.normal, [ABSENT, ABSENT, 0, 0]);
        assert_eq!(obj.face_ends, [4]);
    }

    #[test]
    fn obj_faces_may_come_before_their_vertices() {
        assert_eq!(good(&format!("f 1 2 3\n{THREE}")).corners.position, [0, 1, 2]);
        let late = read_text(&format!("f 1 2 3\nf 1 5 3\nf 1 2 4\n{THREE}")).unwrap_err();
        assert!(late.starts_with("test.obj:2: position index 5 is out of range"), "{late}");
    }

    #[test]
    fn obj_what_draws_nothing_is_passed_over() {
        let text = format!(
            "# \u{FF}\n\ng a b\no c\ns off\nl 1 2\np 1\ncstype bezier\n{THREE}f 1 2\nf 1\nf\n\
             f 1 \\\n2 3\nusemtl Material #25\nusemtl a\nusemtl Material #25\n"
        );
        let obj = good(&text);
        assert_eq!(obj.face_ends, [3]);
        assert_eq!(obj.material_names[0], (b"Material #25".to_vec(), 17));
        assert_eq!(obj.material_uses, [(1, 0), (1, 1), (1, 0)]);
    }

    #[test]
    fn obj_errors_name_the_line() {
        let cases = [
            ("v 1 2", ":4: a vertex of 2 numbers"),
            ("v 1 2 x", ":4: `x` is no number"),
            ("v 1 2 3,5", ":4: `3,5` is no number"),
            ("v 1 2 3 4 5", ":4: a vertex of 5 numbers"),
            ("vt", ":4: a texture coordinate of 0 numbers"),
            ("vn 1 2", ":4: a normal of 2 numbers"),
            ("f 1 2 4", ":4: position index 4 is out of range"),
            ("f 1 2 0", ":4: position index 0 is out of range"),
            ("f 1 2 -4", ":4: position index -4 is out of range"),
            ("f 1/1 2 3", ":4: texture coordinate index 1 is out of range"),
            ("f 1 2 3//9", ":4: normal index 9 is out of range"),
            ("f 1 2 99999999999", ":4: position index 99999999999 is out of range"),
            ("f 1 2 99999999999999999999", ":4: `99999999999999999999` is no corner"),
            ("f 1 2 3/1/1/1", ":4: `3/1/1/1` is no corner"),
            ("f 1 2 /1", ":4: `/1` is no corner"),
            ("f a b c", ":4: `a` is no corner"),
            ("{\"json\": 1}", ":4: `{\\\"json\\\":` begins no OBJ statement"),
            ("\0", ":4: there is a zero byte"),
        ];
        for (line, wanted) in cases {
            let message = read_text(&format!("{THREE}{line}\nf 1 2 3")).unwrap_err();
            assert!(message.contains(wanted), "{line}: {message}");
        }
        assert!(read_text("").unwrap_err().contains("empty"));
        assert!(read_text(THREE).unwrap_err().contains("no face"));
    }
}
