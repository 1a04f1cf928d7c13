#!/usr/bin/env bash
# What is drawn where arithmetic takes subnormal numbers for 0: nothing, and it is said so. gcc's
# crtfastmath.o, which `-ffast-math` links, sets FTZ and DAZ before main. x86-64 Linux with gcc.
set -euo pipefail
cd "$(dirname "$0")/.."
export CARGO_TARGET_DIR=${FLUSHED_TARGET_DIR:-$(mktemp -d)}
export RUSTFLAGS="-C link-arg=$(gcc -print-file-name=crtfastmath.o)"
# For a named target build scripts are not linked so.
cargo test --target x86_64-unknown-linux-gnu --test promises flushed -- --ignored
