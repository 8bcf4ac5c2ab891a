"""One time step of soft soil creep for a general stress: stress, consistent tangent and new state from a strain step.

Stress (6,) and strain (6,) as in :mod:`geoswarm.solver.constitutive.tensors`, compression positive. State is ln p_p.

Algorithm
---------
With the secant moduli K and G = ratio K of the exact elastic law between the mean stresses before and after the step,

1. the deviatoric trial stress is T = s_old + 2 G de; creep and Mohr-Coulomb flow are isotropic, so the new stress is
   coaxial with T;
2. on the axes of T the strain equation ``elastic + creep + plastic = given`` is solved for the three principal stresses
   and the multipliers of the active planes by Newton's method (creep implicit at the new stress, equation set in
   :mod:`geoswarm.solver.constitutive.soft_soil_creep.physics`);
3. G depends on the new mean stress: axes and solution are repeated until both agree. An error in the axes changes
   principal values to second order only, so this converges quadratically; coaxial steps need it once.

The tangent is that of this algorithm: the inverse Jacobian of step 2 for the normal components, the rotation of the
axes with T for the shear components, and the dependence of T on the new mean stress through G.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.mohr_coulomb.limit import ACTIVE_SETS, PLANES, principal_planes
from geoswarm.solver.constitutive.soft_soil_creep.physics import SoftSoilCreep, creep_increment, secant_compliance
from geoswarm.solver.constitutive.tensors import principal_axes, rotation_matrix, solve_dense, turned
from geoswarm.solver.kernels.jit import kernel

__all__ = ["creep_update"]

_AXES_PASSES: Final = 25
_ITERATIONS: Final = 60
_RESIDUAL: Final = 1.0e-14
_LARGEST_FALL: Final = 0.2


@kernel
def _strain_and_compliance(
    old: FloatArray,
    new: FloatArray,
    log_time: float,
    log_pp: float,
    soil: SoftSoilCreep,
    strain: FloatArray,
    C: FloatArray,
) -> float:
    """Fill the elastic and creep strain (3,) between principal stresses and its derivative (3, 3); creep volume."""
    p_old, p = (old[0] + old[1] + old[2]) / 3.0, (new[0] + new[1] + new[2]) / 3.0
    q2 = 0.0
    for i in range(3):
        q2 += 1.5 * (new[i] - p) ** 2
    elastic, compliance, compliance_p = secant_compliance(p_old, p, soil)
    tangent = compliance + compliance_p * (p - p_old)
    creep, creep_p, creep_q2, factor, factor_p, factor_q2 = creep_increment(p, q2, log_time, log_pp, soil)
    half = 0.5 / soil.shear_ratio
    for i in range(3):
        s = new[i] - p
        change = s - (old[i] - p_old)
        strain[i] = (elastic + creep) / 3.0 + half * compliance * change + factor * s
        for j in range(3):
            q2_j = 3.0 * (new[j] - p)
            C[i, j] = (
                (tangent + creep_p) / 9.0
                + creep_q2 * q2_j / 3.0
                + half * compliance_p * change / 3.0
                + s * (factor_p / 3.0 + factor_q2 * q2_j)
                - (half * compliance + factor) / 3.0
            )
        C[i, i] += half * compliance + factor
    return creep


@kernel
def _solve_active(
    planes: FloatArray,
    normals: FloatArray,
    flows: FloatArray,
    offsets: FloatArray,
    old: FloatArray,
    given: FloatArray,
    log_time: float,
    log_pp: float,
    soil: SoftSoilCreep,
    new: FloatArray,
    multipliers: FloatArray,
    D: FloatArray,
) -> tuple[float, bool]:
    """Newton's method with a given set of active planes; fills new stress, multipliers and D = d stress/d strain."""
    active = 0
    while active < 3 and planes[active] >= 0:
        active += 1
    n = 3 + active
    strain, C = np.empty(3), np.empty((3, 3))
    matrix, right = np.empty((n, n)), np.empty((n, 4))
    multipliers[:] = 0.0
    shift = soil.shift + soil.extra
    done = False
    for _ in range(_ITERATIONS):
        creep = _strain_and_compliance(old, new, log_time, log_pp, soil, strain, C)
        size = max(abs(new[0]), abs(new[1]), abs(new[2])) + soil.pressure_floor
        worst = 0.0
        matrix[:, :] = 0.0
        right[:, :] = 0.0
        for i in range(3):
            rest = given[i] - strain[i]
            for j in range(3):
                matrix[i, j] = C[i, j]
            for k in range(active):
                matrix[i, 3 + k] = flows[planes[k], i]
                matrix[3 + k, i] = normals[planes[k], i]
                rest -= multipliers[k] * flows[planes[k], i]
            right[i, 0] = rest
            right[i, 1 + i] = 1.0
            worst = max(worst, abs(rest))
        for k in range(active):
            gap = offsets[planes[k]]
            for j in range(3):
                gap -= normals[planes[k], j] * new[j]
            right[3 + k, 0] = gap
            worst = max(worst, 1.0e-2 * abs(gap) / size)
        if not worst < math.inf or not solve_dense(matrix, right):
            return 0.0, False
        if worst <= _RESIDUAL or done:
            for i in range(3):
                for j in range(3):
                    D[i, j] = right[i, 1 + j]
            return creep, True
        fall = (right[0, 0] + right[1, 0] + right[2, 0]) / 3.0
        pressure = (new[0] + new[1] + new[2]) / 3.0 + shift
        step = 1.0
        if pressure > soil.pressure_floor and pressure + fall < _LARGEST_FALL * pressure:
            step = (1.0 - _LARGEST_FALL) * pressure / -fall
        change = 0.0
        for i in range(3):
            new[i] += step * right[i, 0]
            change = max(change, abs(right[i, 0]))
        for k in range(active):
            multipliers[k] += step * right[3 + k, 0]
        # After a step this small the next residual is rounding: evaluate there once more and stop.
        done = step == 1.0 and change <= 1.0e-10 * size
    return 0.0, False


