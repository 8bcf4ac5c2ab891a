"""A real service with an embedded engine, and both clients on it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from geoswarm import Client
from geoswarm.api import ApiSettings
from geoswarm.workers.hosts.engine import Engine
from tests.api.conftest import LiveServer, live_server, service, settings, small_engine

__all__ = ["client", "engine", "server", "service", "settings"]


@pytest.fixture(scope="package")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Engine]:
    """An engine without keys, in which the tests of all files have their jobs."""
    with small_engine(tmp_path_factory) as running:
        yield running


@pytest.fixture(scope="package")
def server(engine: Engine) -> Iterator[LiveServer]:
    with live_server(engine.service, ApiSettings(poll_seconds=0.05, heartbeat_seconds=0.3)) as running:
        yield running


@pytest.fixture
def client(server: LiveServer) -> Iterator[Client]:
    with Client(server.url) as opened:
        yield opened
