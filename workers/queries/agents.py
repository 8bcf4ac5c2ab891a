"""Queries on agents, and on what they hold."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, and_, case, delete, exists, func, insert, or_, select, text, update

from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import OPEN, agent_leases, agents, api_keys, jobs, workers

__all__ = [
    "any_old_leases",
    "count_agents",
    "count_leases",
    "end_lease",
    "find_agent",
    "find_lease",
    "forget_agent",
    "forget_old_leases",
    "insert_lease",
    "jobs_of_unknown_needs",
    "leases_of_dead_keys",
    "renew_lease",
    "save_agent",
    "see_agents",
    "set_needs",
    "show_slots",
]

KEPT_ENDED_SECONDS = 600.0
"""How long accepted results are remembered, so that handing them in again is recognised."""
KEPT_OPEN_SECONDS = 7 * 86_400.0
"""How long results may still come for a lease of which nothing was heard."""
WITHOUT_KEY = ("", "environment")
"""The caller without a key of the database."""


def find_agent(connection: Connection, agent_id: str) -> Record | None:
    """Return an agent."""
    return connection.execute(select(agents).where(agents.c.id == agent_id)).one_or_none()


def save_agent(connection: Connection, values: Mapping[str, Any]) -> None:
    """Enter an agent, or what it offers now."""
    now = database_now()
    here = agents.c.id == values["id"]
    if connection.execute(update(agents).where(here).values(**values, seen_at=now)).rowcount == 0:
        connection.execute(insert(agents).values(**values, started_at=now, seen_at=now))


def see_agents(connection: Connection, agent_ids: Collection[str]) -> None:
    """Note that agents were heard of, and with them all their slots."""
    now = database_now()
    connection.execute(update(agents).where(agents.c.id.in_(agent_ids)).values(seen_at=now))
    connection.execute(update(workers).where(workers.c.agent.in_(agent_ids)).values(seen_at=now, lost_at=None))


def show_slots(connection: Connection, agent: Record, wanted: Mapping[str, int]) -> None:
    """Have the slots of an agent, numbers by their names as workers, in the list of workers, and no others."""
    there = set(connection.scalars(select(workers.c.id).where(workers.c.agent == agent.id)))
    now = database_now()
    rows = [
        {"id": name, "host": agent.host, "pid": agent.pid, "machine": "", "engine": "agent", "agent": agent.id}
        for name in wanted
        if name not in there
    ]
    for row in rows:
        connection.execute(insert(workers).values(**row, started_at=now, seen_at=now))
    gone = there.difference(wanted)
    if gone:
        connection.execute(delete(workers).where(workers.c.id.in_(sorted(gone))))


def forget_agent(connection: Connection, agent_id: str) -> None:
    """Remove an agent that ends in an orderly way, and its slots."""
    connection.execute(delete(workers).where(workers.c.agent == agent_id))
    connection.execute(delete(agents).where(agents.c.id == agent_id))


def count_agents(connection: Connection, key_id: str, seconds: float, without: str) -> int:
    """Return how many other agents of a key were heard of in the last seconds [s]."""
    recent = and_(agents.c.key_id == key_id, agents.c.seen_at > database_now() - seconds, agents.c.id != without)
    return connection.scalar(select(func.count()).select_from(agents).where(recent)) or 0


def count_leases(connection: Connection, key_id: str) -> int:
    """Return how many leases of a key are running."""
    open_now = and_(
        agent_leases.c.key_id == key_id,
        agent_leases.c.ended_at.is_(None),
        agent_leases.c.expires_at > database_now(),
    )
    return connection.scalar(select(func.count()).select_from(agent_leases).where(open_now)) or 0


def insert_lease(connection: Connection, values: Mapping[str, Any]) -> None:
    """Enter a lease."""
    connection.execute(insert(agent_leases).values(**values))


def find_lease(connection: Connection, lease_id: str, key_id: str) -> Record | None:
    """Return a lease of a key, with the time ``now``; None also for one of another key."""
    statement = select(agent_leases, database_now().label("now"))
    return connection.execute(
        statement.where(agent_leases.c.id == lease_id, agent_leases.c.key_id == key_id)
    ).one_or_none()


def renew_lease(connection: Connection, lease_id: str, seconds: float) -> None:
    """Let a lease run for so long from now [s]."""
    here = and_(agent_leases.c.id == lease_id, agent_leases.c.ended_at.is_(None))
    connection.execute(update(agent_leases).where(here).values(expires_at=database_now() + seconds))


def end_lease(connection: Connection, lease_id: str) -> bool:
    """End a lease; False when it had ended before."""
    here = and_(agent_leases.c.id == lease_id, agent_leases.c.ended_at.is_(None))
    return connection.execute(update(agent_leases).where(here).values(ended_at=database_now())).rowcount > 0


def leases_of_dead_keys(connection: Connection) -> Sequence[Record]:
    """Return leases whose key was revoked or has expired."""
    expired = and_(api_keys.c.expires_at.is_not(None), api_keys.c.expires_at <= database_now())
    dead = or_(api_keys.c.id.is_(None), api_keys.c.revoked_at.is_not(None), expired)
    statement = select(agent_leases).outerjoin(api_keys, api_keys.c.id == agent_leases.c.key_id)
    return connection.execute(
        statement.where(agent_leases.c.ended_at.is_(None), agent_leases.c.key_id.not_in(WITHOUT_KEY), dead)
    ).all()


def _old() -> Any:
    ended = agent_leases.c.ended_at < database_now() - KEPT_ENDED_SECONDS
    return or_(ended, agent_leases.c.expires_at < database_now() - KEPT_OPEN_SECONDS)


def any_old_leases(connection: Connection) -> bool:
    """Whether there are leases that need not be remembered."""
    return bool(connection.scalar(select(exists().where(_old()))))


def forget_old_leases(connection: Connection) -> None:
    """Remove leases that need not be remembered, and agents that were silent for long."""
    connection.execute(delete(agent_leases).where(_old()))
    connection.execute(delete(agents).where(agents.c.seen_at < database_now() - KEPT_OPEN_SECONDS))


def jobs_of_unknown_needs(connection: Connection, limit: int) -> Sequence[Record]:
    """Return id and problem of open jobs whose needs are not known yet."""
    unknown = and_(text(f"jobs.{OPEN}"), jobs.c.needs.is_(None))
    return connection.execute(select(jobs.c.id, jobs.c.problem).where(unknown).limit(limit)).all()


def set_needs(connection: Connection, needs: Mapping[str, str]) -> None:
    """Store what jobs need, by their ids."""
    if needs:
        value = case(*((jobs.c.id == job_id, text_) for job_id, text_ in needs.items()), else_=jobs.c.needs)
        connection.execute(update(jobs).where(jobs.c.id.in_(list(needs))).values(needs=value))
