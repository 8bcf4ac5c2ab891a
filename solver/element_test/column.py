"""One-dimensional consolidation of a specimen of any law, coupled: error-controlled steps of a column of points.

The column is drained at its top and closed at its base; it has no horizontal strain and no weight. With the height Z
of solid particles, from 0 at the base to 1, the present over the initial length J, the pore pressure u and the flow v
of water upwards past the particles::

    dJ/dt + dv/dZ = 0,    v = -(k/gamma_w) (1/J) du/dZ,    sigma' + u = the same everywhere,    u = 0 at the top

(Gibson, England & Hussey 1967; J = exp(-strain)). With small strain J = 1 - strain, and 1/J is left out. Points are
equally spaced with one on each end; balances of water are kept exactly for the lengths about them, half ones at the
ends. So the parabola of u at a constant rate of strain is exact. The permeability is k = k_0 exp(growth (J - 1)),
between two points the mean of theirs. Time is implicit; unknown are the strains of the points, with one equation for
each, in which its neighbours take part.

A step is taken as one, two and four substeps; what follows is told in :mod:`geoswarm.solver.element_test.advance`.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.kernels.jit import kernel
from geoswarm.solver.laws.binary import call_update

__all__ = ["DONE", "NO_STEP", "OUTPUT", "PAUSED", "lead_column", "observe"]

DONE: Final = 0
PAUSED: Final = 1
NO_STEP: Final = 2

OUTPUT: Final = 5
"""Values that are observed: total vertical stress, settlement over initial height, pore pressure at the base, mean
vertical and mean horizontal effective stress over the height of particles."""

_ITERATIONS: Final = 30
_HALVINGS: Final = 8
_FREE: Final = 10
"""Iterations in which what is left may grow."""
_RESIDUAL: Final = 1.0e-13
_MOST_TRIES: Final = 100_000
_SMALLEST_STEP: Final = 1.0e-12
_LOCAL_SHARE: Final = 0.1
_GROWTH: Final = 6.0

Soil = tuple[int, FloatArray]
"""Address of the stress update, and constants."""
Flow = tuple[float, float, bool]
"""N k_0/(gamma_w H^2) in 1/(kPa day) with N intervals, growth of the permeability, whether strain is logarithmic."""
States = tuple[FloatArray, FloatArray, FloatArray]
"""Stress (j, n), strain (j,), state variables (j, s) of the points."""
Room = tuple[FloatArray, FloatArray, FloatArray]
"""Memory: (10, j), (n,), (n, n)."""


@kernel
def _length(strain: float, large: bool) -> float:
    """Present over initial length."""
    return math.exp(-strain) if large else 1.0 - strain


@kernel
def observe(stress: FloatArray, strain: FloatArray, large: bool, output: FloatArray) -> None:
    """Fill what is observed, (OUTPUT,), from stress (j, n) and strain (j,)."""
    last = strain.shape[0] - 1
    settled, vertical, horizontal = 0.0, 0.0, 0.0
    for j in range(last + 1):
        weight = (0.5 if j == 0 or j == last else 1.0) / last
        settled += weight * (1.0 - _length(strain[j], large))
        vertical += weight * stress[j, 1]
        horizontal += weight * 0.5 * (stress[j, 0] + stress[j, 2])
    output[0], output[1], output[2] = stress[last, 1], settled, stress[last, 1] - stress[0, 1]
    output[3], output[4] = vertical, horizontal


@kernel
def _residual(
    by_stress: bool,
    target: float,
    dt: float,
    log_time: float,
    flow: Flow,
    old: States,
    soil: Soil,
    new: States,
    statuses: IntArray,
    room: Room,
) -> float:
    """Fill what is left of each equation at the strain increments in ``room``; the largest one, inf: a law failed.

    ``target`` is the settlement of this substep over the height, or the stress at the top, kPa.
    """
    work, step, tangent = room
    rest, tried, stiff, mobile, slope, length = work[0], work[1], work[2], work[3], work[4], work[5]
    large, growth = flow[2], flow[1]
    last = tried.shape[0] - 1
    for j in range(last + 1):
        step[1] = tried[j]
        status = call_update(soil[0], log_time, step, old[0][j], old[2][j], soil[1], new[0][j], new[2][j], tangent)
        if status < 0:
            return math.inf
        statuses[j] = status
        stiff[j] = tangent[1, 1]
        length[j] = _length(old[1][j] + tried[j], large)
        mobile[j] = math.exp(growth * (length[j] - 1.0))
        slope[j] = -growth * mobile[j]
        if large:
            mobile[j] /= length[j]
            slope[j] = (1.0 - growth * length[j]) * mobile[j]
    below, worst = 0.0, 0.0
    for j in range(last + 1):
        weight = (0.5 if j == 0 or j == last else 1.0) / last
        above = target
        if j < last:
            above = 0.5 * dt * flow[0] * (mobile[j] + mobile[j + 1]) * (new[0][j + 1, 1] - new[0][j, 1])
        rest[j] = weight * (_length(old[1][j], large) - length[j]) - above + below
        if j == last and by_stress:
            rest[j] = (new[0][j, 1] - target) / max(1.0, abs(target))
        below = above
        if not abs(rest[j]) < math.inf:
            return math.inf
        worst = max(worst, abs(rest[j]))
    return worst


@kernel
def _correct(by_stress: bool, target: float, dt: float, flow: Flow, stress: FloatArray, room: Room) -> bool:
    """Put the correction of Newton's method, (j,), in the place of what is left; whether there is one."""
    work = room[0]
    rest, stiff, mobile, slope, length = work[0], work[2], work[3], work[4], work[5]
    lower, diagonal, upper = work[6], work[7], work[8]
    last = rest.shape[0] - 1
    for j in range(last + 1):
        weight = (0.5 if j == 0 or j == last else 1.0) / last
        diagonal[j] = weight * (length[j] if flow[2] else 1.0)
        lower[j], upper[j] = 0.0, 0.0
    for j in range(last):
        mean = 0.5 * dt * flow[0] * (mobile[j] + mobile[j + 1])
        fall = 0.5 * dt * flow[0] * (stress[j + 1, 1] - stress[j, 1])
        here, there = fall * slope[j] - mean * stiff[j], fall * slope[j + 1] + mean * stiff[j + 1]
        diagonal[j] -= here
        upper[j] -= there
        diagonal[j + 1] += there
        lower[j + 1] += here
    if by_stress:
        lower[last], diagonal[last] = 0.0, stiff[last] / max(1.0, abs(target))
    for j in range(1, last + 1):
        if diagonal[j - 1] == 0.0:
            return False
        factor = lower[j] / diagonal[j - 1]
        diagonal[j] -= factor * upper[j - 1]
        rest[j] -= factor * rest[j - 1]
    if diagonal[last] == 0.0:
        return False
    rest[last] = -rest[last] / diagonal[last]
    for k in range(last):
        j = last - 1 - k
        rest[j] = -(rest[j] + upper[j] * rest[j + 1]) / diagonal[j]
    return True


