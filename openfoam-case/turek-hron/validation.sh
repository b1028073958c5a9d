#!/bin/sh
# FSI3, FSI2, FSI1 and CFD1 to CFD3 on meshes refined by the same factor: openfoam-case/turek-hron/validation.sh FOLDER
#
# Seven hours on one core. What has been computed in FOLDER is kept, so the same line goes on where it ended.
# In the end the last second of each run is copied to openfoam-case/turek-hron/kept, and tables and figure are made
# again.
set -eu
. "$(dirname "$0")/../kept.sh"

# compute NAME FILE FROM SIZE GROWTH LARGEST [END [STEP]]: the case of that file, with cells of that size at flag and
# cylinder that grow by that ratio to the largest, to END in steps of STEP (s), and every second step since FROM (s) in
# kept/NAME
compute() {
    run=$out/$1 kept=$case/kept/$1
    complete "$run" --case $case/$2 ${7:+--end-time "$7"} \
        --set flag.mesh.cell_size_m="$4" flag.mesh.growth="$5" flag.mesh.largest_cell_m="$6" \
        ${8:+time.step_s="$8"}
    keep "$run" "$kept"
    forces=openfoam/postProcessing/forces
    mkdir -p "$kept/$forces/0"
    awk -F, -v from="$3" 'NR == 1 || $1 > from - 1e-3 && ++n % 2' "$run/probes.csv" >"$kept/probes.csv"
    # The columns of the total force; those of a later start follow.
    for start in $(ls "$run/$forces" | sort -g); do
        awk -F '\t' -v from="$3" '/^#/ { next } $1 > from - 1e-3 && ++n % 2 { print $1 "\t" $2 }' "$run/$forces/$start/force.dat"
    done >"$kept/$forces/0/force.dat"
}

# Each has half of the cells of the next: sizes by the square root of 2, growth to the power of it.
compute 9500-cells case.toml 4 3e-3 1.1025 16e-3
compute 19000-cells case.toml 4 2.12132e-3 1.071433 11.31371e-3
compute 38000-cells case.toml 4 1.5e-3 1.05 8e-3
compute 9500-cells-half-step case.toml 4 3e-3 1.1025 16e-3 5 5e-4
for steady in cfd1:9 cfd2:9 fsi1:19; do
    name=${steady%:*} from=${steady#*:}
    compute "$name-4800-cells" "$name.toml" "$from" 4.24264e-3 1.148 22.62742e-3
    compute "$name-9500-cells" "$name.toml" "$from" 3e-3 1.1025 16e-3
    compute "$name-19000-cells" "$name.toml" "$from" 2.12132e-3 1.071433 11.31371e-3
done
compute fsi2-4800-cells fsi2.toml 13 4.24264e-3 1.148 22.62742e-3 15
compute cfd3-38000-cells cfd3.toml 14 1.5e-3 1.05 8e-3 15
fsi tables $case/README.md docs/credibility.md
fsi validate $case/published.csv $case/kept/38000-cells --figure $case/tip
rm $case/tip.png
