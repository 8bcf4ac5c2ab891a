"""What returns on principal axes have in common: the elastic trial before, and stress components after them.

Components xx, yy, zz, xy and, in general, yz, zx, compression positive. Limits and flow are isotropic, so that the new
stress has the axes of the elastic trial stress.
"""

from __future__ import annotations

from typing import Final

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.local_arrays import local_matrix, local_vector
from geoswarm.solver.constitutive.tensors import fill_rotation_matrix
from geoswarm.solver.kernels.jit import kernel, kernel_in_place

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
def _along(axes: FloatArray, k: int) -> int:
    """Coordinate along which the axis in column k is, where they are unturned; -1 where they are turned."""
    for m in range(3):
        if axes[m, k] == 1.0:
            return m
    return -1


@kernel_in_place
def _put_back(
    returned: FloatArray,
    D: FloatArray,
    turning: FloatArray,
    places: tuple[int, int, int],
    new: FloatArray,
    tangent: FloatArray,
) -> None:
    """What :func:`turned_back` fills where the principal axes are the coordinates ``places``: no sums."""
    n = new.shape[0]
    for i in range(n):
        new[i] = 0.0
        for j in range(n):
            tangent[i, j] = 0.0
    for k in range(3):
        new[places[k]] = returned[k]
        for m in range(3):
            tangent[places[k], places[m]] = D[k, m]
    for k in range(3):
        i, j = _PAIRS[k]
        low, high = min(places[i], places[j]), max(places[i], places[j])
        shear = 3 if high == 1 else (4 if low == 1 else 5)
        if shear < n:
            tangent[shear, shear] = turning[k]


@kernel_in_place
def turned_back(
    values: FloatArray,
    returned: FloatArray,
    D: FloatArray,
    axes: FloatArray,
    shear: float,
    size: float,
    new: FloatArray,
    tangent: FloatArray,
) -> bool:
    """Fill stress components (n,) and tangent (n, n) from principal stresses; whether the axes are the coordinates.

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
    places = (_along(axes, 0), _along(axes, 1), _along(axes, 2))
    if min(places) >= 0:
        _put_back(returned, D, turning, places, new, tangent)
        return True
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
    return False
