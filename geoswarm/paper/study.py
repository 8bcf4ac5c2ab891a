"""What the studies share: a sampling repeated over seeds, a swarm, and the rows of a table published / here."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Samples, Statistics, analyse
from geoswarm.solver.identifiability.stored.correlations import Coordinates
from geoswarm.solver.problem import FixedParameter, FreeParameter, Problem, parse_problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.report.document.build import Report
from geoswarm.solver.report.record import record_of_result
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.words import ends

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "Picture",
    "Row",
    "Sampling",
    "Study",
    "bounds_rows",
    "coordinates_row",
    "correlation_rows",
    "free",
    "identified_rows",
    "laboratory_rows",
    "minimum_rows",
    "row",
    "sample",
    "spread",
]

Tell = Callable[[str], None]

_ROUNDING = 0.005

_COORDINATES: dict[Coordinates, str] = {"linear": "natural values", "search": "search coordinates (logarithms)"}


@dataclass(frozen=True, slots=True)
class Row:
    """One number: published, here, their difference in words, and what to know about it."""

    topic: str
    quantity: str
    published: str
    here: str
    difference: str
    remark: str = ""


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure, what it shows in a sentence, and the numbers behind it as header and rows."""

    figure: Figure
    caption: str
    numbers: tuple[list[str], list[list[object]]]


@dataclass(frozen=True, slots=True)
class Study:
    """A study run again.

    Parameters
    ----------
    key, title
        ``A``, ``B`` or ``C``, and its name.
    remarks
        What a reader must know before the numbers.
    rows
        Numbers beside the published ones.
    choices
        Parameter, verdict of the sampling, and what was done about it.
    reports
        Of the sampling and of the swarm, by the name of their folder.
    pictures
        Further figures by name.
    """

    key: str
    title: str
    remarks: tuple[str, ...]
    rows: tuple[Row, ...]
    choices: tuple[tuple[str, str, str], ...]
    reports: Mapping[str, Report]
    pictures: Mapping[str, Picture] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Sampling:
    """A sampling: that of the first seed with its report, the same for further seeds, and all put together."""

    report: Report
    statistics: Statistics
    each: tuple[Statistics, ...] = field(repr=False)
    together: Statistics

    def correlations(self, first: str, second: str, coordinates: Coordinates = "linear") -> FloatArray:
        """Pearson's r of a pair for each seed, over natural values or search coordinates, shape (k,)."""
        tables = [s.pearson if coordinates == "linear" else s.pearson_search for s in self.each]
        found = [table.get(first, second).coefficient for table in tables]
        return np.array([np.nan if r is None else r for r in found], dtype=np.float64)


def free(document: Mapping[str, Any], bounds: Mapping[str, tuple[float, float, str]], samples: int) -> Problem:
    """Return a problem with these parameters free, sampled at random ``samples`` times."""
    changed = {**document, "parameters": dict(document["parameters"]), "stopping": {}}
    for name, (lower, upper, scale) in bounds.items():
        changed["parameters"][name] = {"lower": lower, "upper": upper, "scale": scale}
    changed["method"] = {"kind": "monte_carlo", "samples": samples, "batch": 50}
    return parse_problem(changed)


def sample(
    problem: Problem, threshold: float | None, seeds: Sequence[int], tell: Tell, *, workers: int = 1
) -> Sampling:
    """Sample a problem once a seed; the first seed gives the report. Without a threshold one is proposed."""
    calibration = Calibration(problem, seeds[0])
    parts: list[Samples] = []
    each: list[Statistics] = []
    first: CalibrationResult | None = None
    for number, seed in enumerate(seeds, start=1):
        tell(f"statistics {number} of {len(seeds)}: {problem.planned_evaluations} forward runs, seed {seed}")
        result = calibrate(problem, workers=workers, seed=seed)
        first = result if first is None else first
        parts.append(Samples.from_result(problem, result))
        each.append(analyse(calibration, parts[-1], threshold=threshold))
    if first is None:
        raise ValueError("seeds is empty; at least one is needed")
    report = Report(problem, record_of_result(problem, first), parts[0], threshold=threshold)
    together = analyse(calibration, Samples.merge(parts), threshold=threshold)
    return Sampling(report, each[0], tuple(each), together)


def row(
    topic: str,
    quantity: str,
    published: float | None,
    here: float | None,
    *,
    unit: str = "",
    remark: str = "",
    digits: int = 3,
) -> Row:
    """Return a row of two numbers with their relative difference."""
    difference = "–"
    if published is not None and here is not None:
        if here == published:
            difference = "0"
        elif published:
            difference = f"{100.0 * (here - published) / abs(published):+.1f} %".replace("-", "−")
        else:
            difference = f"{here - published:+.3g}".replace("-", "−")
    return Row(topic, quantity, _text(published, unit, digits), _text(here, unit, digits), difference, remark)


def identified_rows(
    published: Mapping[str, float], found: Mapping[str, float], units: Mapping[str, str], remark: str
) -> list[Row]:
    """Return a row for each published identified value, with what the swarm has found."""
    return [
        row("swarm", name, value, found.get(name), unit=units.get(name, ""), remark=remark)
        for name, value in published.items()
    ]


