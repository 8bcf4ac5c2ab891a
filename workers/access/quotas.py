"""Quotas of an owner: how many jobs may be open, how many evaluations be stored, and how much of the disk they take."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, case, func, select, text

from geoswarm.records.states import ENDED_STATES
from geoswarm.solver.calibration import WarmStartRuns
from geoswarm.solver.problem import Problem
from geoswarm.workers.errors import QuotaExceededError
from geoswarm.workers.settings import Settings
from geoswarm.workers.store.tables import jobs

__all__ = ["check_quotas", "lock_quotas", "sizes"]

LOCK = 7_209_341_855_018
"""Number of the lock in PostgreSQL: any that nothing else in this database uses."""

JOB_BYTES = 4096
EVALUATION_BYTES = 600
"""What a row takes beside its numbers, with its share of indices, generations and events, about: measured 220 to 310 in
SQLite, 440 to 790 in PostgreSQL."""


def sizes(problem: Problem, documents: Mapping[str, str], offer: WarmStartRuns | None) -> dict[str, int]:
    """Return what a job will take of the disk, about: ``document_bytes`` at once, ``evaluation_bytes`` for each run.

    Parameters
    ----------
    documents
        Texts that are stored with it.
    offer
        Runs of earlier jobs that are stored with it.
    """
    points = sum(observation.x.size for observation in problem.observations)
    evaluation = EVALUATION_BYTES + 8 * (points + len(problem.free_names))
    offered = 0 if offer is None else len(offer.parameters)
    document = JOB_BYTES + sum(map(len, documents.values())) + offered * evaluation
    return {"document_bytes": document, "evaluation_bytes": evaluation}


def lock_quotas(connection: Connection) -> None:
    """Let other transactions that need room wait for the end of this one: two at once must not both find it.

    One lock for all owners, as they share the room of ``GEOSWARM_QUOTA_TOTAL_MB``. SQLite has one writer anyway.
    """
    if connection.dialect.name == "postgresql":
        connection.execute(text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": LOCK})


def check_quotas(
    connection: Connection,
    owner: str,
    planned: int | None,
    settings: Settings,
    *,
    size: Mapping[str, int],
    taken: int,
    another: bool = True,
) -> None:
    """Refuse another job of an owner when it would exceed a quota; after :func:`lock_quotas`, in the transaction that
    enters the job.

    A job that has not ended counts with all evaluations that it plans, or with those that it has when it plans no
    number. ``another``: it would be one more job that has not ended.

    Parameters
    ----------
    size
        What it takes, from :func:`sizes`.
    taken
        What the database takes of its disk now [bytes].

    Raises
    ------
    QuotaExceededError
    """
    ended = jobs.c.state.in_(ENDED_STATES)
    planned_there = func.coalesce(jobs.c.max_evaluations, 0)
    ahead = case((ended, 0), (planned_there > jobs.c.evaluations, planned_there - jobs.c.evaluations), else_=0)
    row = connection.execute(
        select(
            func.coalesce(func.sum(case((ended, 0), else_=1)), 0),
            func.coalesce(func.sum(jobs.c.evaluations + ahead), 0),
            func.coalesce(func.sum(jobs.c.document_bytes + jobs.c.evaluation_bytes * (jobs.c.evaluations + ahead)), 0),
        ).where(jobs.c.owner == owner)
    ).one()
    open_jobs, stored, owned = (int(value) for value in row)
    if another and open_jobs >= settings.quota_jobs:
        raise QuotaExceededError(
            f"{owner} has {open_jobs} jobs that have not ended; at most {settings.quota_jobs} are accepted."
            " Wait for one, or cancel one"
        )
    wanted = planned or 0
    if stored + wanted > settings.quota_evaluations or stored >= settings.quota_evaluations:
        raise QuotaExceededError(
            f"the jobs of {owner} have or plan {stored} evaluations and this one {wanted} more;"
            f" at most {settings.quota_evaluations} are kept. Delete jobs that are no longer needed"
        )
    asked = size["document_bytes"] + size["evaluation_bytes"] * wanted
    what = f"{_mb(asked)} more ({wanted} evaluations of {size['evaluation_bytes']} bytes)"
    if owned + asked > settings.quota_mb * 1e6:
        raise QuotaExceededError(
            f"the jobs of {owner} have or plan {_mb(owned)} of data and this one {what};"
            f" at most {_mb(settings.quota_mb * 1e6)} are kept (GEOSWARM_QUOTA_MB). Delete jobs that are no longer"
            " needed, cancel some, or plan fewer evaluations or points"
        )
    still = jobs.c.evaluation_bytes * ahead
    waiting: Any = connection.scalar(select(func.coalesce(func.sum(still), 0)).where(~ended))
    if taken + int(waiting) + asked > settings.quota_total_mb * 1e6:
        raise QuotaExceededError(
            f"the database has {_mb(taken)}, jobs that have not ended plan {_mb(int(waiting))} and this one {what};"
            f" at most {_mb(settings.quota_total_mb * 1e6)} are kept for all owners (GEOSWARM_QUOTA_TOTAL_MB)."
            " Delete or cancel jobs, plan fewer evaluations or points, or ask the administrator"
        )


def _mb(size: float) -> str:
    """Words for a number of bytes."""
    return f"{size / 1e6:,.1f} MB".replace(",", " ")
