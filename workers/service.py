"""What the API sees of the engine."""

from __future__ import annotations

import base64
import binascii
import builtins
import hashlib
import json
import re
import secrets
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection

from solver.calibration import choose_seed
from solver.problem import Problem
from workers.coordinator.machine import ENDED_STATES, CancelRequested, PauseRequested, ResumeRequested
from workers.coordinator.runtime import Runtime
from workers.doorbell import Doorbell
from workers.errors import (
    IdempotencyConflictError,
    InvalidCursorError,
    InvalidTransitionError,
    JobNotFoundError,
    StoreUnavailableError,
)
from workers.settings import Settings
from workers.store import Store, jobs
from workers.store.codec import clean_text, pack_json, unpack_json
from workers.store.evaluations import Filters, get_evaluation, list_evaluations
from workers.store.views import evaluation_view, event_view, generation_view, job_view, worker_view
from workers.store.workers import busy_workers, list_workers
from workers.views import EvaluationView, EventView, GenerationView, JobView, Page, WorkerView

if TYPE_CHECKING:
    from workers.statistics import StatisticsDesk

__all__ = ["JobService"]

ID_PATTERN = re.compile("[0-9a-f]{16}")  # what ``submit`` makes; nothing else needs to reach the database
STREAM_ROWS = 1000
LARGEST_PAGE = 10_000


