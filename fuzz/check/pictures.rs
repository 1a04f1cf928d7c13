//! The readers of textures on any bytes, PNG and JPEG: a texture of one texel or more a side, all
//! opaque, the same each time; or an error that names the file. No panic, no hang, and no more
//! memory than the fuzzer grants.

use std::path::Path;

use crate::picture::{self, TextureLimit};

pub(crate) fn pictures(data: &[u8]) {
    let path = Path::new("fuzzed");
    let decode = || picture::decode(data, path, TextureLimit::default());
    match decode() {
        Err(failure) => {
            let message = failure.to_string();
            assert!(message.starts_with("fuzzed"), "{message}");
        }
        Ok(texture) => {
            let (width, height) = texture.size();
            assert!(width > 0 && height > 0, "{width} x {height}");
            for (u, v) in [(0.0, 0.0), (0.5, 0.5), (0.999, 0.001), (-7.25, 3e9)] {
                assert_eq!(texture.nearest(u, v)[3], u8::MAX, "opaque at {u}, {v}");
            }
            let again = decode().map_err(|failure| failure.to_string());
            assert!(again.is_ok_and(|again| again == texture), "the same each time");
        }
    }
}
