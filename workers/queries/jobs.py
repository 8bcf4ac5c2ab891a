"""Queries on jobs, their generations and events. All take the connection of the caller's transaction."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    and_,
    bindparam,
    case,
    delete,
    exists,
    func,
    or_,
    select,
    update,
)
from sqlalchemy.dialects.postgresql import insert as postgresql_insert
from sqlalchemy.dialects.sqlite import insert as sqlite_insert

from geoswarm.records.states import ENDED_STATES
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import GenerationRecord
from geoswarm.solver.progress.state import Progress
from geoswarm.solver.system.versions import versions
from geoswarm.workers.queries.evaluations import drop_generation
from geoswarm.workers.queries.queue import first_place
from geoswarm.workers.states.job import (
    DispatchGeneration,
    DropGeneration,
    JobStatus,
    PublishEvent,
    RecordGeneration,
    Transition,
)
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.codec import pack_json, text_of_program, unpack_json
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.event_listener import insert_events
from geoswarm.workers.store.outbox import insert_deliveries
from geoswarm.workers.store.statements import Statement, change, enter
from geoswarm.workers.store.tables import api_keys, evaluations, events, generations, jobs, turns

__all__ = [
    "LockedJob",
    "account_running_time",
    "clocks_overdue",
    "current_generation",
    "delete_evaluations",
    "delete_job",
    "ended_before",
    "find_by_idempotency_key",
    "get_job",
    "get_frame",
    "get_problem",
    "get_progress",
    "insert_job",
    "list_events",
    "list_generations",
    "list_news",
    "lock_job",
    "publish_state",
    "save_job",
    "which_exist",
]

# What the engine needs; the problem document only at a worker's first look at the job.
COLUMNS = [column for column in jobs.columns if column.name not in ("problem", "tags", "note")]
JOBS_A_QUERY = 400  # SQLite limits the depth of an expression
LARGE = ("progress", "grids")
LAST_EVENT = select(func.max(events.c.id)).where(events.c.job_id == jobs.c.id).scalar_subquery().label("last_event")
VIEW_COLUMNS = [*(column for column in COLUMNS if column.name not in LARGE), jobs.c.tags, LAST_EVENT]


def _locked(*columns: Any) -> Statement:
    """Lock the row, and read the clock when that is done: a statement may wait long for the lock."""
    row = select(*columns).where(jobs.c.id == bindparam("job_id")).with_for_update().subquery()
    return Statement(select(*row.c, database_now().label("now")))


LOCK = _locked(*COLUMNS)
# What most exchanges need: the search of a thousand particles is some hundred kilobytes of text, and columns cost time.
LOCK_BRIEFLY = _locked(
    *(jobs.c[name] for name in ("id", "state", "generation", "dispatched_at", "started_at", "run_seconds", "clock_at")),
    *(jobs.c[name] for name in ("typical_seconds", "priority", "line", "retry_to", "stopping", "versions", "owner")),
    case((jobs.c.progress.is_(None), None), else_="").label("progress"),
)
MACHINE = [jobs.c[name] for name in ("state", "progress", "generations", "failures", "stop_reasons", "error")]
STATE_OF_MACHINE = Statement(select(*MACHINE).where(jobs.c.id == bindparam("job_id")))
CURRENT_GENERATION = select(jobs.c.generation).where(jobs.c.id == bindparam("job_id"), jobs.c.state == "running")


@dataclass(frozen=True, slots=True)
class LockedJob:
    """A job's row, locked until the end of the transaction, and the database's time ``now``.

    ``brief``: the connection to read with what the row was locked without, see :func:`lock_job`.
    """

    row: Record
    now: float
    brief: Connection | None = None

    @property
    def id(self) -> str:
        """Id of the job."""
        return str(self.row.id)

    def job(self) -> JobStatus:
        """Return what the state machine knows of it."""
        row = self.row if self.brief is None else STATE_OF_MACHINE.rows(self.brief, {"job_id": self.id})[0]
        failures = unpack_json(row.failures)
        return JobStatus(
            state=row.state,
            progress=None if row.progress is None else Progress.from_json(unpack_json(row.progress)),
            generations=row.generations,
            failures=Counter(failures["reasons"]),
            first_message=failures["first_message"],
            kept=failures.get("kept", False),
            alike=failures.get("alike", -1),
            stop_reasons=tuple(unpack_json(row.stop_reasons)),
            error=row.error,
        )

    def run_seconds(self, gap: float) -> float:
        """Return the running time up to now [s]; a silence of more than ``gap`` [s] (no engine ran) is cut to it."""
        seconds: float = self.row.run_seconds
        if self.row.state == "running" and self.row.clock_at is not None:
            seconds += min(max(self.now - self.row.clock_at, 0.0), gap)
        return seconds


def lock_job(connection: Connection, job_id: str, *, briefly: bool = False) -> LockedJob | None:
    """Lock a job's row and read it; None when there is no such job.

    ``briefly``: without what the search knows, of which the row only says whether it is there; :meth:`LockedJob.job`
    reads it.
    """
    found = (LOCK_BRIEFLY if briefly else LOCK).rows(connection, {"job_id": job_id})
    return LockedJob(found[0], found[0].now, connection if briefly else None) if found else None


def save_job(
    connection: Connection,
    locked: LockedJob,
    transitions: Sequence[Transition],
    *,
    gap: float,
    typical_seconds: float | None = None,
    finished_at: Sequence[float] = (),
    problem: Problem | None = None,
    conclusion: Mapping[str, Any] | None = None,
) -> None:
    """Write what transitions made of a locked job, with the generations that they recorded and their events.

    ``finished_at`` gives the time of each recorded generation, by default now; ``problem`` is needed with
    generations; ``conclusion`` is what a job that ends says of its parameters.
    """
    before, after = locked.row, transitions[-1].job
    instructions = [instruction for transition in transitions for instruction in transition.instructions]
    if not instructions:
        return
    records = [instruction.record for instruction in instructions if isinstance(instruction, RecordGeneration)]
    times = list(finished_at) or [locked.now] * len(records)
    _insert_generations(connection, locked, records, times)
    published = [
        {
            "job_id": locked.id,
            "kind": instruction.kind,
            "data": pack_json(instruction.data),
            "created_at": locked.now,
        }
        for instruction in instructions
        if isinstance(instruction, PublishEvent)
    ]
    if published:
        insert_events(connection, published)
    for instruction in instructions:
        if isinstance(instruction, DropGeneration):
            drop_generation(connection, locked.id, instruction.generation)
    progress = after.progress
    ended = after.state in ENDED_STATES
    values: dict[str, Any] = {
        "state": after.state,
        "stop_reasons": pack_json(list(after.stop_reasons)),
        "error": None if after.error is None else text_of_program(after.error),
        "run_seconds": locked.run_seconds(gap),
        "clock_at": locked.now if after.state == "running" else None,
        "finished_at": locked.now if ended else None,
        "rung_at": None,
        "conclusion": None if conclusion is None else pack_json(conclusion),
    }
    if before.started_at is None and after.state == "running":
        values["started_at"] = locked.now
        values["versions"] = pack_json([dict(versions())])
    dispatched = any(isinstance(instruction, DispatchGeneration) for instruction in instructions)
    if progress is not None and (records or dispatched):
        values |= {
            "generation": progress.generation,
            "progress": pack_json(progress.to_json()),
            "dispatched_at": times[-1] if records else locked.now,
            "generations": after.generations,
            "evaluations": progress.evaluations,
            "search_evaluations": None if progress.answer is None else progress.answer.evaluations,
            "answer_evaluations": None if progress.answer is None else progress.answer.most,
            "failed_evaluations": progress.failed,
            "failures": pack_json(
                {
                    "reasons": dict(after.failures),
                    "first_message": after.first_message,
                    "kept": after.kept,
                    "alike": after.alike,
                }
            ),
        }
        if typical_seconds is not None:
            values["typical_seconds"] = typical_seconds
    if records and progress is not None and progress.best is not None:
        found = records[-1].parameters
        values |= {
            "objective": progress.best.objective,
            "best_generation": progress.best.generation,
            "best_particle": progress.best.particle,
            "parameters": pack_json(found),
            "at_bounds": None if problem is None or found is None else pack_json(problem.at_bounds(found)),
        }
    # Compare and set: the lock makes it certain, the condition proves it.
    given = {f"to_{name}": value for name, value in values.items()}
    given |= {"of_id": locked.id, "of_generation": before.generation, "of_state": before.state}
    if change(jobs, ("id", "generation", "state"), tuple(values)).write(connection, [given]) != 1:
        raise RuntimeError(f"job {locked.id} changed while its row was locked")
    if ended:
        insert_deliveries(connection, locked.id, before.owner, after.state, locked.now)


def publish_state(
    connection: Connection, locked: LockedJob, state: str, stop_reasons: Sequence[str], error: str | None
) -> None:
    """Tell watchers that the state of a job has changed."""
    data = pack_json({"state": state, "stop_reasons": list(stop_reasons), "error": error})
    insert_events(connection, [{"job_id": locked.id, "kind": "state", "data": data, "created_at": locked.now}])


def _insert_generations(
    connection: Connection, locked: LockedJob, records: Sequence[GenerationRecord], times: Sequence[float]
) -> None:
    if not records:
        return
    begun = [locked.row.dispatched_at, *times[:-1]]
    enter(
        connection,
        generations,
        [
            {
                "job_id": locked.id,
                "number": record.number,
                "evaluations": record.evaluations,
                "failed": record.failed,
                "best_objective": record.best_objective,
                "objective": record.objective,
                "parameters": None if record.parameters is None else pack_json(record.parameters),
                "created_at": created_at,
                "finished_at": finished_at,
            }
            for record, created_at, finished_at in zip(records, begun, times, strict=True)
        ],
    )


def insert_job(connection: Connection, values: Mapping[str, Any]) -> bool:
    """Enter a queued job, with its first event; False when its id or idempotency key is there already."""
    row = {
        "state": "queued",
        "generation": -1,
        "generations": 0,
        "evaluations": 0,
        "failed_evaluations": 0,
        "failures": pack_json({"reasons": {}, "first_message": None, "alike": 0}),
        "stop_reasons": "[]",
        "run_seconds": 0.0,
        "created_at": database_now(),
        "line": values.get("owner") or "",
        "place": first_place(values.get("priority", 0)),
    } | dict(values)
    upsert = sqlite_insert if connection.dialect.name == "sqlite" else postgresql_insert
    if connection.scalar(upsert(jobs).values(row).on_conflict_do_nothing().returning(jobs.c.id)) is None:
        return False
    connection.execute(upsert(turns).values(line=row["line"]).on_conflict_do_nothing())
    data = pack_json({"state": "queued", "stop_reasons": [], "error": None})
    now = connection.scalar(select(database_now()))
    insert_events(connection, [{"job_id": values["id"], "kind": "state", "data": data, "created_at": now}])
    return True


def get_job(connection: Connection, job_id: str) -> Record | None:
    """Return what a view shows of a job, with the time ``now``."""
    statement = select(*VIEW_COLUMNS, jobs.c.note, database_now().label("now")).where(jobs.c.id == job_id)
    return connection.execute(statement).one_or_none()


def current_generation(connection: Connection, job_id: str) -> int | None:
    """Return the current generation of a running job, None if there is no such job."""
    number: int | None = connection.scalar(CURRENT_GENERATION, {"job_id": job_id})
    return number


def get_problem(connection: Connection, job_id: str) -> Record | None:
    """Return ``problem``, ``seed``, ``name``, and changed ``stopping`` or None, of a job, as they are stored."""
    columns = (jobs.c.problem, jobs.c.seed, jobs.c.name, jobs.c.stopping)
    return connection.execute(select(*columns).where(jobs.c.id == job_id)).one_or_none()


def get_progress(connection: Connection, job_id: str) -> Progress | None:
    """Return what the search of a job knows; None before its first generation."""
    stored = connection.scalar(select(jobs.c.progress).where(jobs.c.id == job_id))
    return None if stored is None else Progress.from_json(unpack_json(stored))


def get_frame(connection: Connection, job_id: str) -> Record | None:
    """Return ``owner``, and ``free_parameters`` and ``grids`` of a job as they are stored."""
    statement = select(jobs.c.owner, jobs.c.free_parameters, jobs.c.grids).where(jobs.c.id == job_id)
    return connection.execute(statement).one_or_none()


def find_by_idempotency_key(connection: Connection, key: str) -> Record | None:
    """Return ``id`` and ``body_hash`` of the job that was submitted with a key."""
    return connection.execute(select(jobs.c.id, jobs.c.body_hash).where(jobs.c.idempotency_key == key)).one_or_none()


def list_generations(
    connection: Connection, job_id: str, *, after: int, limit: int, numbers: Sequence[int] | None = None
) -> Sequence[Record]:
    """Return finished generations with a number above ``after``, and one of ``numbers`` if given, in order."""
    condition = and_(generations.c.job_id == job_id, generations.c.number > after)
    if numbers is not None:
        condition = and_(condition, generations.c.number.in_(numbers))
    return connection.execute(select(generations).where(condition).order_by(generations.c.number).limit(limit)).all()


def list_events(connection: Connection, job_id: str, *, after: int, limit: int) -> Sequence[Record]:
    """Return events with an id above ``after``, in order."""
    condition = and_(events.c.job_id == job_id, events.c.id > after)
    return connection.execute(select(events).where(condition).order_by(events.c.id).limit(limit)).all()


def list_news(connection: Connection, after: Mapping[str, int], *, limit: int) -> Sequence[Record]:
    """Return events of several jobs, each above the id given for it, in order.

    Ids of one job's events grow in the order of their commits, as its row is locked; ids of different jobs need not.
    """
    found: list[Record] = []
    watched = list(after.items())
    for start in range(0, len(watched), JOBS_A_QUERY):
        part = watched[start : start + JOBS_A_QUERY]
        news = or_(*(and_(events.c.job_id == job_id, events.c.id > last) for job_id, last in part))
        found += connection.execute(select(events).where(news).order_by(events.c.id).limit(limit)).all()
    return found


def which_exist(connection: Connection, job_ids: Collection[str]) -> set[str]:
    """Return those of the ids that are jobs."""
    return set(connection.scalars(select(jobs.c.id).where(jobs.c.id.in_(job_ids))))


def delete_evaluations(connection: Connection, job_id: str, most: int) -> int:
    """Remove evaluations of a job, the last ones first; return how many there were to remove, at most ``most``."""
    rows = connection.execute(
        select(evaluations.c.generation)
        .where(evaluations.c.job_id == job_id)
        .order_by(evaluations.c.generation.desc(), evaluations.c.particle.desc())
        .limit(most)
    ).all()
    if rows:
        condition = and_(evaluations.c.job_id == job_id, evaluations.c.generation >= rows[-1].generation)
        connection.execute(delete(evaluations).where(condition))
    return len(rows)


def delete_job(connection: Connection, job_id: str) -> None:
    """Remove a job and everything that belongs to it."""
    connection.execute(delete(api_keys).where(api_keys.c.job_id == job_id))
    connection.execute(update(jobs).where(jobs.c.parent == job_id).values(parent=None))
    connection.execute(delete(jobs).where(jobs.c.id == job_id))


def ended_before(connection: Connection, seconds: float, states: Collection[str]) -> Sequence[Record]:
    """Return ``id``, ``name``, ``state`` and ``evaluations`` of jobs that ended longer than this ago [s]."""
    condition = and_(jobs.c.state.in_(states), jobs.c.finished_at < database_now() - seconds)
    columns = (jobs.c.id, jobs.c.name, jobs.c.state, jobs.c.evaluations)
    return connection.execute(select(*columns).where(condition).order_by(jobs.c.finished_at)).all()


def clocks_overdue(connection: Connection, seconds: float) -> bool:
    """Whether some running job's time was not brought up to date for this long [s]."""
    return bool(connection.scalar(select(exists().where(_clock_older_than(seconds)))))


def account_running_time(connection: Connection, older_than: float, gap: float) -> None:
    """Bring the running time of running jobs up to date; so only time in which some engine was up is counted."""
    elapsed = database_now() - jobs.c.clock_at
    counted = jobs.c.run_seconds + case((elapsed > gap, gap), else_=elapsed)
    statement = update(jobs).where(_clock_older_than(older_than))
    connection.execute(statement.values(run_seconds=counted, clock_at=database_now()))


def _clock_older_than(seconds: float) -> ColumnElement[bool]:
    return and_(jobs.c.state == "running", jobs.c.clock_at < database_now() - seconds)
