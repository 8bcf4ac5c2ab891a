"""What the stored evaluations of a job tell; parameter values are natural, numbers that are not known are None."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

from geoswarm.records.record import Number, described, record
from geoswarm.records.remedy import Proposal, Remedy

__all__ = [
    "Basins",
    "Combination",
    "CorrelationPair",
    "CorrelationTable",
    "Dependence",
    "Evidence",
    "FitKind",
    "FitVerdict",
    "KnownOrEstimated",
    "LackOfFit",
    "Linearisation",
    "Misfit",
    "OptimumParameter",
    "OtherFit",
    "ParameterWithoutTests",
    "Place",
    "Projection",
    "Residuals",
    "ReweightAnswer",
    "SampleCounts",
    "SeriesShare",
    "StatisticsAnswer",
    "Threshold",
    "Verdict",
    "WeightShare",
    "WithoutTests",
]

FitKind: TypeAlias = Literal["describes", "gross_error", "doubtful", "lack_of_fit", "error_not_met", "untested"]
"""What is said of a fit: whether the model describes the data."""


VerdictKind: TypeAlias = Literal[
    "identified", "bounded_on_one_side", "in_combination", "not_identified", "undecided", "lack_of_fit", "error_not_met"
]
VerdictCode: TypeAlias = Literal[
    "width", "several", "no_influence", "tied", "correlated", "no_interval", "not_minimum", "nonlinear", "no_error",
    "unexplored", "untried", "misfit", "swarm", "thin", "few_good_fits"
]  # fmt: skip
"""What is said of a parameter, and why."""


@record(closed=True)
class SampleCounts:
    """Evaluations on which the statistics are based."""

    total: int
    failed: int
    left_out: int = described("successful evaluations of a long history that were not read")
    source: str = described("kind of the method they come from; follow_up: of any; mixed: of several")
    kept: int = described("good fits: at or below the threshold")
    kept_unbiased: int = described("those of a Monte Carlo sampling")


@record(closed=True)
class Threshold:
    """Objective up to which a fit counts as good."""

    value: float
    origin: Literal["given", "statistics", "samples"]
    explanation: str
    wanted: Number = described("if it was raised to keep enough samples: its statistical value")


@record(closed=True)
class CorrelationPair:
    """Correlation of two parameters among the good fits."""

    first: str
    second: str
    coefficient: Number
    lower: Number
    upper: Number
    count: int
    interval: Literal["fisher", "bootstrap", "none"]
    correlated: bool = described("|r| at or above 0.5, and the interval excludes 0")


@record(closed=True)
class CorrelationTable:
    """Correlations of all pairs by one method."""

    method: Literal["pearson", "spearman"]
    coordinates: Literal["linear", "search"]
    level: float
    biased: bool = described("over particles of a swarm")
    pairs: list[CorrelationPair]


@record(closed=True)
class Projection:
    """The objective over one parameter."""

    parameter: str
    scale: Literal["linear", "log"]
    edges: list[float]
    envelope: list[Number] = described("lowest objective in each bin; null where it is empty")
    counts: list[int]
    best: float = described("value at the minimum where it is known, of the best evaluation otherwise")
    lowest: Number
    highest: Number
    lower: Number = described("5 % quantile of the good fits")
    upper: Number = described("95 % quantile of the good fits")
    width_ratio: Number = described("width of the good fits over that of all samples")
    unimodal: bool | None
    open_below: bool | None
    open_above: bool | None
    beyond_below: int
    beyond_above: int
    kept: int


@record(closed=True)
class Evidence:
    """Basis of a verdict."""

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
    hidden: Number = described("share of the searched space in which a basin like this one could still hide, 0 to 1")
    partner_intervals: list[tuple[float, float]] = described("95 % intervals of the correlations with partners")
    elsewhere: list[float] = described("values in other basins: those that the data allow too, or that runs point to")
    exchangeable: list[str] = described("parameters with which it may be exchanged for all that is known")
    exact: bool = described("all readings are met to rounding, and no error is stated")
    spare: int | None = described("readings beyond the parameters, from which the error was estimated")
    tests: int = described("tests that count as one each, as the model does not describe them; 0 otherwise")


@record(closed=True)
class Verdict:
    """What the data say about one parameter."""

    parameter: str
    kind: VerdictKind
    words: str = described('the kind in words, as tables show it; with "within one basin" where the runs are sparse')
    code: VerdictCode = described("why; width: of the good fits or the interval, with the bounds that it reaches")
    reason: str = described("why, in one clause; with words, the verdict in one line")
    sentence: str = described("all of it")
    evidence: Evidence
    proposals: list[Proposal]
    what_to_do: list[Remedy]


@record(closed=True)
class Misfit:
    """A series, or a stage of it, that the model does not describe; numbers in the units of the data."""

    series: str
    stage: int | None
    reason: Literal["pattern", "repeats", "stated_error", "missed", "gross_error"]
    probability: Number = described("probability of such a deviation by chance if the model is right")
    deviation: Number = described("root mean square of the residuals; of one reading, its distance from the others")
    largest: Number = described("largest residual, calculated - measured")
    x: Number = described("where it is")
    ratio: Number = described("residuals over the stated error; of one reading, its distance in standard deviations")
    unit: str
    x_unit: str
    reading: int | None = described("number of the one reading, from 1; null for a series")
    slip: Number = described("power of ten, or -1, by which the reading would fit; null where nothing of the kind does")


@record(closed=True)
class Closeness:
    """How close one quantity comes to its readings, over all series of it, in the unit of the data."""

    quantity: str
    series: int = described("number of series")
    largest: Number = described("the largest residual in size")
    deviation: Number = described("root mean square of the residuals, each series counting alike")
    peak: Number = described("largest relative difference of a peak; null where the largest value is not a strength")
    unit: str


@record(closed=True)
class FitVerdict:
    """Whether the model describes the data; it comes before all other verdicts."""

    kind: FitKind
    words: str = described("the kind in a clause")
    headline: str = described("heading above all results; empty where none is needed")
    sentence: str
    misfits: list[Misfit]
    remedies: list[str] = described("the texts of what_to_do")
    what_to_do: list[Remedy]
    level: float = described("probability of doubting a right model")
    closeness: list[Closeness] = described("how close each quantity comes")
    tests: int = described("tests that count as one piece of information each in the intervals, which hold then; or 0")


@record(closed=True)
class OptimumParameter:
    """One parameter at the optimum."""

    value: float
    standard_error: Number
    interval: tuple[float, float] | None
    interval_basis: (
        Literal["linearised", "correlated", "uneven", "possible", "stated", "tests", "moved", "profile"] | None
    ) = described(
        "basis of the interval; correlated, uneven: wider for such residuals; possible: for a correlation that so "
        "few readings cannot exclude; stated: for the problem's noise; tests: for tests that differ; moved: by one "
        "run at each end"
    )
    widening: Number = described("how many times wider correlated or uneven noise makes the interval by linearisation")
    bending: Number = described("relative distance of an end by likelihood from the linearised one; null: not checked")
    needs_profile: bool = described("the model is too nonlinear for the interval: only a profile can give it")
    influence: float
    why_no_interval: str | None


@record(closed=True)
class KnownOrEstimated:
    """Standard deviation of a reading by series, base units."""

    origin: Literal["known", "estimated"]
    deviations: dict[str, float]


@record(closed=True)
class Combination:
    """A direction at the optimum."""

    singular_value: float
    components: dict[str, float]
    open: bool = described("the data leave it open")


@record(closed=True)
class Dependence:
    """A series whose noise is or may be correlated, or is of uneven size; intervals allow for it."""

    series: str
    kind: Literal["correlated", "uneven", "possible", "stated"]
    rho: float = described("correlation of neighbouring readings")
    readings: int
    effective: float = described("number of independent readings with the same information")
    by_x: bool = described("the correlation falls with the distance in x, and not with the readings between")
    sentence: str


@record(closed=True)
class ParameterWithoutTests:
    """One parameter without each of the tests."""

    value: float | None = described("with all tests", default=None)
    values: dict[str, float | None] = described("by the test left out; null where the others do not determine it")
    interval: tuple[float, float] | None = described("95 %, each test as one piece of information (jackknife)")
    pulls: str | None = described("the test without which it moves farthest")


@record(closed=True)
class WithoutTests:
    """Leaving out one test at a time."""

    tests: list[str]
    parameters: dict[str, ParameterWithoutTests]


@record(closed=True)
class Linearisation:
    """Standard errors and intervals at the optimum."""

    parameters: dict[str, OptimumParameter]
    level: float
    degrees_of_freedom: int
    noise: KnownOrEstimated | None
    combinations: list[Combination]
    correlation: list[list[Number]]
    unclear: list[str] = described("parameters whose sensitivities are too uncertain for a statement")
    derivative_error: Number
    distance: list[Number] = described("to the nearest minimum inside the bounds, in standard errors")
    at_optimum: bool = described("false also where no distance is known")
    held: dict[str, Literal["lower", "upper"]] = described(
        "parameters at a bound beyond which the data pull: the minimum lies on it"
    )
    fit: FitVerdict = described("intervals hold only where the model describes the data")
    without_tests: WithoutTests | None = described("the values without each test, by linearisation or as fitted")
    dependence: list[Dependence]


@record(closed=True)
class LackOfFit:
    """Repeats against the scatter around the model."""

    noise: float
    repeats: int
    ratio: Number
    probability: Number


@record(closed=True)
class Residuals:
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
    loss_weights: list[float] | None = described(
        "weights that a robust loss gives the readings, 0 to 1; null without a loss"
    )
    outliers: int | None = described("number of readings with such a weight below a third")
    warnings: list[str]


@record(closed=True)
class SeriesShare:
    """Weight of a series and its share in the objective."""

    series: str
    test: str = described("the part of a combined problem; empty where there is only one test")
    weight: float
    misfit: Number
    share: Number
    root_mean_square: Number = described("of the residuals, weighted as the points are, in unit")
    unit: str = described("of the measured values")


@record(closed=True)
class WeightShare:
    """What the weight of a series makes of it, before the search."""

    series: str
    test: str = described("the part of a combined problem; empty where there is only one test")
    weight: float
    share: float = described("of the objective, if every series is missed by the same part of its range")
    readings: float | None = described(
        "that the scheme counts, of by_error independent ones; null where it counts none"
    )


@record(closed=True)
class OtherFit:
    """A set of parameters that the data do not exclude, outside the region of the optimum."""

    parameters: dict[str, float]
    objective: float
    differs: list[str] = described("parameters that lie outside that region")


@record(closed=True)
class Basins:
    """What is known of the space beyond the basin of the optimum."""

    others: list[OtherFit]
    exchanges: list[tuple[str, str]] = described("pairs of parameters that can be exchanged")
    hidden: Number = described(
        "share of the searched space in which a basin like that of the optimum could hide, 0 to 1"
    )
    unfinished: list[OtherFit] = described("runs that point to another basin that was not explored")
    untried: list[tuple[str, str]] = described(
        "pairs of parameters that may be exchangeable: swapped values were not run"
    )
    sentence: str = described("restriction of every interval at the optimum, with that share")
    what_to_do: list[Remedy] = described("explore, where another basin is likely or could hide")


@record(closed=True)
class StatisticsAnswer:
    """Results from the stored evaluations."""

    samples: SampleCounts
    fit: FitVerdict
    threshold: Threshold
    correlations: list[CorrelationTable]
    projections: list[Projection]
    verdicts: list[Verdict]
    linearisation: Linearisation | None
    basins: Basins
    residuals_at_optimum: bool = described("of a polished optimum, not of the best evaluation")
    residuals: list[Residuals]
    weights: list[SeriesShare]
    warnings: list[str] = described("what to be careful about, beyond what fit says")


@record(closed=True)
class Place:
    """An evaluation and its objective under the new weights."""

    generation: int
    particle: int
    objective: float
    parameters: dict[str, float]


@record(closed=True)
class ReweightAnswer:
    """Stored evaluations under other weights."""

    weights: list[SeriesShare]
    best: Place
    best_before: Place
    moved: bool = described("another evaluation is the best now")
    warnings: list[str]
    problem: dict[str, Any] = described("the problem with the new weights, ready to be submitted")
