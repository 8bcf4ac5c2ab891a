"""One step of the hardening soil model with its consistent tangent, for a plane or a general stress.

Equations and notation: :mod:`geoswarm.solver.constitutive.hardening_soil.surfaces`. The step is one of principal
stresses on the axes of the elastic trial stress. Which surfaces are active and on which edge the stress ends is found
by trying.
"""

from __future__ import annotations

import math
from typing import Final

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.hardening_soil.principal_stresses import (
    BEYOND,
    CAP,
    SHEAR,
    TENSION,
    Room,
    dot,
    solve_on,
    trial_stresses,
)
from geoswarm.solver.constitutive.hardening_soil.surfaces import (
    HardeningSoil,
    cap_pressure,
    cap_rate,
    elastic_modulus,
    largest_shear,
    shear_strain,
)
from geoswarm.solver.constitutive.local_arrays import local_matrix, local_vector
from geoswarm.solver.constitutive.principal_return import turned_back
from geoswarm.solver.constitutive.tensors import fill_principal_axes, fill_rotation_matrix
from geoswarm.solver.kernels.jit import kernel, kernel_in_place

__all__ = ["hardening_soil_step"]

_TRIES: Final = 12
_CLOSE: Final = 0.1
"""Change of the elastic modulus from which Newton's method begins: from further away it may go the wrong way."""

_MOST: Final = 100.0
"""Largest growth of the modulus in that search: with m = 1 there may be no elastic stress."""
_PAIRS: Final = ((0, 1), (1, 2), (2, 0))

FAILURE: Final = 8
EDGE: Final = 16
"""Parts of the status beside the active surfaces: strength reached, and times the number of the edge."""


@kernel
def _violated(s: FloatArray, active: int, gamma: float, pressure: float, size: float, soil: HardeningSoil) -> int:
    """Surfaces, but for ``active`` ones, outside which sorted principal stresses are."""
    beyond = 0
    if not active & SHEAR and s[0] - s[2] - largest_shear(gamma, s[2], soil)[0] > BEYOND * size:
        beyond |= SHEAR
    if not active & CAP:
        X = (s[0] + s[1] + s[2]) / 3.0 + soil.attraction
        along = (s[0] + (soil.delta - 1.0) * s[1] - soil.delta * s[2]) / soil.alpha
        if math.sqrt(along * along + X * X) - soil.attraction - pressure > BEYOND * size:
            beyond |= CAP
    if not active & TENSION and -s[2] - soil.tension > BEYOND * size:
        beyond |= TENSION
    return beyond


@kernel_in_place
def _split(u: FloatArray, edge: int, trial: FloatArray, E: float, size: float, soil: HardeningSoil, room: Room) -> bool:
    """Whether the flows of both sides of an edge, in some share, bring the trial stresses (3,) together."""
    if edge == 0:
        return True
    flows, twice = room.flows, E / (1.0 + soil.poisson)
    sine = -(flows[0, 0] + flows[0, 1] + flows[0, 2])
    X = (u[0] + u[1] + u[2]) / 3.0 + soil.attraction
    along = dot(room.k, u)
    P = max(math.sqrt(along * along / (soil.alpha * soil.alpha) + X * X), 1.0e-9)
    bend = u[4] * along / (soil.alpha * soil.alpha * P)
    gap, apart = 0.0, 0.0
    if edge == 1:
        gap = trial[1] - trial[2]
        apart = 0.5 * (1.0 + sine) * u[3] + (2.0 * soil.delta - 1.0) * bend + u[5]
    elif edge == 2:
        gap = trial[0] - trial[1]
        apart = 0.5 * (1.0 - sine) * u[3] + (2.0 - soil.delta) * bend
    if edge < 3:
        return gap <= twice * apart + BEYOND * size
    # All three: by the cut-off, which can only stretch.
    total = trial[0] + trial[1] + trial[2] - 3.0 * u[0]
    return (1.0 + soil.poisson) * float(trial[0] - u[0]) <= soil.poisson * float(total) + BEYOND * size


