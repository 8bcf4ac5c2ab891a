"""Looking for further basins, away from an optimum."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from pydantic import Field

from geoswarm.solver.errors import Issue
from geoswarm.solver.methods.base import OF_JOB, FollowUpMethod, Maker, PlainMaker, Task, in_order

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.search.base import Snapshot
    from geoswarm.solver.search.descent.exploring import ExploreSearch
    from geoswarm.solver.search.space import SearchSpace

__all__ = ["ExploreMethod"]


class ExploreMethod(FollowUpMethod):
    """Runs where a second basin would be most likely: given points at once, then descents from the best of them."""

    title: ClassVar[str] = "exploration for further basins"

    kind: Literal["explore"] = "explore"
    at: dict[str, float] = Field(min_length=1, description="the known optimum: values of all free parameters")
    points: dict[str, list[float]] = Field(
        min_length=1, description="points to run: the same number of values for each free parameter"
    )
    runs: int = Field(100, ge=1, le=100_000, description="maximum of evaluations; descents use what the points leave")
    objective: float | None = Field(
        None, ge=0, description="at the optimum: a descent that promises to stay above ends"
    )
    of: str | None = Field(None, min_length=1, max_length=64, description=OF_JOB)

    @property
    def learns(self) -> bool:
        """Always: descents follow the residuals."""
        return True

    def in_words(self) -> str:
        """Name it."""
        return f"follow-up: exploration for further basins, {self.runs} runs"

    def issues(self, problem: Problem) -> list[Issue]:
        """Compare optimum and points with the parameters."""
        issues = self.issues_at(self.at, problem)
        names = [p.name for p in problem.free]
        counts = {len(values) for values in self.points.values()}
        if set(self.points) != set(names):
            message = f"must name the free parameters {', '.join(names)}, got {', '.join(self.points)}"
            return [*issues, Issue("method.points", message)]
        if len(counts) != 1 or 0 in counts or max(counts) > self.runs:
            told = ", ".join(str(len(self.points[name])) for name in names)
            message = (
                f"must have the same number of values for each parameter, from 1 to runs ({self.runs}), got {told}"
            )
            return [*issues, Issue("method.points", message)]
        for parameter in problem.free:
            for value in self.points[parameter.name]:
                if not parameter.lower <= value <= parameter.upper:
                    bounds = f"between the bounds {parameter.lower:g} and {parameter.upper:g}"
                    issues.append(Issue(f"method.points.{parameter.name}", f"must be {bounds}, got {value:g}"))
                    break
        return issues

    def search(self, space: SearchSpace, snapshot: Snapshot | None = None) -> ExploreSearch:
        """Begin, or go on."""
        from geoswarm.solver.search.descent.exploring import ExploreSearch

        points = np.array([self.points[name] for name in space.names], dtype=np.float64).T
        return ExploreSearch(space, in_order(space, self.at), points, self.runs, self.objective, snapshot)

    def maker(self, task: Task) -> Maker:
        """Prepare to make it for a job."""
        return PlainMaker(partial(self.search, task.space))
