#!/usr/bin/env bash
# PostgreSQL and Redis for the tests, which start servers of their own on free loopback ports, Chromium, in which they
# look at the dashboard, and debootstrap, in whose Debian the slow tests replay the image; with --all also what only slow
# tests of agents need: a proxy with TLS, Slurm, and a library that gives a process a wrong clock. Nothing happens when all
# are installed.
set -euo pipefail
cd "$(dirname "$0")/.."
shopt -s nullglob

postgres=(/usr/lib/postgresql/*/bin/initdb)
missing=()
[ ${#postgres[@]} -gt 0 ] || command -v initdb >/dev/null || missing+=(postgresql)
command -v redis-server >/dev/null || missing+=(redis-server)
if grep -qs '^ID=debian' /etc/os-release; then
    command -v chromium-headless-shell >/dev/null || missing+=(chromium-headless-shell)
else
    command -v chromium >/dev/null || command -v chromium-browser >/dev/null || missing+=(chromium)
fi
command -v setpriv >/dev/null || missing+=(util-linux)
command -v debootstrap >/dev/null || [ -x /usr/sbin/debootstrap ] || missing+=(debootstrap)
if [ "${1:-}" = --all ]; then
    command -v nginx >/dev/null || [ -x /usr/sbin/nginx ] || missing+=(nginx-light)
    command -v openssl >/dev/null || missing+=(openssl)
    command -v slurmctld >/dev/null || [ -x /usr/sbin/slurmctld ] || missing+=(slurm-wlm)
    faketime=(/usr/lib/*/faketime/libfaketimeMT.so.1)
    [ ${#faketime[@]} -gt 0 ] || missing+=(libfaketime)
fi
[ ${#missing[@]} -eq 0 ] || scripts/apt_install.sh "the tests' own servers, browser and Debian" "${missing[@]}"
