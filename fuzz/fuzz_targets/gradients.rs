//! Values at pixels against rational oracles: `Exact` is correctly rounded, `Fast` within its bound.
//! In full: check/gradients.rs.
#![forbid(unsafe_code)]
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hyperspan_fuzz::targets::gradients(data));
