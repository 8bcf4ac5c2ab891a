"""What the API sees of the engine."""

from __future__ import annotations

import builtins
import copy
import hashlib
import json
import re
import secrets
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection

from geoswarm.records.job import Event, Job
from geoswarm.records.problem import WarmStart
from geoswarm.records.record import Page
from geoswarm.records.service import Worker
from geoswarm.records.states import SERVED_STATES
from geoswarm.solver.calibration import choose_seed
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.forward.registry import PROGRAMS_REFUSED
from geoswarm.solver.plausibility import require_possible
from geoswarm.solver.problem import Problem, Stopping
from geoswarm.solver.problem.checks.extremes import extreme_issues
from geoswarm.solver.runs.check import CheckReport
from geoswarm.solver.runs.warm_start import forward_model_hash
from geoswarm.workers.access.principal import LOCAL, Principal
from geoswarm.workers.access.quotas import check_quotas, lock_quotas, sizes
from geoswarm.workers.agents.prepared import needs_of
from geoswarm.workers.cache import Cache
from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.errors import IdempotencyConflictError, JobNotFoundError, StoreUnavailableError
from geoswarm.workers.execution.sandbox import Sandbox
from geoswarm.workers.operations.measures import Measures, measure
from geoswarm.workers.operations.probe import OneAtATime, Probe
from geoswarm.workers.operations.retention import delete_job
from geoswarm.workers.queries import jobs
from geoswarm.workers.queries.follow_ups import find_parent
from geoswarm.workers.queries.job_list import JobFilters, count_jobs, label_job, list_jobs, list_trends
from geoswarm.workers.queries.offers import find_offer, find_warm_starts, write_offer
from geoswarm.workers.queries.views import event_view, job_view, worker_view
from geoswarm.workers.queries.workers import current_work, list_workers
from geoswarm.workers.service.attachments import Attachments
from geoswarm.workers.service.links import Links
from geoswarm.workers.service.records import JobRecords, clip
from geoswarm.workers.settings import Settings
from geoswarm.workers.states.job import CancelRequested, PauseRequested, Request, ResumeRequested
from geoswarm.workers.store import Store
from geoswarm.workers.store.codec import clean_text, pack_json, unpack_json
from geoswarm.workers.store.problems import problem_of
from geoswarm.workers.waker import Waker

if TYPE_CHECKING:
    from geoswarm.solver.calibration import Evaluation
    from geoswarm.solver.report.compared import Compared
    from geoswarm.workers.service.bodies import BodyService
    from geoswarm.workers.service.statistics import StatisticsService

__all__ = ["JobService"]

ID_PATTERN = re.compile("[0-9a-f]{16}")  # what ``submit`` makes; nothing else needs to reach the database


