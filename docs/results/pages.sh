#!/bin/sh
# Makes the pages about the study again from the runs that are kept in this folder: nothing is computed.
set -eu
cd "$(dirname "$0")/../.."
cargo run --release --quiet -- tables docs/results/README.md docs/credibility.md openfoam-case/fda-nozzle/README.md \
    docs/results/random-lumen.md
cargo run --release --quiet -- report docs/results/native --out docs/results/report.html
