"""What the strategies learn from: the runs that models are fitted to, and where nothing new is to be found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Knowledge", "selection"]

_BEST_POINTS, _OPEN_POINTS, _SPREAD_POINTS = 60, 40, 40  # that a surface is fitted to


@dataclass(frozen=True, slots=True)
class Knowledge:
    """What the strategies learn from: successful evaluations, best first, and where nothing new is to be found.

    Parameters
    ----------
    points, objectives
        In the unit box, shape (n, d), and f, shape (n,).
    residuals
        Shape (n, m); m = 1 when only the objective is known.
    open
        Whether a point is in no finished basin, shape (n,).
    evaluated
        All points so far, failed ones included, shape (N, d).
    admissible
        Whether a point of the unit box may be proposed.
    snapped
        The point of the unit box that is evaluated instead of a given one: integer parameters are rounded.
    integer
        Which parameters that concerns, shape (d,).
    numbers
        Of the evaluations among all, in the order in which they were made, shape (n,).
    """

    points: FloatArray
    objectives: FloatArray
    residuals: FloatArray
    open: BoolArray
    evaluated: FloatArray
    admissible: Callable[[FloatArray], bool]
    snapped: Callable[[FloatArray], FloatArray]
    integer: BoolArray
    numbers: IntArray


def selection(open_: BoolArray) -> IntArray:
    """Choose the runs that models are fitted to, as indices of all successful ones, best first: at most 140.

    The best 60; the best 40 others outside finished basins (else a converged basin would fill the models alone); and,
    evenly over the rest, 40 that hold a surface down elsewhere.

    Parameters
    ----------
    open_
        Whether a run is in no finished basin, shape (n,), best first.
    """
    n = open_.size
    if n <= _BEST_POINTS + _OPEN_POINTS + _SPREAD_POINTS:
        return np.arange(n)
    others = np.arange(_BEST_POINTS, n)
    first = others[np.argsort(~open_[_BEST_POINTS:], kind="stable")[:_OPEN_POINTS]]
    rest = np.setdiff1d(others, first)
    spread = rest[np.linspace(0, rest.size - 1, _SPREAD_POINTS).round().astype(np.int64)]
    return np.unique(np.concatenate([np.arange(_BEST_POINTS), first, spread]))
