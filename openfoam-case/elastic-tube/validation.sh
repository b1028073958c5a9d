#!/bin/sh
# The elastic tube beside published peaks: openfoam-case/elastic-tube/validation.sh FOLDER
#
# An hour and a half on two cores. What has been computed in FOLDER is kept, so the same line goes on where it ended. In
# the end the motion of the wall at mid-length in each run, and the pressures on the axis in two, are copied to
# openfoam-case/elastic-tube/kept, and tables and figure are made again.
set -eu
. "$(dirname "$0")/../kept.sh"

# compute NAME OPTIONS...: with its probe at mid-length in kept/NAME
compute() {
    complete_and_keep "$@"
    awk -F, 'NR == 1 || $2 == 0' "$run/probes.csv" >"$kept/probes.csv"
}

# The same with the pressures on the axis; of velocities, which nobody reads, hardly a digit.
compute_with_pressures() {
    compute "$@"
    awk -F, 'NR == 1 { print; next } { printf "%s,%s,%s,%s,%s,%.6g,%.1g,%.1g,%.1g\n", $1, $2, $3, $4, $5, $6, $7, $8, $9 }' \
        "$run/fluid-probes.csv" >"$kept/fluid-probes.csv"
}

compute second-order --case $case/second-order.toml
compute_with_pressures linear-wall --case $case/linear-wall.toml
compute following-load --case $case/linear-wall.toml --set structure.load=follower
compute openfoam --case $case/second-order.toml --fluid openfoam \
    --set fluid.mesh.radial=10 fluid.mesh.wall_grading=6 fluid.mesh.axial_per_section=40
compute implicit-euler --case $case --fluid native --end-time 0.0095 --set fluid.native.radial=3
# One thing at a time: half the step, and blood and wall refined together.
to_the_peak="--case $case/second-order.toml --end-time 0.0076"
compute step-1e-4 $to_the_peak --set time.step_s=1e-4
compute_with_pressures step-5e-5 --case $case/second-order.toml --set time.step_s=5e-5
compute coarse $to_the_peak --set time.step_s=1e-4 structure.p=3 fluid.native.radial=3 fluid.native.axial_per_section=5
compute fine $to_the_peak --set time.step_s=1e-4 structure.p=5 structure.axial_per_section=12 \
    fluid.native.radial=9 fluid.native.axial_per_section=15
python3 $case/evaluate.py $case/kept/step-5e-5 $case/kept/linear-wall # rows of the page
fsi tables $case/README.md docs/credibility.md
fsi validate $case/tukovic-2018.csv $case/kept/second-order $case/kept/implicit-euler --figure $case/pulse
rm $case/pulse.png
