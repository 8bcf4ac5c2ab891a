"""Slices and contours of the objective through the best run, from the response surface over stored runs.

A place is left out (nan) where the surface knows nothing: outside the range of its runs, where surfaces fitted without
a fifth of the runs disagree, where the nearest run failed, and where a constraint forbids it. All are left out where
the surface misses runs that were left out of its fit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.surface import ResponseSurface

__all__ = ["SurfaceView", "view_surface"]

_TRUSTED = 0.3  # largest error, and difference of surfaces, over f (over the limit where f is smaller)
_HIGH = 10.0  # times the limit: runs up to it span what is shown
_FEWEST = 5  # runs for each free parameter that span it
_MARGIN = 0.1  # of what they span
_LEAST = 1e-3  # parts of the range
_ALONG, _ACROSS = 60, 32  # places on a slice and on a side of the contours: even ones, and as many where runs are
_DRAWS = 256
_FEWEST_PAIRS = 50


@dataclass(frozen=True, slots=True)
class SurfaceView:
    """The objective around the best run, as the surface gives it.

    Parameters
    ----------
    surface, samples
        The surface, and the runs that it was fitted to a part of.
    failed
        Places of failed runs, natural values, shape (k, d).
    limit
        Objective up to which the data cannot tell a fit from the best one.
    error, checked
        Root mean square of (predicted - calculated f) over f (over the limit where f is smaller), for the runs that
        span what is shown, each left out of the fit; and their number.
    trusted
        Whether that error is small enough for anything to be drawn.
    slices
        Of each parameter natural values and f; nan where it is not known.
    pair
        Indices of the two parameters of the contours; None with one free parameter.
    x, y, contours
        Their natural values, shapes (n,) and (m,), and f, shape (m, n); empty without a pair.
    importance
        Share of each parameter in the variation of log f over what is shown, shape (d,): Jansen's total effects,
        made to add up to 1. None where too little of it is known.
    """

    surface: ResponseSurface
    samples: Samples
    failed: FloatArray
    limit: float
    error: float
    checked: int
    trusted: bool
    slices: tuple[tuple[FloatArray, FloatArray], ...]
    pair: tuple[int, int] | None
    x: FloatArray
    y: FloatArray
    contours: FloatArray
    importance: FloatArray | None

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; None where the objective is not known, and for that of a failed run."""
        samples, names = self.samples, self.samples.names
        best, runs = samples.best, self.surface.runs
        places = np.concatenate([samples.parameters[runs], self.failed])
        found = None
        if self.pair is not None:
            found = {
                "x": names[self.pair[0]],
                "y": names[self.pair[1]],
                "x_values": self.x.tolist(),
                "y_values": self.y.tolist(),
                "objectives": [_known(row) for row in self.contours],
            }
        return {
            "evaluations": self.surface.count,
            "error": self.error if np.isfinite(self.error) else None,
            "checked": self.checked,
            "trusted": self.trusted,
            "best": dict(zip(names, samples.parameters[best].tolist(), strict=True)),
            "objective": float(samples.objectives[best]),
            "limit": self.limit,
            "importance": None if self.importance is None else dict(zip(names, self.importance.tolist(), strict=True)),
            "slices": [
                {"parameter": name, "values": values.tolist(), "objectives": _known(objectives)}
                for name, (values, objectives) in zip(names, self.slices, strict=True)
            ],
            "contours": found,
            "runs": {
                "parameters": dict(zip(names, places.T.tolist(), strict=True)),
                "objectives": [*samples.objectives[runs].tolist(), *[None] * len(self.failed)],
            },
        }


