"""Variable projection: parameters in which residuals are linear take the values that fit best (Golub and Pereyra 1973).

Points and moves in parts of the range in search coordinates; residuals are read again from the runs. Linear means in
natural values, whatever the scale.
"""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.bounded import bounded_least_squares
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace

__all__ = ["FAR_MOVE", "admissible", "far_moves", "moved", "project", "residuals_of", "slopes_of_moves", "stretched"]

FAR_MOVE = 0.1  # of parameters that enter linearly


def moved(point: FloatArray, index: int, length: float) -> FloatArray:
    """The point with one parameter moved."""
    after = point.copy()
    after[index] += length
    return after


def admissible(space: SearchSpace, point: FloatArray) -> bool:
    """Whether a point is inside the bounds and satisfies the constraints."""
    return bool((point >= 0.0).all() and (point <= 1.0).all()) and space.feasible(space.from_unit(point))


def far_moves(point: FloatArray, parameters: tuple[int, ...]) -> tuple[tuple[int, float], ...]:
    """A long move inside the bounds for each of the parameters."""
    return tuple((i, FAR_MOVE if point[i] <= 0.5 else -FAR_MOVE) for i in parameters)


def stretched(space: SearchSpace, index: int, length: float) -> float:
    """The change of a natural value by a move, over the slope of that value where the move begins.

    Residuals that are linear in the value change by their slope times this: on a linear scale the length itself.
    """
    if not space.log[index]:
        return length
    span = float(space.search_upper[index] - space.search_lower[index])
    return float(np.expm1(span * length)) / span


def _shrunk(space: SearchSpace, index: int, change: float) -> float:
    """The move whose change this is: the inverse of :func:`stretched`."""
    if not space.log[index]:
        return change
    span = float(space.search_upper[index] - space.search_lower[index])
    return float(np.log1p(max(span * change, -1.0 + 1e-15))) / span


def residuals_of(runs: Runs, row: int) -> FloatArray:
    """Weighted residuals of a run, shape (m,)."""
    return np.asarray(runs.residuals(np.array([row]))[0], dtype=np.float64)


def slopes_of_moves(runs: Runs, rows: tuple[int, ...], lengths: tuple[float, ...]) -> FloatArray:
    """Slopes, shape (m, k), from a run, the first of the rows, and one move of each linear parameter, stretched."""
    first = residuals_of(runs, rows[0])
    return np.stack(
        [(residuals_of(runs, row) - first) / length for row, length in zip(rows[1:], lengths, strict=True)], axis=1
    )


def project(
    space: SearchSpace, point: FloatArray, linear: tuple[int, ...], residuals: FloatArray, columns: FloatArray
) -> tuple[FloatArray, float]:
    """The point with the best values of its linear parameters inside the bounds, and f there.

    Parameters
    ----------
    residuals, columns
        At the point, shape (m,), and their slopes along the linear parameters, shape (m, k).
    """
    indices = list(linear)
    down = np.array([stretched(space, i, -float(point[i])) for i in indices])
    up = np.array([stretched(space, i, 1.0 - float(point[i])) for i in indices])
    step = bounded_least_squares(columns, -residuals, np.minimum(down, -1e-15), np.maximum(up, 1e-15))
    best = point.copy()
    moves = np.array([_shrunk(space, i, float(change)) for i, change in zip(indices, step, strict=True)])
    best[indices] = np.clip(point[indices] + moves, 0.0, 1.0)
    return best, float(np.sum((residuals + columns @ step) ** 2))
