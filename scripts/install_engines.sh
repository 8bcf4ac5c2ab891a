#!/usr/bin/env bash
# The programs of others that the examples call, for their tests: a Fortran compiler and CalculiX; with --all also
# LibreOffice Calc (43 MB), which only slow tests need. Nothing happens when all are installed. Those that PyPI has are
# installed by tests/examples/engines.py.
set -euo pipefail
cd "$(dirname "$0")/.."

missing=()
command -v gfortran >/dev/null || missing+=(gfortran)
command -v ccx >/dev/null || missing+=(calculix-ccx)
[ "${1:-}" != --all ] || command -v soffice >/dev/null || missing+=(libreoffice-calc)
[ ${#missing[@]} -eq 0 ] || scripts/apt_install.sh "the programs that examples call" "${missing[@]}"
