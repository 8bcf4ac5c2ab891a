"""A worker: claims evaluations of a job, runs them with no transaction open, hands them in, and goes on."""

from __future__ import annotations

import logging
import time
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from solver.calibration import Calibration, Evaluation, Progress
from solver.errors import InfeasibleSpaceError
from solver.problem import parse_problem
from workers.coordinator.machine import GenerationJoined, apply
from workers.coordinator.runtime import Runtime
from workers.coordinator.work import Claim, Exchange, HandIn, Leap, Result, joined
from workers.doorbell import Doorbell
from workers.errors import StoreUnavailableError, WorkersError
from workers.heart import Heart
from workers.identity import Identity
from workers.runner.evaluator import Evaluator, InlineEvaluator, NeverMind, limits_of
from workers.runner.runner import Runner
from workers.settings import Settings
from workers.slots import Slots
from workers.store import Store
from workers.store.codec import unpack_problem
from workers.store.database import Record
from workers.store.jobs import current_generation, get_problem
from workers.store.line import claimable_jobs
from workers.store.offers import read_offer
from workers.store.workers import busy_workers, count_live, forget_worker
from workers.tally import tally
from workers.tracing import record_span, span

__all__ = ["Worker"]

log = logging.getLogger(__name__)

CACHED_CALIBRATIONS = 32
LONGEST_WAIT_SECONDS = 2.0
SHORTEST_LOOK, LONGEST_LOOK = 0.002, 0.02  # between two looks for the next generation [s]
PATIENCE_SECONDS = 0.05


@dataclass(slots=True)
class _Part:
    """Results of a claim that are ready while one of its evaluations takes its time; handed in when ``due``."""

    claim: Claim
    results: Sequence[Result]
    due: float
    handed_in: int = 0


