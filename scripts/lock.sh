#!/usr/bin/env bash
# Renew requirements/dev.txt and requirements/image.txt: the newest versions that pyproject.toml admits, with their hashes,
# the same for every Python from 3.11 on. Only versions and hashes are written, never where they come from; uv's own
# settings (UV_DEFAULT_INDEX, SSL_CERT_FILE, HTTPS_PROXY, uv.toml) say where to look.
#
#   scripts/lock.sh [UV] [FOLDER]        the program uv, and where to write (requirements/ unless told)
set -euo pipefail
uv=$(command -v "${1:-uv}")
uv=$(realpath "$uv")
cd "$(dirname "$0")/.."
folder=${2:-requirements}
export UV_CUSTOM_COMPILE_COMMAND='make lock'

# compile FILE OPTION...: the build tools of pyproject.toml come by standard input.
compile() {
    local file=$1
    shift
    sed -n '/^\[build-system\]/,/^requires/s/^requires = \["\(.*\)"\]$/\1/p' pyproject.toml | sed 's/", "/\n/g' |
        "$uv" pip compile pyproject.toml - "$@" --quiet --upgrade --universal --fork-strategy fewest --python-version 3.11 \
            --generate-hashes --no-annotate --no-emit-index-url --no-emit-find-links --output-file "$file" >/dev/null
}

compile "$folder/dev.txt" --extra server --extra plots --extra mesh --extra statistics --extra parquet --extra dev
compile "$folder/image.txt" --constraint "$folder/dev.txt" --extra server --extra plots --extra mesh --extra statistics
