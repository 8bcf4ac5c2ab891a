"""One way down to a minimum of least squares: Levenberg-Marquardt that solves for what enters linearly by itself.

Parameters in which the residuals are linear, all together, are found by differences and a check far away. They are
neither damped nor stepped to: at each trial they take the values that fit best there (variable projection, Golub and
Pereyra 1973, with the slopes of Kaufman 1975), so that curved valleys between them and the others become straight.
Works in parts of the range in search coordinates, one generation at a time; the state is plain data, residuals are read
again from the runs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.bounded import bounded_least_squares
from geoswarm.solver.search.descent.projection import (
    FAR_MOVE,
    admissible,
    far_moves,
    moved,
    project,
    residuals_of,
    slopes_of_moves,
    stretched,
)
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace

__all__ = ["Outcome", "Refinement"]

Outcome: TypeAlias = Literal["", "converged", "stuck", "long", "worse"]

_COARSE, _FINE = 1e-4, 1e-5  # differences, parts of the range
_LINEAR, _LINEAR_LOG = 1e-5, 1e-6  # second over first difference: on a log scale what is nearly linear is common
_LINEAR_FAR = 1e-6  # misprediction over change
_DAMPING, _LEAST_DAMPING, _MOST_DAMPING = 1e-3, 1e-12, 1e8
_COARSE_GAIN, _FINE_GAIN = 1e-8, 1e-13  # of f: less is not worth a generation
_ROUNDING_GAIN, _LOST = 1e-8, 1e-11  # of f: predicted, but lost in rounding perhaps, and surely
_ABOVE, _HOPELESS = 1e-3, 1e-2  # a known minimum: of f; of the way down to it
_CENTRAL_FROM = 1e-2  # relative decrease below which differences are taken on both sides
_RAISE, _RAISE_FINE, _LOWER = 12.0, 100.0, 0.1  # of the damping
_SETTLED = 1e-6  # of f: less is promised with long differences at a minimum of a rough model
_NOTHING = 1e-20  # of the objective at the start: a perfect fit
_HALVINGS = 20


@dataclass(frozen=True, slots=True)
class Refinement:
    """State of a descent.

    Parameters
    ----------
    stage
        What is asked for: ``begin``, slopes on both sides; ``check``, whether the candidates enter linearly together;
        ``trial``, a trial point with moves of the linear parameters; ``slopes`` there.
    asked
        Points due for evaluation, shape (k, d), parts of the range.
    moves
        Parameter and length of each move among them; those of a trial or of slopes come after the point.
    current, row, objective
        Best point, its index among the runs, and f.
    gradient, curvature
        J'r and J'J there.
    goal
        Where the slopes of the stage are taken.
    linear, linear_rows
        Parameters that enter linearly; runs with their moves at the last trial: the trial itself, then one each.
    linear_moves
        Lengths of these, stretched on a log scale.
    damping, predicted, iterations
        Of Levenberg-Marquardt, and the decrease that the trial promises.
    fine, first, outcome
        Whether short differences are in use; f at the start; how it ended.
    known
        f of the best minimum known before. What does no better needs no short differences; what promises hardly any
        of the way down to it is left.
    promise
        Largest decrease of f that a step from the current point promised with long differences, relative to f.
    tried
        The run at the last trial point; None in a state that an earlier version wrote, which went down alone.
    """

    stage: Literal["begin", "check", "trial", "slopes"]
    asked: FloatArray
    moves: tuple[tuple[int, float], ...]
    current: FloatArray
    row: int
    objective: float
    gradient: FloatArray
    curvature: FloatArray
    goal: FloatArray
    linear: tuple[int, ...] = ()
    linear_rows: tuple[int, ...] = ()
    linear_moves: tuple[float, ...] = ()
    damping: float = _DAMPING
    predicted: float = 0.0
    iterations: int = 0
    fine: bool = False
    first: float = 0.0
    outcome: Outcome = ""
    known: float | None = None
    promise: float = 0.0
    tried: int | None = None

    @classmethod
    def begin(cls, space: SearchSpace, runs: Runs, row: int, known: float | None = None) -> Refinement:
        """Begin at a run."""
        point = space.to_unit(runs.positions[row])
        nothing = np.zeros(len(point))
        objective = float(runs.objectives[row])
        state = cls("begin", point[None], (), point, row, objective, nothing, np.diag(nothing), point)
        return replace(state, first=objective, known=known)._slopes(space, both=True)

    @property
    def finished(self) -> bool:
        """Whether nothing is left to ask for."""
        return self.outcome != ""

    @property
    def on_bound(self) -> bool:
        """Whether the best point lies on a bound."""
        return bool(((self.current <= 1e-9) | (self.current >= 1.0 - 1e-9)).any())

    def advance(self, space: SearchSpace, runs: Runs, longest: int) -> Refinement:
        """Take the results at the points asked for, the last of the runs; at most ``longest`` iterations."""
        if self.stage == "begin":
            return self._begun(space, runs)
        if self.stage == "check":
            return self._checked(space, runs)
        if self.stage == "trial":
            return self._tried(space, runs)
        return self._sloped(space, runs, longest)

    # ---- slopes

    def _slopes(self, space: SearchSpace, *, both: bool) -> Refinement:
        """Ask for moves of the parameters whose slopes are not known at the goal, and for the goal if it is new."""
        length = _FINE if self.fine else _COARSE
        points, moves = [], []
        for index in np.flatnonzero(~space.integer).tolist():
            if index in self.linear:
                continue
            sides = [side for side in (length, -length) if admissible(space, moved(self.goal, index, side))]
            if both and len(sides) == 1 and admissible(space, moved(self.goal, index, 2.0 * sides[0])):
                sides.append(2.0 * sides[0])
            for side in sides if both else sides[:1]:
                points.append(moved(self.goal, index, side))
                moves.append((index, side))
        first = [self.goal] if self.linear else []
        if not points and not first:
            return replace(self, outcome="converged")
        return replace(self, asked=np.array([*first, *points]), moves=tuple(moves))

    def _jacobian(
        self, space: SearchSpace, runs: Runs, centre: FloatArray, first: int
    ) -> tuple[FloatArray, FloatArray]:
        """Slopes from the moves, rows from ``first`` on, shape (m, d), and how far two sides differ, shape (d,).

        Sides differ by what is not linear in natural values.
        """
        columns = np.zeros((centre.size, len(self.current)))
        bend = np.full(len(self.current), np.inf)
        for index in dict.fromkeys(index for index, _ in self.moves):
            sides = [
                (length, residuals_of(runs, first + place))
                for place, (parameter, length) in enumerate(self.moves)
                if parameter == index and runs.succeeded[first + place]
            ]
            if len(sides) == 2:
                (a, near), (b, other) = sides
                if b == -a:
                    columns[:, index] = (near - other) / (2.0 * a)
                    size, second = near - other, near - 2.0 * centre + other
                else:  # both on one side, b = 2 a
                    columns[:, index] = (4.0 * near - 3.0 * centre - other) / (2.0 * a)
                    size, second = other - centre, other - 2.0 * near + centre
                rounding = 1e-14 * float(np.linalg.norm(np.abs(near) + np.abs(other)))
                change = float(np.linalg.norm(size))
                if space.log[index]:
                    ahead, behind = ((there - centre) / stretched(space, index, length) for length, there in sides)
                    change, second = float(np.linalg.norm(a * (ahead + behind))), a * (ahead - behind)
                bend[index] = max(float(np.linalg.norm(second)) - rounding, 0.0) / change if change > 0.0 else np.inf
                if space.log[index] and bend[index] < _LINEAR_LOG:
                    columns[:, index] = 0.5 * (ahead + behind)
            elif sides:
                columns[:, index] = (sides[0][1] - centre) / sides[0][0]
        return columns, bend

    def _with_slopes(self, columns: FloatArray, centre: FloatArray) -> Refinement:
        return replace(self, gradient=columns.T @ centre, curvature=columns.T @ columns)

    # ---- stages

    def _begun(self, space: SearchSpace, runs: Runs) -> Refinement:
        centre = residuals_of(runs, self.row)
        columns, bend = self._jacobian(space, runs, centre, len(runs.positions) - len(self.asked))
        after = self._with_slopes(columns, centre)
        linear = bend < np.where(space.log, _LINEAR_LOG, _LINEAR)
        candidates = np.flatnonzero(linear & (np.linalg.norm(columns, axis=0) > 0.0)).tolist()
        point, points, moves = self.current, [], []
        for index in candidates:  # one after the other: products of two are linear in either alone
            far = FAR_MOVE if point[index] <= 0.5 else -FAR_MOVE
            point = moved(point, index, far)
            if not admissible(space, point):
                break
            points.append(point)
            moves.append((index, far))
        if not points:
            return after._next(space)
        return replace(after, stage="check", asked=np.array(points), moves=tuple(moves))

    def _checked(self, space: SearchSpace, runs: Runs) -> Refinement:
        first = len(runs.positions) - len(self.asked)
        linear: list[int] = []
        if runs.succeeded[first:].all():
            rows = [self.row, *range(first, len(runs.positions))]
            changes = np.diff(np.array([residuals_of(runs, row) for row in rows]), axis=0)
            for place, (index, length) in enumerate(self.moves):
                # J'J and J'r at the start tell the change that a linear parameter makes anywhere
                sizes = changes[: place + 1] @ changes[place]
                reach = stretched(space, index, length)
                before = self.moves[: place + 1]
                expected = np.array([self.curvature[i, index] * reach * stretched(space, i, far) for i, far in before])
                scale = np.sqrt(np.sum(changes[: place + 1] ** 2, axis=1) * sizes[-1])
                if (np.abs(sizes - expected) > _LINEAR_FAR * np.maximum(scale, 1e-300)).any():
                    break
                linear.append(index)
        return replace(self, linear=tuple(linear))._next(space)

    def _tried(self, space: SearchSpace, runs: Runs) -> Refinement:
        first = len(runs.positions) - len(self.asked)
        trial = self.asked[0]
        if not runs.succeeded[first]:
            return self._shorter(space)
        goal, objective = trial, float(runs.objectives[first])
        rows: tuple[int, ...] = ()
        lengths: tuple[float, ...] = ()
        if self.linear:
            if not runs.succeeded[first:].all():
                return replace(self, linear=())._shorter(space)
            rows = tuple(range(first, first + len(self.asked)))
            lengths = tuple(stretched(space, *move) for move in self.moves)
            columns = slopes_of_moves(runs, rows, lengths)
            best, promised = project(space, trial, self.linear, residuals_of(runs, first), columns)
            if admissible(space, best):
                goal, objective = best, promised
        if objective >= self.objective:
            return self._shorter(space)
        gained = (self.objective - objective) / max(self.predicted, 1e-300)
        factor = _LOWER if gained > 0.75 else 1.0 if gained > 0.25 else 4.0
        after = replace(
            self,
            stage="slopes",
            goal=goal,
            damping=max(self.damping * factor, _LEAST_DAMPING),
            linear_rows=rows,
            linear_moves=lengths,
            tried=first,
        )
        return after._slopes(space, both=self.fine or objective > self.objective * (1.0 - _CENTRAL_FROM))

    def _sloped(self, space: SearchSpace, runs: Runs, longest: int) -> Refinement:
        first = len(runs.positions) - len(self.asked)
        row = first if self.linear else self._goal_row(first)
        if not runs.succeeded[row] or (runs.objectives[row] >= self.objective and row != self.row and not self.fine):
            return replace(self, linear=())._shorter(space)
        centre = residuals_of(runs, row)
        columns, _ = self._jacobian(space, runs, centre, first + bool(self.linear))
        if self.linear:
            columns[:, list(self.linear)] = self._slopes_at_goal(space, runs)
        after = replace(
            self, current=self.goal, row=row, objective=float(runs.objectives[row]), iterations=self.iterations + 1
        )._with_slopes(columns, centre)
        after = after if self.fine else replace(after, promise=0.0)
        return replace(after, outcome="long") if after.iterations >= longest else after._next(space)

    def _slopes_at_goal(self, space: SearchSpace, runs: Runs) -> FloatArray:
        """Slopes along the linear parameters at the goal, shape (m, k), from the moves at the last trial."""
        slopes = slopes_of_moves(runs, self.linear_rows, self.linear_moves)
        trial = space.to_unit(runs.positions[self.linear_rows[0]])
        span = space.search_upper - space.search_lower
        for place, index in enumerate(self.linear):
            if space.log[index]:  # the natural value is steeper where it is larger
                slopes[:, place] *= np.exp(span[index] * (self.goal[index] - trial[index]))
        return slopes

    def _goal_row(self, first: int) -> int:
        """The run at the goal: the trial before its slopes, or the current point when they are taken anew."""
        if np.array_equal(self.goal, self.current):
            return self.row
        return first - 1 if self.tried is None else self.tried

    def _shorter(self, space: SearchSpace) -> Refinement:
        """A trial was no better: lost in rounding, or damp more."""
        if self.predicted <= _ROUNDING_GAIN * self.objective:
            damping = self.damping * _RAISE_FINE
            if self.fine and self.predicted > _LOST * self.objective and damping < 1.0:
                return replace(self, damping=damping)._next(space)  # too long a step along a curved valley?
            return self._finer(space)
        damping = self.damping * (_RAISE_FINE if self.fine else _RAISE)
        if damping > _MOST_DAMPING:
            return self._finer(space)
        return replace(self, damping=damping)._next(space)

    def _finer(self, space: SearchSpace) -> Refinement:
        """Nothing to gain with these differences: once more with shorter ones, or the end."""
        if self.fine and self.damping > 1.0 and self.promise > _SETTLED:  # so short a step says nothing of what is left
            return replace(self, outcome="stuck")
        if self.fine or (self.known is not None and self.objective >= self.known):
            return replace(self, outcome="converged")
        again = replace(self, stage="slopes", fine=True, goal=self.current, linear=(), damping=_LEAST_DAMPING)
        return again._slopes(space, both=True)

    def _next(self, space: SearchSpace) -> Refinement:
        """Ask for the next trial."""
        if self.objective <= _NOTHING * self.first:
            return replace(self, outcome="converged")
        step = self._step()
        trial = np.clip(self.current + step, 0.0, 1.0)
        for _ in range(_HALVINGS):
            if admissible(space, trial):
                break
            trial = 0.5 * (trial + self.current)
        else:
            return replace(self, outcome="stuck")
        step = trial - self.current
        predicted = -float(2.0 * self.gradient @ step + step @ self.curvature @ step)
        above = 0.0 if self.known is None else self.objective - self.known
        if self.damping <= _DAMPING and above > _ABOVE * self.objective and predicted < _HOPELESS * above:
            return replace(self, outcome="worse")
        if not predicted > (_FINE_GAIN if self.fine else _COARSE_GAIN) * self.objective:
            return self._finer(space)
        moves = far_moves(trial, self.linear)
        points = [moved(trial, index, length) for index, length in moves]
        if not all(admissible(space, point) for point in points):
            return replace(self, linear=())._next(space)
        promise = self.promise if self.fine else max(self.promise, predicted / self.objective)
        asked = np.array([trial, *points])
        return replace(self, stage="trial", asked=asked, moves=moves, predicted=predicted, goal=trial, promise=promise)

    def _step(self) -> FloatArray:
        """The damped step inside the bounds; parameters that enter linearly are not damped."""
        values, vectors = np.linalg.eigh(self.curvature)
        values = np.maximum(values, 0.0)
        keep = values > 1e-15 * max(float(values[-1]), 1e-300)
        root = np.sqrt(values[keep])
        system, wanted = root[:, None] * vectors[:, keep].T, -(vectors[:, keep].T @ self.gradient) / root
        diagonal = np.diag(self.curvature).copy()
        diagonal[diagonal <= 0.0] = max(float(diagonal.max()), 1e-300)
        diagonal[list(self.linear)] = 0.0
        damped = np.diag(np.sqrt(self.damping * diagonal))
        low, high = np.minimum(-self.current, -1e-15), np.maximum(1.0 - self.current, 1e-15)
        wanted = np.concatenate([wanted, np.zeros(len(diagonal))])
        return bounded_least_squares(np.concatenate([system, damped]), wanted, low, high)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, from which :meth:`from_json` restores exactly."""
        data = {name: getattr(self, name) for name in self.__slots__ if name not in _ARRAYS}
        return data | {name: getattr(self, name).tolist() for name in _ARRAYS}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Refinement:
        """Restore from :meth:`to_json`."""
        arrays = {name: np.array(data[name], dtype=np.float64) for name in _ARRAYS}
        listed = {name: tuple(data[name]) for name in ("linear", "linear_rows", "linear_moves")}
        moves = tuple((int(index), float(length)) for index, length in data["moves"])
        return cls(**{**data, **arrays, **listed, "moves": moves})


_ARRAYS = ("asked", "current", "gradient", "curvature", "goal")
