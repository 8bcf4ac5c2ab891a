"""One step of a hypoplastic law: stress, void ratio, intergranular strain and the consistent tangent.

The step is a straight path of strain. Along it the void ratio is exact, (1 + e) exp(volume strain) = const, and stress
and intergranular strain are integrated by the pair of Fehlberg (1969), of order 4 and 5, with substeps whose length
follows the difference of both (explicit with error control, as S. W. Sloan 1987, IJNME 24, 893-911, with a higher
order). The derivative of stress by the strain of the step is integrated with it, by the linearised rate equation: it is
that of the substeps taken (as W. Fellin & A. Ostermann 2002, IJNAMG 26, 1213-1233, but not by differences).

A law comes as five functions of the invariants of stress and the void ratio::

    rate of sigma = A d + B tr(d) 1 + C t (t:d) - (n0 1 + n1 t) |d|,    t = sigma/tr(sigma)

Stress is taken with p_t added to its normal components: a small shift, as implementations for finite elements have it,
gives a cohesion p_t tan(phi) and a stiffness at the surface. Where the shifted mean stress falls below 1e-4 kPa, or the
law is not defined, there is no stress for the step. Shear components are multiplied by sqrt(2) inside, so that sums of
products are tensor products.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.hypoplasticity.clay import CLAY_CONSTANTS
from geoswarm.solver.constitutive.hypoplasticity.intergranular_strain import LEAD, WAY, begin_way, end_of_way
from geoswarm.solver.constitutive.hypoplasticity.rate import CLAY, FIRST, MOST, SAND, Room, fill_invariants, fill_rate
from geoswarm.solver.constitutive.hypoplasticity.sand import SAND_CONSTANTS
from geoswarm.solver.constitutive.local_arrays import local_matrix, local_vector
from geoswarm.solver.kernels.jit import kernel, kernel_in_place

__all__ = ["CLAY", "CONSTANTS", "FIRST", "SAND", "STATE", "hypoplastic_update"]

CONSTANTS: Final = FIRST + max(SAND_CONSTANTS, CLAY_CONSTANTS)

STATE: Final = 8
"""State variables: void ratio, intergranular strain (6,), mobilised friction angle in degree."""

_TOLERANCE: Final = 1.0e-8
"""Error of a substep, relative in stress, over R in intergranular strain."""

_ALIGNED: Final = 1.0e-12
"""Part of the intergranular strain across the path that is none."""

_LARGEST_COUNT: Final = 2000
_SHORTEST: Final = 1.0e-10
_LONGEST: Final = 1.0
"""Substep, as strain over R, while the intergranular strain differs from its limit by more than the next number."""

_STEADY: Final = 1.0e-3
_ROOT: Final = math.sqrt(2.0)

# Fehlberg's pair: nodes, weights of the stages, weights of order 5, and these less those of order 4.
_NODES: Final = np.array([0.0, 1 / 4, 3 / 8, 12 / 13, 1.0, 1 / 2])
_STAGES: Final = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [1 / 4, 0.0, 0.0, 0.0, 0.0],
        [3 / 32, 9 / 32, 0.0, 0.0, 0.0],
        [1932 / 2197, -7200 / 2197, 7296 / 2197, 0.0, 0.0],
        [439 / 216, -8.0, 3680 / 513, -845 / 4104, 0.0],
        [-8 / 27, 2.0, -3544 / 2565, 1859 / 4104, -11 / 40],
    ]
)
_WEIGHTS: Final = np.array([16 / 135, 0.0, 6656 / 12825, 28561 / 56430, -9 / 50, 2 / 55])
_ERRORS: Final = np.array([1 / 360, 0.0, -128 / 4275, -2197 / 75240, 1 / 50, 2 / 55])

_SHORT: Final = 1.0e-2
"""Relative change of stress in a substep up to which three stages are tried first: rules of Kutta and the midpoint."""

_SHORT_TOLERANCE: Final = 1.0e-7
"""Error of the midpoint rule; that of Kutta's is smaller by far more than the change of stress, below _TOLERANCE."""


