"""A material point of any law led through stages of mixed stress and strain control."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.element_test.controls import Stage
from geoswarm.solver.element_test.stage_steps import Movement, PointState, follow_movement
from geoswarm.solver.errors import DivergedError, InfeasibleError
from geoswarm.solver.laws.base import Soil

__all__ = ["History", "PointState", "follow", "point_under"]

_COMPONENTS = 6


def point_under(stress: Sequence[float] | FloatArray, soil: Soil) -> PointState:
    """Unstrained state under a stress (6,), kPa, in which the soil is placed."""
    components = np.array(stress, dtype=np.float64)
    return PointState(components, np.zeros(6), soil.law.initial_state(components, soil.constants))


@dataclass(frozen=True)
class History:
    """States at the requested times, in their order.

    ``stage`` (m,) 0-based, ``time`` (m,) day since the beginning of that stage, ``stress`` (m, 6) kPa, ``strain``
    (m, 6), ``internal`` (m, s), the law's state variables; and ``end``, the state after the last stage.
    """

    stage: IntArray
    time: FloatArray
    stress: FloatArray
    strain: FloatArray
    internal: FloatArray
    end: PointState

    @property
    def p(self) -> FloatArray:
        """Mean stress, kPa, shape (m,)."""
        mean: FloatArray = self.stress[:, :3].mean(axis=1)
        return mean

    @property
    def q(self) -> FloatArray:
        """Deviatoric stress sqrt(3/2 s:s), kPa, shape (m,)."""
        deviator = self.stress[:, :3] - self.p[:, np.newaxis]
        square = 1.5 * (deviator**2).sum(axis=1) + 3.0 * (self.stress[:, 3:] ** 2).sum(axis=1)
        root: FloatArray = np.sqrt(square)
        return root


def follow(
    soil: Soil,
    initial: PointState,
    stages: Sequence[Stage],
    times: Sequence[Sequence[float] | FloatArray],
    *,
    tolerance: float = 1.0e-6,
) -> History:
    """Lead a material point through stages.

    Parameters
    ----------
    soil, initial
        Material and state before the first stage.
    stages
        In the order of their application.
    times
        For each stage, the increasing times since its beginning at which states are wanted, day, from 0 to its
        duration. Time 0 of an instant stage is after its load, that of another stage its beginning.
    tolerance
        Error admitted in strain.

    Raises
    ------
    DivergedError
        No solution was found, for instance because a load is above the strength; names stage and time.
    """
    state = initial
    indices: list[int] = []
    wanted: list[float] = []
    states: list[PointState] = []
    if _COMPONENTS not in soil.law.components:
        raise InfeasibleError(f"{soil.law.title} ({soil.law.kind}) has no stress update for element tests")
    for index, (stage, points) in enumerate(zip(stages, times, strict=True)):
        x = np.array(points, dtype=np.float64)
        if (np.diff(x) <= 0.0).any() or (x < 0.0).any() or (x > stage.duration).any():
            raise ValueError(f"stage {stage.name}: increasing times from 0 to {stage.duration:g} day are accepted")
        controls = stage.arrays()
        if stage.instant:
            state = _move(soil, state, stage, Movement(*controls, 0.0, True), np.zeros(1), tolerance)[-1]
        reached = [state] if x.size and x[0] == 0.0 else []
        if stage.duration > 0.0:
            later = x[x > 0.0]
            goals = later if later.size and later[-1] == stage.duration else np.append(later, stage.duration)
            movement = Movement(*controls, stage.duration, not stage.instant)
            path = _move(soil, state, stage, movement, goals, tolerance)
            reached += path[: later.size]
            state = path[-1]
        indices += [index] * x.size
        wanted += x.tolist()
        states += reached
    return History(
        np.array(indices, dtype=np.int64),
        np.array(wanted),
        np.array([one.stress for one in states]).reshape(-1, 6),
        np.array([one.strain for one in states]).reshape(-1, 6),
        np.array([one.internal for one in states]).reshape(len(states), state.internal.size),
        state,
    )


def _move(
    soil: Soil, state: PointState, stage: Stage, movement: Movement, times: FloatArray, tolerance: float
) -> list[PointState]:
    states, fraction = follow_movement(soil, movement, times, tolerance, state)
    if len(states) < times.size:
        duration = movement.duration
        where = f"{fraction * duration:.6g} day after its beginning" if duration else f"at {fraction:.2%} of its load"
        raise DivergedError(f"stage {stage.name}: no solution {where}")
    return states
