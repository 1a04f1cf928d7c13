//! The OBJ and the `.poly` reader on any bytes: the properties are those of `readers::readers`.
#![forbid(unsafe_code)]
#![no_main]

#[path = "../../src/cli/failure.rs"]
#[expect(dead_code, reason = "the program uses the rest")]
mod failure;
#[path = "../../src/cli/model/obj.rs"]
#[expect(dead_code, reason = "the program uses the rest")]
mod obj;
#[path = "../../src/cli/poly.rs"]
mod poly;
#[path = "../readers.rs"]
mod readers;
#[path = "../../src/cli/text.rs"]
#[expect(dead_code, reason = "the program uses the rest")]
mod text;

libfuzzer_sys::fuzz_target!(|data: &[u8]| readers::readers(data));
