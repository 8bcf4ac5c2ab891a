"""Applies events to the store: locks the job's row, calls the pure state machines, writes, commits, and then wakes.

Every change of a job and of its evaluations happens while the transaction holds the lock of the job's row, taken before
anything else is read. So counting what is left of a generation and advancing it cannot race, whatever the isolation
level, and there is one order of locks.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, MutableMapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any
from weakref import WeakKeyDictionary

from sqlalchemy import Connection

from geoswarm.records.states import ENDED_STATES, SERVED_STATES
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.course import Course
from geoswarm.solver.errors import InfeasibleSpaceError
from geoswarm.solver.problem import Stopping
from geoswarm.solver.problem.running import Failures
from geoswarm.solver.progress.state import Progress
from geoswarm.solver.runs.runlog import RunKey, RunLog
from geoswarm.solver.search.runs import Runs
from geoswarm.workers.coordinator.ending import change_stopping
from geoswarm.workers.coordinator.generation_rows import GenerationRows, load_generation
from geoswarm.workers.coordinator.job_exchange import Closed, Due, JobExchange
from geoswarm.workers.coordinator.retry import begin_retry, finish_retry
from geoswarm.workers.coordinator.together import Together
from geoswarm.workers.coordinator.tries import expire_cell, give_back
from geoswarm.workers.coordinator.work import AgentSide, Asked, Claim, Exchange, Submission
from geoswarm.workers.errors import JobNotFoundError, StoreUnavailableError
from geoswarm.workers.queries.evaluations import (
    count_failed,
    list_positions,
    list_responses,
    renew_leases,
)
from geoswarm.workers.queries.jobs import LockedJob, get_problem, lock_job, save_job
from geoswarm.workers.queries.workers import live_workers
from geoswarm.workers.settings import Settings
from geoswarm.workers.states.job import (
    CancelRequested,
    DispatchGeneration,
    JobBroken,
    JobEvent,
    JobRefused,
    JobStarted,
    Request,
    Transition,
    apply,
)
from geoswarm.workers.store import Store
from geoswarm.workers.store.codec import pack_json
from geoswarm.workers.store.event_listener import insert_events
from geoswarm.workers.store.problems import problem_of, unpack_problem

__all__ = ["Runtime"]

logger = logging.getLogger(__name__)


class Runtime:
    """The coordinator of all jobs in one store; it has no state of its own except a memory of finished runs.

    Parameters
    ----------
    foreign_methods
        Whether methods of other packages act in this process, which may end by it.
    """

    def __init__(self, store: Store, settings: Settings, *, foreign_methods: bool = True) -> None:
        self.store = store
        self.settings = settings
        self.foreign_methods = foreign_methods
        self.logs: MutableMapping[Course, RunLog] = WeakKeyDictionary()
        self._together = Together(self._exchange)

    def shortage(self) -> str | None:
        """Return why no evaluations are handed out and no jobs accepted now (too little free disk), or None."""
        return self.store.shortage(self.settings.disk_reserve_mb * 1e6)

    def request(self, job_id: str, event: Request) -> bool:
        """Apply a user's request; return whether to wake workers.

        Raises
        ------
        JobNotFoundError, InvalidTransitionError
        """

        def work(connection: Connection) -> bool:
            locked = lock_job(connection, job_id)
            if locked is None:
                raise JobNotFoundError(job_id)
            if locked.row.retry_to is not None and isinstance(event, CancelRequested):
                self._end_retry(connection, locked)
                return False
            transition = apply(locked.job(), event)
            self._save(connection, locked, [transition])
            return bool(transition.instructions) and transition.job.state in SERVED_STATES

        return self.store.write(work)

    def change_stopping(self, job_id: str, stopping: Stopping, quota_of: str | None) -> bool:
        """Store new stop criteria, and continue a job that has ended; return whether to wake workers.

        Raises
        ------
        JobNotFoundError, InvalidTransitionError, NothingLeftError, ProblemError, QuotaExceededError
        """
        taken = 0 if quota_of is None else self.store.size_bytes()

        def work(connection: Connection) -> bool:
            locked = lock_job(connection, job_id)
            if locked is None:
                raise JobNotFoundError(job_id)
            transition = change_stopping(connection, locked, stopping, self.settings, quota_of, taken)
            if transition is not None:
                self._save(connection, locked, [transition])
            return transition is not None

        return self.store.write(work)

    def retry_failed(self, job_id: str) -> int:
        """Make the failed evaluations of a job claimable again; return their number.

        Raises
        ------
        JobNotFoundError, InvalidTransitionError, NothingToRetryError
        """

        def work(connection: Connection) -> int:
            locked = lock_job(connection, job_id)
            if locked is None:
                raise JobNotFoundError(job_id)
            return begin_retry(connection, locked, gap=self.settings.lease_seconds)

        return self.store.write(work)

    def _end_retry(self, connection: Connection, locked: LockedJob) -> None:
        """End what runs failures again; a job that had ended before is again what it was."""
        row = get_problem(connection, locked.id)
        state = None if locked.row.retry_to in ENDED_STATES else "cancelled"
        if row is not None:
            problem = problem_of(row.problem)
            finish_retry(connection, locked, problem, gap=self.settings.lease_seconds, state=state)

    def start(self, job_id: str, progress: Progress | InfeasibleSpaceError) -> None:
        """Start a queued job with its generation 0, which the caller has calculated."""
        self._apply(job_id, JobStarted(progress))

    def give_up(self, job_id: str, message: str) -> None:
        """End a job that cannot be run; one whose failures are being rerun returns to its previous state."""

        self._stop(job_id, lambda: JobBroken(message))

    def refuse(self, job_id: str, why: Callable[[], str | None]) -> None:
        """Let a job wait that this worker cannot run; if its failures are being rerun, end the rerun.

        Parameters
        ----------
        why
            Returns the reason, None: there is none any more. It is called with the job locked: a refusal
            that comes late must not stop a job that was resumed because its model is there again.
        """

        def event() -> JobRefused | None:
            message = why()
            return None if message is None else JobRefused(message)

        self._stop(job_id, event)

    def exchange(
        self,
        job_id: str,
        worker: str,
        course: Course,
        submission: Submission,
        *,
        live_workers: int,
        want: bool,
        taken_up: bool = False,
        noted: bool = False,
        agent: AgentSide | None = None,
    ) -> Exchange:
        """Accept the results of a worker, advance the job when its generation is complete, and hand out the next claim.

        Threads of one process that come together share a transaction; see
        :mod:`geoswarm.workers.coordinator.together`.

        Parameters
        ----------
        live_workers
            Number of workers that share the job's evaluations.
        want
            Whether the worker takes a new claim; it gets none while the disk is short.
        taken_up, noted
            The worker turns to this job now: the others move up in the line, if that was not noted before.
        agent
            What stands between it and the database, where the worker is the slot of an agent.
        """
        want = want and self.shortage() is None
        return self._together.ask(job_id, course, Asked(worker, submission, live_workers, want, taken_up, noted, agent))

    def _exchange(self, job_id: str, course: Course, asked: Sequence[Asked]) -> list[Exchange]:
        """Exchange for several workers in one transaction, or one by one where that cannot be."""

        def work(
            connection: Connection, what: Mapping[int, Asked], closed: Closed | None
        ) -> tuple[dict[int, Exchange] | None, Due | None]:
            locked = lock_job(connection, job_id, briefly=True)
            if locked is None:
                return {}, None
            if locked.row.retry_to is not None:
                locked = lock_job(connection, job_id) or locked  # the end of it needs all of the row
            session = JobExchange(self.settings, self.logs.get(course), connection, locked, course)
            if session.alone([*what.values()]):
                return None, None
            admitted = {number: one for number, one in what.items() if _admitted(connection, one)}
            if not admitted:
                return {}, None
            answers = dict(zip(admitted, session.run([*admitted.values()], closed), strict=True))
            for number, answer in answers.items():
                if (agent := admitted[number].agent) is not None:
                    agent.settles(connection, answer)
            return answers, session.due

        brought = dict(enumerate(asked))
        answers, due = self.store.write(lambda connection: work(connection, brought, None))
        while answers is not None and due is not None:
            if course.foreign_method and not self.foreign_methods:
                return [Exchange(due=True) for _ in asked]
            closed = self._close(job_id, course, due)
            still = {number: replace(brought[number], submission=Submission()) for number in answers}
            answers, due = self.store.write(partial(work, what=still, closed=closed))
        if answers is None:
            return [answer for one in asked for answer in self._exchange(job_id, course, [one])]
        return [answers.get(number, Exchange()) for number in range(len(asked))]

    def _close(self, job_id: str, course: Course, due: Due) -> Closed:
        """Close a generation, with all runs so far if it learns from them, while no transaction is open."""
        generation, progress = due.joined.generation, due.job.progress
        if progress is not None and not course.learns(progress):
            return Closed(generation, apply(due.job, due.joined, course), due.stopping)
        log = self.logs.setdefault(course, RunLog(course.calibration))
        if log.failed != self.store.read(lambda connection: count_failed(connection, job_id, log.generations)):
            log = self.logs[course] = RunLog(course.calibration)  # some were run again since, with success
        if log.generations <= generation:
            found = self.store.read(lambda c: list_positions(c, job_id, log.generations, generation))
            for number in range(log.generations, generation + 1):
                log.add(*found[number])

        def fetch(keys: Sequence[RunKey]) -> list[dict[str, FloatArray]]:
            return self.store.read(lambda connection: list_responses(connection, job_id, keys))

        joined = replace(due.joined, runs=log.runs(fetch))
        transition = apply(due.job, joined, course)
        return Closed(generation, transition, due.stopping, _conclusion(course, transition, joined.runs))

    def tell_kernels(self, job_id: str, compiled: int, missing: int, seconds: float | None) -> None:
        """Tell watchers of a job how many groups of kernels are compiled for it; at the end, in which time [s]."""

        def work(connection: Connection) -> None:
            locked = lock_job(connection, job_id)
            if locked is not None:
                data = pack_json({"compiled": compiled, "missing": missing, "seconds": seconds})
                row = {"job_id": job_id, "kind": "kernels", "data": data, "created_at": locked.now}
                insert_events(connection, [row])

        self.store.write(work)

    def renew(self, claim: Claim, worker: str) -> None:
        """Renew the leases of a claim."""

        def work(connection: Connection) -> None:
            lease = self.settings.lease_seconds
            renew_leases(connection, claim.job_id, claim.generation, claim.particles, worker, lease)

        self.store.write(work)

    def take_back(self, job_id: str, generation: int, held: Sequence[tuple[int, int]], worker: str) -> None:
        """Take evaluations, given by particle and attempt, from a worker that may not have them; no attempt is
        counted."""

        def work(connection: Connection) -> None:
            locked = lock_job(connection, job_id)
            if locked is None:
                return
            rows = load_generation(connection, job_id, generation, particles=[particle for particle, _ in held])
            for particle, attempt in held:
                if particle in rows.cells:
                    give_back(rows, rows.cell(particle), worker, attempt, locked.now, killed=False)
            rows.write(connection)

        self.store.write(work)

    def expire(self, job_id: str, generation: int, lost_workers: Sequence[str]) -> int:
        """End the leases of a generation that are overdue or whose worker is lost; return their number.

        A worker that is heard of has not lost its evaluation: the store is slow, and its word is on its way. It gets
        as much time again; then the evaluation goes to others, and the try does not count.
        """

        def work(connection: Connection) -> int:
            locked = lock_job(connection, job_id)
            if locked is None:
                return 0
            rows = load_generation(connection, job_id, generation)
            failures: Failures | None = None
            expired = 0
            fatal: str | None = None
            heard = live_workers(connection, self.settings.lease_seconds).difference(lost_workers)
            for cell in rows.read_running():
                lease, worker = cell.lease_expires_at, cell.status.worker
                late = 0.0 if lease is None else locked.now - lease
                if late <= 0.0 and worker not in lost_workers:
                    continue
                if worker is not None and worker in heard:
                    if late <= self.settings.lease_seconds:
                        continue
                    give_back(rows, cell, worker, cell.status.attempts, locked.now, killed=False)
                else:
                    failures = failures or read_failures(connection, job_id)
                    fatal = expire_cell(connection, rows, cell, failures, locked.now) or fatal
                expired += 1
            rows.write(connection)
            if fatal is not None and locked.row.retry_to is None:
                self._save(connection, locked, [apply(locked.job(), JobBroken(fatal))])
            return expired

        return self.store.write(work)

    def _apply(self, job_id: str, event: JobEvent) -> None:
        def work(connection: Connection) -> None:
            locked = lock_job(connection, job_id)
            if locked is not None and locked.row.retry_to is None:
                self._save(connection, locked, [apply(locked.job(), event)])

        self.store.write(work)

    def _stop(self, job_id: str, why: Callable[[], JobBroken | JobRefused | None]) -> None:
        def work(connection: Connection) -> None:
            locked = lock_job(connection, job_id)
            event = None if locked is None else why()
            if locked is None or event is None:
                return
            if locked.row.retry_to is not None:
                finish_retry(connection, locked, None, gap=self.settings.lease_seconds)
            else:
                self._save(connection, locked, [apply(locked.job(), event)])

        self.store.write(work)

    def _save(self, connection: Connection, locked: LockedJob, transitions: Sequence[Transition]) -> None:
        save_job(connection, locked, transitions, gap=self.settings.lease_seconds)
        for transition in transitions:
            for instruction in transition.instructions:
                if isinstance(instruction, DispatchGeneration):
                    GenerationRows.dispatch(locked.id, instruction.generation, instruction.positions).write(connection)


def _conclusion(course: Course, transition: Transition, runs: Runs | None) -> dict[str, Any] | None:
    """What a job says of its parameters when it ends with the runs that this needs."""
    progress = transition.job.progress
    if transition.job.state != "finished" or progress is None or progress.answer is None or runs is None:
        return None
    search_best = progress.answer.search_best(course.problem)
    from geoswarm.solver.answering import conclude  # needs SciPy: not before a search has ended

    try:
        found = conclude(course.calibration, progress, runs)
    except StoreUnavailableError:
        raise
    except Exception:  # statistics must not take the result from a job whose runs have all ended
        logger.exception("no intervals at the end of %s", course.problem.name)
        found = None
    return ({} if found is None else found.conclusion()) | {"search_best": search_best}


def _admitted(connection: Connection, asked: Asked) -> bool:
    return asked.agent is None or asked.agent.admits(connection, asked.submission)


def read_failures(connection: Connection, job_id: str) -> Failures:
    """Return the failure policy of a job's problem."""
    row = get_problem(connection, job_id)
    return Failures() if row is None else Failures.model_validate(unpack_problem(row.problem).get("failures", {}))
