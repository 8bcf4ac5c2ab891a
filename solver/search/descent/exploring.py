"""Ask / tell of an exploration: given points in one generation, then descents from the best of them."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.acceleration.runs import Runs, latest_residuals
from geoswarm.solver.search.base import Snapshot
from geoswarm.solver.search.descent.descent import Descent
from geoswarm.solver.search.one_thread import one_thread
from geoswarm.solver.search.space import SearchSpace

__all__ = ["ExploreSearch"]

_APART = 0.1  # parts of the range to the nearest better point: a basin of its own
_AT_ONCE = 3  # descents


class ExploreSearch:
    """Points first; then Levenberg-Marquardt from those without a better one nearby (nearest-better clustering).

    Parameters
    ----------
    optimum
        Known already, shape (d,), natural values: nothing begins near it.
    points
        Shape (n, d), natural values.
    runs
        Evaluations at most.
    """

    def __init__(
        self, space: SearchSpace, optimum: FloatArray, points: FloatArray, runs: int, snapshot: Snapshot | None = None
    ) -> None:
        self._space, self._optimum, self._points, self._runs = space, optimum, points, runs
        self.generation = 0
        self._spent = 0
        self._waiting: list[list[float]] = []
        self._descents: list[Descent] = []
        if snapshot is not None:
            self.generation, self._spent = snapshot["generation"], snapshot["spent"]
            self._waiting = [list(start) for start in snapshot["waiting"]]
            self._descents = [Descent.from_json(descent) for descent in snapshot["descents"]]

    def ask(self) -> FloatArray | None:
        """Positions of the current generation; None when all descents have ended, or the runs are spent."""
        if self.generation == 0:
            return self._points
        return np.concatenate([d.positions(self._space) for d in self._descents]) if self._descents else None

    def tell(self, objectives: FloatArray, runs: Runs | None = None) -> None:
        """Take the results of the current generation."""
        self._spent += len(objectives)
        with one_thread():
            if self.generation == 0:
                self._waiting = self._starts(objectives)
            else:
                rows = latest_residuals(runs, len(objectives))
                size = 2 * self._space.dimension + 1
                parts = [rows[i * size : (i + 1) * size] for i in range(len(self._descents))]
                advanced = [d.advance(own) for d, own in zip(self._descents, parts, strict=True)]
                self._descents = [descent for descent in advanced if not descent.finished]
        self._fill()
        self.generation += 1

    def _starts(self, objectives: FloatArray) -> list[list[float]]:
        """Points without a better one nearby, the best first, parts of the range; the optimum is better than all."""
        good = np.flatnonzero(np.isfinite(objectives))
        order = good[np.argsort(objectives[good], kind="stable")]
        unit = self._space.to_unit(np.concatenate([self._optimum[None], self._points[order]]))
        return [
            unit[i].tolist()
            for i in range(1, len(unit))
            if float(np.abs(unit[:i] - unit[i]).max(axis=1).min()) > _APART
        ]

    def _fill(self) -> None:
        """Keep so many descents going as the runs left allow."""
        room = (self._runs - self._spent) // (2 * self._space.dimension + 1)
        most = min(_AT_ONCE, room)
        while self._waiting and len(self._descents) < most:
            self._descents.append(Descent(np.array(self._waiting.pop(0))))
        self._descents = self._descents[:most]

    def snapshot(self) -> Snapshot:
        """State between two generations, JSON-able."""
        return {
            "generation": self.generation,
            "spent": self._spent,
            "waiting": self._waiting,
            "descents": [descent.to_json() for descent in self._descents],
        }
