#!/usr/bin/env bash
# PostgreSQL and Redis for the tests, which start servers of their own on free loopback ports, Chromium, in which they
# look at the dashboard, and debootstrap, in whose Debian the slow tests replay the image. Nothing happens when all are
# installed.
set -euo pipefail
cd "$(dirname "$0")/.."
shopt -s nullglob

postgres=(/usr/lib/postgresql/*/bin/initdb)
missing=()
[ ${#postgres[@]} -gt 0 ] || command -v initdb >/dev/null || missing+=(postgresql)
command -v redis-server >/dev/null || missing+=(redis-server)
command -v chromium >/dev/null || command -v chromium-browser >/dev/null || missing+=(chromium)
command -v setpriv >/dev/null || missing+=(util-linux)
command -v debootstrap >/dev/null || [ -x /usr/sbin/debootstrap ] || missing+=(debootstrap)
[ ${#missing[@]} -eq 0 ] || scripts/apt_install.sh "the tests' own PostgreSQL, Redis, browser and Debian" "${missing[@]}"
