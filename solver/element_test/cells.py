"""Cells of a consolidating column: their heights, and what is measured at a height between them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray

__all__ = ["Cells", "graded"]

_EVEN: Final = 0.1
"""Share of equal heights in graded ones: the least cell is not much smaller than a tenth of the mean."""
_NODES: Final = 4
"""Of an interpolation."""
_SAME: Final = 1.0e-9
"""Part of the height within which a place is on a bound."""


def graded(height: float, count: int, fine_base: bool, fine_top: bool) -> FloatArray:
    """Heights (count,) of cells from base to top that are smaller towards a drained end, by a smooth law.

    Where a load acts at once, pore pressures are steep there; errors still fall with the square of ``count``.
    """
    place = np.arange(count + 1) / count
    if fine_base and fine_top:
        bent = 0.5 - 0.5 * np.cos(math.pi * place)
    elif fine_top:
        bent = np.sin(0.5 * math.pi * place)
    elif fine_base:
        bent = 1.0 - np.cos(0.5 * math.pi * place)
    else:
        bent = place
    return height * np.diff(_EVEN * place + (1.0 - _EVEN) * bent)


@dataclass(frozen=True)
class Cells:
    """Cells of a column from its base.

    Parameters
    ----------
    heights
        (j,), m.
    layers
        Number of the layer of each, (j,), growing from 0.
    open_base
        Whether the base is drained; the top is.
    """

    heights: FloatArray
    layers: IntArray
    open_base: bool

    @cached_property
    def faces(self) -> FloatArray:
        """Heights of the bounds above the base, (j + 1,), m."""
        return np.concatenate([np.zeros(1), np.cumsum(self.heights)])

    @property
    def centres(self) -> FloatArray:
        """Heights of the centres above the base, (j,), m."""
        centres: FloatArray = 0.5 * (self.faces[:-1] + self.faces[1:])
        return centres

    @property
    def share(self) -> FloatArray:
        """Part of the height of the column, (j,)."""
        share: FloatArray = self.heights / self.faces[-1]
        return share

    def below(self, z: float) -> FloatArray:
        """Part of each cell (j,) that lies below a height, m."""
        return np.clip((z - self.faces[:-1]) / self.heights, 0.0, 1.0)

    def holding(self, z: float) -> int:
        """Number of the cell at a height, m; between two it is the lower one."""
        place = int(np.searchsorted(self.faces[1:], z - _SAME * self.faces[-1], side="left"))
        return min(place, self.layers.size - 1)

    def at(self, z: float, zero_at_drains: bool) -> FloatArray:
        """Weights (j,) of the cells that interpolate at a height, m, within its layer, by a cubic.

        ``zero_at_drains``: for an excess pore pressure, that is zero at drained ends and has no slope at a closed base.
        """
        inside = np.flatnonzero(self.layers == self.layers[self.holding(z)])
        places, cells = self.centres[inside].tolist(), inside.tolist()
        if zero_at_drains and inside[-1] == self.layers.size - 1:
            places, cells = [*places, float(self.faces[-1])], [*cells, -1]
        if zero_at_drains and inside[0] == 0:
            places = [0.0 if self.open_base else -places[0], *places]
            cells = [-1 if self.open_base else cells[0], *cells]
        nearest = sorted(range(len(places)), key=lambda i: abs(places[i] - z))[:_NODES]
        weights = np.zeros(self.layers.size)
        for i in nearest:
            if cells[i] >= 0:
                others = [places[k] for k in nearest if k != i]
                weights[cells[i]] += math.prod((z - other) / (places[i] - other) for other in others)
        return weights