class JobService(JobRecords):
    """Submits, shows and steers jobs. Safe to use from several threads.

    Every method may raise :class:`geoswarm.workers.errors.StoreUnavailableError`, those with a ``job_id``
    :class:`geoswarm.workers.errors.JobNotFoundError`: also for a job that :attr:`principal` may not see. That is
    decided in :meth:`_row`, through which every method reaches its job.
    """

    def __init__(self, store: Store, waker: Waker, settings: Settings | None = None) -> None:
        self.store = store
        self.waker = waker
        self.settings = Settings(database_url=store.url) if settings is None else settings
        self.principal = LOCAL
        reserve = self.settings.disk_reserve_mb * 1e6
        self._database = OneAtATime(Probe(store, reserve_bytes=reserve).database)
        self._broker = OneAtATime(waker.health)
        self._cache = Cache()  # every copy uses the same, after it has asked :meth:`_row`
        self._runtime = Runtime(store, self.settings)
        self._sandbox = Sandbox(self.settings)

    @property
    def statistics(self) -> StatisticsService:
        """Reports and statistics of the jobs that :attr:`principal` may see; loaded when they are first asked for."""
        from geoswarm.workers.service.statistics import StatisticsService

        return StatisticsService(self.store, self._row, self._cache, self.principal.sees)

    @property
    def attachments(self) -> Attachments:
        """Files attached to the jobs that :attr:`principal` may see."""
        return Attachments(self.store, self._row, self.settings, self.principal)

    @property
    def links(self) -> Links:
        """Read-only links to the jobs that :attr:`principal` may see."""
        return Links(self.store, self._row, self.principal)

    @property
    def bodies(self) -> BodyService:
        """Meshes and fields of the jobs that :attr:`principal` may see; loaded when they are first asked for."""
        from geoswarm.workers.service.bodies import BodyService

        return BodyService(self.store, self._row, self._cache, self._sandbox)

    def on_behalf_of(self, principal: Principal) -> JobService:
        """Return this service as somebody may use it: other owners' jobs are not there."""
        bound = copy.copy(self)
        bound.principal = principal
        return bound

    def check(self, problem: Problem) -> CheckReport:
        """Make one test run of a problem, within its limits, and estimate its cost; nothing is stored.

        Raises
        ------
        InfeasibleSpaceError, ProblemError
            See :func:`geoswarm.solver.runs.check.check_problem`.
        """
        return self._sandbox.check(problem)

    def compared(self, job_id: str, document: Mapping[str, Any]) -> Compared:
        """Calculate the readings of a job with another set of parameters, within the limits of a test run.

        Raises
        ------
        ProblemError
            The set has mistakes, or the calculation fails.
        """
        from geoswarm.solver.report.compared import compared_with, set_of, with_values

        problem = self.statistics.stored(job_id).problem

        def run(problem: Problem, values: Mapping[str, float]) -> Evaluation:
            fixed = with_values(problem, values)
            return self._sandbox.evaluate(fixed, [values[name] for name in fixed.free_names])

        name, given = set_of(document, "other set")
        key = job_id, "compared", name, json.dumps(given, sort_keys=True)
        return self._cache.once(key, lambda: compared_with(problem, name, given, run))

    def warm_starts(self, problem: Problem) -> builtins.list[WarmStart]:
        """Return earlier jobs of the same forward model whose runs a problem could learn from, newest first."""
        return find_warm_starts(self.store, problem, self.principal.listed, self._cache)

    def close(self) -> None:
        """End what test runs have started."""
        self._sandbox.close()

    def submit(self, problem: Problem, *, idempotency_key: str | None = None) -> tuple[Job, bool]:
        """Store a job and wake workers; return it and whether it is new.

        Raises
        ------
        IdempotencyConflictError
            When the key was used before, with another problem.
        ProblemError
            When a job to start from is not there or offers nothing, a weight or an error of readings is beyond what can
            be calculated with, readings are impossible and not accepted, or the forward model runs programs.
        QuotaExceededError
        StoreUnavailableError
            Also when the disk has less left than its reserve.
        """
        if problem.forward_model.runs_programs:
            raise ProblemError([Issue("forward_model", PROGRAMS_REFUSED)])
        if extreme := extreme_issues(problem):
            raise ProblemError(extreme)
        require_possible(problem)
        problem.forward_model.require_available()
        owner = self.principal.owner
        # Each owner has keys of their own: guessing one must not find another's job.
        stored_key = idempotency_key if idempotency_key is None or owner is None else f"{owner}\n{idempotency_key}"
        offer = find_offer(self.store, problem, self._row) if problem.warm_start else None
        documents = {
            "problem": pack_json(problem.document()),
            "grids": pack_json({observation.series: observation.x.tolist() for observation in problem.observations}),
        }
        size = sizes(problem, documents, offer)
        quota_of = None if self.principal.role == "admin" else owner
        taken = 0 if quota_of is None else self.store.size_bytes()
        values: dict[str, Any] = {
            "id": secrets.token_hex(8),
            "name": clean_text(problem.name),
            "forward_model": problem.forward_model.kind,
            "priority": problem.priority,
            "shared_priority": problem.priority if self.principal.role == "admin" else 0,
            "method": problem.method.kind,
            "seed": choose_seed(problem.seed),
            "free_parameters": pack_json(list(problem.free_names)),
            "max_evaluations": problem.planned_evaluations,
            "idempotency_key": stored_key,
            "owner": owner,
            "body_hash": _hash(documents["problem"]),
            "forward_hash": forward_model_hash(problem),
            "needs": needs_of(problem.forward_model),
            **documents,
            **size,
        }

        def work(connection: Connection) -> tuple[Job, bool]:
            if quota_of is not None:
                lock_quotas(connection)  # before the look: its holder may have used the same key
            same = None if stored_key is None else jobs.find_by_idempotency_key(connection, stored_key)
            if same is None:
                self._require_room()
                if quota_of is not None:
                    planned = problem.planned_evaluations
                    check_quotas(connection, quota_of, planned, self.settings, size=size, taken=taken)
                parent = find_parent(connection, problem, self.principal.sees)
                if jobs.insert_job(connection, values | {"parent": parent}):
                    if offer is not None:
                        write_offer(connection, values["id"], offer)
                    return self._get(connection, values["id"]), True
                # The key was used just now, or this very insertion was committed but its answer lost.
                same = None if stored_key is None else jobs.find_by_idempotency_key(connection, stored_key)
            if same is None or idempotency_key is None:
                return self._get(connection, values["id"]), True
            if same.body_hash != values["body_hash"] and not self._equals(connection, same.id, values["body_hash"]):
                raise IdempotencyConflictError(idempotency_key, same.id)
            return self._get(connection, same.id), same.id == values["id"]

        view, new = self.store.write(work)
        if new:
            self.waker.wake(view.id, kind=view.forward_model)
        return view, new

    def get(self, job_id: str) -> Job:
        """Return one job."""
        return self.store.read(lambda connection: self._get(connection, job_id))

    def list(
        self, filters: JobFilters | None = None, *, limit: int = 50, cursor: str | None = None, trend: int = 0
    ) -> Page[Job]:
        """Return jobs, newest first unless ``filters`` say otherwise, with ``trend`` values of their convergence each.

        Raises
        ------
        InvalidCursorError
        """
        chosen, owner = filters or JobFilters(), self.principal.listed

        def work(connection: Connection) -> Page[Job]:
            rows, following = list_jobs(connection, chosen, owner=owner, limit=clip(limit), cursor=cursor)
            shortage = self._runtime.shortage()
            views = [self._view(row, shortage) for row in rows]
            if trend:
                trends = list_trends(connection, {view.id: view.generations for view in views}, trend)
                views = [replace(view, trend=trends[view.id]) for view in views]
            return Page(items=views, next_cursor=following)

        return self.store.read(work)

    def count(self, filters: JobFilters | None = None) -> int:
        """Return the number of jobs that :meth:`list` shows on all its pages."""
        chosen, owner = filters or JobFilters(), self.principal.listed
        return self.store.read(lambda connection: count_jobs(connection, chosen, owner=owner))

    def cancel(self, job_id: str) -> Job:
        """End a job that has not ended; its finished evaluations stay.

        Raises
        ------
        InvalidTransitionError
            When it has finished or failed.
        """
        return self._request(job_id, CancelRequested())

    def pause(self, job_id: str) -> Job:
        """Stop within two seconds: what finishes in the next one is kept, the rest is killed, to be run again later.

        Raises
        ------
        InvalidTransitionError
            When it is neither queued nor running.
        """
        return self._request(job_id, PauseRequested())

    def resume(self, job_id: str) -> Job:
        """Go on with a paused job where it stopped.

        Raises
        ------
        InvalidTransitionError
            When it is not paused.
        """
        return self._request(job_id, ResumeRequested())

    def change_stopping(self, job_id: str, stopping: Stopping) -> Job:
        """Replace a job's stop criteria; a finished or cancelled job continues exactly where it was.

        Raises
        ------
        InvalidTransitionError
            When it has failed, or its failed evaluations are run again.
        NothingLeftError
            When it has ended and would not go on.
        ProblemError, QuotaExceededError
        """
        view = self.get(job_id)
        quota_of = None if self.principal.role == "admin" else self.principal.owner
        if self._runtime.change_stopping(job_id, stopping, quota_of):
            self.waker.wake(job_id, kind=view.forward_model)
        return self.get(job_id)

    def label(
        self, job_id: str, tags: Collection[str] | None = None, note: str | None = None, name: str | None = None
    ) -> Job:
        """Replace the tags, the note or the name of a job; None leaves them."""

        def work(connection: Connection) -> Job:
            self._row(connection, job_id)
            label_job(connection, job_id, tags, note, name)
            return self._get(connection, job_id)

        return self.store.write(work)

    def retry_failed(self, job_id: str) -> tuple[Job, int]:
        """Run the failed evaluations of a paused or ended job again, and only them; return the job and their number.

        What the search has learned stays as it was; see :mod:`geoswarm.workers.coordinator.retry`.

        Raises
        ------
        InvalidTransitionError
            When it is queued or running.
        NothingToRetryError
            When no evaluation has failed.
        """
        kind = self.get(job_id).forward_model
        number = self._runtime.retry_failed(job_id)
        self.waker.wake(job_id, number, kind=kind)
        return self.get(job_id), number

    def delete(self, job_id: str) -> None:
        """Remove a job that has ended, with all that belongs to it, for good.

        Raises
        ------
        InvalidTransitionError
            When it has not ended.
        """
        self.get(job_id)
        delete_job(self.store, job_id)

    def news(self, after: Mapping[str, int], *, limit: int = 500) -> builtins.list[tuple[str, Event]]:
        """Return events of several jobs, each above the id given for it, with their jobs; knows no owners."""
        rows = self.store.read(lambda connection: jobs.list_news(connection, after, limit=limit))
        return [(row.job_id, event_view(row)) for row in rows]

    def existing(self, job_ids: Collection[str]) -> set[str]:
        """Return those of the ids that are jobs; knows no owners."""
        return self.store.read(lambda connection: jobs.which_exist(connection, job_ids))

    def workers(self) -> builtins.list[Worker]:
        """Return the known worker processes, those lost within the last hour included."""

        def work(connection: Connection) -> builtins.list[Worker]:
            busy = current_work(connection)
            rows = list_workers(connection, self.settings.lease_seconds)
            seen = {id: self.principal.sees(work.owner, work.job_id) for id, work in busy.items()}
            return [worker_view(row, busy.get(row.id), visible=seen.get(row.id, True)) for row in rows]

        return self.store.read(work)

    def measures(self) -> Measures:
        """Return what operators watch, over all owners: numbers only."""
        return self.store.read(lambda connection: measure(connection, self.settings.lease_seconds))

    def health(self) -> dict[str, str]:
        """Return ``database`` and ``broker``: ``ok``, ``embedded``, or why not; never raises, answers in 4 s."""
        return {"database": self._database.answer(), "broker": self._broker.answer()}

    def _row(self, connection: Connection, job_id: str, query: Callable[[Connection, str], Any] = jobs.get_job) -> Any:
        row = query(connection, job_id) if ID_PATTERN.fullmatch(job_id) else None
        if row is None or not self.principal.sees(row.owner, job_id):
            raise JobNotFoundError(job_id)
        return row

    @staticmethod
    def _equals(connection: Connection, job_id: str, body_hash: str) -> bool:
        """Whether a stored problem is the same with the defaults of this version, which may have more of them."""
        row = jobs.get_problem(connection, job_id)
        try:
            return row is not None and _hash(pack_json(problem_of(row.problem).document())) == body_hash
        except ProblemError:  # no longer accepted
            return False

    def _get(self, connection: Connection, job_id: str) -> Job:
        return self._view(self._row(connection, job_id), self._runtime.shortage())

    def _view(self, row: Any, shortage: str | None) -> Job:
        view = job_view(row, self.settings.lease_seconds)
        if shortage is None or view.state not in SERVED_STATES:
            return view
        return replace(view, warnings=[*view.warnings, f"waits: {shortage}"])

    def _require_room(self) -> None:
        shortage = self._runtime.shortage()
        if shortage is not None:
            raise StoreUnavailableError(shortage)

    def _frame(self, connection: Connection, job_id: str) -> tuple[builtins.list[str], dict[str, builtins.list[float]]]:
        """Return what every evaluation of a job shares: names of the free parameters, and x of its responses."""
        row = self._row(connection, job_id, jobs.get_frame)
        return unpack_json(row.free_parameters), unpack_json(row.grids)

    def _request(self, job_id: str, event: Request) -> Job:
        kind = self.get(job_id).forward_model
        if self._runtime.request(job_id, event):
            self.waker.wake(job_id, kind=kind)
        return self.get(job_id)


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
