"""Modified Cam clay: one step of stress, with its consistent tangent, for a plane or a general stress.

Compression positive, kPa. Notation: p mean stress, s deviator, q = sqrt(3/2 s:s), eta = q/p, e void ratio, v = 1 + e.
Sources: Roscoe & Burland (1968), "On the generalised stress-strain behaviour of wet clay"; Wood (1990), "Soil behaviour
and critical state soil mechanics", chapter 5; implicit integration: Borja & Lee (1990), CMAME 78, 49-72, and Borja
(1991), CMAME 88, 225-240, for the stress-dependent elastic moduli.

::

    p + q^2/(M^2 p) <= p_c                                   yield surface, an ellipse through the origin
    dv = -kappa dp/p - (lambda - kappa) dp_c/p_c             swelling line and hardening
    de^p = gamma d(p + q^2/(M^2 p))/d sigma                  associated flow: d eps_v^p = gamma (1 - eta^2/M^2)
    ds = 2 G de^e                                            G = r K with K = v p/kappa (constant nu), or constant G

Volumes are integrated without error: of a step's change of specific volume, ``change`` = v (1 - exp(-d eps_v)) (or v0
d eps_v where v stays the initial one), P = change - kappa x is plastic, x = ln(p/p_old). With G taken at the
logarithmic mean of both pressures and flow at the end of the step, hardening gives x in terms of eta, and one equation
for eta is left::

    lambda x = change + (lambda - kappa) (ln(p_c_old/p_old) - ln(1 + eta^2/M^2))
    H(eta) = eta alpha + 3 eta B P/(M^2 p) - alpha T/p = 0,  alpha = 1 - eta^2/M^2,  B = 2 G/mean v

with T the deviatoric stress of the elastic trial. H grows from below 0 to above 0 between M and the eta at which yield
begins at the elastic pressure: there is a root for every step, however large.
"""

from __future__ import annotations

import math
from typing import Final

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.kernels.jit import kernel, kernel_in_place

__all__ = ["cam_clay_step", "log_ratio"]

_ITERATIONS: Final = 100
_EXCESS: Final = 1.0e-12
_LARGEST_POWER: Final = 200.0
"""ln of the largest change of pressure in one step."""
_CLOSE: Final = 1.0e-9
"""After a correction of eta as small as this, the next one is rounding."""


_SERIES_LIMIT = 1.0e-3


