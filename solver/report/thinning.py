"""Fewer points for figures where there are more than anybody can see: none that sticks out is left out."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray

__all__ = ["MOST_SHOWN", "shown"]

MOST_SHOWN = 4000
"""Points of a curve that a figure draws: more than it has pixels."""


def shown(*curves: FloatArray) -> IntArray:
    """Return which points to draw, rising.

    Parameters
    ----------
    curves
        Values over one x, each of shape (n,).

    Returns
    -------
    All n if they are not too many; else of every group of neighbours the first, the last, and for each of the curves
    the lowest and the highest, so that lines and clouds of points look as if all were drawn.
    """
    count = len(curves[0])
    if count <= MOST_SHOWN:
        return np.arange(count)
    groups = MOST_SHOWN // (2 + 2 * len(curves))
    edges = np.linspace(0, count, groups + 1).astype(np.int64)
    chosen = [edges[:-1], edges[1:] - 1]
    for curve in curves:
        for pick in (np.argmin, np.argmax):
            chosen += [np.array([a + int(pick(curve[a:b])) for a, b in pairwise(edges)])]
    return np.unique(np.concatenate(chosen))
