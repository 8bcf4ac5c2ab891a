"""Places at the ends of linearised intervals, where one run each shows whether the forward model is nonlinear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.search.space import SearchSpace

__all__ = ["IntervalEnds", "plan_ends", "plan_from_residuals"]

_SHORTEST = 0.25  # of the half width: nearer to a bound, nothing is tried on that side
_WIDTH = 2.0  # standard errors, about the half width of a 95 % interval
_OPEN = 1e-7  # singular value, relative to the largest, of a direction that the data leave open


@dataclass(frozen=True, slots=True)
class IntervalEnds:
    """Where to run the model.

    Parameters
    ----------
    positions
        Natural values, shape (k, d).
    parameter
        Whose interval ends there, shape (k,).
    moved
        How far that parameter is from the optimum, parts of the range, shape (k,).
    """

    positions: FloatArray
    parameter: IntArray
    moved: FloatArray

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, from which :meth:`from_json` restores exactly."""
        return {name: getattr(self, name).tolist() for name in ("positions", "parameter", "moved")}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> IntervalEnds:
        """Restore from :meth:`to_json`."""
        return cls(
            np.array(data["positions"], dtype=np.float64),
            np.array(data["parameter"], dtype=np.int64),
            np.array(data["moved"], dtype=np.float64),
        )


def plan_ends(space: SearchSpace, optimum: FloatArray, inverse: FloatArray, half: FloatArray) -> IntervalEnds:
    """Two places for each parameter with an interval, the others refitted to first order; fewer at bounds.

    Parameters
    ----------
    optimum
        Shape (d,), natural values.
    inverse
        What estimates take from weighted readings, parts of the range, shape (d, n).
    half
        Half widths of the intervals, parts of the range, shape (d,); nan where there is none.
    """
    centre = space.to_unit(optimum)
    positions, parameter, moved = [], [], []
    for index in range(space.dimension):
        if not (np.isfinite(half[index]) and half[index] > 0.0) or space.integer[index]:
            continue
        together = inverse @ inverse[index]
        path = together / together[index] * half[index]
        for side in (-1.0, 1.0):
            room = np.where(side * path > 0.0, 1.0 - centre, centre)
            with np.errstate(divide="ignore", invalid="ignore"):
                part = min(1.0, float(np.min(np.where(path == 0.0, np.inf, room / np.abs(path)))))
            if part >= _SHORTEST:
                positions.append(space.from_unit(np.clip(centre + side * part * path, 0.0, 1.0)))
                parameter.append(index)
                moved.append(float(part * half[index]))
    places = np.array(positions, dtype=np.float64).reshape(len(positions), space.dimension)
    return IntervalEnds(places, np.array(parameter, dtype=np.int64), np.array(moved, dtype=np.float64))


def plan_from_residuals(
    space: SearchSpace, optimum: FloatArray, weighted: FloatArray, residuals: FloatArray
) -> IntervalEnds:
    """The same from residuals alone: two standard errors of noise that is the same for all weighted readings.

    None where the derivatives leave a combination of parameters open.

    Parameters
    ----------
    weighted, residuals
        Derivatives per range, shape (n, d), and residuals at the optimum, shape (n,), both weighted.
    """
    count, dimension = weighted.shape
    lengths = np.linalg.norm(weighted, axis=0)
    half = np.full(dimension, np.nan)
    if count <= dimension or not np.isfinite(weighted).all() or not lengths.all():
        return plan_ends(space, optimum, np.empty((dimension, count)), half)
    left, singular, right = np.linalg.svd(weighted / lengths, full_matrices=False)
    inverse = (right.T / singular) @ left.T / lengths[:, None] if singular[-1] > _OPEN * singular[0] else None
    if inverse is None:
        return plan_ends(space, optimum, np.empty((dimension, count)), half)
    noise = float(np.sqrt(residuals @ residuals / (count - dimension)))
    half = _WIDTH * noise * np.linalg.norm(inverse, axis=1)
    return plan_ends(space, optimum, inverse, np.where(half <= 0.5, half, np.nan))
