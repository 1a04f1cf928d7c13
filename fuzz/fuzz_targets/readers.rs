//! The OBJ and the `.poly` reader on any bytes: a file whose indices all name something, or an
//! error that names the file; no panic, no hang, and no more memory than the bytes are worth.
#![forbid(unsafe_code)]
#![no_main]

#[path = "../../src/cli/failure.rs"]
#[expect(dead_code, reason = "the program uses the rest")]
mod failure;
#[path = "../../src/cli/model/obj.rs"]
#[expect(dead_code, reason = "the program uses the rest")]
mod obj;
#[path = "../../src/cli/poly.rs"]
mod poly;
#[path = "../../src/cli/text.rs"]
#[expect(dead_code, reason = "the program uses the rest")]
mod text;

use std::path::Path;

use text::Lines;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
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
            assert!(file.polygons().all(|polygon| polygon.end <= file.positions.len()));
        }
    }
});
