#!/usr/bin/env bash
# 64-bit Arm with NEON, under emulation. Ends with 0 if all is well.
#
#   tests/neon.sh            both of:
#   tests/neon.sh hashes     the scenes of tests/same_hash.rs have the hashes that stand there
#   tests/neon.sh suite      all tests of the library and of the program, as many cases as elsewhere (half an hour)
#
# It needs a Rust that has the standard library's sources, a linker and the emulator. On Debian 12:
#   apt-get install rustc-web cargo-web rust-web-src lld qemu-user gcc-aarch64-linux-gnu libc6-dev-arm64-cross
#   RUST_BIN=/usr/bin tests/neon.sh
set -euo pipefail
repo=$(cd "$(dirname "$0")/.." && pwd)
bin=${RUST_BIN:-$(dirname "$(command -v cargo)")}
target=aarch64-unknown-linux-gnu
emulator="qemu-aarch64 -L /usr/aarch64-linux-gnu"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export PATH="$bin:$PATH" RUSTC="$bin/rustc" RUSTC_BOOTSTRAP=1 CARGO_INCREMENTAL=0
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
export CARGO_TARGET_DIR=${NEON_TARGET_DIR:-$scratch/target}

hashes() {
    # A crate of its own: no development dependency has to be built for Arm.
    mkdir "$scratch/src"
    cat > "$scratch/Cargo.toml" <<TOML
[package]
name = "same-hash"
version = "0.0.0"
edition = "2024"

[dependencies]
hyperspan = { path = "$repo" }
glam = { version = "*", default-features = false, features = ["f64", "libm"] }
libm = { version = "*", default-features = false }

[profile.release]
panic = "abort"
TOML
    cat > "$scratch/src/main.rs" <<RUST
#[path = "$repo/tests/same_hash.rs"]
mod same_hash;

fn main() {
    println!("{} {}", std::env::consts::ARCH, std::env::consts::OS);
    for (level, _) in hyperspan::simd::Simd::all() {
        println!("level: {level}");
    }
    let (table, wrong) = same_hash::table();
    print!("{table}");
    for what in &wrong {
        println!("WRONG {what}");
    }
    std::process::exit(i32::from(!wrong.is_empty()));
}
RUST
    # The versions that the project is tested with.
    cp "$repo/Cargo.lock" "$scratch/Cargo.lock"

    cd "$scratch"
    cargo build --release --quiet --target "$target" -Zbuild-std=core,alloc,std,panic_abort
    $emulator "$CARGO_TARGET_DIR/$target/release/same-hash"
}

# None is skipped. Two are ignored here as everywhere: `flushing_arithmetic_is_refused`, which is
# about x86's flags, and 10^8 pixels, which take minutes without an emulator.
suite() {
    cd "$repo"
    # The emulator starts the tests, and the tests start the program with it.
    CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER=$emulator PROGRAM_RUNNER=$emulator \
        cargo test --locked --features cli --no-fail-fast --target "$target" -Zbuild-std=std,panic_unwind,test
}

for part in "${@:-hashes suite}"; do
    for one in $part; do
        printf '\n== %s\n' "$one"
        "$one"
    done
done
