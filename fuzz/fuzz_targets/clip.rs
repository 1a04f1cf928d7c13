//! The clipper: what is left is inside of every plane, convex, of the right area, and the same
//! from either side of an edge. In full: check/clip.rs.
#![forbid(unsafe_code)]
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hyperspan_fuzz::targets::clip(data));
