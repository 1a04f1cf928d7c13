//! The bodies of the fuzz targets, one function for each: what they check is in check/.
#![forbid(unsafe_code)]

mod check;
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
#[path = "../tests/oracle/mod.rs"]
#[expect(dead_code, reason = "the tests use the rest")]
mod oracle;
#[path = "../src/cli/model/picture.rs"]
#[expect(dead_code, reason = "the program uses the rest")]
mod picture;
#[path = "../src/cli/poly.rs"]
mod poly;
#[path = "../src/cli/text.rs"]
#[expect(dead_code, reason = "the program uses the rest")]
mod text;
#[path = "../src/cli/model/triangulate.rs"]
mod triangulate;

/// A function for each target; the file under check/ that it is named after has its properties.
pub mod targets {
    macro_rules! targets {
        ($($name:ident $body:path;)+) => { $(
            pub fn $name(data: &[u8]) {
                $body(data);
            }
        )+ };
    }

    targets! {
        clip crate::check::clip::clip;
        counts crate::check::counts::counts;
        divide crate::check::divide::divided;
        edges crate::check::edges::edges;
        faces crate::check::faces::faces;
        gradients crate::check::gradients::gradients;
        mtl crate::check::mtl::mtl;
        obj crate::check::obj::obj;
        pictures crate::check::pictures::pictures;
        poly crate::check::poly::poly;
        texture crate::check::texture::texture;
        tiler crate::check::tiler::tiler;
    }
}
