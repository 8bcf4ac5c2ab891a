"""Observations: measured points of a series, checked against the series and converted to base units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Any

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.errors import Issue, ProblemError, SolverError
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec, SeriesInfo
from geoswarm.solver.problem.issues import number
from geoswarm.solver.problem.observation_section import ObservationSection
from geoswarm.solver.problem.points import Points
from geoswarm.solver.problem.readings.selection import SELECTION, chosen_points
from geoswarm.solver.problem.readings.units import unit_of_axis
from geoswarm.solver.problem.stages import same_x_remedy, stage_times
from geoswarm.solver.residuals import TUNING, CurveScale, Loss, residuals_of
from geoswarm.solver.sentences import Key, Sentence, setting
from geoswarm.solver.units import UnitError, convert, meant_unit, shown_unit
from geoswarm.solver.words import did_you_mean

__all__ = ["Observation", "build_observations", "preparation_issues"]

_SPANNED = 0.5  # part of a test that readings in the right unit span
_ROUNDING = 1e-9  # how far a converted x may lie beyond the end of a series, relative to that end
_LEAST_SCALE = 1e-150  # of a loss: its square is an ordinary number
_OF_RESIDUALS = ("distance", "loss", "loss_scale")
_FEWEST_OF_CURVE = 3
_MOST_ISSUES = 100
_MOST_NAMES = 50  # known series that a message lists


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """Measured points of one series.

    Parameters
    ----------
    series
        Name of the forward model's series.
    x, y, point_weights
        Points and weights w_h, each of shape (m,), read-only, in base units (kN, m, day, degree).
    weight
        Weight w_g of the series in the objective: the one given times that of the problem's weighting scheme.
    x_unit, y_unit
        Units of ``points``; None stands for the base unit.
    points
        The points as the user gave them, those that take no part, too.
    chosen
        Which of ``points`` take part, shape (k,), m of them; None for all.
    selection
        What the user left out and how: x_from, x_to, stage_x_from, leave_out_stages, as far as given.
    given_weight
        Weight as the user gave it.
    error, given_error
        Standard deviation of a point of weight 1 in the base unit, and that of a reading as the user gave it; None when
        it is not known.
    loss
        Robust loss with its scale in the base unit; None for squares.
    along
        Ranges of x and y where residuals are distances from the calculated curve; None for differences of y.
    given_residuals
        distance, loss and loss_scale, as far as the user gave them.
    inputs
        Further quantities at the points, each of shape (m,), that a formula uses.
    gross_x, gross_y
        Points marked as gross errors, each of shape (q,), base units: shown, but in no misfit.
    early_x, early_y
        Points that ``stage_x_from`` alone leaves out, each of shape (r,), base units: primary consolidation, from which
        a classical evaluation takes c_v.
    readings
        Number of readings behind x and y: points may be means of several.
    mean_error
        Standard deviation of a point over that of a reading, from ``points.independent``; 1 where that is not known.
    extent
        The largest less the smallest reading behind y, base unit.
    """

    series: str
    x: FloatArray
    y: FloatArray
    point_weights: FloatArray
    weight: float
    x_unit: str | None
    y_unit: str | None
    points: Points
    given_weight: float
    error: float | None = None
    given_error: float | None = None
    loss: Loss | None = None
    along: CurveScale | None = None
    given_residuals: Mapping[str, Any] = field(default_factory=dict)
    chosen: BoolArray | None = None
    selection: Mapping[str, Any] = field(default_factory=dict)
    inputs: dict[str, FloatArray] = field(default_factory=dict)
    gross_x: FloatArray = field(default_factory=lambda: np.empty(0))
    gross_y: FloatArray = field(default_factory=lambda: np.empty(0))
    early_x: FloatArray = field(default_factory=lambda: np.empty(0))
    early_y: FloatArray = field(default_factory=lambda: np.empty(0))
    readings: float = 0.0
    mean_error: float = 1.0
    extent: float = 0.0

    @property
    def notes(self) -> tuple[str, ...]:
        """Origin and processing of the readings, in sentences."""
        return self.points.notes

    def document(self) -> dict[str, Any]:
        """The observation's section in the canonical form, points inlined."""
        units = {"x_unit": self.x_unit, "y_unit": self.y_unit}
        return {
            "series": self.series,
            "points": self.points.document(),
            **{name: unit for name, unit in units.items() if unit is not None},
            "weight": self.given_weight,
            **({} if self.given_error is None else {"error": self.given_error}),
            **self.given_residuals,
            **self.selection,
            **({"gross_errors": [place + 1 for place in self.points.gross_errors]} if self.points.gross_errors else {}),
            **({"notes": list(self.points.notes)} if self.points.notes else {}),
        }

    def residuals(self, calculated: FloatArray) -> FloatArray:
        """Residuals of values at the points, shape (..., m), base units."""
        return residuals_of(self.x, self.y, calculated, self.along)

    @property
    def left_out(self) -> int:
        """Number of points that are left out, including gross errors."""
        return 0 if self.chosen is None else int((~self.chosen).sum())

    def chosen_points(self) -> Points:
        """The points that are used, in the user's units."""
        if self.chosen is None:
            return self.points
        kept = np.flatnonzero(self.chosen).tolist()
        weight, readings, independent = self.points.weight, self.points.readings, self.points.independent
        if independent is not None:
            independent = max(independent * self.points.share_of(self.chosen), 1.0)
        return replace(
            self.points,
            x=[self.points.x[i] for i in kept],
            y=[self.points.y[i] for i in kept],
            weight=None if weight is None else [weight[i] for i in kept],
            readings=None if readings is None else [readings[i] for i in kept],
            independent=independent,
            range=self.points.range_of(self.chosen),
            inputs={name: [values[i] for i in kept] for name, values in self.points.inputs.items()},
            gross_errors=(),
        )


