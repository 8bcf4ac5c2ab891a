# geoswarm: `make help` lists the commands. Each does the set-up it needs; what is already there is left alone.
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.ONESHELL:
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help
MAKEFLAGS += --no-builtin-rules --no-print-directory

VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.geoswarm-installed
WARM := $(VENV)/.geoswarm-warm
KERNELS := $(shell find solver -name '*.py' 2>/dev/null)
TESTS := $(BIN)/python scripts/run_tests.py
# Test processes at once: one more than two cores, as many tests wait for a service. Each numerical library keeps to
# one thread (tests/conftest.py).
JOBS ?= 3
export PYTHON
# Where Python may not keep what it compiles, each of the thousands of processes of the tests compiles all libraries.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help setup servers servers-all engines engines-all demo test test-fast test-all check docs format lock bench clean

help:  ## list the commands
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## */  make \1\t/' | expand -t 20

setup: $(INSTALLED) $(WARM)  ## make .venv with everything that development needs (PYTHON=... chooses the interpreter)

# The virtual environment is brought up to date only when the metadata or the locked versions changed since.
$(INSTALLED): pyproject.toml requirements/dev.txt scripts/make_venv.sh scripts/install_locked.py scripts/find_python.sh
	@scripts/make_venv.sh $(VENV)
	touch $@

# Numba compiles each kernel once and caches it beside its source: do it here, not in the first calibration.
$(WARM): $(INSTALLED) $(KERNELS)
	@$(BIN)/python -m geoswarm.solver.warm
	touch $@

servers:  ## install the PostgreSQL, Redis and browser that tests and benchmarks start for themselves
	@scripts/install_servers.sh

servers-all:
	@scripts/install_servers.sh --all

engines:  ## install the third-party programs that the examples call
	@scripts/install_engines.sh

engines-all: $(INSTALLED)
	@scripts/install_engines.sh --all
	$(BIN)/python -m tests.examples.engines

demo: $(INSTALLED)  ## calibrate the published oedometer test in the embedded service (needs no server)
	@$(BIN)/geoswarm demo

check: $(INSTALLED)  ## format, lint, generated client, types, import rules, spelling, JavaScript
	@$(BIN)/ruff format --check --quiet . || { echo 'ruff format: run `make format`'; exit 1; }
	$(BIN)/ruff check --quiet .
	$(BIN)/python scripts/generate_client.py --check
	MYPY_NUM_WORKERS=2 $(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	$(BIN)/codespell
	scripts/check_javascript.sh
	echo 'check: format, lint, generated client, types, import rules and spelling are in order'

docs: $(INSTALLED)  ## the documentation as a site in build/site, links and anchors checked
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	echo 'docs: open build/site/index.html, or read it as you write with `.venv/bin/mkdocs serve`'

format: $(INSTALLED)  ## put the sources in the house's format and renew the generated client
	@$(BIN)/ruff check --fix --quiet . || true
	$(BIN)/ruff format --quiet .
	$(BIN)/python scripts/generate_client.py
	scripts/check_javascript.sh --fix

test: setup servers engines check  ## all checks and the tests, without the long studies
	@$(TESTS) --jobs $(JOBS) -m "not slow"

test-fast: setup check  ## all checks and the quick tests that start no server, browser or process
	@$(TESTS) --jobs $(JOBS) --no-timing -m "fast and not slow"

test-all: setup servers-all engines-all check  ## all checks and all tests, with the long studies
	@$(TESTS) --jobs $(JOBS) -m "slow or not slow"

lock: $(INSTALLED)  ## renew requirements/: the newest versions that pyproject.toml admits, and their licences
	@scripts/lock.sh $(BIN)/uv
	$(MAKE) $(INSTALLED)  # the licences are read from what is installed
	$(BIN)/python scripts/list_licences.py

bench: setup servers  ## measure the speed of forward calculations and of the engine
	@for program in benchmarks/[a-z]*.py; do echo "== $$program"; $(BIN)/python "$$program"; done

clean:  ## remove .venv, caches and build output
	@rm -rf $(VENV) node_modules dist build .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
