"""Invariants of principal stresses with their first and second derivatives, for surfaces that depend on all three."""

from __future__ import annotations

import math

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.kernels.jit import kernel

__all__ = ["deviatoric_invariants", "invariant_derivatives"]


@kernel
def deviatoric_invariants(stress: FloatArray) -> tuple[float, float, float]:
    """p, q = sqrt(3/2 s:s) and cos(3 theta) = 27/2 det(s)/q^3 of principal stresses (3,), compression positive.

    theta is the angle of Lode, 0 in triaxial compression and 60 degree in extension; cos(3 theta) is 1 for q = 0.
    """
    p = (stress[0] + stress[1] + stress[2]) / 3.0
    a, b, c = stress[0] - p, stress[1] - p, stress[2] - p
    q = math.sqrt(1.5 * (a * a + b * b + c * c))
    if not q > 0.0:
        return p, 0.0, 1.0
    return p, q, min(max(13.5 * (a / q) * (b / q) * (c / q), -1.0), 1.0)


@kernel
def invariant_derivatives(
    stress: FloatArray, dq: FloatArray, dc: FloatArray, ddq: FloatArray, ddc: FloatArray
) -> tuple[float, float, float]:
    """The same, and derivatives of q and c = cos(3 theta) by the stresses: (3,), (3,), (3, 3), (3, 3); q above 0.

    With J3 = det(s) and its derivative t_i = s_i^2 - 2/9 q^2::

        dq_i = 3/2 s_i/q,        dc_i = 27/2 t_i/q^3 - 3 c dq_i/q
        ddq_ij = (3/2 (delta_ij - 1/3) - dq_i dq_j)/q
        ddc_ij = 27/2 (dt_ij - 3 t_i dq_j/q)/q^3 - 3 (dc_j dq_i + c ddq_ij - c dq_i dq_j/q)/q
    """
    p, q, c = deviatoric_invariants(stress)
    cube = 13.5 / (q * q * q)
    for i in range(3):
        s = stress[i] - p
        dq[i] = 1.5 * s / q
        dc[i] = cube * (s * s - 2.0 / 9.0 * q * q) - 3.0 * c * dq[i] / q
    for i in range(3):
        s = stress[i] - p
        t = s * s - 2.0 / 9.0 * q * q
        for j in range(3):
            same = 2.0 / 3.0 if i == j else -1.0 / 3.0
            dt = 2.0 * s * same - 2.0 / 3.0 * (stress[j] - p)
            ddq[i, j] = (1.5 * same - dq[i] * dq[j]) / q
            ddc[i, j] = cube * (dt - 3.0 * t * dq[j] / q)
            ddc[i, j] -= 3.0 * (dc[j] * dq[i] + c * ddq[i, j] - c * dq[i] * dq[j] / q) / q
    return p, q, c
