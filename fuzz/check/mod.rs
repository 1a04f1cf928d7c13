//! What the fuzz targets check, on inputs made of any bytes: a file for each target, which opens
//! with the properties that it asserts.
//!
//! Called by fuzz_targets/*.rs and by tests/corpus.rs, which replays fuzz/corpus with plain
//! `cargo test`. Cases are built by hand from the bytes, with a bias to what breaks rasterizers.
//! Oracles are those of tests/oracle; the readers are the program's, and no library: who has this
//! as a module has them, and the oracles, as modules beside it.

mod bytes;
mod case;
mod picture;
mod shape;

pub(crate) mod clip;
pub(crate) mod counts;
pub(crate) mod divide;
pub(crate) mod edges;
#[cfg(feature = "cli")]
pub(crate) mod faces;
pub(crate) mod gradients;
pub(crate) mod mtl;
pub(crate) mod obj;
#[cfg(feature = "cli")]
pub(crate) mod pictures;
pub(crate) mod poly;
mod readers;
pub(crate) mod texture;
pub(crate) mod tiler;
