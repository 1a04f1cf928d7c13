//! The readers of textures: an opaque texture, or an error that names the file. In full: check/pictures.rs.
#![forbid(unsafe_code)]
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hyperspan_fuzz::targets::pictures(data));
