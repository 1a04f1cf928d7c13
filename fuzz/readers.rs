//! What the readers must hold on any bytes, OBJ and `.poly`: a file whose indices all name
//! something, or an error that names the file; no panic, no hang, and no more memory than the
//! bytes are worth.
//!
//! Called by fuzz_targets/readers.rs and by tests/corpus.rs. The readers are the program's, and
//! no library: who calls this has their files as modules of its own.

use std::path::Path;

use crate::text::Lines;
use crate::{obj, poly};

pub(crate) fn readers(data: &[u8]) {
    let path = Path::new("fuzzed");
    match obj::parse(Lines::new(data, path), path, |_| {}) {
        Err(failure) => assert!(failure.to_string().contains("fuzzed"), "{failure}"),
        Ok(obj) => {
            let corners = &obj.corners;
            assert!(corners.position.iter().all(|i| (*i as usize) < obj.positions.len()));
            let known = |i: &u32, n: usize| *i == obj::ABSENT || (*i as usize) < n;
            assert!(corners.uv.iter().all(|i| known(i, obj.uvs.len())));
            assert!(corners.normal.iter().all(|i| known(i, obj.normals.len())));
            assert!(obj.face_ends.is_sorted());
            assert!(corners.len() <= data.len() && obj.positions.len() <= data.len());
        }
    }
    match poly::parse(Lines::new(data, path), path) {
        Err(failure) => assert!(failure.to_string().contains("fuzzed"), "{failure}"),
        Ok(file) => {
            assert_eq!(file.attributes.len(), file.positions.len() * file.attribute_count);
            assert!((0..file.len()).all(|i| file.vertices(i).end <= file.positions.len()));
        }
    }
}
