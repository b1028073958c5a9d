#!/bin/sh
# Computes the runs of the gallery and draws their pictures into docs/images: docs/gallery.sh FOLDER
# FOLDER keeps the runs; what is there already is not computed again. It prints the seconds of each run: minutes on two
# cores, without OpenFOAM.
set -eu
mkdir -p "$1"
runs=$(cd "$1" && pwd)
cd "$(dirname "$0")/.."
driver=${FSI_DRIVER:-target/release/fsi-driver}

# picture NAME CASE ARGUMENTS...: the run starts in equilibrium at 80 mmHg; second order in time takes long steps.
picture() {
    name=$1 case=$2
    shift 2
    if [ ! -f "$runs/$name/hemodynamics.json" ]; then
        rm -rf "${runs:?}/$name"
        "$driver" --case "$case" --fluid native --out "$runs/$name" --set initial.start=equilibrium \
            windkessel.initial_pressure_Pa=10666 ramp.duration_s=0.05 time.scheme=bdf2 structure.time_scheme=bossak \
            time.step_s=0.01 output.window_start_s=0.05 output.structure_interval_s=0.02 output.fluid_interval_s=0.1 "$@"
    fi
    sed -n "s|^ *\"wall_s\": \([0-9]*\).*|$name: \1 s|p" "$runs/$name/summary.json"
    "$driver" report "$runs/$name" --picture "docs/images/$name.png" --out "$runs/$name/report.html"
}

picture S-0.25 openfoam-case/S-0.25 time.end_s=1.0 --preset coarse
picture H-0.5 openfoam-case/H-0.5 time.end_s=0.4 --preset coarse
picture aneurysm examples/vessels/aneurysm time.end_s=0.4 --preset demo
picture curved examples/vessels/curved time.end_s=0.4 --preset demo
picture carotid examples/vessels/carotid time.end_s=0.4 --preset demo
picture surface examples/vessels/surface time.end_s=0.4 --preset demo
