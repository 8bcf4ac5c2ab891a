"""How many runs of a job can be in progress at once."""

from __future__ import annotations

from sqlalchemy import Connection

from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.workers.queries.workers import count_live, count_machines, workers_elsewhere
from geoswarm.workers.settings import Settings

__all__ = ["free_slots"]


def free_slots(connection: Connection, settings: Settings, model: ForwardModelSpec, job_id: str) -> int:
    """Return the number of live workers without an evaluation of another job, within the slots of the model.

    A worker knows the limits of its own group; others on other machines are taken to be like it.
    """
    workers = count_live(connection, settings.lease_seconds) - workers_elsewhere(connection, job_id)
    machines = max(1, count_machines(connection, settings.lease_seconds))
    if model.kind in settings.slots:
        workers = min(workers, settings.slots[model.kind] * machines)
    return max(1, model.at_once(workers, machines))
