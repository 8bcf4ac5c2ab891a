"""Keys and operations by both clients, on a service that asks for keys."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator

import pytest

from geoswarm import AsyncClient, Client, InvalidProblemError, NotFoundError, UnauthorizedError
from geoswarm.api import ApiSettings
from geoswarm.workers.access.keys import KEY_PATTERN, ApiKeys
from geoswarm.workers.hosts.engine import Engine
from tests.api.conftest import LiveServer, line_problem, live_server, small_engine
from tests.integration.engines import PATIENCE


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Engine]:
    """An engine of this file: the first key closes a service to those without one."""
    with small_engine(tmp_path_factory) as running:
        yield running


@pytest.fixture(scope="module")
def root(engine: Engine) -> str:
    """The key of an administrator."""
    return ApiKeys(engine.service.store).create("root", "admin")[0]


@pytest.fixture(scope="module")
def keyed(engine: Engine) -> Iterator[LiveServer]:
    with live_server(engine.service, ApiSettings(require_key=True)) as running:
        yield running


def test_a_key_is_made_used_and_revoked(keyed: LiveServer, root: str) -> None:
    with Client(keyed.url, root) as admin:
        made = admin.create_key("anna", "read", label="laptop", valid_seconds=3600.0)
        assert KEY_PATTERN.fullmatch(made.key) is not None
        assert made.key not in repr(made)
        view = made.view
        assert (view.owner, view.role, view.label, view.state) == ("anna", "read", "laptop", "active")
        assert made.view.expires_at is not None
        listed = admin.keys()
        assert made.view.id in [key.id for key in listed]
        with Client(keyed.url, made.key) as anna:
            who = anna.session()
            assert (who.owner, who.role, who.key_needed, who.signed_in) == ("anna", "read", True, False)
            with pytest.raises(UnauthorizedError, match="this needs 'admin'"):
                anna.keys()
            assert admin.revoke_key(made.view.id).state == "revoked"
            with pytest.raises(UnauthorizedError, match="not valid"):
                anna.session()
        with pytest.raises(NotFoundError):
            admin.revoke_key("0" * 12)
        with pytest.raises(ValueError, match="key_id is empty"):
            admin.revoke_key("")
        with pytest.raises(InvalidProblemError, match="owner"):
            admin.create_key("an na")


def test_operations_count_jobs_and_runs(keyed: LiveServer, root: str) -> None:
    with Client(keyed.url, root) as admin:
        admin.wait(admin.submit(line_problem()).id, timeout=PATIENCE)
        found = admin.operations()
    assert found.jobs["finished"] >= 1
    assert sum(found.workers.values()) == 1
    assert found.oldest_wait >= 0.0


def test_the_asynchronous_client_does_the_same(keyed: LiveServer, root: str) -> None:
    async def session() -> None:
        async with AsyncClient(keyed.url, root) as admin:
            assert (await admin.session()).role == "admin"
            made = await admin.create_key("ben")
            assert (made.view.role, made.view.expires_at) == ("submit", None)
            listed = await admin.keys()
            assert "ben" in [key.owner for key in listed]
            assert (await admin.revoke_key(made.view.id)).revoked_at is not None
            assert set((await admin.operations()).workers) == {"idle", "busy", "lost"}

    asyncio.run(session())
