"""Zero-thickness interfaces of three node pairs: forces of contact and friction, integrated at the pairs (1:4:1).

The tangent t of the middle line points from start to end, side A is on its left. The relative displacement A - B is
resolved along t and the normal to its left: opening is positive. What has opened must close before it presses again.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.fem.body import Body, State
from geoswarm.solver.kernels.jit import kernel

__all__ = ["assemble_interfaces", "interface_update"]

EDGE_SLOPES: Final = np.array([[-1.5, -0.5, 2.0], [0.5, 1.5, -2.0], [-0.5, 0.5, 0.0]])
"""Slopes of the line's shape functions (start, end, mid) by xi in -1 .. 1, a row for each node."""

PAIR_WEIGHTS: Final = np.array([1.0 / 3.0, 1.0 / 3.0, 4.0 / 3.0])


@kernel
def interface_update(
    normal: float, shear: float, gap: float, opening: float, slip: float, constants: FloatArray, D: FloatArray
) -> tuple[float, float, float]:
    """Tractions after a step of relative displacement.

    Parameters
    ----------
    normal, shear
        Old tractions, kPa, tension positive.
    gap
        How far the sides are apart, m; 0 where they touch.
    opening, slip
        Increments of relative displacement, m.
    constants
        Shape (6,): normal and shear stiffness kPa/m, cohesion kPa, tan(phi), tan(psi), tension kPa.
    D
        Filled: derivative (2, 2) of normal and shear traction by opening and slip.

    Returns
    -------
    normal, shear, gap
        New tractions and gap, with ``|shear| + normal tan(phi) <= c`` and ``normal <= tension``.
    """
    kn, ks, cohesion, friction, dilatancy, tension = (
        constants[0],
        constants[1],
        constants[2],
        constants[3],
        constants[4],
        constants[5],
    )
    if friction > 0.0:
        tension = min(tension, cohesion / friction)
    tn, ts = normal + kn * (gap + opening), shear + ks * slip
    D[0, 0], D[0, 1], D[1, 0], D[1, 1] = kn, 0.0, 0.0, ks
    way = 1.0 if ts >= 0.0 else -1.0
    excess = way * ts + tn * friction - cohesion
    if excess <= 0.0 and tn <= tension:
        return tn, ts, 0.0
    stiffness = ks + kn * friction * dilatancy
    multiplier = excess / stiffness
    shared = tn - kn * dilatancy * multiplier
    if excess > 0.0 and shared <= tension:
        D[0, 0] = kn - kn * dilatancy * kn * friction / stiffness
        D[0, 1] = -kn * dilatancy * ks * way / stiffness
        D[1, 0] = -way * ks * kn * friction / stiffness
        D[1, 1] = ks - ks * ks / stiffness
        return shared, ts - way * ks * multiplier, 0.0
    # Tension cut-off; friction may still limit the shear there.
    D[0, 0], D[0, 1], D[1, 0] = 0.0, 0.0, 0.0
    apart = ((shared if excess > 0.0 else tn) - tension) / kn
    limit = max(cohesion - tension * friction, 0.0)
    if abs(ts) > limit:
        D[1, 1] = 0.0
        return tension, way * limit, apart
    return tension, ts, apart


