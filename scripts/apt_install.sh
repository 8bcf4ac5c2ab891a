#!/usr/bin/env bash
# Install Debian packages with apt: as root, or through sudo when it needs no password or can ask for it on a terminal.
# Otherwise say which command to run, and end with code 1. While packages are installed here, none may start a service,
# and PostgreSQL makes no default cluster; both switches are taken back afterwards.
#
#   scripts/apt_install.sh PURPOSE PACKAGE...
set -euo pipefail

purpose=$1
shift

if ! command -v apt-get >/dev/null; then
    echo "geoswarm: $purpose: apt-get is not here; install what corresponds to Debian's packages $*" >&2
    exit 1
fi
if [ "$(id -u)" -eq 0 ]; then
    as_root=(env)
elif command -v sudo >/dev/null && { sudo -n true 2>/dev/null || { [ -t 0 ] && [ -z "${CI:-}" ]; }; }; then
    as_root=(sudo)
else
    echo "geoswarm: $purpose: packages are missing. Install them once, then repeat what you did:" >&2
    echo "    sudo apt-get update && sudo apt-get install --no-install-recommends $*" >&2
    exit 1
fi

log=$(mktemp)
made=()
clean() {
    rm -f "$log"
    [ ${#made[@]} -eq 0 ] || "${as_root[@]}" rm -f "${made[@]}"
}
trap clean EXIT

write_once() { # FILE MODE TEXT: make a file that is removed at the end, unless there is one already
    [ -e "$1" ] && return
    made+=("$1")
    "${as_root[@]}" mkdir -p "$(dirname "$1")"
    printf '%b' "$3" | "${as_root[@]}" tee "$1" >/dev/null
    "${as_root[@]}" chmod "$2" "$1"
}
write_once /usr/sbin/policy-rc.d 755 '#!/bin/sh\nexit 101\n'
write_once /etc/postgresql-common/createcluster.d/geoswarm.conf 644 'create_main_cluster = false\n'

apt() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get --quiet "$@" </dev/null >"$log" 2>&1; }

echo "geoswarm: installing for $purpose: $*"
# The package lists are fetched only when they cannot serve: on a fresh machine they are empty, later they may be old.
if ! apt install --yes --no-install-recommends "$@"; then
    if ! { apt update && apt install --yes --no-install-recommends "$@"; }; then
        tail -n 25 "$log" >&2
        echo "geoswarm: apt-get could not install: $*" >&2
        exit 1
    fi
fi
