#!/usr/bin/env bash
# Make the virtual environment (or keep a sound one) and install into it what requirements/dev.txt locks, then geoswarm,
# editable. pip's own configuration decides where packages come from.
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
echo "geoswarm: installing into $venv (a minute or two the first time)"
"$python" scripts/install_locked.py
