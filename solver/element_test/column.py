"""One-dimensional consolidation of a column of any laws, coupled: the balances of water of its points.

Each point stands for a part of the height. With the height Z of solid particles at the beginning, the present over
the initial length J, the pore pressure u in excess of the one at rest, and the flow v of water upwards past the
particles::

    dJ/dt + dv/dZ + D = 0,    v = -(k/gamma_w) (1/J) du/dZ,    sigma' + u = level(t) + weight(Z)

(Gibson, England & Hussey 1967; J = exp(-strain)). With small strain J = 1 - strain, and 1/J is left out. ``weight`` is
what acts at the beginning; the submerged weight of particles above a point stays as it is. D = J c u is what drains
take from a mean pressure u (Hansbo 1981). The permeability is k = k_0 exp(growth (J - 1)). Between two points water
passes a part of each, one after the other, so that layers may differ. Time is implicit; unknown are the strains of the
points, with one equation for each, in which its neighbours take part.

Three ways to lead the top: :data:`BY_SETTLEMENT` and :data:`BY_STRESS` have a point on it, whose pore pressure is
zero; then a parabola of u is exact for equal intervals. :data:`BY_LOAD` has the last point half a cell below it.

Steps are described in :mod:`geoswarm.solver.element_test.column_steps`.
"""

from __future__ import annotations

import math
from typing import Final

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.kernels.jit import kernel
from geoswarm.solver.laws.binary import call_update

__all__ = [
    "BY_LOAD",
    "BY_SETTLEMENT",
    "BY_STRESS",
    "CONDUCT",
    "GROUND_ROWS",
    "GROWTH",
    "LIFT",
    "PROFILE",
    "RESIST",
    "SHARE",
    "SINK",
    "WEIGHT",
    "WORK_ROWS",
    "Ground",
    "Room",
    "Soils",
    "States",
    "profile",
    "substep",
]

BY_SETTLEMENT: Final = 0
"""``target`` is the settlement of the top over the height."""
BY_STRESS: Final = 1
"""``target`` is the effective stress at the top, kPa, where a point is."""
BY_LOAD: Final = 2
"""``target`` is the change of the total stress at the top since the beginning, kPa; the last point is below it."""

PROFILE: Final = 3
"""Values of each point that are observed: vertical stress, loss of length over the initial one, horizontal stress."""

SHARE: Final = 0
CONDUCT: Final = 1
GROWTH: Final = 2
WEIGHT: Final = 3
LIFT: Final = 4
SINK: Final = 5
RESIST: Final = 6
GROUND_ROWS: Final = 7
WORK_ROWS: Final = 13

_ITERATIONS: Final = 30
_HALVINGS: Final = 8
_FREE: Final = 10
"""Iterations in which what is left may grow."""
_ROUNDING: Final = 4.0e-16
_CLOSE: Final = 1.0e-13
"""Relative error of a stress that is prescribed."""
_ROUGH: Final = 100.0
"""What may be left, over what should be, where rounding lets no more be gained."""

Soils = tuple[IntArray, FloatArray]
"""Addresses of the stress updates (j,), and constants (j, c)."""
Ground = tuple[FloatArray, int, bool, bool, float]
"""What water meets (7, j), how the top is led, whether the base is drained, whether strain is logarithmic, and what may
be left of a balance, as a part of the height.

Rows: part of the height; k_0/(gamma_w H d) in 1/(kPa day), d being the way from the point to the next part; growth of
ln k with the relative length; effective stress before the first step, kPa; fall of the level for a unit of lost
length, kPa (buoyancy); what drains take, 1/(kPa day), and the share of their own resistance in it.
"""
States = tuple[FloatArray, FloatArray, FloatArray]
"""Stress (j, n), strain (j,), state variables (j, s) of the points."""
Room = tuple[FloatArray, FloatArray, FloatArray]
"""Memory: (WORK_ROWS, j), (n,), (n, n)."""


@kernel
def _length(strain: float, large: bool) -> float:
    """Present over initial length."""
    return math.exp(-strain) if large else 1.0 - strain


@kernel
def profile(stress: FloatArray, strain: FloatArray, large: bool, output: FloatArray) -> None:
    """Fill what is observed, (PROFILE j,), from stress (j, n) and strain (j,)."""
    count = strain.shape[0]
    for j in range(count):
        output[j] = stress[j, 1]
        output[count + j] = 1.0 - _length(strain[j], large)
        output[2 * count + j] = 0.5 * (stress[j, 0] + stress[j, 2])


