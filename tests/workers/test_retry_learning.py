"""A search that learns from stored runs, and failures that are run again while it is paused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.workers.coordinator.work import Exchange
from geoswarm.workers.execution.worker import Worker
from geoswarm.workers.service.job_service import JobService
from tests.workers.conftest import MakeWorker
from tests.workers.problems import recorded_history

pytestmark = pytest.mark.usefixtures("misbehaving_models")


def failing_at_first(cured: Path) -> Problem:
    return parse_problem(
        {
            "name": "cured in between",
            "forward_model": {"kind": "misbehaving", "behaviour": "diverge", "above": 0.2, "cured": str(cured)},
            "parameters": {"slope": {"lower": -1, "upper": 1}},
            "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [0.3, 0.1, 1.4]}}],
            "method": {"kind": "particle_swarm", "particles": 4, "acceleration": "response_surface"},
            "stopping": {"max_evaluations": 60},
            "seed": 5,
        }
    )


def pausing(service: JobService, worker: Worker, job: str) -> Callable[..., Exchange]:
    """The exchange of a worker whose job is paused when its fifth generation is complete."""
    exchange = worker.runtime.exchange

    def then_pause(*given: Any, **named: Any) -> Exchange:
        answer = exchange(*given, **named)
        if service.get(job).generations == 5 and service.get(job).state == "running":
            service.pause(job)
        return answer

    return then_pause


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_who_has_seen_the_failures_goes_on_like_who_has_not(
    service: JobService, make_worker: MakeWorker, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    histories = []
    for newcomer in (False, True):
        cured = tmp_path / f"cured {newcomer}"
        job = service.submit(failing_at_first(cured))[0].id
        worker = make_worker()
        with monkeypatch.context() as watching:
            watching.setattr(worker.runtime, "exchange", pausing(service, worker, job))
            worker.serve(job)
        assert service.get(job).state == "paused"
        assert service.get(job).failed_evaluations > 0
        cured.touch()
        service.retry_failed(job)
        worker.serve(job)
        assert service.get(job).failed_evaluations == 0
        service.resume(job)
        worker = make_worker() if newcomer else worker
        worker.serve(job)
        assert service.get(job).state == "finished"
        histories.append(recorded_history(service, job))
    assert 50 <= len(histories[0]) <= 60  # as many as the runs after the search need
    assert histories[0] == histories[1]


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_job_keeps_its_verdicts_until_a_failure_has_succeeded(
    service: JobService, make_worker: MakeWorker, tmp_path: Path
) -> None:
    cured = tmp_path / "cured"
    job = service.submit(failing_at_first(cured))[0].id
    worker = make_worker()
    worker.serve(job)
    ended = service.get(job)
    assert ended.state == "finished"
    assert ended.failed_evaluations > 0
    assert ended.verdicts is not None
    service.retry_failed(job)
    worker.serve(job)
    assert service.get(job).verdicts == ended.verdicts  # they have failed again
    cured.touch()
    service.retry_failed(job)
    worker.serve(job)
    after = service.get(job)
    assert after.state == "finished"
    assert after.failed_evaluations == 0
    assert after.verdicts is after.intervals is None  # statistics judge all evaluations
    assert after.search_best == ended.search_best
