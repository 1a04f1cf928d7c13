//! The OBJ reader: indices that all name something, or an error that names the file. In full: check/obj.rs.
#![forbid(unsafe_code)]
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hyperspan_fuzz::targets::obj(data));
