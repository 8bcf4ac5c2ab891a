"""Queries on evaluations. Their state changes only while the job's row is locked by the same transaction."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    Update,
    and_,
    bindparam,
    delete,
    exists,
    func,
    insert,
    select,
    text,
    tuple_,
    update,
)

from geoswarm.records.states import DONE_STATES, UNDONE_STATES
from geoswarm.solver.arrays import FloatArray
from geoswarm.workers.states.evaluation import EvaluationStatus
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.codec import pack_array, unpack_array, unpack_responses
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import attempts, evaluations, jobs

__all__ = [
    "GenerationRows",
    "Cell",
    "count_failed",
    "drop_generation",
    "get_evaluation",
    "list_attempts",
    "list_positions",
    "list_responses",
    "load_generation",
    "overdue",
    "renew_leases",
    "reuse",
    "still_wanted",
    "write_new",
]

WORTH_COPYING = 50  # rows
ROWS_AT_ONCE = 200  # keys in one statement
KEY = ("job_id", "generation", "particle")

BRIEF_COLUMNS = [evaluations.c[name] for name in ("particle", "state", "attempts", "worker")]
RESULT_COLUMNS = [column.name for column in evaluations.columns if column.name not in (*KEY, "parameters")]
LIST_COLUMNS = [column for column in evaluations.columns if column.name != "responses"]
GENERATION_COLUMNS = [column for column in LIST_COLUMNS if column.name != "misfits"]
STORED_COLUMNS = ("parameters", *RESULT_COLUMNS)
# Asked for in every exchange: built once, as building takes as long as the database's answer.
GENERATION = (
    select(*BRIEF_COLUMNS)
    .where(evaluations.c.job_id == bindparam("job_id"), evaluations.c.generation == bindparam("generation"))
    .order_by(evaluations.c.particle)
)
WHOLE_GENERATION = GENERATION.with_only_columns(*GENERATION_COLUMNS)
PART = WHOLE_GENERATION.where(evaluations.c.particle.in_(bindparam("particles", expanding=True)))
EARLIER = (
    select(evaluations, database_now().label("now"))
    .where(
        evaluations.c.job_id == bindparam("job_id"),
        evaluations.c.generation < bindparam("generation"),
        evaluations.c.state.in_(DONE_STATES),
        evaluations.c.parameters.in_(bindparam("wanted", expanding=True)),
    )
    .order_by(evaluations.c.generation, evaluations.c.particle)
)


@dataclass(slots=True)
class Cell:
    """One particle of a generation; ``changes`` are the columns to write, ``stored`` what was read of the others."""

    particle: int
    status: EvaluationStatus
    rows: GenerationRows
    stored: dict[str, Any] | None = None
    changes: dict[str, Any] = field(default_factory=dict)

    @property
    def values(self) -> dict[str, Any]:
        """Its columns as they will be, but for those of its key; read when they are first asked for."""
        if self.stored is None:
            self.rows.read([self])
        return self.stored or {}

    @property
    def parameters(self) -> bytes:
        """Its position."""
        found: bytes = self.values["parameters"]
        return found

    def set(self, status: EvaluationStatus, **columns: Any) -> None:
        """Give it a new status and columns."""
        self.status = status
        self.changes |= columns
        self.changes |= {"state": status.state, "attempts": status.attempts, "worker": status.worker}
        if self.stored is not None:
            self.stored |= self.changes


class GenerationRows:
    """All particles of one generation in order, read once, changed in memory, written once.

    Of a large generation only the states are read at first: an exchange concerns few of a thousand.
    """

    def __init__(self, job_id: str, generation: int, connection: Connection | None = None) -> None:
        self.job_id = job_id
        self.generation = generation
        self.cells: list[Cell] = []
        self.lost_tries: list[dict[str, Any]] = []
        self._new = connection is None
        self._connection = connection

    @classmethod
    def dispatch(cls, job_id: str, generation: int, positions: FloatArray) -> GenerationRows:
        """Make the rows of a generation that nobody has seen; ``positions`` has shape (n, d)."""
        empty = dict.fromkeys(RESULT_COLUMNS)
        made = cls(job_id, generation)
        for particle, position in enumerate(positions):
            values = empty | {"parameters": pack_array(position), "state": "pending", "attempts": 0}
            made.cells.append(Cell(particle, EvaluationStatus(), made, values))
        return made

    def read(self, cells: Sequence[Cell]) -> None:
        """Read all columns of some cells, in one question for all."""
        missing = {cell.particle: cell for cell in cells if cell.stored is None}
        if not missing or self._connection is None:
            return
        given: dict[str, Any] = {"job_id": self.job_id, "generation": self.generation}
        statement = WHOLE_GENERATION
        if len(missing) <= ROWS_AT_ONCE:
            statement, given = PART, given | {"particles": list(missing)}
        for row in self._connection.execute(statement, given):
            if row.particle in missing:
                cell = missing[row.particle]
                cell.stored = _stored(row) | cell.changes

    @property
    def complete(self) -> bool:
        """Whether every particle has its counted result."""
        return all(cell.status.done for cell in self.cells)

    def note_try(self, cell: Cell, number: int, worker: str | None, outcome: str, at: float, **columns: Any) -> None:
        """Remember a try that does not count."""
        self.lost_tries.append(
            {
                "job_id": self.job_id,
                "generation": self.generation,
                "particle": cell.particle,
                "number": number,
                "worker": worker,
                "started_at": cell.values["started_at"],
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
        for cell in self.cells:
            if cell.changes:
                alike.setdefault(tuple(cell.changes), []).append(cell)
        for names, cells in alike.items():
            here = {"of_job_id": self.job_id, "of_generation": self.generation}
            connection.execute(
                _change(names),
                [
                    here | {"of_particle": cell.particle} | {f"to_{name}": cell.changes[name] for name in names}
                    for cell in cells
                ],
            )
            for cell in cells:
                cell.changes = {}

    def _rows(self) -> list[dict[str, Any]]:
        key = {"job_id": self.job_id, "generation": self.generation}
        return [key | {"particle": c.particle} | c.values for c in self.cells]


@cache
def _change(names: tuple[str, ...]) -> Update:
    """Return the statement that writes these columns of one evaluation."""
    here = (evaluations.c[name] == bindparam(f"of_{name}") for name in KEY)
    return update(evaluations).where(*here).values({name: bindparam(f"to_{name}") for name in names})


def write_new(connection: Connection, generations: Sequence[GenerationRows]) -> None:
    """Insert the rows of generations that were dispatched in this transaction, all at once."""
    rows = [row for generation_rows in generations for row in generation_rows._rows()]
    if len(rows) >= WORTH_COPYING and connection.dialect.name == "postgresql":
        _copy(connection, rows)
    elif rows:
        connection.execute(insert(evaluations), rows)
    for generation_rows in generations:
        generation_rows._new = False
        for cell in generation_rows.cells:
            cell.changes = {}


def _copy(connection: Connection, rows: Sequence[dict[str, Any]]) -> None:
    """Insert rows with PostgreSQL's COPY, which costs it a third of what as many insertions do."""
    names = tuple(rows[0])
    driver: Any = connection.connection.driver_connection
    with driver.cursor() as cursor, cursor.copy(f"COPY evaluations ({', '.join(names)}) FROM STDIN") as copy:
        for row in rows:
            copy.write_row([row[name] for name in names])


