"""What the engine shows of its jobs: frozen records, times as aware UTC datetimes."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

__all__ = ["AttemptView", "EventView", "GenerationView", "JobView", "WorkerView"]


@dataclass(frozen=True, slots=True)
class JobView:
    """One job.

    Parameters
    ----------
    state
        queued, running, paused, finished, failed or cancelled.
    objective, parameters
        Best f so far and the values of all its parameters; None while no evaluation has succeeded.
    evaluations, generations, failed_evaluations
        Counted over finished generations.
    seconds
        Running time [s]: not queued, not paused, no engine down; None before the start.
    max_evaluations
        Number of evaluations after which the job ends at the latest, None when nothing limits it.
    priority
        Jobs of a higher one get more of the workers: among those of one owner, an administrator's among all.
    retrying
        Its failed evaluations are run again.
    owner
        Whose key submitted it; None: nobody's.
    last_event
        Id of its newest event, 0 without one: who has read the job follows the events after it.
    trend
        Lowest objective so far at evenly spaced generations, where a listing was asked for it.
    versions
        Of geoswarm, Python and what calculates, when it was begun; None: not begun, or begun by an older geoswarm.
    warnings
        One for each other set of versions that took part, and what a job waits for beside its turn.
    """

    id: str
    name: str
    state: str
    forward_model: str
    method: str
    stop_reasons: list[str]
    objective: float | None
    parameters: dict[str, float] | None
    evaluations: int
    generations: int
    failed_evaluations: int
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None
    seconds: float | None
    error: str | None
    seed: int
    free_parameters: list[str]
    max_evaluations: int | None
    priority: int = 0
    retrying: bool = False
    owner: str | None = None
    last_event: int = 0
    trend: list[float | None] | None = None
    versions: dict[str, str] | None = None
    warnings: list[str] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class AttemptView:
    """One try at an evaluation.

    Parameters
    ----------
    number
        Counted from 1 as they were begun.
    outcome
        running, finished, the reason of its failure, late (another had counted), overdue (given to another as well),
        superseded (the one it was given to as well, after the first had finished),
        or stopped (killed because its job was paused, or its worker was to end).
    counted
        Whether it gave the evaluation's result.
    message, log
        What happened, and the end of what the forward model wrote.
    """

    number: int
    worker: str | None
    outcome: str
    counted: bool
    message: str | None
    log: str | None
    started_at: datetime | None
    finished_at: datetime | None


@dataclass(frozen=True, slots=True)
class GenerationView:
    """One finished generation; ``evaluations`` and ``failed`` are totals so far, ``objective`` and ``parameters`` the
    best so far; ``diversity``, see :mod:`geoswarm.solver.search.diversity`, where it was asked for."""

    number: int
    evaluations: int
    failed: int
    best_objective: float | None
    objective: float | None
    parameters: dict[str, float] | None
    created_at: datetime
    finished_at: datetime
    diversity: float | None = None


@dataclass(frozen=True, slots=True)
class EventView:
    """Something that happened to a job; ``id`` grows with time, so that a reader can go on after the last one seen."""

    id: int
    kind: str
    data: dict[str, Any]
    created_at: datetime


@dataclass(frozen=True, slots=True)
class WorkerView:
    """One worker process; ``state`` is idle, busy or lost, ``engine`` embedded or celery.

    Parameters
    ----------
    job, generation, evaluations, busy_since
        What it runs: job, generation, number of evaluations that it has claimed, and since when; None: nothing.
        Of a job that the viewer may not see, job and generation are None.
    """

    id: str
    host: str
    pid: int
    engine: str
    state: str
    job: str | None
    started_at: datetime
    seen_at: datetime
    generation: int | None = None
    evaluations: int | None = None
    busy_since: datetime | None = None
