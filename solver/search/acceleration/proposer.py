"""Where to aim particles next, learned from all runs so far.

Four kinds of proposals, in this order, until enough are found; each is kept only when it is feasible and new:

1. minima of the response surface of the residual vector over the whole space, the lowest first;
2. Gauss-Newton points: residuals linear in the parameters, fitted to the runs next to the best one, in their reach;
3. the minimum of a surface of those near runs alone;
4. points that promise little misfit where nothing was calculated yet (after Regis & Shoemaker 2007).

All in unit coordinates: 0 at the lower, 1 at the upper bound of a parameter in search coordinates. The cost is bounded:
a surface is built from the best runs, at most :data:`LARGEST_MODEL` of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from threadpoolctl import threadpool_limits

from solver.arrays import FloatArray, IntArray
from solver.search.acceleration.levenberg_marquardt import Linearised, minimise
from solver.search.acceleration.residual_surface import ResidualSurface
from solver.search.acceleration.runs import Runs
from solver.search.randomness import particle_generator
from solver.search.space import SearchSpace

__all__ = ["LARGEST_MODEL", "propose"]

LARGEST_MODEL: Final = 150
"""Runs that a surface is built from at most."""

_PROPOSER: Final = 2**31  # a particle number that no swarm reaches: the random stream of a generation's proposals
_CLOUD: Final = 1000  # points at which the surface is looked at over the whole space
_NEAR_ELITE: Final = 60  # further ones around each of the best runs
_ELITE: Final = 10
_STARTS: Final = 12  # descents on the surface
_START_DISTANCE: Final = 0.08
_SURFACE_SHARE: Final = 0.4  # of the proposals; the others keep the surface honest
_REACH: Final = 0.02  # minima closer than this are one
_CLOSEST: Final = 1.0e-4  # to a point that was calculated before
_EXPLORATION: Final = (0.4, 0.7)  # weight of a low objective against a large distance, in turn


@dataclass(frozen=True, slots=True)
class _Known:
    """Successful runs in unit coordinates: points (n, d), residuals (n, m), order from best to worst."""

    points: FloatArray
    residuals: FloatArray
    order: IntArray

    @property
    def best(self) -> int:
        return int(self.order[0])


def propose(space: SearchSpace, runs: Runs, seed: int, generation: int, count: int) -> FloatArray:
    """Return up to ``count`` points worth calculating, search coordinates, shape (k, d), the most promising first.

    Deterministic: the same runs give the same bits, whatever the number of threads of the linear algebra library.
    """
    lower, width = space.search_lower, space.search_upper - space.search_lower
    everywhere = (space.to_search(runs.positions) - lower) / width
    succeeded = runs.succeeded
    points, residuals = everywhere[succeeded], runs.residuals[succeeded]
    if len(points) < space.dimension + 2:
        return np.empty((0, space.dimension))
    order = np.argsort(runs.objectives[succeeded], kind="stable").astype(np.int64)
    known = _Known(points, residuals, order)
    random = particle_generator(seed, generation, _PROPOSER)
    chosen: list[FloatArray] = []
    with threadpool_limits(limits=1):
        for point, apart in _candidates(known, random, count, everywhere, chosen):
            if len(chosen) == count:
                break
            distance = np.sqrt(np.sum((everywhere - point) ** 2, axis=1)).min()
            others = min((float(np.linalg.norm(point - other)) for other in chosen), default=np.inf)
            if distance > _CLOSEST and others > apart and space.is_feasible(lower + point * width):
                chosen.append(point)
    return lower + np.array(chosen).reshape(-1, space.dimension) * width


def _candidates(
    known: _Known, random: np.random.Generator, count: int, everywhere: FloatArray, chosen: list[FloatArray]
) -> Iterator[tuple[FloatArray, float]]:
    """Candidates with the distance that they must keep from those chosen before."""
    used = np.sort(known.order[:LARGEST_MODEL])
    surface = ResidualSurface(known.points[used], known.residuals[used])
    cloud = _cloud(known, random)
    modelled = surface.objective(cloud)
    share = max(1, round(_SURFACE_SHARE * count))
    for point in _minima(surface, known, cloud, modelled):
        if len(chosen) >= share:
            break
        yield point, _REACH
    yield from _local_points(known)
    for weight in _EXPLORATION:
        for point in _unexplored(cloud, modelled, everywhere, chosen, weight):
            before = len(chosen)
            yield point, _REACH
            if len(chosen) > before:
                break


def _cloud(known: _Known, random: np.random.Generator) -> FloatArray:
    d = known.points.shape[1]
    elite = np.repeat(known.points[known.order[:_ELITE]], _NEAR_ELITE, axis=0)
    near = elite + 0.1 * random.standard_normal(elite.shape)
    return np.vstack([random.random((_CLOUD, d)), np.clip(near, 0.0, 1.0)])


def _minima(surface: ResidualSurface, known: _Known, cloud: FloatArray, modelled: FloatArray) -> list[FloatArray]:
    """Local minima of the surface, the lowest first, from starts that are apart."""
    starts = [known.points[known.best]]
    for i in np.argsort(modelled, kind="stable"):
        if len(starts) == _STARTS:
            break
        if min(float(np.linalg.norm(cloud[i] - start)) for start in starts) > _START_DISTANCE:
            starts.append(cloud[i])
    lower, upper = np.zeros(cloud.shape[1]), np.ones(cloud.shape[1])
    found = [minimise(surface.linearised, start, lower, upper) for start in starts]
    return [point for point, _ in sorted(found, key=lambda pair: pair[1])]


def _local_points(known: _Known) -> Iterator[tuple[FloatArray, float]]:
    """Gauss-Newton points, and the minimum of a local surface, around the best run."""
    n, d = known.points.shape
    centre, residual = known.points[known.best], known.residuals[known.best]
    distance = np.sqrt(np.sum((known.points - centre) ** 2, axis=1))
    nearest = np.argsort(distance, kind="stable")
    apart = 0.05 * _REACH
    for wanted in (2 * d + 2, 4 * d + 2):
        near = nearest[: min(wanted, n)]
        weight = 1.0 / (distance[near] + 1.0e-3 + distance[near[1:]].min())
        design = np.hstack([np.ones((len(near), 1)), known.points[near] - centre]) * weight[:, None]
        jacobian = np.linalg.lstsq(design, known.residuals[near] * weight[:, None], rcond=1.0e-10)[0][1:].T

        def linear(x: FloatArray, jacobian: FloatArray = jacobian) -> tuple[FloatArray, FloatArray]:
            return residual + jacobian @ (x - centre), jacobian

        yield _within(linear, centre, distance[near].max()), apart
    if n > 2 * (d + 2):
        near = np.sort(nearest[: min(4 * (d + 1), n)])
        local = ResidualSurface(known.points[near], known.residuals[near])
        yield _within(local.linearised, centre, distance[nearest[min(2 * d + 1, n - 1)]]), apart


def _within(model: Linearised, centre: FloatArray, reach: float) -> FloatArray:
    return minimise(model, centre, np.maximum(0.0, centre - reach), np.minimum(1.0, centre + reach))[0]


def _unexplored(
    cloud: FloatArray, modelled: FloatArray, everywhere: FloatArray, chosen: list[FloatArray], weight: float
) -> list[FloatArray]:
    """Points of the cloud by the weighted sum of their modelled objective (logarithm) and closeness to known points."""
    known = np.vstack([everywhere, *chosen])
    distance = np.full(len(cloud), np.inf)
    for point in known:
        distance = np.minimum(distance, np.sum((cloud - point) ** 2, axis=1))
    distance = np.sqrt(distance)
    low = np.log(modelled + 1.0e-300)
    low = (low - low.min()) / (np.ptp(low) + 1.0e-12)
    close = 1.0 - distance / (distance.max() + 1.0e-12)
    return [cloud[i] for i in np.argsort(weight * low + (1.0 - weight) * close, kind="stable")[:200]]
