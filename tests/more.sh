#!/usr/bin/env bash
# What must hold, and CI leaves out: it needs more than a fresh machine has, or takes long.
#
#   tests/more.sh                 all of it
#   tests/more.sh features glam   a part
#
# features  every combination of features compiles (cargo install cargo-hack)
# glam      the lower end of the range that Cargo.toml allows; the upper one is in Cargo.lock
# flushed   nothing is drawn where arithmetic flushes subnormal numbers (gcc, x86-64)
# valgrind  no invalid access and no uninitialised value: there is no unsafe code here, but in what is
#           depended on; the tests of the scalar path and, since they go over all instruction sets, of the
#           others (valgrind 3.19 knows AVX2, not AVX-512), with a 16th of the cases: an hour
set -euo pipefail
cd "$(dirname "$0")/.."
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export CARGO_TARGET_DIR=${MORE_TARGET_DIR:-$scratch/target}

features() {
    cargo hack check --locked --feature-powerset --lib --bins
}

glam() {
    git ls-files -z --cached --others --exclude-standard | xargs -0 cp --parents -t "$scratch"
    (
        cd "$scratch"
        cargo update --quiet -p glam --precise 0.33.0
        cargo test --test same_hash
        cargo test --test promises -- cameras:: culling::
    )
}

flushed() {
    FLUSHED_TARGET_DIR=$CARGO_TARGET_DIR tests/flushed.sh
}

# Left out are those whose cases PROPTEST_CASES does not make fewer and which draw much
# (conformance, precision_many, same_hash, soak), those that watch something else (flushed, sources)
# and what starts the program (cli): its readers and writers are in --bins and in corpus.
valgrind() {
    local tests=(allocations corpus promises)
    cargo test --locked --features cli --no-run --message-format=json --lib --bins "${tests[@]/#/--test=}" \
        > "$scratch/built.json"
    local program failed=0
    for program in $(sed -n '/"profile":{[^}]*"test":true}/s/.*"executable":"\([^"]*\)".*/\1/p' "$scratch/built.json"); do
        echo "${program##*/}"
        PROPTEST_CASES=16 command valgrind --quiet --error-exitcode=1 "$program" \
            --skip precision_many:: --skip soak:: || failed=1
    done
    return "$failed"
}

for part in "${@:-features glam flushed valgrind}"; do
    for one in $part; do
        printf '\n== %s\n' "$one"
        "$one"
    done
done
