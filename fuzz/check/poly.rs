//! The `.poly` reader on any bytes: polygons, or an error that names the file. No panic, no hang;
//! and
//!
//! - it is the same in pieces and with other line ends;
//! - all vertices have as many attributes, all belong to a polygon, and none is empty;
//! - what was read, written out and read again is the same, bit for bit;
//! - the lists take no more memory than the bytes are worth.

use std::fmt::Write;
use std::path::Path;

use hyperspan::space::DepthRange;
use hyperspan::varying::Interpolation;

use super::readers::{NAME, check_size, read};
use crate::poly::{self, PolyFile};

pub(crate) fn poly(data: &[u8]) {
    let path = Path::new(NAME);
    let parse = |lines| poly::parse(lines, path);
    let Some(file) = read(data, parse) else { return };
    assert_eq!(file.attributes.len(), file.positions.len() * file.attribute_count);
    assert!(file.len() > 0);
    let mut next = 0;
    for i in 0..file.len() {
        let vertices = file.vertices(i);
        assert!(vertices.start == next && vertices.end > next, "polygon {i} is {vertices:?}");
        next = vertices.end;
    }
    assert_eq!(next, file.positions.len());
    check_size(&file.positions, data.len());
    check_size(&file.attributes, data.len());
    check_size(&file.interpolation, data.len());

    let again = read(written(&file).as_bytes(), parse).expect("what was written");
    // As text: a NaN is not equal to itself.
    assert_eq!(format!("{again:?}"), format!("{file:?}"), "written and read again");
    let bits = |file: &PolyFile| {
        let numbers = file.positions.iter().flatten().chain(&file.attributes);
        numbers.filter(|n| !n.is_nan()).map(|n| n.to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(bits(&again), bits(&file));
}

/// The file as text.
fn written(file: &PolyFile) -> String {
    let mut text = String::new();
    if !file.interpolation.is_empty() {
        text.push_str("attrs");
        for mode in &file.interpolation {
            text.push_str(match mode {
                Interpolation::Perspective => " perspective",
                Interpolation::NoPerspective => " noperspective",
                Interpolation::Flat => " flat",
            });
        }
        text.push('\n');
    }
    if file.depth_range == DepthRange::MinusOneToOne {
        text.push_str("zrange -1 1\n");
    }
    for i in 0..file.len() {
        for vertex in file.vertices(i) {
            let attributes = &file.attributes[vertex * file.attribute_count..];
            let numbers = file.positions[vertex].iter();
            for number in numbers.chain(&attributes[..file.attribute_count]) {
                write!(text, "{number:?} ").expect("a string");
            }
            text.push('\n');
        }
        text.push('\n');
    }
    text
}
