//! The whole tiler on any polygons and settings: the properties are those of `check::tiler`.
#![forbid(unsafe_code)]
#![no_main]

#[path = "../check.rs"]
#[expect(dead_code, reason = "the other targets use the rest")]
mod check;

libfuzzer_sys::fuzz_target!(|data: &[u8]| check::tiler(data));
