"""The lines in which jobs wait for workers: one for each owner, served in turn.

The line that was served longest ago comes first, and in it the job that has waited longest. One step of a job's
priority counts as much as ten seconds of waiting, so that no job waits forever: in its own line, and among the lines
only where an administrator gave it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import lru_cache
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    Double,
    ScalarSelect,
    Select,
    TextClause,
    and_,
    bindparam,
    case,
    func,
    literal,
    or_,
    select,
    text,
    true,
    update,
)
from sqlalchemy.sql.dml import ReturningUpdate

from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import OPEN, evaluations, jobs, turns

__all__ = [
    "REOPENED",
    "claimable_jobs",
    "first_place",
    "mark_rung",
    "most_urgent_job",
    "note_served",
    "note_typical",
    "open_needs",
    "take_turn",
]

SECONDS_A_PRIORITY = 10.0
CLOCK_STEP = 1e-6  # [s], four times what a float of seconds since 1970 can tell apart

REOPENED = "evaluations.state = 'pending' AND evaluations.reason IS NOT NULL"
"""Failed evaluations that are to be run again; word for word as in their index."""

WAITING = text(f"jobs.{OPEN}")  # word for word as in the indices of lines and places


def first_place(priority: int, created_at: float | None = None) -> ColumnElement[float]:
    """Return the place of a job that was not served yet, entered at a time [s], by default now: it comes soon."""
    since = database_now() if created_at is None else literal(created_at)
    return since - (1 + priority) * SECONDS_A_PRIORITY


def most_urgent_job(
    connection: Connection,
    *,
    kinds: Collection[str] = (),
    without: Collection[str] = (),
    overdue: tuple[float, float] | None = None,
    needs: Collection[str] | None = None,
    seconds: float | None = None,
) -> Record | None:
    """Return ``id`` and ``forward_model`` of the job whose turn it is, None: there is nothing to do.

    Of each line only the first job that a worker could do something for is looked at, whatever stands behind it.

    Parameters
    ----------
    kinds, without
        Only these kinds of forward model, empty: all; and none of those.
    overdue
        Time [s] and multiple of the typical time after which an evaluation may be run twice at once, when there is
        nothing else to do; None: never.
    needs
        Only jobs that need one of these of their worker; None: all.
    seconds
        Only jobs whose evaluations typically take less [s], or of which that is not known; None: all.
    """
    asked = None if needs is None else frozenset(needs)
    first, late = _most_urgent(frozenset(kinds), frozenset(without), overdue, asked, seconds is not None)
    given = {} if seconds is None else {"left": seconds}
    row = connection.execute(first, given).one_or_none()
    return connection.execute(late, given).one_or_none() if row is None and late is not None else row


def open_needs(connection: Connection, overdue: tuple[float, float]) -> Sequence[Record]:
    """Return what open jobs need from a worker: ``needs``, and the least ``typical`` time of each [s]."""
    statement = select(jobs.c.needs, func.min(func.coalesce(jobs.c.typical_seconds, 0.0)).label("typical"))
    condition = (WAITING, jobs.c.needs.is_not(None), or_(_ready(), _late(*overdue)))
    return connection.execute(statement.where(*condition).group_by(jobs.c.needs)).all()


@lru_cache(maxsize=64)  # workers ask often, and building these takes longer than the database's answer
def _most_urgent(
    kinds: frozenset[str],
    without: frozenset[str],
    overdue: tuple[float, float] | None,
    needs: frozenset[str] | None,
    limited: bool,
) -> tuple[Select[Any], Select[Any] | None]:
    """Return what asks for the job whose turn it is, and for one with an evaluation that is overdue."""
    wanted = and_(WAITING, _of_kinds(kinds, without))
    if needs is not None:
        wanted = and_(wanted, jobs.c.needs.in_(sorted(needs)))
    if limited:
        wanted = and_(wanted, func.coalesce(jobs.c.typical_seconds, 0.0) <= bindparam("left", type_=Double()))
    chosen = _choice(wanted)
    if overdue is None:
        return chosen, None
    late = select(jobs.c.id, jobs.c.forward_model).where(wanted, _late(*overdue))
    return chosen, late.order_by(jobs.c.place).limit(1)


def _choice(wanted: ColumnElement[bool]) -> Select[Any]:
    """Return what asks for the job whose turn it is among the wanted ones."""
    first = (
        select(jobs.c.id)
        .where(jobs.c.line == turns.c.line, wanted, _ready())
        .order_by(jobs.c.place)
        .limit(1)
        .correlate(turns)
        .scalar_subquery()
    )
    firsts = select(turns.c.served_at, first.label("id")).cte("firsts").prefix_with("MATERIALIZED")  # found once
    since = func.coalesce(firsts.c.served_at, jobs.c.created_at - SECONDS_A_PRIORITY)
    turn = _of_job(since - SECONDS_A_PRIORITY * jobs.c.shared_priority, firsts.c.id)
    shown = (_of_job(column, firsts.c.id).label(column.name) for column in (jobs.c.forward_model, jobs.c.served_at))
    return select(firsts.c.id, *shown).where(firsts.c.id.is_not(None)).order_by(turn, firsts.c.id).limit(1)


@lru_cache(maxsize=64)
def _turn(kinds: frozenset[str], without: frozenset[str]) -> ReturningUpdate[Any]:
    """Return what chooses the job whose turn it is and notes it, in one statement of PostgreSQL."""
    passing = jobs.c.id.not_in(bindparam("passing", expanding=True))
    chosen = _choice(and_(WAITING, _of_kinds(kinds, without), passing)).cte("chosen")
    same = and_(jobs.c.id == chosen.c.id, jobs.c.served_at.is_not_distinct_from(chosen.c.served_at))
    now = _later_than_any()
    free = select(jobs.c.id, jobs.c.line, jobs.c.priority, now.label("now"), chosen.c.forward_model).where(same)
    taken = free.with_for_update(skip_locked=True, of=jobs).cte("taken")
    free_line = select(turns.c.line, taken.c.now).where(turns.c.line == taken.c.line)
    line = free_line.with_for_update(skip_locked=True, of=turns).cte("line")
    served = update(turns).where(turns.c.line == line.c.line).values(served_at=line.c.now)
    values = {"served_at": taken.c.now, "place": taken.c.now - SECONDS_A_PRIORITY * taken.c.priority}
    noted = update(jobs).where(jobs.c.id == taken.c.id).values(values).returning(jobs.c.id, taken.c.forward_model)
    return noted.add_cte(served.returning(turns.c.line).cte("served"))


def take_turn(
    connection: Connection, *, kinds: Collection[str] = (), without: Collection[str] = (), passing: Collection[str] = ()
) -> Record | None:
    """Return the job of :func:`most_urgent_job` and note that a worker turns to it: the next one chooses another.

    PostgreSQL only; does not wait. None: there is nothing to do, or another worker took this turn, or an exchange
    has the job locked.

    Parameters
    ----------
    passing
        None of these jobs.
    """
    statement = _turn(frozenset(kinds), frozenset(without))
    return connection.execute(statement, {"passing": list(passing)}).one_or_none()


def claimable_jobs(
    connection: Connection, limit: int, *, overdue: tuple[float, float], not_woken_for: float
) -> Sequence[Record]:
    """Return ``id`` and ``forward_model`` of jobs to wake workers for, those that have waited longest first.

    These are queued ones and running ones with an evaluation to claim, or with none that is open at all (complete, but
    it was not advanced), or with an overdue one.

    Parameters
    ----------
    overdue
        As for :func:`most_urgent_job`.
    not_woken_for
        Leave out jobs for which a sweep woke workers in these seconds.
    """
    silent = or_(jobs.c.rung_at.is_(None), jobs.c.rung_at < database_now() - not_woken_for)
    statement = select(jobs.c.id, jobs.c.forward_model).where(WAITING, silent, or_(_ready(), _late(*overdue)))
    return connection.execute(statement.order_by(jobs.c.place).limit(limit)).all()


def note_served(connection: Connection, row: Record) -> None:
    """Note that a worker turns to this job now: it goes to the end of its line, and its line waits for the others.

    Does not wait for the line, as leases were given before: the transaction that holds it notes the same.
    """
    now = _later_than_any()
    values = {"served_at": now, "place": now - SECONDS_A_PRIORITY * row.priority}
    connection.execute(update(jobs).where(jobs.c.id == row.id).values(values))
    line = turns.c.line == row.line
    if connection.dialect.name == "postgresql":
        line = turns.c.line == select(turns.c.line).where(line).with_for_update(skip_locked=True).scalar_subquery()
    connection.execute(update(turns).where(line).values(served_at=now))


def note_typical(connection: Connection, job_id: str, seconds: float) -> None:
    """Note what an evaluation of a job typically takes [s], before its first generation is complete."""
    connection.execute(update(jobs).where(jobs.c.id == job_id).values(typical_seconds=seconds))


def mark_rung(connection: Connection, job_ids: Sequence[str]) -> None:
    """Note that a sweep wakes for these jobs now, so that other sweeps need not."""
    connection.execute(update(jobs).where(jobs.c.id.in_(job_ids)).values(rung_at=database_now()))


def _later_than_any() -> ColumnElement[float]:
    """Return now [s], but later than any line was served: SQLite's clock has milliseconds, and clocks are set back."""
    now = database_now()
    next_after = select(func.coalesce(func.max(turns.c.served_at), 0.0) + CLOCK_STEP).scalar_subquery()
    return case((next_after > now, next_after), else_=now)


