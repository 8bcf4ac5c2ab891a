"""A calculated oedometer test at constant rate of strain: stages of a consolidating column."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.column import BY_SETTLEMENT, BY_STRESS, PROFILE
from geoswarm.solver.element_test.consolidation import Column, Ground, Movement, Watched, follow_movement
from geoswarm.solver.element_test.load_paths import Path
from geoswarm.solver.laboratory.record import Voids
from geoswarm.solver.laboratory.shear_stages import ShearStage
from geoswarm.solver.laboratory.water_flow import BASE, HORIZONTAL, OUTPUT, STRAIN, STRESS, VERTICAL
from geoswarm.solver.units import WATER

__all__ = ["Flow", "combinations", "lead"]


@dataclass(frozen=True)
class Flow:
    """How water leaves: permeability k_0, m/day, and its growth, ln k over the relative height; height, m."""

    permeability: float
    growth: float
    height: float
    large: bool

    def ground(self, intervals: int) -> Ground:
        """Points at equal distances with one on each end, closed at the base."""
        count = intervals + 1
        share = np.full(count, 1.0 / intervals)
        share[[0, -1]] *= 0.5
        conduct = np.full(count, 2.0 * intervals * self.permeability / (WATER * self.height**2))
        zero = np.zeros(count)
        return Ground(share, conduct, np.full(count, self.growth), zero, zero, zero, zero, False, self.large)


def combinations(share: FloatArray) -> FloatArray:
    """What makes a profile (3 j,) what is observed, (OUTPUT, 3 j), where the last point is on the drained top."""
    count = share.size
    found = np.zeros((OUTPUT, PROFILE, count))
    found[STRESS, 0, -1] = 1.0
    found[STRAIN, 1] = share
    found[BASE, 0, -1], found[BASE, 0, 0] = 1.0, -1.0
    found[VERTICAL, 0] = found[HORIZONTAL, 2] = share
    return found.reshape(OUTPUT, -1)


def lead(
    column: Column, flow: Flow, stages: Sequence[ShearStage], voids: Voids, tolerance: float
) -> tuple[FloatArray, list[Path]]:
    """Lead a column through stages: what is observed before (OUTPUT,), and the path of each stage.

    A stage is led by the settlement over the initial height, or keeps the vertical stress or the settlement.

    Raises
    ------
    DivergedError, InfeasibleError
        No step was found, or a stage leaves no voids; names the stage and how far it came.
    """
    last = column.strain.size - 1
    ground = flow.ground(last)
    combined = combinations(ground.share)
    watched = Watched(combined, np.array([last, -1, last, last, last]))
    start = combined @ column.profile(flow.large)
    paths, before = [], start
    for stage in stages:
        by_stress = stage.control == "stress"
        now = float(before[STRESS if by_stress else STRAIN])
        goal = now if stage.hold else stage.targets[0]
        duration = stage.durations[0] if stage.durations is not None else abs(goal - now) / (stage.rate or math.inf)
        movement = Movement(stage.name, BY_STRESS if by_stress else BY_SETTLEMENT, now, goal, duration)
        found = follow_movement(column, ground, movement, watched, tolerance, voids.check)
        path = found.seen(lambda rows: rows @ combined.T)
        if not by_stress:  # what is prescribed, which steps miss by part of the error admitted
            path.middles[:, STRAIN] = now + (goal - now) * 0.5 * (path.places[:, 0] + path.places[:, 1])
            path.ends[1:, STRAIN] = now + (goal - now) * path.places[:, 1]
        paths.append(path)
        before = path.ends[-1]
    return start, paths
