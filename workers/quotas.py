"""Quotas of an owner: how many jobs may be open, and how many evaluations may be stored."""

from __future__ import annotations

from sqlalchemy import Connection, case, func, select, text

from geoswarm.workers.coordinator.machine import ENDED_STATES
from geoswarm.workers.errors import QuotaExceededError
from geoswarm.workers.settings import Settings
from geoswarm.workers.store.tables import jobs

__all__ = ["check_quotas"]


def check_quotas(
    connection: Connection, owner: str, planned: int | None, settings: Settings, *, another: bool = True
) -> None:
    """Refuse another job of an owner when it would exceed a quota; inside the transaction that enters the job.

    A job that has not ended counts with all evaluations that it plans, or with those that it has when it plans no
    number. ``another``: it would be one more job that has not ended.

    Raises
    ------
    QuotaExceededError
    """
    if connection.dialect.name == "postgresql":  # two submissions at once must not both find room
        connection.execute(text("SELECT pg_advisory_xact_lock(hashtextextended(:owner, 0))"), {"owner": owner})
    ended = jobs.c.state.in_(ENDED_STATES)
    planned_there = func.coalesce(jobs.c.max_evaluations, 0)
    ahead = case((ended, 0), (planned_there > jobs.c.evaluations, planned_there - jobs.c.evaluations), else_=0)
    row = connection.execute(
        select(
            func.coalesce(func.sum(case((ended, 0), else_=1)), 0),
            func.coalesce(func.sum(jobs.c.evaluations + ahead), 0),
        ).where(jobs.c.owner == owner)
    ).one()
    open_jobs, stored = int(row[0]), int(row[1])
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
