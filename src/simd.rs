//! Which of the machine's instruction sets the loops are compiled for.
//!
//! The loops over a block's lanes are plain Rust, compiled once for each level, and the level is
//! chosen once for each polygon. It changes how fast a picture is drawn, and no bit of it.

use fearless_simd::Level;

/// An instruction set that this machine was shown to have.
#[derive(Clone, Copy, Debug)]
pub struct Simd(pub(crate) Level);

impl Simd {
    /// The names that [`by_name`](Self::by_name) knows.
    pub const NAMES: [&str; 8] =
        ["auto", "scalar", "sse2", "sse4.2", "avx2", "avx512", "neon", "wasm"];

    /// The widest that this machine has; without `std`, what the target always has.
    pub fn auto() -> Self {
        Self(Level::try_detect().unwrap_or(Level::baseline()))
    }

    /// Nothing beyond what the target always has: on x86-64 that is SSE2.
    pub fn scalar() -> Self {
        Self(Level::baseline())
    }

    /// The level of one of [`NAMES`](Self::NAMES), if the machine has it.
    pub fn by_name(name: &str) -> Option<Self> {
        match name {
            "auto" => Some(Self::auto()),
            "scalar" => Some(Self::scalar()),
            _ => Self::named(Self::auto().0, name).map(Self),
        }
    }

    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    fn named(best: Level, name: &str) -> Option<Level> {
        match name {
            "sse2" => best.as_sse2().map(fearless_simd::Simd::level),
            "sse4.2" => best.as_sse4_2().map(fearless_simd::Simd::level),
            "avx2" => best.as_avx2().map(fearless_simd::Simd::level),
            "avx512" => best.as_avx512().map(fearless_simd::Simd::level),
            _ => None,
        }
    }

    #[cfg(target_arch = "aarch64")]
    fn named(best: Level, name: &str) -> Option<Level> {
        (name == "neon").then(|| best.as_neon()).flatten().map(fearless_simd::Simd::level)
    }

    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    fn named(best: Level, name: &str) -> Option<Level> {
        (name == "wasm").then(|| best.as_wasm_simd128()).flatten().map(fearless_simd::Simd::level)
    }

    #[cfg(not(any(
        target_arch = "x86",
        target_arch = "x86_64",
        target_arch = "aarch64",
        all(target_arch = "wasm32", target_feature = "simd128")
    )))]
    fn named(_best: Level, _name: &str) -> Option<Level> {
        None
    }

    /// All levels that this machine has, without `auto`; by name.
    pub fn all() -> impl Iterator<Item = (&'static str, Self)> {
        Self::NAMES[1..].iter().filter_map(|name| Some((*name, Self::by_name(name)?)))
    }
}
