"""Listings of evaluations that answer at once however long the history is.

Going through a million rows in search of a few takes too long, and an index for every filter slows down every result
that comes in. So the rows of generations, which know their best objective, say where to look; failures, which are few,
have an index of their own; and what waits or runs is in the generation under evaluation. The first pages by objective
are in the generations with the best objectives, too.
"""

from __future__ import annotations

import base64
import binascii
import json
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    ScalarSelect,
    Select,
    TextClause,
    and_,
    func,
    select,
    text,
    tuple_,
)

from geoswarm.records.evaluation import EvaluationSort
from geoswarm.records.states import UNDONE_STATES
from geoswarm.workers.errors import InvalidCursorError
from geoswarm.workers.store.codec import pack_json
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import evaluations, generations, jobs

__all__ = ["Filters", "decode_cursor", "encode_cursor", "list_evaluations"]

LIST_COLUMNS = [column for column in evaluations.columns if column.name != "responses"]
PLACE = (evaluations.c.generation, evaluations.c.particle)
# what has no objective comes last
BY_OBJECTIVE = (func.coalesce(evaluations.c.objective, sys.float_info.max), *PLACE)


@dataclass(frozen=True, slots=True)
class Filters:
    """Which evaluations to list, None: any, and in what order.

    Parameters
    ----------
    sort
        By generation and particle, or by objective, the lowest first, ties by generation and particle, what has no
        objective last.
    """

    generation: int | None = None
    state: str | None = None
    max_objective: float | None = None
    sort: EvaluationSort = "generation"

    def cursor(self, row: Any) -> str:
        """Return the cursor of what comes after a row in this order."""
        if self.sort == "generation":
            return encode_cursor(row.generation, row.particle)
        value = sys.float_info.max if row.objective is None else row.objective
        return encode_cursor(self.sort, repr(float(value)), row.generation, row.particle)

    def after(self, cursor: str) -> tuple[Any, ...]:
        """Return the place of a cursor in this order.

        Raises
        ------
        InvalidCursorError
            Also when it belongs to another order.
        """
        if self.sort == "generation":
            place: tuple[int, int] = decode_cursor(cursor, int, int)
            return place
        sort, value, generation, particle = decode_cursor(cursor, str, str, int, int)
        try:
            number = float(value)
        except ValueError:
            raise InvalidCursorError(cursor) from None
        if sort != self.sort or not math.isfinite(number):
            raise InvalidCursorError(cursor)
        return number, generation, particle


def list_evaluations(
    connection: Connection,
    job_id: str,
    filters: Filters,
    *,
    after: tuple[Any, ...] | None,
    limit: int,
    responses: bool,
) -> Sequence[Record]:
    """Return evaluations in the order of ``filters`` that come after the place ``after``."""
    if filters.sort == "objective" and filters.state in (None, "finished"):  # the others have no objective
        return _by_objective(connection, job_id, filters, after=after, limit=limit, responses=responses)
    statement = _select(responses).where(*_conditions(job_id, filters)).order_by(*PLACE).limit(limit)
    if after is not None:
        statement = statement.where(tuple_(*PLACE) > after[-2:])
    if filters.max_objective is None or filters.generation is not None or filters.state in (*UNDONE_STATES, "failed"):
        return connection.execute(statement).all()
    # Each of these generations has a match, so this many are enough; one more when the page begins inside the first.
    numbers = select(generations.c.number).where(
        generations.c.job_id == job_id, generations.c.best_objective <= filters.max_objective
    )
    if after is not None:
        numbers = numbers.where(generations.c.number >= after[-2])
    candidates = list(connection.scalars(numbers.order_by(generations.c.number).limit(limit + 1)))
    # The one under evaluation has no row of its own yet, and comes last.
    current = connection.scalar(select(jobs.c.generation).where(jobs.c.id == job_id))
    if len(candidates) <= limit and current is not None and current not in candidates:
        candidates.append(current)
    return connection.execute(statement.where(evaluations.c.generation.in_(candidates))).all()


def _by_objective(
    connection: Connection,
    job_id: str,
    filters: Filters,
    *,
    after: tuple[Any, ...] | None,
    limit: int,
    responses: bool,
) -> Sequence[Record]:
    places = select(*PLACE).where(*_conditions(job_id, filters))
    if after is not None:
        places = places.where(tuple_(*BY_OBJECTIVE) > after)
    if filters.generation is None:
        # As many generations have their best in the rest of the order: the page ends before the worst of these bests.
        bests = select(generations.c.best_objective).where(generations.c.job_id == job_id)
        bests = bests.where(
            generations.c.best_objective.is_not(None) if after is None else generations.c.best_objective > after[0]
        )
        worst = connection.scalar(bests.order_by(generations.c.best_objective).offset(limit - 1).limit(1))
        if worst is not None:
            good = select(generations.c.number).where(
                generations.c.job_id == job_id, generations.c.best_objective <= worst
            )
            current = select(jobs.c.generation).where(jobs.c.id == job_id)  # has no row of its own yet
            places = places.where(evaluations.c.generation.in_(good.union(current)))
    chosen = places.order_by(*BY_OBJECTIVE).limit(limit).subquery()
    here = and_(PLACE[0] == chosen.c.generation, PLACE[1] == chosen.c.particle)
    statement = _select(responses).join(chosen, here).where(evaluations.c.job_id == job_id)
    return connection.execute(statement.order_by(*BY_OBJECTIVE)).all()


def _select(responses: bool) -> Select[Any]:
    return select(*(evaluations.columns if responses else LIST_COLUMNS))


def _conditions(job_id: str, filters: Filters) -> list[ColumnElement[bool] | TextClause]:
    conditions: list[ColumnElement[bool] | TextClause] = [evaluations.c.job_id == job_id]
    if filters.generation is not None:
        conditions.append(evaluations.c.generation == filters.generation)
    elif filters.state in UNDONE_STATES:
        conditions.append(evaluations.c.generation == _current(job_id))
    if filters.state == "failed":  # as in the index: a bound value would not be recognised
        conditions.append(text("evaluations.state = 'failed'"))
    elif filters.state is not None:
        conditions.append(evaluations.c.state == filters.state)
    if filters.max_objective is not None:
        conditions.append(evaluations.c.objective <= filters.max_objective)
    return conditions


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
