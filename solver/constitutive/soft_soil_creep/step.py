"""One time step of soft soil with or without creep, in a plane or general: the fast way.

Components xx, yy, zz, xy (z is a principal axis) and, in general, yz, zx, compression positive. Where Mohr-Coulomb flow
plays no part, the new deviator is a multiple of the trial deviator, so the step is two equations in mean stress p and
deviatoric stress q. Its result is that of
:func:`geoswarm.solver.constitutive.soft_soil_creep.general_update.creep_update`, which takes over where the limit is
reached.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.soft_soil_creep.general_update import creep_update
from geoswarm.solver.constitutive.soft_soil_creep.physics import (
    SoftSoilCreep,
    creep_increment,
    equivalent_pressure,
    secant_compliance,
)
from geoswarm.solver.constitutive.tensors import principal_axes
from geoswarm.solver.kernels.jit import inlined, kernel

__all__ = ["soft_soil_step"]

_ITERATIONS: Final = 40
_RESIDUAL: Final = 1.0e-13
_LARGEST_FALL: Final = 0.2
_LARGEST_RISE: Final = 2.0
"""Of ln p, where a step begins beyond the yield surface."""
_EXCESS: Final = 1.0e-9
_HALVINGS: Final = 60


@kernel
def _at_pressure(
    x: float,
    p_old: float,
    volume: float,
    deviator: tuple[float, float, float],
    log_time: float,
    log_pp: float,
    soil: SoftSoilCreep,
) -> tuple[float, float]:
    """Volume strain that is left over at the pressure exp(x), and the q there: that at which the deviators agree."""
    old_old, old_new, new_new = deviator
    p = math.exp(x) - soil.shift - soil.extra
    elastic, compliance, _ = secant_compliance(p_old, p, soil)
    twice = 2.0 * soil.shear_ratio / compliance
    trial = math.sqrt(max(old_old + twice * (2.0 * old_new + twice * new_new), 0.0))
    low, q, creep = 0.0, trial, 0.0
    high = trial
    for _ in range(_HALVINGS):
        creep, _, _, factor, _, _ = creep_increment(p, q * q, log_time, log_pp, soil)
        if (1.0 + twice * factor) * q > trial:
            high = q
        else:
            low = q
        q = 0.5 * (low + high)
    return volume - elastic - creep, q


@kernel
def _enclosed(
    p_old: float,
    volume: float,
    deviator: tuple[float, float, float],
    log_time: float,
    log_pp: float,
    soil: SoftSoilCreep,
) -> tuple[float, float]:
    """p and q of a step by halving intervals, where Newton's method swings about a sharp yield surface."""
    x = math.log(max(p_old + soil.shift + soil.extra, soil.pressure_floor))
    left, q = _at_pressure(x, p_old, volume, deviator, log_time, log_pp, soil)
    way = 1.0 if left > 0.0 else -1.0
    low, high = x, x
    for _ in range(_HALVINGS):
        high = low + way
        left, q = _at_pressure(high, p_old, volume, deviator, log_time, log_pp, soil)
        if not left * way > 0.0:
            break
        low = high
    for _ in range(_HALVINGS):
        x = 0.5 * (low + high)
        left, q = _at_pressure(x, p_old, volume, deviator, log_time, log_pp, soil)
        if left * way > 0.0:
            low = x
        else:
            high = x
    return math.exp(x) - soil.shift - soil.extra, q


