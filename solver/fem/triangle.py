"""Six-node triangles: internal forces and their exact derivative.

With an updated mesh a step is taken from the positions x at its beginning: strain increment and rotation come from the
gradient of the displacement increment on the mid-step positions (Hughes & Winget 1980), stress and the tensors among
the state variables are turned by half the rotation before the material sees them and by the other half after, and the
forces are those of the new stress on the new positions. The tangent is the derivative of all that; for an isotropic
material what is old and turned needs no more than the tangent by strain. At small strain all three configurations are
the mesh at the beginning of the phase.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.fem.body import Body, State
from geoswarm.solver.kernels.jit import kernel
from geoswarm.solver.laws.binary import call_update

__all__ = ["POINTS", "SHAPES", "SLOPES", "WEIGHT", "assemble_triangles", "shape_functions"]

POINTS: Final = np.array([[1 / 6, 1 / 6], [2 / 3, 1 / 6], [1 / 6, 2 / 3]])
"""Integration points (3, 2) in the unit triangle."""

WEIGHT: Final = 1.0 / 6.0
"""Weight of each."""


def shape_functions(xi: float, eta: float) -> tuple[FloatArray, FloatArray]:
    """Shape functions (6,) and their slopes (2, 6) by xi and eta at a point of the unit triangle."""
    a, b, c = 1.0 - xi - eta, xi, eta
    values = np.array([a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a])
    slopes = np.array(
        [
            [1 - 4 * a, 4 * b - 1, 0.0, 4 * (a - b), 4 * c, -4 * c],
            [1 - 4 * a, 0.0, 4 * c - 1, -4 * b, 4 * b, 4 * (a - c)],
        ]
    )
    return values, slopes


SHAPES: Final = np.array([shape_functions(*point)[0] for point in POINTS])
SLOPES: Final = np.array([shape_functions(*point)[1] for point in POINTS])


@kernel
def _gradients(slopes: FloatArray, x: FloatArray, g: FloatArray) -> float:
    """Fill gradients (2, 6) of the shape functions for node positions (6, 2); determinant of the Jacobian."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    for n in range(6):
        a += slopes[0, n] * x[n, 0]
        b += slopes[0, n] * x[n, 1]
        c += slopes[1, n] * x[n, 0]
        d += slopes[1, n] * x[n, 1]
    determinant = a * d - b * c
    if determinant > 0.0:
        inverse = 1.0 / determinant
        for n in range(6):
            g[0, n] = (d * slopes[0, n] - b * slopes[1, n]) * inverse
            g[1, n] = (a * slopes[1, n] - c * slopes[0, n]) * inverse
    return determinant


@kernel
def _turn(tensor: FloatArray, c: float, s: float, first: int, shear: float) -> None:
    """Turn a tensor in place by the angle whose cosine and sine are given.

    Its xx, yy, zz and xy begin at ``first``; ``shear`` is what it keeps of xy.
    """
    sxx, syy, sxy = tensor[first], tensor[first + 1], tensor[first + 3] / shear
    tensor[first] = c * c * sxx + s * s * syy - 2.0 * c * s * sxy
    tensor[first + 1] = s * s * sxx + c * c * syy + 2.0 * c * s * sxy
    tensor[first + 3] = shear * (c * s * (sxx - syy) + (c * c - s * s) * sxy)


@kernel
def _turn_all(state: FloatArray, c: float, s: float, tensors: IntArray, shear: FloatArray) -> None:
    """Turn the tensors among state variables in place: where they begin, -1: none, and what they keep of xy."""
    for place, first in enumerate(tensors):
        if first >= 0:
            _turn(state, c, s, first, shear[place])


@kernel
def _mix(share: float, bulk: float, shear: float, C: FloatArray) -> None:
    """Replace a tangent (4, 4) by a share of an elastic stiffness."""
    lame = bulk - 2.0 / 3.0 * shear
    for i in range(4):
        for j in range(4):
            elastic = lame if i < 3 and j < 3 else 0.0
            if i == j:
                elastic += 2.0 * shear if i < 3 else shear
            C[i, j] += share * (elastic - C[i, j])


