"""Stores of both kinds, and workers that live in the test's own process."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from geoswarm.workers.execution.worker import Worker
from geoswarm.workers.identity import Identity
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import metadata
from tests.servers import PostgresServer
from tests.variants import variants

MakeWorker: TypeAlias = Callable[..., Worker]
ON_SQLITE = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
"""For what no database makes different."""
ON_SQLITE_FIRST = pytest.mark.parametrize(
    "database_url", ["sqlite", pytest.param("postgresql", marks=pytest.mark.slow)], indirect=True
)
"""For the statistics at the end of a job: other tests compare the evaluations that they read from both databases."""


class RecordingWaker:
    """Remembers the wake-ups."""

    def __init__(self) -> None:
        self.wakes: list[str] = []

    def wake(self, job_id: str, times: int = 1, kind: str = "") -> None:  # noqa: ARG002
        self.wakes += [job_id] * times

    def health(self) -> str:
        return "embedded"

    def close(self) -> None:
        self.wakes.clear()


@pytest.fixture(params=["sqlite", "postgresql"])
def empty_database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Address of an empty database, of each kind in turn."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'jobs.db'}"
    url: str = request.getfixturevalue("fresh_postgres_url")
    return url


@pytest.fixture(scope="session")
def postgres_tables(postgres_server: PostgresServer) -> str:
    """Address of a database with all tables, which the tests of a process use in turn."""
    postgres_server.start()
    url = postgres_server.create_database()
    Store(Settings(database_url=url)).close()
    return url


# PostgreSQL locks rows, so it can go wrong in more ways; tests of API, command line and engine run on SQLite.
@pytest.fixture(params=variants(["sqlite", "postgresql"], {"postgresql"}))
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """Address of a database that has its tables and nothing in them, of each kind in turn."""
    if request.param == "sqlite":
        shutil.copy(request.getfixturevalue("sqlite_template"), tmp_path / "jobs.db")
        yield f"sqlite:///{tmp_path / 'jobs.db'}"
        return
    server: PostgresServer = request.getfixturevalue("postgres_server")
    url: str = request.getfixturevalue("postgres_tables")
    server.start()
    yield url
    server.start()
    server.empty(url, [table.name for table in metadata.sorted_tables])


@pytest.fixture
def settings(database_url: str) -> Settings:
    """Settings with times that no busy machine reaches; a test that needs more time to have passed moves it."""
    return Settings(
        database_url=database_url,
        workers=2,
        lease_seconds=600.0,
        heartbeat_seconds=150.0,
        sweep_seconds=150.0,
        isolate=False,
        slice_seconds=600.0,
        overdue_seconds=600.0,
    )


@pytest.fixture
def store(settings: Settings) -> Iterator[Store]:
    """An open store."""
    opened = Store(settings)
    yield opened
    opened.close()


@pytest.fixture
def waker() -> RecordingWaker:
    """A waker that remembers."""
    return RecordingWaker()


@pytest.fixture
def service(store: Store, waker: RecordingWaker, settings: Settings) -> JobService:
    """The service on the store."""
    return JobService(store, waker, settings)


@pytest.fixture
def make_worker(store: Store, waker: RecordingWaker, settings: Settings) -> Iterator[MakeWorker]:
    """Make a worker that the test drives itself; keywords change the settings."""
    made: list[Worker] = []

    def make(**changes: Any) -> Worker:
        made.append(Worker(store, waker, settings.model_copy(update=changes), Identity.new("embedded")))
        return made[-1]

    yield make
    for worker in made:
        worker.heartbeat.stop()  # a test that fails leaves none behind, which would disturb others
