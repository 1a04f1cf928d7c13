//! The Y loop: spans are what the crossings say, in exact integers. In full: check/edges.rs.
#![forbid(unsafe_code)]
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hyperspan_fuzz::targets::edges(data));
