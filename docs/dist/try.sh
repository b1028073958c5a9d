#!/bin/sh
# Installs the wheel in dist/ in a new environment, from no network, and runs the package's tests and the example
# with the program that it carries. PYTHON=... chooses a Python that has numpy.
set -eu
cd "$(dirname "$0")/../.."
python=${PYTHON:-/usr/bin/python3}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$python" -m venv --system-site-packages "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --no-index --no-deps dist/fsi_driver-*.whl
cp src/python/test_fsi_driver.py "$folder/"
example=$PWD/examples/python/imperfections.py
cd "$folder"
PATH=$folder/venv/bin:$PATH python -m unittest test_fsi_driver
PATH=$folder/venv/bin:$PATH python "$example" imperfections 0.004
