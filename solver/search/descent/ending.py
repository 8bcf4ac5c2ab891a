"""The end of a polished search: from the best run down to a minimum, and from other basins where that one is in doubt.

A minimum on a bound, one whose residuals follow each other, one that some parameter does not change at all, or a
descent that ended with gradients left may not be the least one. Then the best runs of other basins are refined, too,
until two of them agree on the best minimum; parameters that enter linearly help to find such basins. No run that is
better than all of these ends is left behind: it is the next start.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.descent.refinement import Refinement
from geoswarm.solver.search.descent.survey import Survey
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace

__all__ = ["Descended", "Ending"]

_STARTS = 8
_APART = 0.1  # parts of the range to the nearest better run, and between starts
_LONGEST, _LONGEST_LATER = 80, 40  # iterations
_SAME = 1e-6  # relative difference of objectives of one minimum
_ARRIVED, _ABOVE = 1e-3, 1e-3  # at a known minimum: parts of the range, and of its objective
_BESIDE, _ROUGH = 1e-2, 1e-3  # parts of the range; of the objective
_LITTLE = 1e-2  # of the objective, promised where a descent is stuck
_IDLE = 1e-3  # change by a move through the range at the slope of the end, relative to the residuals
_FOLLOWING = 2.5  # autocorrelation of residuals, in its standard errors
_AGREE, _AGREE_ON_BOUND = 2, 4  # descents that end alike
_FEWEST = 8  # residuals for an autocorrelation


@dataclass(frozen=True, slots=True)
class Descended:
    """Where a descent ended: run, f, whether a minimum, on a bound, or whether another basin may hold a better one."""

    row: int
    objective: float
    converged: bool
    on_bound: bool
    doubtful: bool


@dataclass(frozen=True, slots=True)
class Ending:
    """State of the end of a search.

    Parameters
    ----------
    current
        The descent under way.
    starts
        Runs from which others may begin, the best first.
    descended
        Those that ended.
    linear
        Parameters that were found to enter linearly.
    survey, surveyed
        The look at the whole space that is under way, and whether there was one.
    finished
        Whether nothing is left to do.
    """

    current: Refinement
    starts: tuple[int, ...]
    descended: tuple[Descended, ...] = ()
    linear: tuple[int, ...] = ()
    survey: Survey | None = None
    surveyed: bool = False
    finished: bool = False

    @classmethod
    def begin(cls, space: SearchSpace, runs: Runs) -> Ending:
        """Begin at the best run."""
        order = np.argsort(runs.objectives, kind="stable")[: int(runs.succeeded.sum())]
        unit = space.to_unit(runs.positions[order])
        starts = [0]
        for i in range(1, len(order)):
            if len(starts) == _STARTS:
                break
            if float(np.abs(unit[:i] - unit[i]).max(axis=1).min()) > _APART:
                starts.append(i)
        rows = [int(order[i]) for i in starts]
        state = cls(Refinement.begin(space, runs, rows[0]), tuple(rows[1:]))
        return state._following(space, runs) if state.current.finished else state

    @property
    def converged(self) -> bool:
        """Whether the best of all descents ended at a minimum."""
        return min(self.descended, key=lambda end: end.objective).converged if self.descended else False

    def positions(self, space: SearchSpace) -> FloatArray:
        """Points of the current generation, shape (k, d), natural values."""
        return space.from_unit(self.current.asked if self.survey is None else self.survey.asked)

    def advance(self, space: SearchSpace, runs: Runs) -> Ending:
        """Take the results of the current generation, the last of the runs."""
        if self.survey is not None:
            return self._looked(space, runs, self.survey)
        leading = self.current.known is None or self.current.objective < self.current.known
        current = self.current.advance(space, runs, _LONGEST if leading else _LONGEST_LATER)
        after = replace(self, current=current, linear=self.linear or current.linear)
        return after._following(space, runs) if current.finished or after._arrived(space, runs) else after

    def _arrived(self, space: SearchSpace, runs: Runs) -> Descended | None:
        """The minimum, known already, that the descent has come to."""
        for end in self.descended:
            apart = float(np.abs(space.to_unit(runs.positions[end.row]) - self.current.current).max())
            if end.converged and apart < _ARRIVED and self.current.objective <= end.objective * (1.0 + _ABOVE):
                return end
        return None

    def _following(self, space: SearchSpace, runs: Runs) -> Ending:
        """The descent ended: the next one, or the end."""
        end = self._arrived(space, runs) or _end(space, runs, self.current)
        after = replace(self, descended=(*self.descended, end))
        best = min(after.descended, key=lambda other: other.objective)
        agreed = sum(other.converged and other.objective <= best.objective * (1.0 + _SAME) for other in after.descended)
        sure = not best.doubtful or agreed >= (_AGREE_ON_BOUND if best.on_bound else _AGREE)
        better = _better(space, runs, best)
        if better is not None:
            return after._begin(space, runs, better)
        if sure:
            return replace(after, finished=True)
        if not after.surveyed:
            centre = space.to_unit(runs.positions[best.row])
            survey = Survey.begin(space, centre, after.linear)
            after = replace(after, survey=survey, surveyed=survey is not None)
        return after if after.survey is not None else after._next(space, runs)

    def _looked(self, space: SearchSpace, runs: Runs, survey: Survey) -> Ending:
        """Take a generation of the survey; the points of the second one are starts."""
        if not survey.projected:
            following = survey.advance(space, runs)
            after = replace(self, survey=following)
            return after if following is not None else after._next(space, runs)
        first = len(runs.positions) - len(survey.asked)
        rows = [first + i for i in range(len(survey.asked)) if runs.succeeded[first + i]]
        # in turn: the search itself crowds around few basins, whose objectives are the lower for that
        pairs = zip_longest(rows, self.starts)
        starts = tuple(row for pair in pairs for row in pair if row is not None)
        return replace(self, survey=None, starts=starts)._next(space, runs)

    def _next(self, space: SearchSpace, runs: Runs) -> Ending:
        """The next start, if one is left."""
        if not self.starts:
            return replace(self, finished=True)
        return replace(self, starts=self.starts[1:])._begin(space, runs, self.starts[0])

    def _begin(self, space: SearchSpace, runs: Runs, row: int) -> Ending:
        minima = [end.objective * (1.0 - _SAME) for end in self.descended if end.converged]
        following = replace(self, current=Refinement.begin(space, runs, row, min(minima, default=None)))
        return following._following(space, runs) if following.current.finished else following

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, from which :meth:`from_json` restores exactly."""
        return {
            "current": self.current.to_json(),
            "starts": list(self.starts),
            "descended": [
                [end.row, end.objective, end.converged, end.on_bound, end.doubtful] for end in self.descended
            ],
            "linear": list(self.linear),
            "survey": None if self.survey is None else self.survey.to_json(),
            "surveyed": self.surveyed,
            "finished": self.finished,
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Ending:
        """Restore from :meth:`to_json`."""
        return cls(
            Refinement.from_json(data["current"]),
            tuple(data["starts"]),
            tuple(Descended(*end) for end in data["descended"]),
            tuple(data["linear"]),
            None if data["survey"] is None else Survey.from_json(data["survey"]),
            data["surveyed"],
            data["finished"],
        )


def _end(space: SearchSpace, runs: Runs, current: Refinement) -> Descended:
    """How a descent ended. A place where nothing changes the responses is not a minimum."""
    idle = np.diag(current.curvature)[~space.integer] <= _IDLE**2 * current.objective
    converged = current.outcome == "converged" and not (idle.size and idle.all())
    rough = current.outcome == "stuck" and current.promise <= _LITTLE  # no reason to look elsewhere
    doubtful = not (converged or rough) or current.on_bound or bool(idle.any()) or _follow_each_other(runs, current.row)
    return Descended(current.row, current.objective, converged, current.on_bound, doubtful)


def _better(space: SearchSpace, runs: Runs, best: Descended) -> int | None:
    """The best run of all, where it is better than every end; beside the end only beyond what roughness makes."""
    row = int(np.argmin(runs.objectives))
    apart = float(np.abs(space.to_unit(runs.positions[row]) - space.to_unit(runs.positions[best.row])).max())
    gain = _SAME if apart > _BESIDE else _ROUGH
    return row if runs.objectives[row] < best.objective * (1.0 - gain) else None


def _follow_each_other(runs: Runs, row: int) -> bool:
    """Whether the residuals of a run are correlated with their neighbours beyond chance."""
    residuals = np.asarray(runs.residuals(np.array([row]))[0])
    residuals = residuals[residuals != 0.0]
    total = float(residuals @ residuals)
    if residuals.size < _FEWEST or total == 0.0:
        return False
    return float(residuals[:-1] @ residuals[1:]) / total > _FOLLOWING / float(np.sqrt(residuals.size))
