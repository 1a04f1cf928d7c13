//! Conformance: cases of our own in the manner of the tests of Khronos (dEQP) and of piglit, by
//! what these publish of their geometry and rules, made exact. docs/conformance.md lists them.
//!
//! - `case`       a case, and what is judged of it; through the library, and through `tile`
//! - `fill`       fill rules: every pixel of what is tiled exactly once
//! - `primitives` lists, strips, fans; culling
//! - `clip`       the six planes, the user's planes, the guard band
//! - `values`     interpolation, degenerate triangles, depth

mod case;
mod clip;
mod fill;
#[cfg(feature = "cli")]
#[expect(dead_code, reason = "the program's own tests use the rest")]
#[path = "../cli/harness.rs"]
mod harness;
#[expect(dead_code, reason = "each test file uses a part of it")]
#[path = "../oracle/mod.rs"]
mod oracle;
mod primitives;
#[cfg(feature = "cli")]
mod tile;
mod values;
