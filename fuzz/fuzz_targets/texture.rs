//! Texture lookups: the texel that the definition names. In full: check/texture.rs.
#![forbid(unsafe_code)]
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hyperspan_fuzz::targets::texture(data));
