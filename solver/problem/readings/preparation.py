"""Processing of readings before they become observations: zero reading, sorting, readings at equal x, thinning."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.problem.issues import number
from geoswarm.solver.problem.readings.zero import ZeroReading, zero_reading
from geoswarm.solver.problem.stages import AT_LOAD, at_load, stage_of
from geoswarm.solver.section import Section
from geoswarm.solver.sentences import Key, SentenceError, plain, setting

__all__ = [
    "MANY_POINTS",
    "Preparation",
    "PreparationError",
    "Readings",
    "Resample",
    "independent_readings",
    "many_points_warning",
    "prepared",
]

MANY_POINTS = 20_000
"""More points of a series than these cost time and tell nothing more."""

_INDEPENDENT_SHARE = 18.0 / 35.0
"""Degrees of freedom of the variance from second differences, for each: they overlap."""
_BY_CHANCE = 0.01
_FEWEST_TIMES = 2  # other than loads, with a reading of each gauge


class Resample(Section):
    """Fewer points instead of very many: each is the mean of its neighbours."""

    per_decade: int | None = Field(None, ge=1, le=1000, description="groups of equal length in log x: points a decade")
    every: int | None = Field(None, ge=2, description="groups of this many consecutive readings")

    @model_validator(mode="after")
    def _one_way(self) -> Resample:
        if (self.per_decade is None) == (self.every is None):
            ways = setting("per_decade"), " or ", setting("every"), ", for example ", setting("per_decade", "20")
            raise SentenceError("give either ", *ways)
        return self

    def in_words(self) -> str:
        """What is done."""
        if self.every is not None:
            return f"every {self.every} readings in a row were replaced by their mean"
        return f"neighbouring readings were replaced by their means, at most {self.per_decade} to a decade of x"


@dataclass(frozen=True, slots=True)
class Readings:
    """x, y, weight and further quantities of the points, lists of one length; ``weight`` None: not given.

    ``gross_errors`` are the places of those marked as such, rising. ``count`` is the number of readings of which each
    point is the mean; None: 1 each. ``independent`` is the number of independent readings that they are worth, and
    ``range`` the largest less the smallest of them; None: not known.
    """

    x: list[float]
    y: list[float]
    weight: list[float] | None
    inputs: dict[str, list[float]] = field(default_factory=dict)
    gross_errors: tuple[int, ...] = ()
    count: list[float] | None = None
    independent: float | None = None
    range: float | None = None


@dataclass(frozen=True, slots=True)
class Preparation:
    """How to process readings.

    ``error`` is the standard deviation of a reading, as far as it is stated. ``loads`` are the x at which the loads of
    a test in stages are applied: no mean is taken across them.
    """

    zero: Literal["first"] | ZeroReading | None = None
    x_factor: float = 1.0
    y_factor: float = 1.0
    sort: bool = False
    repeated_x: Literal["average", "shift"] | None = None
    resample: Resample | None = None
    error: float | None = None
    loads: tuple[float, ...] = ()


class PreparationError(Exception):
    """Readings cannot be processed as a key of the observation says."""

    def __init__(self, key: str, *message: str | Key) -> None:
        super().__init__(plain(message))
        self.key, self.sentence = key, message


def prepared(readings: Readings, wanted: Preparation) -> tuple[Readings, list[str]]:
    """Multiply x, sort by it, subtract the zero reading, multiply y, make x differ, and thin; report each step.

    Thinning does not change what a series weighs: given weights of the readings of a mean are added, and scaled so that
    their mean over the points is that over the readings. Gross errors take no part in zero readings and means, and
    stand among the others by their x.

    Raises
    ------
    PreparationError
        No reading at the x of the zero reading, or different readings at the moment of a load that would become one.
    """
    if wanted == Preparation(error=wanted.error, loads=wanted.loads):
        return readings, []
    x = np.array(readings.x, dtype=np.float64)
    y = np.array(readings.y, dtype=np.float64)
    weight = np.ones(len(x)) if readings.weight is None else np.array(readings.weight, dtype=np.float64)
    count = np.ones(len(x)) if readings.count is None else np.array(readings.count, dtype=np.float64)
    counted = np.ones(len(x), dtype=np.bool_)
    counted[list(readings.gross_errors)] = False
    if not counted.any():
        return readings, []  # refused elsewhere
    done = []
    if wanted.x_factor != 1.0:
        x = x * wanted.x_factor
        done.append(f"x was multiplied by {number(wanted.x_factor)}")
    order = np.argsort(x, kind="stable") if wanted.sort else np.arange(len(x))
    if (np.diff(order) < 0).any():
        done.append("the readings were sorted by x")
    x, y, weight, count, counted = x[order], y[order], weight[order], count[order], counted[order]
    columns = {f"inputs.{name}": np.array(values, dtype=np.float64)[order] for name, values in readings.inputs.items()}
    if wanted.zero is not None:
        value, said = zero_reading(wanted.zero, x, y, counted)
        if value is None:
            raise PreparationError("y_zero", said)
        y = y - value
        done.append(said)
    if wanted.y_factor != 1.0:
        y = y * wanted.y_factor
        done.append(f"y was multiplied by {number(wanted.y_factor)}")
    columns |= {"y": y, "weight": weight, "count": count}
    marked = x[~counted], {name: values[~counted] for name, values in columns.items()}
    places: IntArray = np.cumsum(counted)[~counted].astype(np.int64)  # how many that count stand before each
    x, columns = x[counted], {name: values[counted] for name, values in columns.items()}
    if wanted.repeated_x == "shift":
        x = _spread(x)
        done.append("readings at equal x were spread evenly up to the next x")
    gauges = _gauges(x, wanted)
    if gauges > 1:
        x, told = _apart(x, gauges, wanted.loads)
        done += told
    begins, notes = _groups(x, columns["count"] if readings.weight is None else columns["weight"], wanted)
    independent, extent = readings.independent, readings.range
    if extent is not None:
        extent *= abs(wanted.y_factor)
    if len(begins) < len(x):
        if gauges == 1:
            _refuse_mixed(x, columns["y"], begins, wanted.loads)
        done += notes
        extent = float(np.ptp(columns["y"])) if extent is None else extent
        if wanted.error is not None and independent is None:
            independent, said = independent_readings(x, columns["y"], begins, wanted.error)
            done.append(said)
        places = np.searchsorted(begins, places, side="left").astype(np.int64)
        x, columns = _means(begins, x, columns, "count" if readings.weight is None else "weight")
    x = np.insert(x, places, marked[0])
    columns = {name: np.insert(values, places, marked[1][name]) for name, values in columns.items()}
    found = Readings(
        x.tolist(),
        columns["y"].tolist(),
        None if readings.weight is None else columns["weight"].tolist(),
        {name: columns[f"inputs.{name}"].tolist() for name in readings.inputs},
        tuple((places + np.arange(len(places))).tolist()),
        None if (columns["count"] == 1.0).all() else columns["count"].tolist(),
        independent,
        extent,
    )
    return found, done


def _groups(x: FloatArray, weight: FloatArray, wanted: Preparation) -> tuple[IntArray, list[str]]:
    """First reading of each group of which the mean is taken, and what is said of it."""
    begins, notes = np.arange(len(x)), []
    if wanted.repeated_x == "average":
        begins = np.flatnonzero(np.diff(x, prepend=np.nan) != 0)
        if len(begins) < len(x):
            notes.append(f"readings at equal x were averaged: {len(begins)} points of {len(x)} readings")
    if wanted.resample is not None:
        before = len(begins)
        stages = stage_of(x[begins], np.array(wanted.loads)) if wanted.loads else np.zeros(before)
        firsts = np.flatnonzero(np.diff(stages, prepend=stages[0]) != 0)
        begins = begins[np.union1d(_resampled(_mean(begins, x, weight), wanted.resample), firsts)]
        if len(begins) < before:
            notes.append(f"{wanted.resample.in_words()}: {len(begins)} points of {before} readings")
    return begins, notes


def _gauges(x: FloatArray, wanted: Preparation) -> int:
    """How many gauges were read at every x of an average: as many readings, or twice as many at the moment of a load.

    1 where that cannot be: then equal x at a load are readings before and after it.
    """
    places, counts = np.unique(x, return_counts=True)
    loaded = at_load(places, np.array(wanted.loads))
    number = int(counts.min()) if wanted.repeated_x == "average" and (~loaded).sum() >= _FEWEST_TIMES else 1
    return number if (counts[~loaded] == number).all() and np.isin(counts[loaded], (number, 2 * number)).all() else 1


def _apart(x: FloatArray, gauges: int, loads: tuple[float, ...]) -> tuple[FloatArray, list[str]]:
    """Move readings after a load halfway to the next x, as ``shift`` does, where those before it have the same x."""
    begins = np.flatnonzero(np.diff(x, prepend=np.nan) != 0)
    twice = begins[(np.diff(np.append(begins, len(x))) == 2 * gauges) & at_load(x[begins], np.array(loads))]
    if not twice.size:
        return x, []
    steps = np.diff(np.append(x[begins], 2.0 * x[-1] - x[begins[-2]]))
    moved = x.copy()
    for first in twice:
        moved[first + gauges : first + 2 * gauges] += 0.5 * steps[begins == first]
    said = f"at a load, the first {gauges} of {2 * gauges} readings are those before it"
    return moved, [f"{said}, and the mean of the others is halfway to the next x"]


def _refuse_mixed(x: FloatArray, y: FloatArray, begins: IntArray, loads: tuple[float, ...]) -> None:
    """Refuse a mean of different readings at the moment of a load: some are from before it, some from after it."""
    group = np.searchsorted(begins, np.arange(len(x)), side="right")
    for stage, load in enumerate(loads, start=1):
        at = np.flatnonzero(at_load(x, np.array([load])))
        if len(np.unique(group[at])) < len(at) and np.ptp(y[at]) > 0.0:
            low, high = number(float(y[at].min())), number(float(y[at].max()))
            found = f"{len(at)} readings at x = {number(load)}, where stage {stage} begins, are from {low} to {high}"
            message = f"{found}: their mean would mix readings before and after the load. "
            raise PreparationError("repeated_x", message, *AT_LOAD)


def _spread(x: FloatArray) -> FloatArray:
    """Spread equal values in a row evenly up to the next one; the last ones by the step before them."""
    begins = np.flatnonzero(np.diff(x, prepend=np.nan) != 0)
    if len(begins) == len(x):
        return x
    steps = np.diff(x[begins])
    steps = np.append(steps, steps[-1] if len(steps) else 1.0)
    counts = np.diff(np.append(begins, len(x)))
    within = np.arange(len(x)) - np.repeat(begins, counts)
    return np.asarray(x + within * np.repeat(steps / counts, counts))


def _resampled(x: FloatArray, resample: Resample) -> IntArray:
    """First point of each group."""
    if resample.every is not None:
        return np.arange(0, len(x), resample.every)
    assert resample.per_decade is not None
    with np.errstate(divide="ignore", invalid="ignore"):
        number = np.floor(np.log10(np.maximum(x, 0.0)) * resample.per_decade)
    return np.flatnonzero(np.diff(np.nan_to_num(number, neginf=-1e9), prepend=np.nan) != 0)


def _mean(begins: IntArray, values: FloatArray, weight: FloatArray) -> FloatArray:
    """Weighted means of the readings from each beginning to the next; plain ones where all weights are 0."""
    sums = np.add.reduceat(weight, begins)
    counts = np.diff(np.append(begins, len(values)))
    share = weight / np.repeat(np.where(sums > 0, sums, 1.0), counts)
    share = np.where(np.repeat(sums > 0, counts), share, 1.0 / np.repeat(counts, counts))
    return np.where(counts == 1, values[begins], np.add.reduceat(values * share, begins))


def _means(
    begins: IntArray, x: FloatArray, columns: dict[str, FloatArray], weighing: str
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Means of the readings from each beginning to the next: sums of counts, and of weights with their mean kept."""
    weight = columns[weighing]
    found = {name: _mean(begins, values, weight) for name, values in columns.items()}
    found["count"] = np.add.reduceat(columns["count"], begins)
    found["weight"] = np.add.reduceat(columns["weight"], begins) * (len(begins) / len(x))
    return _mean(begins, x, weight), found


