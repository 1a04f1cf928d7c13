//! The `.poly` reader: polygons in clip space, as text.
//!
//! ```text
//! # a comment, also behind numbers; a line with only a comment is not blank
//! attrs perspective flat      how each attribute is interpolated; optional, before any vertex
//! zrange -1 1                 the range of z in the view volume; optional, 0 1 if left out
//! -.5 -.5 .5 1   0 7          a vertex: x y z w, then its attributes
//! .5 -.5 .5 1    1 7
//! 0 .6 .5 1      2 7
//!                             one or more blank lines end a polygon
//! ```
//!
//! Nothing is judged here: polygons of one vertex and of NaNs are the tiler's business.

use std::io::BufRead;
use std::ops::Range;
use std::path::Path;

use hyperspan::space::DepthRange;
use hyperspan::varying::Interpolation;

use crate::failure::{Failure, Place};
use crate::text::{self, Lines, quoted, words};

/// The most attributes that a vertex may have.
pub(crate) const MOST_ATTRIBUTES: usize = 10_000;

/// What a file holds.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct PolyFile {
    /// Clip-space positions of all vertices.
    pub(crate) positions: Vec<[f32; 4]>,
    /// Attributes of all vertices, `attribute_count` for each.
    pub(crate) attributes: Vec<f32>,
    /// Attributes of a vertex.
    pub(crate) attribute_count: usize,
    /// Where in `positions` each polygon ends.
    ends: Vec<usize>,
    /// How attributes are interpolated, as far as the file says.
    pub(crate) interpolation: Vec<Interpolation>,
    /// The range of z.
    pub(crate) depth_range: DepthRange,
}

impl PolyFile {
    /// The number of polygons.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    /// Which vertices polygon `i` has, in file order.
    #[inline]
    pub(crate) fn vertices(&self, i: usize) -> Range<usize> {
        let start = i.checked_sub(1).map_or(0, |before| self.ends[before]);
        start..self.ends[i]
    }
}

/// Reads all of it. `path` is its name in messages.
pub(crate) fn parse<R: BufRead>(mut lines: Lines<R>, path: &Path) -> Result<PolyFile, Failure> {
    let mut reader = Reader::default();
    while let Some(line) = lines.next()? {
        let result = reader.line(line);
        if let Err(message) = result {
            return Err(Failure::at(lines.place(), message));
        }
        if let Some(line @ 0) = &mut reader.attrs_line {
            *line = lines.number();
        }
    }
    reader.end_polygon();
    if reader.file.ends.is_empty() {
        return Err(Failure::at(
            Place::file(path),
            "there is no polygon in it: give vertices as lines `x y z w attributes...`",
        ));
    }
    Ok(reader.file)
}

#[derive(Debug, Default)]
struct Reader {
    file: PolyFile,
    /// The line of `attrs`, if there is one; 0 while it is being read.
    attrs_line: Option<u64>,
    has_zrange: bool,
}

impl Reader {
    fn line(&mut self, line: &[u8]) -> Result<(), String> {
        if words(line).next().is_none() {
            self.end_polygon();
            return Ok(());
        }
        let line = text::without_comment(line);
        match text::keyword(line) {
            (b"", _) => Ok(()),
            (b"attrs", rest) => self.attrs(rest),
            (b"zrange", rest) => self.zrange(rest),
            _ => self.vertex(line),
        }
    }

    fn end_polygon(&mut self) {
        let end = self.file.positions.len();
        if end > self.file.ends.last().copied().unwrap_or(0) {
            self.file.ends.push(end);
        }
    }

    fn attrs(&mut self, rest: &[u8]) -> Result<(), String> {
        self.header("attrs", self.attrs_line.is_some())?;
        self.attrs_line = Some(0);
        self.file.interpolation = words(rest)
            .map(|word| match word {
                b"perspective" => Ok(Interpolation::Perspective),
                b"noperspective" => Ok(Interpolation::NoPerspective),
                b"flat" => Ok(Interpolation::Flat),
                _ => Err(format!(
                    "{} is no way to interpolate: give perspective, noperspective or flat",
                    quoted(word)
                )),
            })
            .collect::<Result<_, _>>()?;
        let count = self.file.interpolation.len();
        if count > MOST_ATTRIBUTES {
            return Err(too_many(count));
        }
        Ok(())
    }