class JobService:
    """Submits, shows and steers jobs. Safe to use from several threads.

    Every method may raise :class:`workers.errors.StoreUnavailableError`, those with a ``job_id``
    :class:`workers.errors.JobNotFoundError`.
    """

    def __init__(self, store: Store, doorbell: Doorbell, settings: Settings | None = None) -> None:
        self.store = store
        self.doorbell = doorbell
        self.settings = Settings(database_url=store.url) if settings is None else settings
        self._runtime = Runtime(store, self.settings)

    @cached_property
    def statistics(self) -> StatisticsDesk:
        """Reports and statistics of jobs; loaded when they are first asked for."""
        from workers.statistics import StatisticsDesk

        return StatisticsDesk(self.store)

    def submit(self, problem: Problem, *, idempotency_key: str | None = None) -> tuple[JobView, bool]:
        """Store a job and wake workers; return it and whether it is new.

        Raises
        ------
        IdempotencyConflictError
            When the key was used before, with another problem.
        """
        document = problem.document()
        text = pack_json(document)
        canonical = json.dumps(document, sort_keys=True, allow_nan=False)
        values: dict[str, Any] = {
            "id": secrets.token_hex(8),
            "name": clean_text(problem.name),
            "forward_model": problem.forward_model.kind,
            "method": problem.method.kind,
            "problem": text,
            "seed": choose_seed(problem.seed),
            "free_parameters": pack_json(list(problem.free_names)),
            "grids": pack_json({observation.series: observation.x.tolist() for observation in problem.observations}),
            "max_evaluations": problem.planned_evaluations,
            "idempotency_key": idempotency_key,
            "body_hash": hashlib.sha256(canonical.encode()).hexdigest(),
        }

        def work(connection: Connection) -> tuple[JobView, bool]:
            if jobs.insert_job(connection, values):
                return self._get(connection, values["id"]), True
            # The key was used before, or this very insertion was committed but its answer lost.
            same = None if idempotency_key is None else jobs.find_by_idempotency_key(connection, idempotency_key)
            if same is None or idempotency_key is None:
                return self._get(connection, values["id"]), True
            if same.body_hash != values["body_hash"]:
                raise IdempotencyConflictError(idempotency_key, same.id)
            return self._get(connection, same.id), same.id == values["id"]

        view, new = self.store.write(work)
        if new:
            self.doorbell.ring(view.id)
        return view, new

    def get(self, job_id: str) -> JobView:
        """Return one job."""
        return self.store.read(lambda connection: self._get(connection, job_id))

    def problem(self, job_id: str) -> dict[str, Any]:
        """Return the canonical problem document of a job."""

        def work(connection: Connection) -> Any:
            self._row(connection, job_id)
            return jobs.get_problem(connection, job_id)

        row = self.store.read(work)
        document: dict[str, Any] = unpack_json(row.problem)
        return document

    def list(self, *, state: str | None = None, limit: int = 50, cursor: str | None = None) -> Page[JobView]:
        """Return jobs, newest first.

        Raises
        ------
        InvalidCursorError
        """
        before = None if cursor is None else _decode_cursor(cursor, float, str)
        limit = _clip(limit)
        rows = self.store.read(lambda c: jobs.list_jobs(c, state=state, before=before, limit=limit + 1))
        views = [job_view(row, self._gap) for row in rows[:limit]]
        following = _encode_cursor(rows[limit - 1].created_at, rows[limit - 1].id) if len(rows) > limit else None
        return Page(views, following)

    def cancel(self, job_id: str) -> JobView:
        """End a job that has not ended; its finished evaluations stay.

        Raises
        ------
        InvalidTransitionError
            When it has finished or failed.
        """
        return self._request(job_id, CancelRequested())

    def pause(self, job_id: str) -> JobView:
        """Stop handing out evaluations; what runs is finished and kept.

        Raises
        ------
        InvalidTransitionError
            When it is neither queued nor running.
        """
        return self._request(job_id, PauseRequested())

    def resume(self, job_id: str) -> JobView:
        """Go on with a paused job where it stopped.

        Raises
        ------
        InvalidTransitionError
            When it is not paused.
        """
        return self._request(job_id, ResumeRequested())

    def delete(self, job_id: str) -> None:
        """Remove a job that has ended, with all that belongs to it.

        Raises
        ------
        InvalidTransitionError
            When it has not ended.
        """

        def work(connection: Connection) -> None:
            self._row(connection, job_id)
            locked = jobs.lock_job(connection, job_id)
            if locked is None:
                raise JobNotFoundError(job_id)
            if locked.row.state not in ENDED_STATES:
                raise InvalidTransitionError("delete", locked.row.state, ENDED_STATES)
            jobs.delete_job(connection, job_id)

        self.store.write(work)

    def best(self, job_id: str) -> EvaluationView | None:
        """Return the best evaluation so far with its responses; None while none has succeeded."""

        def work(connection: Connection) -> EvaluationView | None:
            job = self._row(connection, job_id)
            if job.best_generation is None:
                return None
            row = get_evaluation(connection, job_id, job.best_generation, job.best_particle)
            names, grids = self._frame(connection, job_id)
            return evaluation_view(row, names, grids)

        return self.store.read(work)

    def evaluations(
        self,
        job_id: str,
        *,
        generation: int | None = None,
        state: str | None = None,
        max_objective: float | None = None,
        limit: int = 100,
        cursor: str | None = None,
        responses: bool = False,
    ) -> Page[EvaluationView]:
        """Return evaluations ordered by (generation, particle).

        Raises
        ------
        InvalidCursorError
        """
        after = None if cursor is None else _decode_cursor(cursor, int, int)
        filters = Filters(generation, state, max_objective)
        limit = _clip(limit)

        def work(connection: Connection) -> Page[EvaluationView]:
            names, grids = self._frame(connection, job_id)
            rows = list_evaluations(connection, job_id, filters, after=after, limit=limit + 1, responses=responses)
            views = [evaluation_view(row, names, grids if responses else None) for row in rows[:limit]]
            last = views[-1] if len(rows) > limit else None
            return Page(views, None if last is None else _encode_cursor(last.generation, last.particle))

        return self.store.read(work)

    def iterate_evaluations(
        self,
        job_id: str,
        *,
        generation: int | None = None,
        state: str | None = None,
        max_objective: float | None = None,
        responses: bool = False,
    ) -> Iterator[EvaluationView]:
        """Stream evaluations ordered by (generation, particle), in short transactions and flat memory."""
        names, grids = self.store.read(lambda connection: self._frame(connection, job_id))
        filters = Filters(generation, state, max_objective)

        def stream() -> Iterator[EvaluationView]:
            after: tuple[int, int] | None = None
            while True:
                rows = self.store.read(
                    lambda connection, after=after: list_evaluations(  # type: ignore[misc]
                        connection, job_id, filters, after=after, limit=STREAM_ROWS, responses=responses
                    )
                )
                for row in rows:
                    yield evaluation_view(row, names, grids if responses else None)
                if len(rows) < STREAM_ROWS:
                    return
                after = (rows[-1].generation, rows[-1].particle)

        return stream()

    def generations(self, job_id: str, *, after: int = -1, limit: int = 1000) -> builtins.list[GenerationView]:
        """Return finished generations with a number above ``after``, in order."""

        def work(connection: Connection) -> builtins.list[GenerationView]:
            self._row(connection, job_id)
            rows = jobs.list_generations(connection, job_id, after=after, limit=_clip(limit))
            return [generation_view(row) for row in rows]

        return self.store.read(work)

    def events(self, job_id: str, *, after: int = 0, limit: int = 500) -> builtins.list[EventView]:
        """Return events with an id above ``after``, in order."""

        def work(connection: Connection) -> builtins.list[EventView]:
            self._row(connection, job_id)
            rows = jobs.list_events(connection, job_id, after=after, limit=_clip(limit))
            return [event_view(row) for row in rows]

        return self.store.read(work)

    def workers(self) -> builtins.list[WorkerView]:
        """Return the known worker processes, those lost within the last hour included."""

        def work(connection: Connection) -> builtins.list[WorkerView]:
            busy = busy_workers(connection)
            rows = list_workers(connection, self.settings.lease_seconds)
            return [worker_view(row, busy.get(row.id)) for row in rows]

        return self.store.read(work)

    def health(self) -> dict[str, str]:
        """Return ``database`` and ``broker``: ``ok``, ``embedded``, or why not; never raises."""
        try:
            self.store.ping()
        except StoreUnavailableError as error:
            database = str(error)
        else:
            database = "ok"
        return {"database": database, "broker": self.doorbell.health()}

    @property
    def _gap(self) -> float:
        return self.settings.lease_seconds

    def _row(self, connection: Connection, job_id: str) -> Any:
        row = jobs.get_job(connection, job_id) if ID_PATTERN.fullmatch(job_id) else None
        if row is None:
            raise JobNotFoundError(job_id)
        return row

    def _get(self, connection: Connection, job_id: str) -> JobView:
        return job_view(self._row(connection, job_id), self._gap)

    def _frame(self, connection: Connection, job_id: str) -> tuple[builtins.list[str], dict[str, builtins.list[float]]]:
        """Return what every evaluation of a job shares: names of the free parameters, and x of its responses."""
        row = jobs.get_frame(connection, job_id) if ID_PATTERN.fullmatch(job_id) else None
        if row is None:
            raise JobNotFoundError(job_id)
        return unpack_json(row.free_parameters), unpack_json(row.grids)

    def _request(self, job_id: str, event: CancelRequested | PauseRequested | ResumeRequested) -> JobView:
        self.get(job_id)
        if self._runtime.request(job_id, event):
            self.doorbell.ring(job_id)
        return self.get(job_id)


def _clip(limit: int) -> int:
    return max(1, min(limit, LARGEST_PAGE))


def _encode_cursor(*key: float | str) -> str:
    return base64.urlsafe_b64encode(pack_json(key).encode()).decode().rstrip("=")


def _decode_cursor(cursor: str, *types: type) -> Any:
    try:
        padded = cursor.encode("ascii") + b"=" * (-len(cursor) % 4)
        key = json.loads(base64.b64decode(padded, altchars=b"-_", validate=True))
    except (binascii.Error, ValueError):
        raise InvalidCursorError(cursor) from None
    if not isinstance(key, list) or [type(part) for part in key] != list(types):
        raise InvalidCursorError(cursor)
    if not all("\0" not in part if isinstance(part, str) else 0 <= part < 2**40 for part in key):
        raise InvalidCursorError(cursor)
    return tuple(key)
