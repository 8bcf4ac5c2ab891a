"""A calculated oedometer test at constant rate of strain: stages of a consolidating column."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.advance import AS_FOUND
from geoswarm.solver.element_test.column import DONE, NO_STEP, OUTPUT, PAUSED, lead_column, observe
from geoswarm.solver.element_test.legs import Path, PointState
from geoswarm.solver.errors import DivergedError
from geoswarm.solver.laboratory.record import Voids
from geoswarm.solver.laboratory.shear_stages import ShearStage
from geoswarm.solver.laws.base import Soil

__all__ = ["WATER", "Column", "Flow", "lead"]

WATER: Final = 9.81
"""Unit weight of water, kN/m³."""

_CHUNK: Final = 16
_MOST_STEPS: Final = 5_000
_FIRST: Final = 1.0e-4


@dataclass(frozen=True)
class Flow:
    """How water leaves: permeability k_0, m/day, and its growth, ln k over the relative height; height, m."""

    permeability: float
    growth: float
    height: float
    large: bool

    def constants(self, intervals: int) -> tuple[float, float, bool]:
        """As the kernel takes them."""
        return intervals * self.permeability / (WATER * self.height**2), self.growth, self.large


@dataclass
class Column:
    """States of the points of a column from its base to its top: stress (j, n), strain (j,), internal (j, s)."""

    stress: FloatArray
    strain: FloatArray
    internal: FloatArray

    @classmethod
    def of(cls, state: PointState, intervals: int) -> Column:
        """All points alike."""
        count = intervals + 1
        return cls(np.tile(state.stress, (count, 1)), np.zeros(count), np.tile(state.internal, (count, 1)))

    def observed(self, large: bool) -> FloatArray:
        """What is observed, (OUTPUT,)."""
        output = np.empty(OUTPUT)
        observe(self.stress, self.strain, large, output)
        return output


def lead(
    soil: Soil, column: Column, flow: Flow, stages: Sequence[ShearStage], voids: Voids, tolerance: float
) -> tuple[FloatArray, list[Path]]:
    """Lead a column through stages: what is observed before (OUTPUT,), and the path of each stage.

    A stage is led by the settlement over the initial height, or keeps the vertical stress or the settlement.

    Raises
    ------
    DivergedError, InfeasibleError
        No step was found, or a stage leaves no voids; names the stage and how far it came.
    """
    start = column.observed(flow.large)
    paths, before = [], start
    for stage in stages:
        now = float(before[0 if stage.control == "stress" else 1])
        goal = now if stage.hold else stage.targets[0]
        duration = stage.durations[0] if stage.durations is not None else abs(goal - now) / (stage.rate or math.inf)
        path = _follow(soil, column, flow, stage, (now, goal), duration, voids, tolerance, before)
        paths.append(path)
        before = path.ends[-1]
    return start, paths


def _follow(
    soil: Soil,
    column: Column,
    flow: Flow,
    stage: ShearStage,
    ends_of: tuple[float, float],
    duration: float,
    voids: Voids,
    tolerance: float,
    before: FloatArray,
) -> Path:
    law, constants = soil.law, soil.constants
    count = column.strain.size
    guess, limits = np.zeros(count), np.full(count, -1, dtype=np.int64)
    now, length, steps = 0.0, _FIRST, 0
    pieces = [(np.empty((0, 4)), np.empty((0, OUTPUT)), before[np.newaxis])]
    outcome = PAUSED if duration > 0.0 else DONE
    of_state = law.state_weights(constants) / tolerance
    if law.discrete is not None:
        of_state = np.where(law.discrete, AS_FOUND, of_state)
    while outcome == PAUSED:
        bulk = np.array([law.elastic_moduli(constants, float(p))[0] for p in column.stress[:, :3].mean(axis=1)])
        weights = (1.0 / (tolerance * bulk), 1.0 / tolerance, of_state)
        room = (np.empty((_CHUNK, 4)), np.empty((_CHUNK, OUTPUT)), np.empty((_CHUNK, OUTPUT)))
        done, outcome, length = lead_column(
            stage.control == "stress",
            *ends_of,
            duration,
            now,
            length,
            flow.constants(count - 1),
            (column.stress, column.strain, column.internal),
            (law.update.address, constants),
            guess,
            limits,
            weights,
            *room,
        )
        pieces.append((room[0][:done], room[1][:done], room[2][:done]))
        now = float(room[0][done - 1, 1]) if done else now
        steps += done
        voids.check(stage.name, column.strain)
        if outcome == NO_STEP or steps > _MOST_STEPS:
            raise DivergedError(f"stage {stage.name}: no solution {now * duration:.6g} day after its beginning")
    places, middles, ends = (np.concatenate([piece[i] for piece in pieces]) for i in range(3))
    return Path(duration, places, middles, ends, 1)
