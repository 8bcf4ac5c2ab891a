#!/usr/bin/env bash
# ESLint, Prettier and the unit tests of the dashboard's JavaScript; with --fix format it. Where npm is not installed, or
# reaches no registry, only a message: the tests in the browser run the scripts all the same.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! command -v npm >/dev/null; then
    echo "check: npm is not installed, so the JavaScript was not checked" >&2
    exit 0
fi
if [ ! node_modules/.package-lock.json -nt package-lock.json ] && ! npm ci --silent; then
    echo "check: npm could not install ESLint and Prettier, so the JavaScript was not checked" >&2
    exit 0
fi
files=(api/static/js tests/javascript eslint.config.js)
if [ "${1:-}" = --fix ]; then
    node_modules/.bin/eslint --fix "${files[@]}" || true
    node_modules/.bin/prettier --log-level warn --write "${files[@]}"
    exit 0
fi
node_modules/.bin/eslint "${files[@]}"
node_modules/.bin/prettier --log-level warn --check "${files[@]}" || { echo 'prettier: run `make format`' >&2; exit 1; }
node --test --test-reporter=dot tests/javascript/*.test.js
