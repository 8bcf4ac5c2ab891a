"""Weights of series and points: schemes, shares, and re-weighting of stored responses without a new run.

The objective is f = sum_g w_g f'_g with f'_g = (1/m_g) sum_h w_h r_hg^2 (Meier et al. 2008, equations (1) and (2)).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, cast

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import objective_of
from geoswarm.solver.errors import NotFiniteError
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.noise import known_noise, problem_noise
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.objective import counted_in_order
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.problem.weighting import WEIGHTINGS, SeriesShare, Weighting, scheme_factors, series_shares

__all__ = [
    "BY_SPREAD",
    "Reweighted",
    "Weighting",
    "reweight",
    "reweighted_problem",
    "scheme_weights",
    "spread_weights",
]

_EDGE_NEIGHBOURS = 0.02
_FEWEST_FOR_SPREAD = 8

BY_SPREAD = "by_spread"
"""Scheme of :func:`reweight` that chooses the weights of points from the spread of the residuals."""


@dataclass(frozen=True, slots=True)
class Reweighted:
    """Stored evaluations under other weights.

    Parameters
    ----------
    problem
        With the new weights.
    samples
        With the new objectives and misfits, shape (n,).
    shares
        At the new best sample.
    best_before, best_after
        Index of the best sample under the old and the new weights.
    warnings
        Whether the optimum would move outside the region that was sampled densely; empty if not.
    """

    problem: Problem
    samples: Samples
    shares: tuple[SeriesShare, ...]
    best_before: int
    best_after: int
    warnings: tuple[str, ...]


def scheme_weights(
    problem: Problem, weighting: Weighting, *, noise: Mapping[str, float] | float | None = None
) -> dict[str, float]:
    """Weights w_g that a scheme gives, scaled so that the largest is 1.

    The schemes are those of the problem file, see :func:`geoswarm.solver.problem.weighting.scheme_factors`.

    Parameters
    ----------
    noise
        Standard deviation of a reading of each series, base units; needed by ``by_error`` unless the problem has it.

    Raises
    ------
    StatisticsError
        For an unknown scheme, or ``by_error`` without noise.
    """
    if weighting not in WEIGHTINGS:
        raise StatisticsError(f"unknown weighting '{weighting}'; known: {', '.join(WEIGHTINGS)}")
    deviations = problem_noise(problem) if noise is None else known_noise(problem, noise)
    if weighting == "by_error" and deviations is None:
        raise StatisticsError("weighting by_error needs the standard deviation of a reading of each series (noise)")
    errors = {} if deviations is None else deviations.deviations
    return scheme_factors(weighting, problem.observations, problem.forward_model, errors)


def spread_weights(problem: Problem, responses: Mapping[str, FloatArray]) -> dict[str, list[float]]:
    """Weights w_h of the points, by series, from the spread of the residuals: 1 / s(x)^2 with mean 1, shape (m_g,).

    ln s is a parabola over the rank of x, fitted to ln |r| (Carroll and Ruppert 1988, section 3.3); 1 / s^2 differs by
    a factor of 100 at most. Points that are means count as the readings behind them. Points of weight 0 keep it; a
    series of fewer than eight points, or of no residuals, keeps its weights.

    Parameters
    ----------
    responses
        Calculated values at the best fit, shape (m_g,), base units.
    """
    found = {}
    for o in problem.observations:
        used = counted_in_order(o.x, o.point_weights)
        sizes = np.abs(o.residuals(responses[o.series]))[used]
        if used.size < _FEWEST_FOR_SPREAD or not sizes.any():
            continue
        counts = o.chosen_points().counts[used]
        middles = np.cumsum(counts) - counts / 2.0
        rank = 2.0 * (middles - middles[0]) / (middles[-1] - middles[0]) - 1.0
        logarithms = np.log(np.maximum(sizes, 1e-3 * float(np.median(sizes)) + 1e-300))
        table = np.stack([np.ones_like(rank), rank, rank**2], axis=1)
        root = np.sqrt(counts)
        line = table @ np.linalg.lstsq(table * root[:, None], logarithms * root, rcond=None)[0]
        own = counts * np.exp(-2.0 * np.maximum(line, line.max() - np.log(10.0)))
        weights = np.zeros(o.x.size)
        weights[used] = own / own.mean()
        found[o.series] = weights.tolist()
    return found


def reweighted_problem(
    problem: Problem,
    *,
    weights: Mapping[str, float] | None = None,
    point_weights: Mapping[str, list[float]] | None = None,
) -> Problem:
    """The same problem with other weights w_g and w_h; series that are not named keep theirs.

    Raises
    ------
    StatisticsError
        When a series is unknown.
    ProblemError
        When a weight is negative, all are 0, or a list has the wrong length.
    """
    document: dict[str, Any] = problem.document()
    document.pop("weighting", None)  # what its scheme gave is in the weights
    effective = {o.series: o.weight for o in problem.observations}
    known = list(effective)
    unknown = sorted({*(weights or {}), *(point_weights or {})} - set(known))
    if unknown:
        raise StatisticsError(f"unknown series {', '.join(unknown)}; observed: {', '.join(known)}")
    for section in document["observations"]:
        series = section["series"]
        section["weight"] = (weights or {}).get(series, effective[series])
        if point_weights and series in point_weights:
            observation = next(o for o in problem.observations if o.series == series)
            section["points"] = observation.chosen_points().document() | {"weight": list(point_weights[series])}
    return parse_problem(document, programs=problem.forward_model.runs_programs)


def reweight(
    problem: Problem,
    samples: Samples,
    *,
    weights: Mapping[str, float] | None = None,
    point_weights: Mapping[str, list[float]] | None = None,
    weighting: Weighting | Literal["by_spread"] | None = None,
    noise: Mapping[str, float] | float | None = None,
) -> Reweighted:
    """Calculate the objectives that stored responses have under other weights.

    The same code as in an evaluation runs on the same numbers, so the result is that of a fresh one to rounding.

    Parameters
    ----------
    weights
        New w_g by series; or let a ``weighting`` scheme choose them; ``by_spread`` chooses w_h
        (:func:`spread_weights`).
    point_weights
        New w_h by series, shape (m_g,).
    noise
        For ``by_error``.

    Raises
    ------
    StatisticsError
        When responses are needed and not stored, a series is unknown, or both weights and weighting are given.
    ProblemError
        When a weight is not accepted.
    """
    if weights is not None and weighting is not None:
        raise StatisticsError("give either weights or weighting, not both")
    if weighting == BY_SPREAD:
        if not samples.responses:
            raise StatisticsError("weighting by_spread needs the stored responses of the evaluations")
        fitted = {series: values[samples.best] for series, values in samples.responses.items()}
        point_weights = spread_weights(problem, fitted) | dict(point_weights or {})
    elif weighting is not None:
        weights = scheme_weights(problem, cast(Weighting, weighting), noise=noise)
    changed = reweighted_problem(problem, weights=weights, point_weights=point_weights)
    objective = objective_of(changed)
    series = [o.series for o in changed.observations]
    if samples.responses:
        rows = (
            dict(zip(series, row, strict=True)) for row in zip(*(samples.responses[s] for s in series), strict=True)
        )
        try:
            misfits = [objective.misfits(row) for row in rows]
        except NotFiniteError as error:
            raise StatisticsError(f"{error}; smaller weights are accepted") from None
    elif point_weights is None and samples.misfits:
        misfits = [{s: float(samples.misfits[s][i]) for s in series} for i in range(samples.size)]
    else:
        raise StatisticsError("re-weighting points needs the stored responses of the evaluations")
    after = replace(
        samples,
        objectives=np.array([objective.value(m) for m in misfits], dtype=np.float64),
        misfits={s: np.array([m[s] for m in misfits]) for s in series},
    )
    if not np.isfinite(after.objectives).all():
        raise StatisticsError("objectives under these weights are too large for a number; smaller weights are accepted")
    best = after.best
    return Reweighted(
        changed, after, series_shares(changed, misfits[best]), samples.best, best, _moved_outside(samples, after)
    )


def _moved_outside(before: Samples, after: Samples) -> tuple[str, ...]:
    """Warn where the new optimum lies at the edge of what was sampled, or where few samples lie around it.

    A swarm samples densely only around its own optimum. So the number of samples in a box around the new best sample (a
    tenth of the range to either side) is compared with that around the old one, and its place with the outermost
    samples.
    """
    unit, best = after.unit, after.best
    if best == before.best:
        return ()
    warnings = []
    place = unit[best]
    for index, name in enumerate(after.names):
        low, high = float(unit[:, index].min()), float(unit[:, index].max())
        value = after.parameters[best, index]
        if place[index] <= low + _EDGE_NEIGHBOURS * (high - low) or place[index] >= high - _EDGE_NEIGHBOURS * (
            high - low
        ):
            at_bound = place[index] <= _EDGE_NEIGHBOURS or place[index] >= 1.0 - _EDGE_NEIGHBOURS
            where = "at a bound of the search" if at_bound else "at the edge of the sampled region"
            warnings.append(f"the new optimum has {name} = {value:.4g} {where}: the true one may lie outside.")
    if not after.unbiased.any():
        around = int((np.abs(unit - place) <= 0.1).all(axis=1).sum())
        around_old = int((np.abs(unit - unit[before.best]) <= 0.1).all(axis=1).sum())
        if around < max(10 * after.dimension, around_old // 10):
            warnings.append(
                f"only {around} evaluations lie around the new optimum ({around_old} around the old one): the swarm "
                "did not search there; run it again with the new weights."
            )
    return tuple(warnings)