@kernel
def _substep(
    by_stress: bool,
    target: float,
    dt: float,
    flow: Flow,
    old: States,
    soil: Soil,
    piece: FloatArray,
    new: States,
    statuses: IntArray,
    room: Room,
) -> bool:
    """One implicit step of ``dt`` days, from the strain increments guessed in ``piece`` (j,), which are replaced."""
    work = room[0]
    rest, tried = work[0], work[1]
    count = piece.shape[0]
    log_time = math.log(dt)
    goal = target
    if not by_stress:  # settlement in all, so that no error of earlier steps is kept
        for j in range(count):
            weight = (0.5 if j == 0 or j == count - 1 else 1.0) / (count - 1)
            goal -= weight * (1.0 - _length(old[1][j], flow[2]))
    for j in range(count):
        tried[j] = piece[j]
    worst = _residual(by_stress, goal, dt, log_time, flow, old, soil, new, statuses, room)
    if not worst < math.inf:
        for j in range(count):
            piece[j] = 0.0
            tried[j] = 0.0
        worst = _residual(by_stress, goal, dt, log_time, flow, old, soil, new, statuses, room)
        if not worst < math.inf:
            return False
    # Rounding of stresses limits how well balances are kept.
    enough = _RESIDUAL + 4.0e-16 * dt * flow[0] * max(abs(new[0][0, 1]), abs(new[0][count - 1, 1]))
    for iteration in range(_ITERATIONS):
        if worst <= enough:
            break
        if not _correct(by_stress, goal, dt, flow, new[0], room):
            return False
        step, accepted = 1.0, False
        way = work[9]
        for j in range(count):
            way[j] = rest[j]
        for _ in range(_HALVINGS):
            for j in range(count):
                tried[j] = piece[j] + step * way[j]
            now = _residual(by_stress, goal, dt, log_time, flow, old, soil, new, statuses, room)
            # Where points begin to yield, what is left may grow before it falls.
            if now < (1.0 - 1.0e-4 * step) * worst or now <= enough or (iteration < _FREE and now < math.inf):
                worst, accepted = now, True
                break
            step *= 0.5
        if not accepted:
            if not worst <= 100.0 * enough:
                return False
            for j in range(count):
                tried[j] = piece[j]
            _residual(by_stress, goal, dt, log_time, flow, old, soil, new, statuses, room)
            break
        for j in range(count):
            piece[j] = tried[j]
    for j in range(count):
        new[1][j] = old[1][j] + piece[j]
    return bool(worst <= 100.0 * enough)


