#!/bin/sh
# The arteries with both fluids: openfoam-case/single-arteries/keep.sh FOLDER
#
# An hour on two cores. What was computed in FOLDER is kept, so the same line goes on where it ended. In the end
# the last beat of each run is copied to openfoam-case/single-arteries/kept, and tables and figures are made again.
set -eu
. "$(dirname "$0")/../kept.sh"

# compute ARTERY FLUID START OPTIONS...: the run FOLDER/ARTERY-FLUID, and its rows after START in kept/ARTERY-FLUID
compute() {
    artery=$1 fluid=$2 start=$3
    shift 3
    complete_and_keep "$artery-$fluid" --case "$case/$artery.toml" --fluid "$fluid" "$@"
    for table in history.csv probes.csv sections.csv; do
        awk -F, -v start="$start" 'NR == 1 || $1 > start' "$run/$table" >"$kept/$table"
    done
}

compute carotid native 3.3001
compute carotid openfoam 3.3001
compute aorta openfoam 2.8651
compute aorta native 2.8651 --set time.step_s=0.0025
fsi tables $case/README.md docs/credibility.md
for artery in carotid aorta; do
    fsi validate $case/$artery-measured.csv $case/kept/$artery-* --figure $case/$artery
    rm $case/$artery.png
done
