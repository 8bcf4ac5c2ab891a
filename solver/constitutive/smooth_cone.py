"""Cones that are smooth but for their tip, Drucker-Prager and Matsuoka-Nakai, as limits in principal stress.

Compression positive, principal stresses sorted, largest first. With p, q, c = cos(3 theta) of
:mod:`geoswarm.solver.constitutive.invariants` (theta = 0 in triaxial compression)::

    f = q S(c) - slope p - strength <= 0,   S = cos(arccos(-b c)/3) / cos(arccos(-b)/3)
    -sigma_i <= tension                     tension cut-off, associated flow

Plastic flow is that of the same cone with psi instead of phi.

- Drucker-Prager (Drucker & Prager 1952): b = 0, a circle in the deviatoric plane. ``slope`` and ``strength`` are those
  with which it has the strength of Mohr-Coulomb in triaxial compression, in triaxial extension, or in plane strain.
- Matsuoka-Nakai (Matsuoka & Nakai 1974): I1 I2/I3 = 9 + 8 tan(phi)^2 of the stresses shifted by c cot(phi) is, solved
  for its smallest q, this S with b = s (9 - s^2)/(3 + s^2)^(3/2), s = sin(phi), convex everywhere (Panteghini &
  Lagioia 2014, IJNAMG 38, 593-614). It has the strength of Mohr-Coulomb in triaxial compression and extension.

A perfectly plastic body in plane strain fails without plastic strain out of its plane. With J = q/sqrt(3) and the flow
of g = J - d p the stress deviator out of the plane is then 2/3 d J, the radius of Mohr's circle in the plane J sqrt(1 -
d^2/3), its centre p - d J/3, and sin(psi) = d/sqrt(1 - d^2/3). Put into Mohr-Coulomb, they give :func:`cone_of`.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.invariants import deviatoric_invariants, invariant_derivatives
from geoswarm.solver.constitutive.principal_return import elastic_trial, turned_back
from geoswarm.solver.constitutive.tensors import principal_axes, solve_dense
from geoswarm.solver.kernels.jit import kernel

__all__ = [
    "COMPRESSION",
    "EXTENSION",
    "MATSUOKA_NAKAI",
    "PLANE_STRAIN",
    "cone_excess",
    "cone_of",
    "cone_step",
    "return_to_cone",
]

COMPRESSION: Final = 0
EXTENSION: Final = 1
PLANE_STRAIN: Final = 2
MATSUOKA_NAKAI: Final = 3

_ITERATIONS: Final = 60
_HALVINGS: Final = 12
_RESIDUAL: Final = 1.0e-12
_EXCESS: Final = 1.0e-9
_ELASTIC: Final = 1.0e-12
_TIP: Final = 1.0e-12
"""q over the size of stresses below which the tip is reached."""


@kernel
def cone_of(kind: int, cohesion: float, sin_phi: float, cos_phi: float, sin_psi: float, cone: FloatArray) -> None:
    """Fill slope, strength (kPa) and b of the limit, slope and b of the flow; ``kind``: one of the constants above."""
    cone[2], cone[4] = 0.0, 0.0
    if kind == PLANE_STRAIN:
        d = sin_psi / math.sqrt(1.0 + sin_psi * sin_psi / 3.0)
        size = math.sqrt(3.0) / (math.sqrt(1.0 - d * d / 3.0) + d / 3.0 * sin_phi)
        cone[0], cone[1], cone[3] = size * sin_phi, size * cohesion * cos_phi, math.sqrt(3.0) * d
        return
    side = 1.0 if kind == EXTENSION else -1.0
    cone[0] = 6.0 * sin_phi / (3.0 + side * sin_phi)
    cone[1] = 6.0 * cohesion * cos_phi / (3.0 + side * sin_phi)
    cone[3] = 6.0 * sin_psi / (3.0 + side * sin_psi)
    if kind == MATSUOKA_NAKAI:
        cone[2] = sin_phi * (9.0 - sin_phi * sin_phi) / (3.0 + sin_phi * sin_phi) ** 1.5
        cone[4] = sin_psi * (9.0 - sin_psi * sin_psi) / (3.0 + sin_psi * sin_psi) ** 1.5


@kernel
def _shape(c: float, b: float) -> tuple[float, float, float]:
    """S and its first and second derivative by c = cos(3 theta)."""
    if b == 0.0:
        return 1.0, 0.0, 0.0
    size = 1.0 / math.cos(math.acos(-b) / 3.0)
    omega = math.acos(-b * c)
    sine, third = math.sin(omega), omega / 3.0
    ratio = math.sin(third) / sine
    bend = (math.cos(third) / 3.0 - ratio * math.cos(omega)) / sine
    return size * math.cos(third), -size * b / 3.0 * ratio, -size * b / 3.0 * bend * b / sine


@kernel
def cone_excess(stress: FloatArray, cone: FloatArray) -> float:
    """f, kPa, of principal stresses (3,) in any order."""
    p, q, c = deviatoric_invariants(stress)
    excess: float = q * _shape(c, cone[2])[0] - cone[0] * p - cone[1]
    return excess


@kernel
def _beyond_tip(p: float, q: float, theta: float, cone: FloatArray, swelling: float) -> bool:
    """Whether stress returns to the tip: the flow there may have any deviator within the cone of the flow.

    That is, q cos(theta - x) <= m S(x) for all x, S of the flow, with the m that brings p to the tip. The largest ratio
    is found by bisection of its derivative, between 0 and theta.
    """
    if cone[0] == 0.0 or p >= -cone[1] / cone[0]:
        return False
    if swelling == 0.0:
        return True
    low, high = 0.0, theta
    for _ in range(50):
        x = 0.5 * (low + high)
        S, S_c, _ = _shape(math.cos(3.0 * x), cone[4])
        if math.sin(theta - x) * S + 3.0 * math.cos(theta - x) * math.sin(3.0 * x) * S_c > 0.0:
            low = x
        else:
            high = x
    x = 0.5 * (low + high)
    m = (-cone[1] / cone[0] - p) / swelling
    beyond: bool = q * math.cos(theta - x) <= m * _shape(math.cos(3.0 * x), cone[4])[0]
    return beyond


@kernel
def _onto_cone(trial: FloatArray, bulk: float, shear: float, cone: FloatArray, x: FloatArray) -> int:
    """Return to the cone alone; 1: found, 0: the tip is reached first, -1: not found.

    Fills x: stresses (3,) and 2 G times the multiplier. With m = 3 G times the multiplier, theta_t and q_t of the trial
    and S of the flow::

        q_t sin(theta_t - theta) = m S'(theta),   q = q_t cos(theta_t - theta) - m S,   p = p_t + K/(3 G) dilation m
        f(p, q, theta) = 0

    The determinant of both by theta and m has one sign as long as q is above 0, for S is convex.
    """
    slope, strength, b, dilation, flow_b = cone[0], cone[1], cone[2], cone[3], cone[4]
    p_trial, q_trial, c_trial = deviatoric_invariants(trial)
    theta_trial = math.acos(c_trial) / 3.0
    swelling = bulk * dilation / (3.0 * shear)
    size = q_trial + abs(p_trial) + strength
    if _beyond_tip(p_trial, q_trial, theta_trial, cone, swelling):
        return 0
    theta, m, q = theta_trial, 0.0, q_trial
    found = False
    for _ in range(_ITERATIONS):
        c, sine = math.cos(3.0 * theta), math.sin(3.0 * theta)
        S, S_c, _ = _shape(c, b)
        F, F_c, F_cc = _shape(c, flow_b)
        along, across = math.cos(theta_trial - theta), math.sin(theta_trial - theta)
        F_t, F_tt = -3.0 * sine * F_c, 9.0 * (sine * sine * F_cc - c * F_c)
        q = q_trial * along - m * F
        r1 = q_trial * across - m * F_t
        r2 = S * q - slope * (p_trial + swelling * m) - strength
        found = max(abs(r1), abs(r2)) <= _RESIDUAL * size
        if found:
            break
        a11, a12 = -q_trial * along - m * F_tt, -F_t
        a21, a22 = -3.0 * sine * S_c * q + S * r1, -S * F - slope * swelling
        determinant = a11 * a22 - a12 * a21
        if not abs(determinant) > 0.0:
            return -1
        theta = min(max(theta + (a12 * r2 - a22 * r1) / determinant, 0.0), theta_trial)
        m = max(m + (a21 * r1 - a11 * r2) / determinant, 0.0)
    if not found or q <= _TIP * size:
        return -1
    for i in range(3):
        turn = 0.0 if i == 0 else (-2.0 * math.pi / 3.0 if i == 1 else 2.0 * math.pi / 3.0)
        x[i] = p_trial + swelling * m + 2.0 / 3.0 * q * math.cos(theta + turn)
    x[3] = 2.0 / 3.0 * m
    return 1


@kernel
def _system(
    on_cone: bool,
    x: FloatArray,
    trial: FloatArray,
    bulk: float,
    shear: float,
    cone: FloatArray,
    tension: float,
    matrix: FloatArray,
    right: FloatArray,
) -> float:
    """Fill the linearised equations for stresses and multipliers x; the largest residual, kPa, inf at the tip.

    x (4 + k,): stresses (3,), multipliers times 2 G of the cone (0 unless on it) and of the tension planes of the k
    smallest stresses. ``right`` (4 + k, 4): 2 G for each principal strain, and the residual.
    """
    n = x.shape[0]
    dq, dc, ddq, ddc = np.zeros(3), np.zeros(3), np.zeros((3, 3)), np.zeros((3, 3))
    p, q, c = 0.0, 0.0, 1.0
    if on_cone:
        p, q, c = invariant_derivatives(x, dq, dc, ddq, ddc)
        if not q > 0.0:
            return math.inf
    S, S_c, _ = _shape(c, cone[2])
    F, F_c, F_cc = _shape(c, cone[4])
    ratio = 2.0 * shear / (9.0 * bulk)
    for i in range(n):
        for j in range(n):
            matrix[i, j] = 0.0
        for j in range(4):
            right[i, j] = 0.0
    for i in range(3):
        flow = F * dq[i] + q * F_c * dc[i] - cone[3] / 3.0
        matrix[i, 3] = flow
        matrix[3, i] = S * dq[i] + q * S_c * dc[i] - cone[0] / 3.0 if on_cone else 0.0
        right[i, 3] = -x[3] * flow
        for j in range(3):
            elastic = ratio + (2.0 / 3.0 if i == j else -1.0 / 3.0)
            bend = F * ddq[i, j] + F_c * (dq[i] * dc[j] + dc[i] * dq[j] + q * ddc[i, j]) + q * F_cc * dc[i] * dc[j]
            matrix[i, j] = elastic + x[3] * bend
            right[i, 3] -= elastic * (x[j] - trial[j])
        right[i, i] = 2.0 * shear
    matrix[3, 3] = 0.0 if on_cone else 1.0
    right[3, 3] = cone[0] * p + cone[1] - q * S if on_cone else -x[3]
    for k in range(4, n):
        axis = 6 - k
        matrix[axis, k], matrix[k, axis] = -1.0, 1.0
        right[axis, 3] += x[k]
        right[k, 3] = -tension - x[axis]
    worst = 0.0
    for i in range(n):
        worst = max(worst, abs(right[i, 3]))
    return worst if worst == worst else math.inf


@kernel
def _solve(
    on_cone: bool,
    x: FloatArray,
    trial: FloatArray,
    bulk: float,
    shear: float,
    cone: FloatArray,
    tension: float,
    D: FloatArray,
) -> bool:
    """Newton's method with line search for x, a guess; D (3, 3) becomes d stress/d strain. Whether it was found."""
    n = x.shape[0]
    size = abs(trial[0]) + abs(trial[2]) + cone[1]
    matrix, right = np.empty((n, n)), np.empty((n, 4))
    base, way = np.empty(n), np.empty(n)
    worst = _system(on_cone, x, trial, bulk, shear, cone, tension, matrix, right)
    for _ in range(_ITERATIONS):
        if not worst < math.inf or not solve_dense(matrix, right):
            return False
        if worst <= _RESIDUAL * size:
            for i in range(3):
                for j in range(3):
                    D[i, j] = right[i, j]
            return True
        for i in range(n):
            base[i], way[i] = x[i], right[i, 3]
        step, before = 1.0, worst
        for _ in range(_HALVINGS):
            for i in range(n):
                x[i] = base[i] + step * way[i]
            worst = _system(on_cone, x, trial, bulk, shear, cone, tension, matrix, right)
            if worst < (1.0 - 1.0e-4 * step) * before or worst <= _RESIDUAL * size:
                break
            step *= 0.5
    return False