def build_observations(
    sections: list[tuple[str, ObservationSection, Points]], model: ForwardModel, spec: ForwardModelSpec
) -> tuple[tuple[Observation, ...], list[Issue]]:
    """Check sections (path, section, points) against the model's series and convert them."""
    kind = spec.kind
    infos = {info.name: info for info in model.series}
    observations: list[Observation] = []
    issues: list[Issue] = []
    seen: dict[str, str] = {}
    known = ", ".join(islice(infos, _MOST_NAMES)) + (", ..." if len(infos) > _MOST_NAMES else "")
    for path, section, points in sections:
        if len(issues) > _MOST_ISSUES:
            break
        name = section.series
        if name not in infos:
            hint = spec.remedy_for(name) or did_you_mean(name, infos)
            message = f"unknown series '{name[:60]}' of forward model {kind}{hint}; known: {known}"
            issues.append(Issue(f"{path}.series", message))
            continue
        if name in seen:
            there = Key(seen[name], seen[name], "another measurement")
            combined = setting("forward_model.kind", "combined")
            twice = f"series '{name}' is already given at ", there, "; put all its points there, or model a second "
            issues.append(Issue.about(f"{path}.series", (*twice, "specimen as a further part of ", combined)))
            continue
        seen[name] = path
        observation, found = _build(path, section, points, infos[name], spec)
        issues += found
        if observation is not None:
            observations.append(observation)
    if observations and not issues and not any(observation.weight for observation in observations):
        issues.append(Issue("observations", "all weights are 0; at least one series must have a weight above 0"))
    return tuple(observations), issues


