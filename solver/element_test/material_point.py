"""A material point led through stages of mixed stress and strain control."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.constitutive.soft_soil_creep import SoftSoilCreep, equivalent_pressure
from geoswarm.solver.element_test.controls import Stage
from geoswarm.solver.element_test.mixed_step import follow_stage
from geoswarm.solver.errors import DivergedError

__all__ = ["History", "PointState", "follow"]


@dataclass(frozen=True)
class PointState:
    """State of a material point: stress (6,), kPa; strain (6,); ln of the preconsolidation pressure, kPa."""

    stress: FloatArray
    strain: FloatArray
    log_pp: float

    @classmethod
    def from_stress(cls, stress: Sequence[float] | FloatArray, soil: SoftSoilCreep, OCR: float = 1.0) -> PointState:
        """Unstrained state under a stress, with p_p = OCR p_eq."""
        components = np.array(stress, dtype=np.float64)
        return cls(components, np.zeros(6), math.log(OCR * _equivalent(components, soil)))


@dataclass(frozen=True)
class History:
    """States at the requested times, in their order.

    ``stage`` (m,) 0-based, ``time`` (m,) day since the beginning of that stage, ``stress`` (m, 6) kPa, ``strain``
    (m, 6), ``log_pp`` (m,); and ``end``, the state after the last stage.
    """

    stage: IntArray
    time: FloatArray
    stress: FloatArray
    strain: FloatArray
    log_pp: FloatArray
    end: PointState
    soil: SoftSoilCreep

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

    @property
    def OCR(self) -> FloatArray:
        """p_p/p_eq, shape (m,)."""
        return np.array(
            [
                math.exp(log_pp) / _equivalent(stress, self.soil)
                for stress, log_pp in zip(self.stress, self.log_pp, strict=True)
            ]
        )


def follow(
    soil: SoftSoilCreep,
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
    states: list[tuple[FloatArray, FloatArray, float]] = []
    for index, (stage, points) in enumerate(zip(stages, times, strict=True)):
        x = np.array(points, dtype=np.float64)
        if (np.diff(x) <= 0.0).any() or (x < 0.0).any() or (x > stage.duration).any():
            raise ValueError(f"stage {stage.name}: increasing times from 0 to {stage.duration:g} day are accepted")
        rows, of_stress, values = stage.arrays()
        if stage.instant:
            state = _move(soil, state, stage, rows, of_stress, values, np.zeros(1), 0.0, True, tolerance)[-1]
        reached = [state] if x.size and x[0] == 0.0 else []
        if stage.duration > 0.0:
            later = x[x > 0.0]
            goals = later if later.size and later[-1] == stage.duration else np.append(later, stage.duration)
            path = _move(
                soil, state, stage, rows, of_stress, values, goals, stage.duration, not stage.instant, tolerance
            )
            reached += path[: later.size]
            state = path[-1]
        indices += [index] * x.size
        wanted += x.tolist()
        states += [(one.stress, one.strain, one.log_pp) for one in reached]
    return History(
        np.array(indices, dtype=np.int64),
        np.array(wanted),
        np.array([stress for stress, _, _ in states]).reshape(-1, 6),
        np.array([strain for _, strain, _ in states]).reshape(-1, 6),
        np.array([log_pp for _, _, log_pp in states]),
        state,
        soil,
    )


def _move(
    soil: SoftSoilCreep,
    state: PointState,
    stage: Stage,
    rows: FloatArray,
    of_stress: BoolArray,
    values: FloatArray,
    times: FloatArray,
    duration: float,
    moving: bool,
    tolerance: float,
) -> list[PointState]:
    completed, fraction, stresses, strains, log_pps = follow_stage(
        rows, of_stress, values, duration, moving, times, tolerance, state.stress, state.strain, state.log_pp, soil
    )
    if not completed:
        where = f"{fraction * duration:.6g} day after its beginning" if duration else f"at {fraction:.2%} of its load"
        raise DivergedError(f"stage {stage.name}: no solution {where}")
    return [PointState(stresses[i], strains[i], float(log_pps[i])) for i in range(times.shape[0])]


def _equivalent(stress: FloatArray, soil: SoftSoilCreep) -> float:
    p = float(stress[:3].mean())
    q2 = 1.5 * float(((stress[:3] - p) ** 2).sum()) + 3.0 * float((stress[3:] ** 2).sum())
    return equivalent_pressure(p, q2, soil)[0]
