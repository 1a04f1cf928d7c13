//! The program `hyperspan`: models and polygons to pictures and data.
//!
//! One file for each verb, named after it. They share how frames are drawn into memory
//! (`canvas`, `frames`), how results become files (`results`, `output`), and how all that can
//! go wrong is told (`failure`). The library does the drawing; there is nothing in here that
//! decides a pixel.

#![forbid(unsafe_code)]

mod aov;
mod bench;
mod camera;
mod canvas;
mod compare;
mod failure;
mod flags;
mod frames;
mod info;
mod memory;
mod model;
mod needed;
mod output;
mod poly;
mod progress;
mod render;
mod results;
mod scene;
mod shaders;
mod surface;
mod text;
mod tile;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// A scanline polygon tiler: convex N-gons to pixels, exact and the same bytes on every machine.
///
/// Quiet unless asked. Exit codes: 0 good, 1 a comparison differs, 2 bad usage or bad input.
#[derive(Clone, Debug, Parser)]
#[command(version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Clone, Debug, Subcommand)]
enum Verb {
    Render(Box<render::RenderArgs>),
    Tile(tile::TileArgs),
    Info(info::InfoArgs),
    Compare(compare::CompareArgs),
    Bench(bench::BenchArgs),
}

const DIFFERENT: u8 = 1;
const FAILED: u8 = 2;

/// Of what was compared.
fn code(same: bool) -> ExitCode {
    if same { ExitCode::SUCCESS } else { ExitCode::from(DIFFERENT) }
}

fn main() -> ExitCode {
    let result = match Cli::parse().verb {
        Verb::Render(args) => render::run(&args).map(|()| ExitCode::SUCCESS),
        Verb::Tile(args) => tile::run(&args).map(|()| ExitCode::SUCCESS),
        Verb::Info(args) => info::run(&args).map(|()| ExitCode::SUCCESS),
        Verb::Bench(args) => bench::run(&args).map(code),
        Verb::Compare(args) => compare::run(&args).map(code),
    };
    result.unwrap_or_else(|failure| {
        failure::say(&format!("error: {failure}"));
        ExitCode::from(FAILED)
    })
}