@kernel
def return_to_cone(
    trial: FloatArray,
    bulk: float,
    shear: float,
    cone: FloatArray,
    tension: float,
    new: FloatArray,
    D: FloatArray,
) -> bool:
    """Return sorted principal trial stresses (3,) outside the limit to it; whether it was found.

    Parameters
    ----------
    trial, bulk, shear
        kPa.
    cone
        (5,), from :func:`cone_of`.
    tension
        kPa, inf: no cut-off.
    new, D
        Filled: stresses (3,), kPa, and their derivatives by the principal strains (3, 3).
    """
    size = abs(trial[0]) + abs(trial[2]) + cone[1]
    attraction = cone[1] / cone[0] if cone[0] > 0.0 else math.inf
    cut = tension < math.inf and (cone[2] == 0.0 or tension < attraction)  # Matsuoka-Nakai has no more tension
    first = np.zeros(4)
    smooth = _onto_cone(trial, bulk, shear, cone, first)
    for count in range(4):
        x = np.zeros(4 + count)
        for way in range(2):
            # Tension planes alone, then with the cone, which begins where they ended.
            on_cone = way == 1
            if (count > 0 and not cut) or (count == 0 and not on_cone) or (count == 3 and on_cone):
                continue
            if count == 0:
                if smooth < 1:
                    continue
                for i in range(4):
                    x[i] = first[i]
            elif not on_cone or count == 2:
                for i in range(3):
                    x[i] = trial[i] if i < 3 - count else -tension
                if on_cone:  # where both planes meet the cone in triaxial compression
                    x[0] = (cone[1] - tension - 2.0 / 3.0 * cone[0] * tension) / (1.0 - cone[0] / 3.0)
            if not _solve(on_cone, x, trial, bulk, shear, cone, tension, D):
                continue
            admissible = cone_excess(x, cone) <= _EXCESS * size
            for i in range(4 + count):
                if i < 3:
                    new[i] = x[i]
                    admissible &= not cut or x[i] >= -tension - _EXCESS * size
                else:
                    admissible &= x[i] >= -_EXCESS * size
            if admissible:
                return True
    if smooth == 0 and attraction < math.inf and attraction <= tension:
        for i in range(3):
            new[i] = -attraction
            for j in range(3):
                D[i, j] = 0.0
        return True
    return False


