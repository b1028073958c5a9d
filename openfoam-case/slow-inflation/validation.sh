#!/bin/sh
# The slow inflation at two tolerances, beside statics: openfoam-case/slow-inflation/validation.sh FOLDER
#
# A minute on two cores. In the end the last two seconds of the wall at mid-length in each run are copied to
# openfoam-case/slow-inflation/kept, and the table is made again.
set -eu
. "$(dirname "$0")/../kept.sh"

# compute NAME OPTIONS...: with its probe in kept/NAME
compute() {
    complete_and_keep "$@" --case $case
    awk -F, 'NR == 1 || $1 > 9.99' "$run/probes.csv" >"$kept/probes.csv"
}

compute tolerance-1e-5
compute by-residual --set coupling.criterion=residual
compute tolerance-1e-7 --set coupling.e_rel=1e-7
fsi tables $case/README.md
