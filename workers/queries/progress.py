"""Progress of the current generation, the time of runs, and workers free for more."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import Connection, func, select

from geoswarm.workers.queries.workers import busy_workers, live_workers
from geoswarm.workers.store.tables import evaluations

__all__ = ["StateCount", "free_workers", "mean_seconds", "state_counts"]

_LATEST = 20  # generations that tell how long a run takes: earlier ones may have been quicker, or slower
_MOST_RUNS = 200


@dataclass(frozen=True, slots=True)
class StateCount:
    """Evaluations of a generation in one state: their number and lowest objective."""

    number: int
    objective: float | None


def state_counts(connection: Connection, job_id: str, generation: int) -> dict[str, StateCount]:
    """Count the evaluations of a generation by their state; empty where nothing was dispatched."""
    rows = connection.execute(
        select(evaluations.c.state, func.count().label("number"), func.min(evaluations.c.objective).label("objective"))
        .where(evaluations.c.job_id == job_id, evaluations.c.generation == generation)
        .group_by(evaluations.c.state)
    )
    return {row.state: StateCount(row.number, row.objective) for row in rows}


def mean_seconds(connection: Connection, job_id: str, generation: int) -> float | None:
    """Mean time of the latest runs up to a generation [s]; None before a run has finished."""
    latest = (
        select(evaluations.c.seconds)
        .where(
            evaluations.c.job_id == job_id,
            evaluations.c.generation.between(generation - _LATEST, generation),
            evaluations.c.state == "finished",
        )
        .order_by(evaluations.c.generation.desc(), evaluations.c.particle.desc())
        .limit(_MOST_RUNS)
        .subquery()
    )
    found: float | None = connection.scalar(select(func.avg(latest.c.seconds)))
    return found


def free_workers(connection: Connection, lease: float, *, job_id: str | None = None) -> int:
    """Number of live workers that hold no evaluation, or one of this job."""
    held = busy_workers(connection)
    return sum(held.get(worker) in (None, job_id) for worker in live_workers(connection, lease))
