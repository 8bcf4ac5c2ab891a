"""A bounded search for one admissible point, so that a problem without any is refused before it runs."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import Issue
from geoswarm.solver.problem.parameters import FreeParameter, limit_mistake
from geoswarm.solver.problem.problem import Problem

__all__ = ["TRIED_POINTS", "estimates_in_conflict", "infeasibility"]

TRIED_POINTS = 10_000
"""Random points that are tried, beside the initial estimate, the centre and the corners of the bounds."""

_MOST_CORNERS = 1024


def infeasibility(problem: Problem) -> list[Issue]:
    """Why no admissible point was found between the bounds; empty when one was.

    The search is deterministic: the initial estimate, the centre, the corners (for up to ten free parameters) and
    10 000 random points, uniform in search coordinates.
    """
    tried = 0
    fulfilled = [0] * len(problem.constraints)
    refusals: dict[str, int] = {}
    for point in _points(problem.free):
        values = problem.values(point.tolist())
        if problem.satisfies(values):
            return []
        tried += 1
        holds = [bool(constraint.value(values)) for constraint in problem.constraints]
        fulfilled = [count + hold for count, hold in zip(fulfilled, holds, strict=True)]
        if all(holds):
            reason = _refusal(problem, values)
            refusals[reason] = refusals.get(reason, 0) + 1
    return _explained(problem, tried, fulfilled, refusals)


def estimates_in_conflict(problem: Problem) -> list[Issue]:
    """Why no admissible point has the initial values of the problem; empty when one was found, or none is given."""
    initial = np.array([np.nan if p.initial is None else p.initial for p in problem.free])
    given = [p for p in problem.free if p.initial is not None]
    if not given:
        return []
    for point in _points(problem.free):
        if problem.satisfies(problem.values(np.where(np.isnan(initial), point, initial).tolist())):
            return []
        if len(given) == len(problem.free):
            break
    estimates = " and ".join(f"{p.name} = {p.initial:g}" for p in given)
    message = f"no admissible point has {estimates}; change the initial values, or leave some out"
    return [Issue(f"parameters.{given[0].name}.initial", message)]


def _points(free: tuple[FreeParameter, ...]) -> Iterator[FloatArray]:
    log = np.array([p.scale == "log" for p in free])
    integer = np.array([p.integer for p in free])
    lower = np.array([p.lower for p in free])
    upper = np.array([p.upper for p in free])
    low = np.where(log, np.log(np.where(log, lower, 1.0)), lower)
    high = np.where(log, np.log(np.where(log, upper, 1.0)), upper)

    def natural(fraction: FloatArray) -> FloatArray:
        inner = low + fraction * (high - low)
        point = np.where(log, np.exp(np.where(log, inner, 0.0)), inner)
        return np.clip(np.where(integer, np.rint(point), point), lower, upper)

    centre = natural(np.full(len(free), 0.5))
    initial = np.array([np.nan if p.initial is None else p.initial for p in free])
    yield np.where(np.isnan(initial), centre, initial)
    yield centre
    random = np.random.default_rng(0)
    for fraction in random.random((100, len(free))):
        yield natural(fraction)
    if 2 ** len(free) <= _MOST_CORNERS:
        for corner in product((0.0, 1.0), repeat=len(free)):
            yield natural(np.array(corner))
    for fraction in random.random((TRIED_POINTS - 100, len(free))):
        yield natural(fraction)


def _refusal(problem: Problem, values: dict[str, float]) -> str:
    undefined = [name for name, value in values.items() if not np.isfinite(value)]
    if undefined:
        return f"{undefined[0]} is not a finite number"
    infos = {info.name: info for info in problem.model.parameters}
    for name in values.keys() & infos.keys():
        message = limit_mistake(values[name], infos[name])
        if message is not None:
            return f"{name} {message}"
    return problem.model.check(values) or "refused by the forward model"


def _explained(problem: Problem, tried: int, fulfilled: list[int], refusals: dict[str, int]) -> list[Issue]:
    never = [i for i, count in enumerate(fulfilled) if count == 0]
    where = f"at none of {tried} points tried between the bounds"
    if never:
        return [Issue(f"constraints[{i}]", f"'{problem.constraints[i].text}' holds {where}") for i in never]
    if refusals:
        reason = max(refusals, key=lambda text: refusals[text])
        return [Issue("parameters", f"admissible {where}; for example {reason}")]
    counts = ", ".join(
        f"'{constraint.text}' at {count}" for constraint, count in zip(problem.constraints, fulfilled, strict=True)
    )
    return [Issue("constraints", f"hold together {where}; one by one: {counts}")]
