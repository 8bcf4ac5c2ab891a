"""The life of a job as a pure state machine: events in, new state and instructions out; no clock, no I/O.

::

    queued --JobStarted--> running --GenerationJoined (stop)--> finished | failed
      |  ^                  |   ^
      |  +---- Resume ------|---+---- paused
      +------- Pause -------+          (queued again when it had not started)
    queued, running, paused --CancelRequested--> cancelled
    queued, running         --JobBroken--------> failed
    queued, running         --JobRefused-------> paused
    finished, cancelled     --GoOnRequested----> running   (queued when it had not started)
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeAlias, assert_never

from geoswarm.records.states import OPEN_STATES, SERVED_STATES, JobState
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.course import Course
from geoswarm.solver.errors import InfeasibleSpaceError
from geoswarm.solver.methods.widths import Situation
from geoswarm.solver.progress.result import GenerationRecord, count_alike, generation_record, no_success_message
from geoswarm.solver.progress.state import Progress
from geoswarm.solver.progress.stopping import StopCriterion
from geoswarm.solver.search.runs import Runs
from geoswarm.workers.errors import InvalidTransitionError

__all__ = [
    "CancelRequested",
    "DispatchGeneration",
    "DropGeneration",
    "FinishJob",
    "GenerationJoined",
    "GoOnRequested",
    "Instruction",
    "JobStatus",
    "JobBroken",
    "JobEvent",
    "JobRefused",
    "JobStarted",
    "Joined",
    "PauseRequested",
    "PublishEvent",
    "RecordGeneration",
    "Request",
    "ResumeRequested",
    "WakeWorkers",
    "Transition",
    "apply",
]


@dataclass(frozen=True, slots=True)
class JobStatus:
    """What the machine knows of a job.

    Parameters
    ----------
    progress
        None before the start.
    generations
        Number of finished ones.
    failures
        Failed evaluations by reason, over finished generations.
    first_message
        Message of the first of them.
    kept
        Whether one of them keeps series of its parts.
    alike
        Number of runs, over finished generations, if all gave one objective, else -1.
    """

    state: JobState = "queued"
    progress: Progress | None = None
    generations: int = 0
    failures: Mapping[str, int] = field(default_factory=dict)
    first_message: str | None = None
    kept: bool = False
    alike: int = 0
    stop_reasons: tuple[str, ...] = ()
    error: str | None = None

    @property
    def generation(self) -> int:
        """Number of the generation under evaluation, -1 before the start."""
        return -1 if self.progress is None else self.progress.generation


@dataclass(frozen=True, slots=True)
class Joined:
    """Counted result of one particle: f, or None and the reason and message of its failure.

    ``kept``: although it failed, it keeps series of its parts.
    """

    objective: float | None
    reason: str | None = None
    message: str | None = None
    kept: bool = False


@dataclass(frozen=True, slots=True)
class JobStarted:
    """A worker takes the job up; ``progress`` is :meth:`Course.start`, or why the search cannot start."""

    progress: Progress | InfeasibleSpaceError


@dataclass(frozen=True, slots=True)
class GenerationJoined:
    """Every particle of a generation has its counted result, here in particle order; ``seconds``: running time [s].

    ``runs``: all evaluations so far, for a search that learns from them. ``criteria``: when to stop, where that was
    changed since the job was submitted. ``situation``: what decides on the size of what is asked for next.
    """

    generation: int
    results: Sequence[Joined]
    seconds: float
    runs: Runs | None = None
    criteria: Sequence[StopCriterion] | None = None
    situation: Situation | None = None


@dataclass(frozen=True, slots=True)
class CancelRequested:
    """The user wants the job to end."""


@dataclass(frozen=True, slots=True)
class PauseRequested:
    """The user wants the job to wait."""


@dataclass(frozen=True, slots=True)
class ResumeRequested:
    """The user wants a waiting job to go on."""


@dataclass(frozen=True, slots=True)
class GoOnRequested:
    """The user wants a job that has ended to go on where it was; that it has somewhere to go was seen to before."""


@dataclass(frozen=True, slots=True)
class JobBroken:
    """The job cannot be worked on: its forward model is not installed here, or the search itself failed."""

    message: str


@dataclass(frozen=True, slots=True)
class JobRefused:
    """A worker cannot run the forward model as it is there; the job waits until a user has it go on."""

    message: str


Request: TypeAlias = CancelRequested | PauseRequested | ResumeRequested | GoOnRequested
JobEvent: TypeAlias = JobStarted | GenerationJoined | Request | JobBroken | JobRefused


@dataclass(frozen=True, slots=True)
class DispatchGeneration:
    """Make the evaluations of a generation claimable; ``positions`` has shape (n, d)."""

    generation: int
    positions: FloatArray


@dataclass(frozen=True, slots=True)
class DropGeneration:
    """Forget the evaluations of a generation that was asked ahead: the job has ended before it was its turn."""

    generation: int


@dataclass(frozen=True, slots=True)
class RecordGeneration:
    """Store the summary of a finished generation."""

    record: GenerationRecord


@dataclass(frozen=True, slots=True)
class PublishEvent:
    """Notify watchers."""

    kind: Literal["state", "generation"]
    data: dict[str, Any]


@dataclass(frozen=True, slots=True)
class FinishJob:
    """The job has ended: stop its clock."""


@dataclass(frozen=True, slots=True)
class WakeWorkers:
    """There is work; after the commit, as the message must not overtake the rows."""


Instruction: TypeAlias = DispatchGeneration | DropGeneration | RecordGeneration | PublishEvent | FinishJob | WakeWorkers


@dataclass(frozen=True, slots=True)
class Transition:
    """New state and what is to be done; nothing to be done: the event was a duplicate or came too late."""

    job: JobStatus
    instructions: tuple[Instruction, ...] = ()


def apply(job: JobStatus, event: JobEvent, course: Course | None = None) -> Transition:
    """Apply one event; pure.

    Parameters
    ----------
    course
        Needed for :class:`GenerationJoined` only.

    Raises
    ------
    InvalidTransitionError
        When a user's request does not fit the state.
    """
    match event:
        case JobStarted(progress):
            return _start(job, progress)
        case GenerationJoined():
            return _join(job, event, course)
        case CancelRequested():
            if job.state == "cancelled":
                return Transition(job)
            _require("cancel", job, *OPEN_STATES, "cancelled")
            return _end(job, "cancelled")
        case PauseRequested():
            _require("pause", job, *SERVED_STATES)
            return _move(replace(job, state="paused"))
        case ResumeRequested():
            _require("resume", job, "paused")
            state: JobState = "queued" if job.progress is None else "running"
            return _move(replace(job, state=state, error=None), WakeWorkers())
        case GoOnRequested():
            _require("go on with", job, "finished", "cancelled")
            return _go_on(job)
        case JobBroken(message):
            if job.state not in SERVED_STATES:
                return Transition(job)
            return _end(replace(job, error=message), "failed")
        case JobRefused(message):
            if job.state not in SERVED_STATES:
                return Transition(job)
            return _move(replace(job, state="paused", error=message))
        case _:
            assert_never(event)


def _start(job: JobStatus, progress: Progress | InfeasibleSpaceError) -> Transition:
    if job.state != "queued":
        return Transition(job)
    if isinstance(progress, InfeasibleSpaceError):
        return _end(replace(job, error=str(progress)), "failed")
    started = replace(job, state="running", progress=progress)
    return _move(started, *_dispatch(progress), WakeWorkers())


def _join(job: JobStatus, event: GenerationJoined, course: Course | None) -> Transition:
    progress = job.progress
    if job.state != "running" or progress is None or event.generation != progress.generation:
        return Transition(job)
    if course is None or len(event.results) != len(progress.positions):
        raise ValueError(
            f"generation {event.generation} joins {len(event.results)} results of {len(progress.positions)} particles"
            f" ({'with' if course else 'without'} a course)"
        )
    objectives = [result.objective for result in event.results]
    reasons = Counter(result.reason for result in event.results if result.reason is not None)
    failures = dict(Counter(job.failures) + reasons)
    step = course.advance(progress, objectives, event.seconds, event.runs, event.criteria, event.situation, failures)
    alike = count_alike(job.alike, progress.best, objectives)
    record = generation_record(course.problem, progress.generation, objectives, step.progress, alike)
    messages = (result.message for result in event.results if result.reason is not None)
    after = replace(
        job,
        progress=step.progress,
        generations=job.generations + 1,
        failures=failures,
        first_message=job.first_message or next(messages, None),
        kept=job.kept or any(result.kept for result in event.results),
        alike=alike,
        stop_reasons=step.stop_reasons,
    )
    done: tuple[Instruction, ...] = (
        RecordGeneration(record),
        PublishEvent("generation", _generation_data(record)),
    )
    answering = progress.answer is None and step.progress.answer is not None
    begun = progress.ahead_begun
    if begun and (step.stop_reasons or answering):
        done, begun = (*done, DropGeneration(step.progress.generation)), False
    if not step.stop_reasons:
        return Transition(after, (*done, *_dispatch(step.progress, begun=begun), WakeWorkers()))
    after = replace(after, progress=replace(step.progress, ahead_begun=False))
    if step.progress.best is None and not after.kept:
        error = no_success_message(Counter(after.failures), after.first_message)
        ended = _end(replace(after, error=error), "failed")
    else:
        ended = _end(after, "finished")
    return Transition(ended.job, (*done, *ended.instructions))


def _go_on(job: JobStatus) -> Transition:
    """Ended by a criterion, the next generation is known but was never begun; cancelled, it is there already."""
    if job.progress is None:
        return _move(replace(job, state="queued"), WakeWorkers())
    after = replace(job, state="running", stop_reasons=(), error=None)
    if job.state == "cancelled":
        return _move(after, WakeWorkers())
    after = replace(after, progress=job.progress.going_on())
    return _move(after, *_dispatch(job.progress.going_on()), WakeWorkers())


def _dispatch(progress: Progress, *, begun: bool = False) -> list[DispatchGeneration]:
    """Dispatch the generation, unless it was begun ahead, and the one after it where that begins ahead."""
    dispatched = [] if begun else [DispatchGeneration(progress.generation, progress.positions)]
    if progress.ahead is not None and progress.ahead_begun:
        dispatched.append(DispatchGeneration(progress.generation + 1, progress.ahead))
    return dispatched


def _end(job: JobStatus, state: JobState) -> Transition:
    return _move(replace(job, state=state), FinishJob())


def _move(job: JobStatus, *instructions: Instruction) -> Transition:
    data = {"state": job.state, "stop_reasons": list(job.stop_reasons), "error": job.error}
    return Transition(job, (PublishEvent("state", data), *instructions))


def _require(action: str, job: JobStatus, *accepted: JobState) -> None:
    if job.state not in accepted:
        raise InvalidTransitionError(action, job.state, accepted)


def _generation_data(record: GenerationRecord) -> dict[str, Any]:
    return {
        "number": record.number,
        "evaluations": record.evaluations,
        "failed": record.failed,
        "best_objective": record.best_objective,
        "objective": record.objective,
        "parameters": record.parameters,
        "search_evaluations": record.search_evaluations,
        "answer_evaluations": record.answer_evaluations,
    }
