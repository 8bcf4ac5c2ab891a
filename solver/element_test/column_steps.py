"""Error-controlled steps of a consolidating column of points.

A step is taken as one, two and four substeps; what follows is described in :mod:`geoswarm.solver.element_test.advance`.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.element_test.column import (
    PROFILE,
    WORK_ROWS,
    Ground,
    Soils,
    States,
    profile,
    substep,
)
from geoswarm.solver.element_test.step_control import DONE, GROWTH, LOCAL_SHARE, NO_STEP, PAUSED
from geoswarm.solver.kernels.jit import kernel

__all__ = ["lead_column"]

_MOST_TRIES: Final = 100_000
_SMALLEST_STEP: Final = 1.0e-15

Weights = tuple[FloatArray, float, FloatArray]
"""What turns errors of stress (j,), strain and state variables (j, s) into strain over the tolerance; of flags and
counters among the state :data:`geoswarm.solver.element_test.step_control.AS_FOUND`."""
Watch = tuple[FloatArray, FloatArray]
"""Combinations of a profile (w, PROFILE j) that are to be parabolas within a step, and what turns their errors into
strain over the tolerance, (w,)."""


@kernel
def _blend(one: float, two: float, four: float, kink: bool) -> tuple[float, float]:
    """End of a step from its three ways, and its error; a point has few kinks, so that these may be larger."""
    if kink:
        return four, max(abs(four - one), abs(four - two)) * LOCAL_SHARE
    end = (8.0 * four - 6.0 * two + one) / 3.0
    return end, abs(end - 2.0 * four + two)


@kernel
def _whole(
    found: tuple[FloatArray, FloatArray, FloatArray, IntArray],
    limits: IntArray,
    weights: Weights,
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
            if weights[2][j, i] < 0.0:
                end[2][j, i], error = states[6, j, i], 0.0
            worst = max(worst, error * weights[2][j, i])
        if not worst < math.inf:
            return math.inf
    return worst / LOCAL_SHARE


@kernel
def _looked(
    stress: FloatArray, strain: FloatArray, large: bool, watch: Watch, row: FloatArray, seen: FloatArray
) -> None:
    """Fill a profile (PROFILE j,) and what is watched of it (w,)."""
    profile(stress, strain, large, row)
    for i in range(seen.shape[0]):
        total = 0.0
        for j in range(row.shape[0]):
            total += watch[0][i, j] * row[j]
        seen[i] = total


@kernel
def _curved(watch: Watch, seen: FloatArray) -> float:
    """Distance of what is watched from the parabola of the step at its quarter points, over that admitted.

    ``seen`` (7, w): beginning, middle and end of the step, then the ends of its four substeps.
    """
    worst = 0.0
    for i in range(seen.shape[1]):
        low, mid, high = seen[0, i], seen[1, i], seen[2, i]
        early, late = mid - seen[4, i], high - seen[6, i]
        error = abs(0.375 * low + 0.75 * mid - 0.125 * high - seen[3, i] - 0.5 * early)
        error = max(error, abs(0.375 * high + 0.75 * mid - 0.125 * low - seen[5, i] - 0.5 * (early + late)))
        worst = max(worst, error * watch[1][i])
    return worst


@kernel
def _slowing(rate: float, earlier: float, since: float) -> float:
    """The a of a rate that falls as 1/(1 + a t), from the present one and an earlier one; 0 where it does not fall."""
    return (earlier / rate - 1.0) / since if 0.0 < rate < earlier or earlier < rate < 0.0 else 0.0


@kernel
def _expect(
    level: int, k: int, size: float, strain: FloatArray, strains: FloatArray, guess: FloatArray, piece: FloatArray
) -> None:
    """Fill the strain increments expected in a substep, (j,), by rates at the ends of substeps that were taken."""
    for j in range(strain.shape[0]):
        rate, slowing = guess[0, j], guess[1, j]
        whole = strains[0, j] - strain[j]
        if level == 0:
            piece[j] = size * rate / (1.0 + slowing * size)
            continue
        begin = size * rate if rate != 0.0 else whole
        if level == 1:
            piece[j] = 0.25 * (begin + whole) if k == 0 else 0.5 * whole
            continue
        first, second = 2.0 * (strains[1, j] - strain[j]), 2.0 * (strains[2, j] - strains[1, j])
        if rate == 0.0:
            begin = 2.0 * first - second
        if k == 0:
            piece[j] = 0.25 * (0.375 * begin + 0.75 * first - 0.125 * second)
        elif k == 1:
            piece[j] = 0.25 * first
        elif k == 2:
            piece[j] = 0.25 * (-0.125 * begin + 0.75 * first + 0.375 * second)
        else:
            piece[j] = 0.25 * second


@kernel
def lead_column(
    begin: float,
    goal: float,
    duration: float,
    place: float,
    length: float,
    ground: Ground,
    now: States,
    soils: Soils,
    guess: FloatArray,
    limits: IntArray,
    weights: Weights,
    watch: Watch,
    places: FloatArray,
    middles: FloatArray,
    ends: FloatArray,
) -> tuple[int, int, float]:
    """Step through a stage until its end, or until there is no room for more steps.

    Parameters
    ----------
    begin, goal
        What leads the top, at the beginning and at the end of the stage; between them it changes at constant rate.
    duration
        Of the stage, day.
    place, length
        Where the column is, as a fraction of the stage, and a length to try.
    now
        Its states; become those of the last step.
    guess, limits
        (j,): expected strain for each unit of length, and the status of the law in the last step, -1 if there was
        none; become those of the last step.
    places, middles, ends
        Filled for each step: (k, 4) as in :class:`geoswarm.solver.element_test.load_paths.Path`, and the profiles
        in its middle and at its end, (k, PROFILE j).

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
    room = (np.empty((WORK_ROWS, count)), np.zeros(n), np.empty((n, n)))
    piece, seen, row_of = np.empty(count), np.empty((7, watch[1].shape[0])), np.empty(PROFILE * count)
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
                _expect(level, k, size, strain, strains, guess, piece)
                target = begin + (goal - begin) * (place + size * (k + 1) / ways)
                dt = duration * size / ways
                new = (stresses[row], strains[row], states[row])
                if k == 0:
                    through = substep(
                        target, dt, ground, (stress, strain, state), soils, piece, new, statuses[row], room
                    )
                else:
                    old = (stresses[row - 1], strains[row - 1], states[row - 1])
                    through = substep(target, dt, ground, old, soils, piece, new, statuses[row], room)
        if not through:
            length = 0.25 * size
            continue
        error = _whole(found, limits, weights, end, middle)
        large = ground[3]
        _looked(stress, strain, large, watch, row_of, seen[0])
        for k in range(4):
            _looked(stresses[3 + k], strains[3 + k], large, watch, row_of, seen[3 + k])
        _looked(middle[0], middle[1], large, watch, middles[steps], seen[1])
        _looked(end[0], end[1], large, watch, ends[steps], seen[2])
        error = max(error, _curved(watch, seen))
        factor = GROWTH
        if error > 0.0:
            factor = min(GROWTH, max(0.1, 0.9 * error ** (-1.0 / 3.0)))
        if not error <= 1.0:
            length = size * min(factor, 0.9) if error < math.inf else 0.25 * size
            continue
        for j in range(count):
            guess[0, j] = 4.0 * (strains[6, j] - strains[5, j]) / size
            guess[1, j] = _slowing(guess[0, j], 4.0 * (strains[4, j] - strains[3, j]) / size, 0.5 * size)
            strain[j] = end[1][j]
            limits[j] = statuses[6, j]
            for i in range(n):
                stress[j, i] = end[0][j, i]
            for i in range(s):
                state[j, i] = end[2][j, i]
        places[steps, 0], places[steps, 1], places[steps, 2], places[steps, 3] = place, place + size, math.nan, size
        place = 1.0 if cut else place + size
        places[steps, 1] = place
        length = max(size * factor, length) if cut else size * factor
        steps += 1
    return steps, DONE, length
