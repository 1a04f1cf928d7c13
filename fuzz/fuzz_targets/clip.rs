//! The clipper on any finite polygon and planes: the properties are those of `check::clip`.
#![forbid(unsafe_code)]
#![no_main]

#[path = "../check.rs"]
#[expect(dead_code, reason = "the other targets use the rest")]
mod check;

libfuzzer_sys::fuzz_target!(|data: &[u8]| check::clip(data));
