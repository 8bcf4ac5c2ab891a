"""Leases of a slow database, and what an evaluation costs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial

import pytest
from sqlalchemy import Connection, func, select, text, update

from geoswarm.workers.coordinator.job_exchange import _typical
from geoswarm.workers.identity import Identity
from geoswarm.workers.queries.jobs import lock_job
from geoswarm.workers.queries.queue import note_served
from geoswarm.workers.queries.workers import register_worker
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.tables import attempts, evaluations
from tests.integration.engines import wait_for
from tests.workers.hand import PROBLEM, Hand, runtime_for


@pytest.fixture
def job_id(service: JobService) -> str:
    return service.submit(PROBLEM)[0].id


def test_a_lease_that_ends_while_its_worker_is_heard_of_is_no_try(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    runtime = runtime_for(store, settings, lease_seconds=600.0)
    hand = Hand(runtime, job_id, "w1")
    hand.take()
    assert hand.claim is not None
    store.write(lambda c: register_worker(c, Identity("w1", "elsewhere", 1, "another machine", "celery")))

    def late(seconds: float) -> None:
        store.write(
            lambda c: c.execute(
                update(evaluations)
                .where(evaluations.c.worker == "w1")
                .values(lease_expires_at=evaluations.c.started_at - seconds)
            )
        )

    late(1.0)
    assert runtime.expire(job_id, 0, []) == 0  # its word is on its way
    late(1000.0)
    assert runtime.expire(job_id, 0, []) == 1  # others may have it
    first = service.evaluations(job_id).items[0]
    assert (first.state, first.attempts) == ("pending", 0)
    assert store.read(lambda c: c.execute(select(attempts)).all()) == []
    hand.submit()  # and it comes all the same
    first = service.evaluations(job_id).items[0]
    assert (first.state, first.worker) == ("finished", "w1")


LEASE = 1.0
PASS_A_LEASE = select(func.pg_sleep(1.2 * LEASE))


@pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)
@pytest.mark.parametrize("briefly", [False, True])
def test_the_time_of_a_locked_row_is_that_after_the_wait(store: Store, job_id: str, briefly: bool) -> None:
    began: list[float] = []

    def wait(connection: Connection) -> None:
        locked = lock_job(connection, job_id, briefly=briefly)
        assert locked is not None
        began.append(locked.now)

    released = held_meanwhile(store, job_id, lambda: store.write(wait))
    assert began[0] >= released


@pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)
def test_a_lease_that_waited_for_the_job_begins_after_the_wait(store: Store, settings: Settings, job_id: str) -> None:
    runtime = runtime_for(store, settings, lease_seconds=LEASE)
    Hand(runtime, job_id, "w1").take()
    waiting = Hand(runtime, job_id, "w2")
    released = held_meanwhile(store, job_id, waiting.take)
    assert waiting.claim is not None
    assert waiting.claim.now >= released
    ends = select(evaluations.c.lease_expires_at).where(evaluations.c.worker == "w2")
    assert store.read(lambda c: c.execute(ends).scalar_one()) >= released + LEASE


@pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)
def test_a_lease_does_not_wait_for_the_turn_of_its_owner(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    other = service.submit(PROBLEM)[0].id
    hand = Hand(runtime_for(store, settings), job_id, "w1")

    def take_meanwhile(connection: Connection) -> None:
        locked = lock_job(connection, other)
        assert locked is not None
        note_served(connection, locked.row)
        taking = threading.Thread(target=hand.take, daemon=True)
        taking.start()
        taking.join(120.0)
        assert not taking.is_alive(), "it waits for the turn"

    store.write(take_meanwhile)
    assert hand.claim is not None


def held_meanwhile(store: Store, job_id: str, work: Callable[[], object]) -> float:
    """Hold a job's row for longer than a lease, unchanged, while this work waits for it; return when it was let go."""
    held, let_go = threading.Event(), threading.Event()
    released: list[float] = []

    def hold(connection: Connection) -> None:
        lock_job(connection, job_id)
        held.set()
        assert let_go.wait(120.0), "nobody waited for the row"
        connection.execute(PASS_A_LEASE)
        released.append(connection.execute(select(database_now())).scalar_one())

    threads = [threading.Thread(target=target) for target in (partial(store.write, hold), work)]
    threads[0].start()
    assert held.wait(120.0), "the row was not locked"
    threads[1].start()
    waiting = text("SELECT count(*) FROM pg_locks WHERE NOT granted")
    wait_for(lambda: store.read(lambda c: c.execute(waiting).scalar_one()) > 0, "a wait for the row")
    let_go.set()
    for thread in threads:
        thread.join(120.0)
    return released[0]


# With SQLite one transaction writes at a time: the lease waits, and ends all others that do.
@pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)
def test_a_lease_is_renewed_while_the_row_of_the_job_is_locked(store: Store, settings: Settings, job_id: str) -> None:
    runtime = runtime_for(store, settings)
    hand = Hand(runtime, job_id, "w1")
    hand.take()
    assert hand.claim is not None

    def renew_meanwhile(connection: Connection) -> None:
        lock_job(connection, job_id)
        assert hand.claim is not None
        renewing = threading.Thread(target=runtime.renew, args=(hand.claim, "w1"), daemon=True)
        renewing.start()
        renewing.join(120.0)
        assert not renewing.is_alive(), "it waits for the row"

    store.write(renew_meanwhile)


def test_failures_that_take_long_count_in_what_an_evaluation_costs() -> None:
    quick: list[tuple[float | None, str | None]] = [(0.001, None)] * 14
    slow: list[tuple[float | None, str | None]] = [(30.0, "timeout")] * 2
    assert _typical(quick, None) == 0.001
    assert _typical([*quick, *slow], None) == pytest.approx(3.75, rel=1e-2)
    assert _typical(slow, 0.5) == 0.5
    assert _typical([*quick, (0.0, "infeasible")], None) == 0.001
