from __future__ import annotations

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from sqlalchemy import func, select

from geoswarm.solver.calibration import search_space
from geoswarm.solver.search.space import diversity
from geoswarm.workers.errors import (
    IdempotencyConflictError,
    InvalidCursorError,
    InvalidTransitionError,
    JobNotFoundError,
    StoreUnavailableError,
)
from geoswarm.workers.queries.job_list import JobFilters
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import attempts, evaluations, events, generations
from tests.integration.engines import wait_for
from tests.servers import PostgresServer
from tests.workers.conftest import ON_SQLITE, MakeWorker, RecordingWaker
from tests.workers.problems import expected_history, line, recorded_history


def test_a_submitted_job_is_queued_and_rung_for(service: JobService, waker: RecordingWaker) -> None:
    before = datetime.now(UTC)
    view, new = service.submit(line())
    assert new
    assert (view.state, view.name, view.method, view.forward_model) == ("queued", "line", "particle_swarm", "formula")
    assert (view.seed, view.free_parameters, view.max_evaluations) == (7, ["a", "b"], 120)
    assert view.started_at is view.finished_at is view.seconds is view.objective is view.parameters is None
    second = timedelta(seconds=1)  # the clock of a database counts milliseconds
    assert before - second < view.created_at < datetime.now(UTC) + second
    assert waker.wakes == [view.id]
    assert service.get(view.id) == view
    assert service.problem(view.id) == line().document()
    assert service.best(view.id) is None
    assert [event.data["state"] for event in service.events(view.id)] == ["queued"]


@ON_SQLITE
def test_a_job_without_a_seed_gets_one_and_says_which(service: JobService) -> None:
    seeds = {service.submit(line(seed=None))[0].seed for _ in range(3)}
    assert len(seeds) == 3


def test_the_same_key_gives_the_same_job(service: JobService, waker: RecordingWaker) -> None:
    first, new = service.submit(line(), idempotency_key="k")
    again, new_again = service.submit(line(), idempotency_key="k")
    assert (new, new_again) == (True, False)
    assert again == first
    assert len(waker.wakes) == 1
    with pytest.raises(IdempotencyConflictError, match=f"'k' was used for job {first.id}"):
        service.submit(line(name="other"), idempotency_key="k")
    assert len(service.list().items) == 1


@pytest.mark.parametrize("job_id", ["0123456789abcdef", "", "x\x00y", "é" * 40])
def test_unknown_jobs(service: JobService, job_id: str) -> None:
    calls = [service.get, service.problem, service.cancel, service.pause, service.resume, service.delete]
    calls += [service.best, service.evaluations, service.iterate_evaluations, service.generations, service.events]
    for call in calls:
        with pytest.raises(JobNotFoundError, match="there is no job"):
            call(job_id)


def test_listing_pages_newest_first(service: JobService) -> None:
    ids = [service.submit(line(name=f"job {i}"))[0].id for i in range(5)]
    service.cancel(ids[3])
    first = service.list(limit=2)
    second = service.list(limit=2, cursor=first.next_cursor)
    third = service.list(limit=2, cursor=second.next_cursor)
    assert [job.id for page in (first, second, third) for job in page.items] == ids[::-1]
    assert third.next_cursor is None
    assert [job.id for job in service.list(JobFilters(states=("cancelled",))).items] == [ids[3]]


@ON_SQLITE
@pytest.mark.parametrize(
    "cursor",
    ["", "nonsense", "WzEsMl0", "WyJhIl0", "Ww", "é", "W251bGwsMV0", "WzFlOTk5LCJhIl0", "WzEuNSwiYVx1MDAwMCJd"],
)
def test_foreign_cursors_are_refused(service: JobService, cursor: str) -> None:
    job_id = service.submit(line())[0].id
    with pytest.raises(InvalidCursorError):
        service.list(cursor=cursor)
    if cursor != "WzEsMl0":  # [1, 2] is a cursor of evaluations
        with pytest.raises(InvalidCursorError):
            service.evaluations(job_id, cursor=cursor)


def test_a_finished_job_shows_everything(service: JobService, make_worker: MakeWorker) -> None:
    problem = line()
    job_id = service.submit(problem)[0].id
    make_worker(local_batch_seconds=0).serve(job_id)
    view = service.get(job_id)
    assert (view.state, view.stop_reasons, view.error) == ("finished", ["max_evaluations"], None)
    assert (view.evaluations, view.generations, view.failed_evaluations) == (120, 20, 0)
    assert view.started_at is not None
    assert view.finished_at is not None
    assert view.created_at <= view.started_at <= view.finished_at
    assert view.seconds is not None
    assert 0 < view.seconds < 60

    history = expected_history(problem)
    assert recorded_history(service, job_id) == history
    best = service.best(job_id)
    assert best is not None
    objectives = [entry[3] for entry in history if entry[3] is not None]
    assert best.objective == view.objective == min(objectives)
    assert best.parameters == view.parameters
    assert best.responses is not None
    assert best.responses["y"].x == [0.0, 1.0, 2.0, 3.0]
    assert (best.attempts, best.state, best.reason) == (1, "finished", None)
    assert best.started_at is not None
    assert best.finished_at is not None
    assert view.started_at - timedelta(seconds=1) <= best.started_at <= best.finished_at

    generations = service.generations(job_id)
    assert [g.number for g in generations] == list(range(20))
    assert generations[-1].objective == view.objective
    assert [g.evaluations for g in generations] == [6 * (i + 1) for i in range(20)]
    assert all(g.created_at <= g.finished_at for g in generations)
    assert [g.number for g in service.generations(job_id, after=16, limit=2)] == [17, 18]
    assert {g.diversity for g in generations} == {None}  # only where it is asked for
    space = search_space(problem)
    scattered = service.generations(job_id, after=2, limit=5, diversity=True)
    assert [g.number for g in scattered] == [3, 4, 5, 6, 7]
    for generation in scattered:
        natural = [list(e.parameters.values()) for e in service.evaluations(job_id, generation=generation.number).items]
        assert generation.diversity == diversity(space.to_unit(np.array(natural)))

    events = service.events(job_id)
    states = [event.data["state"] for event in events if event.kind == "state"]
    assert states == ["queued", "running", "finished"]
    assert [event.data["number"] for event in events if event.kind == "generation"] == list(range(20))
    ids = [event.id for event in events]
    assert ids == sorted(set(ids))
    assert service.events(job_id, after=ids[4])[0].id == ids[5]