def _build(
    path: str, section: ObservationSection, points: Points, info: SeriesInfo, spec: ForwardModelSpec
) -> tuple[Observation | None, list[Issue]]:
    issues: list[Issue] = []
    converted = []
    units: dict[str, str | None] = {}
    for axis, values, given, base, heading in (
        ("x", points.x, None if points.by_load else section.x_unit, info.x_unit, points.x_heading),
        ("y", points.y, section.y_unit, info.y_unit, points.y_heading),
    ):
        unit, wrong = unit_of_axis(axis, given, info, heading)
        units[axis] = unit
        if wrong is not None:
            issues.append(Issue.about(f"{path}.{axis}_{'unit' if given else 'column'}", wrong, f"{path}."))
            continue
        try:
            array = np.array(values, dtype=np.float64) if unit is None else convert(values, unit, base)
        except UnitError as error:
            issues.append(Issue(f"{path}.{axis}_unit", str(error)))
            continue
        if not np.isfinite(array).all():
            issues.append(Issue(f"{path}.{axis}_unit", f"{axis} is too large a number in {base}"))
        converted.append(array)
    if issues:
        return None, issues
    x, y = converted
    chosen, early, issues = chosen_points(section, path, x, units["x"], info, spec)
    if issues:
        return None, issues
    gross = np.zeros(len(x), dtype=np.bool_)
    gross[list(points.gross_errors)] = True
    gross_x, gross_y = x[gross], y[gross]
    early &= ~gross
    early_x, early_y = x[early], y[early]
    chosen &= ~gross
    kept = np.flatnonzero(chosen)
    place = f"{path}.points.x" if section.points is not None else f"{path}.file"
    if not kept.size:
        nothing = f"no point is left of {len(chosen)}: the others are gross errors"
        return None, [Issue(f"{path}.gross_errors", nothing)]
    x, message = _checked_x(x[kept], points.x, kept, units["x"] or info.x_unit, info, stage_times(spec, section.series))
    if message:
        if section.file is not None and section.x_unit is None and info.x_quantity == "stage":
            message = (*message, "; for loads instead of numbers of stages give ", setting("x_unit", "kPa"))
        return None, [Issue.about(place, message, f"{path}.")]
    y = y[kept]
    count = points.counts[kept]
    # thinning does not weigh: equation (2) is a mean over points
    weights = count / count.mean() if points.weight is None else np.array(points.weight, dtype=np.float64)[kept]
    if not weights.any():
        return None, [Issue(place, "all points that take part have weight 0; at least one must be above 0")]
    for array in (x, y, weights, gross_x, gross_y, early_x, early_y):
        array.flags.writeable = False
    with np.errstate(over="ignore"):
        extent = _difference(points.range_of(chosen), units["y"], info)
        extent = float(np.ptp(y)) if extent is None else extent
    deviation = _difference(section.error, units["y"], info)
    mean_error = points.mean_error(chosen)
    if deviation is not None:
        deviation *= mean_error
    loss, beyond = _loss(section, deviation, units["y"], info)
    if beyond is not None:
        return None, [Issue(f"{path}.loss_scale", beyond)]
    along = CurveScale(float(np.ptp(x)), extent) if section.distance == "orthogonal" else None
    if along is not None and (fault := _no_curve(along, x, info)):
        return None, [Issue(f"{path}.distance", fault)]
    return (
        Observation(
            section.series,
            x,
            y,
            weights,
            section.weight,
            units["x"],
            units["y"],
            points,
            given_weight=section.weight,
            error=deviation,
            given_error=section.error,
            loss=loss,
            along=along,
            given_residuals={name: value for name in _OF_RESIDUALS if (value := getattr(section, name)) is not None},
            chosen=None if chosen.all() else chosen,
            selection={name: getattr(section, name) for name in SELECTION if getattr(section, name) not in (None, [])},
            inputs={name: np.array(values, dtype=np.float64)[kept] for name, values in points.inputs.items()},
            gross_x=gross_x,
            gross_y=gross_y,
            early_x=early_x,
            early_y=early_y,
            readings=float(count.sum()),
            mean_error=mean_error,
            extent=extent,
        ),
        [],
    )


def _difference(value: float | None, unit: str | None, info: SeriesInfo) -> float | None:
    """A difference of y in the base unit: offsets of a unit do not matter."""
    if value is None or unit is None:
        return value
    low, high = convert([0.0, value], unit, info.y_unit)
    return float(high - low)


def _loss(
    section: ObservationSection, error: float | None, unit: str | None, info: SeriesInfo
) -> tuple[Loss | None, str | None]:
    """The loss with its scale in the base unit, and what is wrong with it; ``error`` in the base unit."""
    if section.loss is None:
        return None, None
    scale = _difference(section.loss_scale, unit, info)
    if scale is None:
        assert error is not None  # the section has one of the two
        scale = TUNING[section.loss] * error
    if not _LEAST_SCALE <= scale <= 1.0 / _LEAST_SCALE:
        most = 1.0 / _LEAST_SCALE
        return None, f"must be from {_LEAST_SCALE:g} to {most:g} {info.y_unit}, got {scale:g} {info.y_unit}"
    return Loss(section.loss, scale), None


