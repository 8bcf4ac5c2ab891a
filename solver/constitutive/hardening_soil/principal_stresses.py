"""Principal stresses of a step of hardening soil on given active surfaces and edges, by Newton's method.

Equations and notation: :mod:`geoswarm.solver.constitutive.hardening_soil.surfaces`. The step is implicit; its modulus
is that of the mean of old and new s3, so that the way back of an elastic step ends where it began. On edges of the
pyramids (1: s2 = s3, 2: s1 = s2, 3: both) flow is any mean of the flows of both sides: stresses and flows are averaged
there, and all surfaces are functions of sums of principal stresses whose weights the edge gives.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.hardening_soil.surfaces import (
    HardeningSoil,
    cap_pressure,
    elastic_modulus,
    largest_shear,
    mobilised_dilatancy,
)
from geoswarm.solver.constitutive.local_arrays import local_matrix, local_vector
from geoswarm.solver.constitutive.tensors import fill_principal_axes
from geoswarm.solver.kernels.jit import kernel, kernel_in_place

__all__ = ["BEYOND", "CAP", "SHEAR", "TENSION", "Room", "dot", "solve_on", "trial_stresses"]

_ITERATIONS: Final = 40
_HALVINGS: Final = 8
_RESIDUAL: Final = 1.0e-7
"""What is left of an equation, over the size of the stresses, when the last correction takes it to rounding."""
_WIDE: Final = 11
"""Most columns of a system: unknowns and right-hand sides, the residual, three unit strains, and a relative growth of
the elastic modulus."""
_UNIT: Final = 1
_RIGHT: Final = 4
"""Places of right-hand sides behind the residual."""

_ROUNDS: Final = 8
BEYOND: Final = 1.0e-10
"""What counts as outside a surface, over the size of the stresses."""

SHEAR: Final = 1
CAP: Final = 2
TENSION: Final = 4
"""Surfaces; sums of them are sets of active ones."""


class Room(NamedTuple):
    """Arrays of a step."""

    old: FloatArray
    """(6,): stress before."""

    unit: FloatArray
    """(6,): stress of the strain increment for an elastic modulus of 1."""

    trial: FloatArray
    """(3,): principal trial stresses."""

    slope: FloatArray
    """(3,): their derivative by the elastic modulus."""

    axes: FloatArray
    """(3, 3): their axes, columns."""

    mean: FloatArray
    """(3, 3): averages over an edge; its first and last row are w1 and w3."""

    k: FloatArray
    """(3,): weights of qc."""

    least: FloatArray
    """(3,): weights of s3 in the elastic modulus."""

    D: FloatArray
    """(3, 3): derivatives of the principal stresses by the principal strains."""

    flows: FloatArray
    """(3, 3): of shear, cap and tension."""

    stiffer: FloatArray
    """(3,): derivatives of the principal stresses by the logarithm of the elastic modulus."""


@kernel
def _average(v: FloatArray, edge: int) -> None:
    """Average three values over those that an edge makes the same."""
    if edge == 1:
        v[1] = 0.5 * (v[1] + v[2])
        v[2] = v[1]
    elif edge == 2:
        v[0] = 0.5 * (v[0] + v[1])
        v[1] = v[0]
    elif edge == 3:
        v[0] = (v[0] + v[1] + v[2]) / 3.0
        v[1] = v[0]
        v[2] = v[0]


@kernel
def dot(a: FloatArray, b: FloatArray) -> float:
    total: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return total


@kernel_in_place
def trial_stresses(modulus: float, room: Room) -> None:
    """Fill principal trial stresses, axes and slopes."""
    total, axes, d = local_vector(6), room.axes, room.unit
    for i in range(6):
        total[i] = room.old[i] + modulus * d[i]
    fill_principal_axes(total, room.trial, axes)
    for k in range(3):
        x, y, z = axes[0, k], axes[1, k], axes[2, k]
        room.slope[k] = d[0] * x * x + d[1] * y * y + d[2] * z * z + 2.0 * (d[3] * x * y + d[4] * y * z + d[5] * z * x)


@kernel_in_place
def _weigh(edge: int, trial: FloatArray, size: float, soil: HardeningSoil, room: Room) -> None:
    """Fill the weights of an edge."""
    k, t = room.k, trial
    for i in range(3):
        for j in range(3):
            room.mean[i, j] = 1.0 if i == j else 0.0
        room.least[i] = 1.0 if i == 2 else 0.0
    for i in range(3):
        _average(room.mean[i], edge)
    k[0], k[1], k[2] = 1.0, soil.delta - 1.0, -soil.delta
    _average(k, edge)
    # Without an edge the minor stress of equal trial stresses is their mean: no axis is preferred.
    same = edge
    if edge == 0 and t[1] - t[2] <= BEYOND * size:
        same = 3 if t[0] - t[1] <= BEYOND * size else 1
    _average(room.least, same)


@kernel_in_place
def _system(
    u: FloatArray,
    active: int,
    edge: int,
    gamma: float,
    pressure: float,
    cap_rate: float,
    least_old: float,
    fixed: float,
    n: int,
    soil: HardeningSoil,
    room: Room,
    rows: FloatArray,
) -> float:
    """Fill the linearised equations for u (6,), principal stresses and the multipliers of shear, cap and tension.

    Unknown are the stresses and the multipliers of active surfaces, n: ``rows`` (n of 6, 11), with a matrix (n, n) on
    the left and five right-hand sides from column n on: the residual, stress of the unit principal strains, and of a
    relative growth of the elastic modulus. Returns the largest residual, kPa.
    """
    w, k, flows = room.mean, room.k, room.flows
    E, E_s = fixed, 0.0
    if fixed == 0.0:
        E, E_s = elastic_modulus(least_old, dot(room.least, u), soil)
    trial_stresses(E, room)
    _average(room.trial, edge)
    _average(room.slope, edge)
    lame = soil.poisson / ((1.0 + soil.poisson) * (1.0 - 2.0 * soil.poisson))
    twice = 1.0 / (1.0 + soil.poisson)
    high, low, along = dot(w[0], u), dot(w[2], u), dot(k, u)
    sine, sine_high, sine_low = mobilised_dilatancy(high, low, soil)
    X = (u[0] + u[1] + u[2]) / 3.0 + soil.attraction
    inverse = 1.0 / (soil.alpha * soil.alpha)
    P = max(math.sqrt(along * along * inverse + X * X), 1.0e-9)
    by_P = 1.0 / P
    X_P = X * by_P
    for i in range(3):
        flows[0, i] = 0.5 * (1.0 - sine) * w[0, i] - 0.5 * (1.0 + sine) * w[2, i]
        flows[1, i] = (k[i] * along * inverse + X / 3.0) * by_P
        flows[2, i] = -w[2, i]
    volume = -sine * u[3] + X_P * u[4] - u[5]
    worst = 0.0
    for i in range(3):
        relaxed = lame * volume + twice * (u[3] * flows[0, i] + u[4] * flows[1, i] + u[5] * flows[2, i])
        rest = room.trial[i] - u[i] - E * relaxed
        rows[i, n + _RIGHT] = E * (room.slope[i] - relaxed)
        rows[i, n] = rest
        worst = max(worst, abs(rest))
        stiffer = (relaxed - room.slope[i]) * E_s
        for j in range(3):
            sine_j = sine_high * w[0, j] + sine_low * w[2, j]
            bend = (k[i] * k[j] * inverse + 1.0 / 9.0 - flows[1, i] * flows[1, j]) * by_P
            of_volume = (1.0 / 3.0 - X_P * flows[1, j]) * by_P
            change = -0.5 * u[3] * (w[0, i] + w[2, i]) * sine_j + u[4] * bend
            rows[i, j] = E * (lame * (-u[3] * sine_j + u[4] * of_volume) + twice * change) + stiffer * room.least[j]
            rows[i, n + _UNIT + j] = E * (lame + twice * w[i, j])
        rows[i, i] += 1.0
    at = 3
    for surface in range(3):
        if not active & (1 << surface):
            continue
        dilation = X_P if surface == 1 else (-sine if surface == 0 else -1.0)
        rest = soil.tension + low
        for i in range(3):
            rows[i, at] = E * (twice * flows[surface, i] + lame * dilation)
            rows[at, i] = -w[2, i]
            rows[at, 3 + i] = 0.0
        for i in range(_UNIT, _RIGHT + 1):
            rows[at, n + i] = 0.0
        if surface == 0:
            limit, limit_low, limit_gamma = largest_shear(gamma + u[3], low, soil)
            rows[at, at], rest = -limit_gamma, limit - high + low
            rows[at, n + _RIGHT] = limit_gamma * u[3] * soil.stiffening
            for i in range(3):
                rows[at, i] = w[0, i] - (1.0 + limit_low) * w[2, i]
        elif surface == 1:
            cap, cap_volume = cap_pressure(pressure, cap_rate, u[4] * X_P, soil)
            rows[at, at], rest = -cap_volume * X_P, cap + soil.attraction - P
            for i in range(3):
                rows[at, i] = flows[1, i] - cap_volume * u[4] * (1.0 / 3.0 - X_P * flows[1, i]) * by_P
        rows[at, n] = rest
        worst = max(worst, abs(rest)) if rest == rest else math.inf
        at += 1
    return worst if worst == worst else math.inf


@kernel_in_place
def _solve(rows: FloatArray, n: int, width: int) -> bool:
    """Put the solution of a system in the place of its right-hand sides, up to column ``width``; whether there is one.

    Gaussian elimination as :func:`geoswarm.solver.constitutive.tensors.solve_dense` has it, in one piece of memory.
    """
    for i in range(n):
        scale = 0.0
        for j in range(n):
            scale = max(scale, abs(rows[i, j]))
        if not 0.0 < scale < math.inf:
            return False
        scale = 1.0 / scale
        for j in range(width):
            rows[i, j] *= scale
    for i in range(n):
        pivot = i
        for k in range(i + 1, n):
            if abs(rows[k, i]) > abs(rows[pivot, i]):
                pivot = k
        if not abs(rows[pivot, i]) > 1.0e-300:
            return False
        if pivot != i:
            for j in range(i, width):
                rows[i, j], rows[pivot, j] = rows[pivot, j], rows[i, j]
        inverse = 1.0 / rows[i, i]
        for j in range(i + 1, width):
            rows[i, j] *= inverse
        for k in range(i + 1, n):
            factor = rows[k, i]
            if factor != 0.0:
                for j in range(i + 1, width):
                    rows[k, j] -= factor * rows[i, j]
    for i in range(n - 2, -1, -1):
        for k in range(i + 1, n):
            factor = rows[i, k]
            for j in range(n, width):
                rows[i, j] -= factor * rows[k, j]
    return True


@kernel_in_place
def _newton(
    u: FloatArray,
    active: int,
    edge: int,
    gamma: float,
    pressure: float,
    cap_rate: float,
    least_old: float,
    size: float,
    fixed: float,
    soil: HardeningSoil,
    room: Room,
) -> bool:
    """Newton's method with line search from u; elastic modulus ``fixed`` unless that is 0. Whether u was found."""
    n = 3 + (active & 1) + (active >> 1 & 1) + (active >> 2 & 1)
    rows, base, way = local_matrix(6, _WIDE), local_vector(6), local_vector(6)
    for i in range(6):
        way[i] = 0.0
        for j in range(_WIDE):
            rows[i, j] = 0.0
    worst = _system(u, active, edge, gamma, pressure, cap_rate, least_old, fixed, n, soil, room, rows)
    for _ in range(_ITERATIONS):
        last = worst <= _RESIDUAL * size  # only then the tangent is asked for
        right = (_RIGHT + 1 if soil.scaled else _RIGHT) if last else _UNIT
        if not worst < math.inf or not _solve(rows, n, n + right):
            return False
        at = 3
        for i in range(6):
            if i < 3:
                way[i] = rows[i, n]
            elif active & (1 << (i - 3)):
                way[i] = rows[at, n]
                at += 1
        if last:
            for i in range(6):
                u[i] += way[i]
            for i in range(3):
                room.stiffer[i] = rows[i, n + _RIGHT]
                for j in range(3):
                    room.D[i, j] = rows[i, n + _UNIT + j]
            return True
        for i in range(6):
            base[i] = u[i]
        step, before = 1.0, worst
        for _ in range(_HALVINGS):
            for i in range(6):
                u[i] = base[i] + step * way[i]
            worst = _system(u, active, edge, gamma, pressure, cap_rate, least_old, fixed, n, soil, room, rows)
            if worst < (1.0 - 1.0e-4 * step) * before or worst <= _RESIDUAL * size:
                break
            step *= 0.5
    return False


@kernel_in_place
def solve_on(
    u: FloatArray,
    active: int,
    edge: int,
    gamma: float,
    pressure: float,
    cap_rate: float,
    least_old: float,
    size: float,
    careful: bool,
    soil: HardeningSoil,
    room: Room,
) -> bool:
    """Solve from u, elastic stresses; fills D, stiffer, flows and trial. Whether u was found.

    ``careful``: first with fixed elastic moduli, each that of the solution before. Where the stress ends far from the
    elastic one, Newton's method with the modulus as a function of stress may go the wrong way.
    """
    _weigh(edge, u, size, soil, room)
    _average(u, edge)
    if careful:
        for _ in range(_ROUNDS):
            fixed = elastic_modulus(least_old, dot(room.least, u), soil)[0]
            if not _newton(u, active, edge, gamma, pressure, cap_rate, least_old, size, fixed, soil, room):
                return False
    found: bool = _newton(u, active, edge, gamma, pressure, cap_rate, least_old, size, 0.0, soil, room)
    return found
