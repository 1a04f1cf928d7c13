#![forbid(unsafe_code)]
#![no_std]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

pub mod camera;
pub mod depth;
pub mod error;
pub mod polygon;
pub mod shade;
pub mod space;
pub mod stats;
pub mod target;
pub mod texture;
pub mod tiler;
pub mod varying;
