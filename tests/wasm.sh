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

/// There is nowhere to print to: ends with the number of hashes that differ, or with 255 if the level
/// that this is for is not there.
fn main() -> ExitCode {
    let wanted = if cfg!(target_feature = "simd128") { "wasm" } else { "scalar" };
    if !hyperspan::simd::Simd::all().any(|(level, _)| level == wanted) {
        return ExitCode::from(255);
    }
    let (_, wrong) = same_hash::table();
    ExitCode::from(u8::try_from(wrong.len()).unwrap_or(254))
}
RUST
cat > "$scratch/run.mjs" <<'JS'
import { readFile } from "node:fs/promises";
const { instance } = await WebAssembly.instantiate(await readFile(process.argv[2]), {});
process.exitCode = instance.exports.main(0, 0);
JS
# The versions that the project is tested with.
cp "$repo/Cargo.lock" "$scratch/Cargo.lock"

cd "$scratch"
export PATH="$bin:$PATH" RUSTC="$bin/rustc" RUSTC_BOOTSTRAP=1
export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=wasm-ld
failed=0
for features in "" "-C target-feature=+simd128"; do
    export RUSTFLAGS="-C linker-flavor=wasm-ld $features"
    export CARGO_TARGET_DIR=$scratch/target
    cargo build --release --quiet --target "$target" -Zbuild-std=core,alloc,std,panic_abort
    status=0
    node run.mjs "$CARGO_TARGET_DIR/$target/release/same-hash.wasm" || status=$?
    case $status in
        0) echo "wasm $features: the same bytes" ;;
        255) echo "wasm $features: the level is not there" >&2 ;;
        *) echo "wasm $features: $status hashes differ" >&2 ;;
    esac
    [ "$status" = 0 ] || failed=1
done
exit "$failed"