@kernel
def _blend(one: float, two: float, four: float, kink: bool) -> tuple[float, float]:
    """End of a step from its three ways, and its error; a point has few kinks, so that these may be larger."""
    if kink:
        return four, max(abs(four - one), abs(four - two)) * _LOCAL_SHARE
    end = (8.0 * four - 6.0 * two + one) / 3.0
    return end, abs(end - 2.0 * four + two)


@kernel
def _whole(
    found: tuple[FloatArray, FloatArray, FloatArray, IntArray],
    limits: IntArray,
    weights: tuple[FloatArray, float, FloatArray],
    end: States,
    middle: tuple[FloatArray, FloatArray],
) -> float:
    """Fill end and middle (stress and strain) of a step from its seven substeps; the error over that admitted."""
    stresses, strains, states, statuses = found
    worst = 0.0
    for j in range(limits.shape[0]):
        kink = limits[j] >= 0 and statuses[0, j] != limits[j]
        for row in range(1, 7):
            kink = kink or statuses[row, j] != statuses[0, j]
        for i in range(stresses.shape[2]):
            end[0][j, i], error = _blend(stresses[0, j, i], stresses[2, j, i], stresses[6, j, i], kink)
            middle[0][j, i] = stresses[4, j, i] if kink else 2.0 * stresses[4, j, i] - stresses[1, j, i]
            worst = max(worst, error * weights[0][j])
        end[1][j], error = _blend(strains[0, j], strains[2, j], strains[6, j], kink)
        middle[1][j] = strains[4, j] if kink else 2.0 * strains[4, j] - strains[1, j]
        worst = max(worst, error * weights[1])
        for i in range(states.shape[2]):
            end[2][j, i], error = _blend(states[0, j, i], states[2, j, i], states[6, j, i], kink)
            if weights[2][i] < 0.0:
                end[2][j, i], error = states[6, j, i], 0.0
            worst = max(worst, error * weights[2][i])
        if not worst < math.inf:
            return math.inf
    return worst / _LOCAL_SHARE


@kernel
def _curved(
    found: tuple[FloatArray, FloatArray, FloatArray, IntArray],
    weights: tuple[FloatArray, float, FloatArray],
    large: bool,
    seen: FloatArray,
) -> float:
    """Distance of what is observed from the parabola of the step at its quarter points, over that admitted.

    ``seen`` (7, OUTPUT) has beginning, middle and end of the step in its first rows.
    """
    stresses, strains, _, _ = found
    for k in range(4):
        observe(stresses[3 + k], strains[3 + k], large, seen[3 + k])
    worst = 0.0
    for i in range(seen.shape[1]):
        low, mid, high = seen[0, i], seen[1, i], seen[2, i]
        early, late = mid - seen[4, i], high - seen[6, i]
        error = abs(0.375 * low + 0.75 * mid - 0.125 * high - seen[3, i] - 0.5 * early)
        error = max(error, abs(0.375 * high + 0.75 * mid - 0.125 * low - seen[5, i] - 0.5 * (early + late)))
        worst = max(worst, error * (weights[1] if i == 1 else weights[0][weights[0].shape[0] - 1]))
    return worst