@kernel_in_place
def _short(
    y: FloatArray,
    n: int,
    columns: int,
    now: float,
    part: float,
    scale: float,
    weight: float,
    loading: bool,
    length: float,
    volume: float,
    log_v: float,
    constants: FloatArray,
    room: Room,
    rates: FloatArray,
    trial: FloatArray,
) -> bool:
    """Carry y over a short substep by Kutta's rule of order 3; False, and y as before, where its error is too large.

    The error is that of the midpoint rule, of order 2.
    """
    size = n + n * n + 3
    square = 0.0
    for i in range(n):
        square += rates[0, i] * rates[0, i]
    if not part * math.sqrt(square) <= _SHORT * scale:
        return False
    for i in range(size):
        trial[i] = y[i] + 0.5 * part * rates[0, i]
    if not fill_rate(trial, n, columns, now + 0.5 * part, loading, length, volume, log_v, constants, room, rates[1]):
        return False
    for i in range(size):
        trial[i] = y[i] + part * (2.0 * rates[1, i] - rates[0, i])
    if not fill_rate(trial, n, columns, now + part, loading, length, volume, log_v, constants, room, rates[2]):
        return False
    square = 0.0
    for i in range(n + 1):
        place, share = (i, 1.0 / scale) if i < n else (n + n * n, weight)
        square += (share * part / 6.0 * (rates[0, place] - 2.0 * rates[1, place] + rates[2, place])) ** 2
    if not math.sqrt(square) <= _SHORT_TOLERANCE:
        return False
    for i in range(size):
        y[i] += part / 6.0 * (rates[0, i] + 4.0 * rates[1, i] + rates[2, i])
    return True


@kernel_in_place
def _integrate(
    y: FloatArray,
    n: int,
    columns: int,
    begin: float,
    end: float,
    loading: bool,
    length: float,
    volume: float,
    log_v: float,
    constants: FloatArray,
    room: Room,
    rates: FloatArray,
    trial: FloatArray,
) -> bool:
    """Carry y from one fraction of the path to another by substeps; False where no stress was found."""
    whole = end - begin
    now, part, weight, scale = begin, whole, 0.0, 1.0
    size = n + n * n + 3
    fresh = True
    for _ in range(_LARGEST_COUNT):
        room.way[8] = max(0.1 * part * room.way[2], 1.0e-30)
        if fresh:
            if not fill_rate(y, n, columns, now, loading, length, volume, log_v, constants, room, rates[0]):
                return False
            weight, pace = room.lead[12], room.lead[10]
            square = 0.0
            for i in range(n):
                square += (y[i] + (constants[1] if i < 3 else 0.0)) ** 2
            scale = math.sqrt(square)
            # A transient of h is not stepped over.
            if not loading:
                part = min(part, _LONGEST / room.way[2])
            elif weight * pace > _STEADY * room.way[2]:
                part = min(part, _LONGEST / pace)
        last = part >= 0.999999 * (end - now)
        part = end - now if last else part
        if fresh and _short(
            y, n, columns, now, part, scale, weight, loading, length, volume, log_v, constants, room, rates, trial
        ):
            if last:
                return True
            now += part
            part *= 2.0
            continue
        good = True
        for stage in range(1, 6):
            for i in range(size):
                trial[i] = y[i]
            for old in range(stage):
                share = part * _STAGES[stage, old]
                for i in range(size):
                    trial[i] += share * rates[old, i]
            at = now + part * _NODES[stage]
            good = fill_rate(trial, n, columns, at, loading, length, volume, log_v, constants, room, rates[stage])
            if not good:
                break
        fresh = False
        factor = 0.2
        if good:
            # Of the tensors, so that turned axes have the same substeps.
            square = 0.0
            for i in range(n + 1):
                place, share = (i, 1.0 / scale) if i < n else (n + n * n, weight)
                total = 0.0
                for stage in range(6):
                    total += _ERRORS[stage] * rates[stage, place]
                square += (share * part * total) ** 2
            error = math.sqrt(square) if square < math.inf else math.inf
            if error < math.inf:
                factor = min(5.0, max(0.2, 0.9 * (_TOLERANCE / max(error, 1.0e-20)) ** 0.2))
            good = error <= _TOLERANCE
        if good:
            for stage in range(6):
                share = part * _WEIGHTS[stage]
                for i in range(size):
                    y[i] += share * rates[stage, i]
            if last:
                return True
            now += part
            fresh = True
        part *= factor
        if part < _SHORTEST * whole:
            return False
    return False


