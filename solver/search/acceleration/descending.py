"""How a descent goes on: its first simplex, steps of the trust region, runs that span a direction, and its end.

A descent is over when its trust region has become small, or promises hardly anything though the runs around its best
span all directions, or leads to the same point as an earlier one. Then d + 1 runs are made, far from all others or with
some parameters of the best of all, and the best of these is where the next descent begins.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.acceleration.candidates import Strategies
from geoswarm.solver.search.acceleration.strategies import BEGIN_PATTERN, DESCENT_PATTERN, POISE, Pattern
from geoswarm.solver.search.acceleration.trust_region import BEGUN, SETTLED, TrustRegion

__all__ = ["Descent", "base_of_simplex", "next_of_descent", "simplex"]

_EDGE, _DRAWS = 0.3, 40  # of the unit box that the first run stays away from; tries
_STEPS = (1.0, -1.0, 0.5, -0.5, 0.25, -0.25)  # along an axis, in lengths of the simplex
_LEAST_GAIN, _SMALL = 1e-2, 0.02  # a promise that counts, in a box of at most that half width
_LEAST_GAIN_OF_BEST = 1e-3  # the same around the best of all: a surface with few runs nearby promises too little
_LEAST_GAIN_ABOVE, _SMALL_ABOVE = 0.1, 0.15  # the same where even the promise is above the best of all
_SHORT, _SHORTENED = 0.05, 0.3  # a step of so few half widths narrows the box before it is made


@dataclass(frozen=True, slots=True)
class Descent:
    """The trust region of the next generation, the strategies that alternate in it, and the minimum left, if any."""

    region: TrustRegion
    pattern: Pattern
    left: FloatArray | None = None


def next_of_descent(strategies: Strategies, count: int) -> Descent:
    """Return the next part of the descent after ``count`` runs; this narrows the trust region of the strategies."""
    known = strategies.knowledge
    lacking = known.points.shape[1] + 1 - int((known.numbers >= strategies.region.since).sum())
    if lacking > 0:
        if strategies.region.since:
            return Descent(strategies.region, BEGIN_PATTERN)
        return Descent(strategies.region, (POISE,) * max(lacking - strategies.out, 0) + DESCENT_PATTERN)
    while strategies.region.radius >= SETTLED:
        if strategies.centre is None or not known.open[strategies.first]:  # come down into a finished basin
            return Descent(TrustRegion(since=count), BEGIN_PATTERN)
        if strategies.region.missed:
            if strategies.missing() is not None:
                return Descent(strategies.region, (POISE, *DESCENT_PATTERN))
            strategies.region = strategies.region.narrower()
            continue
        gain, length = strategies.promise()
        radius = strategies.region.radius
        above = known.objectives[strategies.centre] * (1.0 - gain) > known.objectives[0]
        if above and gain < _LEAST_GAIN_ABOVE and radius < _SMALL_ABOVE:
            break
        if gain < (_LEAST_GAIN_OF_BEST if strategies.first == 0 else _LEAST_GAIN):
            if radius < _SMALL and strategies.missing() is None:
                break
            strategies.region = replace(strategies.region, missed=True)
            continue
        if length < _SHORT * radius:
            strategies.region = replace(strategies.region, radius=max(_SHORTENED * radius, 2.0 * length))
        if not known.open.all() and strategies.step(None, 1.0) is None:  # all of it leads into a finished basin
            strategies.region = strategies.region.narrower()
            continue
        return Descent(strategies.region, DESCENT_PATTERN)
    return Descent(TrustRegion(since=count), BEGIN_PATTERN, known.points[strategies.first])


def base_of_simplex(
    random: np.random.Generator,
    fallback: FloatArray,
    snapped: Callable[[FloatArray], FloatArray],
    feasible: Callable[[FloatArray], bool],
) -> FloatArray:
    """Return where the first simplex stands, shape (d,): a feasible point well inside the unit box.

    The middle is closer to wherever the minimum is than a point near the bounds, and steps to both sides are possible.
    """
    drawn = _EDGE + (1.0 - 2.0 * _EDGE) * random.random((_DRAWS, fallback.size))
    return next((point for u in drawn if feasible(point := snapped(u))), fallback)


def simplex(
    random: np.random.Generator,
    base: FloatArray,
    snapped: Callable[[FloatArray], FloatArray],
    feasible: Callable[[FloatArray], bool],
) -> list[FloatArray]:
    """Return the other vertices of a simplex at ``base``: one step along each parameter where one is feasible."""
    signs = np.where(random.random(base.size) < 0.5, -1.0, 1.0)
    vertices = []
    for i in random.permutation(base.size).tolist():
        for step in _STEPS:
            point = base.copy()
            point[i] += signs[i] * step * BEGUN
            point = snapped(point)
            if 0.0 <= point[i] <= 1.0 and point[i] != base[i] and feasible(point):
                vertices.append(point)
                break
    return vertices
