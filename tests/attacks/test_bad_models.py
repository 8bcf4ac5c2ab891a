"""Every way to behave badly, in both engines and in process: the right reason, no history changed, nothing left."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.system.processes import descendants
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from tests.integration.engines import celery_workers, wait_for, wait_until_ended
from tests.models.geoswarm_bad_models import REASONS
from tests.solver.test_local import bits
from tests.workers.problems import expected_history, line, recorded_history

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("misbehaving_models")]

INNOCENT = line()
AT_ONCE = 10
BUSY = 300  # s, that a run may take on a busy machine until it exceeds another limit


def bad(behaviour: str) -> Problem:
    document: dict[str, Any] = {
        "name": behaviour,
        "forward_model": {"kind": "bad", "behaviour": behaviour},
        "parameters": {"slope": {"lower": -1, "upper": 1}},
        "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [0, 1, 2]}}],
        "method": {"kind": "monte_carlo", "samples": 6, "batch": 6},
        "limits": {"seconds_per_evaluation": 3 if REASONS[behaviour] == "timeout" else BUSY, "memory_mb": 300},
        "failures": {"retry": {"worker_lost": 1}},
        "seed": 3,
    }
    return parse_problem(document)


@contextmanager
def engine(kind: str, request: pytest.FixtureRequest, folder: Path) -> Iterator[tuple[JobService, list[int]]]:
    """A service with two workers, and the processes below which they are."""
    if kind == "embedded":
        settings = Settings(database_url=f"sqlite:///{folder / 'jobs.db'}", workers=2)
        with open_engine(settings) as opened:
            assert opened.supervisor is not None
            yield opened.service, opened.supervisor.pids
        return
    urls = {name: request.getfixturevalue(f"fresh_{name}_url") for name in ("postgres", "redis")}
    settings = Settings(database_url=urls["postgres"], broker_url=urls["redis"])
    with celery_workers(settings, 1, 2) as processes, open_engine(settings) as opened:
        yield opened.service, [process.pid for process in processes]


@pytest.mark.timeout(3600)
@pytest.mark.parametrize("kind", ["embedded", "celery"])
def test_bad_models_one_after_the_other_and_ten_at_once(
    kind: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    expected = expected_history(INNOCENT)
    with engine(kind, request, tmp_path) as (service, pids):
        names = list(REASONS)
        for first in range(0, len(names), AT_ONCE):
            jobs = {name: service.submit(bad(name))[0].id for name in names[first : first + AT_ONCE]}
            innocent = service.submit(INNOCENT)[0].id
            for name, job_id in jobs.items():
                view = wait_until_ended(service, job_id, 600.0)
                assert view.state == "finished", (name, view.error)
                wrong = [e for e in service.evaluations(job_id, limit=100).items if not _right(e, REASONS[name])]
                assert not wrong, (name, wrong)
            wait_until_ended(service, innocent)
            assert recorded_history(service, innocent) == expected
        # Each worker keeps a fork server and at most one idle process; whatever the models started is gone.
        most = (1 if kind == "celery" else 0) + 2 * 3 + 2
        wait_for(lambda: sum(len(descendants(pid)) for pid in pids) <= most, "the end of what the models left")


@pytest.mark.timeout(3600)
@pytest.mark.parametrize("half", [0, 1])
def test_bad_models_in_process(half: int) -> None:
    innocent = bits(calibrate(INNOCENT))
    before = set(descendants(os.getpid()))
    for name, reason in list(REASONS.items())[half::2]:
        result = calibrate(bad(name), workers=2)
        assert result.state == "finished", name
        wrong = [record for record in result.history if not _right(record.evaluation, reason)]
        assert not wrong, (name, wrong)
        assert before >= set(descendants(os.getpid())), name
        assert bits(calibrate(INNOCENT)) == innocent, name


def _right(evaluation: Any, reason: str | None) -> bool:
    """Whether an evaluation, of the service or in process, ended as it must."""
    parameters = evaluation.parameters
    slope = parameters["slope"] if isinstance(parameters, dict) else parameters[0]
    if slope > 0.0 and reason is not None:
        return bool(evaluation.reason == reason)
    return evaluation.reason is None and abs(evaluation.objective - 5.0 / 3.0 * (slope - 1.0) ** 2) < 2e-3