@kernel
def lead_column(
    by_stress: bool,
    begin: float,
    goal: float,
    duration: float,
    place: float,
    length: float,
    flow: Flow,
    now: States,
    soil: Soil,
    guess: FloatArray,
    limits: IntArray,
    weights: tuple[FloatArray, float, FloatArray],
    places: FloatArray,
    middles: FloatArray,
    ends: FloatArray,
) -> tuple[int, int, float]:
    """Step through a stage until its end, or until there is no room for more steps.

    Parameters
    ----------
    by_stress
        Whether ``begin`` and ``goal`` are vertical stresses, kPa, in place of settlements over the initial height.
    duration
        Of the stage, day.
    place, length
        Where the column is, as a fraction of the stage, and a length to try.
    now
        Its states; become those of the last step.
    guess, limits
        (j,): expected strain for each unit of length, and the status of the law in the last step, -1 if there was
        none; become those of the last step.
    weights
        What turns errors of stress (j,), strain and state variables (s,) into strain over the tolerance; of flags and
        counters among the state :data:`geoswarm.solver.element_test.advance.AS_FOUND`.
    places, middles, ends
        Filled for each step: (k, 4) as in :class:`geoswarm.solver.element_test.legs.Path`, and what is observed in its
        middle and at its end, (k, OUTPUT).

    Returns
    -------
    steps, outcome, length
        Number of steps; :data:`DONE`, :data:`PAUSED` or :data:`NO_STEP`; length to try next.
    """
    stress, strain, state = now
    count, n, s = stress.shape[0], stress.shape[1], state.shape[1]
    stresses, strains, states = np.empty((7, count, n)), np.empty((7, count)), np.empty((7, count, s))
    statuses = np.zeros((7, count), dtype=np.int64)
    found = (stresses, strains, states, statuses)
    end = (np.empty((count, n)), np.empty(count), np.empty((count, s)))
    middle = (np.empty((count, n)), np.empty(count))
    room = (np.empty((10, count)), np.zeros(n), np.empty((n, n)))
    piece, seen = np.empty(count), np.empty((7, OUTPUT))
    tries, steps = 0, 0
    while place < 1.0:
        if steps == places.shape[0]:
            return steps, PAUSED, length
        tries += 1
        if tries > _MOST_TRIES or not length > _SMALLEST_STEP:
            return steps, NO_STEP, length
        cut = length >= 0.999999 * (1.0 - place)
        size = 1.0 - place if cut else length
        through = True
        for level in range(3):
            ways = 1 << level
            for k in range(ways):
                if not through:
                    continue
                row = ways - 1 + k
                for j in range(count):
                    if level == 0:
                        piece[j] = guess[j] * size
                    else:
                        half = ways // 2 - 1 + k // 2
                        before = strains[half - 1, j] if k > 1 else strain[j]
                        piece[j] = 0.5 * (strains[half, j] - before)
                target = begin + (goal - begin) * (place + size * (k + 1) / ways)
                dt = duration * size / ways
                new = (stresses[row], strains[row], states[row])
                if k == 0:
                    through = _substep(
                        by_stress, target, dt, flow, (stress, strain, state), soil, piece, new, statuses[row], room
                    )
                else:
                    old = (stresses[row - 1], strains[row - 1], states[row - 1])
                    through = _substep(by_stress, target, dt, flow, old, soil, piece, new, statuses[row], room)
        if not through:
            length = 0.25 * size
            continue
        error = _whole(found, limits, weights, end, middle)
        observe(stress, strain, flow[2], seen[0])
        observe(middle[0], middle[1], flow[2], seen[1])
        observe(end[0], end[1], flow[2], seen[2])
        error = max(error, _curved(found, weights, flow[2], seen))
        factor = _GROWTH
        if error > 0.0:
            factor = min(_GROWTH, max(0.1, 0.9 * error ** (-1.0 / 3.0)))
        if not error <= 1.0:
            length = size * min(factor, 0.9) if error < math.inf else 0.25 * size
            continue
        for j in range(count):
            guess[j] = (end[1][j] - strain[j]) / size
            strain[j] = end[1][j]
            limits[j] = statuses[6, j]
            for i in range(n):
                stress[j, i] = end[0][j, i]
            for i in range(s):
                state[j, i] = end[2][j, i]
        if not by_stress:  # what is prescribed, which blending misses by part of the error admitted
            seen[1, 1] = begin + (goal - begin) * (place + 0.5 * size)
            seen[2, 1] = goal if cut else begin + (goal - begin) * (place + size)
        for i in range(OUTPUT):
            middles[steps, i], ends[steps, i] = seen[1, i], seen[2, i]
        places[steps, 0], places[steps, 1], places[steps, 2], places[steps, 3] = place, place + size, math.nan, size
        place = 1.0 if cut else place + size
        places[steps, 1] = place
        length = max(size * factor, length) if cut else size * factor
        steps += 1
    return steps, DONE, length
