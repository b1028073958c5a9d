#!/bin/sh
# The elastic tube beside published peaks: openfoam-case/elastic-tube/validation.sh FOLDER
#
# Half an hour on two cores. What has been computed in FOLDER is kept, so the same line goes on where it ended. In the
# end the motion of the wall at mid-length in each run is copied to openfoam-case/elastic-tube/kept, and tables and
# figure are made again.
set -eu
. "$(dirname "$0")/../kept.sh"

# compute NAME OPTIONS...: with its probe at mid-length in kept/NAME
compute() {
    complete_and_keep "$@"
    awk -F, 'NR == 1 || $2 == 0' "$run/probes.csv" >"$kept/probes.csv"
}

compute second-order --case $case/second-order.toml
compute linear-wall --case $case/linear-wall.toml
compute openfoam --case $case/second-order.toml --fluid openfoam \
    --set fluid.mesh.radial=10 fluid.mesh.wall_grading=6 fluid.mesh.axial_per_section=40
compute implicit-euler --case $case --fluid native --end-time 0.0095 --set fluid.native.radial=3
fsi tables $case/README.md docs/credibility.md
fsi validate $case/tukovic-2018.csv $case/kept/second-order $case/kept/implicit-euler --figure $case/pulse
rm $case/pulse.png
