"""Models of what the statistics answer; parameter values are natural, numbers that are not known are null."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from geoswarm.api.schemas import Number
from geoswarm.records.states import JobState

__all__ = [
    "GlobalRequest",
    "PosteriorAnswer",
    "ProfileRequest",
    "ReweightAnswer",
    "SensitivityRequest",
    "StatisticsAnswer",
    "UncertaintyAnswer",
]


class Answer(BaseModel):
    """What is answered has these fields and no others."""

    model_config = ConfigDict(extra="forbid")


class SampleCounts(Answer):
    """Evaluations that the statistics rest on."""

    total: int
    failed: int
    left_out: int = Field(description="successful ones of a long history that were not read")
    source: str = Field(description="kind of the method they come from; follow_up: of any; mixed: of several")
    kept: int = Field(description="good fits: at or below the threshold")
    kept_unbiased: int = Field(description="those of a Monte Carlo sampling")


class Threshold(Answer):
    """Objective up to which a fit is good."""

    value: float
    origin: Literal["given", "statistics", "samples"]
    explanation: str
    wanted: Number = Field(description="where it was raised to keep enough samples: what statistics would have")


class CorrelationPair(Answer):
    """Correlation of two parameters among the good fits."""

    first: str
    second: str
    coefficient: Number
    lower: Number
    upper: Number
    count: int
    interval: Literal["fisher", "bootstrap", "none"]
    correlated: bool = Field(description="|r| at or above 0.5, and the interval excludes 0")


class CorrelationTable(Answer):
    """Correlations of all pairs by one method."""

    method: Literal["pearson", "spearman"]
    coordinates: Literal["linear", "search"]
    level: float
    biased: bool = Field(description="over particles of a swarm")
    pairs: list[CorrelationPair]


class Projection(Answer):
    """The objective over one parameter."""

    parameter: str
    scale: Literal["linear", "log"]
    edges: list[float]
    envelope: list[Number] = Field(description="lowest objective in each bin; null where it is empty")
    counts: list[int]
    best: float
    lowest: Number
    highest: Number
    lower: Number = Field(description="5 % quantile of the good fits")
    upper: Number = Field(description="95 % quantile of the good fits")
    width_ratio: Number = Field(description="width of the good fits over that of all samples")
    unimodal: bool | None
    open_below: bool | None
    open_above: bool | None
    beyond_below: int
    beyond_above: int
    kept: int


class Evidence(Answer):
    """What a verdict rests on."""

    basis: Literal["sampling", "linearisation", "none"]
    good_fits: int
    range_lower: Number
    range_upper: Number
    width_ratio: Number
    unimodal: bool | None
    open_below: bool | None
    open_above: bool | None
    partners: list[tuple[str, Number]]
    influence: Number
    sampling_bias: bool


class FittedLine(Answer):
    """Line through the good fits, by which one parameter may be linked to another."""

    parameter: str
    partner: str
    scale: Literal["linear", "log"]
    intercept: float
    slope: float
    lower: float
    upper: float
    residual: Number
    correlation: float
    count: int
    expression: str


class Proposal(Answer):
    """Something to do about a parameter."""

    kind: Literal["fix", "link", "widen", "add_test"]
    parameter: str
    sentence: str
    changes: dict[str, Any] = Field(description="parts of the problem to replace")
    line: FittedLine | None


class Verdict(Answer):
    """What the data say about one parameter."""

    parameter: str
    kind: Literal[
        "identified",
        "bounded_on_one_side",
        "in_combination",
        "not_identified",
        "undecided",
        "lack_of_fit",
        "error_not_met",
    ]
    sentence: str
    evidence: Evidence
    proposals: list[Proposal]


class Misfit(Answer):
    """A series, or a stage of it, that the model does not describe; numbers in the units of the data."""

    series: str
    stage: int | None
    reason: Literal["pattern", "repeats", "stated_error"]
    probability: Number = Field(description="of as much by chance, were the model right")
    deviation: Number = Field(description="root mean square of the residuals")
    largest: Number = Field(description="largest smoothed residual, calculated - measured")
    x: Number = Field(description="where it is")
    ratio: Number = Field(description="residuals over the stated error")
    unit: str
    x_unit: str


class FitVerdict(Answer):
    """Whether the model describes the data: it stands before all other verdicts."""

    kind: Literal["describes", "lack_of_fit", "error_not_met", "untested"]
    sentence: str
    misfits: list[Misfit]
    remedies: list[str]
    level: float = Field(description="probability of calling a right model wrong")


class OptimumParameter(Answer):
    """One parameter at the optimum."""

    value: float
    standard_error: Number
    interval: tuple[float, float] | None
    interval_basis: Literal["linearised", "correlated", "uneven", "profile"] | None = Field(
        description="what the interval rests on; the two in the middle allow for correlated or uneven residuals"
    )
    bending: Number = Field(
        description="how far an end by likelihood lies from the linearised one, relatively; null where nobody looked"
    )
    bent: bool = Field(description="the model bends within the interval, and no profile has been calculated")
    influence: float
    why_no_interval: str | None


class KnownOrEstimated(Answer):
    """Standard deviation of a reading by series, base units."""

    origin: Literal["known", "estimated"]
    deviations: dict[str, float]


class Combination(Answer):
    """A direction at the optimum."""

    singular_value: float
    components: dict[str, float]
    open: bool = Field(description="the data leave it open")


class Dependence(Answer):
    """A series whose residuals are correlated, or of uneven size; intervals allow for it."""

    series: str
    kind: Literal["correlated", "uneven"]
    rho: float = Field(description="correlation of neighbouring readings")
    readings: int
    effective: float = Field(description="how many independent ones they are worth")
    sentence: str


class Linearisation(Answer):
    """Standard errors and intervals at the optimum."""

    parameters: dict[str, OptimumParameter]
    level: float
    degrees_of_freedom: int
    noise: KnownOrEstimated | None
    combinations: list[Combination]
    correlation: list[list[Number]]
    unclear: list[str] = Field(description="parameters whose sensitivities are too uncertain to say anything")
    derivative_error: Number
    distance: list[Number] = Field(description="to the nearest minimum inside the bounds, in standard errors")
    at_optimum: bool = Field(description="false also where no distance is known")
    held: dict[str, Literal["lower", "upper"]] = Field(
        description="parameters at a bound beyond which the data pull: the minimum lies on it"
    )
    fit: FitVerdict = Field(description="intervals hold only where the model describes the data")
    dependence: list[Dependence]


class LackOfFit(Answer):
    """Repeats against the scatter around the model."""

    noise: float
    repeats: int
    ratio: Number
    probability: Number


class Residuals(Answer):
    """Residuals of one series at the optimum or the best evaluation, base units."""

    series: str
    x: list[float]
    residuals: list[float]
    deviation: Number
    bias: Number
    runs: int | None
    expected_runs: Number
    runs_probability: Number
    durbin_watson: Number
    durbin_watson_probability: Number
    lack_of_fit: LackOfFit | None
    warnings: list[str]


class SeriesShare(Answer):
    """Weight of a series and its share in the objective."""

    series: str
    weight: float
    misfit: Number
    share: Number


class StatisticsAnswer(Answer):
    """What the stored evaluations tell."""

    samples: SampleCounts
    fit: FitVerdict
    threshold: Threshold
    correlations: list[CorrelationTable]
    projections: list[Projection]
    verdicts: list[Verdict]
    linearisation: Linearisation | None
    residuals_at_optimum: bool = Field(description="of a polished optimum, not of the best evaluation")
    residuals: list[Residuals]
    weights: list[SeriesShare]
    warnings: list[str]


class Place(Answer):
    """An evaluation and its objective under the new weights."""

    generation: int
    particle: int
    objective: float
    parameters: dict[str, float]


class ReweightAnswer(Answer):
    """Stored evaluations under other weights."""

    weights: list[SeriesShare]
    best: Place
    best_before: Place
    moved: bool = Field(description="another evaluation is the best now")
    warnings: list[str]
    problem: dict[str, Any] = Field(description="the problem with the new weights, ready to be submitted")


class FigureList(Answer):
    """Figures that can be drawn."""

    items: list[str]


class Profile(Answer):
    """Profile objective of one parameter; an end is null where the interval is open, or not reached yet."""

    parameter: str
    values: list[float]
    objectives: list[float]
    others: list[list[float]] = Field(description="all free parameters at each value")
    limit: float = Field(description="objective at the ends of the interval")
    lower: Number
    upper: Number
    better: Number = Field(description="lowest objective found, when the search had not found the best fit")
    complete: bool


class GlobalIndex(Answer):
    """Index of one parameter; Sobol: first order and total; Morris: mean absolute effect and its spread."""

    parameter: str
    main: Number
    main_half_width: Number
    total: Number
    total_half_width: Number


class GlobalSensitivity(Answer):
    """Indices of all parameters for one output."""

    kind: Literal["sobol", "morris"]
    output: str
    indices: list[GlobalIndex]
    blocks: int
    dropped: int = Field(description="blocks with failed evaluations")


class FollowUp(Answer):
    """A job that evaluates more about another one."""

    id: str
    kind: Literal["sensitivity", "profile", "sobol", "morris"]
    state: JobState
    evaluations: int


class UncertaintyAnswer(Answer):
    """What the follow-ups of a job have found, or a follow-up itself."""

    fit: FitVerdict | None = Field(description="null where nothing was evaluated at an optimum")
    linearisation: Linearisation | None
    objective: Number = Field(description="objective at the optimum of the linearisation")
    start_objective: Number = Field(description="objective where the descent to it began")
    profiles: list[Profile]
    global_sensitivities: list[GlobalSensitivity]
    notes: list[str]
    follow_ups: list[FollowUp]


class PosteriorAnswer(Answer):
    """Posterior sample through the response surface of the stored evaluations."""

    level: float
    intervals: dict[str, tuple[float, float] | None]
    medians: dict[str, float]
    correlation: list[list[Number]]
    samples: int
    effective: int
    acceptance: float
    autocorrelation: Number
    surface_error: float = Field(description="error of the log-likelihood by the hold-out check")
    trusted: bool
    warnings: list[str]


class _Request(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class SensitivityRequest(_Request):
    """Sensitivities at the optimum of a job."""

    polish: bool = Field(True, description="go to the minimum first; false: one generation at the best evaluation")
    step: float | None = Field(
        None, gt=0, le=0.1, description="largest difference in parts of the range; found for each parameter if absent"
    )
    at: dict[str, float] | None = Field(None, description="another optimum: values of the free parameters")


class ProfileRequest(_Request):
    """Profile objectives around the optimum of a job."""

    parameters: list[str] | None = Field(None, min_length=1, max_length=100, description="all free ones if absent")
    noise: dict[str, float] | float | None = Field(
        None, description="known standard deviation of a reading, base units; that of the problem if absent"
    )


class GlobalRequest(_Request):
    """Global sensitivity over the search range of a job."""

    kind: Literal["sobol", "morris"] = "sobol"
    samples: int | None = Field(
        None, ge=8, le=2**17, description="base points (a power of two; 256) or trajectories (20)"
    )
