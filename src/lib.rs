//! A scanline polygon tiler.
#![forbid(unsafe_code)]
#![no_std]

extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

pub mod error;
pub mod space;
pub mod fixed;
mod exact;
pub mod varying;
pub mod polygon;
pub mod clip;
pub mod divide;
pub mod edge;
mod across;
mod gradient;
pub mod shade;
mod span;
pub mod depth;
pub mod texture;
pub mod target;
pub mod stats;
pub mod tiler;
pub mod camera;
