#!/usr/bin/env bash
# Fuzzes each target for some seconds, one after the other: tests/fuzz/run.sh [SECONDS] [TARGET...]
# Needs nothing but a stable compiler and a C++ compiler. Findings are left in artifacts/, the corpus in corpus/.
set -euo pipefail
cd "$(dirname "$0")"
seconds=${1:-600}
targets=("${@:2}")
[ ${#targets[@]} -gt 0 ] || targets=(protocol case solid_file checkpoint flow_curve measured)
host=$(rustc -vV | sed -n 's/^host: //p')
export RUSTFLAGS="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing"
cargo build --release --target "$host"
mkdir -p artifacts corpus/seeds/{case,solid_file,measured}
cp ../../openfoam-case/defaults.toml ../../openfoam-case/S-0.25/case.toml corpus/seeds/case/
cp ../../docs/solid.toml corpus/seeds/solid_file/
head -n 20 ../../openfoam-case/fda-nozzle/experiment.csv >corpus/seeds/measured/experiment.csv
for target in "${targets[@]}"; do
    mkdir -p "corpus/$target" "corpus/seeds/$target"
    "${CARGO_TARGET_DIR:-target}/$host/release/$target" "corpus/$target" "corpus/seeds/$target" \
        -max_total_time="$seconds" -artifact_prefix="artifacts/$target-"
done