@kernel
def assemble_interfaces(
    body: Body,
    x: FloatArray,
    du: FloatArray,
    old: State,
    new: State,
    fixed: BoolArray,
    tangent: bool,
    tangents: FloatArray,
    force: FloatArray,
) -> None:
    """Add forces of all active interfaces, and fill their tangents (k, 12, 12); arguments as for the triangles."""
    line, line_end, half = np.empty((3, 2)), np.empty((3, 2)), 0.5
    D, f = np.empty((2, 2)), np.empty(12)
    for e in range(body.interfaces.shape[0]):
        K = tangents[e]
        if tangent:
            K[:, :] = 0.0
        if body.interface_material[e] < 0:
            continue
        constants = body.interface_constants[body.interface_material[e]]
        for n in range(3):
            a, b = body.interfaces[e, n], body.interfaces[e, n + 3]
            for i in range(2):
                line[n, i] = 0.5 * (x[a, i] + x[b, i])
                change = 0.5 * (du[2 * a + i] + du[2 * b + i]) if body.updated else 0.0
                line_end[n, i] = line[n, i] + change
                line[n, i] += half * change
        f[:] = 0.0
        for n in range(3):
            a, b = body.interfaces[e, n], body.interfaces[e, n + 3]
            mx, my, ex, ey = 0.0, 0.0, 0.0, 0.0
            for k in range(3):
                mx += EDGE_SLOPES[n, k] * line[k, 0]
                my += EDGE_SLOPES[n, k] * line[k, 1]
                ex += EDGE_SLOPES[n, k] * line_end[k, 0]
                ey += EDGE_SLOPES[n, k] * line_end[k, 1]
            length = math.sqrt(mx * mx + my * my)
            tx, ty = mx / length, my / length
            jump_x, jump_y = du[2 * a] - du[2 * b], du[2 * a + 1] - du[2 * b + 1]
            slip, opening = jump_x * tx + jump_y * ty, jump_y * tx - jump_x * ty
            tn, ts, gap = interface_update(
                old.traction[e, n, 0], old.traction[e, n, 1], old.gap[e, n], opening, slip, constants, D
            )
            new.traction[e, n, 0], new.traction[e, n, 1], new.gap[e, n] = tn, ts, gap
            weight = PAIR_WEIGHTS[n]
            radius = line_end[n, 0]
            share = weight * (radius if body.axisymmetric else 1.0)
            # Force on A opposes its displacement; (ex, ey) carries the length of the line.
            fx, fy = share * (ts * ex - tn * ey), share * (ts * ey + tn * ex)
            f[2 * n] += fx
            f[2 * n + 1] += fy
            f[2 * n + 6] -= fx
            f[2 * n + 7] -= fy
            if not tangent:
                continue
            for k in range(3):
                for i in range(2):
                    for side in range(2):
                        column = 2 * k + i + 6 * side
                        d_slip, d_opening, dex, dey, d_share = 0.0, 0.0, 0.0, 0.0, 0.0
                        if k == n:
                            sign = 1.0 if side == 0 else -1.0
                            d_slip = sign * (tx if i == 0 else ty)
                            d_opening = sign * (-ty if i == 0 else tx)
                        if body.updated:
                            turn = 0.25 * EDGE_SLOPES[n, k] / length * (tx if i == 1 else -ty)
                            d_slip += turn * opening
                            d_opening -= turn * slip
                            if i == 0:
                                dex = 0.5 * EDGE_SLOPES[n, k]
                            else:
                                dey = 0.5 * EDGE_SLOPES[n, k]
                            if body.axisymmetric and k == n and i == 0:
                                d_share = 0.5 * weight
                        dtn = D[0, 0] * d_opening + D[0, 1] * d_slip
                        dts = D[1, 0] * d_opening + D[1, 1] * d_slip
                        dfx = share * (dts * ex - dtn * ey + ts * dex - tn * dey) + d_share * (ts * ex - tn * ey)
                        dfy = share * (dts * ey + dtn * ex + ts * dey + tn * dex) + d_share * (ts * ey + tn * ex)
                        K[2 * n, column] += dfx
                        K[2 * n + 1, column] += dfy
                        K[2 * n + 6, column] -= dfx
                        K[2 * n + 7, column] -= dfy
        for n in range(6):
            node = body.interfaces[e, n]
            force[2 * node] += f[2 * n]
            force[2 * node + 1] += f[2 * n + 1]
        if tangent:
            for n in range(6):
                for i in range(2):
                    if fixed[2 * body.interfaces[e, n] + i]:
                        K[2 * n + i, :] = 0.0
