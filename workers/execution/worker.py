"""A worker: claims evaluations of a job, runs them with no transaction open, hands in the results, and continues."""

from __future__ import annotations

import logging
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from functools import partial

from cachetools import LRUCache

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.course import Course
from geoswarm.solver.errors import InfeasibleSpaceError
from geoswarm.solver.forward.registry import is_foreign
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.progress.state import Progress
from geoswarm.solver.runner.evaluator import BuildError, Evaluator, InlineEvaluator, NoProcessError, RunLimits
from geoswarm.solver.runner.kernels import make_ready
from geoswarm.solver.runner.runner import Runner
from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.coordinator.work import Claim, Exchange, Submission, free_slots
from geoswarm.workers.errors import StoreUnavailableError, WorkersError
from geoswarm.workers.execution.claim_runner import ClaimRunner
from geoswarm.workers.execution.heartbeat import Heartbeat
from geoswarm.workers.execution.slots import Slots
from geoswarm.workers.identity import Identity
from geoswarm.workers.operations.counters import process_counters
from geoswarm.workers.queries.jobs import current_generation, get_problem
from geoswarm.workers.queries.offers import read_offer
from geoswarm.workers.queries.queue import most_urgent_job, take_turn
from geoswarm.workers.queries.workers import begin_build, count_live, end_build, forget_worker
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.problems import unpack_problem
from geoswarm.workers.tracing import span
from geoswarm.workers.waker import Waker

__all__ = ["Worker"]

log = logging.getLogger(__name__)

CACHED_CALIBRATIONS = 32
MOST_LOST_WORKERS = 3
LONGEST_WAIT_SECONDS = 2.0
SHORTEST_LOOK, LONGEST_LOOK = 0.001, 0.02  # between two looks for the next generation [s]
PATIENCE_SECONDS = 0.05
TROUBLE_SECONDS = 5.0


