from __future__ import annotations

import os
import subprocess
import sys
from functools import partial

import pytest
from sqlalchemy import event, select, update

from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.coordinator.work import Submission
from geoswarm.workers.execution.worker import Worker
from geoswarm.workers.identity import Identity, is_dead, this_machine
from geoswarm.workers.operations.sweep import Sweeper, begin_sweep
from geoswarm.workers.queries.workers import register_worker
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import counters, jobs, workers
from tests.integration.engines import wait_for
from tests.workers.conftest import MakeWorker, RecordingWaker
from tests.workers.hand import pass_time
from tests.workers.problems import course, line


def claim_one(worker: Worker, job_id: str) -> None:
    """Let a worker take an evaluation and then forget it."""
    made = course(line())
    runtime = Runtime(worker.store, worker.settings)
    for _ in range(2):
        answer = runtime.exchange(job_id, worker.identity.id, made, Submission(), live_workers=1, want=True)
        if answer.queued:
            runtime.start(job_id, made.start())


def test_a_forgotten_job_is_rung_for_when_somebody_is_idle(
    store: Store, settings: Settings, service: JobService, waker: RecordingWaker, make_worker: MakeWorker
) -> None:
    job_id = service.submit(line())[0].id
    waker.wakes.clear()
    sweeper = Sweeper(Runtime(store, settings), waker)
    sweeper.sweep()
    assert waker.wakes == []  # nobody there to hear it
    worker = make_worker()
    worker.start()
    sweeper.sweep()
    sweeper.sweep()  # at once after the first: once is enough
    assert waker.wakes == [job_id]
    pass_time(store, settings.sweep_seconds)
    sweeper.sweep()
    assert waker.wakes == [job_id, job_id]
    worker.serve(job_id)
    waker.wakes.clear()
    pass_time(store, settings.sweep_seconds)
    sweeper.sweep()
    assert waker.wakes == []
    worker.close()


def test_a_silent_workers_evaluation_goes_to_others(
    store: Store, settings: Settings, service: JobService, waker: RecordingWaker, make_worker: MakeWorker
) -> None:
    job_id = service.submit(line())[0].id
    worker = make_worker()
    register = Identity("silent", "elsewhere", 1, "another machine", "celery")
    worker.identity = register
    store.write(lambda c: register_worker(c, register))
    claim_one(worker, job_id)
    assert [w.state for w in service.workers()] == ["busy"]
    sweeper = Sweeper(Runtime(store, settings), waker)
    sweeper.sweep()
    assert [e.state for e in service.evaluations(job_id).items] == ["running"] + ["pending"] * 5
    store.write(lambda c: c.execute(update(workers).values(seen_at=workers.c.seen_at - 2.0 * settings.lease_seconds)))
    waker.wakes.clear()
    sweeper.sweep()
    assert [e.state for e in service.evaluations(job_id).items] == ["pending"] * 6
    assert [w.state for w in service.workers()] == ["lost"]
    assert waker.wakes == [job_id]
    store.write(lambda c: c.execute(update(workers).values(lost_at=workers.c.lost_at - 7200.0)))
    sweeper.sweep()
    assert service.workers() == []


def test_a_dead_process_of_this_machine_is_seen_at_once(
    store: Store, settings: Settings, service: JobService, waker: RecordingWaker, make_worker: MakeWorker
) -> None:
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    assert is_dead(process.pid, this_machine())
    assert not is_dead(process.pid, "another machine")
    assert not is_dead(os.getpid(), this_machine())
    assert not is_dead(1, this_machine())
    job_id = service.submit(line())[0].id
    worker = make_worker()
    identity = Identity.new("celery", process.pid)
    worker.identity = identity
    store.write(lambda c: register_worker(c, identity))
    claim_one(worker, job_id)
    Sweeper(Runtime(store, settings), waker).sweep()
    assert [e.state for e in service.evaluations(job_id).items] == ["pending"] * 6


def test_the_clock_of_a_running_job_is_kept(
    store: Store, settings: Settings, service: JobService, waker: RecordingWaker, make_worker: MakeWorker
) -> None:
    job_id = service.submit(line())[0].id
    claim_one(make_worker(), job_id)

    def counted(passed: float) -> float:
        before = store.read(lambda c: c.execute(jobs.select()).one()).run_seconds
        pass_time(store, passed)
        Sweeper(Runtime(store, settings), waker).sweep()
        return float(store.read(lambda c: c.execute(jobs.select()).one()).run_seconds - before)

    lease = settings.lease_seconds
    assert 0.6 * lease <= counted(0.6 * lease) <= lease
    assert counted(10.0 * lease) == pytest.approx(lease, rel=1e-9)  # never more than a lease at once


