"""Records, in the transaction that ends a job, whom to notify: once committed, no notification is lost."""

from __future__ import annotations

from sqlalchemy import Connection, and_, insert, literal, or_, select

from geoswarm.workers.store.tables import deliveries, hooks

__all__ = ["insert_deliveries"]


def insert_deliveries(connection: Connection, job_id: str, owner: str | None, state: str, now: float) -> None:
    """Store one delivery for each hook that reports jobs ending in this state."""
    own = hooks.c.owner.is_(None) if owner is None else hooks.c.owner == owner
    meant = or_(hooks.c.job_id == job_id, and_(hooks.c.job_id.is_(None), own))
    wanted = hooks.c.states.contains(f'"{state}"', autoescape=True)
    source = select(
        hooks.c.id, literal(job_id), literal(state), literal("waiting"), literal(0), literal(now), literal(now)
    ).where(meant, wanted)
    names = ["hook_id", "job_id", "job_state", "state", "tries", "due_at", "created_at"]
    connection.execute(insert(deliveries).from_select(names, source))
