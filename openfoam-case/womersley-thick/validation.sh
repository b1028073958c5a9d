#!/bin/sh
# Waves in a tube with a thick wall: openfoam-case/womersley-thick/validation.sh FOLDER
#
# Half an hour on two cores. What has been computed in FOLDER is kept, so the same line goes on where it ended. In the
# end the pressures of the last period are copied to openfoam-case/womersley-thick/kept. The page's table is made of
# these by tests/solvers/benchmark_womersley_thick.rs, which prints it where the page has another one.
set -eu
. "$(dirname "$0")/../kept.sh"

# compute FROM NAME OPTIONS...: with the pressures from then on (s) in kept/NAME
compute() {
    from=$1
    shift
    complete_and_keep "$@" --case $case
    awk -F, -v from="$from" 'NR == 1 || $1 > from' "$run/fluid-probes.csv" >"$kept/fluid-probes.csv"
}

compute 0.499 125-steps --set time.step_s=8e-4
compute 0.499 40-steps
compute 0.399 16-steps --end-time 0.5 \
    --set time.step_s=0.00625 structure.p=3 structure.axial_per_section=4 fluid.native.axial_per_section=4
