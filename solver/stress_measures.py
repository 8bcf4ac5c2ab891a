"""Mean and deviatoric stress of many states at once, in arrays."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["mean_and_squared_q"]


def mean_and_squared_q(stress: FloatArray) -> tuple[FloatArray, FloatArray]:
    """p and q^2 = 3/2 s:s, shapes (...), of stresses (..., 4 or 6): xx, yy, zz, xy, and in general yz, zx.

    >>> p, squared = mean_and_squared_q(np.array([50.0, 110.0, 50.0, 0.0]))
    >>> float(p), float(np.sqrt(squared))
    (70.0, 60.0)
    """
    p: FloatArray = stress[..., :3].mean(axis=-1)
    normal = ((stress[..., :3] - p[..., np.newaxis]) ** 2).sum(axis=-1)
    squared: FloatArray = 1.5 * normal + 3.0 * (stress[..., 3:] ** 2).sum(axis=-1)
    return p, squared