def test_the_sweep_process_frees_what_a_dead_worker_held_and_stops_on_request(
    store: Store, settings: Settings, service: JobService, make_worker: MakeWorker
) -> None:
    job_id = service.submit(line())[0].id
    worker = make_worker()
    identity = Identity("silent", "elsewhere", 1, "another machine", "celery")
    worker.identity = identity
    store.write(lambda c: register_worker(c, identity))
    claim_one(worker, job_id)
    store.write(lambda c: c.execute(update(workers).values(seen_at=workers.c.seen_at - 2.0 * settings.lease_seconds)))
    settings = settings.model_copy(update={"sweep_seconds": 0.1})
    program = (
        "import sys; from geoswarm.workers.settings import Settings;"
        "from geoswarm.workers.hosts.alone import run_sweep;"
        "run_sweep(Settings.model_validate_json(sys.argv[1]))"
    )
    process = subprocess.Popen([sys.executable, "-c", program, settings.model_dump_json()], stderr=subprocess.DEVNULL)
    try:
        wait_for(lambda: not service.evaluations(job_id, state="running").items, "a sweep that frees the evaluation")
    finally:
        process.terminate()
        code = process.wait(120.0)
    assert code == 0


def sweepers(store: Store, settings: Settings, waker: RecordingWaker) -> tuple[Sweeper, Sweeper]:
    first, second = (Sweeper(Runtime(store, settings), waker) for _ in range(2))
    return first, second


with_marks = pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_an_idle_service_leaves_its_file_in_peace(store: Store, settings: Settings, waker: RecordingWaker) -> None:
    sweeper = sweepers(store, settings, waker)[0]
    sweeper.look()
    statements: list[str] = []
    event.listen(store.engine, "before_cursor_execute", partial(_note_statement, statements))
    sweeper.look()
    assert {statement.split()[0] for statement in statements} <= {"BEGIN", "SELECT", "PRAGMA"}
    assert statements


def set_back(store: Store, seconds: float) -> None:
    store.write(lambda c: c.execute(update(counters).values(value=counters.c.value - seconds)))


def rung_long_ago(store: Store) -> None:
    store.write(lambda c: c.execute(update(jobs).values(rung_at=None)))


@with_marks
def test_of_many_processes_one_sweeps(
    store: Store, settings: Settings, service: JobService, waker: RecordingWaker, make_worker: MakeWorker
) -> None:
    job_id = service.submit(line())[0].id
    settings = settings.model_copy(update={"sweep_seconds": 1000.0})
    worker = make_worker()
    worker.start()
    waker.wakes.clear()
    first, second = sweepers(store, settings, waker)
    first.look()
    assert waker.wakes == [job_id]
    rung_long_ago(store)
    statements: list[str] = []
    count = partial(_note_statement, statements)
    event.listen(store.engine, "before_cursor_execute", count)
    second.look()
    first.look()
    event.remove(store.engine, "before_cursor_execute", count)
    assert waker.wakes == [job_id]
    assert len([statement for statement in statements if not statement.startswith("BEGIN")]) == 2
    set_back(store, settings.sweep_seconds)  # whoever comes next, as the one before may be gone
    second.look()
    first.look()
    assert waker.wakes == [job_id, job_id]
    set_back(store, -10.0 * settings.sweep_seconds)  # the clock was set back
    rung_long_ago(store)
    first.look()
    assert waker.wakes == [job_id] * 3
    worker.close()


def _note_statement(statements: list[str], _c: object, _cursor: object, statement: str, *_: object) -> None:
    statements.append(statement)


@with_marks
def test_marks_of_machines_that_have_gone_are_forgotten(
    store: Store, settings: Settings, waker: RecordingWaker
) -> None:
    store.write(lambda c: begin_sweep(c, "gone", 1.0))
    set_back(store, 7200.0)
    sweepers(store, settings, waker)[0].look()
    marks = select(counters.c.label).where(counters.c.name == "sweep")
    assert store.read(lambda c: set(c.scalars(marks))) == {"everywhere", this_machine()}


@with_marks
def test_the_dead_of_a_machine_are_seen_there_although_another_machine_sweeps(
    store: Store, settings: Settings, service: JobService, waker: RecordingWaker, make_worker: MakeWorker
) -> None:
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    job_id = service.submit(line())[0].id
    worker = make_worker()
    identity = Identity.new("celery", process.pid)
    worker.identity = identity
    store.write(lambda c: register_worker(c, identity))
    claim_one(worker, job_id)
    settings = settings.model_copy(update={"sweep_seconds": 1000.0})
    assert store.write(lambda c: begin_sweep(c, "everywhere", 900.0))
    first, second = sweepers(store, settings, waker)
    first.look()
    assert [e.state for e in service.evaluations(job_id).items] == ["pending"] * 6
    claim_one(worker, job_id)
    store.write(lambda c: c.execute(update(workers).values(lost_at=None)))
    second.look()  # another process of this machine has looked
    assert [e.state for e in service.evaluations(job_id).items] == ["running"] + ["pending"] * 5