@kernel
def _residual(
    target: float,
    dt: float,
    log_time: float,
    ground: Ground,
    old: States,
    soils: Soils,
    new: States,
    statuses: IntArray,
    room: Room,
) -> float:
    """Fill what is left of each equation at the strain increments in ``room``; the largest over that admitted.

    inf: a law failed. ``target`` is the settlement of this substep, the stress at the top, or the change of the load.
    """
    work, step, tangent = room
    rest, tried, stiff, mobile, slope, length, excess = work[0], work[1], work[2], work[3], work[4], work[5], work[6]
    before = work[12]
    data, lead, open_base, large, precision = ground
    last = tried.shape[0] - 1
    level = target if lead == BY_LOAD else 0.0
    for j in range(last + 1):
        step[1] = tried[j]
        status = call_update(
            soils[0][j], log_time, step, old[0][j], old[2][j], soils[1][j], new[0][j], new[2][j], tangent
        )
        if status < 0:
            return math.inf
        statuses[j] = status
        stiff[j] = tangent[1, 1]
        length[j] = _length(old[1][j] + tried[j], large)
        mobile[j] = math.exp(data[GROWTH, j] * (length[j] - 1.0))
        slope[j] = -data[GROWTH, j] * mobile[j]
        if large:
            mobile[j] /= length[j]
            slope[j] = (1.0 - data[GROWTH, j] * length[j]) * mobile[j]
        level -= data[LIFT, j] * (1.0 - length[j])
    largest = 0.0
    for j in range(last + 1):
        excess[j] = level + data[WEIGHT, j] - new[0][j, 1]
        largest = max(largest, abs(excess[j]), abs(new[0][j, 1]))
    below, easy_below, worst = 0.0, 0.0, 0.0
    if open_base:
        easy_below = dt * data[CONDUCT, 0] * mobile[0]
        below = -easy_below * excess[0]
    for j in range(last + 1):
        here = data[CONDUCT, j] * mobile[j]
        easy, above = 0.0, 0.0
        if j < last:
            there = data[CONDUCT, j + 1] * mobile[j + 1]
            easy = dt * here * there / (here + there)
            above = easy * (excess[j] - excess[j + 1])
        elif lead == BY_LOAD:
            easy = dt * here
            above = easy * excess[j]
        elif lead == BY_SETTLEMENT:
            above = target
        rest[j] = data[SHARE, j] * (before[j] - length[j]) - above + below
        if data[SINK, j] > 0.0:
            taken = dt * _drained(j, data, mobile[j], length[j], large)
            rest[j] -= taken * excess[j]
            easy += taken
        # Rounding of stresses limits how well balances are kept.
        enough = precision + _ROUNDING * (easy + easy_below) * largest
        if j == last and lead == BY_STRESS:
            rest[j] = (new[0][j, 1] - target) / max(1.0, abs(target))
            enough = _CLOSE
        below, easy_below = above, easy
        if not abs(rest[j]) < math.inf:
            return math.inf
        worst = max(worst, abs(rest[j]) / enough)
    return worst


@kernel
def _drained(j: int, data: FloatArray, mobile: float, length: float, large: bool) -> float:
    """What drains take of a part for a unit of its pressure, 1/(kPa day)."""
    grown = mobile * length if large else mobile
    wide = length if large else 1.0
    return float(data[SHARE, j] * wide * data[SINK, j] * grown / (1.0 + data[RESIST, j] * grown))


