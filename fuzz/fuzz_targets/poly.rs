//! The `.poly` reader: what was read, written and read again is the same. In full: check/poly.rs.
#![forbid(unsafe_code)]
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hyperspan_fuzz::targets::poly(data));
