"""The damped step of Levenberg and Marquardt, which descents and profiles share."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["marquardt_step"]


def marquardt_step(curvature: FloatArray, gradient: FloatArray, damping: float) -> FloatArray:
    """Return the step (d,) that solves (J'J + damping diag(J'J)) step = -J'r (Marquardt 1963).

    Parameters
    ----------
    curvature, gradient
        J'J, shape (d, d), and J'r, shape (d,). A parameter without influence is damped as if its diagonal were 1.
    damping
        0 is the step of Gauss and Newton.
    """
    diagonal = np.diag(curvature)
    system = curvature + damping * np.diag(np.where(diagonal > 0.0, diagonal, 1.0))
    return np.asarray(-np.linalg.solve(system, gradient), dtype=np.float64)
