"""The embedded engine with real worker processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from geoswarm.solver.problem import parse_problem
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.hosts.engine import Engine, open_engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.attacks.attacks import bad
from tests.integration.engines import STEADY, Gated, process_exists, wait_for, wait_until_ended
from tests.servers import PostgresServer
from tests.workers.problems import expected_history, line, recorded_history

pytestmark = pytest.mark.usefixtures("misbehaving_models")


@pytest.fixture
def gated(tmp_path: Path) -> Gated:
    return Gated(tmp_path)


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.slow)])  # Celery's tests use PostgreSQL
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'jobs.db'}"
    url: str = request.getfixturevalue("fresh_postgres_url")
    return url


@contextmanager
def service_alone(settings: Settings) -> Iterator[JobService]:
    """A service without any worker."""
    store = Store(settings)
    try:
        yield JobService(store, NoWaker())
    finally:
        store.close()


def worker_pids(engine: Engine) -> list[int]:
    assert engine.supervisor is not None
    return engine.supervisor.pids


def wait_for_workers(engine: Engine, count: int) -> None:
    wait_for(lambda: sum(w.state != "lost" for w in engine.service.workers()) == count, f"{count} workers")


@pytest.mark.parametrize("workers", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_same_history_as_in_process_for_any_number_of_workers(database_url: str, workers: int) -> None:
    quick = line(stopping={"max_evaluations": 150, "stagnation_generations": 40})
    sampled = line(method={"kind": "monte_carlo", "samples": 60, "batch": 25}, stopping={})
    with open_engine(Settings(database_url=database_url, workers=workers)) as engine:
        ids = [engine.service.submit(problem)[0].id for problem in (quick, sampled)]
        for problem, job_id in zip((quick, sampled), ids, strict=True):
            assert wait_until_ended(engine.service, job_id).state == "finished"
            assert recorded_history(engine.service, job_id) == expected_history(problem)
        pids = worker_pids(engine)
        assert len(pids) == workers
    assert not any(process_exists(pid) for pid in pids)


@pytest.mark.slow
def test_killed_workers_change_nothing(database_url: str, gated: Gated) -> None:
    with open_engine(Settings(database_url=database_url, workers=2, **STEADY)) as engine:
        wait_for_workers(engine, 2)
        job_id = engine.service.submit(gated.problem)[0].id
        for _ in range(2):
            gated.go_on(engine.service, job_id)
            victim = worker_pids(engine)[0]
            os.kill(victim, signal.SIGKILL)
            wait_for(lambda pid=victim: pid not in worker_pids(engine), "a new worker")
        gated.gate.open()
        assert wait_until_ended(engine.service, job_id).state == "finished"
        assert recorded_history(engine.service, job_id) == gated.history()


def test_a_model_that_would_end_every_worker_is_built_in_none(database_url: str) -> None:
    fatal = bad(builds="end workers")
    with open_engine(Settings(database_url=database_url, workers=1, **STEADY)) as engine:
        wait_for_workers(engine, 1)
        before = [worker.id for worker in engine.service.workers()]
        fatal_id = engine.service.submit(parse_problem(fatal))[0].id
        innocent = engine.service.submit(line(stopping={"max_evaluations": 12}))[0].id
        assert wait_until_ended(engine.service, fatal_id).state == "finished"
        assert wait_until_ended(engine.service, innocent).state == "finished"
        assert [worker.id for worker in engine.service.workers()] == before


@pytest.mark.slow
@pytest.mark.parametrize("local_batch_seconds", [0.0, 1.0])
def test_a_method_that_ends_every_worker_fails_its_job_alone(database_url: str, local_batch_seconds: float) -> None:
    fatal = line(method={"kind": "grid", "levels": 4, "fault": "exit"}, stopping={})
    settings = Settings(database_url=database_url, workers=1, **{**STEADY, "local_batch_seconds": local_batch_seconds})
    with open_engine(settings) as engine:
        fatal_id = engine.service.submit(fatal)[0].id
        innocent = engine.service.submit(line(stopping={"max_evaluations": 12}))[0].id
        assert wait_until_ended(engine.service, fatal_id).error == (
            "BuildError: 3 workers ended while they built the problem or its method acted; mend the code that ends them"
        )
        assert wait_until_ended(engine.service, innocent).state == "finished"


@pytest.mark.slow  # test_failures.py pauses and resumes a run in its middle
def test_pause_stops_and_resume_goes_on(database_url: str, gated: Gated) -> None:
    with open_engine(Settings(database_url=database_url, workers=2, **STEADY)) as engine:
        job_id = engine.service.submit(gated.problem)[0].id
        gated.go_on(engine.service, job_id)
        assert engine.service.pause(job_id).state == "paused"
        wait_for(lambda: not any(w.state == "busy" for w in engine.service.workers()), "idle workers")
        before = engine.service.get(job_id)
        other = engine.service.submit(line())[0].id  # the workers are free for others
        assert wait_until_ended(engine.service, other).state == "finished"
        assert engine.service.get(job_id) == before
        gated.gate.open()
        engine.service.resume(job_id)
        assert wait_until_ended(engine.service, job_id).state == "finished"
        assert recorded_history(engine.service, job_id) == gated.history()


@pytest.mark.slow
def test_a_job_goes_on_in_the_next_engine(database_url: str, gated: Gated) -> None:
    settings = Settings(database_url=database_url, workers=2, **STEADY)
    with open_engine(settings) as engine:
        job_id = engine.service.submit(gated.problem)[0].id
        gated.go_on(engine.service, job_id)
    with service_alone(settings) as service:
        assert service.get(job_id).state == "running"
        assert not any(e.state == "running" for e in service.iterate_evaluations(job_id))
    gated.gate.open()
    with open_engine(settings) as engine:
        assert wait_until_ended(engine.service, job_id).state == "finished"
        assert recorded_history(engine.service, job_id) == gated.history()


def test_no_worker_outlives_a_killed_engine(tmp_path: Path) -> None:
    settings = Settings(database_url=f"sqlite:///{tmp_path / 'jobs.db'}", workers=2, grace_seconds=0.5)
    program = (
        "import sys, time; from geoswarm.workers.hosts.engine import open_engine;"
        "from geoswarm.workers.settings import Settings;"
        "engine = open_engine(Settings(**__import__('json').loads(sys.argv[1]))); time.sleep(600)"
    )
    parent = subprocess.Popen([sys.executable, "-c", program, settings.model_dump_json()])
    try:
        with service_alone(settings) as service:
            wait_for(lambda: len(service.workers()) == 2, "two workers")
            pids = [worker.pid for worker in service.workers()]
        assert all(process_exists(pid) for pid in pids)
    finally:
        parent.kill()
        parent.wait()
    wait_for(lambda: not any(process_exists(pid) for pid in pids), "the end of the orphans")


@pytest.mark.slow
def test_a_restarted_database_changes_nothing(
    postgres_server: PostgresServer, fresh_postgres_url: str, gated: Gated
) -> None:
    patient = STEADY | {"lease_seconds": 120.0}  # nobody is lost, however long the restart takes
    with open_engine(Settings(database_url=fresh_postgres_url, workers=2, **patient)) as engine:
        job_id = engine.service.submit(gated.problem)[0].id
        gated.go_on(engine.service, job_id)
        postgres_server.kill()
        with pytest.raises(StoreUnavailableError, match="database postgresql"):
            engine.service.get(job_id)
        postgres_server.start()
        gated.gate.open()
        assert wait_until_ended(engine.service, job_id).state == "finished"
        assert recorded_history(engine.service, job_id) == gated.history()
        assert not any(w.state == "lost" for w in engine.service.workers())