def correlation_rows(sampling: Sampling, first: str, second: str, published: float) -> list[Row]:
    """Return the correlation of a pair over natural values and over search coordinates, each over all seeds."""
    rows = []
    for coordinates, words in _COORDINATES.items():
        values = sampling.correlations(first, second, coordinates)
        middle = float(np.nanmedian(values)) if np.isfinite(values).any() else None
        together = sampling.together.pearson if coordinates == "linear" else sampling.together.pearson_search
        pair = together.get(first, second)
        all_seeds = "–" if pair.coefficient is None else f"{pair.coefficient:.2f}"
        remark = f"{spread(values, published)}; all seeds together {all_seeds} ({pair.count} good fits)"
        quantity = f"correlation ({first}, {second}), {words}"
        rows.append(row("statistics", quantity, published, middle, digits=2, remark=remark))
    return rows


def coordinates_row(sampling: Sampling, published: Mapping[tuple[str, str], float]) -> Row:
    """Say in which coordinates the published correlations lie among those of the seeds; the paper does not tell its."""
    lines, both = [], []
    for coordinates, words in _COORDINATES.items():
        outside = [
            f"({first}, {second}) {value:g}"
            for (first, second), value in published.items()
            if not _among(sampling.correlations(first, second, coordinates), value)
        ]
        lines.append(f"{words}: {' and '.join(outside) + ' outside' if outside else 'all inside'}")
        if not outside:
            both.append(words)
    reproduces = " and ".join(both) or "none"
    remark = f"published values against the 5 to 95 % band of the seeds. {'; '.join(lines)}"
    return Row("statistics", "coordinates that reproduce the correlations", "not printed", reproduces, "–", remark)


def _among(values: FloatArray, published: float) -> bool:
    """Whether a published correlation, of two decimals, is within the middle 90 % of the seeds."""
    finite = values[np.isfinite(values)]
    low, high = np.quantile(finite, [0.05, 0.95]) if finite.size else (np.nan, np.nan)
    return bool(low <= published + _ROUNDING and published - _ROUNDING <= high)


def spread(values: FloatArray, published: float) -> str:
    """Return median and middle 90 % of finite values, and whether the published one lies among them."""
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        return "undefined"
    low, middle, high = np.quantile(finite, [0.05, 0.5, 0.95])
    inside = "inside" if _among(values, published) else "OUTSIDE"
    text = f"median {middle:.2f}, 5 to 95 % {low:.2f} to {high:.2f} over {finite.size} seeds"
    return f"{text}, the published value lies {inside}"


def bounds_rows(
    problem: Problem, bounds: Mapping[str, tuple[float, float, str]], units: Mapping[str, str]
) -> list[Row]:
    """Return rows that compare the search range with the published one."""
    rows = []
    for parameter in problem.free:
        lower, upper, scale = bounds[parameter.name]
        unit = units.get(parameter.name, "")
        written = f"search range ({scale})"
        rows.append(row(parameter.name, f"{written}, lower", lower, parameter.lower, unit=unit))
        rows.append(row(parameter.name, f"{written}, upper", upper, parameter.upper, unit=unit))
    return rows


def laboratory_rows(values: Mapping[str, float], problem: Problem, units: Mapping[str, str]) -> list[Row]:
    """Return rows that compare the laboratory set with fixed and initial values of the swarm's problem."""
    rows = []
    for name, value in values.items():
        parameter = problem.parameters[name]
        if isinstance(parameter, FixedParameter):
            here, remark = parameter.value, "fixed for the swarm"
        elif isinstance(parameter, FreeParameter):
            here, remark = parameter.initial or value, "the swarm's first particle"
        else:
            here, remark = value, "forward run; linked for the swarm"
        rows.append(row("laboratory", name, value, here, unit=units.get(name, ""), remark=remark))
    return rows


def minimum_rows(report: Report, published: Mapping[str, float], units: Mapping[str, str]) -> list[Row]:
    """Return rows with the least-squares optimum near the swarm's best and its confidence intervals."""
    found, rows = report.uncertainty.findings.linearisation, []
    if found is None:
        return []
    values = dict(zip(found.names, found.optimum.tolist(), strict=True))
    for name, value in published.items():
        if name not in values:
            continue
        interval = found.interval(name)
        remark = "no interval" if interval is None else f"95 % interval {' to '.join(ends(*interval, plain=True))}"
        if interval is not None:
            remark += ", holds the published value" if interval[0] <= value <= interval[1] else ""
        rows.append(row("swarm, minimum", name, value, values[name], unit=units.get(name, ""), remark=remark))
    objective = report.lowest_objective
    return [
        *rows,
        row("swarm, minimum", "objective", None, objective, unit="m²", remark="noise alone: 2.5e-9 m² a series"),
    ]


def _text(value: float | None, unit: str, digits: int) -> str:
    if value is None:
        return "–"
    return f"{value:.{digits}g} {unit}".strip()
