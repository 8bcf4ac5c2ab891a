"""Other sets of parameters that fit as well as the optimum: what an interval around one optimum cannot show.

An interval at the optimum follows from the curvature there. Stored runs that fit as well but lie outside the region
that this curvature allows contradict it: the objective has a second basin, or a curved valley.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist
from scipy.special import chdtri, fdtri

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.noise import Noise, noise_objective
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.samples import Samples

__all__ = [
    "OtherFit",
    "equivalent_objective",
    "exchangeable",
    "exchanges",
    "fits_at",
    "heads_elsewhere",
    "other_fits",
    "untried_exchanges",
]

_LEVEL = 0.95
_REPRODUCED = 1e-10  # of the mean square of the measured values: no measurement distinguishes fits below it
_OUTSIDE = 1.5  # times as far from the optimum as the curvature there allows
_LEAST_APART = 1e-3  # parts of the range
_UNFINISHED = 10.0  # times the limit: a basin left there may hold as good a fit
_HEAD_APART = 0.1  # parts of the range to the nearest better run
_MOST_NAMED = 4  # further basins
_MOST_COMPARED = 500  # best runs, of which heads are looked for
_MOST_SWAPPED = 20  # best runs whose swapped values are looked for
_COMMON = 0.5  # of the wider of two ranges
_NEAR = 0.1  # parts of the range, in one dimension
_FEWEST_COMPARED = 10  # runs near a swapped place
_DIFFERENT = 1.35  # times the difference of neighbours
_UNRELATED = 0.3  # difference of ranks
_SAME = 1e-6  # relative difference of the objectives of an exchange


@dataclass(frozen=True, slots=True)
class OtherFit:
    """A set of parameters, shape (d,), natural values, that fits as well; ``differs``: those outside their region."""

    parameters: FloatArray
    objective: float
    differs: tuple[str, ...]

    def to_json(self, names: Sequence[str]) -> dict[str, Any]:
        """Plain JSON values; ``names`` are those of the parameters."""
        parameters = dict(zip(names, self.parameters.tolist(), strict=True))
        return {"parameters": parameters, "objective": self.objective, "differs": list(self.differs)}


def equivalent_objective(
    calibration: Calibration, best: float, noise: Noise | None, linearisation: Linearisation | None = None
) -> float:
    """Objective up to which a fit cannot be distinguished from the best one at 95 % (Seber and Wild 2003, eq. 5.22).

    Without a known noise as for the filter; with one of variance s^2 by what f rises for chi^2_0.95(d), f being the
    sum of squares over n: best + w s^2 chi^2 / n, where the residuals are no larger than this noise has them. With a
    robust loss, outliers are a part of f that says nothing of the noise: best + w s^2 d F / n, s of pseudo residuals.

    Parameters
    ----------
    best
        The lowest objective known.
    noise
        When it is known.
    linearisation
        At the optimum, for losses.
    """
    observed = calibration.objective.observed
    dimension = calibration.space.dimension
    free = calibration.problem.counted_points - dimension
    relative = dimension * float(fdtri(dimension, free, _LEVEL)) if free > 0 else np.nan
    factor = 1.0 + relative / free if free > 0 else 2.0
    if calibration.objective.robust and linearisation is not None and free > 0 and linearisation.noise is not None:
        variances = linearisation.model.variances
        return best + relative * float(variances.sum()) / max(int((variances > 0.0).sum()), 1)
    floor = _REPRODUCED * sum(o.weight * float((o.point_weights * o.y**2).mean()) for o in observed)
    base = max(best, floor)
    if noise is None:
        return base * factor
    known = noise_objective(calibration.problem, noise)
    rise = known * float(chdtri(dimension, 1.0 - _LEVEL)) / calibration.problem.counted_points
    return max(base + rise, base * factor if base > known else 0.0)


def _extent(linearisation: Linearisation, limit: float, best: float) -> FloatArray:
    """How far from the optimum the linearised objective reaches the limit, parts of the range, shape (d,)."""
    half = linearisation.linear_half_widths
    with np.errstate(invalid="ignore", divide="ignore"):
        extent = half * np.sqrt(max(limit - best, 0.0) / linearisation.profile_increase)
    return np.where(half == 0.0, 0.0, extent)


def _outside(samples: Samples, unit: FloatArray, linearisation: Linearisation, limit: float, best: float) -> FloatArray:
    """Whether each parameter of points (k, d), parts of the range, lies outside its region, shape (k, d)."""
    extent = _extent(linearisation, limit, best)
    allowed = np.where(np.isnan(extent), np.inf, np.maximum(_OUTSIDE * extent, _LEAST_APART))
    return np.asarray(np.abs(unit - samples.to_unit(linearisation.optimum)) > allowed)


def other_fits(
    samples: Samples,
    linearisation: Linearisation,
    limit: float,
    best: float,
    further: Sequence[tuple[FloatArray, float]] = (),
) -> tuple[OtherFit, ...]:
    """Fits as good as the optimum that its curvature does not allow: the best for each parameter, and of each basin.

    A run without a better one nearby is the head of a basin (nearest-better clustering, Preuss 2010).

    Parameters
    ----------
    samples, linearisation
        All stored runs, and the region around the optimum.
    limit, best
        Of :func:`equivalent_objective`, and the objective at the optimum.
    further
        Parameters, natural values, and objectives that are not among the samples.
    """
    parameters = np.concatenate([samples.parameters, *(p[None] for p, _ in further)])
    objectives = np.concatenate([samples.objectives, [f for _, f in further]])
    good = np.flatnonzero(objectives <= limit)
    good = good[np.argsort(objectives[good], kind="stable")]
    outside = _outside(samples, samples.to_unit(parameters[good]), linearisation, limit, best)
    unit = samples.to_unit(parameters[good])
    heads = [row for row in _heads(unit) if outside[row].any()][:_MOST_NAMED]
    first = [int(rows[0]) for column in outside.T if (rows := np.flatnonzero(column)).size]
    return tuple(
        OtherFit(
            parameters[good[row]],
            float(objectives[good[row]]),
            tuple(name for name, out in zip(samples.names, outside[row], strict=True) if out),
        )
        for row in sorted({*heads, *first})
    )


def fits_at(
    samples: Samples,
    linearisation: Linearisation,
    limit: float,
    best: float,
    places: Sequence[tuple[FloatArray, float]],
) -> tuple[OtherFit, ...]:
    """Of places (natural values, objectives) those outside the region of the optimum, with what differs; four at most.

    Arguments as of :func:`other_fits`.
    """
    found = []
    for parameters, objective in places:
        outside = _outside(samples, samples.to_unit(parameters)[None], linearisation, limit, best)[0]
        differs = tuple(name for name, out in zip(samples.names, outside, strict=True) if out)
        found += [OtherFit(parameters, objective, differs)] if differs else []
    return tuple(found[:_MOST_NAMED])


def _heads(unit: FloatArray) -> list[int]:
    """Rows without a better one nearby, of points (k, d), the best first; of the first 500."""
    unit = unit[:_MOST_COMPARED]
    return [i for i in range(1, len(unit)) if float(np.abs(unit[:i] - unit[i]).max(axis=1).min()) > _HEAD_APART]


def exchangeable(calibration: Calibration, optimum: FloatArray) -> tuple[tuple[str, str, FloatArray], ...]:
    """Pairs of free parameters that may stand for each other, and the optimum with their values swapped, shape (d,).

    Their scales agree, both or neither take whole numbers, their ranges have half of the wider one in common, and the
    swapped values lie in both and satisfy the constraints; those with the same bounds come first. Whether they can be
    exchanged, only a run with the swapped values shows.
    """
    free, names = calibration.problem.free, calibration.free_names
    low, high = calibration.space.search_lower, calibration.space.search_upper
    found = []
    for i, one in enumerate(free):
        for j in range(i + 1, len(free)):
            common = min(high[i], high[j]) - max(low[i], low[j])
            alike = one.scale == free[j].scale and one.integer == free[j].integer
            alike = alike and common >= _COMMON * max(high[i] - low[i], high[j] - low[j])
            swapped = optimum.copy()
            swapped[[i, j]] = optimum[[j, i]]
            inside = all(free[k].lower <= swapped[k] <= free[k].upper for k in (i, j))
            inside = inside and calibration.space.feasible(swapped)
            if alike and inside and optimum[i] != optimum[j]:
                same = low[i] == low[j] and high[i] == high[j]
                found.append((not same, names[i], names[j], swapped))
    return tuple((one, other, place) for _, one, other, place in sorted(found, key=lambda pair: pair[0]))


def exchanges(
    calibration: Calibration,
    samples: Samples,
    linearisation: Linearisation,
    best: float,
    further: Sequence[tuple[FloatArray, float]],
) -> tuple[tuple[str, str], ...]:
    """Pairs of parameters whose swapped values gave the same objective: other runs, against the optimum and the best.

    Not those that act only in combination, or not at all: swapping shows nothing more of them.
    """
    places, objectives = _best_places(samples, linearisation, best)
    found = []
    for first, second, i, j in _separate_pairs(calibration, linearisation):
        swapped = _swapped(places, i, j)
        apart = np.abs(places[:, i] - places[:, j]) > _LEAST_APART * np.abs(places[:, i])
        for parameters, objective in further:
            same = np.isclose(swapped, parameters, rtol=_SAME, atol=0.0).all(axis=1) & apart
            if (same & (np.abs(objectives - objective) <= _SAME * np.maximum(objectives, np.finfo(float).tiny))).any():
                found.append((first, second))
                break
    return tuple(found)


def _separate_pairs(calibration: Calibration, linearisation: Linearisation) -> list[tuple[str, str, int, int]]:
    """Exchangeable pairs of parameters that the data tell from each other at the optimum, with their indices."""
    names, without = calibration.free_names, linearisation.without_influence
    return [
        (first, second, names.index(first), names.index(second))
        for first, second, _ in exchangeable(calibration, linearisation.optimum)
        if first not in without and second not in without and second not in linearisation.tied_to(first)
    ]


def _best_places(samples: Samples, linearisation: Linearisation, best: float) -> tuple[FloatArray, FloatArray]:
    """The optimum, whose objective is ``best``, and the best runs: natural values, shape (k, d), and objectives."""
    order = np.argsort(samples.objectives, kind="stable")[:_MOST_SWAPPED]
    places = np.concatenate([linearisation.optimum[None], samples.parameters[order]])
    return places, np.concatenate([[best], samples.objectives[order]])


def _swapped(places: FloatArray, i: int, j: int) -> FloatArray:
    swapped = places.copy()
    swapped[:, [i, j]] = places[:, [j, i]]
    return swapped


def untried_exchanges(
    calibration: Calibration,
    samples: Samples,
    linearisation: Linearisation,
    further: Sequence[tuple[FloatArray, float]],
) -> tuple[tuple[str, str], ...]:
    """Pairs of parameters that may be exchangeable as far as stored runs show: swapped values were not run.

    Where they can, a run and one near its swapped place differ no more than neighbours do.
    """
    places, _ = _best_places(samples, linearisation, np.nan)
    found = []
    for first, second, i, j in _separate_pairs(calibration, linearisation):
        swapped = _swapped(places, i, j)
        tried = any(np.isclose(swapped, place, rtol=_SAME, atol=0.0).all(axis=1).any() for place, _ in further)
        if not tried and not _differ_when_swapped(samples, i, j):
            found.append((first, second))
    return tuple(found)


def _differ_when_swapped(samples: Samples, i: int, j: int) -> bool:
    """Whether objectives at swapped places differ by more than those of neighbours: medians of ranks, 0 to 1.

    Where hardly any run lies near a swapped place, other bounds speak for a difference, the same for none.
    """
    rows = np.argsort(samples.generations, kind="stable")[:_MOST_COMPARED]  # spread widely: a search begins so
    unit = samples.unit[rows]
    rank = np.argsort(np.argsort(samples.objectives[rows], kind="stable"), kind="stable") / len(rows)
    mirror = samples.to_unit(_swapped(samples.parameters[rows], i, j))
    away, there = cKDTree(unit).query(mirror)
    far_apart = np.abs(mirror - unit).max(axis=1) > 2.0 * _NEAR
    near = np.flatnonzero((away <= _NEAR * np.sqrt(samples.dimension)) & far_apart)
    if near.size < _FEWEST_COMPARED:
        return bool(samples.lower[i] != samples.lower[j] or samples.upper[i] != samples.upper[j])
    apart = np.abs(cdist(unit[near], unit) - away[near, None])  # neighbours as far away as the run at the swapped place
    apart[np.arange(near.size), near] = np.inf
    beside = float(np.median(np.abs(rank[near] - rank[np.argmin(apart, axis=1)])))
    return float(np.median(np.abs(rank[near] - rank[there[near]]))) > min(_DIFFERENT * beside, _UNRELATED)


def heads_elsewhere(samples: Samples, linearisation: Linearisation, limit: float, best: float) -> IntArray:
    """Indices of the best runs of basins that the search left unfinished, the best first.

    Runs outside the region of the optimum without a better one nearby, whose objective is not far above the limit.
    """
    order = np.argsort(samples.objectives, kind="stable")
    order = order[samples.objectives[order] <= _UNFINISHED * limit]
    unit = samples.unit[order]
    outside = np.atleast_1d(_outside(samples, unit, linearisation, limit, best).any(axis=1))
    heads = [i for i in _heads(unit) if outside[i]]
    return np.asarray(order[heads], dtype=np.int64)