@kernel
def _principal_step(
    old: FloatArray,
    given: FloatArray,
    log_time: float,
    log_pp: float,
    soil: SoftSoilCreep,
    start: FloatArray,
    first: int,
    new: FloatArray,
    D: FloatArray,
) -> tuple[float, int]:
    """Find the set of active planes and its solution; creep volume and the set's number, -1 when there is none.

    ``first`` is tried before all others.
    """
    normals, flows, offsets = principal_planes(soil.cohesion, soil.sin_phi, soil.cos_phi, soil.sin_psi, soil.tension)
    multipliers = np.zeros(3)
    for trial in range(-1, ACTIVE_SETS.shape[0]):
        choice = first if trial < 0 else trial
        if trial == first:
            continue
        planes = ACTIVE_SETS[choice]
        usable = True
        for k in range(3):
            if planes[k] >= 0 and math.isinf(offsets[planes[k]]):
                usable = False
        if not usable:
            continue
        for i in range(3):
            new[i] = start[i]
        creep, converged = _solve_active(
            planes, normals, flows, offsets, old, given, log_time, log_pp, soil, new, multipliers, D
        )
        if not converged:
            continue
        size = max(abs(new[0]), abs(new[1]), abs(new[2])) + soil.pressure_floor
        admissible = True
        for k in range(3):
            if planes[k] >= 0 and multipliers[k] < -1.0e-13:
                admissible = False
        for k in range(PLANES):
            excess = -offsets[k]
            for j in range(3):
                excess += normals[k, j] * new[j]
            if excess > 1.0e-9 * size:
                admissible = False
        if new[0] < new[1] - 1.0e-9 * size or new[1] < new[2] - 1.0e-9 * size:
            admissible = False
        if admissible:
            return creep, choice
    return 0.0, -1


