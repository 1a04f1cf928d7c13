//! The promises of docs/design.md, against oracles that share no code with what they judge, or one way of drawing
//! against another.
//! `cargo test --test promises coverage` runs what begins so. One crate: what they draw with is compiled once.
//!
//! - P1, exact coverage: `clipping`, `coverage`, `exhaustive`, `patterns`, `soak`
//! - P2, bounded error: `cameras`, `precision`, `precision_many`, `precision_long_rows`,
//!   `precision_short_rows`, `stability`
//! - P3, identical bits: `draw`, `lists`, `order`, `reproducible`
//! - P4, total on any input: `flushed`, `fuzzed`, `nasty`, `total`
//! - P6, nothing that the picture does not need: `culling`, `hidden`
//!
//! P5 is tests/sources.rs. `oracles` are held against each other, and against cases done by hand.

#[expect(dead_code, reason = "fuzz/check uses the rest")]
#[path = "../oracle/mod.rs"]
mod oracle;
/// What the program measures itself with is looked at here, and looks at the rest.
#[expect(dead_code, reason = "the program uses the rest")]
#[path = "../../src/cli/bench"]
mod bench {
    pub(crate) mod reference;
    pub(crate) mod soak;
    pub(crate) mod stress;
}

mod cameras;
mod clipping;
mod coverage;
mod culling;
mod draw;
mod exhaustive;
mod flushed;
mod fuzzed;
mod hidden;
mod lists;
mod nasty;
mod oracles;
mod order;
mod patterns;
mod precision;
mod precision_many;
mod precision_long_rows;
mod precision_short_rows;
mod reproducible;
mod soak;
mod stability;
mod total;