@kernel
def _correct(target: float, dt: float, ground: Ground, room: Room) -> bool:
    """Put the correction of Newton's method, (j,), in the place of what is left; whether there is one."""
    work = room[0]
    rest, stiff, mobile, slope, length, excess = work[0], work[2], work[3], work[4], work[5], work[6]
    lower, diagonal, upper, lifted = work[7], work[8], work[9], work[10]
    data, lead, open_base, large, _ = ground
    last = rest.shape[0] - 1
    lifts = False
    for j in range(last + 1):
        stretch = length[j] if large else 1.0
        diagonal[j] = data[SHARE, j] * stretch
        lower[j], upper[j], lifted[j] = 0.0, 0.0, 0.0
        lifts = lifts or data[LIFT, j] != 0.0
        if data[SINK, j] > 0.0:
            taken = dt * _drained(j, data, mobile[j], length[j], large)
            wide, grown = 0.0, mobile[j]
            if large:
                wide, grown = -1.0, mobile[j] * length[j]
            change = wide - data[GROWTH, j] * stretch / (1.0 + data[RESIST, j] * grown)
            diagonal[j] -= taken * (change * excess[j] - stiff[j])
            lifted[j] -= taken
    if open_base:
        easy = dt * data[CONDUCT, 0]
        diagonal[0] -= easy * (slope[0] * excess[0] - mobile[0] * stiff[0])
        lifted[0] -= easy * mobile[0]
    if lead == BY_LOAD:
        easy = dt * data[CONDUCT, last]
        diagonal[last] -= easy * (slope[last] * excess[last] - mobile[last] * stiff[last])
        lifted[last] -= easy * mobile[last]
    for j in range(last):
        here, there = data[CONDUCT, j] * mobile[j], data[CONDUCT, j + 1] * mobile[j + 1]
        both = here + there
        easy, fall = dt * here * there / both, dt * (excess[j] - excess[j + 1])
        by_here = fall * (there / both) ** 2 * data[CONDUCT, j] * slope[j] - easy * stiff[j]
        by_there = fall * (here / both) ** 2 * data[CONDUCT, j + 1] * slope[j + 1] + easy * stiff[j + 1]
        diagonal[j] -= by_here
        upper[j] -= by_there
        diagonal[j + 1] += by_there
        lower[j + 1] += by_here
    if lead == BY_STRESS:
        lower[last], diagonal[last] = 0.0, stiff[last] / max(1.0, abs(target))
    for j in range(1, last + 1):
        if diagonal[j - 1] == 0.0:
            return False
        factor = lower[j] / diagonal[j - 1]
        diagonal[j] -= factor * upper[j - 1]
        rest[j] -= factor * rest[j - 1]
        lifted[j] -= factor * lifted[j - 1]
    if diagonal[last] == 0.0:
        return False
    rest[last] = -rest[last] / diagonal[last]
    lifted[last] /= diagonal[last]
    for k in range(last):
        j = last - 1 - k
        rest[j] = -(rest[j] + upper[j] * rest[j + 1]) / diagonal[j]
        lifted[j] = (lifted[j] - upper[j] * lifted[j + 1]) / diagonal[j]
    if lifts:  # the level falls with all strains at once: Sherman and Morrison
        sunk, share = 0.0, 1.0
        for j in range(last + 1):
            pull = data[LIFT, j] * (length[j] if large else 1.0)
            sunk += pull * rest[j]
            share -= pull * lifted[j]
        if share == 0.0:
            return False
        for j in range(last + 1):
            rest[j] += lifted[j] * sunk / share
    return True


@kernel
def substep(
    target: float,
    dt: float,
    ground: Ground,
    old: States,
    soils: Soils,
    piece: FloatArray,
    new: States,
    statuses: IntArray,
    room: Room,
) -> bool:
    """One implicit step of ``dt`` days, from the strain increments guessed in ``piece`` (j,), which are replaced.

    Whether it was found; ``target`` is a settlement in all.
    """
    work = room[0]
    rest, tried, way = work[0], work[1], work[11]
    count = piece.shape[0]
    log_time = math.log(dt)
    goal, before = target, work[12]
    for j in range(count):
        tried[j], before[j] = piece[j], _length(old[1][j], ground[3])
        if ground[1] == BY_SETTLEMENT:  # settlement in all, so that no error of earlier steps is kept
            goal -= ground[0][SHARE, j] * (1.0 - before[j])
    worst = _residual(goal, dt, log_time, ground, old, soils, new, statuses, room)
    if not worst < math.inf:
        for j in range(count):
            piece[j] = 0.0
            tried[j] = 0.0
        worst = _residual(goal, dt, log_time, ground, old, soils, new, statuses, room)
        if not worst < math.inf:
            return False
    for iteration in range(_ITERATIONS):
        if worst <= 1.0:
            break
        if not _correct(goal, dt, ground, room):
            return False
        step, accepted = 1.0, False
        for j in range(count):
            way[j] = rest[j]
        for _ in range(_HALVINGS):
            for j in range(count):
                tried[j] = piece[j] + step * way[j]
            now = _residual(goal, dt, log_time, ground, old, soils, new, statuses, room)
            # Where points begin to yield, what is left may grow before it falls.
            if now < (1.0 - 1.0e-4 * step) * worst or now <= 1.0 or (iteration < _FREE and now < math.inf):
                worst, accepted = now, True
                break
            step *= 0.5
        if not accepted:
            if not worst <= _ROUGH:
                return False
            for j in range(count):
                tried[j] = piece[j]
            _residual(goal, dt, log_time, ground, old, soils, new, statuses, room)
            break
        for j in range(count):
            piece[j] = tried[j]
    for j in range(count):
        new[1][j] = old[1][j] + piece[j]
    return bool(worst <= _ROUGH)
