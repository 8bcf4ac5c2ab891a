"""Listings of evaluations that answer at once however long the history is.

Going through a million rows in search of a few takes too long, and an index for every filter slows down every result
that comes in. So the rows of generations, which know their best objective, say where to look; failures, which are few,
have an index of their own; and what waits or runs is in the generation under evaluation.
"""

from __future__ import annotations

import base64
import binascii
import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, ScalarSelect, Select, select, text, tuple_

from geoswarm.records.states import UNDONE_STATES
from geoswarm.workers.errors import InvalidCursorError
from geoswarm.workers.store.codec import pack_json
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import evaluations, generations, jobs

__all__ = ["Filters", "decode_cursor", "encode_cursor", "list_evaluations"]

LIST_COLUMNS = [column for column in evaluations.columns if column.name != "responses"]


@dataclass(frozen=True, slots=True)
class Filters:
    """Which evaluations to list; None: any."""

    generation: int | None = None
    state: str | None = None
    max_objective: float | None = None


def list_evaluations(
    connection: Connection,
    job_id: str,
    filters: Filters,
    *,
    after: tuple[int, int] | None,
    limit: int,
    responses: bool,
) -> Sequence[Record]:
    """Return evaluations ordered by (generation, particle) that come after ``after``."""
    statement = _statement(job_id, filters, after, responses=responses).limit(limit)
    if filters.generation is not None:
        return connection.execute(statement.where(evaluations.c.generation == filters.generation)).all()
    if filters.state in UNDONE_STATES:
        return connection.execute(statement.where(evaluations.c.generation == _current(job_id))).all()
    if filters.max_objective is None or filters.state == "failed":
        return connection.execute(statement).all()
    # Each of these generations has a match, so this many are enough; one more when the page begins inside the first.
    numbers = select(generations.c.number).where(
        generations.c.job_id == job_id, generations.c.best_objective <= filters.max_objective
    )
    if after is not None:
        numbers = numbers.where(generations.c.number >= after[0])
    candidates = list(connection.scalars(numbers.order_by(generations.c.number).limit(limit + 1)))
    # The one under evaluation has no row of its own yet, and comes last.
    current = connection.scalar(select(jobs.c.generation).where(jobs.c.id == job_id))
    if len(candidates) <= limit and current is not None and current not in candidates:
        candidates.append(current)
    return connection.execute(statement.where(evaluations.c.generation.in_(candidates))).all()


def _statement(
    job_id: str, filters: Filters, after: tuple[int, int] | None, *, responses: bool
) -> Select[tuple[object, ...]]:
    statement: Select[tuple[object, ...]] = select(*(evaluations.columns if responses else LIST_COLUMNS))
    statement = statement.where(evaluations.c.job_id == job_id)
    if filters.state == "failed":  # as in the index: a bound value would not be recognised
        statement = statement.where(text("evaluations.state = 'failed'"))
    elif filters.state is not None:
        statement = statement.where(evaluations.c.state == filters.state)
    if filters.max_objective is not None:
        statement = statement.where(evaluations.c.objective <= filters.max_objective)
    if after is not None:
        statement = statement.where(tuple_(evaluations.c.generation, evaluations.c.particle) > after)
    return statement.order_by(evaluations.c.generation, evaluations.c.particle)


def _current(job_id: str) -> ScalarSelect[int]:
    return select(jobs.c.generation).where(jobs.c.id == job_id).scalar_subquery()


def encode_cursor(*key: float | str) -> str:
    """Return the cursor of a sort key."""
    return base64.urlsafe_b64encode(pack_json(key).encode()).decode().rstrip("=")


def decode_cursor(cursor: str, *types: type) -> Any:
    """Return the sort key of a cursor, whose parts must be of these types.

    Raises
    ------
    InvalidCursorError
    """
    try:
        padded = cursor.encode("ascii") + b"=" * (-len(cursor) % 4)
        key = json.loads(base64.b64decode(padded, altchars=b"-_", validate=True))
    except (binascii.Error, ValueError):
        raise InvalidCursorError(cursor) from None
    if not isinstance(key, list) or [type(part) for part in key] != list(types):
        raise InvalidCursorError(cursor)
    if not all("\0" not in part if isinstance(part, str) else 0 <= part < 2**40 for part in key):
        raise InvalidCursorError(cursor)
    return tuple(key)
