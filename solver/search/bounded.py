"""Linear least squares inside bounds."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["bounded_least_squares"]


def bounded_least_squares(
    matrix: FloatArray, wanted: FloatArray, lower: FloatArray, upper: FloatArray, *, most_steps: int | None = None
) -> FloatArray:
    """Return x, shape (n,), from ``lower`` to ``upper``, that makes the norm of ``matrix @ x - wanted`` least.

    Parameters
    ----------
    matrix, wanted
        Shapes (m, n) and (m,).
    lower, upper
        Shape (n,), with room between them.
    most_steps
        Of the active-set method (Stark and Parker 1995); None: as many as there are parameters.

    Examples
    --------
    >>> bounded_least_squares(np.eye(2), np.array([3.0, 0.5]), np.zeros(2), np.ones(2)).tolist()
    [1.0, 0.5]
    """
    from scipy.optimize import lsq_linear  # takes half a second to import, which `geoswarm check` need not wait for

    found = lsq_linear(matrix, wanted, (lower, upper), method="bvls", max_iter=most_steps)
    return np.asarray(found.x, dtype=np.float64)