class Worker:
    """One worker of this process. :meth:`serve` belongs to one thread; a heartbeat runs beside it.

    Parameters
    ----------
    waker
        Wakes the other workers.
    slots
        Shared with the other workers of this group; None: every kind of forward model may use them all.
    """

    def __init__(
        self, store: Store, waker: Waker, settings: Settings, identity: Identity, slots: Slots | None = None
    ) -> None:
        self.store = store
        self.waker = waker
        self.settings = settings
        self.identity = identity
        self.runtime = Runtime(store, settings)
        self.heartbeat = Heartbeat(store, self.runtime, settings, identity)
        self.stopping = self.heartbeat.stopping
        self.slots = Slots.none() if slots is None else slots
        self._evaluator: Evaluator = Runner(settings.passed_environment) if settings.isolate else InlineEvaluator()
        self._live_workers = 1
        self._short = False  # of disk
        self._courses: LRUCache[str, Course] = LRUCache(CACHED_CALIBRATIONS)

    def start(self) -> None:
        """Register the worker, start the heartbeat, and prepare to evaluate.

        Raises
        ------
        StoreUnavailableError
        """
        self.heartbeat.start()
        self._evaluator.start()

    def close(self) -> None:
        """End the heartbeat and the evaluation process, and leave the list of workers."""
        self.heartbeat.stop()
        self._evaluator.close()
        try:
            process_counters.flush(self.store)
            self.store.write(lambda connection: forget_worker(connection, self.identity.id))
        except StoreUnavailableError as error:
            log.warning("worker %s could not sign off: %s", self.identity.id, error)

    def next_job(self) -> str | None:
        """Return the most urgent job that this worker can do something for, None when there is nothing to do.

        Raises
        ------
        StoreUnavailableError
        """
        urgent = self.most_urgent()
        return None if urgent is None else urgent.id

    def take_turn(self) -> tuple[str, bool] | None:
        """Return the same job, and whether it is noted already that this worker turns to it.

        If so, the workers that come next choose other jobs, and do not wait for this one's first exchange.

        Raises
        ------
        StoreUnavailableError
        """
        if (noted := self._note_turn()) is not None:
            return noted.id, True
        urgent = self.most_urgent()
        if urgent is None:
            return None
        # Another worker was faster, or an exchange has the job locked: that one is left to others, if there are any.
        for passing in ((), (urgent.id,)):
            if (noted := self._note_turn(passing)) is not None:
                return noted.id, True
        return urgent.id, False

    def _note_turn(self, passing: Collection[str] = ()) -> Record | None:
        if self.store.engine.dialect.name != "postgresql":
            return None
        note = partial(take_turn, kinds=self.settings.kinds, without=self.slots.full(), passing=passing)
        return self.store.read(note)  # one statement: a transaction around it would hold its locks for longer

    def most_urgent(self) -> Record | None:
        """Return ``id`` and ``forward_model`` of the same job.

        Raises
        ------
        StoreUnavailableError
        """
        shortage = self.runtime.shortage()
        if (shortage is None) is self._short:
            self._short = shortage is not None
            log.warning(
                "worker %s %s", self.identity.id, f"waits: {shortage}" if shortage else "continues: there is room"
            )
        if shortage is not None:
            return None
        settings = self.settings
        return self.store.read(
            lambda connection: most_urgent_job(
                connection,
                kinds=settings.kinds,
                without=self.slots.full(),
                overdue=(settings.overdue_seconds, settings.overdue_factor),
            )
        )

    def serve(self, job_id: str, noted: bool = False) -> None:
        """Work on a job until nothing can be claimed or the time slice ends; never raises.

        ``noted``: that it turns to this job was noted, see :meth:`take_turn`.

        A bug anywhere in the job's own code ends this job as failed, not the worker.
        """
        extra = {"job": job_id, "worker": self.identity.id}
        try:
            course = self._course(job_id)
            if course is None:
                return
            if course.problem.forward_model.unavailable() is not None:
                self._refuse(job_id, course)
            elif self._make_ready(job_id, course):
                with self.slots.hold(_kind(course)) as free:
                    if free:
                        self._work(job_id, course, noted)
        except StoreUnavailableError as error:
            # Whatever was claimed comes back through its lease.
            log.warning("worker %s: %s", self.identity.id, error, extra=extra)
            # Jobs may be listed by a database that takes nothing in (disk full): do not ask it without a pause.
            self.stopping.wait(self.settings.poll_seconds)
        except NoProcessError as error:
            self._rest(str(error))
        except Exception as error:
            log.exception("job %s cannot be worked on", job_id, extra=extra)
            self._give_up(job_id, f"{type(error).__name__}: {error}")
        finally:
            self.heartbeat.claim = None

    def _make_ready(self, job_id: str, course: Course) -> bool:
        tell = partial(self.runtime.tell_kernels, job_id)
        return make_ready(self._evaluator, course.problem, unwanted=self.stopping.is_set, tell=tell)

    def _work(self, job_id: str, course: Course, noted: bool) -> None:
        if self.heartbeat.late:
            # The database is too slow for all that ask: fewer claims, so that leases are renewed in time.
            self.stopping.wait(self.settings.lease_seconds / 4)
        turn = _Turn(self, job_id, noted)
        self._count_live()
        answer = self._exchange(job_id, course, Submission(), turn)
        if answer.queued:
            try:
                with self._method_acts(job_id, course):
                    progress: Progress | InfeasibleSpaceError = course.start(self._free_slots(job_id, course))
            except InfeasibleSpaceError as error:
                progress = error
            self.runtime.start(job_id, progress)
            answer = self._exchange(job_id, course, Submission(), turn)
        early = partial(self._early, job_id, course, turn)
        while answer.claim is not None:
            self.heartbeat.claim = claim = answer.claim
            claimed = ClaimRunner(claim, self._evaluator, course, self.settings, self.heartbeat, early)
            with (
                span("evaluations", job=job_id, generation=claim.generation, evaluations=len(claim.particles)),
                self._method_acts(job_id, course, acts=claim.job is not None),  # it does in whole generations
            ):
                submission = claimed.run()
            if claimed.trouble is not None or course.problem.forward_model.unavailable() is not None:
                turn.end()  # what has changed is seen to when the job is taken up again
            answer = self._exchange(job_id, course, submission, turn)
            if claimed.trouble is not None:
                self._rest(claimed.trouble)
            if answer.waiting is not None and self._generation_ends(claim, answer.waiting, turn):
                answer = self._exchange(job_id, course, Submission(), turn)
            self.heartbeat.claim = answer.claim
        if answer.left:
            self.waker.wake(job_id, kind=_kind(course))

    def _rest(self, trouble: str) -> None:
        """Leave the work to others for a while: this worker cannot do any now, and no evaluation is to blame."""
        log.warning("worker %s takes no evaluation for %g s: %s", self.identity.id, TROUBLE_SECONDS, trouble)
        self.stopping.wait(TROUBLE_SECONDS)

    def _generation_ends(self, claim: Claim, typical: float, turn: _Turn) -> bool:
        """Wait for the others to end a generation, if nothing else is to be done and it cannot take long.

        A ring through the broker would come later than a look at the database.
        """
        longest = min(max(0.03 * typical, SHORTEST_LOOK), LONGEST_LOOK)
        pause = SHORTEST_LOOK  # the others began when this worker did: most often they end with it
        now = time.monotonic()
        patience = min(turn.until, now + max(3.0 * typical, PATIENCE_SECONDS))
        others = now + LONGEST_LOOK  # when to look for other work
        while now < patience and self.heartbeat.unwanted() is None:
            if self.store.read(lambda connection: current_generation(connection, claim.job_id)) != claim.generation:
                return True
            if now >= others:
                if self.most_urgent() is not None:
                    return False
                others = now + LONGEST_LOOK
            self.stopping.wait(pause)
            pause = min(1.2 * pause, longest)
            now = time.monotonic()
        return False

    def _exchange(self, job_id: str, course: Course, submission: Submission, turn: _Turn) -> Exchange:
        """Exchange with the runtime, again and again while the database does not answer: results are worth the wait."""
        wait = 0.1
        while True:
            try:
                answer = self._ask(job_id, course, submission, turn)
            except StoreUnavailableError:
                if submission.claim is None or self.stopping.wait(wait):
                    raise
                wait = min(2 * wait, LONGEST_WAIT_SECONDS)
            else:
                if answer.wakes:
                    self.waker.wake(job_id, answer.wakes, kind=_kind(course))
                return answer

    def _ask(self, job_id: str, course: Course, submission: Submission, turn: _Turn, *, want: bool = True) -> Exchange:
        """Exchange with the runtime once."""
        want = want and turn.goes_on(soon=submission.partial)
        with self._method_acts(job_id, course):
            answer = self.runtime.exchange(
                job_id,
                self.identity.id,
                course,
                submission,
                live_workers=self._live_workers,
                want=want,
                taken_up=turn.begins,
                noted=turn.noted,
            )
        turn.begins = turn.begins and answer.queued
        done, following = submission.claim, answer.claim
        if course.foreign_method and done and following and following.generation > done.generation:
            self.store.write(lambda connection: end_build(connection, job_id))
        return answer

    @contextmanager
    def _method_acts(self, job_id: str, course: Course, *, acts: bool = True) -> Iterator[None]:
        """Note that a method of another package acts in this process, which may end by it."""
        if not (acts and course.foreign_method):
            yield
            return
        self._begin(job_id)
        try:
            yield
        finally:
            self.store.write(lambda connection: end_build(connection, job_id, self.identity.id))

    def _begin(self, job_id: str) -> None:
        """Note that this worker may end by what follows; three that have ended so are enough."""
        lost = self.store.write(lambda connection: begin_build(connection, job_id, self.identity.id))
        if lost >= MOST_LOST_WORKERS:
            self.store.write(lambda connection: end_build(connection, job_id))
            raise BuildError(
                f"{lost} workers ended while they built the problem or its method acted; mend the code that ends them"
            )

    def _early(
        self, job_id: str, course: Course, turn: _Turn, submission: Submission, want: bool
    ) -> tuple[bool, Claim | None]:
        """Hand in what is ready while an evaluation runs; see :data:`geoswarm.workers.execution.claim_runner.Early`."""
        try:
            answer = self._ask(job_id, course, submission, turn, want=want)
            if answer.wakes or (answer.left and not want):
                self.waker.wake(job_id, max(answer.wakes, 1), kind=_kind(course))
        except StoreUnavailableError as error:
            log.warning("worker %s: %s", self.identity.id, error)  # it is handed in again at the end
            return False, None
        return True, answer.claim

    def _course(self, job_id: str) -> Course | None:
        """Return the job made ready, from the cache of this process if possible; None: there is no such job."""
        if job_id in self._courses:
            return self._courses[job_id]
        row = self.store.read(lambda connection: get_problem(connection, job_id))
        if row is None:
            return None
        self._begin(job_id)
        try:
            self._courses[job_id] = course = self._built(job_id, row)
        except Exception:
            self.store.write(lambda connection: end_build(connection, job_id, self.identity.id))
            raise
        built_by = self.identity.id if course.foreign_method else None  # those that it ended remain noted
        self.store.write(lambda connection: end_build(connection, job_id, built_by))
        return course

    def _built(self, job_id: str, row: Record) -> Course:
        """Build the problem of a job; what cannot be built ends an evaluation process, not this one."""
        document = unpack_problem(row.problem)
        if is_foreign(document.get("forward_model")):
            self._evaluator.build(job_id, document, row.seed, RunLimits(None, self.settings.build_memory_mb))
        problem = parse_problem(document)
        offer = self.store.read(lambda connection: read_offer(connection, job_id)) if problem.warm_start else None
        return Course(Calibration(problem, row.seed, offer))

    def _refuse(self, job_id: str, course: Course) -> None:
        def why() -> str | None:
            message = course.problem.forward_model.unavailable()
            if message is not None:
                message = f"worker {self.identity.id} refuses: {message}"
                log.warning("job %s: %s", job_id, message, extra={"job": job_id})
            return message

        self.runtime.refuse(job_id, why)

    def _give_up(self, job_id: str, message: str) -> None:
        try:
            self.runtime.give_up(job_id, message)
        except WorkersError as error:
            log.warning("job %s could not be ended: %s", job_id, error, extra={"job": job_id})

    def _free_slots(self, job_id: str, course: Course) -> int:
        model = course.problem.forward_model
        return self.store.read(lambda connection: free_slots(connection, self.settings, model, job_id))

    def _count_live(self) -> None:
        lease = self.settings.lease_seconds
        self._live_workers = max(1, self.store.read(lambda connection: count_live(connection, lease)))


def _kind(course: Course) -> str:
    return course.problem.forward_model.kind


class _Turn:
    """How long a worker stays with a job: a slice of time, and another one where no other job waits."""

    def __init__(self, worker: Worker, job_id: str, noted: bool = False) -> None:
        self._worker = worker
        self._job_id = job_id
        self._ended = False
        self.begins = True
        """The job goes to the end of the line with the next exchange."""
        self.noted = noted
        """It is there already."""
        self.until = time.monotonic() + worker.settings.slice_seconds

    def end(self) -> None:
        """Take no further claim of this job."""
        self._ended = True

    def goes_on(self, *, soon: bool) -> bool:
        """Whether the worker takes another claim of this job.

        With ``soon`` an evaluation still runs: a slice that is about to end is looked at now, while nothing waits.
        """
        if self._ended or self._worker.stopping.is_set() or (self._worker.heartbeat.late and not self.begins):
            return False
        slice_seconds = self._worker.settings.slice_seconds
        ends = self.until - (0.5 * slice_seconds if soon else 0.0)
        if time.monotonic() >= ends and self._worker.next_job() in (None, self._job_id):
            self.until = time.monotonic() + slice_seconds
            self.begins, self.noted = True, False
        return time.monotonic() < self.until
