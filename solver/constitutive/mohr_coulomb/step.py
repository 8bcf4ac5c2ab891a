"""Linear elasticity with the Mohr-Coulomb limit: one step of stress with its consistent tangent.

Compression positive. In a plane the components are xx, yy, zz, xy, and z is a principal axis (plane strain,
axisymmetry); yz and zx follow for a general stress. The elastic trial stress is returned to the limit on its own
principal axes, exactly: planes, edges, apex and tension cut-off are the active sets of
:mod:`geoswarm.solver.constitutive.mohr_coulomb.limit`.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.mohr_coulomb.limit import ACTIVE_SETS, PLANES, principal_planes
from geoswarm.solver.constitutive.principal_return import elastic_trial, turned_back
from geoswarm.solver.constitutive.tensors import principal_axes, solve_dense
from geoswarm.solver.kernels.jit import inlined, kernel

__all__ = ["general_mohr_coulomb", "planar_mohr_coulomb", "return_to_limit"]

_EXCESS: Final = 1.0e-9


@kernel
def return_to_limit(
    trial: FloatArray,
    bulk: float,
    shear: float,
    cohesion: float,
    sin_phi: float,
    cos_phi: float,
    sin_psi: float,
    tension: float,
    new: FloatArray,
    D: FloatArray,
) -> bool:
    """Return sorted principal trial stresses (3,) to the limit; fill new stresses and d new/d strain (3, 3)."""
    normals, flows, offsets = principal_planes(cohesion, sin_phi, cos_phi, sin_psi, tension)
    lame = bulk - 2.0 / 3.0 * shear
    stiff_flow, normal_stiff = np.empty((3, 3)), np.empty((3, 3))
    size = max(abs(trial[0]), abs(trial[2])) + cohesion + 1.0e-6
    for choice in range(1, ACTIVE_SETS.shape[0]):
        active = 0
        usable = True
        while active < 3 and ACTIVE_SETS[choice, active] >= 0:
            if math.isinf(offsets[ACTIVE_SETS[choice, active]]):
                usable = False
            active += 1
        if not usable:
            continue
        matrix, right = np.empty((active, active)), np.empty((active, 4))
        for k in range(active):
            plane = ACTIVE_SETS[choice, k]
            volume = flows[plane, 0] + flows[plane, 1] + flows[plane, 2]
            along = normals[plane, 0] + normals[plane, 1] + normals[plane, 2]
            right[k, 3] = -offsets[plane]
            for i in range(3):
                stiff_flow[k, i] = lame * volume + 2.0 * shear * flows[plane, i]
                normal_stiff[k, i] = lame * along + 2.0 * shear * normals[plane, i]
                right[k, i] = normal_stiff[k, i]
                right[k, 3] += normals[plane, i] * trial[i]
        for k in range(active):
            for m in range(active):
                matrix[k, m] = 0.0
                for i in range(3):
                    matrix[k, m] += normals[ACTIVE_SETS[choice, k], i] * stiff_flow[m, i]
        if not solve_dense(matrix, right):
            continue
        admissible = True
        for k in range(active):
            if not right[k, 3] >= -_EXCESS * size / shear:
                admissible = False
        if not admissible:
            continue
        for i in range(3):
            new[i] = trial[i]
            for k in range(active):
                new[i] -= right[k, 3] * stiff_flow[k, i]
        for k in range(PLANES):
            excess = -offsets[k]
            for i in range(3):
                excess += normals[k, i] * new[i]
            if excess > _EXCESS * size:
                admissible = False
        if new[0] < new[1] - _EXCESS * size or new[1] < new[2] - _EXCESS * size:
            admissible = False
        if not admissible:
            continue
        for i in range(3):
            for j in range(3):
                D[i, j] = lame + (2.0 * shear if i == j else 0.0)
                for k in range(active):
                    D[i, j] -= stiff_flow[k, i] * right[k, j]
        return True
    # At the apex all six shear planes meet, three more than sorted stresses have: what no other set returns ends there.
    attraction = cohesion * cos_phi / sin_phi if sin_phi > 0.0 else math.inf
    if attraction < math.inf and attraction <= tension:
        for i in range(3):
            new[i] = -attraction
            for j in range(3):
                D[i, j] = 0.0
        return True
    return False


@inlined
def planar_mohr_coulomb(
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
    """One step of stress.

    Parameters
    ----------
    stress, strain_increment
        Shape (4,): kPa, and strain with engineering shear; they stay as they are.
    bulk, shear, cohesion, tension
        kPa; ``tension`` inf switches the tension cut-off off.
    sin_phi, cos_phi, sin_psi
        Of friction and dilatancy angle.
    new, tangent
        Filled: stress (4,) and d stress/d strain increment of this algorithm (4, 4).

    Returns
    -------
    int
        0: elastic; 1: at the limit; -1: no admissible return was found.
    """
    lame = bulk - 2.0 / 3.0 * shear
    volume = strain_increment[0] + strain_increment[1] + strain_increment[2]
    for i in range(3):
        new[i] = stress[i] + lame * volume + 2.0 * shear * strain_increment[i]
        for j in range(3):
            tangent[i, j] = lame
        tangent[i, i] += 2.0 * shear
        tangent[i, 3], tangent[3, i] = 0.0, 0.0
    new[3] = stress[3] + shear * strain_increment[3]
    tangent[3, 3] = shear
    centre, half = 0.5 * (new[0] + new[1]), 0.5 * (new[0] - new[1])
    radius = math.sqrt(half * half + new[3] * new[3])
    largest, smallest = max(centre + radius, new[2]), min(centre - radius, new[2])
    excess = largest * (1.0 - sin_phi) - smallest * (1.0 + sin_phi) - 2.0 * cohesion * cos_phi
    size = max(abs(largest), abs(smallest)) + cohesion
    if excess <= 1.0e-12 * size and -smallest <= tension + 1.0e-12 * size:
        return 0
    # Places of the principal axes (two in the plane, major first, then z) among the sorted ones.
    major, minor, out = 0, 1, 2
    if new[2] > centre + radius:
        major, minor, out = 1, 2, 0
    elif new[2] > centre - radius:
        major, minor, out = 0, 2, 1
    trial, sorted_new, D = np.empty(3), np.empty(3), np.empty((3, 3))
    trial[major], trial[minor], trial[out] = centre + radius, centre - radius, new[2]
    if not return_to_limit(trial, bulk, shear, cohesion, sin_phi, cos_phi, sin_psi, tension, sorted_new, D):
        return -1
    cosine2, sine2 = (half / radius, new[3] / radius) if radius > 0.0 else (1.0, 0.0)
    a, b = sorted_new[major], sorted_new[minor]
    new[0] = 0.5 * (a + b) + 0.5 * (a - b) * cosine2
    new[1] = 0.5 * (a + b) - 0.5 * (a - b) * cosine2
    new[2] = sorted_new[out]
    new[3] = 0.5 * (a - b) * sine2
    if radius > 1.0e-9 * size:
        turning = shear * 0.5 * (a - b) / radius
    else:
        turning = 0.25 * (D[major, major] - D[major, minor] + D[minor, minor] - D[minor, major])
    local = np.zeros((4, 4))
    places = (major, minor, out)
    for i in range(3):
        for j in range(3):
            local[i, j] = D[places[i], places[j]]
    local[3, 3] = turning
    Q = np.zeros((4, 4))
    c2, s2, cs = 0.5 * (1.0 + cosine2), 0.5 * (1.0 - cosine2), 0.5 * sine2
    Q[0, 0], Q[0, 1], Q[0, 3] = c2, s2, -2.0 * cs
    Q[1, 0], Q[1, 1], Q[1, 3] = s2, c2, 2.0 * cs
    Q[2, 2] = 1.0
    Q[3, 0], Q[3, 1], Q[3, 3] = cs, -cs, cosine2
    for i in range(4):
        for j in range(4):
            total = 0.0
            for k in range(4):
                if Q[i, k] != 0.0:
                    for m in range(4):
                        total += Q[i, k] * local[k, m] * Q[j, m]
            tangent[i, j] = total
    return 1


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
