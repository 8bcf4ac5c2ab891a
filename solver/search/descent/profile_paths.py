"""One side of a profile: a chain of values of one parameter, at each of which the others are fitted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.descent.descent import marquardt_step
from geoswarm.solver.search.space import SearchSpace

__all__ = ["ProfilePath", "ProfilePoint"]

_DIFFERENCE = 1e-4  # in parts of the range
_MOST_ITERATIONS = 12  # of Levenberg-Marquardt at one value
_MOST_POINTS = 60
_SMALL_GAIN = 2e-3  # of the increase: an iteration that lowers f by less has converged
_DAMPING = 1e-3
_OVERSHOOT = 6.0  # in rises: more is too far beyond the end of the interval
_MOST_REFINEMENTS = 6
_MOST_DAMPING = 1e8


@dataclass(frozen=True, slots=True)
class ProfilePoint:
    """A finished value: all parameters in parts of the range, shape (d,), and the lowest objective found."""

    unit: FloatArray
    objective: float


@dataclass(frozen=True, slots=True)
class ProfilePath:
    """State of one side of a profile.

    Parameters
    ----------
    index, side
        Which parameter, and -1 towards the lower or 1 towards the upper bound.
    step
        Distance to the next value, parts of the range.
    increase
        Rise of the profile that ends the interval.
    points
        Finished values, outwards.
    trial
        Point that is due for evaluation, shape (d,), parts of the range.
    current, objective, gradient, curvature
        Best point at this value, its f, J'r over and J'J of the other parameters; None before the first evaluation.
    damping, iterations
        Of Levenberg-Marquardt at this value.
    finished
        Nothing is left to do.
    refinements
        How often a step went too far and was taken back.
    """

    index: int
    side: int
    step: float
    increase: float
    points: tuple[ProfilePoint, ...]
    trial: FloatArray
    origin: FloatArray
    current: FloatArray | None = None
    objective: float | None = None
    gradient: FloatArray | None = None
    curvature: FloatArray | None = None
    damping: float = _DAMPING
    iterations: int = 0
    finished: bool = False
    refinements: int = 0

    @classmethod
    def begin(
        cls, index: int, side: int, optimum: FloatArray, step: float, increase: float, *, idle: bool = False
    ) -> ProfilePath:
        """Begin at the optimum, shape (d,), parts of the range; an ``idle`` path has nothing to do."""
        path = cls(index, side, step, increase, (), optimum, optimum)
        return replace(path, finished=True) if idle else path._next_value()

    def positions(self, space: SearchSpace) -> FloatArray:
        """The trial and a small move of each other parameter, shape (d, d), natural values."""
        return space.from_unit(np.array([self.trial, *self._moved()]))

    def _moved(self) -> list[FloatArray]:
        moved = []
        for other in self._others():
            point = self.trial.copy()
            point[other] += _DIFFERENCE if point[other] + _DIFFERENCE <= 1.0 else -_DIFFERENCE
            moved.append(point)
        return moved

    def _others(self) -> list[int]:
        return [i for i in range(len(self.trial)) if i != self.index]

    def advance(self, space: SearchSpace, residuals: FloatArray, lowest: float) -> ProfilePath:
        """Take the results at :meth:`positions`.

        Parameters
        ----------
        residuals
            Weighted residual vectors, shape (d, m), whose squared lengths are the objectives; nan where it failed.
        lowest
            f at the optimum.
        """
        succeeded = bool(np.isfinite(residuals[0]).all()) and space.feasible(space.from_unit(self.trial))
        objective = float(np.sum(residuals[0] * residuals[0])) if succeeded else None
        path = replace(self, iterations=self.iterations + 1)
        if objective is None and self.objective is None:
            # the others cannot be kept at this value: the space ends here, as at a bound
            return replace(path, finished=True)
        if objective is None or (self.objective is not None and objective >= self.objective):
            return replace(path, damping=self.damping * 10.0)._next_trial(lowest, 0.0)
        gain = np.inf if self.objective is None else self.objective - objective
        gradient, curvature = self._linearised(residuals)
        path = replace(
            path,
            current=self.trial,
            objective=objective,
            gradient=gradient,
            curvature=curvature,
            damping=max(self.damping / 10.0, 1e-12),
        )
        return path._next_trial(lowest, gain)

    def _linearised(self, residuals: FloatArray) -> tuple[FloatArray, FloatArray]:
        columns = []
        for other, moved, row in zip(self._others(), self._moved(), residuals[1:], strict=True):
            if np.isfinite(row).all():
                columns.append((row - residuals[0]) / (moved[other] - self.trial[other]))
            else:
                columns.append(np.zeros_like(row))  # cannot be moved from here
        jacobian = np.stack(columns, axis=1) if columns else np.empty((residuals.shape[1], 0))
        return jacobian.T @ residuals[0], jacobian.T @ jacobian

    def _next_trial(self, lowest: float, gain: float) -> ProfilePath:
        """The next Levenberg-Marquardt step at this value, or the next value."""
        assert self.current is not None
        assert self.gradient is not None
        assert self.curvature is not None
        others = self._others()
        done = not others or self.iterations >= _MOST_ITERATIONS or self.damping > _MOST_DAMPING
        step: FloatArray = np.zeros(len(others))
        if not done:
            step = marquardt_step(self.curvature, self.gradient, self.damping)
            predicted = float(-(2.0 * self.gradient @ step + step @ self.curvature @ step))
            small = _SMALL_GAIN * self.increase
            done = predicted < small or (0.0 < gain < small and self.iterations > 1)
        if done:
            return self._finish_value(lowest)
        trial = self.current.copy()
        trial[others] = np.clip(trial[others] + step, 0.0, 1.0)
        return replace(self, trial=trial)

    def _finish_value(self, lowest: float) -> ProfilePath:
        assert self.current is not None
        assert self.objective is not None
        if self.objective > lowest + _OVERSHOOT * self.increase and self.refinements < _MOST_REFINEMENTS:
            # far beyond the end of the interval: a straight line from the last point would not tell where it ends
            return replace(self, step=0.25 * self.step, refinements=self.refinements + 1)._next_value()
        points = (*self.points, ProfilePoint(self.current, self.objective))
        end = self.current[self.index] in (0.0, 1.0)
        before = self.points[-1].objective if self.points else lowest
        rise = self.objective - before
        step = self.step
        if rise < 0.1 * self.increase and self.refinements == 0:
            step = min(2.0 * step, 0.1)
        elif rise > 0.5 * self.increase:
            step = max(0.5 * step, 1e-9)
        path = replace(self, points=points, step=step)
        if end or len(points) >= _MOST_POINTS or self.objective >= lowest + 1.5 * self.increase:
            return replace(path, finished=True)
        return path._next_value()

    def _next_value(self) -> ProfilePath:
        """Go one step outwards; the other parameters go on in the direction they took last."""
        last = self.points[-1].unit if self.points else self.origin
        before = self.points[-2].unit if len(self.points) > 1 else self.origin
        value = float(np.clip(last[self.index] + self.side * self.step, 0.0, 1.0))
        moved = value - last[self.index]
        if moved == 0.0:
            return replace(self, finished=True)
        trial = last.copy()
        earlier = last[self.index] - before[self.index]
        if self.points and earlier != 0.0:
            trial = np.clip(last + (last - before) * moved / earlier, 0.0, 1.0)
        trial[self.index] = value
        return replace(
            self,
            trial=trial,
            current=None,
            objective=None,
            gradient=None,
            curvature=None,
            damping=_DAMPING,
            iterations=0,
        )

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, from which :meth:`from_json` restores exactly."""
        data = asdict(self)
        for key in _ARRAYS:
            data[key] = None if data[key] is None else data[key].tolist()
        return data | {"points": [{"unit": p.unit.tolist(), "objective": p.objective} for p in self.points]}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> ProfilePath:
        """Restore from :meth:`to_json`."""
        arrays = {k: None if data[k] is None else np.array(data[k], dtype=np.float64) for k in _ARRAYS}
        points = tuple(ProfilePoint(np.array(p["unit"], dtype=np.float64), p["objective"]) for p in data["points"])
        return cls(**{**data, **arrays, "points": points})


_ARRAYS = ("trial", "origin", "current", "gradient", "curvature")
