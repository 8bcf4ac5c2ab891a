"""What an operator watches: work that waits, workers, and what has been counted since the installation was made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy import Connection, and_, func, select, text

from geoswarm.records.states import UNDONE_STATES
from geoswarm.workers.operations.counters import read_counters
from geoswarm.workers.queries.workers import busy_workers, list_workers
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.tables import deliveries, evaluations, jobs

__all__ = ["Measures", "measure"]


WAITING = text("deliveries.state = 'waiting'")  # word for word as in its index


@dataclass(frozen=True, slots=True)
class Measures:
    """State and counters of an installation, over all its processes.

    Parameters
    ----------
    jobs
        Number by state.
    waiting, running
        Evaluations of running jobs that wait for a worker, and that a worker has.
    oldest_wait
        Time since the job was submitted that has waited longest for its first worker [s]; 0: none waits.
    workers
        Number by state: idle, busy, lost.
    notices
        Messages about ended jobs that wait to be delivered.
    counters
        Sums by name and label, see :mod:`geoswarm.workers.operations.counters`.
    """

    jobs: Mapping[str, int]
    waiting: int
    running: int
    oldest_wait: float
    workers: Mapping[str, int]
    notices: int
    counters: Mapping[tuple[str, str], float]


def measure(connection: Connection, lease: float) -> Measures:
    """Read all measures; costs a few short queries, whatever the history."""
    by_state = {row[0]: row[1] for row in connection.execute(select(jobs.c.state, func.count()).group_by(jobs.c.state))}
    here = and_(
        evaluations.c.job_id == jobs.c.id,
        evaluations.c.generation == jobs.c.generation,
        evaluations.c.state.in_(UNDONE_STATES),
    )
    statement = select(evaluations.c.state, func.count()).select_from(jobs.join(evaluations, here))
    statement = statement.where(jobs.c.state == "running").group_by(evaluations.c.state)
    open_evaluations = {row[0]: row[1] for row in connection.execute(statement)}
    oldest = connection.scalar(select(database_now() - func.min(jobs.c.created_at)).where(jobs.c.state == "queued"))
    busy = busy_workers(connection)
    states = {"idle": 0, "busy": 0, "lost": 0}
    for row in list_workers(connection, lease):
        states["lost" if row.lost else "busy" if row.id in busy else "idle"] += 1
    return Measures(
        jobs=by_state,
        waiting=open_evaluations.get("pending", 0),
        running=open_evaluations.get("running", 0),
        oldest_wait=max(oldest or 0.0, 0.0),
        workers=states,
        notices=connection.scalar(select(func.count()).select_from(deliveries).where(WAITING)) or 0,
        counters=read_counters(connection),
    )
