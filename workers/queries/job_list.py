"""The list of jobs: filtered, searched, sorted, in pages that miss and repeat no job while others are submitted."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from sqlalchemy import (
    ARRAY,
    ColumnElement,
    Connection,
    Integer,
    Select,
    String,
    and_,
    bindparam,
    exists,
    func,
    or_,
    select,
    tuple_,
    update,
)

from geoswarm.workers.errors import InvalidCursorError
from geoswarm.workers.queries.jobs import VIEW_COLUMNS
from geoswarm.workers.queries.listing import decode_cursor, encode_cursor
from geoswarm.workers.queries.selection import spaced
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import generations, jobs

__all__ = ["JobFilters", "SortKey", "count_by_parent", "count_jobs", "label_job", "list_jobs", "list_trends"]

SortKey: TypeAlias = Literal["created", "finished", "name", "objective", "evaluations", "seconds"]

NAME_LETTERS = 40
LARGEST = 1.7e308  # stands for what is not there, so that it comes last
COLUMNS: Mapping[SortKey, ColumnElement[Any]] = {
    "created": jobs.c.created_at,
    "finished": jobs.c.finished_at,
    "name": func.substr(func.lower(jobs.c.name), 1, NAME_LETTERS),  # a cursor holds it
    "objective": jobs.c.objective,
    "evaluations": jobs.c.evaluations,
    "seconds": jobs.c.run_seconds,
}
ASCENDING_BY_ITSELF = ("name", "objective")
TREND_JOBS_A_QUERY = 50


@dataclass(frozen=True, slots=True)
class JobFilters:
    """Which jobs to list, and in what order.

    Parameters
    ----------
    states
        Only jobs in one of these; empty: in any.
    text
        Only jobs with it in their name, forward model, method, owner or tags, or at the beginning of their id.
    owner
        Only jobs of this one.
    tag
        Only jobs with this tag.
    parents
        Only follow-ups of these jobs; empty: only jobs that are no follow-ups of a job that may be seen; None: all.
    sort, ascending
        Order; ``ascending`` None: newest, best or largest first, names from A to Z. What has no value comes last.
    """

    states: tuple[str, ...] = ()
    text: str | None = None
    owner: str | None = None
    sort: SortKey = "created"
    ascending: bool | None = None
    tag: str | None = None
    parents: tuple[str, ...] | None = None

    @property
    def rising(self) -> bool:
        """Whether the smallest comes first."""
        return self.sort in ASCENDING_BY_ITSELF if self.ascending is None else self.ascending


def list_jobs(
    connection: Connection, filters: JobFilters, *, owner: str | None, limit: int, cursor: str | None
) -> tuple[Sequence[Record], str | None]:
    """Return one page of jobs and the cursor of the next one, None: it is the last.

    Parameters
    ----------
    owner
        Whose jobs may be seen; None: all.

    Raises
    ------
    InvalidCursorError
        When the cursor does not belong to this order.
    """
    key = _key(filters)
    statement = select(*VIEW_COLUMNS, key.label("sort_key"), database_now().label("now"))
    statement = statement.where(*_conditions(filters, owner))
    if cursor is not None:
        place = tuple_(key, jobs.c.id)
        after = _decoded(filters, cursor)
        statement = statement.where(place > after if filters.rising else place < after)
    order = (key.asc(), jobs.c.id.asc()) if filters.rising else (key.desc(), jobs.c.id.desc())
    rows = connection.execute(statement.order_by(*order).limit(limit + 1)).all()
    if len(rows) <= limit:
        return rows, None
    last = rows[limit - 1]
    value = last.sort_key if isinstance(last.sort_key, str) else repr(float(last.sort_key))
    return rows[:limit], encode_cursor(_order(filters), value, last.id)


def count_jobs(connection: Connection, filters: JobFilters, *, owner: str | None) -> int:
    """Return the number of jobs that match, on all pages together; ``owner`` as for :func:`list_jobs`."""
    statement = select(func.count()).select_from(jobs).where(*_conditions(filters, owner))
    return connection.scalar(statement) or 0


def count_by_parent(connection: Connection, parents: Sequence[str], *, owner: str | None) -> dict[str, int]:
    """Return the number of follow-ups of each of some jobs, those without any left out."""
    conditions = _conditions(JobFilters(parents=tuple(parents)), owner)
    statement = select(jobs.c.parent, func.count()).where(*conditions).group_by(jobs.c.parent)
    return {row[0]: row[1] for row in connection.execute(statement)}


def label_job(
    connection: Connection, job_id: str, tags: Collection[str] | None, note: str | None, name: str | None
) -> None:
    """Replace the tags of a job, its note, or its name; None leaves them. Its stored problem keeps its first name."""
    values = {} if tags is None else {"tags": _as_lines(tags)}
    values |= {} if note is None else {"note": note}
    values |= {} if name is None else {"name": name}
    if values:
        connection.execute(update(jobs).where(jobs.c.id == job_id).values(values))


def _as_lines(tags: Collection[str]) -> str:
    """Tags as they are stored: sorted, each between two line ends."""
    return "".join(f"\n{tag}" for tag in sorted(set(tags))) + "\n" * bool(tags)


def list_trends(connection: Connection, totals: Mapping[str, int], points: int) -> dict[str, list[float | None]]:
    """Return the lowest objective so far of each job at evenly spaced generations, the last one included.

    Parameters
    ----------
    totals
        Number of finished generations of each job.
    points
        Most values a job.
    """
    numbers = {job_id: spaced(total, points) for job_id, total in totals.items() if total > 0}
    trends: dict[str, list[float | None]] = {job_id: [] for job_id in totals}
    find = _listed_generations if connection.dialect.name == "postgresql" else _named_generations
    ids = list(numbers)
    for start in range(0, len(ids), TREND_JOBS_A_QUERY):
        statement = find({job_id: numbers[job_id] for job_id in ids[start : start + TREND_JOBS_A_QUERY]})
        for row in connection.execute(statement.order_by(generations.c.job_id, generations.c.number)):
            trends[row.job_id].append(row.objective)
    return trends


def _named_generations(numbers: Mapping[str, Sequence[int]]) -> Select[Any]:
    """Ask for generations, each named in the query."""
    wanted = or_(
        *(and_(generations.c.job_id == job_id, generations.c.number.in_(of)) for job_id, of in numbers.items())
    )
    return select(generations.c.job_id, generations.c.objective).where(wanted)


def _listed_generations(numbers: Mapping[str, Sequence[int]]) -> Select[Any]:
    """Ask for generations with two lists: PostgreSQL plans 1600 names for longer than it looks for them."""
    pairs = [(job_id, number) for job_id, of in numbers.items() for number in of]
    ids = bindparam("ids", [job_id for job_id, _ in pairs], type_=ARRAY(String))
    places = bindparam("numbers", [number for _, number in pairs], type_=ARRAY(Integer))
    wanted = func.unnest(ids, places).table_valued("job_id", "number").render_derived()
    return select(generations.c.job_id, generations.c.objective).join(
        wanted, and_(generations.c.job_id == wanted.c.job_id, generations.c.number == wanted.c.number)
    )


def _conditions(filters: JobFilters, owner: str | None) -> list[ColumnElement[bool]]:
    conditions: list[ColumnElement[bool]] = [] if owner is None else [jobs.c.owner == owner]
    if filters.states:
        conditions.append(jobs.c.state.in_(filters.states))
    if filters.owner is not None:
        conditions.append(jobs.c.owner == filters.owner)
    if filters.parents is not None:
        conditions.append(jobs.c.parent.in_(filters.parents) if filters.parents else _above(owner))
    if filters.tag:
        conditions.append(jobs.c.tags.contains(_as_lines([filters.tag]), autoescape=True))
    if filters.text:
        text = filters.text.lower()
        columns = (jobs.c.name, jobs.c.forward_model, jobs.c.method, jobs.c.owner, jobs.c.tags)
        found = [func.lower(column).contains(text, autoescape=True) for column in columns]
        conditions.append(or_(*found, jobs.c.id.startswith(text, autoescape=True)))
    return conditions


def _above(owner: str | None) -> ColumnElement[bool]:
    """Jobs that are no follow-ups, or whose job no list of the owner shows, as it is another owner's."""
    follows_none = jobs.c.parent.is_(None)
    if owner is None:
        return follows_none
    shown = jobs.alias()
    return or_(follows_none, ~exists().where(shown.c.id == jobs.c.parent, shown.c.owner == owner))


def _key(filters: JobFilters) -> ColumnElement[Any]:
    column = COLUMNS[filters.sort]
    if filters.sort in ("finished", "objective"):
        return func.coalesce(column, LARGEST if filters.rising else -LARGEST)
    return column


def _order(filters: JobFilters) -> str:
    return f"{filters.sort} {'rising' if filters.rising else 'falling'}"


def _decoded(filters: JobFilters, cursor: str) -> tuple[Any, str]:
    order, value, job_id = decode_cursor(cursor, str, str, str)
    if order != _order(filters):
        raise InvalidCursorError(cursor)
    if filters.sort == "name":
        return value, job_id
    try:
        number = float(value)
    except ValueError:
        raise InvalidCursorError(cursor) from None
    if not math.isfinite(number):
        raise InvalidCursorError(cursor)
    return number, job_id