@kernel
def cone_step(
    stress: FloatArray,
    strain: FloatArray,
    bulk: float,
    shear: float,
    cone: FloatArray,
    tension: float,
    new: FloatArray,
    tangent: FloatArray,
) -> int:
    """One step of linear elasticity with the limit; 0: elastic, 1: at the limit, -1: no return was found.

    Parameters
    ----------
    stress, strain
        (n,), n = 4 or 6: kPa, and strain increment with engineering shear; they stay as they are.
    bulk, shear, cone, tension
        As for :func:`return_to_cone`.
    new, tangent
        Filled: stress (n,), and d stress/d strain of this algorithm (n, n).
    """
    elastic_trial(stress, strain, bulk, shear, new, tangent)
    trial = np.zeros(6)
    for i in range(new.shape[0]):
        trial[i] = new[i]
    values, axes = principal_axes(trial)
    size = abs(values[0]) + abs(values[2]) + cone[1]
    if cone_excess(values, cone) <= _ELASTIC * size and -values[2] <= tension + _ELASTIC * size:
        return 0
    returned, D = np.empty(3), np.empty((3, 3))
    if not return_to_cone(values, bulk, shear, cone, tension, returned, D):
        return -1
    turned_back(values, returned, D, axes, shear, size, new, tangent)
    return 1