@kernel
def hypoplastic_update(
    old: FloatArray,
    strain: FloatArray,
    state: FloatArray,
    constants: FloatArray,
    new: FloatArray,
    new_state: FloatArray,
    tangent: FloatArray,
) -> int:
    """Stress, state and tangent after a step of strain.

    Parameters
    ----------
    old, strain
        (4,) or (6,): stress, kPa, and strain with engineering shear, compression positive.
    state
        (STATE,): void ratio; intergranular strain with engineering shear; mobilised friction angle, degree.
    constants
        Number of the law, p_t (kPa), R (0: without intergranular strain), m_R, m_T, beta_r, chi, and those of the law.
    new, new_state, tangent
        Filled; the tangent (n, n) of a step without strain is that of a reversal.

    Returns
    -------
    int
        0, or -1 where the law gives no stress.
    """
    whole, n = old.shape[0], 3
    R, e = constants[2], state[0]
    for i in range(3, whole):
        if old[i] != 0.0 or strain[i] != 0.0 or (R > 0.0 and state[1 + i] != 0.0):
            n = whole
    if not e > -1.0:
        return -1
    log_v = math.log(1.0 + e)
    y, trial, rates = local_vector(MOST), local_vector(MOST), local_matrix(6, MOST)
    room = Room(local_matrix(2, 6), local_vector(WAY), local_vector(LEAD))
    units, lead, way = room.units, room.lead, room.way
    for i in range(n, n + n * n + 3):
        y[i] = 0.0
    for i in range(6):
        units[0, i], units[1, i] = 0.0, 0.0
    for i in range(WAY):
        way[i] = 0.0
    for i in range(LEAD):
        lead[i] = 0.0
    lead[0], lead[2], lead[3], lead[6], lead[7], lead[8] = 1.0, 1.0, 1.0, 1.0, 1.0, 1.0
    length, volume = 0.0, strain[0] + strain[1] + strain[2]
    along, across, total = 0.0, 0.0, 0.0
    for i in range(n):
        y[i] = old[i] if i < 3 else _ROOT * old[i]
        units[0, i] = strain[i] if i < 3 else strain[i] / _ROOT
        length += units[0, i] * units[0, i]
        if R > 0.0:
            units[1, i] = (state[1 + i] if i < 3 else state[1 + i] / _ROOT) / R
            total += units[1, i] * units[1, i]
    length, total = math.sqrt(length), math.sqrt(total)
    if not (length < math.inf and total < math.inf):
        return -1
    if length == 0.0:
        # The tangent of a reversal: at its beginning, and without N.
        lead[2], lead[8], way[0], way[8] = 0.0, 0.0, -min(total, 1.0), 1.0e-30
        for i in range(n):
            units[0, i] = units[1, i] / total if total > 0.0 else 0.0
            units[1, i] = 0.0
        if not fill_rate(y, n, n, 0.0, False, 0.0, 0.0, log_v, constants, room, trial):
            return -1
        for i in range(n, n + n * n + 3):
            y[i] = trial[i]
    else:
        for i in range(n):
            units[0, i] /= length
            along += units[0, i] * units[1, i]
        for i in range(n):
            units[1, i] -= along * units[0, i]
            across += units[1, i] * units[1, i]
        across = math.sqrt(across)
        if not across > _ALIGNED * total:
            across = 0.0
        for i in range(n):
            units[1, i] = units[1, i] / across if across > 0.0 else 0.0
        columns, turn = n, 0.0
        if n == 3 and y[0] == y[2] and units[0, 0] == units[0, 2] and units[1, 0] == units[1, 2]:
            columns = 2  # x and z are the same: the column of z is left out, and does not change
            for stage in range(6):
                for i in range(9, 12):
                    rates[stage, i] = 0.0
        if R > 0.0:
            excess = max(math.hypot(along, across), 1.0)  # beyond 1 by rounding or extrapolation
            y[n + n * n], y[n + n * n + 1] = begin_way(along / excess, across / excess, length / R, constants[5], way)
            turn = way[3]
        for loading in (False, True):
            begin, end = (turn, 1.0) if loading else (0.0, turn)
            if begin < end and not _integrate(
                y, n, columns, begin, end, loading, length, volume, log_v, constants, room, rates, trial
            ):
                return -1
        if columns == 2:
            y[9], y[10], y[11] = y[5], y[4], y[3]
        along, across = end_of_way(y[n + n * n], constants, way) if R > 0.0 else (0.0, 0.0)
    for i in range(n + n * n + 3):
        if not abs(y[i]) < math.inf:
            return -1
    _, j, k = fill_invariants(y, n, constants[1], trial, rates[0])
    new_state[0] = (1.0 + e) * math.exp(-volume) - 1.0
    for i in range(6):
        h = 0.0
        if length == 0.0:
            h = state[1 + i]
        elif i < n:
            h = R * (along * units[0, i] + across * units[1, i])
        new_state[1 + i] = h if i < 3 or length == 0.0 else h * _ROOT
    # Matsuoka and Nakai: sin^2 of the friction angle of a triaxial state of the same I1 I2/I3.
    square = (j - 3.0 * k) / max(8.0 / 27.0 - (j + k) / 3.0, 1.0e-30)
    new_state[7] = math.degrees(math.asin(math.sqrt(min(max(square, 0.0), 1.0))))
    for i in range(n, whole):
        new[i] = 0.0
        for m in range(whole):
            tangent[i, m], tangent[m, i] = 0.0, 0.0
        tangent[i, i] = 0.5 * y[n + n * n + 2]
    for i in range(n):
        turned = 1.0 if i < 3 else 1.0 / _ROOT
        new[i] = y[i] * turned
        for m in range(n):
            tangent[i, m] = y[n + n * m + i] * (turned if m < 3 else turned / _ROOT)
    return 0
