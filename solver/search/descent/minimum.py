"""Ask / tell of the runs after a search: sensitivities at its best point, steps to the minimum, ends of intervals.

The derivatives at the best point give the step of Gauss and Newton; each run there brings them up to date (Broyden
1965). Where the minimum is farther away than the noise makes it uncertain, they are taken again there. One run at
each end of the linearised intervals then shows whether the model is nonlinear. The state is plain data; residuals are
read again from the runs, whose rows are counted from the first of these.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.base import Snapshot
from geoswarm.solver.search.bounded import bounded_least_squares
from geoswarm.solver.search.descent.interval_ends import IntervalEnds, plan_from_residuals
from geoswarm.solver.search.descent.projection import admissible
from geoswarm.solver.search.descent.steps import Moves, StepSearch
from geoswarm.solver.search.determinism import one_thread
from geoswarm.solver.search.runs import Runs, latest_residuals
from geoswarm.solver.search.space import SearchSpace

__all__ = ["LOST_IN_NOISE", "MinimumSearch", "Walk"]

_SMALL_GAIN = 1e-10  # of f: less is not worth a run
_NEAR = 0.5  # standard errors: derivatives hold at a minimum that is no farther away
_MOST_TRIALS = 12  # before the derivatives are taken again
_MOST_FAILED = 4  # trials without a better point, one after the other
_MOST_ROUNDS = 4  # of derivatives
_DAMPING = 1e-2  # after the first trial that was no better
_HALVINGS = 10  # of a step that constraints exclude
_ROOM = 1e-12  # parts of the range: the least that a bound must leave

LOST_IN_NOISE = 1e-3
"""Decrease of the objective that is none, in parts of the variance of the noise: a thirtieth of a standard error."""


@dataclass(frozen=True, slots=True)
class Walk:
    """From the point of the differences towards the minimum.

    Parameters
    ----------
    row
        Of the best point.
    residuals
        There, weighted, shape (m,).
    jacobian
        By differences, per range, shape (m, d).
    far
        Whether that point is too far from the differences for them.
    trial
        Where to go next, shape (d,), parts of the range; None at the minimum.
    """

    row: int
    residuals: FloatArray
    jacobian: FloatArray
    far: bool
    trial: FloatArray | None


@dataclass(frozen=True, slots=True)
class _State:
    """What goes on; rows and generations told so far.

    ``optimum``, natural values, is where the differences ``moves`` are taken, the first of them at row ``first``;
    ``trials``, natural values, come after these.
    """

    stage: Literal["differences", "trial", "ends", "done"]
    optimum: FloatArray
    moves: list[Moves]
    generation: int = 0
    told: int = 0
    first: int = 0
    rounds: int = 1
    trials: tuple[FloatArray, ...] = ()
    ends: IntervalEnds | None = None


class MinimumSearch:
    """The runs that a result needs.

    Parameters
    ----------
    space
        Where.
    start
        The best point of the search, shape (d,), natural values.
    most
        Runs at most; nothing is begun that does not fit.
    snapshot
        To go on from.
    """

    def __init__(self, space: SearchSpace, start: FloatArray, most: int, snapshot: Snapshot | None = None) -> None:
        self._space, self._most = space, most
        if snapshot is None:
            self._state = _State("differences", start, StepSearch(space, start).generations)
            if len(self._steps.positions) > most:
                self._state = replace(self._state, stage="done")
        else:
            self._state = _restored(snapshot)

    # ---- ask and tell

    def ask(self) -> FloatArray | None:
        """Positions of the current generation; None at the end."""
        state = self._state
        if state.stage == "differences":
            return self._steps.positions
        if state.stage == "trial":
            return state.trials[-1][None, :]
        return state.ends.positions if state.stage == "ends" and state.ends is not None else None

    def tell(self, objectives: FloatArray, runs: Runs | None = None) -> None:
        """Take the results of the current generation."""
        state = self._state
        state = replace(state, told=state.told + len(objectives), generation=state.generation + 1)
        self._state = replace(state, stage="done")
        if state.stage == "ends":
            return
        rows = latest_residuals(runs, state.told)
        if not np.isfinite(rows[state.first]).all():
            return
        with one_thread():
            steps = self._steps.next(rows[state.first :]) if state.stage == "differences" else None
            if steps is not None and self._fits(len(steps.positions)):
                self._state = replace(state, moves=steps.generations)
            else:
                self._state = self._after(state, rows)

    def _after(self, state: _State, rows: FloatArray) -> _State:
        """Go towards the minimum, take the derivatives there, or look at the ends of the intervals."""
        walk = self.walk(rows)
        if walk.trial is not None and self._fits(1):
            return replace(state, stage="trial", trials=(*state.trials, self._space.from_unit(walk.trial)))
        place = self.place(walk.row)
        if walk.far:
            again = [self._steps.found(rows[state.first :])]
            if state.rounds == _MOST_ROUNDS or not self._fits(len(StepSearch(self._space, place, again).positions)):
                return replace(state, stage="done")
            there = replace(state, optimum=place, moves=again, first=state.told, trials=())
            return replace(there, stage="differences", rounds=state.rounds + 1)
        ends = plan_from_residuals(self._space, place, walk.jacobian, walk.residuals)
        wanted = len(ends.positions) > 0 and self._fits(len(ends.positions))
        return replace(state, stage="ends", ends=ends) if wanted else replace(state, stage="done")

    def _fits(self, count: int) -> bool:
        return self._state.told + count <= self._most

    # ---- what has been found

    @property
    def _steps(self) -> StepSearch:
        return StepSearch(self._space, self._state.optimum, self._state.moves)

    @property
    def _differences(self) -> int:
        return len(self._steps.every.positions)

    def place(self, row: int) -> FloatArray:
        """The point of the differences or a trial, natural values, shape (d,)."""
        state = self._state
        return state.optimum if row == state.first else state.trials[row - state.first - self._differences]

    def walk(self, rows: FloatArray) -> Walk:
        """Return how far the way to the minimum has got; ``rows``: weighted residuals so far, shape (N, m)."""
        state, at = self._state, self._state.first
        differences = np.nan_to_num(self._steps.columns(rows[at:]))
        jacobian, damping, failed = differences, 0.0, 0
        start = unit = self._space.to_unit(state.optimum)
        residuals = rows[at]
        for row, trial in enumerate(state.trials[: len(rows) - at - self._differences], at + self._differences):
            move, succeeded = self._space.to_unit(trial) - unit, bool(np.isfinite(rows[row]).all())
            length = float(move @ move)
            if succeeded and length > 0.0:  # Broyden's update
                miss = rows[row] - residuals - jacobian @ move
                jacobian = jacobian + np.outer(miss, move) / length
            better = succeeded and float(rows[row] @ rows[row]) < float(residuals @ residuals)
            damping, failed = (damping / 10.0, 0) if better else (max(10.0 * damping, _DAMPING), failed + 1)
            if better:
                at, unit, residuals = row, unit + move, rows[row]
        over = failed >= _MOST_FAILED or len(state.trials) >= _MOST_TRIALS
        ahead = None if over else self._next_trial(unit, residuals, jacobian, damping)
        if ahead is not None and np.array_equal(self._space.from_unit(ahead), self.place(at)):
            ahead = None  # the step is below the spacing of floats
        return Walk(at, residuals, differences, _far(jacobian @ (unit - start), residuals, len(unit)), ahead)

    def _next_trial(
        self, unit: FloatArray, residuals: FloatArray, jacobian: FloatArray, damping: float
    ) -> FloatArray | None:
        """The damped step of Gauss and Newton inside the bounds; None where it is not worth a run."""
        spare = len(residuals) - len(unit)
        moving = ~self._space.integer & (np.linalg.norm(jacobian, axis=0) > 0.0)
        if not moving.any():
            return None
        columns, step = jacobian[:, moving], np.zeros_like(unit)
        damped = np.diag(np.sqrt(damping) * np.linalg.norm(columns, axis=0))
        wanted = np.concatenate([-residuals, np.zeros(len(damped))])
        low, high = np.minimum(-unit[moving], -_ROOM), np.maximum(1.0 - unit[moving], _ROOM)
        step[moving] = bounded_least_squares(np.concatenate([columns, damped]), wanted, low, high)
        trial = np.clip(unit + step, 0.0, 1.0)
        for _ in range(_HALVINGS):
            if admissible(self._space, trial):
                break
            trial = 0.5 * (trial + unit)
        left = residuals + jacobian @ (trial - unit)
        before = float(residuals @ residuals)
        small = max(_SMALL_GAIN, LOST_IN_NOISE / spare) if spare > 0 else _SMALL_GAIN
        worth = before - float(left @ left) > small * before and admissible(self._space, trial)
        return trial if worth else None

    @property
    def differences(self) -> tuple[StepSearch, int] | None:
        """The differences that were told and their first row; None before a whole set was."""
        state = self._state
        known = state.moves[:-1] if state.stage == "differences" else state.moves
        return (StepSearch(self._space, state.optimum, known), state.first) if known and state.told else None

    @property
    def generation(self) -> int:
        """Closed generations."""
        return self._state.generation

    @property
    def told(self) -> int:
        """Runs of closed generations."""
        return self._state.told

    @property
    def trying(self) -> bool:
        """Whether the current generation is one run towards the minimum."""
        return self._state.stage == "trial"

    @property
    def ends(self) -> IntervalEnds | None:
        """Ends of the intervals, once they were run: the last rows."""
        return self._state.ends if self._state.stage == "done" else None

    def snapshot(self) -> Snapshot:
        """State between two generations, JSON-able."""
        state = self._state
        plain = {name: getattr(state, name) for name in ("stage", "generation", "told", "first", "rounds")}
        return plain | {
            "optimum": state.optimum.tolist(),
            "moves": [[list(move) for move in moves] for moves in state.moves],
            "trials": [trial.tolist() for trial in state.trials],
            "ends": None if state.ends is None else state.ends.to_json(),
        }


def _far(moved: FloatArray, residuals: FloatArray, dimension: int) -> bool:
    """Whether the residuals moved by more than the noise of the parameters makes of them."""
    spare = len(residuals) - dimension
    if not moved.any():
        return False
    return spare <= 0 or bool(moved @ moved > _NEAR**2 * float(residuals @ residuals) / spare)


def _restored(data: Mapping[str, Any]) -> _State:
    return _State(
        **{
            **data,
            "optimum": np.array(data["optimum"], dtype=np.float64),
            "moves": [[(int(index), float(step)) for index, step in moves] for moves in data["moves"]],
            "trials": tuple(np.array(trial, dtype=np.float64) for trial in data["trials"]),
            "ends": None if data["ends"] is None else IntervalEnds.from_json(data["ends"]),
        }
    )
