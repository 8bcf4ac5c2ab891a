"""Queries on evaluations. Their state changes only while the job's row is locked by the same transaction."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy import (
    Connection,
    and_,
    bindparam,
    case,
    delete,
    exists,
    func,
    literal_column,
    or_,
    select,
    text,
    tuple_,
    update,
)

from geoswarm.records.states import DONE_STATES, UNDONE_STATES
from geoswarm.solver.arrays import FloatArray
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.codec import unpack_array, unpack_responses
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.statements import Statement
from geoswarm.workers.store.tables import attempts, evaluations, jobs

__all__ = [
    "KEPT",
    "count_failed",
    "drop_generation",
    "get_evaluation",
    "list_attempts",
    "list_positions",
    "list_responses",
    "list_results",
    "overdue",
    "renew_leases",
    "still_wanted",
]

ROWS_AT_ONCE = 200  # keys in one statement
KEPT = and_(evaluations.c.reason.is_not(None), evaluations.c.responses.is_not(None))
"""Failed, with series of parts that a prediction keeps."""
RESULTS = Statement(
    select(
        *(evaluations.c[name] for name in ("objective", "reason", "message", "seconds")),
        case((KEPT, literal_column("1")), else_=literal_column("0")).label("kept"),
    )
    .where(
        evaluations.c.job_id == bindparam("job_id"),
        evaluations.c.generation == bindparam("generation"),
        or_(*(evaluations.c.state == state for state in DONE_STATES)),
    )
    .order_by(evaluations.c.particle)
    .limit(bindparam("most"))
)


def list_results(connection: Connection, job_id: str, generation: int, most: int = 2**31) -> Sequence[Record]:
    """Return ``objective``, ``reason``, ``message``, ``seconds``, ``kept`` of the first counted results, in order."""
    return RESULTS.rows(connection, {"job_id": job_id, "generation": generation, "most": most})


def drop_generation(connection: Connection, job_id: str, generation: int) -> None:
    """Remove the evaluations of a generation, and the tries at them."""
    for table in (attempts, evaluations):
        connection.execute(delete(table).where(table.c.job_id == job_id, table.c.generation == generation))


def renew_leases(
    connection: Connection, job_id: str, generation: int, particles: Sequence[int], worker: str, lease: float
) -> None:
    """Renew the leases [s] that a worker still holds.

    Does not wait for the job's row, as a lease is no state. Rows that an exchange is changing now are left to it.
    """
    held = and_(
        evaluations.c.job_id == job_id,
        evaluations.c.generation == generation,
        evaluations.c.particle.in_(particles),
        evaluations.c.state == "running",
        evaluations.c.worker == worker,
    )
    if connection.dialect.name == "postgresql":
        free = select(evaluations.c.particle).where(held).with_for_update(skip_locked=True).subquery()
        held = and_(held, evaluations.c.particle.in_(select(free.c.particle)))
    connection.execute(update(evaluations).where(held).values(lease_expires_at=database_now() + lease))


def still_wanted(connection: Connection, job_id: str, generation: int, particles: Sequence[int]) -> str:
    """Return the state of the job of evaluations under way; ``gone``: there is none, ``done``: all have results."""
    state: str | None = connection.scalar(select(jobs.c.state).where(jobs.c.id == job_id))
    if state != "running":
        return state or "gone"
    missing = exists().where(
        evaluations.c.job_id == job_id,
        evaluations.c.generation == generation,
        evaluations.c.particle.in_(particles),
        evaluations.c.state.in_(UNDONE_STATES),
    )
    return state if connection.scalar(select(missing)) else "done"


def overdue(connection: Connection, lost_workers: Sequence[str]) -> Sequence[Record]:
    """Return job_id and generation of running evaluations whose lease has ended, or whose worker is lost."""
    late = evaluations.c.lease_expires_at < database_now()
    if lost_workers:
        late = late | evaluations.c.worker.in_(lost_workers)
    condition = and_(evaluations.c.state == "running", late)
    return connection.execute(select(evaluations.c.job_id, evaluations.c.generation).where(condition).distinct()).all()


def count_failed(connection: Connection, job_id: str, before: int) -> int:
    """Return how many evaluations of the generations before this one have failed."""
    failed = and_(
        evaluations.c.job_id == job_id, text("evaluations.state = 'failed'"), evaluations.c.generation < before
    )
    return connection.scalar(select(func.count()).where(failed)) or 0


def list_positions(
    connection: Connection, job_id: str, first: int, last: int
) -> dict[int, tuple[list[FloatArray], list[float | None]]]:
    """Return parameters and objectives (None: failed) of generations ``first`` to ``last``, particles in order."""
    columns = (evaluations.c.generation, evaluations.c.parameters, evaluations.c.objective)
    condition = and_(evaluations.c.job_id == job_id, evaluations.c.generation.between(first, last))
    order = (evaluations.c.generation, evaluations.c.particle)
    found: dict[int, tuple[list[FloatArray], list[float | None]]] = {}
    for generation, parameters, objective in connection.execute(select(*columns).where(condition).order_by(*order)):
        positions, objectives = found.setdefault(generation, ([], []))
        positions.append(unpack_array(parameters))
        objectives.append(objective)
    return found


def list_responses(connection: Connection, job_id: str, keys: Sequence[tuple[int, int]]) -> list[dict[str, FloatArray]]:
    """Return the responses of successful evaluations, given by generation and particle, in the order of the keys."""
    place = tuple_(evaluations.c.generation, evaluations.c.particle)
    columns = (evaluations.c.generation, evaluations.c.particle, evaluations.c.responses)
    found: dict[tuple[int, int], dict[str, FloatArray]] = {}
    for start in range(0, len(keys), ROWS_AT_ONCE):
        condition = and_(evaluations.c.job_id == job_id, place.in_(keys[start : start + ROWS_AT_ONCE]))
        for generation, particle, responses in connection.execute(select(*columns).where(condition)):
            found[generation, particle] = unpack_responses(responses)
    return [found[key] for key in keys]


def list_attempts(connection: Connection, job_id: str, generation: int, particle: int) -> Sequence[Record]:
    """Return the tries at one evaluation that did not count, in order."""
    here = (attempts.c.job_id == job_id, attempts.c.generation == generation, attempts.c.particle == particle)
    return connection.execute(select(attempts).where(*here).order_by(attempts.c.number, attempts.c.id)).all()


def get_evaluation(connection: Connection, job_id: str, generation: int, particle: int) -> Record | None:
    """Return one evaluation with its responses."""
    statement = select(evaluations).where(
        evaluations.c.job_id == job_id,
        evaluations.c.generation == generation,
        evaluations.c.particle == particle,
    )
    return connection.execute(statement).one_or_none()