def view_surface(
    calibration: Calibration,
    surface: ResponseSurface,
    samples: Samples,
    failed: FloatArray,
    limit: float,
    *,
    x: str | None = None,
    y: str | None = None,
) -> SurfaceView:
    """Cut a surface along every parameter, and along two of them, through the best run; runs no forward calculation.

    Parameters
    ----------
    samples
        Those that the surface was fitted to.
    failed
        Places of failed runs, natural values, shape (k, d).
    limit
        Objective up to which the data cannot tell a fit from the best one.
    x, y
        Parameters of the contours; the first ones when absent.

    Raises
    ------
    StatisticsError
        When a name is not that of a free parameter, the two are the same, or the limit is 0 or infinite.
    """
    chosen = _pair(samples.names, x, y)
    if not 0.0 < limit < np.inf:
        raise StatisticsError(
            f"the objectives are too large or too small to be compared: the limit of fits that are alike is {limit:g}; "
            "units in which the readings are nearer to 1 are needed"
        )
    fitted, best = samples.unit[surface.runs], samples.unit[samples.best]
    found = samples.objectives[surface.runs]
    near = found <= _HIGH * limit
    near[: _FEWEST * samples.dimension] = True
    low, high = fitted[near].min(axis=0), fitted[near].max(axis=0)
    margin = np.maximum(_MARGIN * (high - low), _LEAST)
    low, high = np.maximum(low - margin, surface.lower), np.minimum(high + margin, surface.upper)
    with np.errstate(over="ignore"):  # infinite where objectives are too far apart
        relative = (surface.predicted[near] - found[near]) / np.maximum(found[near], limit)
        error = float(np.sqrt(np.mean(relative**2)))
    space = calibration.space
    places = cKDTree(np.concatenate([fitted, samples.to_unit(failed)]))
    trusted = error <= _TRUSTED

    def objective(at: FloatArray) -> FloatArray:
        if not trusted:
            return np.full(len(at), np.nan)
        value = surface.objective(at)
        known = surface.inside(at) & (surface.spread(at) <= _TRUSTED * np.maximum(value, limit))
        known &= places.query(at)[1] < len(fitted)
        known[known] = [space.feasible(space.from_unit(place)) for place in at[known]]
        return np.where(known, value, np.nan)

    def steps(index: int, count: int) -> FloatArray:
        """Places along a parameter: at even distances, closer where the runs are, and that of the best run."""
        runs = np.quantile(fitted[near, index], np.linspace(0.0, 1.0, count))
        return np.unique([*np.linspace(low[index], high[index], count), *runs, best[index]])

    slices = []
    for index in range(samples.dimension):
        along = steps(index, _ALONG)
        at = np.tile(best, (len(along), 1))
        at[:, index] = along
        slices.append((_natural(samples, index, along), objective(at)))
    across = up = np.empty(0)
    contours: FloatArray = np.empty((0, 0))
    if chosen is not None:
        first, second = chosen
        across, up = steps(first, _ACROSS), steps(second, _ACROSS)
        at = np.tile(best, (len(across) * len(up), 1))
        at[:, first], at[:, second] = np.tile(across, len(up)), np.repeat(up, len(across))
        contours = objective(at).reshape(len(up), len(across))
        across, up = _natural(samples, first, across), _natural(samples, second, up)
    return SurfaceView(
        surface=surface,
        samples=samples,
        failed=failed,
        limit=limit,
        error=error,
        checked=int(near.sum()),
        trusted=trusted,
        slices=tuple(slices),
        pair=chosen,
        x=across,
        y=up,
        contours=contours,
        importance=_importance(objective, low, high, limit),
    )


def _pair(names: tuple[str, ...], x: str | None, y: str | None) -> tuple[int, int] | None:
    for name in (x, y):
        if name is not None and name not in names:
            raise StatisticsError(f"{name!r} is no free parameter; there are {', '.join(names)}")
    if x is not None and x == y:
        raise StatisticsError(f"contours need two different parameters, {x!r} was given twice")
    if len(names) < 2:
        return None
    first = next(name for name in names if name != y) if x is None else x
    second = next(name for name in names if name != first) if y is None else y
    return names.index(first), names.index(second)


def _natural(samples: Samples, index: int, unit: FloatArray) -> FloatArray:
    lower, upper = samples.lower[index], samples.upper[index]
    if samples.log[index]:
        return np.asarray(lower * (upper / lower) ** unit)
    return np.asarray(lower + unit * (upper - lower))


def _importance(
    objective: Callable[[FloatArray], FloatArray], low: FloatArray, high: FloatArray, limit: float
) -> FloatArray | None:
    """Total effects by pairs of places that differ in one parameter (Jansen 1999), made to add up to 1."""
    dimension = len(low)
    random = np.random.default_rng(0)
    first, other = (low + random.random((_DRAWS, dimension)) * (high - low) for _ in range(2))
    moved = np.repeat(first[None], dimension, axis=0)
    for index in range(dimension):
        moved[index, :, index] = other[:, index]
    level = np.log(np.maximum(objective(np.concatenate([first[None], moved]).reshape(-1, dimension)), limit))
    level = level.reshape(dimension + 1, _DRAWS)
    squares = 0.5 * (level[1:] - level[0]) ** 2
    counted = np.isfinite(squares).sum(axis=1)
    if counted.min() < _FEWEST_PAIRS:
        return None
    effects = np.nansum(squares, axis=1) / counted
    return np.asarray(effects / effects.sum()) if effects.sum() > 0.0 else None


def _known(values: FloatArray) -> list[float | None]:
    return [value if np.isfinite(value) else None for value in values.tolist()]
