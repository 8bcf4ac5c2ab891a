"""Linear least squares inside bounds, by the active-set method of Stark and Parker (1995).

For the few parameters of a calibration. SciPy has the same method and gives the same numbers, to the last bit (a test
compares them), but takes 0.4 s to load, which every command that begins a search would wait for.
"""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray

__all__ = ["bounded_least_squares"]

_ENOUGH = 1e-10  # a slope, or a relative gain, below which nothing is left to gain


def bounded_least_squares(
    matrix: FloatArray, wanted: FloatArray, lower: FloatArray, upper: FloatArray, *, most_steps: int | None = None
) -> FloatArray:
    """Return x, shape (n,), from ``lower`` to ``upper``, that minimises the norm of ``matrix @ x - wanted``.

    P. B. Stark, R. L. Parker, Bounded-variable least-squares: an algorithm and applications, Computational Statistics
    10 (1995) 129-141; begun at the solution without bounds, as they advise.

    Parameters
    ----------
    matrix, wanted
        Shapes (m, n) and (m,).
    lower, upper
        Shape (n,), with room between them. Rounding may leave x beyond one by 1e-15 of that room.
    most_steps
        Bounds that are left in turn; None: as many as there are parameters.

    Examples
    --------
    >>> bounded_least_squares(np.eye(2), np.array([3.0, 0.5]), np.zeros(2), np.ones(2)).tolist()
    [1.0, 0.5]
    """
    free_minimum = np.asarray(np.linalg.lstsq(matrix, wanted, rcond=-1)[0], dtype=np.float64)
    if ((free_minimum >= lower) & (free_minimum <= upper)).all():
        return free_minimum
    x, side = _on_all_that_are_beyond(matrix, wanted, lower, upper, free_minimum)
    misses = matrix.dot(x) - wanted
    for _ in range(len(x) if most_steps is None else most_steps):
        slopes, before = matrix.T.dot(misses), misses.dot(misses)
        if np.where(side == 0, np.abs(slopes), slopes * side).max() < _ENOUGH:
            break
        side[np.argmax(slopes * side)] = 0
        _to_the_minimum_between(matrix, wanted, lower, upper, x, side)
        misses = matrix.dot(x) - wanted
        if before - misses.dot(misses) < _ENOUGH * before:
            break
    return x


def _on_all_that_are_beyond(
    matrix: FloatArray, wanted: FloatArray, lower: FloatArray, upper: FloatArray, start: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Hold whatever is beyond a bound there and solve for the others, until these are inside.

    Returns x, and for each parameter -1 on the lower bound, 1 on the upper one, 0 free; both of shape (n,).
    """
    side = np.where(start <= lower, -1, np.where(start >= upper, 1, 0))
    x = np.clip(start, lower, upper)
    while (free := np.nonzero(side == 0)[0]).size:
        found = _minimum(matrix, wanted, x, side != 0)
        below, above = found < lower[free], found > upper[free]
        side[free[below]], side[free[above]] = -1, 1
        x[free] = np.clip(found, lower[free], upper[free])
        if not (below | above).any():
            break
    return x, side


def _to_the_minimum_between(
    matrix: FloatArray, wanted: FloatArray, lower: FloatArray, upper: FloatArray, x: FloatArray, side: IntArray
) -> None:
    """Move x, by whole ways or up to the first bound, until the free parameters are at their minimum inside."""
    while True:
        free = np.nonzero(side == 0)[0]
        found = _minimum(matrix, wanted, x, side != 0)
        at, low, high = x[free], lower[free], upper[free]
        beyond = np.concatenate([np.nonzero(found < low)[0], np.nonzero(found > high)[0]])
        if not beyond.size:
            x[free] = found
            return
        bound = np.where(found < low, low, high)[beyond]
        parts = (bound - at[beyond]) / (found[beyond] - at[beyond])
        first = int(np.argmin(parts))
        x[free] = at * (1 - parts[first]) + parts[first] * found
        side[free[beyond[first]]] = -1 if found[beyond[first]] < low[beyond[first]] else 1


def _minimum(matrix: FloatArray, wanted: FloatArray, x: FloatArray, held: BoolArray) -> FloatArray:
    """Free parameters of least squares while the others are held."""
    found = np.linalg.lstsq(matrix[:, ~held], wanted - matrix.dot(x * held), rcond=None)[0]
    return np.asarray(found, dtype=np.float64)
