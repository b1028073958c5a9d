#!/bin/sh
# The arteries with both fluids: openfoam-case/single-arteries/keep.sh FOLDER
#
# Half an hour on two cores. What was computed in FOLDER is kept, so the same line goes on where it ended. In the end
# the last beat of each run is copied to openfoam-case/single-arteries/kept, and tables and figures are made again.
set -eu
. "$(dirname "$0")/../kept.sh"

# compute ARTERY FLUID START: the run FOLDER/ARTERY-FLUID, and its rows after START in kept/ARTERY-FLUID
compute() {
    run=$out/$1-$2 kept=$case/kept/$1-$2
    complete "$run" --case "$case/$1.toml" --fluid "$2"
    keep "$run" "$kept"
    for table in history.csv probes.csv sections.csv; do
        awk -F, -v start="$3" 'NR == 1 || $1 > start' "$run/$table" >"$kept/$table"
    done
}

compute carotid native 3.3001
compute carotid openfoam 3.3001
compute aorta openfoam 2.8651
fsi tables $case/README.md docs/credibility.md
for artery in carotid aorta; do
    fsi validate $case/$artery-measured.csv $case/kept/$artery-* --figure $case/$artery
    rm $case/$artery.png
done
