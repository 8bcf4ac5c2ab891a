"""The step from an optimum to the minimum of the linearised objective, inside the bounds (Karush, Kuhn and Tucker).

At a bound, a gradient that points outwards is not a sign of a minimum elsewhere: the minimum lies there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.identifiability.optimum.combinations import Directions
from geoswarm.solver.search.bounded import bounded_least_squares

__all__ = ["MinimisingStep", "minimising_step"]

_ON_BOUND = 1e-6  # parts of the range


@dataclass(frozen=True, slots=True)
class MinimisingStep:
    """Where the linearised objective is least.

    Parameters
    ----------
    move
        Of each parameter, parts of the range, shape (d,); 0 for those that the data leave open.
    held
        -1 at the lower, 1 at the upper bound where the data pull beyond it, else 0; shape (d,).
    """

    move: FloatArray
    held: IntArray


def minimising_step(
    weighted: FloatArray, residuals: FloatArray, found: Directions, place: FloatArray
) -> MinimisingStep:
    """Minimise |residuals + weighted move| over the determined directions.

    Parameters
    ----------
    weighted, residuals
        Derivatives per range, shape (n, d), and residuals, shape (n,), both weighted.
    place
        Of the optimum, parts of the range, shape (d,).
    """
    free = -found.inverse(weighted) @ residuals
    lowest, highest = np.where(place <= _ON_BOUND, 0.0, -place), np.where(place >= 1.0 - _ON_BOUND, 0.0, 1.0 - place)
    held = np.zeros(len(place), dtype=np.int64)
    pulled = ((free < lowest) & (lowest == 0.0)) | ((free > highest) & (highest == 0.0))
    if not pulled.any():
        return MinimisingStep(free, held)
    basis = found.basis
    # a bound needs some room for the solver; what is left of it is far below a standard error
    room = (np.minimum(lowest, -1e-12), np.maximum(highest, 1e-12))
    move = bounded_least_squares(basis.T @ weighted, -basis.T @ residuals, *room)
    gradient = weighted.T @ (basis @ (basis.T @ (residuals + weighted @ move)))
    held[(lowest == 0.0) & (gradient > 0.0) & (move <= 0.0)] = -1
    held[(highest == 0.0) & (gradient < 0.0) & (move >= 0.0)] = 1
    move[held != 0] = 0.0
    return MinimisingStep(move, held)
