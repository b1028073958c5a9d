#!/bin/sh
# Makes the surface of the lumen, with a solid for each patch, and the mesh of snappyHexMesh in it.
set -eu
cd "$(dirname "$0")"
: "${WM_PROJECT_DIR:=/usr/share/openfoam}"
export WM_PROJECT_DIR
mkdir -p fluid/constant/triSurface
python3 ../../trees/lumen.py ../../trees/carotid/lines.vtp fluid/constant/triSurface/lumen.stl \
    --solids wall,common,internal,external
cd fluid
for program in blockMesh surfaceFeatureExtract "snappyHexMesh -overwrite"; do
    $program > "log.${program%% *}" 2>&1 || { tail -n 30 "log.${program%% *}" >&2; exit 1; }
done
checkMesh -latestTime > log.checkMesh 2>&1 || true
grep -E "^ +cells:|Mesh OK|\*\*\*" log.checkMesh
