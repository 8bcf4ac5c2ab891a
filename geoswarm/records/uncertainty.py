"""How sure the parameters of a job are: what follow-ups have found, and a sample of the posterior."""

from __future__ import annotations

from typing import Literal

from geoswarm.records.record import Number, record, told
from geoswarm.records.states import JobState
from geoswarm.records.statistics import FitVerdict, Linearisation

__all__ = [
    "FollowUp",
    "GlobalIndex",
    "GlobalSensitivity",
    "PosteriorAnswer",
    "Profile",
    "UncertaintyAnswer",
]


@record(closed=True)
class Profile:
    """Profile objective of one parameter; an end is null where the interval is open, or not reached yet."""

    parameter: str
    values: list[float]
    objectives: list[float]
    others: list[list[float]] = told("all free parameters at each value")
    limit: float = told("objective at the ends of the interval")
    lower: Number
    upper: Number
    better: Number = told("lowest objective found, when the search had not found the best fit")
    complete: bool


@record(closed=True)
class GlobalIndex:
    """Index of one parameter; Sobol: first order and total; Morris: mean absolute effect and its spread."""

    parameter: str
    main: Number
    main_half_width: Number
    total: Number
    total_half_width: Number


@record(closed=True)
class GlobalSensitivity:
    """Indices of all parameters for one output."""

    kind: Literal["sobol", "morris"]
    output: str
    indices: list[GlobalIndex]
    blocks: int
    dropped: int = told("blocks with failed evaluations")


@record(closed=True)
class FollowUp:
    """A job that evaluates more about another one."""

    id: str
    kind: Literal["sensitivity", "profile", "sobol", "morris"]
    state: JobState
    evaluations: int


@record(closed=True)
class UncertaintyAnswer:
    """What the follow-ups of a job have found, or a follow-up itself."""

    fit: FitVerdict | None = told("null where nothing was evaluated at an optimum")
    linearisation: Linearisation | None
    objective: Number = told("objective at the optimum of the linearisation")
    start_objective: Number = told("objective where the descent to it began")
    profiles: list[Profile]
    global_sensitivities: list[GlobalSensitivity]
    notes: list[str]
    follow_ups: list[FollowUp]


@record(closed=True)
class PosteriorAnswer:
    """Posterior sample through the response surface of the stored evaluations."""

    level: float
    intervals: dict[str, tuple[float, float] | None]
    medians: dict[str, float]
    correlation: list[list[Number]]
    samples: int
    effective: int
    acceptance: float
    autocorrelation: Number
    surface_error: float = told("error of the log-likelihood by the hold-out check")
    trusted: bool
    warnings: list[str]
