"""Stores of both kinds, and workers that live in the test's own process."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from geoswarm.workers.execution.worker import Worker
from geoswarm.workers.identity import Identity
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store

MakeWorker: TypeAlias = Callable[..., Worker]


class RecordingDoorbell:
    """Remembers the rings."""

    def __init__(self) -> None:
        self.rings: list[str] = []

    def ring(self, job_id: str, times: int = 1, kind: str = "") -> None:  # noqa: ARG002
        self.rings += [job_id] * times

    def health(self) -> str:
        return "embedded"

    def close(self) -> None:
        self.rings.clear()


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Address of an empty database, of each kind in turn."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'jobs.db'}"
    url: str = request.getfixturevalue("fresh_postgres_url")
    return url


@pytest.fixture
def settings(database_url: str) -> Settings:
    """Settings with short times."""
    return Settings(
        database_url=database_url,
        workers=2,
        lease_seconds=1.0,
        heartbeat_seconds=0.2,
        sweep_seconds=0.1,
        isolate=False,
        slice_seconds=60,
    )


@pytest.fixture
def store(settings: Settings) -> Iterator[Store]:
    """An open store."""
    opened = Store(settings)
    yield opened
    opened.close()


@pytest.fixture
def doorbell() -> RecordingDoorbell:
    """A doorbell that remembers."""
    return RecordingDoorbell()


@pytest.fixture
def service(store: Store, doorbell: RecordingDoorbell, settings: Settings) -> JobService:
    """The service on the store."""
    return JobService(store, doorbell, settings)


@pytest.fixture
def make_worker(store: Store, doorbell: RecordingDoorbell, settings: Settings) -> MakeWorker:
    """Make a worker that the test drives itself; keywords change the settings."""

    def make(**changes: Any) -> Worker:
        return Worker(store, doorbell, settings.model_copy(update=changes), Identity.new("embedded"))

    return make