@kernel
def creep_update(
    stress: FloatArray, strain_increment: FloatArray, log_time: float, log_pp: float, soil: SoftSoilCreep
) -> tuple[FloatArray, FloatArray, float, int]:
    """One time step from a strain increment.

    Parameters
    ----------
    stress
        Shape (6,), kPa, before the step.
    strain_increment
        Shape (6,).
    log_time
        ln(dt/tau); -inf for an instantaneous step.
    log_pp
        ln p_p before the step.
    soil
        Constants of the material.

    Returns
    -------
    stress, tangent, log_pp, active
        New stress (6,), d stress/d strain increment of this algorithm (6, 6), new ln p_p, and the number of the active
        planes in :data:`geoswarm.solver.constitutive.mohr_coulomb.limit.ACTIVE_SETS` (0: none). Inputs stay as they
        are. ``active`` is -1 when there is no solution: the step is too large, and the other values mean nothing.
    """
    p_old = (stress[0] + stress[1] + stress[2]) / 3.0
    half = 0.5 / soil.shear_ratio
    mean_strain = (strain_increment[0] + strain_increment[1] + strain_increment[2]) / 3.0
    old, given, start, new = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    T = np.empty(6)
    D = np.empty((3, 3))
    axes = np.empty((3, 3))
    creep, choice = 0.0, int(np.int64(0))  # a number that is written out would have the search compiled once more
    p = p_old
    agreed = False
    for attempt in range(_AXES_PASSES):
        _, compliance, _ = secant_compliance(p_old, p, soil)
        for k in range(6):
            mean, part = (p_old, mean_strain) if k < 3 else (0.0, 0.0)
            share = 1.0 if k < 3 else 0.5
            T[k] = stress[k] - mean + (share * strain_increment[k] - part) / (half * compliance)
        axes = principal_axes(T)[1]
        Q = rotation_matrix(axes)
        for i in range(3):
            old[i], given[i] = 0.0, 0.0
            for k in range(6):
                old[i] += Q[k, i] * stress[k] * (1.0 if k < 3 else 2.0)
                given[i] += Q[k, i] * strain_increment[k]
        for i in range(3):
            start[i] = old[i] if attempt == 0 else new[i]
        creep, choice = _principal_step(old, given, log_time, log_pp, soil, start, choice, new, D)
        if choice < 0:
            return stress.copy(), np.zeros((6, 6)), log_pp, -1
        p_new = (new[0] + new[1] + new[2]) / 3.0
        agreed = abs(p_new - p) <= 1.0e-11 * (abs(p) + soil.shift + soil.pressure_floor)
        coaxial = _shear_on_axes(stress, strain_increment, axes) <= 1.0e-13
        p = p_new
        if agreed or coaxial:
            agreed = True
            break
    if not agreed:
        return stress.copy(), np.zeros((6, 6)), log_pp, -1
    _, compliance, compliance_p = secant_compliance(p_old, p, soil)
    Q = rotation_matrix(axes)
    local = np.zeros((6, 6))
    values = np.zeros(3)
    for i in range(3):
        along = 0.0
        for k in range(6):
            along += Q[k, i] * stress[k] * (1.0 if k < 3 else 2.0)
        values[i] = along - p_old + (given[i] - mean_strain) / (half * compliance)
        for j in range(3):
            local[i, j] = D[i, j]
    size = max(abs(values[0]), abs(values[2])) + soil.pressure_floor
    for k in range(3, 6):
        i, j = (0, 1) if k == 3 else ((1, 2) if k == 4 else (2, 0))
        gap = values[i] - values[j]
        if abs(gap) > 1.0e-7 * size:
            turning = (new[i] - new[j]) / gap
        else:
            turning = 0.5 * half * compliance * (D[i, i] - D[i, j] + D[j, j] - D[j, i])
        sheared = 0.0
        for m in range(6):
            sheared += Q[m, k] * strain_increment[m]
        # The secant shear modulus changes with the new mean stress.
        softening = -0.5 * sheared * compliance_p / (half * compliance * compliance)
        for j2 in range(3):
            local[k, j2] = turning * softening * (D[0, j2] + D[1, j2] + D[2, j2]) / 3.0
        local[k, k] = 0.5 * turning / (half * compliance)
    new_stress = np.zeros(6)
    for k in range(6):
        for i in range(3):
            new_stress[k] += Q[k, i] * new[i]
    return new_stress, turned(Q, local), log_pp + creep / (soil.lambda_star - soil.kappa_star), choice


@kernel
def _shear_on_axes(stress: FloatArray, strain: FloatArray, axes: FloatArray) -> float:
    """Largest shear of stress (relative) and strain increment (relative) on the axes: 0 for a coaxial step."""
    Q = rotation_matrix(axes)
    stress_size, strain_size = 1.0e-300, 1.0e-300
    for k in range(6):
        stress_size = max(stress_size, abs(stress[k]))
        strain_size = max(strain_size, abs(strain[k]))
    worst = 0.0
    for k in range(3, 6):
        shear, gamma = 0.0, 0.0
        i, j = (0, 1) if k == 3 else ((1, 2) if k == 4 else (2, 0))
        for a in range(6):
            gamma += Q[a, k] * strain[a]
        for a in range(3):
            row = axes[a, i]
            for b in range(3):
                index = a if a == b else (3 if a + b == 1 else (4 if a + b == 3 else 5))
                shear += row * stress[index] * axes[b, j]
        worst = max(worst, abs(shear) / stress_size, abs(gamma) / strain_size)
    return worst
