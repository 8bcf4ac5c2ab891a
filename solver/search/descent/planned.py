"""Ask / tell of follow-ups: sensitivities at an optimum, profiles, and the designs of global sensitivity."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import InfeasibleSpaceError
from geoswarm.solver.search.base import Snapshot
from geoswarm.solver.search.descent.descent import Descent
from geoswarm.solver.search.descent.differences import DifferenceDesign, plan_differences
from geoswarm.solver.search.descent.interval_ends import IntervalEnds, plan_from_residuals
from geoswarm.solver.search.descent.profile_paths import ProfilePath
from geoswarm.solver.search.descent.steps import FIRST_STEP, Moves, StepSearch
from geoswarm.solver.search.determinism import one_thread
from geoswarm.solver.search.runs import Runs, latest_residuals
from geoswarm.solver.search.space import SearchSpace

__all__ = [
    "BLIND_STEP",
    "DesignSearch",
    "GlobalPoints",
    "ProfileSearch",
    "ProfileSettings",
    "SensitivitySearch",
    "SensitivitySettings",
]

_FEWEST_BLOCKS = 8
_LARGEST_DRAW = 2**17  # blocks drawn at most in the search for feasible ones

BLIND_STEP = 0.05
"""First step of a profile, in parts of the range, where nothing is known about its width."""


@dataclass(frozen=True, slots=True)
class SensitivitySettings:
    """The optimum, shape (d,), natural values; largest offset in parts of the range, found where it is None; whether to
    polish first.
    """

    optimum: FloatArray
    step: float | None
    polish: bool = False


class SensitivitySearch:
    """Differences at the optimum, after the generations of a descent where that is wanted.

    One generation with a given step; otherwise further ones, until the step of each parameter is found, and then one at
    the ends of the linearised intervals, which shows whether the model is nonlinear there.
    """

    def __init__(self, space: SearchSpace, settings: SensitivitySettings, snapshot: Snapshot | None = None) -> None:
        self._space = space
        self._settings = settings
        self.generation = 0
        self.done = False
        self.descent = Descent(space.to_unit(settings.optimum)) if settings.polish else None
        self.ends: IntervalEnds | None = None
        """Of the linearised intervals, once the steps are found."""
        moves = None
        if snapshot is not None:
            self.generation, self.done = snapshot["generation"], snapshot["done"]
            self.descent = None if snapshot["descent"] is None else Descent.from_json(snapshot["descent"])
            moves = [[(int(i), float(h)) for i, h in moves] for moves in snapshot.get("moves") or []]
            ends = snapshot.get("ends")
            self.ends = None if ends is None else IntervalEnds.from_json(ends)
        self._moves: list[Moves] | None = moves or None

    @property
    def optimum(self) -> FloatArray:
        """Where the differences are taken, shape (d,), natural values; the best point of the descent so far."""
        descent = self.descent
        moved = descent is not None and descent.current is not None
        return self._space.from_unit(descent.best) if descent is not None and moved else self._settings.optimum

    @property
    def steps(self) -> StepSearch | None:
        """The generations of differences, where their steps are found; None with a given step."""
        return StepSearch(self._space, self.optimum, self._moves) if self._settings.step is None else None

    @property
    def plan(self) -> DifferenceDesign:
        """All differences asked for so far; around the best point so far while the descent goes on."""
        step = self._settings.step
        steps = self.steps
        return plan_differences(self._space, self.optimum, step or FIRST_STEP) if steps is None else steps.every

    @property
    def descending(self) -> bool:
        """Whether the current generation is one of the descent."""
        return self.descent is not None and not self.descent.finished

    def ask(self) -> FloatArray | None:
        """Positions of the current generation; None after the differences."""
        if self.done:
            return None
        if self.descent is not None and not self.descent.finished:
            return self.descent.positions(self._space)
        if self.ends is not None:
            return self.ends.positions
        steps = self.steps
        return self.plan.positions if steps is None else steps.positions

    def tell(self, objectives: FloatArray, runs: Runs | None = None) -> None:
        """Take the results of the current generation."""
        steps = self.steps
        with one_thread():
            if self.descent is not None and not self.descent.finished:
                self.descent = self.descent.advance(latest_residuals(runs, len(objectives)))
            elif self.ends is not None:
                self.done = True
            elif steps is not None:
                rows = latest_residuals(runs, len(steps.every.positions))
                following = steps.next(rows)
                self._moves = steps.generations if following is None else following.generations
                if following is None:
                    found = self._ends(steps, rows)
                    self.done = not len(found.positions)
                    self.ends = None if self.done else found
            else:
                self.done = True
        self.generation += 1

    def _ends(self, steps: StepSearch, rows: FloatArray) -> IntervalEnds:
        """Ends of the intervals that the weighted residuals of all differences, shape (N, n), give."""
        columns = steps.columns(rows)
        return plan_from_residuals(self._space, self.optimum, columns, rows[0])

    def snapshot(self) -> Snapshot:
        """State between two generations, JSON-able."""
        ends = None if self.ends is None else self.ends.to_json()
        descent = None if self.descent is None else self.descent.to_json()
        moves = None if self._moves is None else [[list(move) for move in moves] for moves in self._moves]
        return {"generation": self.generation, "done": self.done, "descent": descent, "moves": moves, "ends": ends}


@dataclass(frozen=True, slots=True)
class ProfileSettings:
    """What to profile.

    Parameters
    ----------
    optimum
        Shape (d,), natural values.
    rise
        Of the objective at the ends of the interval, shape (d,); nan for parameters that are not profiled.
    step
        First step away from the optimum, shape (d,), parts of the range.
    """

    optimum: FloatArray
    rise: FloatArray
    step: FloatArray


class ProfileSearch:
    """Profiles of several parameters, both sides, all paths in parallel; generation 0 has the optimum as well."""

    def __init__(self, space: SearchSpace, settings: ProfileSettings, snapshot: Snapshot | None = None) -> None:
        self.space = space
        self.settings = settings
        self.generation = 0
        self.objective: float | None = None
        """f at the optimum; None before generation 0."""
        self.failed = False
        """The optimum itself failed: there is nothing to profile."""
        if snapshot is None:
            self.paths = self._begin()
        else:
            self.generation, self.objective = snapshot["generation"], snapshot["objective"]
            self.failed = snapshot["failed"]
            self.paths = tuple(ProfilePath.from_json(path) for path in snapshot["chains"])

    def _begin(self) -> tuple[ProfilePath, ...]:
        settings = self.settings
        unit = self.space.to_unit(settings.optimum)
        return tuple(
            ProfilePath.begin(
                index,
                side,
                unit,
                float(settings.step[index]),
                float(np.nan_to_num(settings.rise[index])),
                idle=not np.isfinite(settings.rise[index]),
            )
            for index in range(self.space.dimension)
            for side in (-1, 1)
        )

    @property
    def finished(self) -> bool:
        """Whether nothing is left to evaluate."""
        return self.failed or (self.objective is not None and all(path.finished for path in self.paths))

    def ask(self) -> FloatArray | None:
        """Positions of the current generation; None when all profiles have ended."""
        if self.finished:
            return None
        parts = [path.positions(self.space) for path in self.paths if not path.finished]
        first = [self.settings.optimum[None, :]] if self.objective is None else []
        return np.concatenate([*first, *parts])

    def tell(self, objectives: FloatArray, runs: Runs | None = None) -> None:
        """Take the results of the current generation."""
        self.take(latest_residuals(runs, len(objectives)))

    def take(self, residuals: FloatArray) -> None:
        """Take the weighted residual vectors of the current generation, shape (n, m); nan where it failed."""
        rows = residuals
        if self.objective is None:
            lowest = float(np.sum(rows[0] * rows[0]))
            self.failed = not np.isfinite(lowest)
            self.objective, rows = (None if self.failed else lowest), rows[1:]
        self.generation += 1
        if self.objective is None:
            return
        paths, start = [], 0
        with one_thread():
            for path in self.paths:
                size = 0 if path.finished else self.space.dimension
                own = rows[start : start + size]
                paths.append(path if path.finished else path.advance(self.space, own, self.objective))
                start += size
        self.paths = tuple(paths)

    def snapshot(self) -> Snapshot:
        """State between two generations, JSON-able."""
        return {
            "generation": self.generation,
            "objective": self.objective,
            "failed": self.failed,
            "chains": [path.to_json() for path in self.paths],
        }


@dataclass(frozen=True)
class GlobalPoints:
    """The points of a design for global sensitivity, drawn as a whole; keep one for all restores of a search.

    Parameters
    ----------
    space
        Where.
    kind
        ``sobol`` (Saltelli et al. 2010) or ``morris`` (Morris 1991; Campolongo et al. 2007), drawn by SALib.
    samples
        Base points, a power of two, or trajectories.
    seed
        Of the design.
    """

    space: SearchSpace
    kind: Literal["sobol", "morris"]
    samples: int
    seed: int

    @property
    def block(self) -> int:
        """Rows that belong together: d + 2 of a Sobol point, d + 1 of a Morris trajectory."""
        return self.space.dimension + (2 if self.kind == "sobol" else 1)

    @cached_property
    def unit(self) -> FloatArray:
        """Positions in parts of the range in search coordinates, shape (n, d), all feasible.

        With constraints, blocks are drawn until enough lie wholly in the feasible part, or as many as a bounded
        number of them has. Indices then describe the part of the space that such blocks fill.

        Raises
        ------
        InfeasibleSpaceError
            When fewer than eight blocks are feasible.
        """
        factor = 1
        while True:
            blocks = self._draw(self.samples * factor).reshape(-1, self.block, self.space.dimension)
            whole = [block for block in blocks if all(map(self.space.feasible, self.space.from_unit(block)))]
            if len(whole) >= self.samples or self.samples * factor * 2 > _LARGEST_DRAW:
                break
            factor *= 2
        if len(whole) < _FEWEST_BLOCKS:
            raise InfeasibleSpaceError(
                f"only {len(whole)} of {len(blocks)} blocks of the {self.kind} design satisfy the constraints at each "
                f"of their {self.block} positions, {_FEWEST_BLOCKS} are needed; narrow the bounds or relax the "
                "constraints"
            )
        return np.concatenate(whole[: self.samples])

    def _draw(self, samples: int) -> FloatArray:
        from SALib.sample import morris, sobol

        names = list(self.space.names)
        seed = self.seed % 2**32  # all that it takes
        problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
        if self.kind == "sobol":
            return np.asarray(sobol.sample(problem, samples, calc_second_order=False, seed=seed))
        return np.asarray(morris.sample(problem, samples, seed=seed))

    @cached_property
    def positions(self) -> FloatArray:
        """The same as natural values."""
        return self.space.from_unit(self.unit)


class DesignSearch:
    """Ask and tell of a fixed design in generations; learns nothing from the objectives."""

    def __init__(self, points: GlobalPoints, batch: int, snapshot: Snapshot | None = None) -> None:
        self._points = points
        self._batch = batch
        self.generation: int = 0 if snapshot is None else snapshot["generation"]

    def ask(self) -> FloatArray | None:
        """Positions of the current generation; None when the design is complete."""
        first = self.generation * self._batch
        positions = self._points.positions[first : first + self._batch]
        return positions if len(positions) else None

    def tell(self, objectives: FloatArray, runs: Runs | None = None) -> None:  # noqa: ARG002  (it does not learn)
        """Close the current generation."""
        self.generation += 1

    def snapshot(self) -> Snapshot:
        """State between two generations, JSON-able."""
        return {"generation": self.generation}
