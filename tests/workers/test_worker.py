from __future__ import annotations

import errno
import itertools
import time
from typing import Any

import numpy as np
import pytest
from sqlalchemy import func, select, update

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.course import Course
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.progress.state import Step
from geoswarm.solver.runner.fork_server_link import ForkServerLink
from geoswarm.workers.coordinator.work import Submission
from geoswarm.workers.execution.worker import _Turn
from geoswarm.workers.queries.workers import begin_build
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.store import Store
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.codec import pack_json
from geoswarm.workers.store.tables import builds, evaluations, jobs
from tests.integration.engines import wait_for
from tests.workers.conftest import ON_SQLITE, MakeWorker, RecordingWaker
from tests.workers.hand import pass_time
from tests.workers.problems import course, expected_history, line, recorded_history


def test_a_burst_and_single_steps_give_the_same_history(service: JobService, make_worker: MakeWorker) -> None:
    problem = line(stopping={"max_evaluations": 60})
    expected = expected_history(problem)
    for changes in (
        {},
        {"local_batch_seconds": 0.0},
        {"local_batch_seconds": 0.0, "cheap_seconds": 0.0},
        {"local_batch_seconds": 0.0, "cheap_seconds": 0.0, "single_seconds": 0.0},
        {"chunk_seconds": 1e-4},
    ):
        job_id = service.submit(problem)[0].id
        worker = make_worker(**changes)
        worker.serve(job_id)
        assert service.get(job_id).state == "finished"
        assert recorded_history(service, job_id) == expected
        assert [g.number for g in service.generations(job_id)] == list(range(10))


class Ticks:
    """A clock that moves on by a second whenever somebody looks at it."""

    def __init__(self) -> None:
        self._seconds = itertools.count(1000.0)

    def monotonic(self) -> float:
        return next(self._seconds)


