"""Ask / tell of an exploration: given points in one generation, then descents from the best of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.base import Snapshot
from geoswarm.solver.search.descent.refinement import Refinement
from geoswarm.solver.search.determinism import one_thread
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace

__all__ = ["ExploreSearch"]

_APART = 0.1  # parts of the range to the nearest better point: a basin of its own
_AT_OPTIMUM = 0.01  # parts of the range
_LEADS_BACK = 0.2  # of the way to the known optimum, by the curvature: what the step to the minimum may miss it by
_AT_ONCE = 3  # descents
_LONGEST = 40  # iterations


@dataclass(frozen=True, slots=True)
class _UnderWay:
    """A descent that goes on, and the indices of its runs."""

    descent: Refinement
    rows: tuple[int, ...] = ()


class ExploreSearch:
    """Points first; then descents from those without a better one nearby (nearest-better clustering).

    A descent ends where it comes to the known optimum, where the next step would lead there, or where it promises to
    stay above it.

    Parameters
    ----------
    optimum
        Known already, shape (d,), natural values: nothing begins near it.
    points
        Shape (n, d), natural values.
    runs
        Evaluations at most.
    objective
        At the optimum; None where it is not known.
    """

    def __init__(
        self,
        space: SearchSpace,
        optimum: FloatArray,
        points: FloatArray,
        runs: int,
        objective: float | None = None,
        snapshot: Snapshot | None = None,
    ) -> None:
        self._space, self._optimum, self._points, self._runs = space, optimum, points, runs
        self._known = objective
        self.generation = 0
        self._spent = 0
        self._waiting: list[int] = []
        self._descents: list[_UnderWay] = []
        self._left: list[int] = []
        if snapshot is not None:
            self.generation, self._spent = snapshot["generation"], snapshot["spent"]
            self._waiting, self._left = list(snapshot["waiting"]), list(snapshot.get("left", ()))
            descents = [Refinement.from_json(descent) for descent in snapshot["descents"]]
            rows = snapshot.get("rows", [()] * len(descents))  # an earlier version did not keep them
            self._descents = [_UnderWay(descent, tuple(own)) for descent, own in zip(descents, rows, strict=True)]

    def ask(self) -> FloatArray | None:
        """Positions of the current generation; None when all descents have ended, or the runs are spent."""
        if self.generation == 0:
            return self._points
        parts = [one.descent.asked for one in self._descents]
        return self._space.from_unit(np.concatenate(parts)) if parts else None

    def tell(self, objectives: FloatArray, runs: Runs | None = None) -> None:
        """Take the results of the current generation."""
        if runs is None:
            raise ValueError("an exploration needs the runs so far")
        self._spent += len(objectives)
        first = len(runs.positions) - len(objectives)
        with one_thread():
            if self.generation == 0:
                self._waiting = [first + point for point in self._starts(objectives)]
            else:
                going = []
                for one in self._descents:
                    rows = range(first, first + len(one.descent.asked))
                    first = rows.stop
                    so_far = replace(runs, positions=runs.positions[:first], objectives=runs.objectives[:first])
                    after = one.descent.advance(self._space, so_far, _LONGEST)
                    if not after.finished and not self._back(after):
                        going.append(_UnderWay(after, (*one.rows, *rows)))
                self._descents = going
            self._fill(runs)
        self.generation += 1

    def _starts(self, objectives: FloatArray) -> list[int]:
        """Points without a better one nearby, the best first; the optimum is better than all."""
        good = np.flatnonzero(np.isfinite(objectives))
        order = good[np.argsort(objectives[good], kind="stable")]
        unit = self._space.to_unit(np.concatenate([self._optimum[None], self._points[order]]))
        apart = [float(np.abs(unit[:i] - unit[i]).max(axis=1).min()) > _APART for i in range(1, len(unit))]
        return [int(point) for point, far in zip(order, apart, strict=True) if far]

    def _back(self, descent: Refinement) -> bool:
        """Whether a descent has come to the known optimum, or the step of Gauss and Newton leads there."""
        away, curvature = self._space.to_unit(self._optimum) - descent.current, descent.curvature
        if float(np.abs(away).max()) <= _AT_OPTIMUM:
            return True
        missed = away + np.linalg.pinv(curvature, hermitian=True) @ descent.gradient
        length = float(away @ curvature @ away)
        return length > 0.0 and float(missed @ curvature @ missed) <= _LEADS_BACK**2 * length

    def _fill(self, runs: Runs) -> None:
        """Keep as many descents going as the runs left allow."""
        while self._waiting and len(self._descents) < _AT_ONCE:
            begun = Refinement.begin(self._space, runs, self._waiting.pop(0), self._known)
            if not begun.finished:
                self._descents.append(_UnderWay(begun))
        while sum(len(one.descent.asked) for one in self._descents) > self._runs - self._spent:
            self._left += self._descents.pop().rows

    @property
    def left(self) -> list[int]:
        """Indices of the runs of descents that have not ended: where these would have led is not known."""
        return [*self._left, *(row for one in self._descents for row in one.rows)]

    def snapshot(self) -> Snapshot:
        """State between two generations, JSON-able."""
        return {
            "generation": self.generation,
            "spent": self._spent,
            "waiting": self._waiting,
            "descents": [one.descent.to_json() for one in self._descents],
            "rows": [list(one.rows) for one in self._descents],
            "left": self._left,
        }
