//! What every reader of text must hold.

use std::fmt::Debug;
use std::io::{BufRead, BufReader, Cursor};
use std::path::Path;

use super::bytes::Bytes;
use crate::failure::Failure;
use crate::text::Lines;

/// The file's name in messages.
pub(super) const NAME: &str = "fuzzed";

/// Reads `data` with `parse`: at once and in pieces of a few bytes, with line ends of one kind
/// and of the other, it is the same or the same error, which names the file.
pub(super) fn read<T: Debug>(
    data: &[u8],
    parse: impl Fn(Lines<Box<dyn BufRead>>) -> Result<T, Failure>,
) -> Option<T> {
    let parse = |data: Vec<u8>, piece: usize| {
        let input = Box::new(BufReader::with_capacity(piece, Cursor::new(data)));
        parse(Lines::new(input, Path::new(NAME))).map_err(|failure| failure.to_string())
    };
    let result = parse(data.to_vec(), data.len().max(1));
    let shown = format!("{result:?}");
    let piece = 1 + usize::from(Bytes(data).byte() % 8);
    let in_pieces = parse(data.to_vec(), piece);
    assert_eq!(format!("{in_pieces:?}"), shown, "in pieces of {piece} bytes");
    if !data.contains(&b'\r') {
        let mut other = Vec::new();
        for byte in data {
            other.extend(if *byte == b'\n' { &b"\r\n"[..] } else { std::slice::from_ref(byte) });
        }
        assert_eq!(format!("{:?}", parse(other, 64)), shown, "with other line ends");
    }
    if let Err(message) = &result {
        assert!(message.starts_with(NAME), "{message}");
        assert!(message.len() < 600 && !message.contains(char::is_control), "{message:?}");
    }
    result.ok()
}

/// Does a list of this capacity hold no more than a file of `len` bytes is worth?
#[track_caller]
pub(super) fn check_size<T>(list: &Vec<T>, len: usize) {
    let (bytes, most) = (list.capacity() * size_of::<T>(), 64 * len + 1024);
    assert!(bytes <= most, "{bytes} bytes of {}, for a file of {len}", std::any::type_name::<T>());
}
