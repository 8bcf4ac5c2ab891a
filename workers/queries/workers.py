"""Queries on worker processes."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy import ColumnElement, Connection, and_, case, delete, exists, func, insert, or_, select, update

from geoswarm.workers.identity import Identity
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import agents, builds, evaluations, jobs, workers

__all__ = [
    "any_lost_before",
    "begin_build",
    "busy_workers",
    "count_live",
    "count_machines",
    "current_work",
    "end_build",
    "forget_worker",
    "forget_workers_lost_before",
    "list_workers",
    "live_workers",
    "mark_lost",
    "overdue_workers",
    "register_worker",
    "see_worker",
    "workers_elsewhere",
]


def register_worker(connection: Connection, identity: Identity) -> None:
    """Enter a worker that starts."""
    now = database_now()
    connection.execute(
        insert(workers).values(
            id=identity.id,
            host=identity.host,
            pid=identity.pid,
            machine=identity.machine,
            engine=identity.engine,
            started_at=now,
            seen_at=now,
        )
    )


def see_worker(connection: Connection, identity: Identity) -> None:
    """Note that a worker is alive; register it again if it had been given up."""
    values = {"seen_at": database_now(), "lost_at": None}
    if connection.execute(update(workers).where(workers.c.id == identity.id).values(values)).rowcount == 0:
        register_worker(connection, identity)


def forget_worker(connection: Connection, worker_id: str) -> None:
    """Remove a worker that ends in an orderly way."""
    connection.execute(delete(workers).where(workers.c.id == worker_id))


def begin_build(connection: Connection, job_id: str, worker_id: str) -> int:
    """Note that a worker builds the problem of a job; return how many have ended that were building it."""
    alive = select(workers.c.id).where(workers.c.lost_at.is_(None))
    others = and_(builds.c.job_id == job_id, builds.c.worker != worker_id)
    lost = connection.scalar(select(func.count()).where(others, builds.c.worker.not_in(alive)))
    end_build(connection, job_id, worker_id)
    connection.execute(insert(builds).values(job_id=job_id, worker=worker_id))
    return lost or 0


def end_build(connection: Connection, job_id: str, worker_id: str | None = None) -> None:
    """Note that a worker has built the problem, or tried it, without ending; None: no worker ends by it."""
    noted = delete(builds).where(builds.c.job_id == job_id)
    connection.execute(noted if worker_id is None else noted.where(builds.c.worker == worker_id))


def count_live(connection: Connection, lease: float) -> int:
    """Return the number of workers heard of within their lease [s]."""
    return connection.scalar(select(func.count()).select_from(workers).where(_live(lease))) or 0


def count_machines(connection: Connection, lease: float) -> int:
    """Return the number of machines that they are on."""
    return connection.scalar(select(func.count(workers.c.machine.distinct())).where(_live(lease))) or 0


def workers_elsewhere(connection: Connection, job_id: str) -> int:
    """Return the number of workers that hold an evaluation of another job."""
    held = and_(evaluations.c.state == "running", evaluations.c.job_id != job_id)
    return connection.scalar(select(func.count(evaluations.c.worker.distinct())).where(held)) or 0


def live_workers(connection: Connection, lease: float) -> set[str]:
    """Return the workers heard of within their lease [s]."""
    return set(connection.scalars(select(workers.c.id).where(_live(lease))))


def _live(lease: float) -> ColumnElement[bool]:
    return and_(workers.c.lost_at.is_(None), workers.c.seen_at > database_now() - lease)


def busy_workers(connection: Connection) -> dict[str, str]:
    """Return the job of every worker that holds an evaluation."""
    statement = select(evaluations.c.worker, evaluations.c.job_id).where(evaluations.c.state == "running").distinct()
    return {row[0]: row[1] for row in connection.execute(statement) if row[0] is not None}


def current_work(connection: Connection) -> dict[str, Record]:
    """Return what every busy worker has: job_id, its owner, generation, number ``claimed``, ``since``."""
    statement = (
        select(
            evaluations.c.worker,
            evaluations.c.job_id,
            jobs.c.owner,
            evaluations.c.generation,
            func.count().label("claimed"),
            func.min(evaluations.c.started_at).label("since"),
        )
        .join(jobs, jobs.c.id == evaluations.c.job_id)
        .where(evaluations.c.state == "running")
        .group_by(evaluations.c.worker, evaluations.c.job_id, jobs.c.owner, evaluations.c.generation)
    )
    return {row.worker: row for row in connection.execute(statement) if row.worker is not None}


def overdue_workers(connection: Connection, lease: float, machine: str | None = None) -> Sequence[Record]:
    """Return workers (id, pid, machine, overdue) that have not been given up yet; None: of all machines."""
    late = workers.c.seen_at < database_now() - lease
    columns = (workers.c.id, workers.c.pid, workers.c.machine, case((late, 1), else_=0).label("overdue"))
    statement = select(*columns).where(workers.c.lost_at.is_(None))
    return connection.execute(statement if machine is None else statement.where(workers.c.machine == machine)).all()


def mark_lost(connection: Connection, worker_ids: Sequence[str]) -> None:
    """Give workers up."""
    connection.execute(update(workers).where(workers.c.id.in_(worker_ids)).values(lost_at=database_now()))


def any_lost_before(connection: Connection, seconds: float) -> bool:
    """Whether some worker was given up longer than this ago [s]."""
    return bool(connection.scalar(select(exists().where(workers.c.lost_at < database_now() - seconds))))


def forget_workers_lost_before(connection: Connection, seconds: float) -> None:
    """Remove workers that were given up longer than this ago [s].

    An agent goes with its slots: one that comes back is asked to announce itself, and is listed again.
    """
    lost = workers.c.lost_at < database_now() - seconds
    connection.execute(delete(agents).where(agents.c.id.in_(select(workers.c.agent).where(lost))))
    connection.execute(delete(workers).where(lost))


def list_workers(connection: Connection, lease: float) -> Sequence[Record]:
    """Return all workers, oldest first, with ``lost`` (0 or 1), and of slots what their agent is."""
    silent = or_(workers.c.lost_at.is_not(None), workers.c.seen_at < database_now() - lease)
    of_agent = (agents.c.slots, agents.c.system, agents.c.versions, agents.c.models)
    statement = select(workers, *of_agent, case((silent, 1), else_=0).label("lost"))
    statement = statement.outerjoin(agents, agents.c.id == workers.c.agent)
    return connection.execute(statement.order_by(workers.c.started_at, workers.c.id)).all()
