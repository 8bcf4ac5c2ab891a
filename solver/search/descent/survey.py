"""A look at the whole space through the parameters that enter linearly.

What an objective is worth far from a minimum says little where amplitudes are wrong. At points spread evenly over the
other parameters, the linear ones take their best values (variable projection): what is left shows the basins. The best
of these points are evaluated and become starts of descents.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.descent.projection import (
    admissible,
    far_moves,
    moved,
    project,
    residuals_of,
    slopes_of_moves,
    stretched,
)
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace

__all__ = ["Survey"]

_POINTS = 6  # for each parameter that does not enter linearly
_STARTS = 6
_TRIED = 20  # times as many points are drawn where constraints exclude some


@dataclass(frozen=True, slots=True)
class Survey:
    """Two generations: points with a move of each linear parameter, then the best points with their best values.

    Parameters
    ----------
    linear
        Parameters that enter linearly.
    asked
        Points due for evaluation, shape (n, d), parts of the range.
    projected
        Whether these are the points of the second generation.
    """

    linear: tuple[int, ...]
    asked: FloatArray
    projected: bool = False

    @classmethod
    def begin(cls, space: SearchSpace, centre: FloatArray, linear: tuple[int, ...]) -> Survey | None:
        """Begin with the linear parameters as at ``centre``, shape (d,); None where there is nothing to look at."""
        others = [i for i in range(centre.size) if i not in linear and not space.integer[i]]
        wanted = _POINTS * len(others)
        if not linear or not others:
            return None
        asked: list[FloatArray] = []
        for place in _evenly(_TRIED * wanted, len(others)):
            point = centre.copy()
            point[others] = place
            points = [point, *(moved(point, index, length) for index, length in far_moves(point, linear))]
            if all(admissible(space, other) for other in points):
                asked += points
            if len(asked) == wanted * (len(linear) + 1):
                break
        return cls(linear, np.array(asked)) if asked else None

    def advance(self, space: SearchSpace, runs: Runs) -> Survey | None:
        """The second generation, after the first, the last of the runs; None where no point is worth it."""
        first, each = len(runs.positions) - len(self.asked), len(self.linear) + 1
        found: list[tuple[float, FloatArray]] = []
        for place in range(0, len(self.asked), each):
            rows = tuple(range(first + place, first + place + each))
            if not runs.succeeded[list(rows)].all():
                continue
            point = self.asked[place]
            lengths = tuple(stretched(space, *move) for move in far_moves(point, self.linear))
            columns = slopes_of_moves(runs, rows, lengths)
            best, objective = project(space, point, self.linear, residuals_of(runs, rows[0]), columns)
            if admissible(space, best):
                found.append((objective, best))
        found.sort(key=lambda pair: pair[0])
        return Survey(self.linear, np.array([best for _, best in found[:_STARTS]]), projected=True) if found else None

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, from which :meth:`from_json` restores exactly."""
        return {"linear": list(self.linear), "asked": self.asked.tolist(), "projected": self.projected}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Survey:
        """Restore from :meth:`to_json`."""
        return cls(tuple(data["linear"]), np.array(data["asked"], dtype=np.float64), data["projected"])


def _evenly(count: int, dimension: int) -> FloatArray:
    """Points spread evenly over the unit box and over each of its sides, shape (count, d) (Roberts 2018).

    Multiples of powers of the root of x^(d + 1) = x + 1, which are badly approximated by fractions, modulo 1.
    """
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (dimension + 1))
    steps = root ** -np.arange(1.0, dimension + 1.0)
    return np.asarray((0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0)
