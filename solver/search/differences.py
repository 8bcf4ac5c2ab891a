"""Where to evaluate for derivatives of fourth order at an optimum: one generation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.search.space import SearchSpace

__all__ = ["DifferenceDesign", "plan_differences"]

_CENTRAL = (-1.0, -0.5, 0.5, 1.0)
_ABOVE = (0.25, 0.5, 0.75, 1.0)


@dataclass(frozen=True, slots=True)
class DifferenceDesign:
    """Where to evaluate for the sensitivities at an optimum.

    Parameters
    ----------
    optimum
        Shape (d,), natural values.
    positions
        Shape (n, d), natural values; the first is the optimum.
    parameter
        Which parameter each position moves, shape (n,); -1 for the optimum.
    offset
        By how much, shape (n,), in parts of the range between the bounds in search coordinates.
    """

    optimum: FloatArray
    positions: FloatArray
    parameter: IntArray
    offset: FloatArray

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, from which :meth:`from_json` restores exactly."""
        return {
            "optimum": self.optimum.tolist(),
            "positions": self.positions.tolist(),
            "parameter": self.parameter.tolist(),
            "offset": self.offset.tolist(),
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> DifferenceDesign:
        """Restore from :meth:`to_json`."""
        return cls(
            np.array(data["optimum"], dtype=np.float64),
            np.array(data["positions"], dtype=np.float64),
            np.array(data["parameter"], dtype=np.int64),
            np.array(data["offset"], dtype=np.float64),
        )


def plan_differences(space: SearchSpace, optimum: FloatArray, step: float) -> DifferenceDesign:
    """Plan the optimum and four places along each parameter, 4 d + 1 at most.

    Central places where both sides are inside the bounds and feasible, otherwise all on one side.

    Parameters
    ----------
    optimum
        Shape (d,), natural values, inside the bounds.
    step
        Largest offset in parts of the range in search coordinates.
    """
    optimum = np.asarray(optimum, dtype=np.float64)
    low, span = space.search_lower, space.search_upper - space.search_lower
    centre = (space.to_search(optimum) - low) / span
    positions, parameter, offset = [optimum], [-1], [0.0]
    for index in range(space.dimension):
        best: tuple[int, list[float], list[FloatArray]] = (-1, [], [])
        for pattern in (_CENTRAL, _ABOVE, tuple(-v for v in _ABOVE)):
            offsets, points = [], []
            for part in pattern:
                unit = centre.copy()
                unit[index] += part * step
                point = optimum.copy()  # the others stay as they are, to the last digit
                point[index] = space.to_natural(low + unit * span)[index]
                if 0.0 <= unit[index] <= 1.0 and space.feasible(point):
                    offsets.append(part * step)
                    points.append(point)
            if len(points) > best[0]:
                best = (len(points), offsets, points)
        positions += best[2]
        offset += best[1]
        parameter += [index] * best[0]
    return DifferenceDesign(optimum, np.array(positions), np.array(parameter, dtype=np.int64), np.array(offset))
