"""The scalar functions of Masin's hypoplastic law for clay, and their derivatives.

Compression positive; t = sigma/tr(sigma), s its deviator, d the strain rate, p the mean stress, p_r = 1 kPa::

    rate of sigma = f_s L:d - (f_d/f_dA) (f_s L:n - sigma tr(n)/lambda*) |d|
    L = 1 + nu/(1 - 2 nu) 1 x 1,   f_s = (3 p/2) (1/lambda* + 1/kappa*) (1 - 2 nu)/(1 + nu)
    f_d = (2 p/p_e)^alpha,   p_e = p_r exp((N - ln(1 + e))/lambda*)
    f_dA = 2^alpha (1 - F_m)^(alpha/omega)
    alpha = ln((lambda* - kappa*)/(lambda* + kappa*) (3 + a^2)/(sqrt(3) a))/ln(2),   a as for sand
    omega = -ln(cos^2(phi_c))/ln(2) + 0.3 (F_m - sin^2(phi_c))
    n: the unit tensor of s + zeta 1, the direction of strain in which f_d = f_dA goes on with a constant stress ratio
    zeta = (2/3 - (cos(3 theta) + 1)/4 F_m^(1/4)) (sin^xi(phi_c) - F_m^(xi/2))/(1 - sin^xi(phi_c))
    xi = 1.7 + 3.9 sin^2(phi_c)
    F_m = (9 I3 - I1 I2)/(I3 - I1 I2), sin^2 of the friction angle that Matsuoka and Nakai ascribe to the stress

D. Masin (2013), Clay hypoplasticity with explicitly defined asymptotic states, Acta Geotechnica 8, 481-496.
"""

from __future__ import annotations

import math
from typing import Final

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.kernels.jit import kernel_in_place

__all__ = ["CLAY_CONSTANTS", "SHAPE", "clay_functions"]

CLAY_CONSTANTS: Final = 9
"""From place ``first`` on: f_s/tr(sigma), nu/(1 - 2 nu), lambda*, N, alpha, sin(phi_c), omega at phi_c, xi,
sin^xi(phi_c)."""

SHAPE: Final = 0.3
"""Change of omega with F_m."""

_LEAST_FRICTION: Final = 1.0e-20


@kernel_in_place
def clay_functions(
    trace: float, j: float, k: float, log_v: float, constants: FloatArray, first: int, f: FloatArray, slopes: FloatArray
) -> bool:
    """Fill the functions of the law and their derivatives, as :func:`sand_functions` does, from ln(1 + e)."""
    lateral, slope, alpha = constants[first + 1], constants[first + 2], constants[first + 4]
    sine, xi = constants[first + 5], constants[first + 7]
    below = 8.0 / 27.0 - (j + k) / 3.0
    if not below > 0.0:
        return False
    inverse = 1.0 / below
    F = (j - 3.0 * k) * inverse
    if not F < 1.0:
        return False
    # zeta and F_m with their derivatives by j and k.
    power = constants[first + 8]
    share = 1.0 / (1.0 - power)
    zeta, zeta_j, zeta_k, F_j, F_k = 2.0 / 3.0 * power * share, 0.0, 0.0, 0.0, 0.0
    if F > _LEAST_FRICTION:
        by_F, by_j = 1.0 / F, 1.0 / j
        F_j, F_k = (1.0 + F / 3.0) * inverse, (F / 3.0 - 3.0) * inverse
        cube = by_j * math.sqrt(6.0 * by_j)
        lode, lode_j, lode_k = 0.25 - 0.25 * cube * k, 0.375 * cube * k * by_j, -0.25 * cube
        fourth = math.sqrt(math.sqrt(F))
        mobilised = math.exp(0.5 * xi * math.log(F))
        left, right = 2.0 / 3.0 - lode * fourth, (power - mobilised) * share
        left_F, right_F = -0.25 * lode * fourth * by_F, -0.5 * xi * mobilised * by_F * share
        zeta = left * right
        zeta_j = (left_F * F_j - lode_j * fourth) * right + left * right_F * F_j
        zeta_k = (left_F * F_k - lode_k * fourth) * right + left * right_F * F_k
    else:
        F = 0.0
    # f_d/f_dA over the norm of s + zeta 1, and the derivatives of its logarithm.
    omega, log_rest = constants[first + 6] + SHAPE * (F - sine * sine), math.log(1.0 - F)
    by_norm2, by_omega, by_slope = 1.0 / (j + 3.0 * zeta * zeta), 1.0 / omega, 1.0 / slope
    ratio = math.exp(alpha * (math.log(trace / 3.0) - (constants[first + 3] - log_v) * by_slope - log_rest * by_omega))
    ratio *= math.sqrt(by_norm2)
    of_F = alpha * by_omega * (1.0 / (1.0 - F) + log_rest * SHAPE * by_omega)
    ratio_j = of_F * F_j - (0.5 + 3.0 * zeta * zeta_j) * by_norm2
    ratio_k = of_F * F_k - 3.0 * zeta * zeta_k * by_norm2
    f_s, whole = constants[first] * trace, 1.0 + 3.0 * lateral
    f[0], f[1], f[2] = f_s, f_s * lateral, 0.0
    f[3] = ratio * f_s * (zeta * whole - 1.0 / 3.0)
    f[4] = ratio * (f_s - 3.0 * zeta * trace * by_slope)
    for i in range(3):
        slopes[i, 0], slopes[i, 1], slopes[i, 2], slopes[i, 3] = f[i], 0.0, 0.0, 0.0
    for i in range(3, 5):
        by_zeta = ratio * (f_s * whole if i == 3 else -3.0 * trace * by_slope)
        slopes[i, 0] = (1.0 + alpha) * f[i]
        slopes[i, 1] = f[i] * ratio_j + by_zeta * zeta_j
        slopes[i, 2] = f[i] * ratio_k + by_zeta * zeta_k
        slopes[i, 3] = f[i] * alpha * by_slope
    return True
