//! Lines, words and numbers of text files whose bytes nobody vouches for.
//!
//! Bytes, not characters: comments and names may be in any encoding. It knows no format.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::failure::{Failure, Place};

/// The lines of a text file, one at a time, with their numbers.
#[derive(Debug)]
pub(crate) struct Lines<R> {
    input: R,
    path: PathBuf,
    text: Vec<u8>,
    /// Number of the first line of `text`, from 1.
    number: u64,
    /// Lines read.
    read: u64,
    /// Bytes read.
    bytes: u64,
    /// Does a `\` at the end of a line join the next one to it?
    joined: bool,
}

impl Lines<BufReader<File>> {
    /// The lines of the file at `path`.
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        let file = File::open(path).map_err(|e| Failure::io(path, "open", &e))?;
        Ok(Self::new(BufReader::with_capacity(1 << 16, file), path))
    }
}

impl<R: BufRead> Lines<R> {
    /// The lines of `input`, which is called `path` in messages.
    pub(crate) fn new(input: R, path: &Path) -> Self {
        let path = path.to_owned();
        Self { input, path, text: Vec::new(), number: 0, read: 0, bytes: 0, joined: false }
    }

    /// The same, but a line that ends in `\` goes on in the next, unless it is a comment (in
    /// which paths may end so).
    pub(crate) fn with_continuations(self) -> Self {
        Self { joined: true, ..self }
    }

    /// The next line, without its end; nothing at the end of the file.
    pub(crate) fn next(&mut self) -> Result<Option<&[u8]>, Failure> {
        self.text.clear();
        self.number = self.read + 1;
        if !self.append_line()? {
            return Ok(None);
        }
        if self.number == 1 && self.text.starts_with(b"\xEF\xBB\xBF") {
            self.text.drain(..3);
        }
        let comment = self.text.trim_ascii_start().starts_with(b"#");
        while self.joined && !comment && self.text.trim_ascii_end().ends_with(b"\\") {
            let end = self.text.trim_ascii_end().len() - 1;
            self.text.truncate(end);
            self.text.push(b' ');
            if !self.append_line()? {
                break;
            }
        }
        Ok(Some(&self.text))
    }

    /// Adds a line of the file to `text`; false at the end of the file.
    fn append_line(&mut self) -> Result<bool, Failure> {
        let mut any = false;
        loop {
            let chunk = match self.input.fill_buf() {
                Ok(chunk) => chunk,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
                Err(e) => return Err(Failure::io(&self.path, "read", &e)),
            };
            if chunk.is_empty() {
                break;
            }
            any = true;
            let end = chunk.iter().position(|byte| *byte == b'\n');
            let part = &chunk[..end.unwrap_or(chunk.len())];
            // Here and not when the line is whole: a device that gives nothing but zeros has
            // no end of line.
            if part.contains(&0) {
                let place = Place::line(&self.path, self.read + 1);
                return Err(Failure::at(place, "there is a zero byte here: this is no text file"));
            }
            self.text.extend_from_slice(part);
            let used = end.map_or(chunk.len(), |end| end + 1);
            self.bytes += used as u64;
            self.input.consume(used);
            if end.is_some() {
                break;
            }
        }
        self.read += u64::from(any);
        Ok(any)
    }

    /// Number of the line that [`next`](Self::next) gave last, from 1; of its first part if it
    /// was continued.
    pub(crate) fn number(&self) -> u64 {
        self.number
    }

    /// Bytes read so far.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The line that was given last, to name in a message.
    pub(crate) fn place(&self) -> Place {
        Place::line(&self.path, self.number)
    }
}

/// The words of a line.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|byte| is_space(*byte)).filter(|word| !word.is_empty())
}

/// `line` up to a word that begins with `#`.
pub(crate) fn without_comment(line: &[u8]) -> &[u8] {
    let starts = |i: &usize| line[*i] == b'#' && (*i == 0 || is_space(line[*i - 1]));
    if !line.contains(&b'#') {
        return line;
    }
    &line[..(0..line.len()).find(starts).unwrap_or(line.len())]
}

/// The first word of a line, and what follows it, without spaces at the ends.
pub(crate) fn keyword(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii();
    let end = line.iter().position(|byte| is_space(*byte)).unwrap_or(line.len());
    (&line[..end], line[end..].trim_ascii_start())
}

/// `word` as a number, or nothing if it is none.
pub(crate) fn number<T: FromStr>(word: &[u8]) -> Option<T> {
    str::from_utf8(word).ok()?.parse().ok()
}

/// `word` as it may stand in a message, whatever its bytes: quoted, escaped, not too long.
pub(crate) fn quoted(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let cut = word.len() > LONGEST;
    let text = String::from_utf8_lossy(&word[..word.len().min(LONGEST)]);
    format!("`{}{}`", text.escape_debug(), if cut { "..." } else { "" })
}

/// The path that a file names: its bytes where the system takes any, else as UTF-8.
pub(crate) fn path_from_bytes(name: &[u8]) -> PathBuf {
    #[cfg(unix)]
    {
        use std::ffi::OsStr;
        use std::os::unix::ffi::OsStrExt;
        PathBuf::from(OsStr::from_bytes(name))
    }
    #[cfg(not(unix))]
    PathBuf::from(String::from_utf8_lossy(name).into_owned())
}

fn is_space(byte: u8) -> bool {
    // Vertical tabs too, which `is_ascii_whitespace` leaves out.
    byte.is_ascii_whitespace() || byte == 0x0B
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &[u8], joined: bool) -> Vec<(u64, Vec<u8>)> {
        let mut lines = Lines { joined, ..Lines::new(text, Path::new("test")) };
        let mut all = Vec::new();
        while let Some(line) = lines.next().expect("readable") {
            let line = line.to_owned();
            all.push((lines.number(), line));
        }
        all
    }

    #[test]
    fn lines_have_the_number_that_an_editor_shows() {
        let of = |text: &[u8]| lines(text, true);
        assert_eq!(
            of(b"\xEF\xBB\xBFa\r\n\nb"),
            [(1, b"a\r".to_vec()), (2, b"".to_vec()), (3, b"b".to_vec())]
        );
        assert_eq!(of(b"f 1 \\\r\n2 \\\n3\nx"), [(1, b"f 1  2  3".to_vec()), (4, b"x".to_vec())]);
        assert_eq!(of(b"# c:\\\nv\n"), [(1, b"# c:\\".to_vec()), (2, b"v".to_vec())]);
        assert_eq!(of(b"end \\"), [(1, b"end  ".to_vec())]);
        assert_eq!(of(b""), []);
    }

    #[test]
    fn words_and_comments_are_bytes() {
        assert_eq!(words(b"\tv  1\x0B2 \r").collect::<Vec<_>>(), [b"v", b"1", b"2"]);
        assert_eq!(without_comment(b"a#b # \xFF"), b"a#b ");
        assert_eq!(keyword(b" mtllib  my file.mtl \r"), (&b"mtllib"[..], &b"my file.mtl"[..]));
        assert_eq!(number::<f32>(b"-inf"), Some(f32::NEG_INFINITY));
        assert_eq!(number::<f32>(b"1,5"), None);
        assert_eq!(quoted(b"a\xFFb\n"), "`a\u{FFFD}b\\n`");
    }
}