def load_generation(connection: Connection, job_id: str, generation: int, *, briefly: bool = False) -> GenerationRows:
    """Read one generation, ``briefly`` only the states; the caller has locked the job's row.

    Responses and misfits stay in the database: an evaluation that has them has ended and changes no more.
    """
    rows = GenerationRows(job_id, generation, connection)
    given = {"job_id": job_id, "generation": generation}
    for row in connection.execute(GENERATION if briefly else WHOLE_GENERATION, given):
        stored = None if briefly else _stored(row)
        rows.cells.append(Cell(row.particle, EvaluationStatus(row.state, row.attempts, row.worker), rows, stored))
    return rows


def _stored(row: Record) -> dict[str, Any]:
    return {name: row._mapping.get(name) for name in STORED_COLUMNS}


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


def reuse(connection: Connection, generation_rows: GenerationRows) -> None:
    """Give cells of a new generation the counted results that the same parameters had earlier in the job."""
    pending = {cell.parameters for cell in generation_rows.cells if not cell.status.done}
    given = {"job_id": generation_rows.job_id, "generation": generation_rows.generation, "wanted": list(pending)}
    earlier: dict[bytes, Record] = {}
    for row in connection.execute(EARLIER, given):
        earlier.setdefault(row.parameters, row)
    for cell in generation_rows.cells:
        if cell.parameters in earlier and not cell.status.done:
            row = earlier[cell.parameters]
            kept = ("objective", "misfits", "responses", "reason", "message", "log")
            columns = {name: row._mapping[name] for name in kept}
            cell.set(
                EvaluationStatus(row.state, 1, row.worker),
                **columns,
                started_at=row.now,
                finished_at=row.now,
                seconds=0.0,
            )


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
