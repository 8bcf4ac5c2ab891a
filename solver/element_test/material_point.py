"""A material point of any law led through stages of mixed stress and strain control."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.element_test.boundary_conditions import Stage
from geoswarm.solver.element_test.load_paths import LoadPath, PointState, follow_load_path, point_under
from geoswarm.solver.laws.base import Soil, mean_and_squared_q

__all__ = ["History", "PointState", "follow", "point_under"]


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
        root: FloatArray = np.sqrt(mean_and_squared_q(self.stress)[1])
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
        Material and state before the first stage, of six components.
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
    state, n = initial, initial.stress.size
    indices: list[int] = []
    wanted: list[float] = []
    rows = [np.empty((0, 2 * n + state.internal.size))]
    for index, (stage, points) in enumerate(zip(stages, times, strict=True)):
        x = np.array(points, dtype=np.float64)
        if (np.diff(x) <= 0.0).any() or (x < 0.0).any() or (x > stage.duration).any():
            raise ValueError(f"stage {stage.name}: times must increase from 0 to {stage.duration:g} day")
        coefficients, of_stress, values = stage.arrays()
        stress_rows, strain_rows = (np.where(own[:, np.newaxis], coefficients, 0.0) for own in (of_stress, ~of_stress))
        if stage.instant:
            load = LoadPath(stage.name, stress_rows, strain_rows, values, 0.0)
            state = follow_load_path(soil, load, state, tolerance, dense=False).end
        if stage.duration > 0.0:
            load_path = LoadPath(stage.name, stress_rows, strain_rows, values, stage.duration, hold=stage.instant)
            path = follow_load_path(soil, load_path, state, tolerance, dense=bool(x.size))
            rows.append(path.at(x / stage.duration))
            state = path.end
        elif x.size:
            rows.append(np.concatenate([state.stress, state.strain, state.internal])[np.newaxis])
        indices += [index] * x.size
        wanted += x.tolist()
    found = np.concatenate(rows)
    return History(
        np.array(indices, dtype=np.int64),
        np.array(wanted),
        found[:, :n],
        found[:, n : 2 * n],
        found[:, 2 * n :],
        state,
    )
