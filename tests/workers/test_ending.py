"""Other stop criteria: a job that had ended goes on exactly as if they had been given from the start."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import Stopping
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.errors import InvalidTransitionError, NothingLeftError, QuotaExceededError
from geoswarm.workers.execution.claim_runner import ClaimRunner
from geoswarm.workers.service.job_service import JobService
from tests.workers.conftest import ON_SQLITE, ON_SQLITE_FIRST, MakeWorker
from tests.workers.problems import expected_history, line, recorded_history

METHODS: list[dict[str, Any]] = [
    {"kind": "particle_swarm", "particles": 6, "acceleration": "none"},
    {"kind": "particle_swarm", "particles": 6, "acceleration": "response_surface"},
]


@ON_SQLITE
@pytest.mark.parametrize("method", METHODS, ids=["textbook", "accelerated"])
@pytest.mark.parametrize("local_batch_seconds", [0.0, 5.0], ids=["single generations", "bursts"])
def test_a_finished_job_goes_on_as_if_it_had_been_asked_for_more_at_first(
    service: JobService, make_worker: MakeWorker, method: dict[str, Any], local_batch_seconds: float
) -> None:
    wanted = line(method=method, stopping={"max_evaluations": 90})
    job_id = service.submit(line(method=method, stopping={"max_evaluations": 36}))[0].id
    worker = make_worker(local_batch_seconds=local_batch_seconds)
    worker.serve(job_id)
    assert service.get(job_id).stop_reasons == ["max_evaluations"]
    view = service.change_stopping(job_id, Stopping(max_evaluations=90))
    assert (view.state, view.stop_reasons, view.finished_at, view.max_evaluations) == ("running", [], None, 90)
    assert service.problem(job_id)["stopping"] == {"max_evaluations": 90}
    worker.serve(job_id)
    assert service.get(job_id).state == "finished"
    assert recorded_history(service, job_id) == expected_history(wanted)
    states = [event.data["state"] for event in service.events(job_id) if event.kind == "state"]
    assert states == ["queued", "running", "finished", "running", "finished"]


@ON_SQLITE
def test_a_job_that_ended_with_its_answer_goes_on_with_its_search(service: JobService, make_worker: MakeWorker) -> None:
    points = {"x": [0, 1, 2, 3], "y": [1.0, 3.1, 4.9, 7.05]}
    given: dict[str, Any] = {"observations": [{"series": "y", "points": points}], "method": METHODS[1]}
    first, more = {"max_evaluations": 48}, {"max_evaluations": 96}
    job_id = service.submit(line(**given, stopping=first, answer={"max_evaluations": 12}))[0].id
    worker = make_worker()
    worker.serve(job_id)
    ended = service.get(job_id)
    assert set(ended.verdicts or {}) == {"a", "b"}
    assert ended.fit is not None
    assert ended.shares is not None
    # all weights are 1: the objective is the square of the root mean square
    assert ended.shares[0].root_mean_square == pytest.approx((ended.objective or 0.0) ** 0.5)
    again = service.change_stopping(job_id, Stopping.model_validate(more))
    assert (again.state, again.verdicts, again.fit, again.search_evaluations) == ("running", None, None, None)
    worker.serve(job_id)
    view = service.get(job_id)
    assert view.state == "finished"
    assert set(view.verdicts or {}) == {"a", "b"}
    assert ended.evaluations < view.evaluations <= 96
    history = recorded_history(service, job_id)
    alone = expected_history(line(**given, stopping=more))
    searched = 36  # what the answer left of the first evaluations
    assert history[:searched] == alone[:searched]
    # asked for before the answer began; later ones have learnt from its runs, too
    following = slice(ended.evaluations, ended.evaluations + 6)
    assert [run[2] for run in history[following]] == [run[2] for run in alone[searched : searched + 6]]


@ON_SQLITE_FIRST
@pytest.mark.parametrize("method", METHODS, ids=["textbook", "accelerated"])
def test_evaluations_too_few_for_new_intervals_are_refused(
    service: JobService, make_worker: MakeWorker, method: dict[str, Any]
) -> None:
    readings = [{"series": "y", "points": {"x": [0, 1, 2, 3], "y": [1.0, 3.1, 4.9, 7.05]}}]
    asked = line(method=method, observations=readings, stopping={"max_evaluations": 80}, answer={})
    job_id = service.submit(asked)[0].id
    worker = make_worker()
    worker.serve(job_id)
    ended = service.get(job_id)
    assert set(ended.verdicts or {}) == {"a", "b"}
    for few in (ended.evaluations + 1, ended.evaluations + 8):
        with pytest.raises(NothingLeftError, match="left to the runs after the search"):
            service.change_stopping(job_id, Stopping(max_evaluations=few))
    assert service.get(job_id) == ended
    service.change_stopping(job_id, Stopping(max_evaluations=400))
    worker.serve(job_id)
    assert set(service.get(job_id).verdicts or {}) == {"a", "b"}


def test_a_fault_of_the_statistics_leaves_the_result_of_a_job(
    service: JobService, make_worker: MakeWorker, monkeypatch: Any, caplog: Any
) -> None:
    def broken(*_: object) -> None:
        raise np.linalg.LinAlgError("SVD did not converge")

    monkeypatch.setattr("geoswarm.solver.answering.conclude", broken)
    readings = [{"series": "y", "points": {"x": [0, 1, 2, 3], "y": [1.0, 3.1, 4.9, 7.05]}}]
    job_id = service.submit(line(observations=readings, stopping={"max_evaluations": 80}, answer={}))[0].id
    make_worker().serve(job_id)
    view = service.get(job_id)
    assert (view.state, view.intervals, view.verdicts, view.fit, view.shares) == ("finished", *[None] * 4)
    assert view.search_best is not None
    assert "SVD did not converge" in caplog.text


def test_a_cancelled_job_goes_on_too(service: JobService, make_worker: MakeWorker, monkeypatch: Any) -> None:
    job_id = service.submit(line(stopping={"max_evaluations": 60}))[0].id
    service.cancel(job_id)
    assert service.change_stopping(job_id, Stopping(max_evaluations=60)).state == "queued"
    run = ClaimRunner.run
    calls: list[int] = []

    def interrupted(self: ClaimRunner) -> Any:
        calls.append(1)
        if len(calls) == 3:
            service.cancel(job_id)
        return run(self)

    monkeypatch.setattr(ClaimRunner, "run", interrupted)
    worker = make_worker(local_batch_seconds=0.0)
    worker.serve(job_id)
    assert service.get(job_id).state == "cancelled"
    service.change_stopping(job_id, Stopping(max_evaluations=60))
    worker.serve(job_id)
    assert service.get(job_id).state == "finished"
    assert recorded_history(service, job_id) == expected_history(line(stopping={"max_evaluations": 60}))


@ON_SQLITE
@pytest.mark.parametrize("method", METHODS, ids=["textbook", "accelerated"])
@pytest.mark.parametrize(("first", "then"), [(36, 90), (90, 36)], ids=["more", "fewer"])
def test_a_change_while_a_worker_is_at_it_holds(
    service: JobService, make_worker: MakeWorker, monkeypatch: Any, method: dict[str, Any], first: int, then: int
) -> None:
    """The worker runs several generations in a row and concludes from the old criteria; that must not count."""
    job_id = service.submit(line(method=method, stopping={"max_evaluations": first}))[0].id
    run = ClaimRunner.run
    calls: list[int] = []

    def overtaken(self: ClaimRunner) -> Any:
        calls.append(1)
        submission = run(self)
        if len(calls) == 2:
            service.change_stopping(job_id, Stopping(max_evaluations=then))
        return submission

    monkeypatch.setattr(ClaimRunner, "run", overtaken)
    make_worker(local_batch_seconds=5.0).serve(job_id)
    assert len(calls) >= 2
    assert service.get(job_id).state == "finished"
    assert recorded_history(service, job_id) == expected_history(
        line(method=method, stopping={"max_evaluations": then})
    )


def test_what_would_end_at_once_is_refused(service: JobService, make_worker: MakeWorker) -> None:
    job_id = service.submit(line(stopping={"max_evaluations": 36, "target_objective": 1e6}))[0].id
    make_worker().serve(job_id)
    with pytest.raises(NothingLeftError, match="target_objective"):
        service.change_stopping(job_id, Stopping(max_evaluations=100, target_objective=1e6))
    with pytest.raises(ProblemError, match="stopping"):
        service.change_stopping(job_id, Stopping())
    assert service.get(job_id).state == "finished"
    assert service.problem(job_id)["stopping"] == {"max_evaluations": 36, "target_objective": 1e6}


@ON_SQLITE
def test_a_sampling_keeps_its_points_and_a_failed_job_its_end(service: JobService, make_worker: MakeWorker) -> None:
    sampling = {"kind": "monte_carlo", "samples": 20, "sampling": "sobol", "batch": 10}
    job_id = service.submit(line(method=sampling, stopping={}))[0].id
    with pytest.raises(ProblemError, match="20 points at once"):
        service.change_stopping(job_id, Stopping(max_evaluations=10))
    make_worker().serve(job_id)
    with pytest.raises(NothingLeftError, match="nothing left"):
        service.change_stopping(job_id, Stopping(max_seconds=100))
    model = {"kind": "formula", "series": {"y": "a * x + b + ln(0 - 1)"}}
    broken = service.submit(line(forward_model=model, stopping={"max_evaluations": 12}))[0].id
    make_worker().serve(broken)
    assert service.get(broken).state == "failed"
    with pytest.raises(InvalidTransitionError, match="failed"):
        service.change_stopping(broken, Stopping(max_evaluations=100))


def test_quotas_hold_for_what_is_added(service: JobService, make_worker: MakeWorker) -> None:
    service.settings = service.settings.model_copy(update={"quota_evaluations": 100})
    service._runtime.settings = service.settings
    alice = service.on_behalf_of(Principal("alice", "submit"))
    job_id = alice.submit(line(stopping={"max_evaluations": 36}))[0].id
    make_worker().serve(job_id)
    with pytest.raises(QuotaExceededError):
        alice.change_stopping(job_id, Stopping(max_evaluations=120))
    assert alice.change_stopping(job_id, Stopping(max_evaluations=60)).state == "running"
