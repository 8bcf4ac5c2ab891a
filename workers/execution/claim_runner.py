"""What a worker does with a claim: runs it, hands in early what is ready, and reaches for the next one in good time."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Evaluation
from geoswarm.solver.course import Course
from geoswarm.solver.runner.evaluator import EvaluationCancelled, Evaluator, NoProcessError
from geoswarm.solver.runner.fork_server_link import POLL_SECONDS
from geoswarm.workers.coordinator.ending import changed_criteria
from geoswarm.workers.coordinator.work import Claim, LocalBatch, Result, Submission, joined
from geoswarm.workers.execution.heartbeat import Heartbeat
from geoswarm.workers.execution.sandbox import limits_of
from geoswarm.workers.operations.counters import process_counters
from geoswarm.workers.settings import Settings
from geoswarm.workers.states.job import GenerationJoined, JobStatus, apply
from geoswarm.workers.tracing import record_span

__all__ = ["Early", "ClaimRunner"]

log = logging.getLogger(__name__)

Early = Callable[[Submission, bool], tuple[bool, Claim | None]]
"""Hands in results while their neighbours go on, and asks for the next claim if the second argument says so.

Gives whether they have arrived, and the claim."""

AHEAD_SECONDS = 1.2 * POLL_SECONDS  # before the end of the last evaluation of a claim


class ClaimRunner:
    """A claim under way in one worker.

    Parameters
    ----------
    claim
        What the worker holds.
    heartbeat
        Renews the leases of what is held, and knows whether it is still wanted.
    early
        Speaks to the coordinator while an evaluation runs.
    """

    def __init__(
        self,
        claim: Claim,
        evaluator: Evaluator,
        course: Course,
        settings: Settings,
        heartbeat: Heartbeat,
        early: Early,
    ) -> None:
        self._claim = self._held = claim
        self._evaluator = evaluator
        self._course = course
        self._settings = settings
        self._heartbeat = heartbeat
        self._early = early
        self._clock = claim.now - time.monotonic()
        self._results: list[Result] = []
        self._handed_in = 0
        self._ahead: Claim | None = None
        self._asked = True
        self._last = 0  # number of results with which the last evaluation of the claim begins
        self._due = self._since = 0.0
        self.trouble: str | None = None
        """Why this worker could not begin an evaluation: what it held goes back, and others may begin it."""

    def run(self) -> Submission:
        """Run it, or several generations when it is cheap enough; what takes long is cut and handed in early.

        As the last evaluation nears its end the next claim is fetched, so that no run waits for the database.
        """
        return self._piecewise() if self._claim.job is None else self._run_local_batch(self._claim.job)

    def _piecewise(self) -> Submission:
        part = self._claim
        while True:
            began = self._since = time.monotonic()
            self._due = began + self._settings.chunk_seconds
            self._last = len(self._results) + len(part.particles) - 1
            self._asked = part.last
            killed = self._evaluate(
                part.generation, part.particles, part.attempts, part.positions, began, self._results
            )
            finished = self._results[self._last + 1 - len(part.particles) :]
            cut = len(finished) < len(part.particles) or self._heartbeat.unwanted() is not None
            if self._ahead is None or cut or self._decides(finished):
                return Submission(self._held, (), part.generation, self._results[self._handed_in :], killed)
            part, self._ahead = self._ahead, None

    def _run_local_batch(self, job: JobStatus) -> Submission:
        """Run whole generations in a row."""
        claim = self._claim
        began = time.monotonic()
        criteria = changed_criteria(claim.stopping)
        local_batches: list[LocalBatch] = []
        generation, positions = claim.generation, claim.positions
        particles: Sequence[int] = claim.particles
        attempts: Sequence[int] = claim.attempts
        while True:
            results: list[Result] = []
            killed = self._evaluate(generation, particles, attempts, positions, began, results)
            if self._decides(results) or len(results) < len(positions):
                return Submission(claim, local_batches, generation, results, killed)
            elapsed = time.monotonic() - began
            results_there = joined(_in_order(results))
            event = GenerationJoined(generation, results_there, claim.run_seconds + elapsed, criteria=criteria)
            transition = apply(job, event, self._course)
            local_batches.append(LocalBatch(generation, results, transition, claim.now + elapsed))
            job = transition.job
            tired = elapsed > self._settings.chunk_seconds or self._heartbeat.unwanted() is not None
            if tired or job.state != "running" or job.progress is None or self._course.learns(job.progress):
                return Submission(claim, local_batches, job.generation, ())
            generation, positions = job.generation, job.progress.positions
            particles, attempts = range(len(positions)), [1] * len(positions)

    def _evaluate(
        self,
        generation: int,
        particles: Sequence[int],
        attempts: Sequence[int],
        positions: FloatArray,
        began: float,
        results: list[Result],
    ) -> int | None:
        """Append the results of evaluations, as many as are begun soon enough; return the particle that was killed."""
        job_id, first = self._claim.job_id, len(results)
        outcomes = self._evaluator.run(
            job_id,
            self._course.calibration,
            positions,
            limits_of(self._course.problem, self._settings),
            budget=max(began + self._settings.chunk_seconds - time.monotonic(), 0.0),
            unwanted=self._look,
        )
        try:
            for outcome in outcomes:
                number = len(results) - first
                self._note(generation, particles[number], outcome.evaluation)
                times = (self._clock + outcome.began, self._clock + outcome.ended)
                shown = None if outcome.log is None else self._course.problem.forward_model.shown(outcome.log)
                results.append(Result(particles[number], attempts[number], outcome.evaluation, *times, shown))
                self._since = outcome.ended
        except EvaluationCancelled as end:
            return particles[end.index]
        except NoProcessError as error:
            self.trouble = str(error)
        return None

    def _look(self) -> float | None:
        """While a run takes its time: hand in what is ready, and tell how long it may go on when it is not wanted."""
        unwanted = self._heartbeat.unwanted()
        now = time.monotonic()
        typical = self._claim.typical
        if not self._asked and unwanted is None and typical is not None and typical <= self._settings.single_seconds:
            if len(self._results) == self._last and now > self._since + typical - AHEAD_SECONDS:
                self._asked = True
                self._reach(want=True)
        elif len(self._results) > self._handed_in and now > self._due:
            self._due = now + self._settings.chunk_seconds
            self._reach(want=False)
        return unwanted

    def _reach(self, *, want: bool) -> None:
        ready = tuple(self._results[self._handed_in :])
        arrived, ahead = self._early(Submission(self._held, (), self._held.generation, ready, partial=True), want)
        if arrived:
            self._handed_in += len(ready)
        if ahead is not None:
            self._ahead = ahead
            self._held = self._heartbeat.claim = self._held.followed_by(ahead, without=ready)

    def _decides(self, results: Sequence[Result]) -> bool:
        """Whether a failure among them is for the coordinator to decide on."""
        failures = self._course.problem.failures
        reasons = {r.evaluation.reason for r in results if r.evaluation.reason is not None}
        return any(failures.retries(reason) or failures.ends_job(reason) for reason in reasons)

    def _note(self, generation: int, particle: int, evaluation: Evaluation) -> None:
        """Count a run, and log it when it failed."""
        job = self._claim.job_id
        process_counters.run(evaluation.reason or "finished", evaluation.seconds)
        record_span("evaluation", evaluation.seconds, job=job, generation=generation, evaluation=particle)
        if evaluation.reason is not None:
            context = {
                "job": job,
                "generation": generation,
                "evaluation": particle,
                "worker": self._heartbeat.identity.id,
            }
            log.info("run failed: %s", evaluation.message, extra=context | {"reason": evaluation.reason})


def _in_order(results: Sequence[Result]) -> list[Evaluation]:
    return [result.evaluation for result in sorted(results, key=lambda result: result.particle)]
