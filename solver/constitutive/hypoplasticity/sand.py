"""The scalar functions of von Wolffersdorff's hypoplastic law for sand, and their derivatives.

Compression positive; t = sigma/tr(sigma), s its deviator, d the strain rate::

    rate of sigma = g (F^2 d + a^2 t (t:d) - f_d F a (t + s) |d|),   g = f_s/(t:t)
    tan(psi) = sqrt(3) |s|,   cos(3 theta) = -sqrt(6) tr(s^3)/|s|^3
    F = sqrt(tan^2(psi)/8 + (2 - tan^2(psi))/(2 + sqrt(2) tan(psi) cos(3 theta))) - tan(psi)/(2 sqrt(2))
    a = sqrt(3) (3 - sin(phi_c))/(2 sqrt(2) sin(phi_c))
    e_i/e_i0 = e_c/e_c0 = e_d/e_d0 = exp(-(tr(sigma)/h_s)^n)                        (Bauer 1996)
    f_d = ((e - e_d)/(e_c - e_d))^alpha, 0 for e below e_d, linear within 1e-6 (e_c - e_d) above it
    f_s = (h_s/n) (e_i/e)^beta (1 + e_i)/e_i (tr(sigma)/h_s)^(1 - n)
          / (3 + a^2 - sqrt(3) a ((e_i0 - e_d0)/(e_c0 - e_d0))^alpha)

P.-A. von Wolffersdorff (1996), A hypoplastic relation for granular materials with a predefined limit state surface,
Mechanics of Cohesive-Frictional Materials 1, 251-271; f_s is his f_b f_e. In compression cos(3 theta) = -1 and F = 1.
"""

from __future__ import annotations

import math
from typing import Final

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.kernels.jit import kernel_in_place

__all__ = ["SAND_CONSTANTS", "sand_functions"]

SAND_CONSTANTS: Final = 9
"""Of the law, from place ``first`` on: a, h_s, n, e_d0, e_c0, e_i0, alpha, beta, and the last bracket of f_s."""

_NO_DEVIATOR: Final = 1.0e-24

_LINEAR: Final = 1.0e-6
"""Density (e - e_d)/(e_c - e_d) below which f_d is linear: its slope at e_d is infinite for alpha below 1."""


@kernel_in_place
def sand_functions(
    trace: float, j: float, k: float, e: float, constants: FloatArray, first: int, f: FloatArray, slopes: FloatArray
) -> bool:
    """Fill the functions A, B, C, n0, n1 of a hypoplastic law and their derivatives.

    Parameters
    ----------
    trace, j, k, e
        tr(sigma), kPa, above 0; s:s; tr(s^3); void ratio.
    constants, first
        Those of the law begin at ``first``.
    f
        (5,): rate of sigma = A d + B tr(d) 1 + C t (t:d) - (n0 1 + n1 t) |d|.
    slopes
        (5, 4): their derivatives by ln(trace), j, k and ln(1 + e).

    Returns
    -------
    bool
        False where the law is not defined.
    """
    a, h_s, n = constants[first], constants[first + 1], constants[first + 2]
    e_d0, e_c0, e_i0 = constants[first + 3], constants[first + 4], constants[first + 5]
    alpha, beta, bracket = constants[first + 6], constants[first + 7], constants[first + 8]
    log_ratio = math.log(trace / h_s)
    x = math.exp(n * log_ratio)
    shrunk = math.exp(-x)
    e_d, e_c, e_i = e_d0 * shrunk, e_c0 * shrunk, e_i0 * shrunk
    volume = 1.0 + e
    # Density and pressure.
    f_s = h_s / n * math.exp(beta * math.log(e_i / e) + log_ratio) / x * (1.0 + e_i) / e_i / bracket
    f_s_p = 1.0 - n - n * x * (beta - 1.0 / (1.0 + e_i))  # of ln(f_s) by ln(trace)
    f_s_e = -beta * volume / e
    density = (e - e_d) / (e_c - e_d)
    f_d, f_d_p, f_d_e = 0.0, 0.0, 0.0
    if density > 0.0:
        if density < _LINEAR and alpha < 1.0:
            f_d = math.exp(alpha * math.log(_LINEAR)) * density / _LINEAR
            slope = 1.0 / (e - e_d)  # of ln(f_d)
        else:
            f_d = math.exp(alpha * math.log(density))
            slope = alpha / (e - e_d)
        f_d_p, f_d_e = slope * n * x * e, slope * volume
    # Direction of stress: b = tan(psi)/(2 sqrt(2)), v = tr(s^3)/s:s.
    F, F_j, F_k = 1.0, 0.0, 0.0
    if j > _NO_DEVIATOR:
        v, b = k / j, math.sqrt(0.375 * j)
        below = 2.0 - 6.0 * v
        top = 2.0 - 3.0 * j
        square = 0.375 * j + top / below
        if not (below > 0.0 and square > 0.0):
            return False
        root = math.sqrt(square)
        F = root - b
        F_k = 3.0 * top / (below * below * j * root)
        F_j = 0.5 * (0.375 - 3.0 / below) / root - v * F_k - 0.1875 / b
    length = j + 1.0 / 3.0
    g = f_s / length
    f[0], f[1], f[2] = g * F * F, 0.0, g * a * a
    f[4] = 2.0 * g * f_d * F * a
    f[3] = -f[4] / 6.0
    for i in range(5):
        slopes[i, 0] = f_s_p * f[i]
        slopes[i, 1] = -f[i] / length
        slopes[i, 2] = 0.0
        slopes[i, 3] = f_s_e * f[i]
        if i == 0:
            slopes[i, 1] += 2.0 * g * F * F_j
            slopes[i, 2] += 2.0 * g * F * F_k
        elif i > 2:
            slopes[i, 0] += f_d_p * f[i]
            slopes[i, 1] += f[i] * F_j / F
            slopes[i, 2] += f[i] * F_k / F
            slopes[i, 3] += f_d_e * f[i]
    return True
