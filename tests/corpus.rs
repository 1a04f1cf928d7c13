//! Replays fuzz/corpus on stable: what the fuzzer kept, and every input that once failed.

#[path = "../fuzz/check/mod.rs"]
mod check;
#[cfg(feature = "cli")]
#[path = "../src/cli/model/face/mod.rs"]
mod face;
#[path = "../src/cli/failure.rs"]
#[expect(dead_code, reason = "the program uses the rest")]
mod failure;
#[path = "../src/cli/model/mtl.rs"]
mod mtl;
#[path = "../src/cli/model/obj.rs"]
#[expect(dead_code, reason = "the program uses the rest")]
mod obj;
#[expect(dead_code, reason = "each test file uses a part of it")]
mod oracle;
#[cfg(feature = "cli")]
#[path = "../src/cli/model/picture.rs"]
#[expect(dead_code, reason = "the program uses the rest")]
mod picture;
#[path = "../src/cli/poly.rs"]
mod poly;
#[path = "../src/cli/text.rs"]
#[expect(dead_code, reason = "the program uses the rest")]
mod text;
#[cfg(feature = "cli")]
#[path = "../src/cli/model/triangulate.rs"]
mod triangulate;

use std::fs;
use std::path::Path;

/// Calls `body` with every file of fuzz/corpus/`name`, in order.
fn replay(name: &str, body: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(name);
    let entries = fs::read_dir(&folder).expect("a folder of inputs");
    let mut files: Vec<_> = entries.map(|entry| entry.expect("readable").path()).collect();
    files.sort();
    assert!(!files.is_empty(), "no inputs in {}", folder.display());
    for file in files {
        let data = fs::read(&file).expect("readable");
        // A failure names the file.
        let shown = file.display().to_string();
        let guard = Named(&shown);
        body(&data);
        drop(guard);
    }
}

/// Says which input it was if the test ends while it is alive.
struct Named<'a>(&'a str);

impl Drop for Named<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("the input that failed: {}", self.0);
        }
    }
}

#[test]
fn corpus_of_the_clipper_holds() {
    replay("clip", check::clip::clip);
}

#[test]
fn corpus_of_the_division_holds() {
    replay("divide", check::divide::divided);
}

#[test]
fn corpus_of_the_gradients_holds() {
    replay("gradients", check::gradients::gradients);
}

#[test]
fn corpus_of_the_edges_holds() {
    replay("edges", check::edges::edges);
}

#[test]
fn corpus_of_the_tiler_holds() {
    replay("tiler", check::tiler::tiler);
}

#[test]
fn corpus_of_numbers_of_attributes_holds() {
    replay("counts", check::counts::counts);
}

#[test]
fn corpus_of_texture_lookups_holds() {
    replay("texture", check::texture::texture);
}

#[test]
fn corpus_of_the_poly_reader_holds() {
    replay("poly", check::poly::poly);
}

#[test]
fn corpus_of_the_obj_reader_holds() {
    replay("obj", check::obj::obj);
}

#[test]
fn corpus_of_the_mtl_reader_holds() {
    replay("mtl", check::mtl::mtl);
}

#[cfg(feature = "cli")]
#[test]
fn corpus_of_faces_holds() {
    replay("faces", check::faces::faces);
}

#[cfg(feature = "cli")]
#[test]
fn corpus_of_the_picture_readers_holds() {
    replay("pictures", check::pictures::pictures);
}

/// Bytes without a plan, so that something is tested even where the corpus goes stale.
#[test]
fn corpus_of_pseudorandom_bytes_holds() {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut data = [0_u8; 512];
    for round in 0..2000 {
        for byte in &mut data {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            *byte = (state >> 56) as u8;
        }
        let shown = format!("pseudorandom bytes, round {round}");
        let guard = Named(&shown);
        check::tiler::tiler(&data);
        check::clip::clip(&data);
        check::divide::divided(&data);
        check::edges::edges(&data);
        check::gradients::gradients(&data);
        check::counts::counts(&data);
        check::texture::texture(&data);
        check::poly::poly(&data);
        check::obj::obj(&data);
        check::mtl::mtl(&data);
        drop(guard);
    }
}
