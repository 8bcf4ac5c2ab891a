"""Messages between a worker and the runtime, and how many runs of a job can be in progress at once."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from sqlalchemy import Connection

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Evaluation
from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.workers.queries.workers import count_live, count_machines, workers_elsewhere
from geoswarm.workers.settings import Settings
from geoswarm.workers.states.job import JobStatus, Joined, Transition

__all__ = [
    "AgentSide",
    "Asked",
    "Claim",
    "Exchange",
    "LocalBatch",
    "Result",
    "Sizing",
    "Submission",
    "free_slots",
    "joined",
]

HANDING_OUT_SECONDS = 0.0002  # what it costs to hand out an evaluation and to take in its result
LONG_BATCH = 10.0  # times local_batch_seconds, for runs that cost less than that


@dataclass(frozen=True, slots=True)
class Claim:
    """Evaluations that a worker holds, all of one generation.

    Parameters
    ----------
    particles, attempts
        Numbers of the particles, and of this try at each.
    positions
        Natural values of their free parameters, shape (k, d).
    now, run_seconds
        The database's time and the job's running time when they were claimed [s].
    job
        Given when the claim is a whole generation that is cheap enough to run several in a row; else None.
    typical
        What an evaluation of this job usually takes [s]; None: not known yet.
    stopping
        The stop criteria, where they were changed, as in the job's row.
    last
        Nothing else of the generation was left for anybody when they were claimed.
    """

    job_id: str
    generation: int
    particles: tuple[int, ...]
    attempts: tuple[int, ...]
    positions: FloatArray
    now: float
    run_seconds: float
    job: JobStatus | None
    typical: float | None = None
    stopping: str | None = None
    last: bool = False

    def followed_by(self, ahead: Claim, *, without: Sequence[Result]) -> Claim:
        """Return what remains of this claim without these results, joined with a claim that follows it."""
        finished = {result.particle for result in without}
        left = [index for index, particle in enumerate(self.particles) if particle not in finished]
        return replace(
            ahead,
            particles=(*(self.particles[index] for index in left), *ahead.particles),
            attempts=(*(self.attempts[index] for index in left), *ahead.attempts),
            positions=np.concatenate([self.positions[left], ahead.positions]),
        )


@dataclass(frozen=True, slots=True)
class Result:
    """Outcome of one attempt; times are the database's [s]; ``log``: the end of the output of a failed one."""

    particle: int
    attempt: int
    evaluation: Evaluation
    started_at: float
    finished_at: float
    log: str | None = None


@dataclass(frozen=True, slots=True)
class LocalBatch:
    """A generation that one worker ran alone, with the outcome of the state machine."""

    generation: int
    results: Sequence[Result]
    transition: Transition
    finished_at: float


@dataclass(frozen=True, slots=True)
class Submission:
    """What a worker returns for a claim: whole generations in order, then results of the last one started.

    ``killed``: it was at one more particle, which was killed on request. ``partial``: it goes on with the rest.
    """

    claim: Claim | None = None
    local_batches: Sequence[LocalBatch] = ()
    generation: int = -1
    results: Sequence[Result] = ()
    killed: int | None = None
    partial: bool = False

    def particles(self) -> list[int]:
        """Particles that it concerns: held, with results, or of the first whole generation."""
        held = [] if self.claim is None else self.claim.particles
        first = self.local_batches[0].results if self.local_batches else ()
        return [*held, *(result.particle for result in (*self.results, *first))]

    def under_way(self) -> frozenset[int]:
        """Particles that the worker continues with."""
        if self.claim is None or not self.partial:
            return frozenset()
        return frozenset(self.claim.particles) - {result.particle for result in self.results}


class AgentSide(Protocol):
    """What an exchange does for an agent, in the same transaction and with the job's row locked."""

    @property
    def versions(self) -> Mapping[str, str]:
        """Versions with which the agent calculates."""

    def most(self, typical: float | None) -> int:
        """How many evaluations the agent takes at once, if one typically takes this long [s]."""

    def admits(self, connection: Connection, submission: Submission) -> bool:
        """Whether results may be accepted: they were not before."""

    def settles(self, connection: Connection, answer: Exchange) -> None:
        """Record what the agent is given."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What one worker brings to an exchange, and requests from it; see :meth:`Runtime.exchange`.

    Parameters
    ----------
    live_workers
        Number of workers that share the job's evaluations.
    want
        Whether it takes a new claim.
    taken_up, noted
        It turns to this job now, and that was noted before.
    agent
        What stands between it and the database, where the worker is the slot of an agent.
    """

    worker: str
    submission: Submission
    live_workers: int
    want: bool
    taken_up: bool = False
    noted: bool = False
    agent: AgentSide | None = None


@dataclass(frozen=True, slots=True)
class Exchange:
    """What the runtime answers.

    Parameters
    ----------
    claim
        The next evaluations, None when there is nothing for this worker now.
    wakes
        How many other workers should be woken.
    queued
        The job has not started: its generation 0 must be asked for first.
    due
        The generation is complete, and a method of another package, which may not act in this process, has to close it.
    left
        Something is left for others.
    waiting
        Others are at the rest of the generation, and each evaluation typically takes so long [s]; None: it is not
        known, or it takes too long for waiting to be worth it.
    """

    claim: Claim | None = None
    wakes: int = 0
    queued: bool = False
    due: bool = False
    left: bool = False
    waiting: float | None = None


def joined(evaluations: Sequence[Evaluation]) -> list[Joined]:
    """Return the results of a generation in the form that the state machine needs."""
    return [Joined(e.objective, e.reason, e.message, e.reason is not None and bool(e.responses)) for e in evaluations]


@dataclass(frozen=True, slots=True)
class Sizing:
    """How many evaluations a worker takes at once.

    Cheap ones go in as many chunks as there are workers, those that cost a little more in chunks that get smaller
    towards the end of the generation (two thirds of an even share of what is left, so that no worker ends late, and at
    most ``chunk_seconds``), expensive or unknown ones singly, and generations that cost less than handing them out stay
    whole in one worker.
    """

    cheap_seconds: float
    local_batch_seconds: float
    single_seconds: float
    chunk_seconds: float

    def local_batch(self, typical_seconds: float | None, particles: int) -> bool:
        """Whether whole generations stay in one worker."""
        if typical_seconds is None:
            return False
        longest = self.local_batch_seconds * (LONG_BATCH if typical_seconds < HANDING_OUT_SECONDS else 1.0)
        return typical_seconds * particles < longest

    def chunk(self, typical_seconds: float | None, particles: int, left: int, live_workers: int) -> int:
        """Return the number of evaluations that go out together, when ``left`` of all particles are not started yet."""
        workers = max(live_workers, 1)
        if typical_seconds is None or typical_seconds > self.single_seconds:
            return 1
        if typical_seconds > self.cheap_seconds:
            longest = math.ceil(self.chunk_seconds / typical_seconds)
            return max(1, min(-(-2 * left // (3 * workers)), longest))
        return particles if self.local_batch(typical_seconds, particles) else -(-particles // workers)


def free_slots(connection: Connection, settings: Settings, model: ForwardModelSpec, job_id: str) -> int:
    """Return the number of live workers without an evaluation of another job, within the slots of the model.

    A worker knows the limits of its own group; others on other machines are taken to be like it.
    """
    workers = count_live(connection, settings.lease_seconds) - workers_elsewhere(connection, job_id)
    machines = max(1, count_machines(connection, settings.lease_seconds))
    if model.kind in settings.slots:
        workers = min(workers, settings.slots[model.kind] * machines)
    return max(1, model.at_once(workers, machines))