    fn zrange(&mut self, rest: &[u8]) -> Result<(), String> {
        self.header("zrange", self.has_zrange)?;
        self.has_zrange = true;
        let ends: Vec<_> = words(rest).map(text::number::<f32>).collect();
        self.file.depth_range = match ends.as_slice() {
            [Some(0.0), Some(1.0)] => DepthRange::ZeroToOne,
            [Some(-1.0), Some(1.0)] => DepthRange::MinusOneToOne,
            _ => return Err("zrange must be `zrange 0 1` or `zrange -1 1`".to_owned()),
        };
        Ok(())
    }

    /// May a header line stand here?
    fn header(&self, name: &str, again: bool) -> Result<(), String> {
        if again {
            return Err(format!("a second `{name}`: one is enough"));
        }
        if !self.file.positions.is_empty() {
            return Err(format!("`{name}` must stand before the first vertex"));
        }
        Ok(())
    }

    fn vertex(&mut self, line: &[u8]) -> Result<(), String> {
        let file = &mut self.file;
        let first = file.positions.is_empty();
        let mut position = [0.0; 4];
        let before = file.attributes.len();
        let mut count = 0;
        for word in words(line) {
            let number: f32 =
                text::number(word).ok_or_else(|| format!("{} is no number", quoted(word)))?;
            match position.get_mut(count) {
                Some(coordinate) => *coordinate = number,
                None => file.attributes.push(number),
            }
            count += 1;
        }
        if count < 4 {
            return Err(format!("a vertex of {count} numbers: it needs x y z w"));
        }
        let count = file.attributes.len() - before;
        if count > MOST_ATTRIBUTES {
            return Err(too_many(count));
        }
        if let Some(line) = self.attrs_line
            && count != file.interpolation.len()
        {
            return Err(format!(
                "this vertex has {count} attributes, but `attrs` (line {line}) names {}",
                file.interpolation.len()
            ));
        }
        if !first && count != file.attribute_count {
            return Err(format!(
                "this vertex has {count} attributes, but the first one has {}: give all the same",
                file.attribute_count
            ));
        }
        file.attribute_count = count;
        file.positions.push(position);
        Ok(())
    }
}

fn too_many(count: usize) -> String {
    format!("{count} attributes are too many: give {MOST_ATTRIBUTES} at most")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<PolyFile, String> {
        let path = Path::new("test.poly");
        parse(Lines::new(text.as_bytes(), path), path).map_err(|e| e.to_string())
    }

    #[test]
    fn poly_polygons_end_at_blank_lines_and_not_at_comments() {
        let file = read(
            "\n# head\nattrs perspective  flat # two\r\nzrange -1 1\n\n1 2 3 4 5 6\n# not blank\n\
             inf NaN -0 1e-3 7 8 # c\n\t \n \n.5 .5 .5 1 9 10",
        )
        .expect("a good file");
        assert_eq!((0..file.len()).map(|i| file.vertices(i)).collect::<Vec<_>>(), [0..2, 2..3]);
        assert_eq!(file.attributes, [5.0, 6.0, 7.0, 8.0, 9.0, 10.0]);
        assert_eq!(file.attribute_count, 2);
        assert_eq!(file.interpolation, [Interpolation::Perspective, Interpolation::Flat]);
        assert_eq!(file.depth_range, DepthRange::MinusOneToOne);
        assert_eq!(file.positions[1][0], f32::INFINITY);
        assert!(file.positions[1][1].is_nan());
    }

    #[test]
    fn poly_errors_name_the_line() {
        for (text, wanted) in [
            ("0 0 0 1 1\n0 0 0 1\n", "test.poly:2: this vertex has 0 attributes, but the first"),
            (
                "attrs flat\n0 0 0 1\n",
                "test.poly:2: this vertex has 0 attributes, but `attrs` (line 1) names 1",
            ),
            ("0 0 0 1\nattrs\n", "test.poly:2: `attrs` must stand before"),
            ("attrs\nattrs\n", "test.poly:2: a second `attrs`"),
            ("attrs smooth\n", "test.poly:1: `smooth` is no way"),
            ("zrange 0 2\n", "test.poly:1: zrange must be"),
            ("0 0 0\n", "test.poly:1: a vertex of 3 numbers"),
            ("# c\n\n0 0 x 1\n", "test.poly:3: `x` is no number"),
            ("# c\n\n", "test.poly: there is no polygon"),
            ("", "test.poly: there is no polygon"),
        ] {
            let message = read(text).unwrap_err();
            assert!(message.starts_with(wanted), "{text}: {message}");
        }
        let many = format!("0 0 0 1{}", " 1".repeat(MOST_ATTRIBUTES + 1));
        assert!(read(&many).unwrap_err().contains("too many"));
    }
}
