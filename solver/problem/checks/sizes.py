"""How large a problem may be, counted before anything of that size is made."""

from __future__ import annotations

from collections.abc import Iterable

from geoswarm.solver.errors import Issue
from geoswarm.solver.problem.problem import Problem
from geoswarm.solver.sentences import Key

__all__ = ["MAX_DESIGN_VALUES", "MAX_POINTS", "MAX_VALUES", "point_issues", "size_issues"]

MAX_POINTS = 200_000
"""Measured points of all observations of a problem."""

MAX_DESIGN_VALUES = 20_000_000
"""Samples times free parameters of a design that is drawn as a whole."""

MAX_VALUES = 1_000_000_000
"""Planned evaluations times measured points: the number of calculated values that are stored."""


def point_issues(counts: Iterable[int]) -> list[Issue]:
    """What is wrong with the numbers of points of all observations."""
    total = sum(counts)
    if total <= MAX_POINTS:
        return []
    resample = Key("observations[0].resample.per_decade", "resample: {per_decade: 20}", "20")
    found = f"have {total} points; at most {MAX_POINTS} are accepted; "
    return [Issue.about("observations", (found, resample, " takes means of neighbouring readings"))]


def size_issues(problem: Problem) -> list[Issue]:
    """What is wrong with the size of a sound problem."""
    method, free = problem.method, len(problem.free)
    values = method.drawn_at_once * free
    if values > MAX_DESIGN_VALUES:
        message = (
            f"{method.drawn_at_once} samples of {free} free parameters are {values} values, which {method.in_words()} "
            f"draws as a whole; at most {MAX_DESIGN_VALUES} are accepted; sampling: random has no such limit"
        )
        return [Issue("method.samples", message)]
    planned = problem.planned_evaluations
    points = sum(observation.x.size for observation in problem.observations)
    if planned is not None and planned * points > MAX_VALUES:
        path = "method" if problem.stopping.max_evaluations != planned else "stopping.max_evaluations"
        message = (
            f"{planned} evaluations of {points} points are {planned * points} values to be stored; "
            f"at most {MAX_VALUES} are accepted"
        )
        return [Issue(path, message)]
    return []
