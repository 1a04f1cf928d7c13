//! The program from outside: what section "The command line" of docs/design.md says, and what
//! it does with input that nobody vouches for.

mod bench;
mod compare;
mod data;
mod errors;
mod harness;
mod models;
mod nasty;
mod stats;
mod tile;
