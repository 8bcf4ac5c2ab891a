"""Quotas of an owner: how many jobs may be open, how many evaluations be stored, and how much of the disk they and the
files attached to them take."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, case, func, select, text

from geoswarm.records.states import ENDED_STATES
from geoswarm.solver.calibration import WarmStartRuns
from geoswarm.solver.problem import Problem
from geoswarm.workers.errors import QuotaExceededError
from geoswarm.workers.queries.attachments import attached_bytes, count_attachments
from geoswarm.workers.settings import Settings
from geoswarm.workers.store.tables import jobs

__all__ = ["check_attachment_quotas", "check_quotas", "lock_quotas", "sizes"]

LOCK = 7_209_341_855_018
"""Number of the lock in PostgreSQL: any that nothing else in this database uses."""

JOB_BYTES = 4096
EVALUATION_BYTES = 600
"""What a row takes beside its numbers, with its share of indices, generations and events, about: measured 220 to 310 in
SQLite, 440 to 790 in PostgreSQL."""


ENDED = jobs.c.state.in_(ENDED_STATES)
PLANNED = func.coalesce(jobs.c.max_evaluations, 0)
AHEAD = case((ENDED, 0), (jobs.c.evaluations < PLANNED, PLANNED - jobs.c.evaluations), else_=0)
"""Evaluations that a job still plans."""


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
    open_jobs, stored, written, attached = _totals(connection, owner)
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
    what = f"this one {_mb(asked)} more ({wanted} evaluations of {size['evaluation_bytes']} bytes)"
    _check_room(connection, owner, written + attached, asked, what, settings, taken)


def check_attachment_quotas(
    connection: Connection, job_id: str, owner: str | None, size: int, settings: Settings, *, taken: int
) -> None:
    """Refuse another file of a job when it would exceed a limit; after :func:`lock_quotas`, in the transaction that
    stores it.

    Parameters
    ----------
    owner
        Whose quotas count; None: only the limits of the job do.
    size
        Of the file [bytes].
    taken
        What the database takes of its disk now [bytes].

    Raises
    ------
    QuotaExceededError
    """
    number, attached = count_attachments(connection, job_id)
    if number >= settings.attachments_per_job:
        raise QuotaExceededError(
            f"the job has {number} files; at most {settings.attachments_per_job} can be attached"
            " (GEOSWARM_ATTACHMENTS_PER_JOB). Delete files that are no longer needed"
        )
    if attached + size > settings.attachments_per_job_mb * 1e6:
        raise QuotaExceededError(
            f"the job has {_mb(attached)} of files and this one {_mb(size)} more;"
            f" at most {_mb(settings.attachments_per_job_mb * 1e6)} can be attached (GEOSWARM_ATTACHMENTS_PER_JOB_MB)."
            " Delete files that are no longer needed"
        )
    if owner is None:
        return
    _, _, written, attached = _totals(connection, owner)
    if attached + size > settings.quota_attachments_mb * 1e6:
        raise QuotaExceededError(
            f"the jobs of {owner} have {_mb(attached)} of files and this one {_mb(size)} more;"
            f" at most {_mb(settings.quota_attachments_mb * 1e6)} are kept (GEOSWARM_QUOTA_ATTACHMENTS_MB)."
            " Delete files or jobs that are no longer needed"
        )
    _check_room(connection, owner, written + attached, size, f"this file {_mb(size)} more", settings, taken)


def _totals(connection: Connection, owner: str) -> tuple[int, int, int, int]:
    """Return how many jobs of an owner have not ended; of all, evaluations and their data [bytes], stored or planned,
    and attached files [bytes]."""
    row = connection.execute(
        select(
            func.coalesce(func.sum(case((ENDED, 0), else_=1)), 0),
            func.coalesce(func.sum(jobs.c.evaluations + AHEAD), 0),
            func.coalesce(func.sum(jobs.c.document_bytes + jobs.c.evaluation_bytes * (jobs.c.evaluations + AHEAD)), 0),
        ).where(jobs.c.owner == owner)
    ).one()
    open_jobs, evaluations, written = (int(value) for value in row)
    return open_jobs, evaluations, written, attached_bytes(connection, owner)


def _check_room(
    connection: Connection, owner: str, owned: int, asked: int, what: str, settings: Settings, taken: int
) -> None:
    """Refuse what an owner, or all of them, have no room for; ``what`` are words for the bytes that are asked for."""
    if owned + asked > settings.quota_mb * 1e6:
        raise QuotaExceededError(
            f"the jobs of {owner} have or plan {_mb(owned)} of data and {what};"
            f" at most {_mb(settings.quota_mb * 1e6)} are kept (GEOSWARM_QUOTA_MB). Delete jobs that are no longer"
            " needed, cancel some, or plan fewer evaluations or points"
        )
    still = jobs.c.evaluation_bytes * AHEAD
    waiting: Any = connection.scalar(select(func.coalesce(func.sum(still), 0)).where(~ENDED))
    if taken + int(waiting) + asked > settings.quota_total_mb * 1e6:
        raise QuotaExceededError(
            f"the database has {_mb(taken)}, jobs that have not ended plan {_mb(int(waiting))} and {what};"
            f" at most {_mb(settings.quota_total_mb * 1e6)} are kept for all owners (GEOSWARM_QUOTA_TOTAL_MB)."
            " Delete or cancel jobs, plan fewer evaluations or points, or ask the administrator"
        )


def _mb(size: float) -> str:
    """Words for a number of bytes."""
    return f"{size / 1e6:,.1f} MB".replace(",", " ")
