"""One generation in the transaction that holds the lock of its job: read once, changed in memory, written once."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    Integer,
    and_,
    bindparam,
    delete,
    func,
    insert,
    or_,
    select,
    text,
)

from geoswarm.records.states import DONE_STATES
from geoswarm.solver.arrays import FloatArray
from geoswarm.workers.states.evaluation import EvaluationStatus
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.codec import pack_array
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.statements import Statement, change, enter
from geoswarm.workers.store.tables import attempts, evaluations

__all__ = ["Cell", "GenerationRows", "load_generation", "reuse", "write_new"]

KEY = ("job_id", "generation", "particle")

CELL_COLUMNS = ("state", "attempts", "worker", "parameters", "duplicates", "lease_expires_at", "started_at")
HERE = (evaluations.c.job_id == bindparam("job_id"), evaluations.c.generation == bindparam("generation"))
PENDING = text("evaluations.state = 'pending'")
RUNNING = text("evaluations.state = 'running'")
COUNTED = (
    select(
        func.count().label("size"),
        func.count().filter(PENDING).label("pending"),
        func.count().filter(or_(PENDING, RUNNING)).label("undone"),
    )
    .select_from(evaluations)
    .where(*HERE)
    .subquery("counted")
)
CELLS = select(evaluations.c.particle, *(evaluations.c[name] for name in CELL_COLUMNS)).where(*HERE)
LAST_OF_MOST = (
    select(evaluations.c.particle)
    .where(*HERE, PENDING)
    .order_by(evaluations.c.particle)
    .limit(1)
    .offset(bindparam("more_than_one"))
    .correlate(None)
    .scalar_subquery()
)
CONCERNED = or_(
    evaluations.c.particle.between(bindparam("first"), bindparam("last")),
    and_(RUNNING, or_(evaluations.c.worker == bindparam("worker"), bindparam("everybody", type_=Integer) == 1)),
    and_(PENDING, evaluations.c.particle <= func.coalesce(LAST_OF_MOST, evaluations.c.particle)),
)
OPEN = Statement(
    select(COUNTED, *CELLS.selected_columns)
    .select_from(COUNTED.outerjoin(evaluations, and_(*HERE, CONCERNED)))
    .order_by(evaluations.c.particle)
)
FURTHER = Statement(
    CELLS.where(PENDING, evaluations.c.particle > bindparam("after"))
    .order_by(evaluations.c.particle)
    .limit(bindparam("most"))
)
UNDER_WAY = Statement(CELLS.where(RUNNING).order_by(evaluations.c.particle))
_TIMES = {"lease_expires_at", "started_at", "finished_at", "seconds"}
_OF_ITS_RUN = {"state", "parameters", "attempts", "duplicates", "worker"} | _TIMES
_RESULT = [c.name for c in evaluations.c if not c.primary_key and c.name not in _OF_ITS_RUN]
"""Columns that depend on the parameters alone: equal parameters share them."""


@dataclass(slots=True)
class Cell:
    """One particle of a generation; ``changes`` are the columns to write."""

    rows: GenerationRows
    particle: int
    status: EvaluationStatus
    parameters: bytes
    duplicates: int | None = None
    lease_expires_at: float | None = None
    started_at: float | None = None
    changes: dict[str, Any] = field(default_factory=dict)

    def set(self, status: EvaluationStatus, **columns: Any) -> None:
        """Give it a new status and columns."""
        self.rows.pending += (status.state == "pending") - (self.status.state == "pending")
        self.rows.undone += self.status.done - status.done
        self.status = status
        self.changes |= columns
        self.changes |= {"state": status.state, "attempts": status.attempts, "worker": status.worker}
        for name in ("duplicates", "lease_expires_at", "started_at"):
            if name in columns:
                setattr(self, name, columns[name])


class GenerationRows:
    """One generation: how many of its particles are open, and those that somebody asks for.

    They are read once, changed in memory and written once: an exchange concerns few of a thousand.

    Parameters
    ----------
    size, pending, undone
        Number of particles, of unclaimed ones, and of those without a counted result.
    connection
        None: the generation is not in the database yet, and its particles are all here.
    """

    def __init__(
        self, job_id: str, generation: int, size: int, pending: int, undone: int, connection: Connection | None = None
    ) -> None:
        self.job_id = job_id
        self.generation = generation
        self.size, self.pending, self.undone = size, pending, undone
        self.cells: dict[int, Cell] = {}
        self.lost_tries: list[dict[str, Any]] = []
        self._new = connection is None
        self._connection = connection
        self._known: float = math.inf  # every pending particle up to this one was read

    @classmethod
    def dispatch(cls, job_id: str, generation: int, positions: FloatArray) -> GenerationRows:
        """Make the rows of a new generation; ``positions`` has shape (n, d)."""
        made = cls(job_id, generation, len(positions), len(positions), len(positions))
        for particle, position in enumerate(positions):
            made.cells[particle] = Cell(made, particle, EvaluationStatus(), pack_array(position))
        return made

    def cell(self, particle: int) -> Cell:
        """Return what was read of a particle.

        Raises
        ------
        IndexError
            The generation has none of that number.
        """
        if particle not in self.cells:
            raise IndexError(f"generation {self.generation} has {self.size} particles; there is no {particle}")
        return self.cells[particle]

    @property
    def complete(self) -> bool:
        """Whether every particle has its counted result."""
        return self.undone == 0

    def held_by(self, worker: str) -> list[Cell]:
        """Return what a worker that is in the exchange holds."""
        return [cell for cell in self.cells.values() if (cell.status.state, cell.status.worker) == ("running", worker)]

    def unclaimed(self) -> list[Cell]:
        """Return the first unclaimed particles in their order, as many as were read."""
        found = [
            cell for cell in self.cells.values() if cell.status.state == "pending" and cell.particle <= self._known
        ]
        return sorted(found, key=lambda cell: cell.particle)

    def read_unclaimed(self, most: int) -> list[Cell]:
        """Read unclaimed particles beyond those of :meth:`unclaimed`, and return them.

        The database still has those as pending whose result was recorded in this transaction.
        """
        before, further = self._known, list[Cell]()
        while len(further) < most and self._known < math.inf:
            given = {"job_id": self.job_id, "generation": self.generation, "after": self._known, "most": most}
            found = self._read(FURTHER, given)
            self._known = found[-1].particle if len(found) == most else math.inf
            further = [cell for cell in self.unclaimed() if cell.particle > before]
        return further

    def read_running(self) -> list[Cell]:
        """Read all particles that somebody holds, and return them."""
        self._read(UNDER_WAY, {"job_id": self.job_id, "generation": self.generation})
        found = [cell for cell in self.cells.values() if cell.status.state == "running"]
        return sorted(found, key=lambda cell: cell.particle)

    def _read(self, statement: Statement, given: Mapping[str, Any]) -> list[Cell]:
        if self._connection is None:
            return []
        return [self._take(row) for row in statement.rows(self._connection, given)]

    def _take(self, row: Sequence[Any]) -> Cell:
        """Keep a particle as it was read, unless it is here: it may have changed."""
        particle, state, attempts, worker, *values = row
        if particle not in self.cells:
            self.cells[particle] = Cell(self, particle, EvaluationStatus(state, attempts, worker), *values)
        return self.cells[particle]

    @classmethod
    def open(cls, connection: Connection, given: Mapping[str, Any]) -> GenerationRows:
        """Read what :data:`OPEN` selects."""
        rows = OPEN.rows(connection, given)
        size, pending, undone = rows[0][:3]
        made = cls(given["job_id"], given["generation"], size, pending, undone, connection)
        for row in rows:
            if row[3] is not None:
                made._take(row[3:])
        first = made.unclaimed()
        if len(first) < pending:
            made._known = first[given["more_than_one"]].particle
        return made

    def note_try(self, cell: Cell, number: int, worker: str | None, outcome: str, at: float, **columns: Any) -> None:
        """Remember a try that does not count."""
        self.lost_tries.append(
            {
                "job_id": self.job_id,
                "generation": self.generation,
                "particle": cell.particle,
                "number": number,
                "worker": worker,
                "started_at": cell.started_at,
                "finished_at": at,
                "outcome": outcome,
                "message": None,
                "log": None,
            }
            | columns
        )

    def forget_try(
        self, connection: Connection, cell: Cell, number: int, worker: str | None, outcomes: Collection[str]
    ) -> None:
        """Take back what was noted of a try, as there is something better to say of it."""
        connection.execute(
            delete(attempts).where(
                self._tries_at(cell),
                attempts.c.number == number,
                attempts.c.worker == worker,
                attempts.c.outcome.in_(outcomes),
            )
        )

    def _tries_at(self, cell: Cell) -> ColumnElement[bool]:
        return and_(
            attempts.c.job_id == self.job_id,
            attempts.c.generation == self.generation,
            attempts.c.particle == cell.particle,
        )

    def tries(self, connection: Connection, cell: Cell) -> Sequence[Record]:
        """Return number, worker and outcome of the tries at one evaluation that did not count, those noted here too."""
        statement = select(attempts.c.number, attempts.c.worker, attempts.c.outcome).where(self._tries_at(cell))
        if self.lost_tries:
            connection.execute(insert(attempts), self.lost_tries)
            self.lost_tries = []
        return connection.execute(statement).all()

    def write(self, connection: Connection) -> None:
        """Write what has changed."""
        if self._new:
            write_new(connection, [self])
        else:
            self._update(connection)
        if self.lost_tries:
            connection.execute(insert(attempts), self.lost_tries)
            self.lost_tries = []

    def _update(self, connection: Connection) -> None:
        """Write only columns that have changed: a claim touches few of them."""
        alike: dict[tuple[str, ...], list[Cell]] = {}
        for cell in self.cells.values():
            if cell.changes:
                alike.setdefault(tuple(cell.changes), []).append(cell)
        for names, cells in alike.items():
            here = {"of_job_id": self.job_id, "of_generation": self.generation}
            change(evaluations, KEY, names).write(
                connection,
                [
                    here | {"of_particle": cell.particle} | {f"to_{name}": cell.changes[name] for name in names}
                    for cell in cells
                ],
            )
            for cell in cells:
                cell.changes = {}


def write_new(connection: Connection, generations: Sequence[GenerationRows]) -> None:
    """Insert the rows of generations that were dispatched in this transaction, all at once."""
    cells = [cell for generation_rows in generations for cell in generation_rows.cells.values()]
    empty = dict.fromkeys(name for cell in cells for name in cell.changes) | {"state": "pending", "attempts": 0}
    rows = [
        empty
        | {"job_id": cell.rows.job_id, "generation": cell.rows.generation}
        | {"particle": cell.particle, "parameters": cell.parameters}
        | cell.changes
        for cell in cells
    ]
    if rows:
        enter(connection, evaluations, rows)
    for generation_rows in generations:
        generation_rows._new = False
    for cell in cells:
        cell.changes = {}


def load_generation(
    connection: Connection,
    job_id: str,
    generation: int,
    *,
    particles: Collection[int] = (),
    workers: Collection[str] = (),
    most: int = 1,
) -> GenerationRows:
    """Read what an exchange needs of one generation; the caller has locked the job's row.

    Parameters
    ----------
    particles, workers
        Those that are handed in or given back, and workers that may hold some. More may be read: rows cost less than a
        list.
    most
        How many unclaimed particles to read at first.
    """
    given: dict[str, Any] = {"job_id": job_id, "generation": generation, "more_than_one": most - 1}
    given |= {"first": min(particles, default=-1), "last": max(particles, default=-1)}
    given |= {"worker": next(iter(workers), ""), "everybody": int(len(workers) > 1)}
    return GenerationRows.open(connection, given)


@lru_cache(maxsize=16)
def _earlier(count: int) -> Statement:
    """Return what selects earlier results of a number of parameter sets."""
    shown = (evaluations.c[name] for name in ("parameters", "state", "worker", *_RESULT))
    return Statement(
        select(*shown, database_now().label("now"))
        .where(
            evaluations.c.job_id == bindparam("job_id"),
            evaluations.c.generation < bindparam("generation"),
            or_(*(evaluations.c.state == state for state in DONE_STATES)),
            evaluations.c.parameters.in_([bindparam(f"wanted_{number}") for number in range(count)]),
        )
        .order_by(evaluations.c.generation, evaluations.c.particle)
    )


def reuse(connection: Connection, generation_rows: GenerationRows) -> None:
    """Give cells of a new generation the counted results that the same parameters had earlier in the job."""
    pending = {cell.parameters for cell in generation_rows.cells.values() if not cell.status.done}
    given = {"job_id": generation_rows.job_id, "generation": generation_rows.generation}
    given |= {f"wanted_{number}": parameters for number, parameters in enumerate(pending)}
    earlier: dict[bytes, Record] = {}
    for row in _earlier(len(pending)).rows(connection, given):
        earlier.setdefault(row.parameters, row)
    for cell in generation_rows.cells.values():
        if cell.parameters in earlier and not cell.status.done:
            row = earlier[cell.parameters]
            columns = {name: getattr(row, name) for name in _RESULT}
            cell.set(
                EvaluationStatus(row.state, 1, row.worker),
                **columns,
                started_at=row.now,
                finished_at=row.now,
                seconds=0.0,
            )