@kernel_in_place
def hardening_soil_step(
    stress: FloatArray,
    strain: FloatArray,
    gamma: float,
    pressure: float,
    soil: HardeningSoil,
    new: FloatArray,
    tangent: FloatArray,
    by_stiffness: FloatArray,
) -> tuple[float, float, int]:
    """One step.

    Parameters
    ----------
    stress, strain
        (n,), n = 4 or 6: kPa, and strain increment with engineering shear; they stay as they are.
    gamma, pressure
        Plastic shear strain of the shear surface and p_p, kPa, before the step.
    soil
        Constants.
    new, tangent
        Filled: stress (n,), and d stress/d strain of this algorithm (n, n).
    by_stiffness
        Filled: derivative of the stress by the logarithm of the elastic modulus, (n,), kPa.

    Returns
    -------
    gamma, p_p, status
        At the end; 0: elastic, above: what is active, -1: no stress was found.
    """
    n = stress.shape[0]
    room = Room(
        local_vector(6),
        local_vector(6),
        local_vector(3),
        local_vector(3),
        local_matrix(3, 3),
        local_matrix(3, 3),
        local_vector(3),
        local_vector(3),
        local_matrix(3, 3),
        local_matrix(3, 3),
        local_vector(3),
    )
    lame = soil.poisson / ((1.0 + soil.poisson) * (1.0 - 2.0 * soil.poisson))
    twice = 1.0 / (1.0 + soil.poisson)
    volume = strain[0] + strain[1] + strain[2]
    for i in range(6):
        room.old[i], room.unit[i] = 0.0, 0.0
    for i in range(n):
        room.old[i] = stress[i]
        room.unit[i] = lame * volume + twice * strain[i] if i < 3 else 0.5 * twice * strain[i]
    fill_principal_axes(room.old, room.trial, room.axes)
    least_old = room.trial[2]
    E, E_s = elastic_modulus(least_old, least_old, soil)
    size = 0.0
    most = _MOST * E
    for _ in range(_TRIES):
        trial_stresses(E, room)
        if size == 0.0:
            size = abs(room.trial[0]) + abs(room.trial[2]) + soil.attraction + 1.0e-3
        before = E
        E = min(elastic_modulus(least_old, room.trial[2], soil)[0], most)
        if abs(E - before) <= _CLOSE * E:
            break
    if not size < math.inf:
        return gamma, pressure, -1
    first, u = local_vector(3), local_vector(6)
    for i in range(3):
        first[i] = room.trial[i]
    active, edge, found = _violated(first, 0, gamma, pressure, size, soil), 0, False
    if active & SHEAR:  # mostly shear alone brings an elastic stress beyond the cut-off back; else it is found below
        active &= ~TENSION
    if active and first[0] - first[2] > BEYOND * size:  # two equal trial stresses stay equal, as in triaxial tests
        edge = 1 if first[1] - first[2] <= BEYOND * size else (2 if first[0] - first[1] <= BEYOND * size else 0)
    # The last try leads to the next one; so once more, with care; then all sets of surfaces and edges.
    begin, tries, careful, listed, slow = (active, edge), 0, False, -1, 0.0
    for _ in range(2 * _TRIES + 32):
        if listed < 0 and tries == _TRIES:
            tries = 0
            if careful:
                listed = 0
            else:
                careful = True
                active, edge = begin
        if listed >= 0:
            edge, active = listed // 8, listed % 8
            listed += 1
            if edge > 3:
                break
            if edge > 0 and active == 0:
                continue
        tries += 1
        for i in range(6):
            u[i] = first[i] if i < 3 else 0.0
        if active & CAP and slow == 0.0:
            slow = cap_rate(pressure, soil)
        if not solve_on(u, active, edge, gamma, pressure, slow, least_old, size, careful, soil, room):
            tries = _TRIES
            continue
        E, E_s = elastic_modulus(least_old, dot(room.least, u), soil)
        if edge > 0:
            trial_stresses(E, room)  # without means
        apart, below = u[0] - u[1], u[1] - u[2]
        if min(apart, below) < -BEYOND * size:
            edge = 3 if edge > 0 else (1 if below < apart else 2)
            continue
        negative = 0
        for k in range(3):
            if u[3 + k] < -BEYOND * size / E:
                negative |= 1 << k
        beyond = _violated(u, active, gamma + u[3], pressure, size, soil)
        if negative == 0 and beyond == 0:
            if _split(u, edge, room.trial, E, size, soil, room):
                found = True
                break
            edge = 0
        active = (active & ~negative) | beyond
        if active == 0:
            edge = 0
    if not found:
        return gamma, pressure, -1
    if not _finish(u, edge, E, E_s, size, soil, room, new, tangent, by_stiffness):
        return gamma, pressure, -1
    status = active + EDGE * edge
    after, cap = gamma, pressure
    if active & SHEAR:
        most = shear_strain(soil.strength * max(u[2] + soil.attraction, 0.0), u[2], soil)
        if gamma + u[3] >= most:
            status |= FAILURE
        after = max(gamma, min(gamma + u[3], most))
    if active & CAP:
        X = (u[0] + u[1] + u[2]) / 3.0 + soil.attraction
        along = dot(room.k, u) / soil.alpha
        cap = cap_pressure(pressure, slow, u[4] * X / max(math.sqrt(along * along + X * X), 1.0e-9), soil)[0]
    if not (cap < math.inf and after < math.inf):
        return gamma, pressure, -1
    return after, cap, status


