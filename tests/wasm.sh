#!/usr/bin/env bash
# Draws the scenes of tests/same_hash.rs as WebAssembly, without vectors and with, and compares with the
# hashes that stand there. Ends with 0 if all are the same.
#
# It needs a Rust that has the standard library's sources, a linker and Node.js. On Debian 12:
#   apt-get install rustc-web cargo-web rust-web-src lld nodejs
#   RUST_BIN=/usr/bin tests/wasm.sh
set -euo pipefail
repo=$(cd "$(dirname "$0")/.." && pwd)
bin=${RUST_BIN:-$(dirname "$(command -v cargo)")}
target=wasm32-unknown-unknown
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# A crate of its own: no development dependency has to be built.
mkdir "$scratch/src"
cat > "$scratch/Cargo.toml" <<TOML
[package]
name = "same-hash"
version = "0.0.0"
edition = "2024"

[dependencies]
hyperspan = { path = "$repo", default-features = false }
glam = { version = "*", default-features = false, features = ["f64", "libm"] }
libm = { version = "*", default-features = false }

[profile.release]
panic = "abort"
TOML
cat > "$scratch/src/main.rs" <<RUST
use std::process::ExitCode;

#[path = "$repo/tests/same_hash.rs"]
mod same_hash;

/// There is nowhere to print to: what is wrong is left in memory, between two marks. Ends with 0 if
/// nothing is.
fn main() -> ExitCode {
    let wanted = if cfg!(target_feature = "simd128") { "wasm" } else { "scalar" };
    if !hyperspan::simd::Simd::all().any(|(level, _)| level == wanted) {
        return told(format!("there is no level {wanted}"));
    }
    let (_, wrong) = same_hash::table();
    if wrong.is_empty() { ExitCode::SUCCESS } else { told(wrong.join("\n")) }
}

fn told(what: String) -> ExitCode {
    // Put together here, so that the program itself does not hold them.
    let marks = ["begin", "end"].map(|mark| format!("<<{mark}>>"));
    std::hint::black_box(format!("{}{what}{}", marks[0], marks[1]).leak());
    ExitCode::FAILURE
}
RUST
cat > "$scratch/run.mjs" <<'JS'
import { readFile } from "node:fs/promises";
const { instance } = await WebAssembly.instantiate(await readFile(process.argv[2]), {});
process.exitCode = instance.exports.main(0, 0);
const memory = Buffer.from(instance.exports.memory.buffer);
// The marks alone lie before them.
const begin = memory.lastIndexOf("<<begin>>");
const end = memory.indexOf("<<end>>", begin);
if (process.exitCode !== 0) console.error(memory.toString("utf8", begin + 9, end));
JS
# The versions that the project is tested with.
cp "$repo/Cargo.lock" "$scratch/Cargo.lock"

cd "$scratch"
export PATH="$bin:$PATH" RUSTC="$bin/rustc" RUSTC_BOOTSTRAP=1
export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=wasm-ld
failed=0
for features in "" "-C target-feature=+simd128"; do
    export RUSTFLAGS="-C linker-flavor=wasm-ld $features"
    export CARGO_TARGET_DIR=${WASM_TARGET_DIR:-$scratch/target}
    cargo build --release --quiet --target "$target" -Zbuild-std=core,alloc,std,panic_abort
    if node run.mjs "$CARGO_TARGET_DIR/$target/release/same-hash.wasm"; then
        echo "wasm $features: the same bytes"
    else
        failed=1
    fi
done
exit "$failed"
