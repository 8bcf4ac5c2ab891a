"""What evaluations of curves share: the straight line of least squares, and why a curve allows no evaluation."""

from __future__ import annotations

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import SolverError

__all__ = ["NoEvaluationError", "straight_line"]


class NoEvaluationError(SolverError):
    """A curve does not allow an evaluation; the message says what is missing."""


def straight_line(x: FloatArray, y: FloatArray) -> tuple[float, float, float]:
    """Return slope, value at x = 0, and the sum of squares of what is left; x and y of shape (n,).

    Raises
    ------
    NoEvaluationError
        All x are the same.
    """
    middle = float(x.mean())
    dx, dy = x - middle, y - y.mean()
    square = float(dx @ dx)
    if not square > 0.0:
        raise NoEvaluationError("the points of a straight line are all at the same place")
    slope = float(dx @ dy) / square
    left = dy - slope * dx
    return slope, float(y.mean()) - slope * middle, float(left @ left)
