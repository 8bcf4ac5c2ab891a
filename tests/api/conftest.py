"""A real job service on an SQLite file, and the application on it."""

from __future__ import annotations

import asyncio
import shutil
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest

from geoswarm.api import ApiSettings, bind, create_app
from geoswarm.api.server import base_url, build_server
from geoswarm.records.job import Job
from geoswarm.records.states import ENDED_STATES
from geoswarm.workers.hosts.engine import Engine, open_engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.integration.engines import PATIENCE, wait_for

API = "/api/v1"
BROKEN = {"kind": "formula", "series": {"y": {"expression": "a + b * x + ln(0 - 1)"}}}
"""A forward model whose every run fails."""


def line_problem(**changes: Any) -> dict[str, Any]:
    """A straight line through three points, calibrated in 60 evaluations."""
    return {
        "name": "line",
        "forward_model": {"kind": "formula", "series": {"y": {"expression": "a + b * x"}}},
        "parameters": {"a": {"lower": -5, "upper": 5}, "b": {"lower": 0, "upper": 4}},
        "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [1, 3, 5]}}],
        "method": {"kind": "particle_swarm", "particles": 6},
        "stopping": {"max_evaluations": 60},
        "answer": {"max_evaluations": "off"},
        "seed": 7,
    } | changes


@pytest.fixture
def settings(tmp_path: Path, sqlite_template: Path) -> Settings:
    shutil.copy(sqlite_template, tmp_path / "jobs.db")
    # a worker whose heartbeat is late leaves its job to others: there are none here
    patient = {"lease_seconds": 600.0, "heartbeat_seconds": 150.0, "slice_seconds": 60.0}
    return Settings(database_url=f"sqlite:///{tmp_path}/jobs.db", workers=1, **patient)


@pytest.fixture
def service(settings: Settings) -> Iterator[JobService]:
    """No worker runs: submitted jobs stay queued."""
    store = Store(settings)
    made = JobService(store, NoWaker(), settings)
    yield made
    made.close()
    store.close()


class App:
    """Requests to an application in this process, without a network."""

    def __init__(self, service: JobService, settings: ApiSettings | None = None) -> None:
        self.app = create_app(service, settings)
        self.headers: dict[str, str] = {}

    def __call__(self, method: str, path: str, **request: Any) -> httpx.Response:
        async def send() -> httpx.Response:
            transport = httpx.ASGITransport(self.app, raise_app_exceptions=False)
            async with httpx.AsyncClient(
                transport=transport, base_url="http://localhost", headers=self.headers
            ) as client:
                return await client.request(method, path, **request)

        return asyncio.run(send())

    def get(self, path: str, **request: Any) -> httpx.Response:
        return self("GET", path, **request)

    def post(self, path: str, **request: Any) -> httpx.Response:
        return self("POST", path, **request)


@pytest.fixture
def app(service: JobService) -> App:
    return App(service)


class LiveServer:
    """A real server on a free loopback port, in a thread of its own."""

    def __init__(self, service: JobService, settings: ApiSettings | None = None, port: int = 0) -> None:
        self.listener = bind("127.0.0.1", port)
        self.url = base_url(self.listener)
        started = threading.Event()
        self.server = build_server(service, self.listener, settings, lambda _: started.set())
        self.feed = self.server.config.app.state.feed  # type: ignore[union-attr]
        self._thread = threading.Thread(target=self.server.run, kwargs={"sockets": [self.listener]})
        self._thread.start()
        assert started.wait(PATIENCE)

    def stop(self) -> None:
        """Stop gracefully."""
        self.server.should_exit = True
        self._thread.join(PATIENCE)
        self.listener.close()
        assert not self._thread.is_alive()


@contextmanager
def live_server(service: JobService, settings: ApiSettings | None = None, port: int = 0) -> Iterator[LiveServer]:
    server = LiveServer(service, settings, port)
    try:
        yield server
    finally:
        server.stop()


@pytest.fixture
def server(service: JobService) -> Iterator[LiveServer]:
    with live_server(service, ApiSettings(heartbeat_seconds=0.3, poll_seconds=0.05)) as running:
        yield running


def wait_until(condition: Callable[[], bool], seconds: float = PATIENCE) -> None:
    """Wait for something that happens in another thread."""
    wait_for(condition, "what another thread does", seconds)


@contextmanager
def small_engine(factory: pytest.TempPathFactory) -> Iterator[Engine]:
    """The embedded engine with one worker process."""
    with open_engine(Settings(database_url=f"sqlite:///{factory.mktemp('engine')}/jobs.db", workers=1)) as running:
        yield running


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Engine]:
    """An engine of a file; one that goes on would take what other tests of this process count (operations.counters)."""
    with small_engine(tmp_path_factory) as running:
        yield running


def wait_for_end(service: JobService, job_id: str, seconds: float = PATIENCE) -> Job:
    """Wait until the workers have ended a job."""
    wait_until(lambda: service.get(job_id).state in ENDED_STATES, seconds)
    return service.get(job_id)
