"""How sure the parameters of a job are: what follow-ups have found, a sample of the posterior, the response surface."""

from __future__ import annotations

from typing import Literal

from geoswarm.records.record import Number, described, record
from geoswarm.records.states import JobState
from geoswarm.records.statistics import Closeness, FitVerdict, Linearisation, WithoutTests

__all__ = [
    "CandidateWorth",
    "Design",
    "FollowUp",
    "GlobalIndex",
    "GlobalSensitivity",
    "PosteriorAnswer",
    "PredictedBasin",
    "PredictedSeries",
    "Prediction",
    "PredictionBasin",
    "Profile",
    "SurfaceAnswer",
    "SurfaceContours",
    "SurfaceRuns",
    "SurfaceSlice",
    "UncertaintyAnswer",
]


@record(closed=True)
class Profile:
    """Profile objective of one parameter; an end is null where the interval is open, or not reached yet."""

    parameter: str
    values: list[float]
    objectives: list[float]
    others: list[list[float]] = described("all free parameters at each value")
    limit: float = described("objective at the ends of the interval")
    lower: Number
    upper: Number
    better: Number = described("lowest objective found, when the search had not found the best fit")
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
    dropped: int = described("blocks with failed evaluations")


@record(closed=True)
class PredictedBasin:
    """One basin in one series; null where its run failed, or it has too few."""

    optimum: list[float] | None = described("curve at its optimum")
    lower: list[float] | None
    upper: list[float] | None


@record(closed=True)
class PredictedSeries:
    """Median and band of one series, in the units that its points were given in."""

    series: str
    x_quantity: str
    y_quantity: str
    x_unit: str
    y_unit: str
    x: list[float]
    median: list[float]
    lower: list[float] = described("ends of the band, at each x")
    upper: list[float]
    reading_lower: list[float] | None = described("ends for a future reading; null where its error is not known")
    reading_upper: list[float] | None
    measured: list[float] | None
    basins: list[PredictedBasin]
    inside: int | None = described("measured points in the band, that of readings where it is known")
    straight: Number = described("share of the variation that a plane over the parameters explains, the least over x")
    end_error: Number = described("how far the ends differ between two halves of the draws, parts of the band's width")
    closeness: Closeness | None = described("how close the curve at the best optimum comes to the measured points")


@record(closed=True)
class PredictionBasin:
    """One set of parameters that the data allow."""

    share: float
    parameters: dict[str, float]
    draws: int


@record(closed=True)
class Prediction:
    """Effect of the uncertainty of the identified parameters on another forward model."""

    name: str
    level: float
    basis: Literal["covariance", "posterior"] = described("where the draws come from")
    runs: int
    failed: int
    basins: list[PredictionBasin]
    undecided: list[str] = described("parameters that the data do not limit: drawn over their searched range")
    series: list[PredictedSeries]
    alarm: str | None = described("why the band is unreliable")
    remarks: list[str] = described("what the band contains, and its caveats")


@record(closed=True)
class CandidateWorth:
    """Worth of a candidate test: expected reductions of widths, as parts of these."""

    name: str
    cost: Number
    readings: int
    parameters: dict[str, float] = described("of the interval of each parameter")
    intervals: dict[str, tuple[float, float] | None] = described("expected 95 % intervals; null beyond the bounds")
    widths: float = described("of all intervals, the geometric mean")
    volume: float = described("of the common region, its d-th root")
    prediction: Number = described("of the predicted band")
    distinguishes: Number = described("probability that it distinguishes the nearest two basins; null with one")
    per_cost: Number = described("decrease of log width by the criterion for each unit of cost")


@record(closed=True)
class Design:
    """Candidate tests, the most informative first."""

    name: str
    criterion: Literal["widths", "volume", "prediction"]
    predicted: str | None
    candidates: list[CandidateWorth]
    basins: int
    centres: int = described("sets of parameters over which the worth is averaged")
    failed: int
    alarm: str | None
    remarks: list[str]


@record(closed=True)
class FollowUp:
    """A job that evaluates more about another one."""

    id: str
    kind: Literal["sensitivity", "profile", "jackknife", "explore", "predict", "design", "sobol", "morris"]
    state: JobState
    evaluations: int


@record(closed=True)
class UncertaintyAnswer:
    """What the follow-ups of a job have found, or a follow-up itself."""

    fit: FitVerdict | None = described("null where nothing was evaluated at an optimum")
    linearisation: Linearisation | None
    objective: Number = described("objective at the optimum of the linearisation")
    start_objective: Number = described("objective where the descent to it started")
    profiles: list[Profile]
    global_sensitivities: list[GlobalSensitivity]
    explored: int = described("successful runs that looked for further basins; /statistics says what they found")
    predictions: list[Prediction]
    designs: list[Design]
    jackknife: WithoutTests | None = described("the values fitted without each test, by further runs")
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
    surface_error: float = described("error of the log-likelihood by the hold-out check")
    trusted: bool
    warnings: list[str]


@record(closed=True)
class SurfaceSlice:
    """Objective over one parameter, the others as in the best run; null where the surface does not know it."""

    parameter: str
    values: list[float]
    objectives: list[Number]


@record(closed=True)
class SurfaceContours:
    """Objective over two parameters, the others as in the best run; null where the surface does not know it."""

    x: str
    y: str
    x_values: list[float]
    y_values: list[float]
    objectives: list[list[Number]] = described("a row for each of y_values")


@record(closed=True)
class SurfaceRuns:
    """Stored runs that the surface is fitted to, and failed ones."""

    parameters: dict[str, list[float]]
    objectives: list[Number] = described("null of a failed run")


@record(closed=True)
class SurfaceAnswer:
    """Slices and contours of the response surface of the stored evaluations, through the best of them."""

    evaluations: int = described("that the surface is fitted to")
    error: Number = described(
        "root mean square error of the objective of runs left out of the fit, over the objective (over limit where it "
        "is smaller)"
    )
    checked: int = described("number of those: runs that span what is shown")
    trusted: bool = described("whether that error is small enough: otherwise the surface is said to know nothing")
    best: dict[str, float]
    objective: float = described("of the best run")
    limit: float = described("objective up to which the data cannot tell a fit from the best one at 95 %")
    importance: dict[str, float] | None = described(
        "share of each parameter in the variation of the logarithm of the objective over what is shown; null where too "
        "little of it is known"
    )
    slices: list[SurfaceSlice]
    contours: SurfaceContours | None = described("null with one free parameter")
    runs: SurfaceRuns
