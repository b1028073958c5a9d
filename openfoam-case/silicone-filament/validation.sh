#!/bin/sh
# The filament on two meshes beside the experiment: openfoam-case/silicone-filament/validation.sh FOLDER
#
# Two hours on two cores. What has been computed in FOLDER is kept, so the same line goes on where it ended. In the end
# the last step of each run is copied to openfoam-case/silicone-filament/kept, and tables and figure are made again.
set -eu
[ $# -eq 1 ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 2; }
out=$(mkdir -p "$1" && cd "$1" && pwd)
cd "$(dirname "$0")/../.."
case=openfoam-case/silicone-filament
fsi() { cargo run --release --quiet -- "$@"; }

# compute NAME CELLS: on the mesh with so many cells across the outlet, with its last step in kept/NAME
compute() {
    name=$1
    if ! grep -qs '"status": "complete"' "$out/$name/summary.json"; then
        resume=
        [ ! -d "$out/$name/checkpoints" ] || resume=--resume
        $case/make_mesh.sh "$2"
        fsi --case $case --out "$out/$name" $resume
    fi
    kept=$case/kept/$name
    mkdir -p $kept
    sed "s|$PWD/$case/||" "$out/$name/case.resolved.toml" >$kept/case.resolved.toml
    cp "$out/$name/summary.json" "$out/$name/hemodynamics.json" $kept
    for table in probes.csv fluid-probes.csv; do
        last=$(tail -n 1 "$out/$name/$table" | cut -d, -f1)
        awk -F, -v last="$last" 'NR == 1 || $1 == last' "$out/$name/$table" >$kept/$table
    done
}

compute coarse 12
compute fine 17
fsi tables $case/README.md docs/credibility.md
fsi validate $case/experiment.csv $case/kept/coarse $case/kept/fine --figure $case/experiment
rm $case/experiment.png
