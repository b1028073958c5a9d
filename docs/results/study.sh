#!/bin/sh
# The study, from nothing to its pages: docs/results/study.sh FOLDER [STEP...]
#
#   native       the twelve models with the native fluid (about ten minutes a model on one core)
#   openfoam     the same with OpenFOAM
#   paper        the twelve at the resolution of the paper with the native fluid, six of them with OpenFOAM, five of
#                these with a finer mesh
#   periodic     the twelve on the meshes of the paper with the native fluid, in the steps of the preset fast, two at
#                once; only if it is named
#   experiments  what the page tries besides: other flows, surfaces and paths, stretched walls in tissue
#   refinement   H-0.5 with finer steps, fluid, wall and tolerance, and with second order in time
#   keep         copies what the pages need from FOLDER to docs/results; tables with fewer digits, compressed
#   pages        makes the pages again from what is kept (pages.sh, which needs no FOLDER)
#
# Without a step: all of them. Whatever has been computed is kept, so the same line goes on where it ended.
set -eu
[ $# -gt 0 ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 2; }
out=$(mkdir -p "$1" && cd "$1" && pwd)
shift
[ $# -gt 0 ] || set -- native openfoam paper experiments refinement keep pages
cd "$(dirname "$0")/../.."
fsi() { cargo run --release --quiet -- "$@"; }

# study NAME MODELS OPTIONS...: the models in FOLDER/NAME, those that are done already excepted
study() {
    name=$1 models=$2
    shift 2
    fsi study --preset "${preset:-coarse}" --models "$models" --out "$out/$name" --resume "$@"
}

paper() {
    preset=paper
    study native-paper '[SHA]-*' --fluid native
    study openfoam-paper 'S-0.0,S-0.75,H-0.0,H-0.5,H-0.75,A-0.5'
    # The clamped rims in shorter cells; a finer cross-section.
    study openfoam-rims 'S-0.75,H-0.5,H-0.75,A-0.5' --set fluid.mesh.rim_parts=4
    study openfoam-section A-0.5 --set fluid.mesh.core=11 fluid.mesh.radial=7
    preset=coarse
}

periodic() {
    preset=fast
    study native-periodic '[SHA]-*' --jobs 2 --fluid native --set structure.circumferential=8 --set 'fluid.native={axial_extension=9,axial_per_section=8}'
    preset=coarse
}

# The run starts in equilibrium at the lowest pressure of the beat, so that the second beat is evaluated.
at_once='--fluid native --set initial.start=equilibrium --set ramp.duration_s=0.1
    --set windkessel.initial_pressure_Pa=1.07e4 --set time.end_s=2'

experiments() {
    # Half the flow, at the same pressures: half the Reynolds number.
    study half-flow '[SH]-0.0' $at_once --set inflow.base_m3_s=2.5e-6 --set inflow.amplitude_m3_s=4.5e-6 \
        --set windkessel.resistance_Pa_s_m3=3.57e9 --set windkessel.compliance_m3_Pa=0.805e-10
    # The same pulse on a lower base.
    study low-base 'S-0.0,S-0.75' $at_once --set inflow.base_m3_s=3.5e-6 --set windkessel.resistance_Pa_s_m3=2.244e9
    # The other surfaces of surfaces.md.
    study surface-9265 'S-0.5,S-0.75' $at_once --set 'geometry.imperfection=[[0,0,0,0,0],[0.38,0.26,0.09,0.44,0.16],[0.96,0.48,0.1,0.39,0.71],[0.82,0.78,0.76,0.19,0.88],[0.58,0.15,0.26,0.27,0.49],[0.6,0.58,0.08,0.27,0.23],[0,0,0,0,0]]'
    study surface-2430 'S-0.5,S-0.75' $at_once --set 'geometry.imperfection=[[0,0,0,0,0],[0.62,0.31,0.56,0.5,0.23],[0.02,0.17,0.67,0.93,0.19],[0.97,0.89,0.88,0.58,0.05],[0.15,0.25,0.8,0.92,0.36],[0.3,0.39,0.21,0.6,0.6],[0,0,0,0,0]]'
    # A helix of half the radius, an arc of half the angle.
    study gentle-paths H-0.0 $at_once --set geometry.helix_radius_m=3e-3
    study gentle-paths A-0.0 $at_once --set geometry.arc_angle_deg=60
    # Gentler still.
    study gentler-paths H-0.0 $at_once --set geometry.helix_radius_m=1.5e-3
    study gentler-paths A-0.0 $at_once --set geometry.arc_angle_deg=30
    # What could raise the largest wall shear of a smooth artery: one that buckles at 0.64 times its highest pressure; a
    # narrower graft.
    study beyond-buckling 'H-0.0,H-0.75' $at_once --set geometry.artery_inner_radius_m=2e-3 geometry.media_thickness_m=4e-4 \
        geometry.adventitia_thickness_m=4e-4 geometry.graft_inner_radius_m=2.5e-3 geometry.graft_thickness_m=3.1e-4 \
        inflow.base_m3_s=1.22e-6 inflow.amplitude_m3_s=2.2e-6 windkessel.resistance_Pa_s_m3=7.31e9 windkessel.compliance_m3_Pa=0.447e-10
    study narrow-graft 'S-0.0,S-0.75' $at_once --set geometry.graft_inner_radius_m=3e-3
    # Stretched by 10 and 20 %, in tissue.
    for stretch in 1.1 1.2; do
        study tissue-$stretch '[SH]-0.0,[SH]-0.75' $at_once --set initial.axial_stretch=$stretch --set surroundings.spring_Pa_m=2e6
    done
}

# refined NAME OPTIONS...: H-0.5 with one thing finer, in FOLDER/NAME
refined() {
    run=$out/$1
    shift
    ! grep -qs '"status": "complete"' "$run/summary.json" || return 0
    resume=
    [ ! -d "$run/checkpoints" ] || resume=--resume
    fsi --case openfoam-case/H-0.5 --preset coarse --out "$run" $resume $at_once "$@"
}

refinement() {
    refined refined/base
    refined refined/step-1ms --set time.step_s=1e-3
    refined refined/step-4ms --set time.step_s=4e-3
    refined refined/fluid-degree-3 --set fluid.native.degree=3
    refined refined/fluid-degree-5 --set fluid.native.degree=5
    refined refined/mesh-of-paper --set fluid.native.axial_extension=9 --set fluid.native.axial_per_section=8 --set structure.circumferential=8
    refined refined/wall-p-5 --set structure.p=5
    refined refined/wall-p-6 --set structure.p=6
    study native-degree-4 A-0.5 $at_once
    study native-degree-5 A-0.5 $at_once --set fluid.native.degree=5
    refined refined/tolerance-1e-6 --set coupling.e_rel=1e-6
    for step in 1 2 4; do
        refined second-order/step-${step}ms --set time.scheme=bdf2 --set structure.time_scheme=bossak --set time.step_s=${step}e-3
    done
}

# keep STUDY TABLES: the figures of each finished run of a study, and its tables if they are wanted
keep() {
    for run in "$out/$1"/*/; do
        keep_run "$1/$(basename "$run")" "$2"
    done
}

keep_run() {
    run=$out/$1 kept=docs/results/$1
    grep -qs '"status": "complete"' "$run/summary.json" || { echo "$1 is not done: not kept"; return 0; }
    mkdir -p "$kept"
    cp "$run/case.resolved.toml" "$run/summary.json" "$run/hemodynamics.json" "$kept"
    for table in $2; do
        # The rate of change of the volume is to be had from the history.
        digits=6
        [ "$table" != history.csv ] || digits=9
        awk -F, -v OFS=, -v CONVFMT=%.${digits}g 'NR > 1 {
            for (i = 1; i <= NF; i++) if ($i ~ /^-?[0-9]+[.][0-9]*(e-?[0-9]+)?$/ && length($i) > 8) $i = ($i + 0) ""
        } { print }' "$run/$table" | gzip -9n > "$kept/$table.gz"
    done
}

keep_all() {
    keep native 'history.csv regions.csv wall-shear.csv'
    for experiment in openfoam native-paper openfoam-paper half-flow low-base surface-2430 surface-9265 gentle-paths gentler-paths beyond-buckling narrow-graft tissue-1.1 tissue-1.2 second-order \
        openfoam-rims openfoam-section native-periodic native-degree-4 native-degree-5 refined; do
        keep "$experiment" ''
    done
}

for step; do
    case $step in
    native) study native '[SHA]-*' --fluid native ;;
    openfoam) study openfoam '[SHA]-*' ;;
    paper) paper ;;
    periodic) periodic ;;
    experiments) experiments ;;
    refinement) refinement ;;
    keep) keep_all ;;
    pages) docs/results/pages.sh ;;
    *) echo "$0: $step is no step: native, openfoam, paper, periodic, experiments, refinement, keep or pages" >&2; exit 2 ;;
    esac
done
