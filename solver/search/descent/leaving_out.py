"""Ask / tell of the fits without each of several tests, all from one optimum and all from the same runs.

A run has the residuals of all tests, so it is worth as much for each of the fits: the sum of squares without a test is
known wherever any of them went. Each generation has one trial for each fit that has not settled, the minimum without
its test of a surface through all runs so far. A trial that is no better halves the region that its fit trusts. The
state is plain data; residuals are read again from the runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.search.base import Snapshot
from geoswarm.solver.search.descent.projection import admissible
from geoswarm.solver.search.descent.quadratic import QuadraticSurface
from geoswarm.solver.search.determinism import one_thread
from geoswarm.solver.search.runs import Runs, latest_residuals
from geoswarm.solver.search.space import SearchSpace

__all__ = ["LeavingOutSearch", "LeavingOutSettings"]

_CLOSE = 2e-3  # of the spread between the fits: a step that is shorter is not worth a run
_FAR = 0.05  # of that spread: a minimum that is farther away has not been reached
_RADIUS = 0.25  # parts of the range, at first
_MOST_FAILED = 4  # trials of a fit that are no better, one after the other
_HALVINGS = 10  # of a step that constraints exclude
_SHORTEST = 1e-12  # parts of the range: below it, a step is rounding


@dataclass(frozen=True, slots=True)
class LeavingOutSettings:
    """What to fit without.

    Parameters
    ----------
    optimum
        Of all tests, shape (d,), natural values.
    step
        First moves, shape (d,), parts of the range.
    tests
        Name of the test and number of readings of each series, in the order of the residuals; no name: it stays.
    runs
        Evaluations at most.
    """

    optimum: FloatArray
    step: FloatArray
    tests: Sequence[tuple[str, int]]
    runs: int

    @property
    def names(self) -> tuple[str, ...]:
        """Of the tests."""
        return tuple(dict.fromkeys(name for name, _ in self.tests if name))

    @property
    def kept(self) -> BoolArray:
        """Whether a residual counts in the fit without a test, shape (tests, m)."""
        owner = np.repeat([name for name, _ in self.tests], [count for _, count in self.tests])
        return np.asarray(owner[None, :] != np.array(self.names)[:, None])


@dataclass(frozen=True, slots=True)
class _State:
    """What goes on after ``told`` evaluations.

    ``rows``: best run of each fit; ``radius``: how far it trusts the surface; ``failed``: trials in a row that were no
    better; ``far``: the minimum has not been reached; ``lost``: parameters that the tests left do not determine, shape
    (tests, d); ``trying``: the fits that ``due`` belong to, natural values; None: all is done; ``broken``: the optimum
    itself failed.
    """

    rows: IntArray
    units: FloatArray
    radius: FloatArray
    failed: IntArray
    far: BoolArray
    lost: BoolArray
    due: FloatArray | None
    trying: tuple[int, ...] = ()
    generation: int = 0
    told: int = 0
    broken: bool = False


class LeavingOutSearch:
    """The optimum and a move of each parameter, then trials of all fits together."""

    def __init__(self, space: SearchSpace, settings: LeavingOutSettings, snapshot: Snapshot | None = None) -> None:
        self._space, self.settings = space, settings
        self._state = self._begin() if snapshot is None else _restored(snapshot)

    def _begin(self) -> _State:
        count, dimension = len(self.settings.names), self._space.dimension
        unit = self._space.to_unit(self.settings.optimum)
        moved = [place for index in range(dimension) if (place := self._moved(unit, index)) is not None]
        due = self._space.from_unit(np.array([unit, *moved]))
        due[0] = self.settings.optimum
        return _State(
            rows=np.zeros(count, dtype=np.int64),
            units=np.tile(unit, (count, 1)),
            radius=np.full(count, _RADIUS),
            failed=np.zeros(count, dtype=np.int64),
            far=np.ones(count, dtype=np.bool_),
            lost=np.zeros((count, dimension), dtype=np.bool_),
            due=due,
        )

    def _moved(self, unit: FloatArray, index: int) -> FloatArray | None:
        """The optimum with one parameter moved; None where it cannot be."""
        if self._space.integer[index]:
            return None
        step = float(self.settings.step[index])
        for length in (step, -step, 0.1 * step, -0.1 * step):
            place = unit.copy()
            place[index] += length
            if admissible(self._space, place):
                return place
        return None

    # ---- ask and tell

    @property
    def generation(self) -> int:
        """Number of the current generation, from 0."""
        return self._state.generation

    def ask(self) -> FloatArray | None:
        """Positions of the current generation; None when all fits have settled, or no run is left."""
        return self._state.due

    def tell(self, objectives: FloatArray, runs: Runs | None = None) -> None:
        """Take the results of the current generation."""
        state = self._state
        told = state.told + len(objectives)
        residuals = latest_residuals(runs, told)
        assert runs is not None  # or there are no residuals
        state = replace(state, told=told, generation=state.generation + 1)
        if not np.isfinite(residuals[0]).all():
            self._state = replace(state, due=None, broken=True)
        else:
            with one_thread():
                units = self._space.to_unit(runs.positions[-told:])
                units[0] = self._space.to_unit(self.settings.optimum)
                self._state = self._next(self._judged(state, units, residuals), units, residuals)

    def _judged(self, state: _State, units: FloatArray, residuals: FloatArray) -> _State:
        """Take the best run of each fit, and what its trial says of the surface."""
        radius, failed, rows = state.radius.copy(), state.failed.copy(), state.rows.copy()
        first = len(units) - len(state.trying)
        for fit, kept in enumerate(self.settings.kept):
            squares = np.sum(residuals[:, kept] ** 2, axis=1)
            squares = np.where(np.isfinite(squares), squares, np.inf)
            if fit in state.trying:
                trial = first + state.trying.index(fit)
                length = float(np.abs(units[trial] - units[rows[fit]]).max())
                if squares[trial] < squares[rows[fit]]:
                    failed[fit] = 0
                    radius[fit] = max(radius[fit], 2.0 * length)
                else:
                    failed[fit] += 1
                    radius[fit] = 0.5 * length
            rows[fit] = int(np.argmin(squares))
        return replace(state, radius=radius, failed=failed, rows=rows, units=units[rows])

    def _next(self, state: _State, units: FloatArray, residuals: FloatArray) -> _State:
        """Go to the minimum without each test of the surface through all runs."""
        space, settings = self._space, self.settings
        moves, lost = np.zeros_like(state.units), state.lost.copy()
        surfaces: dict[int, QuadraticSurface] = {}
        fixed = np.ptp(units, axis=0) <= _SHORTEST
        for fit, kept in enumerate(settings.kept):
            row, at = int(state.rows[fit]), state.units[fit]
            if row not in surfaces:
                others = np.isfinite(residuals).all(axis=1) & (np.arange(len(units)) != row)
                away = (units[others] - at) / settings.step
                surfaces[row] = QuadraticSurface.through(away, residuals[others], residuals[row])
            room = np.where(fixed, 0.0, state.radius[fit])
            lower, upper = np.maximum(-at, -room) / settings.step, np.minimum(1.0 - at, room) / settings.step
            z, lost[fit] = surfaces[row].minimum(kept, lower, upper)
            moves[fit] = self._allowed(at, z * settings.step)
        ends = state.units + moves
        spread = np.sqrt(np.sum((ends - ends.mean(axis=0)) ** 2, axis=0))
        lengths = np.max(np.abs(moves) / np.maximum(spread, _SHORTEST / _CLOSE), axis=1)
        settled = lengths <= _CLOSE
        due = np.flatnonzero(~settled & (state.failed < _MOST_FAILED))
        due = np.sort(due[np.argsort(-lengths[due], kind="stable")][: max(settings.runs - state.told, 0)])
        state = replace(state, lost=lost, far=lengths > _FAR, due=None, trying=())
        if not due.size:
            return state
        return replace(state, trying=tuple(due.tolist()), due=space.from_unit(ends[due]))

    def _allowed(self, at: FloatArray, move: FloatArray) -> FloatArray:
        """The move, shortened until bounds and constraints admit it."""
        for _ in range(_HALVINGS):
            if admissible(self._space, np.clip(at + move, 0.0, 1.0)):
                return np.asarray(np.clip(at + move, 0.0, 1.0) - at)
            move = 0.5 * move
        return np.zeros_like(move)

    # ---- what has been found

    @property
    def failed(self) -> bool:
        """Whether the optimum itself failed."""
        return self._state.broken

    @property
    def told(self) -> int:
        """Number of evaluations so far."""
        return self._state.told

    @property
    def moves(self) -> FloatArray:
        """From the optimum to the minimum without each test, parts of the range, shape (tests, d).

        nan where the tests left do not determine a parameter.
        """
        unit = self._space.to_unit(self.settings.optimum)
        return np.asarray(np.where(self._state.lost, np.nan, self._state.units - unit))

    @property
    def unsettled(self) -> tuple[str, ...]:
        """Tests without which the minimum has not been reached."""
        return tuple(name for name, far in zip(self.settings.names, self._state.far, strict=True) if far)

    def snapshot(self) -> Snapshot:
        """State between two generations, JSON-able."""
        state = self._state
        data: dict[str, Any] = {name: getattr(state, name) for name in ("generation", "told", "broken")}
        data["trying"] = list(state.trying)
        return data | {name: None if (v := getattr(state, name)) is None else v.tolist() for name in _ARRAYS}


_ARRAYS = {
    "rows": np.int64,
    "units": np.float64,
    "radius": np.float64,
    "failed": np.int64,
    "far": np.bool_,
    "lost": np.bool_,
    "due": np.float64,
}


def _restored(data: Snapshot) -> _State:
    arrays: dict[str, Any] = {
        name: None if data[name] is None else np.array(data[name], dtype=kind) for name, kind in _ARRAYS.items()
    }
    return _State(
        **arrays, trying=tuple(data["trying"]), **{name: data[name] for name in ("generation", "told", "broken")}
    )
