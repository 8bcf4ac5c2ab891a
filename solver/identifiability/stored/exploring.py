"""Where runs are spent that look for a second basin: what the stored ones exclude the least."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.noise import problem_noise
from geoswarm.solver.identifiability.optimum.basins import equivalent_objective, exchangeable, heads_elsewhere
from geoswarm.solver.identifiability.optimum.hidden import Unseen, places
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.follow_ups import follow_up
from geoswarm.solver.methods.base import by_name
from geoswarm.solver.problem import Problem

__all__ = ["explore_problem", "other_starts"]

_CANDIDATES = 2000
_MOST_RUNS = 2000  # stored runs that are looked at: the best, and others spread evenly
_MOST_SWAPS, _MOST_HEADS = 10, 12
_HEIGHT = 2.0  # times as high as a basin reaches: descents cost little
_SAME = 1e-9  # relative difference of parameters


def explore_problem(
    problem: Problem,
    samples: Samples,
    linearisation: Linearisation | None,
    *,
    seed: int,
    runs: int = 100,
    of: str | None = None,
) -> Problem:
    """The problem that spends runs where a second basin would be most likely.

    Half of them, at once: the optimum with the values of exchangeable parameters swapped, the best stored runs of other
    basins, and places where the stored runs exclude a basin like this one the least. The other half goes down from the
    best of these.

    Parameters
    ----------
    samples
        Stored runs.
    linearisation
        At the optimum, from which the width of a basin follows; a tenth of the ranges without.
    seed
        Of the job, and of the places tried.
    runs
        Evaluations at most.
    of
        Id of the job.

    Raises
    ------
    StatisticsError
        When there is no successful evaluation.
    ProblemError
        When ``runs`` is wrong, or there are fewer measured points than free parameters.
    """
    if not samples.size:
        raise StatisticsError("no evaluation has succeeded yet, so there is nothing to explore around")
    calibration = Calibration(problem, seed)
    optimum = samples.parameters[samples.best]
    first = max((runs + 1) // 2, 1)
    if linearisation is None:
        found = [swapped for _, _, swapped in exchangeable(calibration, optimum)[:_MOST_SWAPS]]
    else:
        found = other_starts(calibration, samples, linearisation, float(samples.objectives[samples.best]))
    found = [place for place in found if calibration.space.feasible(place)]
    found = found[: max(first // 2, 1)]
    found += list(_least_excluded(calibration, samples, linearisation, first - len(found), seed))
    points = np.array(found).reshape(-1, samples.dimension)
    method = {
        "kind": "explore",
        "at": by_name(calibration.space, optimum),
        "points": {name: column.tolist() for name, column in zip(problem.free_names, points.T, strict=True)},
        "runs": runs,
        "of": of,
    }
    return follow_up(problem, method, seed)


def other_starts(
    calibration: Calibration,
    samples: Samples,
    linearisation: Linearisation,
    best: float,
    explored: Sequence[tuple[FloatArray, float]] = (),
    looked: Sequence[FloatArray] = (),
) -> list[FloatArray]:
    """Where descents to other basins may begin, natural values, each of shape (d,).

    The optimum with the values of exchangeable parameters swapped, and the best runs that point to other basins.

    Parameters
    ----------
    samples
        Runs of the search.
    linearisation, best
        At the optimum, and the objective there.
    explored
        Parameters and objectives of further runs.
    looked
        Where descents have begun already: not again.
    """
    limit = equivalent_objective(calibration, best, problem_noise(calibration.problem), linearisation)
    unseen = Unseen.of(samples, linearisation, best, explored)
    left = unseen.unfinished(0.0, [samples.to_unit(place) for place in looked], height=_HEIGHT, made=True)
    heads = heads_elsewhere(samples, linearisation, limit, best)
    places = [place for _, _, place in exchangeable(calibration, linearisation.optimum)[:_MOST_SWAPS]]
    places += [place for place, _ in unseen.places_of(calibration.space, left)][:_MOST_HEADS]
    places += list(samples.parameters[heads[:_MOST_HEADS]])
    kept: list[FloatArray] = []
    for place in places:
        known = np.array([linearisation.optimum, *looked, *kept])
        if not np.isclose(known, place, rtol=_SAME, atol=0.0).all(axis=1).any():
            kept.append(place)
    return kept


def _least_excluded(
    calibration: Calibration, samples: Samples, linearisation: Linearisation | None, count: int, seed: int
) -> FloatArray:
    """Places whose lowest possible objective is least, shape (at most count, d), natural values.

    A basin of the curvature of the optimum with its bottom at p has at most f_best + |F'(p - r)|^2 at a run r. So the
    bottom is at least max_r (f_r - |F'(p - r)|^2), as in Piyavskii's method; f_r counts up to the reach of a basin, as
    it does not rise like this for ever. A chosen place counts as a run that found nothing.
    """
    best = float(samples.objectives[samples.best])
    if linearisation is None:
        reach = max(float(np.median(samples.objectives)) - best, np.finfo(float).tiny)
        factor = np.eye(samples.dimension) * np.sqrt(reach) / 0.1
    else:
        unseen = Unseen.of(samples, linearisation, best)
        reach, factor = max(unseen.reach, np.finfo(float).tiny), unseen.factor
    order = np.argsort(samples.objectives, kind="stable")
    rows = order[:: max(1, -(-len(order) // _MOST_RUNS))]
    candidates = places(calibration.space, _CANDIDATES, seed % 2**32)
    if count < 1 or not len(candidates):
        return np.empty((0, samples.dimension))
    moved, runs = candidates @ factor, samples.unit[rows] @ factor
    heights = np.minimum(samples.objectives[rows] - best, reach)
    lowest = np.full(len(moved), -np.inf)
    for run, height in zip(runs, heights, strict=True):
        np.maximum(lowest, height - ((moved - run) ** 2).sum(axis=1), out=lowest)
    chosen = []
    for _ in range(min(count, len(moved))):
        place = int(np.argmin(lowest))
        chosen.append(place)
        np.maximum(lowest, reach - ((moved - moved[place]) ** 2).sum(axis=1), out=lowest)
    return calibration.space.from_unit(candidates[chosen])
