//! The MTL reader: diffuse colours and diffuse textures. All else that a material may say is
//! passed over, since nothing draws it.

use std::io::BufRead;

use crate::failure::{Failure, Place};
use crate::text::{self, Lines, quoted, words};

/// A material as a file has it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Definition {
    /// Of `newmtl`.
    pub(crate) name: Vec<u8>,
    /// `Kd`: white if the file does not say.
    pub(crate) diffuse: [f32; 3],
    /// `map_Kd`: the picture's file name, and the line that has it.
    pub(crate) map: Option<(Vec<u8>, u64)>,
}

/// Reads all materials; `warn` is told what they ask for that is not built.
pub(crate) fn parse<R: BufRead>(
    lines: Lines<R>,
    mut warn: impl FnMut(&Place, &str),
) -> Result<Vec<Definition>, Failure> {
    let mut lines = lines.with_continuations();
    let mut all: Vec<Definition> = Vec::new();
    while let Some(line) = lines.next()? {
        let (keyword, rest) = text::keyword(line);
        let result = if keyword == b"newmtl" {
            all.push(Definition { name: rest.to_owned(), diffuse: [1.0; 3], map: None });
            Ok(None)
        } else if let Some(material) = all.last_mut() {
            match keyword {
                b"Kd" => diffuse(text::without_comment(rest), material),
                _ if keyword.eq_ignore_ascii_case(b"map_Kd") => map(rest, material),
                _ => Ok(None),
            }
        } else {
            Ok(None)
        };
        let place = lines.place();
        if let Some((_, number @ 0)) = all.last_mut().and_then(|material| material.map.as_mut()) {
            *number = lines.number();
        }
        match result {
            Ok(None) => {}
            Ok(Some(warning)) => warn(&place, &warning),
            Err(message) => return Err(Failure::at(place, message)),
        }
    }
    Ok(all)
}

/// What a statement has to say for itself: nothing, a warning, or an error.
type Verdict = Result<Option<String>, String>;

fn diffuse(rest: &[u8], material: &mut Definition) -> Verdict {
    let mut parts = words(rest);
    let first = parts.next();
    if let Some(kind @ (b"spectral" | b"xyz")) = first {
        return Ok(Some(format!("Kd {} is not built: drawn white", quoted(kind))));
    }
    let values: Vec<f32> = first
        .into_iter()
        .chain(parts)
        .map(|word| text::number(word).ok_or_else(|| format!("{} is no number", quoted(word))))
        .collect::<Result<_, _>>()?;
    material.diffuse = match *values {
        [r, g, b, ..] => [r, g, b],
        // "If only r is specified, g and b are assumed to be equal to r."
        [gray] => [gray; 3],
        _ => return Err(format!("Kd with {} numbers: give red green blue", values.len())),
    };
    Ok(None)
}

/// Takes the file name that follows the options.
fn map(rest: &[u8], material: &mut Definition) -> Verdict {
    let mut rest = rest;
    let mut ignored = Vec::new();
    while rest.starts_with(b"-") {
        let (option, after) = text::keyword(rest);
        let (least, most) = match option {
            b"-o" | b"-s" | b"-t" => (1, 3),
            b"-mm" => (2, 2),
            b"-blendu" | b"-blendv" | b"-cc" | b"-clamp" | b"-texres" | b"-bm" | b"-boost"
            | b"-imfchan" | b"-type" => (1, 1),
            // A file name may begin with a dash.
            _ => break,
        };
        rest = after;
        let mut values = Vec::new();
        for i in 0..most {
            let (value, after) = text::keyword(rest);
            // Optional ones are numbers, and a name must be left over.
            let taken = i < least || (text::number::<f32>(value).is_some() && !after.is_empty());
            if !taken {
                break;
            }
            values.push(value);
            rest = after;
        }
        let changes = match option {
            b"-clamp" => values == [b"on"],
            b"-o" | b"-s" | b"-t" => true,
            _ => false,
        };
        if changes {
            ignored.push(String::from_utf8_lossy(option).into_owned());
        }
    }
    if rest.is_empty() {
        return Err("map_Kd names no file: give the name of a PNG or JPEG picture".to_owned());
    }
    material.map = Some((rest.to_owned(), 0));
    let warning = || format!("{} of map_Kd is not built: drawn without", ignored.join(" and "));
    Ok((!ignored.is_empty()).then(warning))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn read(text: &str) -> Result<Vec<Definition>, String> {
        let lines = Lines::new(text.as_bytes(), Path::new("test.mtl"));
        parse(lines, |_, _| {}).map_err(|e| e.to_string())
    }

    #[test]
    fn mtl_textures_stand_after_options() {
        for (line, name) in [
            ("map_Kd brick.png", "brick.png"),
            ("map_kd my  brick #1.png \r", "my  brick #1.png"),
            ("map_Kd -s 2 2 1 -clamp on -o .5 a b.png", "a b.png"),
            ("map_Kd -mm 0 1 -blendu off -s 2 1.png", "1.png"),
            ("map_Kd -s 1 1 1 7", "7"),
            ("map_Kd -odd.png", "-odd.png"),
        ] {
            let all = read(&format!("newmtl m\n{line}\n")).expect(line);
            assert_eq!(all[0].map, Some((name.as_bytes().to_vec(), 2)), "{line}");
        }
    }

    #[test]
    fn mtl_colours() {
        let all = read("Kd 9 9 9\nnewmtl a b\nKd .5 .25 1 # c\nNs 3\nnewmtl c\nKd .5\nnewmtl d\n");
        let colours: Vec<_> = all.expect("good").into_iter().map(|m| (m.name, m.diffuse)).collect();
        assert_eq!(
            colours,
            [
                (b"a b".to_vec(), [0.5, 0.25, 1.0]),
                (b"c".to_vec(), [0.5; 3]),
                (b"d".to_vec(), [1.0; 3])
            ]
        );
        for (line, wanted) in [
            ("Kd a b c", "test.mtl:2: `a` is no number"),
            ("Kd 1 2", "test.mtl:2: Kd with 2 numbers"),
            ("map_Kd -s 1", "test.mtl:2: map_Kd names no file"),
            ("map_Kd", "test.mtl:2: map_Kd names no file"),
        ] {
            let message = read(&format!("newmtl m\n{line}")).unwrap_err();
            assert!(message.contains(wanted), "{message}");
        }
    }
}
