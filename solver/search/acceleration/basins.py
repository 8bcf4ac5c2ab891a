"""Restarts: which region the search works in, and which it has finished with. The best of all is never lost."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray

__all__ = ["Basins"]

_RADIUS = 0.05  # half the width of a finished basin in the unit box
_WORTH = 0.02  # a relative decrease of the objective that counts
_CLUSTERED = 200  # best runs
_REMEMBERED = 6  # finished basins: an older one may have been left too early and is tried again


@dataclass(frozen=True, slots=True)
class Basins:
    """Finished basins (centres in the unit box) and the state of the one being worked on.

    ``best`` is None before its first evaluation; ``waiting`` counts generations without a worthwhile decrease,
    ``gained``: whether the last one had it; ``radius`` is half the width of a finished basin's box, which the
    search knows and the JSON-able form leaves out.
    """

    finished: tuple[tuple[float, ...], ...] = ()
    best: float | None = None
    waiting: int = 0
    restarts: int = 0
    gained: bool = False
    radius: float = _RADIUS

    def outside(self, points: FloatArray) -> BoolArray:
        """Tell which points, shape (n, d), are in no finished basin."""
        inside = np.zeros(len(points), dtype=np.bool_)
        for centre in self.finished:
            inside |= np.abs(points - np.array(centre)).max(axis=1) <= self.radius
        return ~inside

    def open_runs(self, points: FloatArray) -> BoolArray:
        """Tell which runs, shape (n, d), best first, belong to no finished basin.

        A basin is wider than its box: what lies outside, but so near to a better run of the basin that the way down
        leads there, belongs to it (nearest-better clustering, Preuss 2010). Else the rim of a finished basin would be
        the next one.
        """
        open_ = self.outside(points)
        if self.finished and len(points):
            best = points[:_CLUSTERED]
            distances = np.zeros((len(best), len(best)))
            for coordinate in best.T:  # the largest along an axis of five is five times as slow to find
                np.maximum(distances, np.abs(coordinate[:, None] - coordinate), out=distances)
            distances[np.triu_indices(len(best))] = np.inf
            nearest = np.argmin(distances, axis=1)
            near = distances[np.arange(len(best)), nearest] <= self.radius
            for i in np.nonzero(near)[0].tolist():
                if not open_[nearest[i]]:
                    open_[i] = False
        return open_

    def admits(self, point: FloatArray, runs: FloatArray, open_: BoolArray) -> bool:
        """Return whether a new point, shape (d,), is in no finished basin, by the runs around it and their openness."""
        if not self.finished:
            return True
        distances = np.abs(runs - point).max(axis=1)
        nearest = int(np.argmin(distances))
        beside = not open_[nearest] and bool(distances[nearest] <= self.radius)
        return not beside and bool(self.outside(point[None])[0])

    def after(self, points: FloatArray, objectives: FloatArray, patience: int) -> Basins:
        """Return the state after a generation.

        Parameters
        ----------
        points, objectives
            Of all successful runs so far, best first, unit box, shapes (n, d) and (n,).
        patience
            Generations without a worthwhile decrease after which a basin is finished.
        """
        current, open_ = self, self.open_runs(points)
        if not open_.any():  # nothing left: begin again
            current = Basins(restarts=self.restarts + 1, radius=self.radius)
            open_ = current.open_runs(points)
        candidates = np.where(open_, objectives, np.inf)
        lowest = int(np.argmin(candidates))
        best = float(candidates[lowest])
        if current.best is None or best < current.best * (1.0 - _WORTH):
            return replace(current, best=best, waiting=0, gained=current.best is not None)
        if current.waiting + 1 < patience:
            return replace(current, waiting=current.waiting + 1, gained=False)
        return current.left(points[lowest])

    def left(self, centre: FloatArray) -> Basins:
        """Return the state when the basin around a point, shape (d,), is finished."""
        finished = (*self.finished, tuple(centre.tolist()))[-_REMEMBERED:]
        return Basins(finished, None, 0, self.restarts + 1, radius=self.radius)

    def to_json(self) -> dict[str, Any]:
        """Return a JSON-able form."""
        return {
            "finished": [list(centre) for centre in self.finished],
            "best": self.best,
            "waiting": self.waiting,
            "restarts": self.restarts,
            "gained": self.gained,
        }

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Basins:
        """Invert :meth:`to_json`."""
        finished = tuple(tuple(centre) for centre in data["finished"])
        return cls(finished, data["best"], data["waiting"], data["restarts"], data["gained"])