@kernel
def _creep_alone(
    stress: FloatArray,
    strain_increment: FloatArray,
    log_time: float,
    log_pp: float,
    soil: SoftSoilCreep,
    new: FloatArray,
    tangent: FloatArray,
) -> tuple[float, bool]:
    """Step without Mohr-Coulomb flow; creep volume, and whether Newton's method found it."""
    p_old = (stress[0] + stress[1] + stress[2]) / 3.0
    volume = strain_increment[0] + strain_increment[1] + strain_increment[2]
    n = stress.shape[0]
    old_old, old_new, new_new = 0.0, 0.0, 0.0
    for i in range(n):
        share = 1.0 if i < 3 else 2.0
        s = stress[i] - p_old if i < 3 else stress[i]
        e = strain_increment[i] - volume / 3.0 if i < 3 else 0.5 * strain_increment[i]
        old_old += share * s * s
        old_new += share * s * e
        new_new += share * e * e
    old_old *= 1.5
    old_new *= 1.5
    new_new *= 1.5
    p, q = p_old, math.sqrt(old_old)
    shift = soil.shift + soil.extra
    if soil.mu_star == 0.0 and p + shift > soil.pressure_floor:
        # From the elastic side Newton's method swings about the yield surface: begin on the other one, where the step
        # leads beyond it at a constant ratio of stresses.
        beyond = math.log(equivalent_pressure(p, q * q, soil)[0]) - log_pp
        rise = (volume - (soil.lambda_star - soil.kappa_star) * beyond) / soil.lambda_star
        if 0.0 < rise < _LARGEST_RISE and rise + beyond > 0.0:
            grown = math.exp(rise)
            p, q = grown * (p + shift) - shift, grown * q
    done = False
    twice, twice_p, trial = 0.0, 0.0, 0.0
    creep, factor, factor_p, factor_q2 = 0.0, 0.0, 0.0, 0.0
    a11, a12, a21, a22, determinant = 1.0, 0.0, 0.0, 1.0, 1.0
    for iteration in range(2 * _ITERATIONS):
        if iteration == _ITERATIONS:
            p, q = _enclosed(p_old, volume, (old_old, old_new, new_new), log_time, log_pp, soil)
        elastic, compliance, compliance_p = secant_compliance(p_old, p, soil)
        creep, creep_p, creep_q2, factor, factor_p, factor_q2 = creep_increment(p, q * q, log_time, log_pp, soil)
        twice = 2.0 * soil.shear_ratio / compliance
        twice_p = -twice * compliance_p / compliance
        trial = math.sqrt(max(old_old + twice * (2.0 * old_new + twice * new_new), 0.0))
        trial_p = (old_new + twice * new_new) / trial * twice_p if trial > 0.0 else 0.0
        scale = 1.0 + twice * factor
        r1 = volume - elastic - creep
        r2 = trial - scale * q
        a11 = compliance + compliance_p * (p - p_old) + creep_p
        a12 = 2.0 * q * creep_q2
        a21 = q * (twice_p * factor + twice * factor_p) - trial_p
        a22 = scale + q * twice * factor_q2 * 2.0 * q
        determinant = a11 * a22 - a12 * a21
        worst = max(abs(r1), abs(r2) / twice)
        if not (worst < math.inf and abs(determinant) > 0.0):
            return 0.0, False
        if worst <= _RESIDUAL or done:
            break
        if iteration == (_ITERATIONS - 1 if soil.mu_star > 0.0 else 2 * _ITERATIONS - 1):
            return 0.0, False
        dp = (r1 * a22 - a12 * r2) / determinant
        dq = (a11 * r2 - a21 * r1) / determinant
        pressure = p + shift
        step = 1.0
        if pressure > soil.pressure_floor and pressure + dp < _LARGEST_FALL * pressure:
            step = (1.0 - _LARGEST_FALL) * pressure / -dp
        if q + step * dq < 0.0:
            dq = -0.5 * q / step
        p += step * dp
        q += step * dq
        done = step == 1.0 and abs(dp) + abs(dq) <= 1.0e-10 * (abs(p) + q + soil.pressure_floor)
    scale = 1.0 + twice * factor
    # d(p, q) = inverse (a) of d volume and of 3/2 (2G/trial) T : d strain.
    of_trial = 1.5 * twice / trial if trial > 0.0 else 0.0
    p_v, p_t = a22 / determinant, -a12 / determinant * of_trial
    q_v, q_t = -a21 / determinant, a11 / determinant * of_trial
    by_p = -(twice_p * factor + twice * factor_p) / (scale * scale)
    by_q = -twice * factor_q2 * 2.0 * q / (scale * scale)
    for i in range(n):
        e_i = strain_increment[i] - volume / 3.0 if i < 3 else 0.5 * strain_increment[i]
        T_i = (stress[i] - p_old if i < 3 else stress[i]) + twice * e_i
        one = 1.0 if i < 3 else 0.0
        new[i] = T_i / scale + p if i < 3 else T_i / scale
        along_p = one + twice_p * e_i / scale + by_p * T_i
        along_q = by_q * T_i
        volume_part = along_p * p_v + along_q * q_v
        trial_part = along_p * p_t + along_q * q_t
        for j in range(n):
            e_j = strain_increment[j] - volume / 3.0 if j < 3 else 0.5 * strain_increment[j]
            T_j = (stress[j] - p_old if j < 3 else stress[j]) + twice * e_j
            value = trial_part * T_j
            if j < 3:
                value += volume_part
                if i < 3:
                    value -= twice / scale / 3.0
            if i == j:
                value += twice / scale * (1.0 if i < 3 else 0.5)
            tangent[i, j] = value
    return creep, True


@inlined
def soft_soil_step(
    stress: FloatArray,
    strain_increment: FloatArray,
    log_time: float,
    log_pp: float,
    soil: SoftSoilCreep,
    new: FloatArray,
    tangent: FloatArray,
) -> tuple[float, int]:
    """One time step.

    Parameters
    ----------
    stress, strain_increment
        Shape (n,), n = 4 or 6: kPa, and strain with engineering shear; they stay as they are.
    log_time, log_pp, soil
        As for :func:`geoswarm.solver.constitutive.soft_soil_creep.general_update.creep_update`.
    new, tangent
        Filled: stress (n,) and d stress/d strain increment of this algorithm (n, n).

    Returns
    -------
    log_pp, active
        New ln p_p; number of the active planes, 0 for none, -1 when there is no solution.
    """
    n = stress.shape[0]
    creep, found = _creep_alone(stress, strain_increment, log_time, log_pp, soil, new, tangent)
    if found:
        if n == 4:
            centre, half = 0.5 * (new[0] + new[1]), 0.5 * (new[0] - new[1])
            radius = math.sqrt(half * half + new[3] * new[3])
            largest, smallest = max(centre + radius, new[2]), min(centre - radius, new[2])
        else:
            values = principal_axes(new)[0]
            largest, smallest = values[0], values[2]
        excess = largest * (1.0 - soil.sin_phi) - smallest * (1.0 + soil.sin_phi) - 2.0 * soil.cohesion * soil.cos_phi
        size = max(abs(largest), abs(smallest)) + soil.pressure_floor
        if excess <= _EXCESS * size and -smallest <= soil.tension + _EXCESS * size:
            return log_pp + creep / (soil.lambda_star - soil.kappa_star), 0
    old6, strain6 = np.zeros(6), np.zeros(6)
    for i in range(n):
        old6[i], strain6[i] = stress[i], strain_increment[i]
    new6, tangent6, new_pp, active = creep_update(old6, strain6, log_time, log_pp, soil)
    for i in range(n):
        new[i] = new6[i]
        for j in range(n):
            tangent[i, j] = tangent6[i, j]
    return new_pp, active
