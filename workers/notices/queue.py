"""Deliveries in the database: which are due, which process holds them, how they ended."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy import Connection, and_, delete, func, insert, or_, select, update

from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import deliveries, hooks

__all__ = [
    "any_due",
    "forget_old",
    "hold_due",
    "insert_delivery",
    "keep_body",
    "note_delivered",
    "note_failure",
]

KEPT_SECONDS = 30 * 86_400.0
"""Deliveries that have ended are listed for so long."""

_DUE = and_(
    deliveries.c.state == "waiting",
    deliveries.c.due_at <= database_now(),
    or_(deliveries.c.held_until.is_(None), deliveries.c.held_until <= database_now()),
)


def any_due(connection: Connection) -> bool:
    """Whether something is to be delivered now."""
    return connection.scalar(select(deliveries.c.id).where(_DUE).limit(1)) is not None


def hold_due(connection: Connection, most: int, seconds: float) -> Sequence[Record]:
    """Take deliveries that are due, one of each hook, for some time [s]; return them with what their hook says.

    The try counts at once: a process lost in mid-try has made it, and another process makes the next one.
    """
    busy = select(deliveries.c.hook_id).where(deliveries.c.state == "waiting", deliveries.c.held_until > database_now())
    first = (
        select(func.min(deliveries.c.id))
        .where(_DUE, deliveries.c.hook_id.not_in(busy))
        .group_by(deliveries.c.hook_id)
        .order_by(func.min(deliveries.c.due_at))
        .limit(most)
    )
    chosen = select(deliveries.c.id).where(deliveries.c.id.in_(first)).with_for_update(skip_locked=True)
    ids = connection.scalars(chosen).all()
    if not ids:
        return []
    held = {"tries": deliveries.c.tries + 1, "held_until": database_now() + seconds}
    # A process that waited for the lock of a row that another one has just taken finds it held.
    taken = update(deliveries).where(deliveries.c.id.in_(ids), _DUE).values(held).returning(deliveries.c.id)
    mine = connection.scalars(taken).all()
    columns = (
        deliveries.c.id,
        deliveries.c.hook_id,
        deliveries.c.job_id,
        deliveries.c.job_state,
        deliveries.c.tries,
        deliveries.c.body,
        deliveries.c.created_at,
        hooks.c.kind,
        hooks.c.target,
        hooks.c.secret,
    )
    return connection.execute(
        select(*columns).join(hooks, hooks.c.id == deliveries.c.hook_id).where(deliveries.c.id.in_(mine))
    ).all()


def keep_body(connection: Connection, delivery_id: int, body: str) -> None:
    """Keep the body, so that every try sends the same."""
    connection.execute(update(deliveries).where(deliveries.c.id == delivery_id).values(body=body))


def note_delivered(connection: Connection, delivery_id: int) -> None:
    """Note that it was taken."""
    values = {"state": "delivered", "held_until": None, "error": None, "ended_at": database_now()}
    connection.execute(update(deliveries).where(deliveries.c.id == delivery_id).values(values))


def note_failure(connection: Connection, delivery_id: int, error: str, again: float | None) -> None:
    """Note why a try failed, and when the next one is due [s from now]; None: it is given up."""
    values = {"held_until": None, "error": error}
    more = {"state": "given_up", "ended_at": database_now()} if again is None else {"due_at": database_now() + again}
    connection.execute(update(deliveries).where(deliveries.c.id == delivery_id).values({**values, **more}))


def insert_delivery(connection: Connection, hook_id: str, job_id: str | None, job_state: str) -> None:
    """Enter a message about a job that has ended, or, with ``test`` for its state, one that only tests the hook."""
    values = {"hook_id": hook_id, "job_id": job_id, "job_state": job_state, "state": "waiting", "tries": 0}
    now = database_now()
    connection.execute(insert(deliveries).values(**values, due_at=now, created_at=now))


def forget_old(connection: Connection) -> None:
    """Remove deliveries that ended long ago."""
    connection.execute(delete(deliveries).where(deliveries.c.ended_at < database_now() - KEPT_SECONDS))
