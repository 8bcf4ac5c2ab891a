"""From the points that a program has written to the points that were observed."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import BadOutputError

__all__ = ["at_points"]

_TOLERANCE = 1.0e-9
"""How far beyond the ends an observed point may lie, over the range of x: rounding of what was printed."""


def at_points(series: str, x: FloatArray, y: FloatArray, wanted: FloatArray) -> FloatArray:
    """Linear between the points of a series; x may rise or fall, or be in any order where all wanted points are in it.

    Parameters
    ----------
    x, y
        Shape (n,).
    wanted
        Points, shape (m,), in the same unit as x.

    Raises
    ------
    BadOutputError
        The series does not reach a wanted point, has two values at one, or turns back between them.

    Examples
    --------
    >>> at_points("u", np.array([2.0, 0.0]), np.array([4.0, 0.0]), np.array([0.5, 2.0])).tolist()
    [1.0, 4.0]
    """
    steps = np.diff(x)
    turns = bool((steps < 0.0).any() and (steps > 0.0).any())
    if turns and not np.isin(wanted, x).all():
        place = int(np.argmax(np.sign(steps) != np.sign(steps[np.flatnonzero(steps)[0]])))
        raise BadOutputError(
            f"{series} turns back at x = {x[place]:g} (point {place + 1} of {len(x)}), so it has no one value between "
            "its points; observe it at points that it has, or choose rows"
        )
    order = np.argsort(x, kind="stable")
    x, y = x[order], y[order]
    twice = (np.diff(x) == 0.0) & (np.diff(y) != 0.0)
    if twice.any():
        place = int(np.argmax(twice))
        raise BadOutputError(f"{series} has two values at x = {x[place]:g}: {y[place]:g} and {y[place + 1]:g}")
    slack = _TOLERANCE * max(float(x[-1] - x[0]), abs(float(x[-1])), abs(float(x[0])))
    if wanted.min() < x[0] - slack or wanted.max() > x[-1] + slack:
        raise BadOutputError(
            f"{series} was calculated for x from {x[0]:g} to {x[-1]:g} ({len(x)} points); "
            f"it is observed from {wanted.min():g} to {wanted.max():g}"
        )
    return np.asarray(np.interp(wanted, x, y))
