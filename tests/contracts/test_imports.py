"""The rooms keep their one-way doors (docs/decisions/0001-layout.md)."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.contracts.repository import ROOT

LINT = [str(Path(sys.executable).with_name("lint-imports")), "--no-cache", "--no-logo"]


def test_import_contracts_are_kept() -> None:
    done = subprocess.run(LINT, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 broken" in done.stdout


SLOW = ("numba", "scipy", "celery", "matplotlib", "pint", "psycopg", "alembic")
STATISTICS = tuple(f"geoswarm.solver.{name}" for name in ("identifiability", "parameter_estimates", "report.document"))
LOADS_NOT: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("geoswarm", "geoswarm.cli", "geoswarm.solver", "geoswarm.workers"), (*SLOW, "numpy", "pydantic")),
    "geoswarm.client": (*SLOW, "numpy"),
    **dict.fromkeys(("geoswarm.api.app", "geoswarm.api.compute_program"), (*SLOW, *STATISTICS, "redis")),
    "geoswarm.workers.hosts.embedded_worker": (*SLOW, *STATISTICS, "redis", "fastapi", "httpx"),
    "geoswarm.workers.hosts.tasks": (*(name for name in SLOW if name != "celery"), *STATISTICS, "fastapi", "httpx"),
    **dict.fromkeys(
        ("geoswarm.solver.runner.fork_server, geoswarm.solver.runner.child", "geoswarm.agent.run_main"),
        (*SLOW, *STATISTICS, "sqlalchemy", "httpx", "geoswarm.solver.search.acceleration"),
    ),
}
"""What the processes of geoswarm do not import when they start, by what they do import: some never need it, and
others load it for the job, the request or the database that does."""


@pytest.mark.parametrize("unwanted", dict.fromkeys(LOADS_NOT.values()))
def test_a_process_starts_without_what_it_may_never_need(unwanted: tuple[str, ...]) -> None:
    entries = [entry for entry, not_loaded in LOADS_NOT.items() if not_loaded == unwanted]
    program = (
        "import sys, importlib\n"
        f"for entry in {entries}:\n"
        "    for name in entry.split(', '):\n        importlib.import_module(name)\n"
        f"    loaded = {set(unwanted)} & set(sys.modules)\n"
        "    if loaded:\n        sys.exit(f'{entry} loads {loaded}')"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_solver_runs_without_the_extras() -> None:
    blocked = ("sqlalchemy", "alembic", "celery", "redis", "fastapi", "uvicorn", "psycopg", "matplotlib")
    program = (
        f"import sys; sys.modules.update(dict.fromkeys({blocked!r}))\n"
        "from geoswarm.solver.runs.local import calibrate\n"
        "import geoswarm.solver.parameter_estimates.proposal, geoswarm.solver.report.folder.reading\n"
        "assert 'numba' not in sys.modules, 'formulas need no kernels, neither do their estimates and reports'\n"
        "from geoswarm.solver.problem import parse_problem\n"
        "from geoswarm.solver.warm import SAMPLES\n"
        "print(calibrate(parse_problem(SAMPLES['oedometer'])).state)"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "finished"), done.stderr


def test_a_check_loads_no_solvers_of_scipy() -> None:
    """They take longer to load than all that a check calculates, the trial of the search included."""
    examples = ("oedometer", "isotropic_compression", "combined", "formula")
    program = (
        "import sys\nfrom geoswarm.cli import main\n"
        f"for name in {examples}:\n"
        f"    assert main(['check', f'{ROOT}/examples/{{name}}/problem.yaml']) == 0\n"
        "    solvers = {'scipy.linalg', 'scipy.optimize', 'scipy.special', 'scipy.stats', 'cmaes'} & set(sys.modules)\n"
        "    if solvers:\n        sys.exit(f'{name}: {solvers}')"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("the search's own time included") == len(examples)
