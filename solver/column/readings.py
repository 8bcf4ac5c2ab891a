"""What settlement plates and piezometers in a column show, from profiles of its cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.column.rest import GroundAtRest
from geoswarm.solver.element_test.cells import Cells
from geoswarm.solver.element_test.column import PROFILE

__all__ = ["Readings"]

_WORDS = {
    "settlement": ("Settlement", "settlement", "m"),
    "pore_pressure": ("Pore pressure", "pore pressure", "kPa"),
    "excess_pore_pressure": ("Pore pressure above that of water at rest", "excess pore pressure", "kPa"),
    "effective_stress": ("Vertical effective stress", "effective stress", "kPa"),
    "void_ratio": ("Void ratio", "void ratio", ""),
}


@dataclass(frozen=True)
class Readings:
    """Instruments in a column.

    Parameters
    ----------
    cells, rest
        Of the ground.
    weight, lift, voids
        Of the cells, (j,): effective stress without excess pore pressure before the first stage, kPa; loss of load for
        a unit of lost length, kPa; initial void ratio, None where it is not known.
    depths
        Of the instruments, by their names, m.
    moving
        Whether the water at rest above an instrument grows as it settles.
    """

    cells: Cells
    rest: GroundAtRest
    weight: FloatArray
    lift: FloatArray
    voids: Sequence[float | None]
    depths: Mapping[str, float]
    moving: bool

    @cached_property
    def names(self) -> tuple[tuple[str, str, str, str], ...]:
        """Series: name, description, quantity, unit."""
        found = [("settlement", "Settlement of the ground surface", "settlement", "m")]
        for point, depth in self.depths.items():
            for kind, (text, quantity, unit) in _WORDS.items():
                if kind != "void_ratio" or self._void(depth) is not None:
                    found.append((f"{point}.{kind}", f"{text} at {point}, in a depth of {depth:g} m", quantity, unit))
        return tuple(found)

    def of(self, name: str, rows: FloatArray, reference: FloatArray) -> FloatArray:
        """A series at states.

        Parameters
        ----------
        rows
            Profiles with the change of the load, (m, 3 j + 1).
        reference
            The one from which settlements count, (3 j + 1,).
        """
        point, _, kind = name.rpartition(".")
        depth = self.depths[point] if point else 0.0
        if kind == "settlement":
            return self._settled(depth, rows) - self._settled(depth, reference[np.newaxis])
        if kind == "void_ratio":
            initial = self._void(depth)
            assert initial is not None
            return initial - (1.0 + initial) * self._lost(rows) @ self.cells.at(self._height(depth), False)
        excess = self._excess(depth, rows)
        if kind == "excess_pore_pressure":
            return excess
        if kind == "pore_pressure":
            return self.rest.water(depth, self._settled(depth, rows) if self.moving else 0.0) + excess
        return self.rest.effective(np.array([depth])) + self._level(rows) - excess

    def _height(self, depth: float) -> float:
        """Above the base, m."""
        return max(float(self.cells.faces[-1]) - depth, 0.0)

    def _void(self, depth: float) -> float | None:
        """Initial void ratio of the cell at a depth."""
        return self.voids[self.cells.holding(self._height(depth))]

    def _lost(self, rows: FloatArray) -> FloatArray:
        """Loss of length of the cells over the initial one, (m, j)."""
        count = self.weight.size
        return rows[:, count : 2 * count]

    def _level(self, rows: FloatArray) -> FloatArray:
        """Change of the load that the ground feels, (m,), kPa."""
        level: FloatArray = rows[:, PROFILE * self.weight.size] - self._lost(rows) @ self.lift
        return level

    def _settled(self, depth: float, rows: FloatArray) -> FloatArray:
        """Settlement since the beginning, (m,), m."""
        part = self.cells.heights * self.cells.below(self._height(depth))
        settled: FloatArray = self._lost(rows) @ part
        return settled

    def _excess(self, depth: float, rows: FloatArray) -> FloatArray:
        """Excess pore pressure, (m,), kPa."""
        at = self.cells.at(self._height(depth), True)
        stress = rows[:, : self.weight.size]
        excess: FloatArray = (self._level(rows)[:, np.newaxis] + self.weight - stress) @ at
        return excess