@kernel_in_place
def _finish(
    u: FloatArray,
    edge: int,
    E: float,
    E_s: float,
    size: float,
    soil: HardeningSoil,
    room: Room,
    new: FloatArray,
    tangent: FloatArray,
    by_stiffness: FloatArray,
) -> bool:
    """Fill stress components and their derivatives from the solution u; whether they are numbers.

    The shear stress on the trial axes is that of the trial times the ratio of the differences of the principal
    stresses, and the trial depends on the elastic modulus, too.
    """
    n = new.shape[0]
    shear, by_strain, Q, d = 0.5 * E / (1.0 + soil.poisson), local_vector(3), local_matrix(6, 6), local_vector(3)
    for j in range(3):
        by_strain[j] = 0.0
        for i in range(3):
            by_strain[j] += E_s * room.least[i] * room.D[i, j]
    # Nothing resists a difference of two strains on an edge. Where it is none yet, as in triaxial tests, elastic
    # stiffness keeps it so.
    i, j = (1, 2) if edge == 1 else (0, 1)
    if 0 < edge < 3 and room.trial[i] - room.trial[j] <= BEYOND * size:
        room.D[i, i] += shear
        room.D[j, j] += shear
        room.D[i, j] -= shear
        room.D[j, i] -= shear
    unturned = turned_back(room.trial, u, room.D, room.axes, shear, size, new, tangent)
    sheared = False
    for k in range(3, 6):
        sheared = sheared or room.unit[k] != 0.0
    good = True
    if unturned and not sheared:  # nothing turns
        for i in range(n):
            by_stiffness[i] = 0.0
        for i in range(3):
            good = good and abs(new[i]) < math.inf
            for k in range(3):
                by_stiffness[i] += room.axes[i, k] * room.stiffer[k]
            for j in range(3):
                good = good and abs(tangent[i, j]) < math.inf
        return good
    fill_rotation_matrix(room.axes, Q)
    for k in range(3):
        i, j = _PAIRS[k]
        total = 0.0
        for m in range(3):
            a, b = room.axes[m, i], room.axes[m, j]
            other = (m + 1) % 3
            total += room.unit[m] * a * b
            total += room.unit[3 + m] * (a * room.axes[other, j] + b * room.axes[other, i])
        gap = room.trial[i] - room.trial[j]
        ratio = (u[i] - u[j]) / gap if abs(gap) > 1.0e-9 * size else 0.0
        d[k] = ratio * total
    for i in range(n):
        turn = Q[i, 3] * d[0] + Q[i, 4] * d[1] + Q[i, 5] * d[2]
        by_stiffness[i] = turn * (E + E_s * dot(room.least, room.stiffer))
        for k in range(3):
            by_stiffness[i] += Q[i, k] * room.stiffer[k]
        for j in range(n):
            tangent[i, j] += turn * (Q[j, 0] * by_strain[0] + Q[j, 1] * by_strain[1] + Q[j, 2] * by_strain[2])
            good = good and abs(tangent[i, j]) < math.inf
        good = good and abs(new[i]) < math.inf
    return good
