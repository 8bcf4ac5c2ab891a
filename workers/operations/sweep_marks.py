"""When all was last swept, and what one machine alone can see, in PostgreSQL: so that of many processes one does it.

A mark is a row of the counters. Nobody holds it: if the process that began a sweep dies, the next interval has another.
"""

from __future__ import annotations

from collections.abc import Collection

from sqlalchemy import ColumnElement, Connection, delete, not_, or_, select
from sqlalchemy.dialects.postgresql import insert

from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.tables import counters

__all__ = ["begin_sweep", "due_sweeps", "forget_marks"]

NAME = "sweep"
FORGET_SECONDS = 3600.0  # machines that have gone


def due_sweeps(connection: Connection, labels: Collection[str], seconds: float) -> list[str]:
    """Return those of the labels whose sweep nobody began in these seconds."""
    marks = counters.c.name == NAME, counters.c.label.in_(labels), not_(_old(seconds))
    fresh = set(connection.scalars(select(counters.c.label).where(*marks)))
    return [label for label in labels if label not in fresh]


def begin_sweep(connection: Connection, label: str, seconds: float) -> bool:
    """Note that this process sweeps now; False if another one has begun in these seconds."""
    statement = insert(counters).values(name=NAME, label=label, value=database_now())
    statement = statement.on_conflict_do_update(
        index_elements=[counters.c.name, counters.c.label], set_={"value": database_now()}, where=_old(seconds)
    )
    return connection.scalar(statement.returning(counters.c.label)) is not None


def forget_marks(connection: Connection, kept: Collection[str]) -> None:
    """Delete the marks of machines that have gone."""
    gone = counters.c.name == NAME, counters.c.label.not_in(kept), _old(FORGET_SECONDS)
    connection.execute(delete(counters).where(*gone))


def _old(seconds: float) -> ColumnElement[bool]:
    """Whether a mark is older than this, or of a clock that was set back since."""
    now = database_now()
    return or_(counters.c.value < now - seconds, counters.c.value > now + seconds)
