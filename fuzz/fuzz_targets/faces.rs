//! Faces of models: judged the same from any vertex, and cut into triangles of their vertices. In
//! full: check/faces.rs.
#![forbid(unsafe_code)]
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hyperspan_fuzz::targets::faces(data));
