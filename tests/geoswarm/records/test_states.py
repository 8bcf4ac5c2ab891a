"""States are typed in one place; what is derived of them covers all."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from geoswarm.records.states import (
    DONE_STATES,
    ENDED_STATES,
    EVALUATION_STATES,
    JOB_STATES,
    OPEN_STATES,
    SERVED_STATES,
    UNDONE_STATES,
)
from geoswarm.workers.store.tables import OPEN
from tests.contracts.repository import ROOT

HOME = ROOT / "geoswarm" / "records" / "states.py"
PYTHON = [
    path for folder in ("api", "workers", "geoswarm/cli", "geoswarm/client") for path in ROOT.glob(f"{folder}/**/*.py")
]
SCRIPTS = [*ROOT.glob("api/static/js/**/*.js"), *ROOT.glob("api/templates/*.html")]
ENOUGH = 2  # so many states in one collection are a list of states


def lists_of(path: Path) -> list[set[str]]:
    """Texts that stand side by side in a tuple, list, set or Literal."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    collections = [node.elts for node in ast.walk(tree) if isinstance(node, ast.Tuple | ast.List | ast.Set)]
    return [
        {item.value for item in elements if isinstance(item, ast.Constant) and isinstance(item.value, str)}
        for elements in collections
    ]


def test_every_state_is_open_or_ended_done_or_undone() -> None:
    assert {*OPEN_STATES, *ENDED_STATES} == set(JOB_STATES)
    assert not {*OPEN_STATES} & {*ENDED_STATES}
    assert {*SERVED_STATES} < {*OPEN_STATES}
    assert {*DONE_STATES, *UNDONE_STATES} == set(EVALUATION_STATES)
    assert not {*DONE_STATES} & {*UNDONE_STATES}


def test_no_other_file_lists_the_states_of_jobs() -> None:
    only_of_jobs = {"queued", "paused", "cancelled"}
    listing = [
        str(path.relative_to(ROOT))
        for path in PYTHON
        if "migrations" not in path.parts and any(len(found & only_of_jobs) >= ENOUGH for found in lists_of(path))
    ]
    assert listing == []
    assert any(len(found & only_of_jobs) >= ENOUGH for found in lists_of(HOME))


def test_the_dashboard_gets_them_from_the_page() -> None:
    states = "|".join(JOB_STATES)
    lists = re.compile(rf"""\[\s*["']({states})["']\s*,\s*["']({states})["']""")
    assert [path.name for path in SCRIPTS if lists.search(path.read_text(encoding="utf-8"))] == []


def test_the_index_of_waiting_jobs_is_the_one_that_migrations_made() -> None:
    assert OPEN == "state IN ('queued', 'running')"
