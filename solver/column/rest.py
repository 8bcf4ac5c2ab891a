"""Stress and water in layered ground before anything is built on it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.units import WATER

__all__ = ["GroundAtRest"]


@dataclass(frozen=True)
class GroundAtRest:
    """Layers from the ground surface downwards, under water that is at rest.

    Parameters
    ----------
    thicknesses, unit_weights
        m and kN/m³ (in all, water included), (l,).
    water_table
        Its depth, m; negative: free water.
    surcharge
        Effective stress on the ground surface, kPa.
    """

    thicknesses: FloatArray
    unit_weights: FloatArray
    water_table: float
    surcharge: float

    @cached_property
    def bounds(self) -> FloatArray:
        """Depths of the ground surface and of the lower bounds of layers, m, (l + 1,)."""
        return np.concatenate([np.zeros(1), np.cumsum(self.thicknesses)])

    def water(self, depths: FloatArray | float, settled: FloatArray | float = 0.0) -> FloatArray:
        """Pore pressure at depths, any shape, kPa, that have settled by so much, m: zero above the water table."""
        pressure: FloatArray = WATER * np.maximum(depths - self.water_table + settled, 0.0)
        return pressure

    def effective(self, depths: FloatArray) -> FloatArray:
        """Vertical effective stress at depths, (m,), m, if nothing is left to consolidate, kPa."""
        totals = np.concatenate([np.zeros(1), np.cumsum(self.thicknesses * self.unit_weights)])
        total = self.surcharge + WATER * max(-self.water_table, 0.0) + np.interp(depths, self.bounds, totals)
        stress: FloatArray = total - self.water(depths)
        return stress
