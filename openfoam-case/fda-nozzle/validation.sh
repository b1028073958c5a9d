#!/bin/sh
# The nozzle with either fluid on two meshes and the experiment: openfoam-case/fda-nozzle/validation.sh FOLDER
#
# Some hours on two cores. What has been computed in FOLDER is kept, so the same line goes on where it ended. In the end
# the last step of each run is copied to openfoam-case/fda-nozzle/kept, and the tables of the pages are made again.
set -eu
. "$(dirname "$0")/../kept.sh"

# compute NAME OPTIONS...: the case in FOLDER/NAME, with its last step in kept/NAME
compute() {
    complete_and_keep "$@" --case $case
    keep_last "$run" "$kept"
}

compute openfoam --set time.step_s=0.02
compute openfoam-coarse --set time.step_s=0.02 fluid.mesh.core=11 fluid.mesh.radial=6 fluid.mesh.axial_per_section=20
compute native --fluid native
fsi tables $case/README.md docs/credibility.md
fsi validate $case/experiment.csv $case/kept/openfoam-coarse $case/kept/openfoam $case/kept/native --figure $case/experiment
rm $case/experiment.png