def test_a_time_slice_ends_and_the_job_rings_for_itself(
    service: JobService, make_worker: MakeWorker, waker: RecordingWaker, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("geoswarm.workers.execution.worker.time", Ticks())
    long_job = service.submit(line(stopping={"max_evaluations": 6000}))[0].id
    short_job = service.submit(line())[0].id
    waker.wakes.clear()
    worker = make_worker(slice_seconds=30.0, local_batch_seconds=0.0)
    worker.serve(long_job)
    assert waker.wakes[-1] == long_job
    assert service.get(long_job).state == "running"
    assert worker.next_job() == short_job  # the one that has waited longest
    worker.serve(short_job)
    assert service.get(short_job).evaluations > 0
    assert worker.next_job() is not None


def test_a_search_that_cannot_start_fails_the_job(service: JobService, make_worker: MakeWorker, store: Store) -> None:
    job_id = service.submit(line())[0].id
    impossible = line().document() | {"constraints": ["a + b > 9.9999999"]}
    store.write(lambda c: c.execute(update(jobs).values(problem=pack_json(impossible))))
    make_worker().serve(job_id)
    view = service.get(job_id)
    assert view.state == "failed"
    assert view.error
    assert view.finished_at is not None


def test_a_problem_that_cannot_be_built_fails_the_job_not_the_worker(
    service: JobService, make_worker: MakeWorker, store: Store
) -> None:
    job_id = service.submit(line())[0].id
    store.write(lambda c: c.execute(update(jobs).values(problem='{"name": "x"}')))
    worker = make_worker()
    worker.serve(job_id)
    view = service.get(job_id)
    assert view.state == "failed"
    assert view.error is not None
    assert view.error.startswith("ProblemError: ")
    other = service.submit(line())[0].id
    worker.serve(other)
    assert service.get(other).state == "finished"


@ON_SQLITE
@pytest.mark.usefixtures("misbehaving_models")
def test_a_model_that_dies_while_it_is_built_fails_its_job_and_no_worker(
    service: JobService, make_worker: MakeWorker, store: Store
) -> None:
    document: dict[str, Any] = {
        "forward_model": {"kind": "bad"},
        "parameters": {"slope": {"lower": -5, "upper": 5}},
        "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [0, 1, 2]}}],
        "stopping": {"max_evaluations": 12},
        "seed": 1,
    }
    job_id = service.submit(parse_problem(document))[0].id
    document["forward_model"]["builds"] = "crash"
    store.write(lambda c: c.execute(update(jobs).values(problem=pack_json(document))))
    worker = make_worker(isolate=True)
    worker.serve(job_id)
    view = service.get(job_id)
    assert view.state == "failed"
    assert view.error == (
        "BuildError: the problem could not be built, tried 3 times: the evaluation process was ended by SIGSEGV"
    )
    other = service.submit(line())[0].id
    worker.serve(other)
    worker.close()
    assert service.get(other).state == "finished"


def test_a_job_fails_that_was_being_built_when_three_workers_ended(
    service: JobService, make_worker: MakeWorker, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    def ends(*_: object) -> None:
        raise SystemExit  # as if the process had ended: nothing is noted any more

    job_id = service.submit(line())[0].id
    with monkeypatch.context() as patch:
        patch.setattr("geoswarm.workers.execution.worker.parse_problem", ends)
        for _ in range(2):
            with pytest.raises(SystemExit):
                make_worker().serve(job_id)
    alive = make_worker()
    alive.heartbeat.start()
    store.write(lambda connection: begin_build(connection, job_id, alive.identity.id))
    make_worker().serve(job_id)  # two ended, and one is building it: a third try
    assert service.get(job_id).state == "finished"
    assert store.read(lambda connection: connection.scalar(select(func.count()).select_from(builds))) == 0
    job_id = service.submit(line())[0].id
    with monkeypatch.context() as patch:
        patch.setattr("geoswarm.workers.execution.worker.parse_problem", ends)
        for _ in range(3):
            with pytest.raises(SystemExit):
                make_worker().serve(job_id)
    make_worker().serve(job_id)
    assert service.get(job_id).error == (
        "BuildError: 3 workers ended while they built the problem or its method acted; mend the code that ends them"
    )


@ON_SQLITE
def test_without_a_process_to_spare_the_work_is_left_to_others(
    service: JobService, make_worker: MakeWorker, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(_self: ForkServerLink) -> None:
        raise OSError(errno.EAGAIN, "no process to spare")

    monkeypatch.setattr("geoswarm.workers.execution.worker.TROUBLE_SECONDS", 0.01)
    monkeypatch.setattr("geoswarm.solver.runner.fork_server_link.PAUSES", (0.0,))
    job_id = service.submit(line(stopping={"max_evaluations": 12}))[0].id
    worker = make_worker(isolate=True)
    with monkeypatch.context() as patch:
        patch.setattr(ForkServerLink, "start", none)
        for _ in range(5):
            worker.serve(job_id)
        assert service.get(job_id).state == "running"
        assert {(e.state, e.attempts) for e in service.iterate_evaluations(job_id)} == {("pending", 0)}
    worker.serve(job_id)
    worker.close()
    assert service.get(job_id).state == "finished"
    assert {(e.state, e.attempts) for e in service.iterate_evaluations(job_id)} == {("finished", 1)}
    assert recorded_history(service, job_id) == expected_history(line(stopping={"max_evaluations": 12}))


@ON_SQLITE
def test_while_heartbeats_are_late_a_worker_takes_one_claim_at_a_time(
    service: JobService, make_worker: MakeWorker
) -> None:
    job_id = service.submit(line(stopping={"max_evaluations": 12}))[0].id
    worker = make_worker(single_seconds=0.0, cheap_seconds=0.0, local_batch_seconds=0.0, lease_seconds=0.4)
    worker.heartbeat.late = True
    for number in range(1, 13):
        began = time.monotonic()
        worker.serve(job_id)
        assert time.monotonic() - began >= worker.settings.lease_seconds / 4
        assert sum(e.state == "finished" for e in service.iterate_evaluations(job_id)) == number
    assert service.get(job_id).state == "finished"


@ON_SQLITE
def test_a_bug_in_the_search_fails_the_job_not_the_worker(
    service: JobService, make_worker: MakeWorker, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> Step:
        raise ZeroDivisionError("in the search")

    job_id = service.submit(line())[0].id
    monkeypatch.setattr(Course, "advance", broken)
    make_worker().serve(job_id)
    view = service.get(job_id)
    assert (view.state, view.error) == ("failed", "ZeroDivisionError: in the search")


@ON_SQLITE
def test_an_unknown_job_is_no_trouble(make_worker: MakeWorker, waker: RecordingWaker) -> None:
    make_worker().serve("0123456789abcdef")
    assert waker.wakes == []


def test_the_heartbeat_renews_the_lease_of_a_long_run(
    service: JobService, make_worker: MakeWorker, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    job_id = service.submit(line(stopping={"max_evaluations": 6}))[0].id
    original = Calibration.evaluate
    seen: list[int] = []

    def left() -> float:
        """What is left of the lease [s]."""
        lease = select(func.max(evaluations.c.lease_expires_at) - database_now())
        return store.read(lambda connection: connection.execute(lease).scalar_one())

    def slow(self: Calibration, parameters: FloatArray) -> Evaluation:
        if not seen:
            pass_time(store, 2.0 * worker.settings.lease_seconds)
            wait_for(lambda: left() > 0.0, "a heartbeat that renews the lease")
            seen.append(worker.runtime.expire(job_id, 0, []))
            worker.heartbeat.settings = worker.settings.model_copy(update={"heartbeat_seconds": 300.0})
            worker.heartbeat.late = False  # on a busy machine it may have been, and would end the turn
        return original(self, np.asarray(parameters))

    monkeypatch.setattr(Calibration, "evaluate", slow)
    worker = make_worker(heartbeat_seconds=0.1, watch_seconds=0.1)
    worker.start()
    worker.serve(job_id)
    worker.close()
    assert seen == [0]
    assert service.get(job_id).state == "finished"
    assert {e.attempts for e in service.iterate_evaluations(job_id)} == {1}


def test_a_worker_that_stays_with_a_job_lets_the_others_move_up(
    service: JobService, make_worker: MakeWorker, store: Store
) -> None:
    job_id = service.submit(line())[0].id
    worker = make_worker()
    made = course(line())
    worker.runtime.start(job_id, made.start())
    turn = _Turn(worker, job_id)
    held = worker._ask(job_id, made, Submission(), turn).claim
    assert held is not None
    store.write(lambda c: c.execute(update(jobs).values(served_at=1.0)))
    going_on = Submission(held, (), held.generation, (), partial=True)
    assert worker._early(job_id, made, turn, going_on, True)[0]
    assert served_at(store) == 1.0  # its turn has not ended
    turn.until = 0.0
    assert worker._early(job_id, made, turn, going_on, True)[0]
    assert served_at(store) > 1.0


def served_at(store: Store) -> float:
    return float(store.read(lambda c: c.scalar(select(jobs.c.served_at))))
