"""Steps for derivatives, found for each parameter until truncation and roughness are both small.

A first generation moves every parameter by the same part of its range. What bends faster is moved less, and what the
roughness of the forward model hides is moved more, in further generations of those parameters alone, until the error
of each derivative is small against what it must tell: the parameters from each other. The state is plain data; the
residuals are read again from the runs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.search.descent.differences import DifferenceDesign, derivative, join_moves
from geoswarm.solver.search.space import SearchSpace

__all__ = ["FIRST_STEP", "Moves", "StepSearch"]

Moves: TypeAlias = list[tuple[int, float]]
"""Parameters and their steps, in parts of the range."""

FIRST_STEP = 5e-3
_LEAST, _MOST = 1e-8, 0.1
_GENERATIONS = 9
_STRICTEST, _LOOSEST = 1e-6, 1e-3  # relative error of a derivative
_OF_SINGULAR = 0.03  # of the smallest singular value over the largest, which the error must not reach
_BLIND = 0.3  # relative error from which it says nothing of the step that is needed
_STRIDE, _SHORTEST_BLIND = 0.125, 1e-6
_AGREES = 2.0  # errors that two derivatives may differ by
_FLAT = 1e-13  # change relative to the residuals


@dataclass(frozen=True, slots=True)
class _Trial:
    """One step of one parameter: its rows among all, and the derivative with its error, lengths and vector."""

    step: float
    rows: IntArray
    column: FloatArray
    error: float

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.column))

    @property
    def relative(self) -> float:
        return self.error / self.length if self.length > 0.0 else (0.0 if self.error == 0.0 else np.inf)


class StepSearch:
    """Generations of differences at an optimum.

    Parameters
    ----------
    space, optimum
        Where, shape (d,), natural values.
    generations
        Those asked for already; the first is that of all parameters.
    """

    def __init__(self, space: SearchSpace, optimum: FloatArray, generations: list[Moves] | None = None) -> None:
        self._space = space
        self._optimum = np.asarray(optimum, dtype=np.float64)
        self.generations = generations or [[(index, FIRST_STEP) for index in range(space.dimension)]]

    @property
    def positions(self) -> FloatArray:
        """Of the last generation, shape (n, d), natural values; the optimum is the first of all."""
        planned = join_moves(self._optimum, self.generations[-1], self._space).positions
        return planned if len(self.generations) == 1 else planned[1:]

    @cached_property
    def every(self) -> DifferenceDesign:
        """The plan of all generations together."""
        optimum, plans = self._optimum, self._plans
        return DifferenceDesign(
            optimum,
            np.concatenate([optimum[None, :], *(plan.positions[1:] for plan in plans)]),
            np.concatenate([[-1], *(plan.parameter[1:] for plan in plans)]),
            np.concatenate([[0.0], *(plan.offset[1:] for plan in plans)]),
        )

    @cached_property
    def _plans(self) -> list[DifferenceDesign]:
        """That of each move on its own."""
        return [join_moves(self._optimum, [move], self._space) for move in self._moves]

    @property
    def _moves(self) -> Moves:
        return [move for moves in self.generations for move in moves]

    def next(self, residuals: FloatArray) -> StepSearch | None:
        """Go on after the last generation; None when every derivative is good enough, or can be made no better.

        Parameters
        ----------
        residuals
            Weighted, of all generations so far, shape (N, m); nan where a run failed.
        """
        if len(self.generations) >= _GENERATIONS or not np.isfinite(residuals[0]).all():
            return None
        trials = self._trials(residuals)
        target = self._target(trials)
        moves: Moves = []
        for index, tried in enumerate(trials):
            step = None if self._space.integer[index] else _next_step(tried, target, float(np.abs(residuals[0]).max()))
            if step is not None:
                moves.append((index, step))
        planned = len(join_moves(self._optimum, moves, self._space).positions) - 1 if moves else 0
        return StepSearch(self._space, self._optimum, [*self.generations, moves]) if planned else None

    def chosen(self, residuals: FloatArray) -> tuple[DifferenceDesign, IntArray]:
        """The plan with the best step of each parameter, and its rows among all; ``residuals`` as in :meth:`next`."""
        rows = [np.zeros(1, dtype=np.int64)]
        every = self.every
        for index, tried in enumerate(self._trials(residuals)):
            first = np.flatnonzero(every.parameter == index)[:4]
            rows.append(_best(tried).rows if tried else first)
        kept = np.concatenate(rows)
        plan = DifferenceDesign(every.optimum, every.positions[kept], every.parameter[kept], every.offset[kept])
        return plan, kept

    def found(self, residuals: FloatArray) -> Moves:
        """The best step of each parameter; ``residuals`` as in :meth:`next`."""
        return [(i, _best(tried).step if tried else FIRST_STEP) for i, tried in enumerate(self._trials(residuals))]

    def columns(self, residuals: FloatArray) -> FloatArray:
        """The best derivative of each parameter per range, shape (m, d), nan where there is none."""
        blank = np.full(residuals.shape[1], np.nan)
        return np.stack([_best(tried).column if tried else blank for tried in self._trials(residuals)], axis=1)

    def _trials(self, residuals: FloatArray) -> list[list[_Trial]]:
        """Steps of each parameter that gave a derivative."""
        good = np.atleast_1d(np.isfinite(residuals).all(axis=1))
        trials: list[list[_Trial]] = [[] for _ in range(self._space.dimension)]
        first = 1
        every = self.every
        for (index, step), plan in zip(self._moves, self._plans, strict=True):
            count = len(plan.positions) - 1
            rows = np.arange(first, first + count)
            first += count
            used = rows[good[rows]] if good[0] else rows[:0]
            if len(used) < 2:
                continue
            offsets = np.array([0.0, *every.offset[used]])
            column, error = derivative(offsets, residuals[[0, *used]])
            trials[index].append(_Trial(step, rows, column, float(np.linalg.norm(error))))
        return [_cautious(tried) for tried in trials]

    @staticmethod
    def _target(trials: list[list[_Trial]]) -> float:
        """Relative error that distinguishes the parameters from each other."""
        best = [_best(tried) for tried in trials if tried]
        known = [trial.column / trial.length for trial in best if trial.relative < _BLIND and trial.length > 0.0]
        if not known:
            return _LOOSEST
        singular = np.linalg.svd(np.stack(known, axis=1), compute_uv=False)
        return float(np.clip(_OF_SINGULAR * singular[-1] / singular[0], _STRICTEST, _LOOSEST))


def _cautious(tried: list[_Trial]) -> list[_Trial]:
    """Trials of one parameter with errors that agree with each other: one estimate may be small by chance.

    Roughness that a shorter step shows is there with a longer one, too, divided by its length; and where a longer one
    differs by more than its errors, the shorter is off: roughness grows as steps get shorter.
    """
    after = []
    for trial in tried:
        rough = [other.error * other.step / trial.step for other in tried if other.step < trial.step]
        apart = [
            float(np.linalg.norm(other.column - trial.column)) - _AGREES * other.error
            for other in tried
            if other.step > trial.step and other.relative < _BLIND
        ]
        after.append(replace(trial, error=max([trial.error, *rough, *apart])))
    return after


def _best(tried: list[_Trial]) -> _Trial:
    """The step with the least relative error: in a response that oscillates, too long ones give small derivatives."""
    return min(tried, key=lambda trial: trial.relative)


def _next_step(tried: list[_Trial], target: float, scale: float) -> float | None:
    """The step to try next for one parameter; None when its derivative is good enough or gets no better."""
    if not tried:  # neighbours failed: nearer ones may not
        return None
    best = _best(tried)
    steps = sorted(trial.step for trial in tried)
    if best.length * best.step <= _FLAT * scale and best.error * best.step <= _FLAT * scale:
        return _MOST if steps[-1] < _MOST else None  # nothing moves: does a longer way?
    if best.relative <= target:
        return None
    if best.relative >= _BLIND:  # the errors tell nothing either: shorter first, as a response is bounded
        shorter = steps[0] * _STRIDE
        longer = steps[-1] / _STRIDE
        return shorter if shorter >= _SHORTEST_BLIND else min(longer, _MOST) if steps[-1] < _MOST else None
    others = [trial.relative for trial in tried if trial is not best]
    if others and best.relative > 0.5 * min(others):
        return None
    if best.step == steps[0] and best.step > _LEAST:
        return max(best.step * float(np.clip(0.5 * (target / best.relative) ** 0.25, 0.06, 0.5)), _LEAST)
    if best.step == steps[-1] and best.step < _MOST:
        return min(best.step * 4.0, _MOST)
    return None
