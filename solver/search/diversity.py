"""The scatter of a generation."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["diversity"]


def diversity(units: FloatArray) -> float:
    """Root mean square distance of a generation from its centroid, relative to points that fill the box evenly.

    Near 1 for a generation that is scattered over the whole space, 0 where all particles are at one point. The
    parameters count alike: sqrt(12 mean_j(mean_i (u_ij - mean_i u_ij)^2)), as the variance of an even distribution over
    a unit interval is 1/12. At most sqrt(3), half of the particles at either end of every parameter.

    Parameters
    ----------
    units
        Places between the bounds, shape (n, d), 0 to 1 in search coordinates.
    """
    return float(np.sqrt(12.0 * units.var(axis=0).mean()))