def test_evaluations_page_and_filter(service: JobService, make_worker: MakeWorker) -> None:
    job_id = service.submit(line())[0].id
    make_worker().serve(job_id)
    keys = []
    cursor = None
    while True:
        page = service.evaluations(job_id, limit=50, cursor=cursor)
        keys += [(e.generation, e.particle) for e in page.items]
        assert all(e.responses is None for e in page.items)
        cursor = page.next_cursor
        if cursor is None:
            break
    assert keys == [(g, p) for g in range(20) for p in range(6)]
    third = service.evaluations(job_id, generation=3, responses=True).items
    assert [(e.generation, e.particle) for e in third] == [(3, p) for p in range(6)]
    assert all(e.responses is not None for e in third)
    objectives = sorted(e.objective for e in service.iterate_evaluations(job_id) if e.objective is not None)
    good = service.evaluations(job_id, max_objective=objectives[9], limit=1000).items
    assert sorted(e.objective for e in good if e.objective is not None) == objectives[:10]
    assert service.evaluations(job_id, state="failed").items == []


def test_failed_evaluations_are_data(service: JobService, make_worker: MakeWorker) -> None:
    model = {"kind": "formula", "series": {"y": "a * x + ln(b)"}}
    problem = line(forward_model=model, stopping={"max_evaluations": 36})
    job_id = service.submit(problem)[0].id
    make_worker().serve(job_id)
    view = service.get(job_id)
    failed = service.evaluations(job_id, state="failed", limit=1000).items
    assert view.state == "finished"
    assert view.failed_evaluations == len(failed) > 0
    assert {e.reason for e in failed} == {"not_finite"}
    assert all(e.objective is None and e.message and e.misfits == {} for e in failed)
    assert recorded_history(service, job_id) == expected_history(problem)


@ON_SQLITE
def test_a_job_whose_every_run_fails_ends_failed(service: JobService, make_worker: MakeWorker) -> None:
    model = {"kind": "formula", "series": {"y": "a * x + b + ln(-1)"}}
    problem = line(forward_model=model, stopping={"max_evaluations": 36})
    job_id = service.submit(problem)[0].id
    make_worker().serve(job_id)
    view = service.get(job_id)
    assert view.state == "failed"
    assert view.error is not None
    assert view.error.startswith("all 36 evaluations failed (36 not finite)")
    assert view.objective is None
    assert service.best(job_id) is None


def test_cancel_pause_resume_and_delete(service: JobService, make_worker: MakeWorker) -> None:
    job_id = service.submit(line())[0].id
    with pytest.raises(InvalidTransitionError, match="cannot resume a job that is queued; accepted states: paused"):
        service.resume(job_id)
    with pytest.raises(InvalidTransitionError, match="cannot delete a job that is queued"):
        service.delete(job_id)
    assert service.pause(job_id).state == "paused"
    worker = make_worker()
    worker.serve(job_id)
    assert service.get(job_id).evaluations == 0
    assert service.resume(job_id).state == "queued"
    assert service.cancel(job_id).state == "cancelled"
    assert service.cancel(job_id).state == "cancelled"
    worker.serve(job_id)
    assert service.get(job_id).finished_at is not None
    assert service.evaluations(job_id).items == []
    service.delete(job_id)
    with pytest.raises(JobNotFoundError):
        service.get(job_id)


def test_deleting_really_deletes(service: JobService, make_worker: MakeWorker) -> None:
    job_id = service.submit(line(stopping={"max_evaluations": 36}))[0].id
    make_worker().serve(job_id)
    service.delete(job_id)
    for table in (attempts, evaluations, events, generations):
        assert service.store.read(lambda c, table=table: c.scalar(select(func.count()).select_from(table))) == 0


def test_workers_and_health(service: JobService, make_worker: MakeWorker) -> None:
    worker = make_worker()
    worker.start()
    (view,) = service.workers()
    assert (view.id, view.state, view.job, view.engine) == (worker.identity.id, "idle", None, "embedded")
    worker.close()
    assert service.workers() == []
    wait_for(lambda: service.health() == {"database": "ok", "broker": "embedded"}, "the word that all is well")


def test_health_of_a_dead_database_says_why(postgres_server: PostgresServer, waker: RecordingWaker) -> None:
    postgres_server.start()
    url = postgres_server.create_database()
    store = Store(Settings(database_url=url))
    service = JobService(store, waker)
    wait_for(lambda: service.health()["database"] == "ok", "a database that is ready")
    postgres_server.stop()
    try:
        masked = "database postgresql+psycopg://geoswarm:***@"
        wait_for(lambda: service.health()["database"].startswith(masked), "the word that the database is away")
        with pytest.raises(StoreUnavailableError):
            service.list()
    finally:
        postgres_server.start()
    wait_for(lambda: service.health()["database"] == "ok", "a service that recovers by itself")
    store.close()
    postgres_server.drop_database(url)
