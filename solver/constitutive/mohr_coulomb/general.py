"""Linear elasticity with the Mohr-Coulomb limit for a general stress: one step with its consistent tangent.

Components xx, yy, zz, xy, yz, zx, compression positive; the elastic trial stress is returned to the limit on its own
principal axes, as :mod:`geoswarm.solver.constitutive.mohr_coulomb.planar` does in a plane.
"""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.mohr_coulomb.planar import return_to_limit
from geoswarm.solver.constitutive.principal_return import elastic_trial, turned_back
from geoswarm.solver.constitutive.tensors import principal_axes
from geoswarm.solver.kernels.jit import inlined

__all__ = ["general_mohr_coulomb"]


@inlined
def general_mohr_coulomb(
    stress: FloatArray,
    strain_increment: FloatArray,
    bulk: float,
    shear: float,
    cohesion: float,
    sin_phi: float,
    cos_phi: float,
    sin_psi: float,
    tension: float,
    new: FloatArray,
    tangent: FloatArray,
) -> int:
    """One step of stress; arguments and result as of the planar one, shapes (6,) and (6, 6)."""
    elastic_trial(stress, strain_increment, bulk, shear, new, tangent)
    values, axes = principal_axes(new)
    excess = values[0] * (1.0 - sin_phi) - values[2] * (1.0 + sin_phi) - 2.0 * cohesion * cos_phi
    size = max(abs(values[0]), abs(values[2])) + cohesion
    if excess <= 1.0e-12 * size and -values[2] <= tension + 1.0e-12 * size:
        return 0
    returned, D = np.empty(3), np.empty((3, 3))
    if not return_to_limit(values, bulk, shear, cohesion, sin_phi, cos_phi, sin_psi, tension, returned, D):
        return -1
    turned_back(values, returned, D, axes, shear, size, new, tangent)
    return 1
