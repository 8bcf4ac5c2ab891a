"""Where runs are spent that look for a second basin: what the stored ones exclude the least."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.optimum.basins import exchangeable, heads_elsewhere
from geoswarm.solver.identifiability.optimum.hidden import Unseen, places
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.problem import Problem, parse_problem

__all__ = ["explore_problem"]

_CANDIDATES = 2000
_MOST_RUNS = 2000  # stored runs that are looked at: the best, and others spread evenly
_MOST_SWAPS, _MOST_HEADS = 10, 4
_LONGEST_NAME = 200


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
    found = [swapped for _, _, swapped in exchangeable(calibration, optimum)[:_MOST_SWAPS]]
    found = [place for place in found if calibration.space.feasible(place)]
    if linearisation is not None:
        lowest = float(samples.objectives[samples.best])
        unseen = Unseen.of(samples, linearisation, lowest)
        found += [place for place, _ in unseen.places_of(calibration.space, unseen.unfinished(0.0))][:_MOST_HEADS]
        heads = heads_elsewhere(samples, linearisation, float(samples.objectives.max()), lowest)
        found += list(samples.parameters[heads[:_MOST_HEADS]])
    found = list({tuple(place): place for place in found}.values())
    found = found[: max(first // 2, 1)]
    found += list(_least_excluded(calibration, samples, linearisation, first - len(found), seed))
    points = np.array(found).reshape(-1, samples.dimension)
    method = {
        "kind": "explore",
        "at": dict(zip(problem.free_names, optimum.tolist(), strict=True)),
        "points": {name: column.tolist() for name, column in zip(problem.free_names, points.T, strict=True)},
        "runs": runs,
    } | ({} if of is None else {"of": of})
    name = f"{problem.name}, explore"[:_LONGEST_NAME]
    document = problem.document() | {"name": name, "method": method, "stopping": {}, "seed": seed}
    return parse_problem(document, programs=problem.forward_model.runs_programs)


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
