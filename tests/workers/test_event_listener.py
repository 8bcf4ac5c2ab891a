"""The database tells of events, so that who listens need not look again and again."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from sqlalchemy import text

from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.event_listener import EventListener
from geoswarm.workers.waker import NoWaker
from tests.integration.engines import wait_for
from tests.workers.problems import line


@pytest.fixture
def postgres_store(fresh_postgres_url: str) -> Iterator[Store]:
    store = Store(Settings(database_url=fresh_postgres_url))
    yield store
    store.close()


def listeners(store: Store) -> list[int]:
    """Process numbers of the connections that listen."""
    query = text("SELECT pid FROM pg_stat_activity WHERE query LIKE 'LISTEN%' AND datname = current_database()")
    return list(store.read(lambda connection: connection.execute(query).scalars().all()))


def test_it_rings_when_events_are_committed_and_after_a_lost_connection(postgres_store: Store) -> None:
    woken = threading.Event()
    listener = EventListener(postgres_store, woken.set)
    service = JobService(postgres_store, NoWaker())
    listener.start()
    try:
        wait_for(lambda: listener.live and woken.is_set(), "a listener that listens")
        woken.clear()
        job = service.submit(line())[0].id
        wait_for(woken.is_set, "a wake-up for the new job")
        (pid,) = listeners(postgres_store)
        woken.clear()
        postgres_store.write(lambda connection: connection.execute(text(f"SELECT pg_terminate_backend({pid})")))
        wait_for(lambda: listeners(postgres_store) not in ([], [pid]) and listener.live, "another connection")
        wait_for(woken.is_set, "a wake-up for what may have come in between")
        woken.clear()
        service.cancel(job)
        wait_for(woken.is_set, "a wake-up for the cancelled job")
    finally:
        listener.stop()
    wait_for(lambda: not listeners(postgres_store), "the end of listening")
    assert not listener.live


def test_where_the_database_cannot_tell_it_is_never_live(store: Store) -> None:
    listener = EventListener(store, lambda: None)
    listener.start()
    on_postgres = store.engine.dialect.name == "postgresql"
    if on_postgres:
        wait_for(lambda: listener.live, "a listener that listens")
    assert listener.live is on_postgres
    listener.stop()
