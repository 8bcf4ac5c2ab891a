#!/usr/bin/env bash
# Print a Python 3.11 to 3.14 that can make virtual environments; install one with apt when there is none.
# Each candidate is really run: a pyenv shim may exist for a version that is not active.
# PYTHON=/path/to/python chooses one.
set -euo pipefail
cd "$(dirname "$0")/.."

supported='import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))'
complete='import ensurepip, venv'
candidates=(python3.14 python3.13 python3.12 python3.11 python3 /usr/bin/python3.14 /usr/bin/python3.13 /usr/bin/python3.12 /usr/bin/python3.11 /usr/bin/python3)

works() { "$@" </dev/null >/dev/null 2>&1; }

if [ -n "${PYTHON:-}" ]; then
    if ! works "$PYTHON" -c "$supported; $complete"; then
        echo "geoswarm: PYTHON=$PYTHON is no Python 3.11 to 3.14 with the modules venv and ensurepip" >&2
        exit 1
    fi
    command -v "$PYTHON"
    exit
fi

search() {
    for candidate in "${candidates[@]}"; do
        if works "$candidate" -c "$supported" && works "$candidate" -c "$complete"; then
            command -v "$candidate"
            return
        fi
    done
    return 1
}

search && exit

# Debian ships ensurepip in a package of its own.
for candidate in "${candidates[@]}"; do
    if works "$candidate" -c "$supported"; then
        version=$("$candidate" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
        scripts/apt_install.sh "virtual environments" "python$version-venv" >&2
        search && exit
    fi
done
install_listed() { # the newest supported version that the package lists know
    for version in 3.14 3.13 3.12 3.11; do
        if apt-cache show "python$version-venv" >/dev/null 2>&1; then
            scripts/apt_install.sh "Python" "python$version" "python$version-venv" >&2
            return
        fi
    done
    return 1
}
# On a fresh machine the lists are empty: asking for the distribution's own Python fetches them.
install_listed || scripts/apt_install.sh "Python" python3 python3-venv >&2
search && exit
install_listed && search && exit
echo "geoswarm: there is no Python 3.11 to 3.14; name one with: make setup PYTHON=/path/to/python3.12" >&2
exit 1
