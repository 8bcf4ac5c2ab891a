"""Rates of stress and tangent of a hypoplastic law along a straight path of strain, by its functions of invariants.

Equations and notation: :mod:`geoswarm.solver.constitutive.hypoplasticity.step`.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.hypoplasticity.clay import clay_functions
from geoswarm.solver.constitutive.hypoplasticity.intergranular_strain import along_way
from geoswarm.solver.constitutive.hypoplasticity.sand import sand_functions
from geoswarm.solver.constitutive.local_arrays import local_matrix, local_vector
from geoswarm.solver.kernels.jit import inlined, kernel, kernel_in_place

__all__ = ["CLAY", "FIRST", "MOST", "SAND", "Room", "fill_invariants", "fill_rate"]

FIRST: Final = 7
"""Place of the first constant of a law, after its number, p_t, R, m_R, m_T, beta_r and chi."""

CLAY: Final = 0
SAND: Final = 1

MOST: Final = 45
"""Numbers that are integrated, of six components: stress, tangent, q and its slope, shear stiffness across the axes."""

_LEAST_TRACE: Final = 3.0e-4
_HALF_ROOT: Final = math.sqrt(0.5)


@kernel_in_place
def fill_invariants(y: FloatArray, n: int, shift: float, t: FloatArray, s2: FloatArray) -> tuple[float, float, float]:
    """Fill t = sigma/tr(sigma) (6,) and s^2 (6,); return tr(sigma), s:s and tr(s^3), with p_t in the stress."""
    trace = y[0] + y[1] + y[2] + 3.0 * shift
    inverse = 1.0 / trace
    for i in range(3):
        t[i] = (y[i] + shift) * inverse
    for i in range(3, 6):
        t[i] = y[i] * inverse if i < n else 0.0
    x, y_, z = t[0] - 1.0 / 3.0, t[1] - 1.0 / 3.0, t[2] - 1.0 / 3.0
    a, b, c = t[3], t[4], t[5]
    s2[0] = x * x + 0.5 * (a * a + c * c)
    s2[1] = y_ * y_ + 0.5 * (a * a + b * b)
    s2[2] = z * z + 0.5 * (b * b + c * c)
    s2[3] = a * (x + y_) + b * c * _HALF_ROOT
    s2[4] = b * (y_ + z) + a * c * _HALF_ROOT
    s2[5] = c * (x + z) + a * b * _HALF_ROOT
    j = s2[0] + s2[1] + s2[2]
    return trace, j, s2[0] * x + s2[1] * y_ + s2[2] * z + s2[3] * a + s2[4] * b + s2[5] * c


class Room(NamedTuple):
    """Arrays that the stages of a step share."""

    units: FloatArray
    """(2, 6): unit strains along the path, and across it in the plane of the old intergranular strain."""

    way: FloatArray
    """(WAY,): the path of the intergranular strain."""

    lead: FloatArray
    """(LEAD,): what it makes of the strain rate."""


@inlined
def _change(slopes: FloatArray, i: int, of_trace: float, of_j: float, of_k: float, of_e: float) -> float:
    """Change of a function of the law."""
    change: float = slopes[i, 0] * of_trace + slopes[i, 1] * of_j + slopes[i, 2] * of_k + slopes[i, 3] * of_e
    return change


@kernel
def fill_rate(
    y: FloatArray,
    n: int,
    columns: int,
    fraction: float,
    loading: bool,
    length: float,
    volume: float,
    log_v: float,
    constants: FloatArray,
    room: Room,
    rate: FloatArray,
) -> bool:
    """Fill the derivative by the fraction of the path of y: stress (n,), tangent (n, n), q and its slope.

    The last of y is the tangent of shear where nothing is sheared; n is then 3. Of the tangent only the first
    ``columns`` are filled. ``length``, ``volume``, ``log_v``: norm of the strain of the whole path, its volume strain,
    ln(1 + e) at its beginning. False where the law is not defined.

    Loops over three components are apart from those over the shears, so that the compiler lays them out.
    """
    units, lead = room.units, room.lead
    t, s2, D, f, slopes = local_vector(6), local_vector(6), local_vector(6), local_vector(5), local_matrix(5, 4)
    trace, j, k = fill_invariants(y, n, constants[1], t, s2)
    log_now = log_v - fraction * volume
    if not (trace > _LEAST_TRACE and log_now > 0.0):
        return False
    if constants[0] == CLAY:
        known = clay_functions(trace, j, k, log_now, constants, FIRST, f, slopes)
    else:
        known = sand_functions(trace, j, k, math.exp(log_now) - 1.0, constants, FIRST, f, slopes)
    if not known:
        return False
    if constants[2] > 0.0:
        along_way(fraction, loading, y[n + n * n], y[n + n * n + 1], constants, room.way, lead)
    A, B, C, n0, n1 = f[0], f[1], f[2], f[3], f[4]
    size = lead[2] * length
    td, t0, t1 = 0.0, 0.0, 0.0
    for i in range(3):
        D[i] = length * (lead[0] * units[0, i] + lead[1] * units[1, i])
        td += t[i] * D[i]
        t0 += t[i] * units[0, i]
        t1 += t[i] * units[1, i]
    for i in range(3, n):
        D[i] = length * (lead[0] * units[0, i] + lead[1] * units[1, i])
        td += t[i] * D[i]
        t0 += t[i] * units[0, i]
        t1 += t[i] * units[1, i]
    D_trace = D[0] + D[1] + D[2]
    trace0, trace1 = units[0, 0] + units[0, 1] + units[0, 2], units[1, 0] + units[1, 1] + units[1, 2]
    w = C * td - n1 * size
    everywhere = B * D_trace - n0 * size
    for i in range(3):
        rate[i] = A * D[i] + w * t[i] + everywhere
    for i in range(3, n):
        rate[i] = A * D[i] + w * t[i]
    # Column by column, the derivative by one strain: that of stress so far is in y.
    same, inverse = lead[7], 1.0 / trace
    flow = w * inverse
    for m in range(columns):
        first = n + n * m
        of_trace = (y[first] + y[first + 1] + y[first + 2]) * inverse
        of_t, of_s2, of_D = 0.0, 0.0, 0.0
        for i in range(3):
            b = y[first + i]
            of_t += t[i] * b
            of_s2 += s2[i] * b
            of_D += D[i] * b
        for i in range(3, n):
            b = y[first + i]
            of_t += t[i] * b
            of_s2 += s2[i] * b
            of_D += D[i] * b
        of_t, of_s2, of_D = of_t * inverse, of_s2 * inverse, of_D * inverse
        one = 1.0 if m < 3 else 0.0
        of_j = 2.0 * (of_t - (1.0 / 3.0 + j) * of_trace)
        of_k = 3.0 * (of_s2 - (k + j / 3.0) * of_trace)
        of_e = -fraction * one
        u0 = (lead[3] - same) * units[0, m] + lead[4] * units[1, m]
        u1 = lead[5] * units[0, m] + (lead[6] - same) * units[1, m]
        of_size = lead[8] * units[0, m] + lead[9] * units[1, m]
        of_A, of_B = _change(slopes, 0, of_trace, of_j, of_k, of_e), _change(slopes, 1, of_trace, of_j, of_k, of_e)
        of_C, of_n0 = _change(slopes, 2, of_trace, of_j, of_k, of_e), _change(slopes, 3, of_trace, of_j, of_k, of_e)
        of_n1 = _change(slopes, 4, of_trace, of_j, of_k, of_e)
        everywhere = D_trace * of_B - size * of_n0 - n0 * of_size + B * (same * one + trace0 * u0 + trace1 * u1)
        along = C * (of_D - td * of_trace + same * t[m] + t0 * u0 + t1 * u1) + td * of_C - size * of_n1 - n1 * of_size
        along -= w * of_trace
        u0, u1 = A * u0, A * u1
        for i in range(3):
            straight = D[i] * of_A + units[0, i] * u0 + units[1, i] * u1
            rate[first + i] = flow * y[first + i] + t[i] * along + straight + everywhere
        for i in range(3, n):
            straight = D[i] * of_A + units[0, i] * u0 + units[1, i] * u1
            rate[first + i] = flow * y[first + i] + t[i] * along + straight
        rate[first + m] += A * same
    rate[n + n * n] = lead[10]
    rate[n + n * n + 1] = lead[11]
    rate[n + n * n + 2] = flow * y[n + n * n + 2] + A * same
    return True
