"""Ask / tell of points that are all given beforehand."""

from __future__ import annotations

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.acceleration.runs import Runs
from geoswarm.solver.search.base import Snapshot

__all__ = ["GivenSearch"]


class GivenSearch:
    """Points, shape (n, d), natural values, ``batch`` of them in a generation; learns nothing from the objectives."""

    def __init__(self, points: FloatArray, batch: int, snapshot: Snapshot | None = None) -> None:
        self._points, self._batch = points, batch
        self.generation: int = 0 if snapshot is None else snapshot["generation"]

    def ask(self) -> FloatArray | None:
        """Positions of the current generation; None when all points have been asked for."""
        first = self.generation * self._batch
        positions = self._points[first : first + self._batch]
        return positions if len(positions) else None

    def tell(self, objectives: FloatArray, runs: Runs | None = None) -> None:  # noqa: ARG002  (it does not learn)
        """Close the current generation."""
        self.generation += 1

    def snapshot(self) -> Snapshot:
        """State between two generations, JSON-able."""
        return {"generation": self.generation}
