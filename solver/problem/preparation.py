"""Processing of readings before they become observations: zero reading, sorting, readings at equal x, thinning."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.problem.issues import number
from geoswarm.solver.problem.zero import ZeroReading, zero_reading
from geoswarm.solver.section import Section

__all__ = [
    "MANY_POINTS",
    "NoZeroError",
    "Preparation",
    "Readings",
    "Resample",
    "many_points_warning",
    "prepared",
]

MANY_POINTS = 20_000
"""More points of a series than these cost time and tell nothing more."""


class Resample(Section):
    """Fewer points instead of very many: each is the mean of its neighbours."""

    per_decade: int | None = Field(None, ge=1, le=1000, description="groups of equal length in log x: points a decade")
    every: int | None = Field(None, ge=2, description="groups of so many readings in a row")

    @model_validator(mode="after")
    def _one_way(self) -> Resample:
        if (self.per_decade is None) == (self.every is None):
            raise PydanticCustomError("resample", "give either per_decade or every: {{per_decade: 20}}")
        return self

    def in_words(self) -> str:
        """What is done."""
        if self.every is not None:
            return f"every {self.every} readings in a row were replaced by their mean"
        return f"neighbouring readings were replaced by their means, at most {self.per_decade} to a decade of x"


@dataclass(frozen=True, slots=True)
class Readings:
    """x, y, weight and further quantities of the points, lists of one length; ``weight`` None: all 1.

    ``gross_errors`` are the places of those marked as such, rising.
    """

    x: list[float]
    y: list[float]
    weight: list[float] | None
    inputs: dict[str, list[float]] = field(default_factory=dict)
    gross_errors: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Preparation:
    """How to process readings."""

    zero: Literal["first"] | ZeroReading | None = None
    factor: float = 1.0
    sort: bool = False
    repeated_x: Literal["average", "shift"] | None = None
    resample: Resample | None = None


class NoZeroError(Exception):
    """There is no zero reading."""


def prepared(readings: Readings, wanted: Preparation) -> tuple[Readings, list[str]]:
    """Sort by x, subtract the zero reading, multiply, make x differ, and thin, in this order; report each step.

    The weight of a mean is the sum of those of its readings, so a series as a whole weighs what it did. Gross errors
    take no part in zero readings and means, and stand among the others by their x.

    Raises
    ------
    NoZeroError
        No reading at the x of the zero reading.
    """
    if wanted == Preparation():
        return readings, []
    x = np.array(readings.x, dtype=np.float64)
    y = np.array(readings.y, dtype=np.float64)
    weight = np.ones(len(x)) if readings.weight is None else np.array(readings.weight, dtype=np.float64)
    counted = np.ones(len(x), dtype=np.bool_)
    counted[list(readings.gross_errors)] = False
    if not counted.any():
        return readings, []  # refused elsewhere
    done = []
    order = np.argsort(x, kind="stable") if wanted.sort else np.arange(len(x))
    if (np.diff(order) < 0).any():
        done.append("the readings were sorted by x")
    x, y, weight, counted = x[order], y[order], weight[order], counted[order]
    columns = {f"inputs.{name}": np.array(values, dtype=np.float64)[order] for name, values in readings.inputs.items()}
    if wanted.zero is not None:
        value, said = zero_reading(wanted.zero, x, y, counted)
        if value is None:
            raise NoZeroError(said)
        y = y - value
        done.append(said)
    if wanted.factor != 1.0:
        y = y * wanted.factor
        done.append(f"y was multiplied by {number(wanted.factor)}")
    columns["y"] = y
    marked = x[~counted], weight[~counted], {name: values[~counted] for name, values in columns.items()}
    places: IntArray = np.cumsum(counted)[~counted].astype(np.int64)  # how many that count stand before each
    x, weight, columns = x[counted], weight[counted], {name: values[counted] for name, values in columns.items()}
    if wanted.repeated_x == "shift":
        x = _spread(x)
        done.append("readings at equal x were spread evenly up to the next x")
    for groups, said in _groupings(wanted):
        begins = groups(x)
        places = np.searchsorted(begins, places, side="left").astype(np.int64)
        before = len(x)
        x, weight, columns = _means(begins, x, weight, columns)
        done.append(f"{said}: {len(x)} points of {before} readings")
    x, weight = np.insert(x, places, marked[0]), np.insert(weight, places, marked[1])
    columns = {name: np.insert(values, places, marked[2][name]) for name, values in columns.items()}
    found = Readings(
        x.tolist(),
        columns["y"].tolist(),
        None if readings.weight is None and (weight == 1.0).all() else weight.tolist(),
        {name: columns[f"inputs.{name}"].tolist() for name in readings.inputs},
        tuple((places + np.arange(len(places))).tolist()),
    )
    return found, done


def _groupings(wanted: Preparation) -> Iterator[tuple[Callable[[FloatArray], IntArray], str]]:
    """Functions that give the first reading of each group, and what is said of them."""
    if wanted.repeated_x == "average":
        yield lambda x: np.flatnonzero(np.diff(x, prepend=np.nan) != 0), "readings at equal x were averaged"
    resample = wanted.resample
    if resample is not None:
        yield lambda x: _groups(x, resample), resample.in_words()


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


def _groups(x: FloatArray, resample: Resample) -> IntArray:
    """First reading of each group."""
    if resample.every is not None:
        return np.arange(0, len(x), resample.every)
    assert resample.per_decade is not None
    with np.errstate(divide="ignore", invalid="ignore"):
        number = np.floor(np.log10(np.maximum(x, 0.0)) * resample.per_decade)
    return np.flatnonzero(np.diff(np.nan_to_num(number, neginf=-1e9), prepend=np.nan) != 0)


def _means(
    begins: IntArray, x: FloatArray, weight: FloatArray, columns: dict[str, FloatArray]
) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]]:
    """Weighted means of the readings from each beginning to the next; plain ones where all weights are 0."""
    sums = np.add.reduceat(weight, begins)
    counts = np.diff(np.append(begins, len(x)))
    share = weight / np.repeat(np.where(sums > 0, sums, 1.0), counts)
    share = np.where(np.repeat(sums > 0, counts), share, 1.0 / np.repeat(counts, counts))
    alone = counts == 1

    def mean(values: FloatArray) -> FloatArray:
        return np.where(alone, values[begins], np.add.reduceat(values * share, begins))

    return mean(x), sums, {name: mean(values) for name, values in columns.items()}


def many_points_warning(series: str, points: int) -> str | None:
    """Warning about a series with very many points."""
    if points <= MANY_POINTS:
        return None
    return (
        f"series '{series}' has {points} points; more than {MANY_POINTS} cost time and tell nothing more: "
        "resample: {per_decade: 20}, or {every: 10}, in its observation takes means of them"
    )
