"""A full disk and a read-only database: a clear state, nothing lost, and work goes on when it can be written again."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psycopg
import pytest
from sqlalchemy import Connection, event

from geoswarm.workers.coordinator.work import Exchange, Submission
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.execution.claim_runner import ClaimRunner
from geoswarm.workers.execution.worker import Worker
from geoswarm.workers.identity import Identity
from geoswarm.workers.operations.probe import Probe
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from tests.integration.engines import wait_for
from tests.workers.conftest import RecordingWaker
from tests.workers.problems import expected_history, line, recorded_history


class Switch:
    """Makes a database unwritable, and writable again."""

    def __init__(self, store: Store, kind: str) -> None:
        self.store = store
        self.kind = kind
        self.broken = False
        if store.engine.dialect.name == "sqlite":
            event.listen(store.engine, "begin", lambda connection: self._prepare(connection, self.broken))
            for end in ("commit", "rollback"):  # the next transaction begins before it can be prepared
                event.listen(store.engine, end, lambda connection: self._prepare(connection, False))

    def _prepare(self, connection: Connection, broken: bool) -> None:
        cursor = connection.connection.cursor()
        if self.kind == "full":
            cursor.execute("PRAGMA page_count")
            pages = cursor.fetchone()[0]
            cursor.execute(f"PRAGMA max_page_count = {pages if broken else 2**30}")
        else:
            cursor.execute(f"PRAGMA query_only = {'ON' if broken else 'OFF'}")

    def turn(self, broken: bool) -> None:
        self.broken = broken
        if self.store.engine.dialect.name == "postgresql":
            url = self.store.engine.url
            address = url.set(drivername="postgresql", database="postgres").render_as_string(hide_password=False)
            with psycopg.connect(address, autocommit=True) as connection:
                connection.execute(
                    f"ALTER DATABASE {url.database} SET default_transaction_read_only = {'on' if broken else 'off'}"
                )
                connection.execute(
                    "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = %s", (url.database,)
                )


# PostgreSQL is made read-only in both cases: filling its disk would fill this machine's.
@pytest.fixture(params=[pytest.param("read-only", marks=pytest.mark.slow), "full"])
def switch(request: pytest.FixtureRequest, store: Store) -> Iterator[Switch]:
    made = Switch(store, request.param)
    yield made
    made.turn(False)


@contextmanager
def working(store: Store, settings: Settings) -> Iterator[Worker]:
    """A worker in a thread, as in its own process."""
    worker = Worker(store, RecordingWaker(), settings, Identity.new("embedded"))
    worker.start()

    def work() -> None:
        while not worker.stopping.is_set():
            try:
                job_id = worker.next_job()
            except StoreUnavailableError:
                job_id = None
            if job_id is None:
                worker.stopping.wait(0.02)
            else:
                worker.serve(job_id)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield worker
    finally:  # a thread that is left would keep the process of the tests from ending
        worker.stopping.set()
        thread.join(120.0)
        worker.close()
    assert not thread.is_alive()


def big() -> Any:
    """A problem that needs several pages of the file."""
    x = [i / 10 for i in range(400)]
    return line(observations=[{"series": "y", "points": {"x": x, "y": [2 * v + 1 for v in x]}}])


def test_the_state_is_clear_and_reading_goes_on(service: JobService, switch: Switch) -> None:
    kept = service.submit(line())[0]
    wait_for(lambda: service.health()["database"] == "ok", "a database that is ready")
    switch.turn(True)
    with pytest.raises(StoreUnavailableError, match=r"full|read-?only|query_only"):
        service.submit(big())
    assert [job.id for job in service.list().items] == [kept.id]
    assert service.get(kept.id).state == "queued"
    switch.turn(False)
    assert service.submit(big())[1]
    assert len(service.list().items) == 2


def test_readiness_tells_that_the_database_takes_nothing_in(store: Store, switch: Switch) -> None:
    probe = Probe(store, every=0.0)
    assert probe.database() == "ok"
    if switch.kind == "full" and store.engine.dialect.name == "sqlite":
        # A row that fits into its page still goes in; the probe tells when even that is impossible.
        switch.kind = "read-only"
    switch.turn(True)
    assert "can be read, but not written" in probe.database()
    switch.turn(False)
    assert probe.database() == "ok"


@pytest.mark.slow
def test_nothing_is_lost_and_work_goes_on_by_itself(
    store: Store, service: JobService, settings: Settings, switch: Switch, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = line(stopping={"max_evaluations": 120})
    expected = expected_history(problem)
    run = ClaimRunner.run
    claims: list[int] = []
    refused: list[int] = []

    def unwritable_from_the_25th(self: ClaimRunner) -> Submission:
        claims.append(1)
        if len(claims) == 25:
            switch.turn(True)
        return run(self)

    def stuck() -> int:
        """How many have come in when two more exchanges were in vain."""
        seen = len(refused)
        wait_for(lambda: len(refused) >= seen + 2, "refused exchanges")
        return service.get(job_id).evaluations

    monkeypatch.setattr(ClaimRunner, "run", unwritable_from_the_25th)
    with working(
        store, settings.model_copy(update={"local_batch_seconds": 0.0, "cheap_seconds": 0.0, "single_seconds": 0.0})
    ) as worker:
        exchange = worker.runtime.exchange

        def counted(*given: Any, **named: Any) -> Exchange:
            try:
                return exchange(*given, **named)
            except StoreUnavailableError:
                refused.append(1)
                raise

        monkeypatch.setattr(worker.runtime, "exchange", counted)
        job_id = service.submit(problem)[0].id
        before = stuck()
        assert before > 20
        assert stuck() - before <= 12  # some rows still fit into a page
        assert service.get(job_id).state == "running"
        switch.turn(False)
        wait_for(lambda: service.get(job_id).state == "finished", "the end of the job")
    assert recorded_history(service, job_id) == expected


def test_a_worker_does_not_ask_an_unwritable_database_without_a_pause(
    store: Store, service: JobService, settings: Settings, switch: Switch
) -> None:
    if switch.kind == "full":
        switch.kind = "read-only"
    job_id = service.submit(line())[0].id
    worker = Worker(store, RecordingWaker(), settings, Identity.new("embedded"))
    switch.turn(True)
    began = time.monotonic()
    worker.serve(job_id)
    assert time.monotonic() - began >= 0.9 * settings.poll_seconds
    assert service.get(job_id).state == "queued"


def test_the_probe_writes_seldom_however_often_it_is_asked(tmp_path: Path) -> None:
    store = Store(Settings(database_url=f"sqlite:///{tmp_path}/jobs.db"))
    writes: list[int] = []
    write = store.write
    store.write = lambda function: (writes.append(1), write(function))[1]  # type: ignore[method-assign, assignment]
    probe = Probe(store)
    assert {probe.database() for _ in range(50)} == {"ok"}
    assert len(writes) == 1
    store.close()
