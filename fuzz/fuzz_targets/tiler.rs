//! The whole tiler: no write outside the target, and the same bits by every way. In full: check/tiler.rs.
#![forbid(unsafe_code)]
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hyperspan_fuzz::targets::tiler(data));
