//! The division and the snap: every place on the grid is P1's, in exact integers. In full: check/divide.rs.
#![forbid(unsafe_code)]
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hyperspan_fuzz::targets::divide(data));
