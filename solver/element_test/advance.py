"""Error-controlled steps of a material point of any law along a load path: a movement of its controls, or a hold.

A step is taken as one, two and four implicit substeps. Where the law does not change its limit in it, the ends are
extrapolated to third order and the middles of the last two to second order; the difference between the second and
third order at the end is the error. Where it does (a kink), the ways have no common expansion: the four substeps count
as they are, and the difference between all ways is the error.

Between the ends of a step the point is on the parabola through beginning, middle and end. Its distance from the
quarter points of the four substeps, corrected as beginning, middle and end are, is kept below the tolerance as well:
an update may be exact for a step of any length whose path is curved.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.element_test.mixed_step import Room, mixed_step
from geoswarm.solver.element_test.step_control import DONE, GROWTH, LOCAL_SHARE, NO_STEP, PAUSED
from geoswarm.solver.kernels.jit import kernel

__all__ = ["advance"]

_MOST_TRIES: Final = 200_000
_SMALLEST_STEP: Final = 1.0e-13

Controls = tuple[FloatArray, FloatArray, BoolArray, FloatArray, FloatArray]
Points = tuple[FloatArray, FloatArray, FloatArray, IntArray]


@kernel
def _way(
    count: int,
    controls: Controls,
    begin: float,
    end: float,
    log_time: float,
    log_length: float,
    stress: FloatArray,
    strain: FloatArray,
    state: FloatArray,
    guess: FloatArray,
    address: int,
    constants: FloatArray,
    points: Points,
    target: FloatArray,
    piece: FloatArray,
    room: Room,
) -> bool:
    """Go from one place of a load path to another in ``count`` implicit substeps.

    Parameters
    ----------
    controls
        Combinations of stress and of strain (n, n), whether they are of stress (n,), values at the beginning of the
        load path and at its end (n,).
    begin, end
        Places as fractions of the load path.
    log_time, log_length
        Substeps are equal in time, ``log_time`` being ln(time/day) of all; or, for ``log_length`` above 0, equal in
        logarithmic time s = 0 .. ``log_length``, ``log_time`` then being ln(theta/day).
    stress, strain, state
        At ``begin``; strain since the beginning of the load path.
    guess
        (n,): expected strain increment; of the first way only.
    points
        Filled with what is found after each substep, from row ``count - 1`` on: stress, strain since ``begin``, state,
        status of the law. Rows of the ways before serve as guesses.
    """
    stress_rows, strain_rows, of_stress, start, goal = controls
    stresses, strains, states, statuses = points
    n = stress.shape[0]
    for step in range(count):
        row = count - 1 + step
        fraction = begin + (end - begin) * (step + 1) / count
        for i in range(n):
            if count == 1:
                piece[i] = guess[i]
            else:
                half = count // 2 - 1 + step // 2  # the substep of the way before in which this one lies
                before = strains[half - 1, i] if step > 1 else 0.0
                piece[i] = 0.5 * (strains[half, i] - before)
        for i in range(n):
            target[i] = start[i] + (goal[i] - start[i]) * fraction
            for k in range(n):
                done = strain[k] + (strains[row - 1, k] if step > 0 else 0.0)
                target[i] -= strain_rows[i, k] * done
        share = log_time - math.log(count)
        if log_length > 0.0:
            s = log_length / count
            share = log_time + (step + 1) * s + math.log(-math.expm1(-s))
        status = mixed_step(
            stress_rows,
            strain_rows,
            of_stress,
            target,
            stress if step == 0 else stresses[row - 1],
            share,
            state if step == 0 else states[row - 1],
            address,
            constants,
            piece,
            stresses[row],
            states[row],
            room,
        )
        if status < 0:
            return False
        statuses[row] = status
        for i in range(n):
            strains[row, i] = piece[i] + (strains[row - 1, i] if step > 0 else 0.0)
    return True


@kernel
def _combine(
    found: FloatArray,
    first: FloatArray,
    kink: bool,
    weights: FloatArray,
    middle: FloatArray,
    end: FloatArray,
    offset: int,
    share: float,
    dense: bool,
) -> float:
    """Fill middle and end of a step from the seven rows of its ways; the error over that admitted.

    ``found`` (7, m); ``first`` (m,) at the beginning; ``weights`` (m,) turn errors into strain over the tolerance, of
    which ``share`` is granted to the end, or are
    :data:`geoswarm.solver.element_test.step_control.AS_FOUND`;
    ``offset`` of the m values in ``middle`` and ``end``.
    """
    worst = 0.0
    for i in range(first.shape[0]):
        one, two, four = found[0, i], found[2, i], found[6, i]
        if weights[i] < 0.0:
            end[offset + i], middle[offset + i] = four, found[4, i]
            continue
        if kink:
            end[offset + i], middle[offset + i] = four, found[4, i]
            error = max(abs(four - one), abs(four - two))
        else:
            end[offset + i] = (8.0 * four - 6.0 * two + one) / 3.0
            middle[offset + i] = 2.0 * found[4, i] - found[1, i]
            error = abs(end[offset + i] - 2.0 * four + two)
        error /= share
        if dense:
            low, mid, high = first[i], middle[offset + i], end[offset + i]
            early, late = mid - found[4, i], high - four
            error = max(error, abs(0.375 * low + 0.75 * mid - 0.125 * high - found[3, i] - 0.5 * early))
            error = max(error, abs(0.375 * high + 0.75 * mid - 0.125 * low - found[5, i] - 0.5 * (early + late)))
        error *= weights[i]
        if not error < math.inf:
            return math.inf
        worst = max(worst, error)
    return worst


@kernel
def advance(
    controls: Controls,
    log_duration: float,
    log_theta: float,
    place: float,
    length: float,
    stress: FloatArray,
    strain: FloatArray,
    state: FloatArray,
    guess: FloatArray,
    address: int,
    constants: FloatArray,
    weights: tuple[FloatArray, FloatArray, FloatArray],
    p_range: tuple[float, float],
    dense: bool,
    places: FloatArray,
    middles: FloatArray,
    ends: FloatArray,
) -> tuple[int, int, float]:
    """Step along a load path until its end, until there is no room for more steps, or until p leaves a range.

    Parameters
    ----------
    controls
        As for one way.
    log_duration
        ln(duration/day) of the load path; -inf: it is instantaneous.
    log_theta
        ln(theta/day) of a hold, which is stepped in s = ln(1 + t/theta), t being the time since ``place``; nan for a
        movement of the controls.
    place, length
        Where the point is, as a fraction of the load path, and a length to try, in fractions or in s.
    stress, strain, state
        There, (n,), (n,) since the beginning of the load path, and (s,); become those of the last step.
    guess
        (n,): expected strain for each unit of length; becomes that of the last step.
    weights
        For stress, strain and state, (n,), (n,), (s,): what turns their errors into strain over the tolerance; of flags
        and counters among the state :data:`geoswarm.solver.element_test.step_control.AS_FOUND`.
    p_range
        Mean stress, kPa, between which the weights hold.
    dense
        Whether values between the ends of steps will be wanted.
    places, middles, ends
        Filled for each step: beginning and end, ln(theta/day) and length in s of a hold, (k, 4); stress, strain and
        state in the middle and at the end, (k, 2 n + s).

    Returns
    -------
    steps, outcome, length
        Number of steps; :data:`DONE`, :data:`PAUSED` or :data:`NO_STEP`; length to try next.
    """
    n, s = stress.shape[0], state.shape[0]
    points = (np.empty((7, n)), np.empty((7, n)), np.empty((7, s)), np.zeros(7, dtype=np.int64))
    stresses, strains, states, statuses = points
    room = (np.empty(n), np.empty(n), np.empty((n, 1)), np.empty((n, n)), np.empty((n, n)))
    target, piece, expected, nothing = np.empty(n), np.empty(n), np.empty(n), np.zeros(n)
    hold = log_theta == log_theta
    limit, tries, steps = -1, 0, 0
    while place < 1.0:
        if steps == places.shape[0]:
            return steps, PAUSED, length
        mean = (stress[0] + stress[1] + stress[2]) / 3.0
        if steps > 0 and not p_range[0] <= mean <= p_range[1]:
            return steps, PAUSED, length
        whole, log_time = 1.0 - place, log_duration
        if hold:
            x = math.log(whole) + log_duration - log_theta
            whole, log_time = (x if x > 0.0 else 0.0) + math.log1p(math.exp(-abs(x))), log_theta
        tries += 1
        if tries > _MOST_TRIES or not length > _SMALLEST_STEP * whole:
            return steps, NO_STEP, length
        cut = length >= 0.999999 * whole
        size = whole if cut else length
        end = 1.0 if cut else place + size
        if hold and not cut:
            end = place + math.exp(log_theta + size + math.log(-math.expm1(-size)) - log_duration)
        if not hold:
            log_time += math.log(size)
        for i in range(n):
            expected[i] = guess[i] * size
        through = True
        for level in range(3):
            through = through and _way(
                1 << level,
                controls,
                place,
                end,
                log_time,
                size if hold else 0.0,
                stress,
                strain,
                state,
                expected,
                address,
                constants,
                points,
                target,
                piece,
                room,
            )
        if not through:
            length = 0.25 * size
            continue
        kink = limit >= 0 and statuses[0] != limit
        for row in range(1, 7):
            kink = kink or statuses[row] != statuses[0]
        middle, final = middles[steps], ends[steps]
        error = _combine(stresses, stress, kink, weights[0], middle, final, 0, LOCAL_SHARE, dense)
        error = max(error, _combine(strains, nothing, kink, weights[1], middle, final, n, LOCAL_SHARE, dense))
        error = max(error, _combine(states, state, kink, weights[2], middle, final, 2 * n, LOCAL_SHARE, dense))
        factor = GROWTH
        if error > 0.0:
            factor = min(GROWTH, max(0.1, 0.9 * error ** (-0.5 if kink else -1.0 / 3.0)))
        if not error <= 1.0:
            length = size * min(factor, 0.9) if error < math.inf else 0.25 * size
            continue
        places[steps, 0], places[steps, 1], places[steps, 2], places[steps, 3] = place, end, log_theta, size
        for i in range(n):
            stress[i] = final[i]
            guess[i] = final[n + i] / size
            middle[n + i] += strain[i]
            strain[i] += final[n + i]
            final[n + i] = strain[i]
        for i in range(s):
            state[i] = final[2 * n + i]
        if hold:
            # What the creep of this step has done to its pace: as if its stress had been there from the beginning.
            log_theta += size
        place, limit = end, statuses[6]
        # A step that was cut short to end with the load path says nothing against the longer one planned.
        length = max(size * factor, length) if cut else size * factor
        steps += 1
    return steps, DONE, length