def independent_readings(x: FloatArray, y: FloatArray, begins: IntArray, error: float) -> tuple[float, str]:
    """How many independent readings of this error the means are worth, and what is said of it.

    The error of a mean of n readings is error / sqrt(n) only where they scatter independently. The scatter of
    neighbours about the straight line between those before and after gives the variance s^2 that means reduce (Gasser,
    Sroka and Jennen-Steinmetz 1986). Where it is smaller than that of the stated error, beyond chance (1 %), the rest
    is common to neighbours, such as the calibration of a gauge or the drift of a logger; a mean of n is worth
    1 / (s^2 / error^2 / n + 1 - s^2 / error^2) readings.

    Parameters
    ----------
    x, y
        All readings, shape (n,).
    begins
        First reading of each mean, shape (k,).
    """
    from scipy.special import chdtr

    counts = np.diff(np.append(begins, len(x)))
    inner = np.flatnonzero(np.repeat(counts > 1, counts)[1:-1]) + 1
    share = 1.0
    if inner.size:
        before, after = x[inner] - x[inner - 1], x[inner + 1] - x[inner]
        whole = before + after
        part = np.divide(before, whole, out=np.full(inner.size, 0.5), where=whole > 0.0)
        off = y[inner] - (1.0 - part) * y[inner - 1] - part * y[inner + 1]
        ratio = float(np.mean(off**2 / (1.0 + part**2 + (1.0 - part) ** 2))) / error**2
        degrees = max(_INDEPENDENT_SHARE * inner.size, 1.0)
        share = ratio if float(chdtr(degrees, degrees * ratio)) < _BY_CHANCE else 1.0
    worth = float(np.sum(1.0 / (share / counts + 1.0 - share)))
    if share == 1.0:
        return worth, "the error of a mean of n readings counts as the error of a reading over the root of n"
    return worth, (
        f"neighbouring readings differ by less than independent errors of {number(error)} would, so the {len(x)} "
        f"readings are equivalent to {worth:.3g} independent ones of this error"
    )


def many_points_warning(series: str, points: int) -> str | None:
    """Warning about a series with very many points."""
    if points <= MANY_POINTS:
        return None
    return (
        f"series '{series}' has {points} points; more than {MANY_POINTS} cost time and add nothing: "
        "resample: {per_decade: 20}, or {every: 10}, in its observation takes means of them"
    )
