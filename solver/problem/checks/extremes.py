"""Weights and errors of readings with which objectives and statistics can be calculated, judged before a job is stored.

Squares of numbers between 1e-150 and 1e150 are ordinary numbers in double precision; so are the squares of readings in
units of their error when their ratio is.
"""

from __future__ import annotations

import numpy as np

from geoswarm.solver.errors import Issue
from geoswarm.solver.problem.observations import Observation
from geoswarm.solver.problem.problem import Problem
from geoswarm.solver.words import number

__all__ = ["LARGEST", "SMALLEST", "extreme_issues"]

SMALLEST, LARGEST = 1e-150, 1e150
"""Numbers whose squares are ordinary numbers."""

_RANGE = f"{SMALLEST:g} to {LARGEST:g}"


def extreme_issues(problem: Problem) -> list[Issue]:
    """What is wrong with the weights and errors of a sound problem; stored problems are not asked again."""
    issues: list[Issue] = []
    for index, observation in enumerate(problem.observations):
        issues += _judged(f"observations[{index}]", observation)
    return issues


def _judged(path: str, observation: Observation) -> list[Issue]:
    issues = []
    weight = observation.given_weight
    if weight and not SMALLEST <= weight <= LARGEST:
        issues.append(Issue(f"{path}.weight", f"is {number(weight, plain=True)}; 0 and {_RANGE} are accepted"))
    graded = observation.point_weights[observation.point_weights > 0.0]
    wrong = graded[(graded < SMALLEST) | (graded > LARGEST)]
    if wrong.size:
        message = f"weights of points must be 0 or {_RANGE}, got {number(float(wrong[0]), plain=True)}"
        issues.append(Issue(path, message))
    if observation.error is None:
        return issues
    given = number(observation.given_error, plain=True)
    largest = float(np.abs(observation.y).max())
    if not SMALLEST <= observation.error <= LARGEST:
        issues.append(Issue(f"{path}.error", f"is {given}; {_RANGE} (in base units) are accepted"))
    elif largest / LARGEST > observation.error:
        message = f"is {given}; at least {SMALLEST:g} times the largest reading is accepted"
        issues.append(Issue(f"{path}.error", message))
    return issues
