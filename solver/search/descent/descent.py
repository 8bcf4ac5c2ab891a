"""Levenberg-Marquardt towards the minimum, one generation an iteration: a trial and central differences around it.

Levenberg (1944), Marquardt (1963), with the projection of active bounds. Works in parts of the range in search
coordinates; the state is plain data.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.space import SearchSpace

__all__ = ["Descent", "marquardt_step"]

_DIFFERENCE = 1e-4  # in parts of the range
_MOST_ITERATIONS = 40
_DAMPING = 1e-4
_MOST_DAMPING = 1e6
_SMALL_GAIN = 1e-10  # of f: less is not worth a generation


@dataclass(frozen=True, slots=True)
class Descent:
    """State of a descent.

    Parameters
    ----------
    trial
        Point that is due for evaluation, shape (d,), parts of the range.
    current, objective, gradient, curvature
        Best point so far, its f, J'r and J'J; None before the first evaluation.
    damping, iterations
        Of Levenberg-Marquardt.
    finished
        ``current`` is the minimum, or no better point can be found.
    """

    trial: FloatArray
    current: FloatArray | None = None
    objective: float | None = None
    gradient: FloatArray | None = None
    curvature: FloatArray | None = None
    damping: float = _DAMPING
    iterations: int = 0
    finished: bool = False

    @property
    def best(self) -> FloatArray:
        """Best point, parts of the range, shape (d,); the start when nothing succeeded."""
        return self.trial if self.current is None else self.current

    def positions(self, space: SearchSpace) -> FloatArray:
        """The trial and two moves of each parameter, shape (2 d + 1, d), natural values."""
        return space.from_unit(np.array([self.trial, *self._moved()]))

    def _moved(self) -> list[FloatArray]:
        moved = []
        for index in range(len(self.trial)):
            for side in (-_DIFFERENCE, _DIFFERENCE):
                point = self.trial.copy()
                point[index] = np.clip(point[index] + side, 0.0, 1.0)
                moved.append(point)
        return moved

    def advance(self, residuals: FloatArray) -> Descent:
        """Take the weighted residual vectors at :meth:`positions`, shape (2 d + 1, m); nan where it failed."""
        centre = residuals[0]
        objective = float(np.sum(centre * centre)) if np.isfinite(centre).all() else None
        after = replace(self, iterations=self.iterations + 1)
        if objective is None and self.objective is None:
            return replace(after, finished=True)
        if objective is None or (self.objective is not None and objective >= self.objective):
            return replace(after, damping=self.damping * 10.0)._next_trial()
        gain = np.inf if self.objective is None else self.objective - objective
        jacobian = self._jacobian(residuals)
        after = replace(
            after,
            current=self.trial,
            objective=objective,
            gradient=jacobian.T @ centre,
            curvature=jacobian.T @ jacobian,
            damping=max(self.damping / 10.0, 1e-14),
        )
        return replace(after, finished=True) if gain <= _SMALL_GAIN * objective else after._next_trial()

    def _jacobian(self, residuals: FloatArray) -> FloatArray:
        """Derivatives per part of the range, shape (m, d); one-sided where a move failed, 0 where both did."""
        places = [self.trial, *self._moved()]
        columns = []
        for index in range(len(self.trial)):
            used = [row for row in (2 * index + 1, 2 * index + 2) if np.isfinite(residuals[row]).all()]
            first, last = (used[0], used[-1]) if len(used) == 2 else (0, used[0] if used else 0)
            apart = places[last][index] - places[first][index]
            zero = np.zeros(residuals.shape[1])
            columns.append((residuals[last] - residuals[first]) / apart if apart != 0.0 else zero)
        return np.stack(columns, axis=1)

    def _next_trial(self) -> Descent:
        assert self.current is not None
        assert self.objective is not None
        assert self.gradient is not None
        assert self.curvature is not None
        gradient, curvature = self.gradient, self.curvature
        moving = ~(((self.current <= 0.0) & (gradient > 0.0)) | ((self.current >= 1.0) & (gradient < 0.0)))
        if not moving.any() or self.iterations >= _MOST_ITERATIONS or self.damping > _MOST_DAMPING:
            return replace(self, finished=True)
        step = np.zeros_like(self.current)
        step[moving] = marquardt_step(curvature[np.ix_(moving, moving)], gradient[moving], self.damping)
        trial = np.clip(self.current + step, 0.0, 1.0)
        step = trial - self.current
        predicted = -float(2.0 * gradient @ step + step @ curvature @ step)
        if not predicted > _SMALL_GAIN * self.objective:
            return replace(self, finished=True)
        return replace(self, trial=trial)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, from which :meth:`from_json` restores exactly."""
        data = {name: getattr(self, name) for name in ("objective", "damping", "iterations", "finished")}
        return data | {name: _listed(getattr(self, name)) for name in _ARRAYS}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Descent:
        """Restore from :meth:`to_json`."""
        arrays = {k: None if data[k] is None else np.array(data[k], dtype=np.float64) for k in _ARRAYS}
        return cls(**{**data, **arrays})


_ARRAYS = ("trial", "current", "gradient", "curvature")


def _listed(array: FloatArray | None) -> Any:
    return None if array is None else array.tolist()


def marquardt_step(curvature: FloatArray, gradient: FloatArray, damping: float) -> FloatArray:
    """Return the step (d,) that solves (J'J + damping diag(J'J)) step = -J'r (Marquardt 1963).

    Parameters
    ----------
    curvature, gradient
        J'J, shape (d, d), and J'r, shape (d,). A parameter without influence is damped as if its diagonal were 1.
    damping
        0 is the step of Gauss and Newton.
    """
    diagonal = np.diag(curvature)
    system = curvature + damping * np.diag(np.where(diagonal > 0.0, diagonal, 1.0))
    return np.asarray(-np.linalg.solve(system, gradient), dtype=np.float64)
