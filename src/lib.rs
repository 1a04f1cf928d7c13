//! A scanline polygon tiler: convex N-gons with any attributes in, pixels out, or depth, ids,
//! normals and uv as data, on a CPU, with the same bytes on every machine.
//!
//! ```
#![doc = include_str!("../docs/examples/triangle.rs")]
//! ```
//!
//! # Conventions
//!
//! ```text
//!   clip space              framebuffer                 coverage
//!     y                       o-----> x                   +---+---+
//!     |   z into the          |  pixel (c, r) has its     | o | o |  a centre on a left or
//!     |  /  picture,          v  centre at                +---+---+  a top edge is in, on a
//!     | /   0 <= z <= w       y  (c + 1/2, r + 1/2)       | o | o |  right or bottom one out
//!     +-----> x               n.16 subpixels              +---+---+
//! ```
//!
//! * Positions are homogeneous, (x, y, z, w), before division; the view volume is
//!   -w <= x, y <= w and 0 <= z <= w (or -w <= z <= w), 0 < w.
//! * Front faces are counter-clockwise with y up. Ranges are half-open.
//! * Depth is z/w; any compare function; the cameras' default is reversed-Z.
//! * An attribute has perspective unless it is said to be noperspective or flat.
//! * A NaN is written as `0x7FC00000`.
//!
//! # The pipeline: one way, a module for each stage
//!
//! ```text
//! polygon -> clip -> divide -> edge (Y loop) -> gradient -> span (X loop) -> depth -> shade -> target
//!                                                  or across
//! ```
//!
//! A triangle or a convex quadrilateral of a few pixels within the view goes from its vertices' places on the
//! grid straight to pixels ([`placed`], `patch`, `in_view`), and gets the same bits.
//!
//! A module uses only what is listed above it here. [`clip`], [`divide`](mod@divide) and
//! [`edge`] can be used alone; [`Tiler`] drives them all.
//!
//! # Guarantees
//!
//! Coverage is exact; values are correctly rounded ([`Precision::Exact`]); nothing depends on
//! where a list of vertices begins, on a crop, or on a power of two that all coordinates are
//! scaled by; no input panics, and none is written outside the target. docs/precision.md has the
//! derivations, and names the test of each.
#![forbid(unsafe_code)]
#![no_std]

extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

pub mod error;
pub mod simd;
pub mod space;
pub mod fixed;
mod fetch;
mod subnormal;
mod exact;
mod number;
pub mod varying;
pub mod placed;
pub mod polygon;
pub mod clip;
pub mod divide;
pub mod edge;
mod across;
mod gradient;
pub mod shade;
pub mod aligned;
mod lanes;
mod settle;
mod doubt;
mod along;
mod within;
mod patch;
mod packed;
mod in_view;
mod span;
mod tested;
mod prepared;
mod row;
pub mod depth;
pub mod texture;
pub mod target;
mod clear;
pub mod cull;
pub mod batch;
pub mod order;
mod hidden;
mod paint;
pub mod stats;
pub mod tiler;
pub mod draw;
pub mod camera;

pub use aligned::Aligned;
pub use batch::{Batch, Mesh};
pub use cull::{BoundingBox, BoundingSphere, Clusters, Hierarchy, Inclusion, ViewVolume};
pub use depth::{Compare, DepthBounds, DepthSource, DepthTest};
pub use draw::{Canvas, Frame, Polygons, Screen};
pub use error::Error;
pub use order::{DrawOrder, Ordered};
pub use placed::Placed;
pub use polygon::{Indexed, Polygon, Strided, Vertex};
pub use shade::{Attributes, BLOCK, Block, Fragment, Inputs, ROW, Shader, Solid, unorm8};
pub use simd::Simd;
pub use space::{DepthRange, Grid, PixelRect, Viewport};
pub use stats::Stats;
pub use target::{DepthBuffer, Plane, Target};
pub use texture::Texture;
pub use tiler::{Cull, Outcome, Precision, Tiler};
pub use varying::Interpolation;
