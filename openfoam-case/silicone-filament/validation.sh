#!/bin/sh
# The filament on two meshes beside the experiment: openfoam-case/silicone-filament/validation.sh FOLDER
#
# One and a half hours on one core. What has been computed in FOLDER is kept, so the same line goes on where it ended.
# In the end the last step of each run is copied to openfoam-case/silicone-filament/kept, and tables and figure are made
# again.
set -eu
. "$(dirname "$0")/../kept.sh"

# compute NAME CELLS: on the mesh with so many cells across the outlet, with its last step in kept/NAME
compute() {
    run=$out/$1 kept=$case/kept/$1
    is_complete "$run" || $case/make_mesh.sh "$2"
    complete "$run" --case $case
    keep "$run" "$kept"
    keep_last "$run" "$kept"
}

compute coarse 12
compute fine 17
fsi tables $case/README.md docs/credibility.md
fsi validate $case/experiment.csv $case/kept/coarse $case/kept/fine --figure $case/experiment
rm $case/experiment.png
