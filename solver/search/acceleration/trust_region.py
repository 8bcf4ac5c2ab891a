"""A trust region on the response surface: how far from the best run of a descent the surface is believed.

As in derivative-free least squares (DFO-LS: Cartis, Fiala, Marteau & Roberts 2019): a descent begins with a simplex of
d + 1 runs, each step is the minimum of the model in a box, the box grows or shrinks by how much of the
promised decrease came true, and where the runs nearby do not span all directions, a run that does is made before the
box shrinks. The model is the interpolating surface of all runs, so no simplex of its own has to be kept.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["BEGUN", "SETTLED", "TrustRegion", "missing_direction", "spanned"]

BEGUN = 0.2  # half the width of the first box in the unit box
_WIDEST, _GROWTH, _DECAY = 0.5, 2.0, 0.5
_KEPT, _MISSED = 0.7, 0.1  # shares of the promised decrease
SETTLED = 1e-4  # half the width at which nothing is left to gain
_NEAR, _LEAST = 2.0, 0.1  # reach within which runs count, and their least part in a direction, in half widths


@dataclass(frozen=True, slots=True)
class TrustRegion:
    """State of a descent between two generations.

    ``radius``: half the width of the box, in the unit box; ``since``: number of the first run that belongs to the
    descent; ``promised``: lowest objective that the steps of the generation under way promise, None: it has no step;
    ``missed``: the last step did not keep its promise.
    """

    radius: float = BEGUN
    since: int = 0
    promised: float | None = None
    missed: bool = False

    def after(
        self, points: FloatArray, objectives: FloatArray, count: int, steps: list[int], unseen: int = 0
    ) -> TrustRegion:
        """Return the state when a generation is known.

        Parameters
        ----------
        points, objectives
            Of all runs, the generation last, unit box, shapes (N, d) and (N,); inf where one failed.
        count
            Runs of the generation.
        steps
            Which of them, counted from 0, were steps of the trust region.
        unseen
            Number of runs before the generation that were not known yet when it was asked.
        """
        first = len(points) - count
        mine = objectives[self.since : max(first - unseen, 0)]
        if self.promised is None or not steps or not np.isfinite(mine).any():
            return replace(self, promised=None, missed=False)
        lowest = self.since + int(np.argmin(mine))
        before, found = float(objectives[lowest]), float(objectives[first:].min())
        kept = (before - found) / max(before - self.promised, 1e-300) if np.isfinite(found) else -np.inf
        reached = first + int(np.argmin(objectives[first:])) if kept > _MISSED else first + steps[0]
        length = float(np.abs(points[reached] - points[lowest]).max())
        radius = self.radius
        if kept > _KEPT:
            radius = max(radius, min(_GROWTH * length, _WIDEST))
        elif kept < _MISSED:
            radius = min(radius, max(length, _DECAY * radius))
        return TrustRegion(radius, self.since, None, kept < _MISSED)

    def narrower(self, factor: float = _DECAY) -> TrustRegion:
        """Return a smaller box."""
        return replace(self, radius=self.radius * factor, missed=False)

    def to_json(self) -> dict[str, Any]:
        """Return a JSON-able form, the arguments of the class."""
        return {"radius": self.radius, "since": self.since, "promised": self.promised, "missed": self.missed}


def spanned(points: FloatArray, centre: FloatArray, radius: float) -> FloatArray:
    """Directions in which runs lie near a centre, orthonormal, shape (k, d), k at most d.

    Those count that lie within two half widths; of what the others leave open, a tenth of a half width at least.
    """
    steps = (points - centre) / radius
    lengths = np.abs(steps).max(axis=1)
    steps = steps[(lengths <= _NEAR) & (lengths > _LEAST * _LEAST)]
    d = centre.size
    basis: FloatArray = np.zeros((0, d))
    while len(basis) < d and len(steps):
        squares = (steps * steps).sum(axis=1)
        longest = int(np.argmax(squares))
        if squares[longest] < _LEAST * _LEAST:
            break
        direction = steps[longest] / np.sqrt(squares[longest])
        basis = np.concatenate([basis, direction[None]])
        steps = steps - np.outer(steps @ direction, direction)
    return basis


def missing_direction(points: FloatArray, centre: FloatArray, radius: float) -> FloatArray | None:
    """Direction in which no run lies near a centre, largest component 1, shape (d,); None when all are spanned.

    It is the parameter that the spanned directions know least, less what they know of it.
    """
    basis = spanned(points, centre, radius)
    if len(basis) == centre.size:
        return None
    unknown = np.eye(centre.size) - basis.T @ basis
    direction = unknown[int(np.argmax(np.diag(unknown)))]
    return np.asarray(direction / np.abs(direction).max())
