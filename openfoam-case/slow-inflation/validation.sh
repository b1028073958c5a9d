#!/bin/sh
# The slow inflation at two tolerances, beside statics: openfoam-case/slow-inflation/validation.sh FOLDER
#
# A minute on two cores. In the end the last two seconds of the wall at mid-length in each run are copied to
# openfoam-case/slow-inflation/kept, and the table is made again.
set -eu
. "$(dirname "$0")/../kept.sh"

# compute NAME OPTIONS...: with its probe in kept/NAME
compute() {
    name=$1
    shift
    complete "$out/$name" --case $case "$@"
    keep "$out/$name" "$case/kept/$name"
    awk -F, 'NR == 1 || $1 > 9.99' "$out/$name/probes.csv" >"$case/kept/$name/probes.csv"
}

compute tolerance-1e-5
compute by-residual --set coupling.criterion=residual
compute tolerance-1e-7 --set coupling.e_rel=1e-7
fsi tables $case/README.md