def _no_curve(along: CurveScale, x: FloatArray, info: SeriesInfo) -> str:
    """Why readings have no distance from a calculated curve; empty where they have."""
    if info.x_integer:
        return f"orthogonal needs x along which the curve runs, but {info.x_quantity} only counts; use vertical"
    if x.size < _FEWEST_OF_CURVE:
        return f"orthogonal needs at least {_FEWEST_OF_CURVE} readings that take part, got {x.size}; use vertical"
    level = [quantity for quantity, span in ((info.x_quantity, along.x), (info.y_quantity, along.y)) if not span > 0.0]
    return f"orthogonal needs readings that vary, but {level[0]} is the same in all; use vertical" if level else ""


def _checked_x(
    x: FloatArray, given: list[float], kept: IntArray, unit: str, info: SeriesInfo, starts: FloatArray
) -> tuple[FloatArray, Sentence]:
    """Points x fit for the series, and what is wrong with them, if anything is.

    Messages show x as the user ``given`` it in ``unit``; ``kept`` are the places of x, shape (m,), in it; loads act
    at ``starts``.
    """

    def shown(index: int) -> str:
        return f"x = {number(given[kept[index]])}{_suffix(unit)} (point {kept[index] + 1})"

    if info.x_integer:
        whole = np.round(x)
        apart = np.abs(x - whole) > _ROUNDING * np.maximum(1.0, np.abs(x))
        if apart.any():
            where = shown(int(np.argmax(apart)))
            return x, (f"series '{info.name}' has values only at whole numbers of {info.x_quantity}, not at {where}",)
        x = whole
    low = -np.inf if info.x_lower is None else info.x_lower
    high = np.inf if info.x_upper is None else info.x_upper
    slack = _ROUNDING * max([1e-300, *(abs(end) for end in (low, high) if np.isfinite(end))])
    outside = (x < low - slack) | (x > high + slack)
    if outside.any():
        places = np.flatnonzero(outside)
        found = f"{shown(int(places[0]))} is outside series '{info.name}', which has {info.x_quantity} {_limits(info)}"
        if len(places) > 1:
            values = [given[kept[place]] for place in places]
            found += f"; {len(places)} points are, {number(min(values))} to {number(max(values))}{_suffix(unit)}"
        if low == 0.0 and not (x > slack).any():
            return x, (f"{found}; ", setting("x_factor", "-1"), " turns the sign")
        if low == 0.0 and (x >= low).any() and not (x > high + slack).any():
            return x, (f"{found}; ", setting("x_from", "0"), " leaves out what is below 0")
        if info.x_unit == "day" and _are_calendar_years(x, np.array(given)[kept]):
            return x, (f"{found}; these may be calendar years: give dates (2019-07-02) or the years since the start",)
        reached = _SPANNED * high, high + slack  # by the readings of a whole test
        meant = meant_unit(float(x.max()), info.x_unit, lambda value: reached[0] <= value <= reached[1], given=unit)
        if meant is not None:
            return x, (f"{found}; in {meant[0]} they would fit: ", setting("x_unit", meant[0]))
        return x, (found,)
    x = np.clip(x, low, high)
    if info.x_increasing and len(x) > 1:
        falling = np.diff(x) <= 0
        if falling.any():
            at = int(np.argmax(falling))
            remedy = same_x_remedy(x[at], starts) if x[at] == x[at + 1] else (setting("sort", "true"), " sorts")
            return x, (f"must increase strictly, but {shown(at + 1)} follows {shown(at)}; ", *remedy)
    return x, ()


def _are_calendar_years(days: FloatArray, given: FloatArray) -> bool:
    """Whether times that were given in years are dates such as 2019.5."""
    return bool(np.all((given > 1900.0) & (given < 2100.0)) and np.allclose(days, 365.0 * given, rtol=2e-3))


def _limits(info: SeriesInfo) -> str:
    unit = _suffix(info.x_unit)
    if info.x_lower is None:
        return f"up to {info.x_upper:g}{unit}"
    if info.x_upper is None:
        return f"from {info.x_lower:g}{unit}"
    return f"from {info.x_lower:g} to {info.x_upper:g}{unit}"


def _suffix(unit: str) -> str:
    return f" {shown_unit(unit)}".rstrip()


def preparation_issues(model: ForwardModel, observations: tuple[Observation, ...]) -> list[Issue]:
    """Return what a model only finds when it is prepared, such as a series that needs a further key of its section."""
    try:
        model.prepare({observation.series: observation.x for observation in observations})
    except ProblemError as error:
        return list(error.issues)
    except (SolverError, ValueError) as error:
        return [Issue("observations", str(error))]
    return []
