#!/bin/sh
# The flap, and its first peak on four meshes: examples/own-case/flap/mesh-study.sh FOLDER
#
# An hour on one core. What has been computed in FOLDER is kept, so the same line goes on where it ended. In the end the
# motion of the flap's end in each run is copied to examples/own-case/flap/kept, and the tables are made again.
set -eu
. "$(dirname "$0")/../../../openfoam-case/kept.sh"

# compute NAME TIMES STEP END: with so many times the cells in each direction, in steps of STEP to END (s), the probe in
# kept/NAME
compute() {
    run=$out/$1 copy=$out/$1-case kept=$case/kept/$1
    mkdir -p "$copy"
    cp -r $case/case.toml $case/flap.msh $case/fluid "$copy"
    awk -v times="$2" '$1 ~ /^(along|over|beside|above)$/ { $2 = times * $2 ";" } { print }' \
        $case/fluid/system/blockMeshDict >"$copy/fluid/system/blockMeshDict"
    complete "$run" --case "$copy" --end-time "$4" --set structure.p=6 structure.time_scheme=bossak \
        time.step_s="$3" output.structure_interval_s=1 output.fluid_interval_s=1
    keep "$run" "$kept"
    sed "s|[^ \"]*$1-case/||g" "$run/case.resolved.toml" >"$kept/case.resolved.toml"
    cp "$run/probes.csv" "$kept"
}

complete_and_keep case --case $case
cp "$run/probes.csv" "$kept"
compute 2790-cells 1 0.005 3
compute 11160-cells 2 0.005 3
compute 25110-cells 3 0.005 3
compute 44640-cells 4 0.005 0.8
compute half-steps 1 0.0025 1
fsi tables $case/README.md docs/credibility.md
fsi validate $case/peak.csv $case/kept/case $case/kept/25110-cells --figure $case/peak
rm $case/peak.png
