"""Which part of a long history its statistics read: whole generations, so that they are found at once.

Up to :data:`MOST_READ` evaluations all are read. Of more, a search gives half of that from the generations with the
lowest objectives and half from generations spread evenly over its course; a sampling, whose generations are all alike,
gives generations spread evenly, so that what is read fills the space as the whole does.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from sqlalchemy import Connection, select, tuple_

from geoswarm.solver.progress.result import GenerationRecord
from geoswarm.workers.store.codec import unpack_json
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import evaluations, generations, jobs

__all__ = [
    "MOST_READ",
    "MOST_VALUES",
    "chosen_generations",
    "counted_failures",
    "read_evaluations",
    "read_records",
    "spaced",
]

MOST_VALUES = 4_000_000
"""Calculated values that are read of a job at once: evaluations times points, about 32 MB."""

MOST_READ = 20_000
MOST_RECORDS = 2_000
ROWS_AT_ONCE = 2_000


def chosen_generations(connection: Connection, job: Record, most: int, *, sampled: bool) -> list[int] | None:
    """Return the numbers of the generations to read, in order; None: all of them.

    Parameters
    ----------
    job
        Its row.
    most
        Number of evaluations to read, about.
    sampled
        The generations are all alike: those of a sampling, not of a search.
    """
    if job.evaluations <= most or job.generations < 2:
        return None
    count = max(most * job.generations // job.evaluations, 1)
    lowest: Sequence[int] = ()
    if not sampled:
        count = max(count // 2, 1)
        statement = select(generations.c.number).where(
            generations.c.job_id == job.id, generations.c.best_objective.is_not(None)
        )
        order = (generations.c.best_objective, generations.c.number)
        lowest = connection.scalars(statement.order_by(*order).limit(count)).all()
    best = () if job.best_generation is None else (job.best_generation,)
    return sorted({*lowest, *best, *spaced(job.generations, count), max(job.generation, 0)})


def read_evaluations(
    connection: Connection, job_id: str, numbers: Collection[int] | None, first: int = 0
) -> Iterator[Record]:
    """Give the evaluations of generations with their responses, in order of generation and particle.

    ``numbers``: of the generations; None: of all from the ``first`` on.
    """
    if numbers is not None:
        wanted = sorted(numbers)
        for start in range(0, len(wanted), ROWS_AT_ONCE):
            yield from _chosen(connection, job_id, wanted[start : start + ROWS_AT_ONCE])
    else:
        yield from _all(connection, job_id, first)


def _chosen(connection: Connection, job_id: str, numbers: Sequence[int]) -> Iterator[Record]:
    """Give generations, a page at a time.

    A list of generations together with a comparison of rows made PostgreSQL read all evaluations for each page.
    """
    key = (evaluations.c.generation, evaluations.c.particle)
    statement = select(evaluations).where(evaluations.c.job_id == job_id).order_by(*key)
    left = list(numbers)
    while left:
        page = connection.execute(statement.where(key[0].in_(left)).limit(ROWS_AT_ONCE)).all()
        yield from page
        if len(page) < ROWS_AT_ONCE:
            return
        last = page[-1]
        yield from connection.execute(statement.where(key[0] == last.generation, key[1] > last.particle)).all()
        left = [number for number in left if number > last.generation]


def _all(connection: Connection, job_id: str, first: int) -> Iterator[Record]:
    key = (evaluations.c.generation, evaluations.c.particle)
    statement = select(evaluations).where(evaluations.c.job_id == job_id).order_by(*key).limit(ROWS_AT_ONCE)
    after = (first, -1)
    while True:
        page = connection.execute(statement.where(tuple_(*key) > after)).all()
        yield from page
        if len(page) < ROWS_AT_ONCE:
            return
        after = (page[-1].generation, page[-1].particle)


def counted_failures(connection: Connection, job_id: str) -> dict[str, int]:
    """Return how many evaluations of a job have failed for which reason, as far as their generations are closed."""
    packed = connection.scalar(select(jobs.c.failures).where(jobs.c.id == job_id))
    reasons: dict[str, int] = {} if packed is None else unpack_json(packed)["reasons"]
    return reasons


def read_records(connection: Connection, job: Record) -> list[GenerationRecord]:
    """Return the finished generations, of many an even selection with the first and the last."""
    statement = select(generations).where(generations.c.job_id == job.id).order_by(generations.c.number)
    if job.generations > MOST_RECORDS:
        statement = statement.where(generations.c.number.in_(spaced(job.generations, MOST_RECORDS)))
    return [
        GenerationRecord(
            row.number,
            row.evaluations,
            row.failed,
            row.best_objective,
            row.objective,
            None if row.parameters is None else unpack_json(row.parameters),
        )
        for row in connection.execute(statement)
    ]


def spaced(total: int, points: int) -> list[int]:
    """Return at most this many whole numbers below ``total``, evenly spaced, including the first and the last."""
    if total <= points:
        return list(range(total))
    return sorted({round(i * (total - 1) / max(points - 1, 1)) for i in range(points)} | {total - 1})[-points:]
