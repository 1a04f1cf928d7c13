//! NumPy's `.npy`: arrays written as `<f4` and `<u4`, and read in any of the plain numeric
//! types, for comparing. No other byte orders, no Fortran order, no structured types.

use std::io::{self, Write};

/// What a `.npy` file begins with.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// An array that was read, its values widened.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Array {
    /// Length of each axis.
    pub(crate) shape: Vec<usize>,
    /// Row-major.
    pub(crate) values: Vec<f64>,
}

/// Writes a header of version 1.0 for `shape` and `kind` ("<f4" or "<u4"), then `words`.
pub(crate) fn write_npy(
    out: &mut dyn Write,
    kind: &str,
    shape: &[usize],
    words: impl Iterator<Item = [u8; 4]>,
) -> io::Result<()> {
    // Magic, version and the header's length take 10 bytes; data begins at a multiple of 64.
    const PREFIX: usize = 10;
    const ALIGNMENT: usize = 64;
    let axes: Vec<String> = shape.iter().map(ToString::to_string).collect();
    let comma = if axes.len() == 1 { "," } else { "" };
    let mut header = format!(
        "{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}{comma}), }}",
        axes.join(", ")
    );
    let end = (PREFIX + header.len() + 1).next_multiple_of(ALIGNMENT);
    header.extend(std::iter::repeat_n(' ', end - PREFIX - header.len() - 1));
    header.push('\n');
    let length = u16::try_from(header.len()).map_err(|_| io::ErrorKind::InvalidInput)?;
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(header.as_bytes())?;
    // In chunks: a call for each word would be slow through `dyn`.
    const CHUNK: usize = 1 << 14;
    let mut chunk = Vec::with_capacity(CHUNK);
    for word in words {
        chunk.extend_from_slice(&word);
        if chunk.len() == CHUNK {
            out.write_all(&chunk)?;
            chunk.clear();
        }
    }
    out.write_all(&chunk)
}

/// Reads an array out of the bytes of a file, or says why it is none.
pub(crate) fn read_npy(bytes: &[u8]) -> Result<Array, String> {
    let cut = || "it is cut short".to_owned();
    let rest = bytes.strip_prefix(MAGIC).ok_or("it does not begin as .npy does")?;
    let (length, rest) = match rest {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        [1..=3, ..] | [] => return Err(cut()),
        [version, ..] => return Err(format!("version {version} of the format is not known")),
    };
    let (header, data) = rest.split_at_checked(length).ok_or_else(cut)?;
    let header = str::from_utf8(header).map_err(|_| "its header is no text")?;

    let kind = value_of(header, "descr").and_then(|v| v.strip_prefix(['\'', '"']));
    let kind = kind.and_then(|v| v.split(['\'', '"']).next()).ok_or("its header has no 'descr'")?;
    if value_of(header, "fortran_order").is_none_or(|v| !v.starts_with("False")) {
        return Err("only arrays in C order can be read".to_owned());
    }
    let shape = value_of(header, "shape").and_then(|v| v.strip_prefix('('));
    let shape = shape.and_then(|v| v.split(')').next()).ok_or("its header has no 'shape'")?;
    let shape = shape
        .split(',')
        .map(str::trim)
        .filter(|axis| !axis.is_empty())
        .map(|axis| axis.parse().map_err(|_| format!("`{axis}` is no length of an axis")))
        .collect::<Result<Vec<usize>, _>>()?;

    let (size, widen): (usize, fn(&[u8]) -> f64) = match kind {
        "<f4" => (4, |b| f64::from(f32::from_le_bytes(take(b)))),
        "<f8" => (8, |b| f64::from_le_bytes(take(b))),
        "|u1" => (1, |b| f64::from(b[0])),
        "<u2" => (2, |b| f64::from(u16::from_le_bytes(take(b)))),
        "<u4" => (4, |b| f64::from(u32::from_le_bytes(take(b)))),
        "<i4" => (4, |b| f64::from(i32::from_le_bytes(take(b)))),
        _ => {
            return Err(format!(
                "its values of type {kind:?} cannot be read: save them as '<f4' or '<u4'"
            ));
        }
    };
    let needed = shape.iter().try_fold(size, |all, axis| all.checked_mul(*axis));
    if needed != Some(data.len()) {
        return Err(format!(
            "its header says {shape:?} of type '{kind}', but {} bytes follow",
            data.len()
        ));
    }
    Ok(Array { shape, values: data.chunks_exact(size).map(widen).collect() })
}

/// What follows `'key':` in a header.
fn value_of<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let quoted = [format!("'{key}'"), format!("\"{key}\"")];
    let end = quoted.iter().find_map(|key| Some(header.find(key.as_str())? + key.len()))?;
    Some(header[end..].trim_start().strip_prefix(':')?.trim_start())
}

/// The first `N` bytes of a chunk that has as many.
fn take<const N: usize>(bytes: &[u8]) -> [u8; N] {
    let mut all = [0; N];
    all.copy_from_slice(&bytes[..N]);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(shape: &[usize], values: &[f32]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let words = values.iter().map(|value| value.to_le_bytes());
        write_npy(&mut bytes, "<f4", shape, words).expect("memory");
        bytes
    }

    #[test]
    fn npy_data_begins_at_a_multiple_of_64() {
        for shape in [&[2, 3][..], &[6], &[1, 6, 1], &[16384, 16384, 10_000]] {
            let bytes = written(shape, &[]);
            assert_eq!(bytes.len() % 64, 0);
            assert_eq!(bytes.last(), Some(&b'\n'));
        }
        let bytes = written(&[1, 2], &[1.5, -2.0]);
        assert!(bytes.starts_with(
            b"\x93NUMPY\x01\x00\x76\x00{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2), }"
        ));
        assert_eq!(bytes[128..], [0, 0, 0xC0, 0x3F, 0, 0, 0, 0xC0]);
    }

    #[test]
    fn npy_comes_back_as_it_was() {
        let array = Array { shape: vec![2, 1, 3], values: vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0] };
        let bytes = written(&array.shape, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(read_npy(&bytes), Ok(array));
        assert_eq!(read_npy(&written(&[2, 2, 0], &[])).map(|a| a.values.len()), Ok(0));
    }

    #[test]
    fn npy_that_lies_is_refused() {
        let good = written(&[2, 2], &[0.0; 4]);
        for end in 0..good.len() {
            assert!(read_npy(&good[..end]).is_err(), "cut at {end}");
        }
        assert!(read_npy(&written(&[usize::MAX, usize::MAX], &[0.0; 4])).is_err());
        for (from, to) in
            [("<f4", ">f4"), ("False", "True "), ("(2, 2)", "(2, x)"), ("shape", "shop ")]
        {
            let text = str::from_utf8(&good[10..128]).expect("ASCII").replacen(from, to, 1);
            let mut bad = good.clone();
            bad[10..128].copy_from_slice(text.as_bytes());
            assert!(read_npy(&bad).is_err(), "{to}");
        }
    }
}
