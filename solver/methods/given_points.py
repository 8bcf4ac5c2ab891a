"""What follow-ups have in common whose points are all in their problem."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import Issue
from geoswarm.solver.methods.base import FollowUpMethod, Maker, PlainMaker, Task

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geoswarm.solver.problem import Problem
    from geoswarm.solver.search.base import Search, Snapshot

__all__ = ["BATCH", "GivenPointsMethod"]

BATCH = 200
"""Evaluations in a generation."""


class GivenPointsMethod(FollowUpMethod):
    """Runs given points, in one or several generations; declares ``points``."""

    compares: ClassVar[bool] = False

    if TYPE_CHECKING:  # each declares the field at its place in the section
        points: dict[str, list[float]]

    def planned(self, free: int) -> int | None:  # noqa: ARG002  (the form of all methods)
        """Return the number of points."""
        return max((len(values) for values in self.points.values()), default=0)

    def issues(self, problem: Problem) -> list[Issue]:
        """Compare the points with the parameters."""
        names = [p.name for p in problem.free]
        if set(self.points) != set(names):
            message = f"must name the free parameters {', '.join(names)}, got {', '.join(self.points)}"
            return [Issue("method.points", message)]
        counts = {len(values) for values in self.points.values()}
        if len(counts) != 1 or 0 in counts:
            told = ", ".join(str(len(self.points[name])) for name in names)
            return [
                Issue(
                    "method.points", f"must have the same number of values for each parameter, at least 1, got {told}"
                )
            ]
        issues = []
        for parameter in problem.free:
            values = self.points[parameter.name]
            wrong = next((v for v in values if not parameter.lower <= v <= parameter.upper), None)
            if wrong is not None:
                bounds = f"between the bounds {parameter.lower:g} and {parameter.upper:g}"
                issues.append(Issue(f"method.points.{parameter.name}", f"must be {bounds}, got {wrong:g}"))
        return issues

    def lengths(self, **lists: Sequence[object]) -> list[Issue]:
        """Issues of lists that need one entry a point."""
        count = self.planned(0)
        return [
            Issue(f"method.{name}", f"must have as many entries as there are points ({count}), got {len(values)}")
            for name, values in lists.items()
            if len(values) != count
        ]

    def positions(self, names: Sequence[str]) -> FloatArray:
        """Return the points, shape (n, d), natural values, in the order of ``names``."""
        return np.array([self.points[name] for name in names], dtype=np.float64).T

    def maker(self, task: Task) -> Maker:
        """Prepare to make it for a job."""

        def search(snapshot: Snapshot | None) -> Search:
            from geoswarm.solver.search.monte_carlo import GivenSearch

            return GivenSearch(self.positions(task.space.names), BATCH, snapshot)

        return PlainMaker(search)
