"""The line in which jobs wait for workers."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from sqlalchemy import Connection, and_, case, exists, func, literal, or_, select, text, update

from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import evaluations, jobs

__all__ = ["REOPENED", "claimable_jobs", "mark_rung", "note_served"]

SECONDS_A_PRIORITY = 10.0

REOPENED = "evaluations.state = 'pending' AND evaluations.reason IS NOT NULL"
"""Failed evaluations that are to be run again; word for word as in their index."""


def claimable_jobs(
    connection: Connection,
    limit: int,
    *,
    kinds: Collection[str] = (),
    without: Collection[str] = (),
    overdue: tuple[float, float] | None = None,
    not_rung_for: float | None = None,
) -> list[Record]:
    """Return ``id`` and ``forward_model`` of jobs that a worker could do something for, the most urgent first.

    These are queued ones and running ones with an evaluation to claim, or with none that is open at all (complete, but
    nobody advanced it). Who has waited longest comes first; one step of priority counts as much as ten seconds of
    waiting, so that nobody waits for ever.

    Parameters
    ----------
    kinds, without
        Only these kinds of forward model, empty: all; and none of those.
    overdue
        Time [s] and multiple of the typical time after which an evaluation may be run twice at once; None: never.
    not_rung_for
        Leave out jobs for which a sweep rang in these seconds.
    """
    now = database_now()
    here = evaluations.c.job_id == jobs.c.id
    current = and_(here, evaluations.c.generation == jobs.c.generation)
    claimable = exists().where(current, evaluations.c.state == "pending").correlate(jobs)
    running = exists().where(current, evaluations.c.state == "running").correlate(jobs)
    reopened = exists().where(here, text(REOPENED)).correlate(jobs)
    retrying = exists().where(here, text("evaluations.state = 'running'")).correlate(jobs)
    ready = or_(
        jobs.c.state == "queued",
        and_(jobs.c.state == "running", jobs.c.retry_to.is_(None), or_(claimable, ~running)),
        and_(jobs.c.state == "running", jobs.c.retry_to.is_not(None), or_(reopened, ~retrying)),
    )
    condition = ready
    if overdue is not None:
        seconds, factor = overdue
        longest = case(
            (jobs.c.typical_seconds * factor > seconds, jobs.c.typical_seconds * factor), else_=literal(seconds)
        )
        late = exists().where(
            current,
            text("evaluations.state = 'running'"),
            evaluations.c.duplicates.is_(None),
            evaluations.c.started_at < now - longest,
        )
        condition = or_(ready, and_(jobs.c.state == "running", jobs.c.retry_to.is_(None), late.correlate(jobs)))
    if not_rung_for is not None:
        condition = and_(condition, or_(jobs.c.rung_at.is_(None), jobs.c.rung_at < now - not_rung_for))
    if kinds:
        condition = and_(condition, jobs.c.forward_model.in_(kinds))
    if without:
        condition = and_(condition, jobs.c.forward_model.not_in(without))
    since = func.coalesce(jobs.c.served_at, jobs.c.created_at - SECONDS_A_PRIORITY)  # who is new comes soon
    waiting = since - SECONDS_A_PRIORITY * jobs.c.priority
    order = (case((ready, 0), else_=1), waiting, jobs.c.created_at)
    statement = select(jobs.c.id, jobs.c.forward_model).where(condition).order_by(*order).limit(limit)
    return list(connection.execute(statement).all())


def note_served(connection: Connection, job_id: str) -> None:
    """Note that a worker turns to this job now: it goes to the end of the line."""
    connection.execute(update(jobs).where(jobs.c.id == job_id).values(served_at=database_now()))


def mark_rung(connection: Connection, job_ids: Sequence[str]) -> None:
    """Note that a sweep rings for these jobs now, so that other sweeps need not."""
    connection.execute(update(jobs).where(jobs.c.id.in_(job_ids)).values(rung_at=database_now()))