def _of_job(value: ColumnElement[Any], job_id: ColumnElement[str]) -> ScalarSelect[Any]:
    """Look a value of one job up by its key: a join would make PostgreSQL read all jobs."""
    return select(value).where(jobs.c.id == job_id).correlate_except(jobs).scalar_subquery()


def _of_kinds(kinds: Collection[str], without: Collection[str]) -> ColumnElement[bool]:
    condition: ColumnElement[bool] = true()
    if kinds:
        condition = jobs.c.forward_model.in_(kinds)
    if without:
        condition = and_(condition, jobs.c.forward_model.not_in(without))
    return condition


def _ready() -> ColumnElement[bool]:
    """Whether a worker can claim something of a job, start it, or advance it."""
    current = evaluations.c.generation == jobs.c.generation
    claimable = _some(evaluations.c.generation >= jobs.c.generation, evaluations.c.state == "pending")
    running = _some(current, evaluations.c.state == "running")
    reopened = _some(text(REOPENED))
    retrying = _some(text("evaluations.state = 'running'"))
    return or_(
        jobs.c.state == "queued",
        and_(jobs.c.state == "running", jobs.c.retry_to.is_(None), or_(claimable, ~running)),
        and_(jobs.c.state == "running", jobs.c.retry_to.is_not(None), or_(reopened, ~retrying)),
    )


def _late(seconds: float, factor: float) -> ColumnElement[bool]:
    """Whether an evaluation of a job is overdue and in one hand only."""
    longest = case((jobs.c.typical_seconds * factor > seconds, jobs.c.typical_seconds * factor), else_=literal(seconds))
    late = _some(
        evaluations.c.generation == jobs.c.generation,
        text("evaluations.state = 'running'"),
        evaluations.c.duplicates.is_(None),
        evaluations.c.started_at < database_now() - longest,
    )
    return and_(jobs.c.state == "running", jobs.c.retry_to.is_(None), late)


def _some(*conditions: ColumnElement[bool] | TextClause) -> ColumnElement[bool]:
    """Whether the job has such an evaluation; PostgreSQL would read the whole table for EXISTS here."""
    found = select(literal(1)).where(evaluations.c.job_id == jobs.c.id, *conditions).limit(1).correlate(jobs)
    return found.scalar_subquery().is_not(None)
