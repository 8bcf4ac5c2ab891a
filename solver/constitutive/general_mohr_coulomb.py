"""Linear elasticity with the Mohr-Coulomb limit for a general stress: one step with its consistent tangent.

Components xx, yy, zz, xy, yz, zx, compression positive; the elastic trial stress is returned to the limit on its own
principal axes, as :mod:`geoswarm.solver.constitutive.planar_mohr_coulomb` does in a plane.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.planar_mohr_coulomb import return_to_limit
from geoswarm.solver.constitutive.tensors import principal_axes, rotation_matrix
from geoswarm.solver.kernels.jit import inlined

__all__ = ["general_mohr_coulomb"]

_PAIRS: Final = ((0, 1), (1, 2), (2, 0))


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
    lame = bulk - 2.0 / 3.0 * shear
    volume = strain_increment[0] + strain_increment[1] + strain_increment[2]
    for i in range(6):
        for j in range(6):
            tangent[i, j] = lame if i < 3 and j < 3 else 0.0
        stiffness = 2.0 * shear if i < 3 else shear
        tangent[i, i] += stiffness
        new[i] = stress[i] + stiffness * strain_increment[i] + (lame * volume if i < 3 else 0.0)
    values, axes = principal_axes(new)
    excess = values[0] * (1.0 - sin_phi) - values[2] * (1.0 + sin_phi) - 2.0 * cohesion * cos_phi
    size = max(abs(values[0]), abs(values[2])) + cohesion
    if excess <= 1.0e-12 * size and -values[2] <= tension + 1.0e-12 * size:
        return 0
    returned, D = np.empty(3), np.empty((3, 3))
    if not return_to_limit(values, bulk, shear, cohesion, sin_phi, cos_phi, sin_psi, tension, returned, D):
        return -1
    local = np.zeros((6, 6))
    for i in range(3):
        for j in range(3):
            local[i, j] = D[i, j]
    for k in range(3):
        i, j = _PAIRS[k]
        gap = values[i] - values[j]
        if abs(gap) > 1.0e-9 * size:
            local[3 + k, 3 + k] = shear * (returned[i] - returned[j]) / gap
        else:
            local[3 + k, 3 + k] = 0.25 * (D[i, i] - D[i, j] + D[j, j] - D[j, i])
    Q = rotation_matrix(axes)
    for i in range(6):
        new[i] = 0.0
        for k in range(3):
            new[i] += Q[i, k] * returned[k]
        for j in range(6):
            total = 0.0
            for k in range(6):
                for m in range(6):
                    total += Q[i, k] * local[k, m] * Q[j, m]
            tangent[i, j] = total
    return 1
