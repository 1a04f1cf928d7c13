//! The MTL reader: materials, or an error that names the file. In full: check/mtl.rs.
#![forbid(unsafe_code)]
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hyperspan_fuzz::targets::mtl(data));
