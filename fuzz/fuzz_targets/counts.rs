//! Numbers of attributes known at run time: no attribute depends on how many others there are. In full: check/counts.rs.
#![forbid(unsafe_code)]
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hyperspan_fuzz::targets::counts(data));
