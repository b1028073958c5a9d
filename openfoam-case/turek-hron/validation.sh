#!/bin/sh
# FSI3 on meshes refined by the same factor: openfoam-case/turek-hron/validation.sh FOLDER
#
# Two hours on one core. What has been computed in FOLDER is kept, so the same line goes on where it ended. In the end
# the last second of each run is copied to openfoam-case/turek-hron/kept, and tables and figure are made again.
set -eu
. "$(dirname "$0")/../kept.sh"

# compute NAME SIZE GROWTH LARGEST SETTING...: cells of that size at flag and cylinder that grow by that ratio to the
# largest, and every second step of the last second in kept/NAME
compute() {
    name=$1 size=$2 growth=$3 largest=$4
    shift 4
    run=$out/$name kept=$case/kept/$name
    complete "$run" --case $case --set flag.mesh.cell_size_m="$size" flag.mesh.growth="$growth" \
        flag.mesh.largest_cell_m="$largest" "$@"
    keep "$run" "$kept"
    forces=openfoam/postProcessing/forces
    mkdir -p "$kept/$forces/0"
    awk -F, 'NR == 1 || $1 > 3.999 && ++n % 2' "$run/probes.csv" >"$kept/probes.csv"
    # The columns of the total force; those of a later start follow.
    for start in $(ls "$run/$forces" | sort -g); do
        awk -F '\t' '/^#/ { next } $1 > 3.999 && ++n % 2 { print $1 "\t" $2 }' "$run/$forces/$start/force.dat"
    done >"$kept/$forces/0/force.dat"
}

# Each has half of the cells of the next: sizes by the square root of 2, growth to the power of it.
compute 9500-cells 3e-3 1.1025 16e-3
compute 19000-cells 2.12132e-3 1.071433 11.31371e-3
compute 38000-cells 1.5e-3 1.05 8e-3
fsi tables $case/README.md docs/credibility.md
fsi validate $case/published.csv $case/kept/38000-cells --figure $case/tip
rm $case/tip.png
