"""The error-controlled steps of a material point through one movement of its controls, or one hold."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.element_test.mixed_step import three_ways
from geoswarm.solver.laws.base import Soil

__all__ = ["Movement", "PointState", "follow_movement"]

_MAX_STEPS: Final = 20000
_SMALLEST_STEP: Final = 1.0e-13
_FIRST_MOVE: Final = 1.0e-3  # of the movement
_FIRST_HOLD: Final = 0.02  # of logarithmic time
_LOCAL_SHARE: Final = 0.1
_KINK_SHARE: Final = 0.1


@dataclass(frozen=True)
class PointState:
    """State of a material point: stress (6,), kPa; strain (6,); the law's state variables (s,)."""

    stress: FloatArray
    strain: FloatArray
    internal: FloatArray


@dataclass(frozen=True)
class Movement:
    """What the controls do.

    Parameters
    ----------
    rows, of_stress, values
        As :meth:`geoswarm.solver.element_test.controls.Stage.arrays` gives them; ``values`` of strain rows are changes
        over the whole movement.
    duration
        Day; 0: an instantaneous movement.
    moving
        Whether the controls move to their values, linearly in time; otherwise all stay as they are.
    """

    rows: FloatArray
    of_stress: BoolArray
    values: FloatArray
    duration: float
    moving: bool


def follow_movement(
    soil: Soil, movement: Movement, times: FloatArray, tolerance: float, state: PointState
) -> tuple[list[PointState], float]:
    """Follow a movement of the controls, or a hold, with error-controlled steps.

    A hold is stepped in the logarithmic time of :mod:`geoswarm.solver.element_test.constant_load`, with the time scale
    of the law. One, two and three implicit substeps a step are extrapolated to third order; the difference between
    second and third order, in strain (stress over the bulk modulus, state variables by their weights), is the error.
    Every requested time ends a step.

    Parameters
    ----------
    times
        Shape (m,), increasing, in (0, duration]; the last must be ``duration``. For an instantaneous movement [0].
    tolerance
        Error admitted in strain.
    state
        At the beginning.

    Returns
    -------
    states, fraction
        States at the times, fewer than m where no step was found; fraction of the movement reached.
    """
    law, constants, duration = soil.law, soil.constants, movement.duration
    start = np.where(movement.of_stress, movement.rows @ state.stress, 0.0)
    goal = movement.values if movement.moving else start
    holding = duration > 0.0 and not movement.moving
    local, weights = _LOCAL_SHARE * tolerance, law.state_weights(constants)
    length, now = (_FIRST_HOLD if holding else _FIRST_MOVE), 0.0
    guess, guess_length = np.zeros(6), 1.0
    ends = np.empty((3, 6)), np.empty((3, 6)), np.empty((3, state.internal.size))
    steps, limit = 0, 0
    reached: list[PointState] = []
    for time in times.tolist():
        until = time / duration if duration > 0.0 else 1.0
        while now < until:
            # Length of a step: a fraction of the movement, or logarithmic time in a hold.
            whole, log_time, log_length = until - now, -math.inf, 0.0
            if holding:
                log_time = _log_scale(soil, state, duration)
                whole = float(np.logaddexp(0.0, math.log((until - now) * duration) - log_time))
            steps += 1
            if steps > _MAX_STEPS or length < _SMALLEST_STEP * whole:
                return reached, now
            cut = length >= 0.999999 * whole
            size = whole if cut else length
            end = until if cut else now + size
            if holding:
                log_length = size
                if not cut:
                    end = now + math.exp(log_time + size + math.log(-math.expm1(-size))) / duration
            elif duration > 0.0:
                log_time = math.log(duration * size)
            status = three_ways(
                movement.rows,
                movement.of_stress,
                goal,
                start,
                now,
                end,
                log_time,
                log_length,
                state.stress,
                state.internal,
                guess * (size / guess_length),
                law.update.address,
                constants,
                *ends,
            )
            if status < 0:
                length = 0.25 * size
                continue
            stress, strain, internal = (4.5 * one[2] - 4.0 * one[1] + 0.5 * one[0] for one in ends)
            low_stress, low_strain, low_internal = (3.0 * one[2] - 2.0 * one[1] for one in ends)
            compliance = 1.0 / law.elastic_moduli(constants, float(state.stress[:3].mean()))[0]
            error = max(
                float(np.abs(strain - low_strain).max()),
                compliance * float(np.abs(stress - low_stress).max()),
                float((weights * np.abs(internal - low_internal)).max(initial=0.0)),
            )
            if status != limit:
                # A limit was reached or left within the step: too late for the extrapolation to see. What happened
                # must be small itself.
                error = max(error, _KINK_SHARE * compliance * float(np.abs(stress - state.stress).max()))
            factor = 5.0
            if error > 0.0:
                factor = min(5.0, max(0.1, 0.9 * (local / error) ** (1.0 / 3.0)))
            if not error <= local:
                length = size * min(factor, 0.9) if error < math.inf else 0.25 * size
                continue
            now, limit = end, status
            state = PointState(stress, state.strain + strain, internal)
            guess, guess_length = strain, size
            # A step that was cut short to end at a time says nothing against the longer one planned.
            length = max(size * factor, length) if cut else size * factor
        reached.append(state)
    return reached, now


def _log_scale(soil: Soil, state: PointState, duration: float) -> float:
    """ln(theta/day) of the law at a state; where time has no effect, that of the duration."""
    scale = soil.law.log_time_scale(state.stress, state.internal, soil.constants)
    return math.log(duration) if scale is None else float(scale)
