#!/bin/sh
# The measurements of docs/speed.md, on a machine that does nothing else: docs/speed/measure.sh FOLDER [PART...]
# From models to growth they took three quarters of an hour in a busy one.
#
#   models     a step of demo, coarse and paper with either fluid (S-0.25 from equilibrium)
#   tube       the elastic tube with OpenFOAM, two meshes, two tolerances, from its beginning
#   settings   looser settings of OpenFOAM
#   ranks      one and two ranks
#   pair       two models at once
#   growth     finer and finer meshes of either fluid and of the wall
#   large      200,000 and a million cells on two ranks, a wall of 200,000 degrees of freedom
#   walls      walls without blood, 20,000 to 400,000 unknowns of a tube and of a tree
#   kernels    cargo bench --bench structure
#
# Without a part: all of them. Figures that are in FOLDER already are not measured again; an interrupted part
# starts again.
set -eu
[ $# -gt 0 ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 2; }
out=$(mkdir -p "$1" && cd "$1" && pwd)
shift
[ $# -gt 0 ] || set -- models tube settings ranks pair growth large walls kernels
cd "$(dirname "$0")/../.."
cargo build --release --quiet
fsi=$PWD/target/release/fsi-driver
at_once='initial.start=equilibrium ramp.duration_s=0.1 windkessel.initial_pressure_Pa=1.3e4'

# steps NAME WARM N FROM OPTIONS...: N steps of S-0.25 from FROM on, their figures in NAME.json; several may share the
# warm run WARM
steps() {
    name=$1 warm=$2 count=$3 from=$4
    shift 4
    [ -f "$out/$name.json" ] || "$fsi" bench --quiet --case openfoam-case/S-0.25 --steps "$count" --from "$from" --warm "$out/warm-$warm" \
        --json "$out/$name.json" "$@"
}

is_complete() {
    grep -qs '"status": "complete"' "$1/summary.json"
}

# run NAME OPTIONS...: a whole run, whose summary.json has the figures
run() {
    name=$1
    shift
    is_complete "$out/$name" || "$fsi" --quiet --force --out "$out/$name" "$@"
}

models() {
    for preset in demo coarse paper; do
        for fluid in openfoam native; do
            steps $preset-$fluid $preset-$fluid 40 0.16 --preset $preset --fluid $fluid --set $at_once
        done
    done
}

tube() {
    fine=fluid.mesh.axial_per_section=74
    for tolerance in 1e-6 1e-3; do
        by_residual="coupling.criterion=residual coupling.e_rel=$tolerance"
        run tube-$tolerance --case openfoam-case/elastic-tube --end-time 0.01 --set $by_residual
        run tube-fine-$tolerance --case openfoam-case/elastic-tube --end-time 0.003 --set $by_residual $fine
    done
}

# with NAME EXPRESSION: 40 steps of coarse with OpenFOAM's settings changed by sed
with() {
    templates=$out/templates-$1
    rm -rf "$templates" && cp -r openfoam-case/base "$templates"
    sed -i "$2" "$templates/system/fvSolution"
    steps settings-$1 coarse-openfoam 40 0.16 --preset coarse --set $at_once --set "fluid.templates=$templates"
}

settings() {
    with none ''
    with p-0.1 '/relTol          0.02/s/0.02/0.1/'
    with p-U-0.1 's/relTol          0.0[12]/relTol          0.1/'
    with one-sweep '/DICGaussSeidel/s/$/ nPreSweeps 0; nPostSweeps 1;/'
    with coarsest '/DICGaussSeidel/s/$/ nCellsInCoarsestLevel 50; directSolveCoarsest yes;/'
    for correctors in 1 2; do
        steps correctors-$correctors paper-openfoam 40 0.16 --preset paper --set $at_once fluid.max_correctors=$correctors
    done
}

ranks() {
    for preset in coarse paper; do
        steps ranks-$preset-2 ranks-$preset 40 0.16 --preset $preset --ranks 2 --set $at_once
    done
}

pair() {
    for fluid in openfoam native; do
        for jobs in 1 2; do
            folder=$out/pair-$fluid-$jobs
            ! { is_complete "$folder/S-0.25" && is_complete "$folder/H-0.5"; } || continue
            rm -rf "$folder"
            "$fsi" study --quiet --preset coarse --fluid $fluid --models 'S-0.25,H-0.5' --jobs $jobs --end-time 0.2 --out "$folder" --set $at_once
        done
    done
}

growth() {
    for fluid in openfoam native; do
        "$fsi" bench --quiet --case openfoam-case/S-0.25 --preset coarse --fluid $fluid --from 0.02 --steps 10 --growth "$out/growth-$fluid"
    done
}

large() {
    # Ranks that yield the processor wait long for each other where they share cores.
    export OMPI_MCA_mpi_yield_when_idle=0
    ten='--preset paper --ranks 2 --end-time 0.02'
    run cells-200000 --case openfoam-case/S-0.25 $ten --set $at_once 'fluid.mesh={core=16,radial=9,axial_extension=80,axial_per_section=80}'
    run cells-1000000 --case openfoam-case/S-0.25 $ten --set $at_once 'fluid.mesh={core=26,radial=16,axial_extension=143,axial_per_section=143}'
    run wall-200000 --case openfoam-case/S-0.25 --preset coarse --end-time 0.024 --set structure.p=4 structure.axial_per_section=30 structure.circumferential=32
}

# wall NAME CASE KEYS...: two steps of the wall alone, and its memory
wall() {
    name=$1 case=$2
    shift 2
    [ -f "$out/wall-$name.txt" ] || cargo bench --quiet --bench large_wall -- "$case" 2 "$@" > "$out/wall-$name.txt"
}

walls() {
    for size in '12 8' '18 12' '27 18' '38 26' '55 36'; do
        wall "tube-${size% *}" openfoam-case/S-0.25 structure.axial_per_section="${size% *}" structure.circumferential="${size#* }"
    done
    for size in '2 1.8' '2 0.6' '4 0.6' '4 0.3'; do
        wall "tree-${size% *}-${size#* }" examples/trees/arteries tree.core="${size% *}" tree.length="${size#* }"
    done
}

kernels() {
    [ -f "$out/kernels.txt" ] || RAYON_NUM_THREADS=1 cargo bench --quiet --bench structure > "$out/kernels.txt"
}

for part; do
    case $part in
    models | tube | settings | ranks | pair | growth | large | walls | kernels) $part ;;
    *) echo "$0: $part is no part: models, tube, settings, ranks, pair, growth, large, walls or kernels" >&2; exit 2 ;;
    esac
done
