#!/usr/bin/env bash
# WebAssembly in Node.js, without vectors and with. Ends with 0 if all is well.
#
#   tests/wasm.sh            both of:
#   tests/wasm.sh hashes     the scenes of tests/same_hash.rs have the hashes that stand there
#   tests/wasm.sh suite      the tests of the core (an hour, most of it the compiler's)
#
# It needs a Rust that has the standard library's sources, a linker, Node.js and, for the tests, WASI's C library. On
# Debian 12:
#   apt-get install rustc-web cargo-web rust-web-src lld nodejs wasi-libc
#   RUST_BIN=/usr/bin tests/wasm.sh
set -euo pipefail
repo=$(cd "$(dirname "$0")/.." && pwd)
bin=${RUST_BIN:-$(dirname "$(command -v cargo)")}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export PATH="$bin:$PATH" RUSTC="$bin/rustc" RUSTC_BOOTSTRAP=1 CARGO_INCREMENTAL=0
export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=wasm-ld CARGO_TARGET_WASM32_WASIP1_LINKER=wasm-ld
# One for each: their flags differ.
target_dir=${WASM_TARGET_DIR:-$scratch/target}
failed=0

hashes() {
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
    for features in "" "-C target-feature=+simd128"; do
        export RUSTFLAGS="-C linker-flavor=wasm-ld $features"
        export CARGO_TARGET_DIR=$target_dir/hashes
        cargo build --release --quiet --target wasm32-unknown-unknown -Zbuild-std=core,alloc,std,panic_abort
        if node run.mjs "$CARGO_TARGET_DIR/wasm32-unknown-unknown/release/same-hash.wasm"; then
            echo "wasm $features: the same bytes"
        else
            failed=1
        fi
    done
}

# The library's own tests, and of tests/promises those that need no threads, no program and no files. Without
# vectors it is fewer: an operation on 16 lanes is 16 of them then.
without_vectors=(clipping coverage exhaustive fuzzed oracles)
with_vectors=("${without_vectors[@]}" cameras nasty order patterns precision total)

# A test that fails ends the others of its file: there is no unwinding. Those that must panic are
# ignored for that reason.
core_tests() {
    local cargo_test=(
        cargo test --locked --no-default-features --features std --target wasm32-wasip1
        -Zbuild-std=std,panic_abort,test
    )
    "${cargo_test[@]}" --lib -- --nocapture || failed=1
    "${cargo_test[@]}" --test promises -- --nocapture "${@/%/::}" || failed=1
}

suite() {
    # What the standard library asks for and WASI does not have; it is not called.
    mkdir -p "$target_dir"
    printf '%s\n' pthread_join pthread_detach > "$target_dir/threads"
    cat > "$scratch/wasi.mjs" <<'JS'
import { readFile } from "node:fs/promises";
import { WASI } from "node:wasi";
const [, , program, ...rest] = process.argv;
// The property tests look for inputs that failed before.
const preopens = { "/": process.env.REPO };
const wasi = new WASI({ version: "preview1", args: [program, ...rest], env: process.env, preopens });
const never = () => { throw new Error("there are no threads"); };
const env = { pthread_join: never, pthread_detach: never };
const imports = { ...wasi.getImportObject(), env };
process.exitCode = wasi.start((await WebAssembly.instantiate(await readFile(program), imports)).instance);
JS

    cd "$repo"
    local libc=/usr/lib/wasm32-wasi
    local link="-C linker-flavor=wasm-ld -C link-self-contained=no -L native=$libc -C link-arg=$libc/crt1-command.o"
    link+=" -C link-arg=--allow-undefined-file=$target_dir/threads"
    for vectors in with_vectors without_vectors; do
        local -n tests=$vectors
        export RUSTFLAGS=$link
        [[ $vectors == without_vectors ]] || RUSTFLAGS+=" -C target-feature=+simd128"
        echo "$vectors:"
        export CARGO_TARGET_DIR=$target_dir/suite
        REPO=$repo CARGO_PROFILE_TEST_DEBUG=0 \
            CARGO_TARGET_WASM32_WASIP1_RUNNER="node --no-warnings $scratch/wasi.mjs" \
            core_tests "${tests[@]}"
    done
}

for part in "${@:-hashes suite}"; do
    for one in $part; do
        printf '\n== %s\n' "$one"
        "$one"
    done
done
exit "$failed"