class Worker:
    """One worker of this process. :meth:`serve` belongs to one thread; a heartbeat runs beside it.

    Parameters
    ----------
    doorbell
        Wakes the other workers.
    slots
        Shared with the other workers of this group; None: every kind of forward model may use them all.
    """

    def __init__(
        self, store: Store, doorbell: Doorbell, settings: Settings, identity: Identity, slots: Slots | None = None
    ) -> None:
        self.store = store
        self.doorbell = doorbell
        self.settings = settings
        self.identity = identity
        self.runtime = Runtime(store, settings)
        self.heart = Heart(store, self.runtime, settings, identity)
        self.stopping = self.heart.stopping
        self.slots = Slots.none() if slots is None else slots
        self._evaluator: Evaluator = Runner() if settings.isolate else InlineEvaluator()
        self._live_workers = 1
        self._calibrations: OrderedDict[str, Calibration] = OrderedDict()

    def start(self) -> None:
        """Enter the list of workers, begin the heartbeat, and make ready to evaluate.

        Raises
        ------
        StoreUnavailableError
        """
        self.heart.start()
        self._evaluator.start()

    def close(self) -> None:
        """End the heartbeat and the evaluation process, and leave the list of workers."""
        self.heart.stop()
        self._evaluator.close()
        try:
            tally.flush(self.store)
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

    def most_urgent(self) -> Record | None:
        """Return ``id`` and ``forward_model`` of the same job.

        Raises
        ------
        StoreUnavailableError
        """
        settings = self.settings
        rows = self.store.read(
            lambda connection: claimable_jobs(
                connection,
                1,
                kinds=settings.kinds,
                without=self.slots.full(),
                overdue=(settings.overdue_seconds, settings.overdue_factor),
            )
        )
        return rows[0] if rows else None

    def serve(self, job_id: str) -> None:
        """Work on a job until nothing of it is to be had or the time slice ends; never raises.

        A bug anywhere in the job's own code ends this job as failed, not the worker.
        """
        extra = {"job": job_id, "worker": self.identity.id}
        try:
            calibration = self._calibration(job_id)
            if calibration is not None:
                with self.slots.hold(_kind(calibration)) as free:
                    if free:
                        self._work(job_id, calibration)
        except StoreUnavailableError as error:
            # Whatever was claimed comes back through its lease.
            log.warning("worker %s: %s", self.identity.id, error, extra=extra)
            # Jobs may be listed by a database that takes nothing in (disk full): do not ask it without a pause.
            self.stopping.wait(self.settings.poll_seconds)
        except Exception as error:
            log.exception("job %s cannot be worked on", job_id, extra=extra)
            self._give_up(job_id, f"{type(error).__name__}: {error}")
        finally:
            self.heart.claim = None

    def _work(self, job_id: str, calibration: Calibration) -> None:
        until = time.monotonic() + self.settings.slice_seconds
        self._count_live()
        answer = self._exchange(job_id, calibration, HandIn(), until, taken_up=True)
        if answer.queued:
            try:
                progress: Progress | InfeasibleSpaceError = calibration.start(self._free_slots())
            except InfeasibleSpaceError as error:
                progress = error
            self.runtime.start(job_id, progress)
            answer = self._exchange(job_id, calibration, HandIn(), until, taken_up=True)
        while answer.claim is not None:
            self.heart.claim = answer.claim
            claim = answer.claim
            with span("evaluations", job=job_id, generation=claim.generation, evaluations=len(claim.particles)):
                hand_in = self._run(claim, calibration)
            answer = self._exchange(job_id, calibration, hand_in, until)
            if answer.waiting is not None and self._generation_ends(claim, answer.waiting, until):
                answer = self._exchange(job_id, calibration, HandIn(), until)
            self.heart.claim = answer.claim
        if answer.left:
            self.doorbell.ring(job_id, kind=_kind(calibration))

    def _generation_ends(self, claim: Claim, typical: float, until: float) -> bool:
        """Wait for the others to end a generation, if nothing else is to be done and it cannot take long.

        A ring through the broker would come later than a look at the database.
        """
        pause = min(max(0.05 * typical, SHORTEST_LOOK), LONGEST_LOOK)
        patience = min(until, time.monotonic() + max(3.0 * typical, PATIENCE_SECONDS))
        while time.monotonic() < patience and self.heart.unwanted() is None:
            if self.store.read(lambda connection: current_generation(connection, claim.job_id)) != claim.generation:
                return True
            if self.most_urgent() is not None:
                return False
            self.stopping.wait(pause)
        return False

    def _exchange(
        self, job_id: str, calibration: Calibration, hand_in: HandIn, until: float, *, taken_up: bool = False
    ) -> Exchange:
        """Exchange with the runtime, again and again while the database does not answer: results are worth the wait."""
        wait = 0.1
        while True:
            try:
                answer = self.runtime.exchange(
                    job_id,
                    self.identity.id,
                    calibration,
                    hand_in,
                    live_workers=self._live_workers,
                    want=time.monotonic() < until and not self.stopping.is_set(),
                    taken_up=taken_up,
                )
            except StoreUnavailableError:
                if hand_in.claim is None or self.stopping.wait(wait):
                    raise
                wait = min(2 * wait, LONGEST_WAIT_SECONDS)
            else:
                if answer.rings:
                    self.doorbell.ring(job_id, answer.rings, kind=_kind(calibration))
                return answer

    def _run(self, claim: Claim, calibration: Calibration) -> HandIn:
        """Run a claim, or several generations when it is cheap enough; what takes long is cut and handed in early."""
        began = time.monotonic()
        failures = calibration.problem.failures
        leaps: list[Leap] = []
        job, generation, positions = claim.job, claim.generation, claim.positions
        particles: Sequence[int] = claim.particles
        attempts: Sequence[int] = claim.attempts
        while True:
            results: list[Result] = []
            killed: int | None = None
            part = _Part(claim, results, began + self.settings.chunk_seconds) if job is None else None
            budget = max(self.settings.chunk_seconds - (time.monotonic() - began), 0.0)
            outcomes = self._evaluator.run(
                claim.job_id,
                calibration,
                positions,
                limits_of(calibration.problem, self.settings),
                budget=budget,
                unwanted=partial(self._look, part, calibration),
            )
            try:
                for outcome in outcomes:
                    number = len(results)
                    particle, evaluation = particles[number], outcome.evaluation
                    self._note(claim.job_id, generation, particle, evaluation)
                    times = (claim.now + (outcome.began - began), claim.now + (outcome.ended - began))
                    results.append(Result(particle, attempts[number], evaluation, *times, outcome.log))
            except NeverMind as end:
                killed = particles[end.index]
            reasons = {r.evaluation.reason for r in results if r.evaluation.reason is not None}
            decide = any(failures.retries(reason) or failures.ends_job(reason) for reason in reasons)
            if job is None or decide or len(results) < len(positions):
                return HandIn(claim, leaps, generation, results, killed)
            elapsed = time.monotonic() - began
            event = GenerationJoined(generation, joined(_in_order(results)), claim.run_seconds + elapsed)
            transition = apply(job, event, calibration)
            leaps.append(Leap(generation, results, transition, claim.now + elapsed))
            job = transition.job
            tired = elapsed > self.settings.chunk_seconds or self.heart.unwanted() is not None
            if tired or job.state != "running" or job.progress is None:
                return HandIn(claim, leaps, job.generation, ())
            generation, positions = job.generation, job.progress.positions
            particles, attempts = range(len(positions)), [1] * len(positions)

    def _look(self, part: _Part | None, calibration: Calibration) -> float | None:
        """While a run takes its time: hand in what its neighbours have, and see whether it is still wanted."""
        if part is not None and len(part.results) > part.handed_in and time.monotonic() > part.due:
            part.handed_in = len(part.results)
            claim = part.claim
            hand_in = HandIn(claim, (), claim.generation, tuple(part.results), partial=True)
            try:
                answer = self.runtime.exchange(
                    claim.job_id, self.identity.id, calibration, hand_in, live_workers=self._live_workers, want=False
                )
            except StoreUnavailableError as error:
                log.warning("worker %s: %s", self.identity.id, error)  # it is handed in again at the end
            else:
                if answer.rings or answer.left:
                    self.doorbell.ring(claim.job_id, max(answer.rings, 1), kind=_kind(calibration))
        return self.heart.unwanted()

    def _note(self, job_id: str, generation: int, particle: int, evaluation: Evaluation) -> None:
        """Count a run, and log it when it failed."""
        tally.run(evaluation.reason or "finished", evaluation.seconds)
        record_span("evaluation", evaluation.seconds, job=job_id, generation=generation, evaluation=particle)
        if evaluation.reason is not None:
            context = {"job": job_id, "generation": generation, "evaluation": particle, "worker": self.identity.id}
            log.info("run failed: %s", evaluation.message, extra=context | {"reason": evaluation.reason})

    def _calibration(self, job_id: str) -> Calibration | None:
        """Return the job made ready, from the cache of this process if possible; None: there is no such job."""
        if job_id in self._calibrations:
            self._calibrations.move_to_end(job_id)
            return self._calibrations[job_id]
        row = self.store.read(lambda connection: get_problem(connection, job_id))
        if row is None:
            return None
        problem = parse_problem(unpack_problem(row.problem))
        offer = self.store.read(lambda connection: read_offer(connection, job_id)) if problem.warm_start else None
        calibration = Calibration(problem, row.seed, offer)
        self._calibrations[job_id] = calibration
        if len(self._calibrations) > CACHED_CALIBRATIONS:
            self._calibrations.popitem(last=False)
        return calibration

    def _give_up(self, job_id: str, message: str) -> None:
        try:
            self.runtime.give_up(job_id, message)
        except WorkersError as error:
            log.warning("job %s could not be ended: %s", job_id, error, extra={"job": job_id})

    def _free_slots(self) -> int:
        """Number of workers that hold no evaluation of another job."""
        busy = self.store.read(lambda connection: len(busy_workers(connection)))
        return max(1, self._live_workers - busy)

    def _count_live(self) -> None:
        lease = self.settings.lease_seconds
        self._live_workers = max(1, self.store.read(lambda connection: count_live(connection, lease)))


def _in_order(results: Sequence[Result]) -> list[Evaluation]:
    return [result.evaluation for result in sorted(results, key=lambda result: result.particle)]


def _kind(calibration: Calibration) -> str:
    return calibration.problem.forward_model.kind