@kernel
def cam_clay_step(
    stress: FloatArray,
    strain: FloatArray,
    preconsolidation: float,
    void_ratio: float,
    slope: float,
    stiff: float,
    soft: float,
    shear_ratio: float,
    shear: float,
    volume: float,
    new: FloatArray,
    tangent: FloatArray,
) -> tuple[float, float, int]:
    """One step.

    Parameters
    ----------
    stress, strain
        (n,), n = 4 or 6: kPa, and strain increment with engineering shear; they stay as they are.
    preconsolidation, void_ratio
        p_c, kPa, and e before the step.
    slope, stiff, soft
        M, lambda and kappa.
    shear_ratio, shear
        G/K, or 0 and the constant G, kPa.
    volume
        Specific volume that strains refer to; 0: the present one.
    new, tangent
        Filled: stress (n,), and d stress/d strain of this algorithm (n, n).

    Returns
    -------
    p_c, e, status
        At the end; 0: elastic, 1: at yield, -1: no stress for this step, which is too large, or for this state.
    """
    n = stress.shape[0]
    p_old = (stress[0] + stress[1] + stress[2]) / 3.0
    dilation = strain[0] + strain[1] + strain[2]
    v_old = 1.0 + void_ratio
    if not (p_old > 0.0 and preconsolidation > 0.0 and void_ratio > 0.0):
        return preconsolidation, void_ratio, -1
    # Change of volume, its derivative, mean specific volume and its derivative by the volume strain.
    change, after, mean, mean_v = volume * dilation, volume, volume, 0.0
    if volume == 0.0:
        change = -v_old * math.expm1(-dilation)
        after = v_old - change
        if abs(dilation) < 1.0e-4:
            mean = v_old * (1.0 - dilation * (0.5 - dilation * (1.0 / 6.0 - dilation / 24.0)))
            mean_v = v_old * (-0.5 + dilation * (1.0 / 3.0 - dilation * (0.125 - dilation / 30.0)))
        else:
            mean = change / dilation
            mean_v = (after - mean) / dilation
    e = void_ratio - change
    power = change / soft
    if not (e > 0.0 and power > -_LARGEST_POWER and change < _LARGEST_POWER * stiff):
        return preconsolidation, void_ratio, -1
    # (old : old), (old : step) and (step : step) of the deviators, times 3/2.
    old_old, old_step, step_step = 0.0, 0.0, 0.0
    for i in range(n):
        s = stress[i] - (p_old if i < 3 else 0.0)
        d = strain[i] - dilation / 3.0 if i < 3 else 0.5 * strain[i]
        share = 1.5 if i < 3 else 3.0
        old_old += share * s * s
        old_step += share * s * d
        step_step += share * d * d
    M2 = slope * slope
    past = math.log(preconsolidation / p_old)
    low, high, eta = 0.0, slope, 0.0
    yielding = True
    if power < _LARGEST_POWER:
        p = p_old * math.exp(power)
        two_G = _twice_shear(p_old, p, soft, shear_ratio, shear, mean)[0]
        trial = math.sqrt(max(old_old + two_G * (2.0 * old_step + two_G * step_step), 0.0))
        eta = trial / p
        yielding = power + math.log1p(eta * eta / M2) > past + _EXCESS
        if past > power:
            first = slope * math.sqrt(math.expm1(past - power))
            low, high = min(first, slope), max(first, slope)
    # The elastic trial is the first guess of eta as far as the bracket admits it.
    eta = min(max(eta, low), high)
    p, two_G, two_G_p, trial, plastic, alpha, eta_x, Z = p_old, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0
    total, done = 1.0, False
    for iteration in range(_ITERATIONS):
        x = power
        if yielding:
            x = (change + (stiff - soft) * (past - math.log1p(eta * eta / M2))) / stiff
        p = p_old * math.exp(x)
        two_G, two_G_p = _twice_shear(p_old, p, soft, shear_ratio, shear, mean)
        trial = math.sqrt(max(old_old + two_G * (2.0 * old_step + two_G * step_step), 0.0))
        if not yielding:
            break
        plastic = change - soft * x
        alpha = 1.0 - eta * eta / M2
        B, weight = two_G / mean, 3.0 * eta / (M2 * p)
        H = eta * alpha + weight * B * plastic - alpha * trial / p
        trial_p = (old_step + two_G * step_step) / trial * two_G_p if trial > 0.0 else 0.0
        eta_x = -(stiff - soft) / stiff * 2.0 * eta / (M2 + eta * eta)
        # d H/dx at constant eta: plastic volume, modulus, pressure and trial.
        Z = -soft * weight * B + weight * plastic * two_G_p / mean * p
        Z += (alpha * trial / p - weight * B * plastic) - alpha * trial_p
        total = alpha - 2.0 * eta * eta / M2 + 3.0 * B * plastic / (M2 * p) + 2.0 * eta / M2 * trial / p + eta_x * Z
        if done:
            break
        if H < 0.0:
            low = eta
        else:
            high = eta
        following = eta - H / total
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if iteration == _ITERATIONS - 1:
            return preconsolidation, void_ratio, -1
        done = abs(following - eta) <= _CLOSE * (slope + eta)
        eta = following
    q = eta * p if yielding else trial
    ratio = 1.0
    if yielding:
        ratio = q / trial if trial > 0.0 else 1.0 / (1.0 + 3.0 * two_G / mean * plastic / (M2 * p))
    if not (0.0 < p < math.inf and abs(total) > 0.0 and q < math.inf):
        return preconsolidation, void_ratio, -1
    # d p and d q by the volume strain (_v) and by the trial through the deviatoric strain (_t).
    two_G_v = 0.0 if shear_ratio == 0.0 else two_G * mean_v / mean
    inverse = 1.0 / trial if trial > 0.0 else 0.0
    growth = (old_step + two_G * step_step) * inverse
    if yielding:
        weight = 3.0 * eta / (M2 * p)
        B_v = two_G_v / mean - two_G * mean_v / (mean * mean)
        H_v = weight * two_G / mean * after + after / stiff * Z + weight * plastic * B_v - alpha / p * growth * two_G_v
        eta_v, eta_t = -H_v / total, alpha / p / total
        p_v, p_t = p * (eta_x * eta_v + after / stiff), p * eta_x * eta_t
        q_v, q_t = p * eta_v + eta * p_v, p * eta_t + eta * p_t
        ratio_v = inverse * (q_v - ratio * growth * (two_G_p * p_v + two_G_v))
        ratio_t = inverse * (q_t - ratio * (1.0 + growth * two_G_p * p_t))
    else:
        p_v, p_t, ratio_v, ratio_t = p * after / soft, 0.0, 0.0, 0.0
    for i in range(n):
        one = 1.0 if i < 3 else 0.0
        d_i = strain[i] - dilation / 3.0 if i < 3 else 0.5 * strain[i]
        T_i = stress[i] - p_old * one + two_G * d_i
        new[i] = one * p + ratio * T_i
        by_volume = one * p_v + ratio * d_i * (two_G_p * p_v + two_G_v) + T_i * ratio_v
        by_trial = (one * p_t + ratio * d_i * two_G_p * p_t + T_i * ratio_t) * 1.5 * two_G * inverse
        for j in range(n):
            d_j = strain[j] - dilation / 3.0 if j < 3 else 0.5 * strain[j]
            T_j = stress[j] - (p_old if j < 3 else 0.0) + two_G * d_j
            value = by_trial * T_j
            if j < 3:
                value += by_volume - ratio * two_G * one / 3.0
            if i == j:
                value += ratio * two_G * (1.0 if i < 3 else 0.5)
            tangent[i, j] = value
    return preconsolidation * math.exp(plastic / (stiff - soft)), e, 1 if yielding else 0


@kernel
def _twice_shear(
    p_old: float, p: float, soft: float, shear_ratio: float, shear: float, mean: float
) -> tuple[float, float]:
    """2 G between two pressures and its derivative by the second one."""
    if shear_ratio == 0.0:
        return 2.0 * shear, 0.0
    ratio, bend = log_ratio((p - p_old) / p_old)
    factor = 2.0 * shear_ratio * mean / soft
    return factor * p_old / ratio, -factor * bend / (ratio * ratio)


@kernel_in_place
def log_ratio(d: float) -> tuple[float, float]:
    """ln(1 + d)/d and its derivative by d, without loss of digits near 0.

    With d = (p - p_old)/p_old, p_old over it is the logarithmic mean of both pressures, (p - p_old)/ln(p/p_old).
    """
    if abs(d) < _SERIES_LIMIT:
        ratio = 1.0 + d * (-1 / 2 + d * (1 / 3 + d * (-1 / 4 + d * (1 / 5 - d / 6))))
        slope = -1 / 2 + d * (2 / 3 + d * (-3 / 4 + d * (4 / 5 + d * (-5 / 6 + d * 6 / 7))))
    else:
        ratio = math.log1p(d) / d
        slope = (1.0 / (1.0 + d) - ratio) / d
    return ratio, slope
