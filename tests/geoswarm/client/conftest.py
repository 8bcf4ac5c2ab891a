"""A real service with an embedded engine, and both clients on it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from geoswarm import Client
from geoswarm.api import ApiSettings
from geoswarm.workers.hosts.engine import Engine, open_engine
from geoswarm.workers.settings import Settings
from tests.api.conftest import LiveServer, live_server


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Engine]:
    folder = tmp_path_factory.mktemp("engine")
    with open_engine(Settings(database_url=f"sqlite:///{folder}/jobs.db", workers=1)) as running:
        yield running


@pytest.fixture(scope="module")
def server(engine: Engine) -> Iterator[LiveServer]:
    with live_server(engine.service, ApiSettings(poll_seconds=0.05, heartbeat_seconds=0.3)) as running:
        yield running


@pytest.fixture
def client(server: LiveServer) -> Iterator[Client]:
    with Client(server.url) as opened:
        yield opened
