#!/usr/bin/env bash
# Make the virtual environment (or keep a sound one) and install geoswarm into it, editable, with everything that
# development needs. pip's own configuration decides where packages come from.
#
#   scripts/make_venv.sh FOLDER
set -euo pipefail
cd "$(dirname "$0")/.."

venv=$1
python=$venv/bin/python
supported='import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))'

if ! "$python" -c "$supported" >/dev/null 2>&1 || ! "$python" -m pip --version >/dev/null 2>&1; then
    base=$(scripts/find_python.sh)
    echo "geoswarm: making $venv with $("$base" --version)"
    "$base" -m venv --clear "$venv"
fi
echo "geoswarm: installing into $venv (a few minutes the first time)"
"$python" -m pip install --quiet --quiet --disable-pip-version-check --no-input --editable '.[server,plots,mesh,statistics,parquet,dev]'
