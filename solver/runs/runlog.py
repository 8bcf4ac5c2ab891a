"""The runs of a job, and those offered from earlier jobs, for searches that learn from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.search.runs import Runs

__all__ = ["Fetch", "RunKey", "RunLog"]

RunKey: TypeAlias = tuple[int, int]
"""Generation and particle."""

Fetch: TypeAlias = Callable[[Sequence[RunKey]], Sequence[Mapping[str, FloatArray]]]
"""Gives the responses of successful runs, by series, in the order asked for."""

_KEPT_ROWS = 512


@dataclass(frozen=True, slots=True)
class _Generation:
    positions: FloatArray
    objectives: FloatArray


class RunLog:
    """Positions and objectives of all finished generations, read once, and residuals of recently used runs.

    Responses stay where they are stored: a search reads a selection only. :attr:`failed` counts runs without responses.

    Parameters
    ----------
    calibration
        Of this job.
    """

    def __init__(self, calibration: Calibration) -> None:
        self._objective = calibration.objective
        self._outputs = sum(observed.y.size for observed in calibration.objective.observed)
        self._offered = calibration.offered
        self._dimension = calibration.space.dimension
        self._generations: list[_Generation] = []
        self._rows: dict[int, FloatArray] = {}
        self._evaluated: set[bytes] = set()
        self.failed = 0

    @property
    def generations(self) -> int:
        """Number of generations in the log."""
        return len(self._generations)

    def add(self, parameters: Sequence[FloatArray], objectives: Sequence[float | None]) -> None:
        """Add the next generation: natural values, each of shape (d,), and f (None: failed), in particle order."""
        values = np.array([np.inf if f is None else f for f in objectives], dtype=np.float64)
        self._generations.append(_Generation(np.array(parameters, dtype=np.float64), values))
        self.failed += sum(objective is None for objective in objectives)
        self._evaluated.update(position.tobytes() for position in parameters)

    def repeats(self, positions: FloatArray) -> bool:
        """Whether one of the positions, natural values, shape (n, d), has been evaluated."""
        return any(position.tobytes() in self._evaluated for position in positions)

    def runs(self, fetch: Fetch) -> Runs:
        """Return the offered runs and those of all generations added; ``fetch`` serves as long as they are used."""
        parts = self._generations
        positions = [np.empty((0, self._dimension)), *(part.positions for part in parts)]
        objectives = [np.empty(0), *(part.objectives for part in parts)]
        begins = np.cumsum([0, *(len(part.positions) for part in parts)])
        offered = self._offered
        first = 0 if offered is None else len(offered.positions)
        if offered is not None:
            positions, objectives = [offered.positions, *positions], [offered.objectives, *objectives]

        def key(run: int) -> RunKey:
            generation = int(np.searchsorted(begins, run, side="right")) - 1
            return generation, run - int(begins[generation])

        def residuals(chosen: IntArray) -> FloatArray:
            own = [i for i in chosen.tolist() if i >= first]
            missing = [i for i in own if i not in self._rows]
            if missing:
                found = fetch([key(i - first) for i in missing])
                self._rows |= {i: self._objective.weighted_residuals(r) for i, r in zip(missing, found, strict=True)}
            earlier = [i for i in chosen.tolist() if i < first]
            rows = {} if offered is None else dict(zip(earlier, offered.residuals(np.array(earlier, int)), strict=True))
            rows |= {i: self._rows[i] for i in own}
            if len(self._rows) > _KEPT_ROWS:
                self._rows = {i: self._rows[i] for i in own}
            return np.array([rows[i] for i in chosen.tolist()]).reshape(len(chosen), self._outputs)

        def responses(chosen: IntArray) -> Sequence[Mapping[str, FloatArray]]:
            return fetch([key(run - first) for run in chosen.tolist()])

        return Runs(np.concatenate(positions), np.concatenate(objectives), residuals, responses)
