#!/bin/sh
# Makes the surfaces of phantom and filament, and the mesh of snappyHexMesh between them with CELLS cells across the
# outlet (12 if absent) before it is refined: make_mesh.sh [CELLS]
set -eu
cd "$(dirname "$0")"
: "${WM_PROJECT_DIR:=/usr/share/openfoam}"
export WM_PROJECT_DIR
across=${1:-12}
python3 make_surfaces.py fluid/constant/triSurface
cd fluid
rm -rf constant/polyMesh
echo "across $across; along $((across * 111 / 80)); downstream $((across * 12 / 10));" > system/cells
run() { "$@" > "log.$1" 2>&1 || { tail -n 30 "log.$1" >&2; exit 1; }; }
run blockMesh
run surfaceFeatureExtract
run snappyHexMesh -overwrite
checkMesh -latestTime > log.checkMesh 2>&1 || true
grep -E "^ +cells:|Mesh OK|\*\*\*" log.checkMesh
