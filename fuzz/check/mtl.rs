//! The MTL reader on any bytes: materials, or an error that names the file. No panic, no hang;
//! and
//!
//! - it is the same in pieces and with other line ends;
//! - there is a material for each `newmtl`, a texture has a name and a line;
//! - the materials take no more memory than the bytes are worth.

use super::readers::{check_size, read};
use crate::mtl;

pub(crate) fn mtl(data: &[u8]) {
    let Some(materials) = read(data, |lines| mtl::parse(lines, |_, _| {})) else { return };
    let lines = data.iter().filter(|byte| **byte == b'\n').count() + 1;
    assert!(materials.len() <= lines);
    for material in &materials {
        if let Some((name, line)) = &material.map {
            assert!(!name.is_empty() && (1..=lines as u64).contains(line), "line {line}");
        }
    }
    check_size(&materials, data.len());
}
