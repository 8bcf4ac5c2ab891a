"""What is done to readings before they become observations: sorting, readings at equal x, thinning."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.section import Section

__all__ = ["MANY_POINTS", "Readings", "Resample", "many_points_warning", "prepared"]

MANY_POINTS = 20_000
"""More points of a series than these cost time and tell nothing more."""


class Resample(Section):
    """Fewer points in place of very many: each is the mean of its neighbours."""

    per_decade: int | None = Field(None, ge=1, le=1000, description="groups of equal length in log x: points a decade")
    every: int | None = Field(None, ge=2, description="groups of so many readings in a row")

    @model_validator(mode="after")
    def _one_way(self) -> Resample:
        if (self.per_decade is None) == (self.every is None):
            raise PydanticCustomError("resample", "give either per_decade or every: {{per_decade: 20}}")
        return self


@dataclass(frozen=True, slots=True)
class Readings:
    """x, y, weight and further quantities of the points, lists of one length; ``weight`` None: all 1."""

    x: list[float]
    y: list[float]
    weight: list[float] | None
    inputs: dict[str, list[float]] = field(default_factory=dict)


def prepared(
    readings: Readings, *, sort: bool, repeated_x: Literal["average", "shift"] | None, resample: Resample | None
) -> Readings:
    """Sort readings by x, make x differ, and thin them, in this order.

    The weight of a mean is the sum of those of its readings, so a series as a whole weighs what it did.
    """
    x = np.array(readings.x, dtype=np.float64)
    weight = np.ones(len(x)) if readings.weight is None else np.array(readings.weight, dtype=np.float64)
    columns = {"y": np.array(readings.y, dtype=np.float64)}
    columns |= {f"inputs.{name}": np.array(values, dtype=np.float64) for name, values in readings.inputs.items()}
    if sort:
        order = np.argsort(x, kind="stable")
        x, weight = x[order], weight[order]
        columns = {name: values[order] for name, values in columns.items()}
    if repeated_x == "shift":
        x = _spread(x)
    elif repeated_x == "average":
        x, weight, columns = _means(np.flatnonzero(np.diff(x, prepend=np.nan) != 0), x, weight, columns)
    if resample is not None:
        x, weight, columns = _means(_groups(x, resample), x, weight, columns)
    return Readings(
        x.tolist(),
        columns["y"].tolist(),
        None if readings.weight is None and (weight == 1.0).all() else weight.tolist(),
        {name: columns[f"inputs.{name}"].tolist() for name in readings.inputs},
    )


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
    """What to say of a series with very many points."""
    if points <= MANY_POINTS:
        return None
    return (
        f"series '{series}' has {points} points; more than {MANY_POINTS} cost time and tell nothing more: "
        "resample: {per_decade: 20}, or {every: 10}, in its observation takes means of them"
    )
