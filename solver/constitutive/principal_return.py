"""What returns on principal axes have in common: the elastic trial before, and stress components after them.

Components xx, yy, zz, xy and, in general, yz, zx, compression positive. Limits and flow are isotropic, so that the new
stress has the axes of the elastic trial stress.
"""

from __future__ import annotations

from typing import Final

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.local_arrays import local_matrix, local_vector
from geoswarm.solver.constitutive.tensors import fill_rotation_matrix
from geoswarm.solver.kernels.jit import kernel

__all__ = ["elastic_trial", "turned_back"]

_PAIRS: Final = ((0, 1), (1, 2), (2, 0))
_SAME: Final = 1.0e-9


@kernel
def elastic_trial(
    stress: FloatArray, strain: FloatArray, bulk: float, shear: float, new: FloatArray, tangent: FloatArray
) -> None:
    """Fill stress (n,) after a linear elastic step and its stiffness (n, n); n = 4 or 6."""
    n = stress.shape[0]
    lame = bulk - 2.0 / 3.0 * shear
    volume = strain[0] + strain[1] + strain[2]
    for i in range(n):
        for j in range(n):
            tangent[i, j] = lame if i < 3 and j < 3 else 0.0
        stiffness = 2.0 * shear if i < 3 else shear
        tangent[i, i] += stiffness
        new[i] = stress[i] + stiffness * strain[i] + (lame * volume if i < 3 else 0.0)


@kernel
def turned_back(
    values: FloatArray,
    returned: FloatArray,
    D: FloatArray,
    axes: FloatArray,
    shear: float,
    size: float,
    new: FloatArray,
    tangent: FloatArray,
) -> None:
    """Fill stress components (n,) and tangent (n, n) from principal stresses.

    Parameters
    ----------
    values, returned, D
        Trial and new principal stresses (3,), and derivatives of the new ones by the principal strains (3, 3).
    axes
        (3, 3): principal axes as columns.
    shear
        Shear modulus with which the trial stress turns, kPa.
    size
        Of the stresses: trial stresses closer than a small part of it are the same.
    """
    n = new.shape[0]
    turning, Q, half = local_vector(3), local_matrix(6, 6), local_matrix(3, 6)
    for k in range(3):
        i, j = _PAIRS[k]
        gap = values[i] - values[j]
        if abs(gap) > _SAME * size:
            turning[k] = shear * (returned[i] - returned[j]) / gap
        else:
            turning[k] = 0.25 * (D[i, i] - D[i, j] + D[j, j] - D[j, i])
    fill_rotation_matrix(axes, Q)
    for k in range(3):
        for j in range(n):
            half[k, j] = D[k, 0] * Q[j, 0] + D[k, 1] * Q[j, 1] + D[k, 2] * Q[j, 2]
    for i in range(n):
        new[i] = 0.0
        for k in range(3):
            new[i] += Q[i, k] * returned[k]
        for j in range(n):
            total = 0.0
            for k in range(3):
                total += Q[i, k] * half[k, j] + Q[i, 3 + k] * turning[k] * Q[j, 3 + k]
            tangent[i, j] = total