@kernel
def assemble_triangles(
    body: Body,
    x: FloatArray,
    du: FloatArray,
    log_time: float,
    old: State,
    new: State,
    fixed: BoolArray,
    tangent: bool,
    blend: float,
    tangents: FloatArray,
    force: FloatArray,
) -> int:
    """Add internal forces of all active triangles, and fill their tangents.

    Parameters
    ----------
    x, du
        (n, 2) positions at the beginning of the step; (2 n,) displacement increments.
    log_time
        ln(dt/day); -inf without time.
    old, new
        States before and after; ``new`` is filled.
    fixed
        (2 n,): dofs whose rows of the tangents are zero.
    tangent, blend, tangents
        Whether to fill ``tangents`` (e, 12, 12), and with which share of the elastic stiffness at plastic points.
    force
        (2 n,): added to.

    Returns
    -------
    int
        -1, or the number of a triangle that is turned inside out (number) or whose material found no stress
        (number + number of triangles).
    """
    count: int = body.triangles.shape[0]
    start, mid, end, moved = np.empty((6, 2)), np.empty((6, 2)), np.empty((6, 2)), np.empty((6, 2))
    gm, g = np.empty((2, 6)), np.empty((2, 6))
    stress, strain, sigma, C = np.empty(4), np.empty(4), np.empty(4), np.empty((4, 4))
    E, S = np.empty((4, 12)), np.empty((4, 12))
    spin, f, hoop = np.zeros(12), np.empty(12), np.zeros(6)
    turned = np.empty(old.internal.shape[2])
    updated, axisymmetric = body.updated, body.axisymmetric

    for e in range(count):
        K = tangents[e]
        if tangent:
            K[:, :] = 0.0
        if body.material[e] < 0:
            continue
        number = body.material[e]
        address, constants = body.updates[number], body.constants[number]
        bulk, shear = body.elastic[number, 0], body.elastic[number, 1]
        for n in range(6):
            node = body.triangles[e, n]
            for i in range(2):
                start[n, i] = x[node, i]
                moved[n, i] = du[2 * node + i]
                mid[n, i] = start[n, i] + (0.5 * moved[n, i] if updated else 0.0)
                end[n, i] = start[n, i] + (moved[n, i] if updated else 0.0)
        f[:] = 0.0
        for point in range(3):
            slopes, shapes = SLOPES[point], SHAPES[point]
            if not _gradients(slopes, mid, gm) > 0.0:
                return e
            gxx, gxy, gyx, gyy = 0.0, 0.0, 0.0, 0.0
            r, r_mid, u_r = 0.0, 0.0, 0.0
            for n in range(6):
                gxx += gm[0, n] * moved[n, 0]
                gxy += gm[1, n] * moved[n, 0]
                gyx += gm[0, n] * moved[n, 1]
                gyy += gm[1, n] * moved[n, 1]
                r += shapes[n] * end[n, 0]
                r_mid += shapes[n] * mid[n, 0]
                u_r += shapes[n] * moved[n, 0]
            around = u_r / r_mid if axisymmetric else 0.0
            # Compression positive for the material.
            strain[0], strain[1], strain[2], strain[3] = -gxx, -gyy, -around, -(gxy + gyx)
            for i in range(4):
                stress[i] = -old.stress[e, point, i]
            half_spin, c, s = 0.0, 1.0, 0.0
            if updated:
                half_spin = 0.25 * (gyx - gxy)
                c = 1.0 / math.sqrt(1.0 + half_spin * half_spin)
                s = half_spin * c
                _turn(stress, c, s, 0, 1.0)
            before, after = old.internal[e, point], new.internal[e, point]
            if updated:
                turned[:] = before
                _turn_all(turned, c, s, body.tensors[number], body.tensor_shear[number])
                before = turned
            limit = call_update(
                address,
                log_time,
                strain,
                stress,
                before,
                constants,
                sigma,
                after,
                C,
            )
            if limit < 0:
                return e + count
            if limit > 0 and blend > 0.0 and shear > 0.0:
                _mix(blend, bulk, shear, C)
            new.plastic[e, point] = limit > 0
            if updated:
                _turn(sigma, c, s, 0, 1.0)
                _turn_all(after, c, s, body.tensors[number], body.tensor_shear[number])
            for i in range(4):
                sigma[i] = -sigma[i]
                new.stress[e, point, i] = sigma[i]
            determinant = _gradients(slopes, end, g) if updated else 0.0
            if updated:
                if not determinant > 0.0:
                    return e
            else:
                determinant = _gradients(slopes, mid, g)
            weight = determinant * WEIGHT * (r if axisymmetric else 1.0)
            for n in range(6):
                hoop[n] = shapes[n] / r if axisymmetric else 0.0
                f[2 * n] += weight * (g[0, n] * sigma[0] + g[1, n] * sigma[3] + hoop[n] * sigma[2])
                f[2 * n + 1] += weight * (g[1, n] * sigma[1] + g[0, n] * sigma[3])
            if not tangent:
                continue
            if updated:
                a00, a01, a10, a11 = 1.0 - 0.5 * gxx, -0.5 * gxy, -0.5 * gyx, 1.0 - 0.5 * gyy
                turn = 1.0 / (1.0 + half_spin * half_spin)
                for n in range(6):
                    bx, by = gm[0, n], gm[1, n]
                    E[0, 2 * n], E[0, 2 * n + 1] = a00 * bx, a01 * bx
                    E[1, 2 * n], E[1, 2 * n + 1] = a10 * by, a11 * by
                    E[2, 2 * n] = shapes[n] / r_mid * (1.0 - 0.5 * around) if axisymmetric else 0.0
                    E[2, 2 * n + 1] = 0.0
                    E[3, 2 * n], E[3, 2 * n + 1] = a00 * by + a10 * bx, a01 * by + a11 * bx
                    spin[2 * n] = 0.5 * (a10 * bx - a00 * by) * turn
                    spin[2 * n + 1] = 0.5 * (a11 * bx - a01 * by) * turn
                # The law is isotropic: an old stress turned by half the spin gives the turned result of a strain that
                # is turned back.
                for m in range(12):
                    E[0, m] -= 0.5 * spin[m] * strain[3]
                    E[1, m] += 0.5 * spin[m] * strain[3]
                    E[3, m] += spin[m] * (strain[0] - strain[1])
            else:
                for n in range(6):
                    E[0, 2 * n], E[0, 2 * n + 1] = g[0, n], 0.0
                    E[1, 2 * n], E[1, 2 * n + 1] = 0.0, g[1, n]
                    E[2, 2 * n], E[2, 2 * n + 1] = hoop[n], 0.0
                    E[3, 2 * n], E[3, 2 * n + 1] = g[1, n], g[0, n]
            for i in range(4):
                c0, c1, c2, c3 = weight * C[i, 0], weight * C[i, 1], weight * C[i, 2], weight * C[i, 3]
                for m in range(12):
                    S[i, m] = c0 * E[0, m] + c1 * E[1, m] + c2 * E[2, m] + c3 * E[3, m]
            if updated:
                for m in range(12):
                    s0, s1, s3 = S[0, m], S[1, m], S[3, m]
                    S[0, m] = c * c * s0 + s * s * s1 - 2.0 * c * s * s3
                    S[1, m] = s * s * s0 + c * c * s1 + 2.0 * c * s * s3
                    S[3, m] = c * s * (s0 - s1) + (c * c - s * s) * s3
                    S[0, m] -= 2.0 * weight * spin[m] * sigma[3]
                    S[1, m] += 2.0 * weight * spin[m] * sigma[3]
                    S[3, m] += weight * spin[m] * (sigma[0] - sigma[1])
            for n in range(6):
                bx, by, h = g[0, n], g[1, n], hoop[n]
                for m in range(12):
                    K[2 * n, m] += bx * S[0, m] + by * S[3, m] + h * S[2, m]
                    K[2 * n + 1, m] += by * S[1, m] + bx * S[3, m]
            if updated:
                for a in range(6):
                    tx = weight * (g[0, a] * sigma[0] + g[1, a] * sigma[3])
                    ty = weight * (g[0, a] * sigma[3] + g[1, a] * sigma[1])
                    th = weight * hoop[a] * sigma[2]
                    for b in range(6):
                        bx = weight * (g[0, b] * sigma[0] + g[1, b] * sigma[3])
                        by = weight * (g[0, b] * sigma[3] + g[1, b] * sigma[1])
                        for k in range(2):
                            K[2 * a, 2 * b + k] += (tx + th) * g[k, b] - g[k, a] * bx
                            K[2 * a + 1, 2 * b + k] += ty * g[k, b] - g[k, a] * by
                        K[2 * a, 2 * b] += tx * hoop[b]
                        K[2 * a + 1, 2 * b] += ty * hoop[b]
        for n in range(6):
            node = body.triangles[e, n]
            force[2 * node] += f[2 * n]
            force[2 * node + 1] += f[2 * n + 1]
        if tangent:
            for n in range(6):
                for i in range(2):
                    if fixed[2 * body.triangles[e, n] + i]:
                        K[2 * n + i, :] = 0.0
    return -1
