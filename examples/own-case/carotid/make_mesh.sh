#!/bin/sh
# Makes the surface of the lumen, with a solid for each patch, and the mesh of snappyHexMesh in it.
set -eu
cd "$(dirname "$0")"
: "${WM_PROJECT_DIR:=/usr/share/openfoam}"
export WM_PROJECT_DIR
mkdir -p fluid/constant/triSurface
cd fluid
python3 ../../../trees/lumen.py ../../../trees/carotid/lines.vtp constant/triSurface/mm.stl \
    --solids wall,common,internal,external
run() { "$@" > "log.$1" 2>&1 || { tail -n 30 "log.$1" >&2; exit 1; }; }
run surfaceTransformPoints -scale "(0.001 0.001 0.001)" constant/triSurface/mm.stl constant/triSurface/lumen.stl
run blockMesh
run surfaceFeatureExtract
run snappyHexMesh -overwrite
checkMesh -latestTime > log.checkMesh 2>&1 || true
grep -E "^ +cells:|Mesh OK|\*\*\*" log.checkMesh
