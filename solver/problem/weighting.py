"""Weights w_g of the series that follow from their readings, and the shares of series and tests in the objective.

A test is a part of a combined problem; other problems are one test.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias, get_args

import numpy as np

from geoswarm.solver.problem.stages import section_of_test
from geoswarm.solver.units import convert_difference

if TYPE_CHECKING:
    from geoswarm.solver.forward.base import ForwardModelSpec
    from geoswarm.solver.problem.observations import Observation
    from geoswarm.solver.problem.problem import Problem

__all__ = [
    "WEIGHTINGS",
    "SeriesShare",
    "WeightShare",
    "Weighting",
    "by_test",
    "scheme_factors",
    "series_shares",
    "test_of",
    "weight_shares",
]

Weighting: TypeAlias = Literal["by_error", "by_count", "by_range", "by_test"]

WEIGHTINGS: tuple[Weighting, ...] = get_args(Weighting)


def scheme_factors(
    weighting: Weighting, observations: Sequence[Observation], spec: ForwardModelSpec, errors: Mapping[str, float]
) -> dict[str, float]:
    """Weights w_g that a scheme gives, scaled so that the largest is 1.

    ``by_error``
        m_g / sigma_g^2: every point counts by its precision, which makes the estimate the most likely one for normal
        errors.
    ``by_count``
        Number of readings: each counts alike, also those behind a point that is their mean, where eq. (2) of Meier et
        al. (2008) lets every *series* count alike.
    ``by_range``
        1 / (max y - min y)^2: misfits relative to the range of each series, for series of different units. A series of
        constant readings takes their magnitude.
    ``by_test``
        1 / (max y - min y)^2 / (number of series of the test whose weight is not 0): every test counts alike, and so do
        the series in it.

    Parameters
    ----------
    errors
        Standard deviation sigma_g of a point of weight 1 of each series, base units; only ``by_error`` looks at them.
    """
    if weighting == "by_count":
        weights = {o.series: o.readings for o in observations}
    elif weighting == "by_error":
        scaled = _scaled({o.series: errors[o.series] for o in observations})
        weights = {o.series: o.y.size / scaled[o.series] ** 2 for o in observations}
    else:
        weights = {series: 1.0 / extent**2 for series, extent in _scaled(_extents(observations)).items()}
    if weighting == "by_test":
        tests = {o.series: test_of(spec, o.series) for o in observations}
        counts = Counter(tests[o.series] for o in observations if o.weight > 0)
        weights = {series: weight / max(counts[tests[series]], 1) for series, weight in weights.items()}
    largest = max(weights.values())
    return {series: weight / largest for series, weight in weights.items()}


def test_of(spec: ForwardModelSpec, series: str) -> str:
    """Name of the test that a series belongs to; empty where there is only one."""
    return section_of_test(spec, series)[0].partition(".parts.")[2]


@dataclass(frozen=True, slots=True)
class SeriesShare:
    """Part of one series in the objective.

    Parameters
    ----------
    series, test
        Names; ``test`` is empty where there is only one.
    weight, misfit
        w_g and f'_g of equations (1) and (2), (base unit)^2.
    share
        w_g f'_g / f, between 0 and 1; 0 when the objective is 0.
    root_mean_square
        Of the residuals, weighted as the points are, in ``unit``: that of the measured values. Of a series with a loss
        the root of its mean loss.
    """

    series: str
    test: str
    weight: float
    misfit: float
    share: float
    root_mean_square: float
    unit: str


def series_shares(problem: Problem, misfits: Mapping[str, float]) -> tuple[SeriesShare, ...]:
    """Return the share of every series in the objective, in the order of the problem; ``misfits``: f'_g by series."""
    objective = sum(o.weight * misfits[o.series] for o in problem.observations)
    base = {info.name: info.y_unit for info in problem.model.series}
    shares = []
    for o in problem.observations:
        misfit, unit = float(misfits[o.series]), o.y_unit or base[o.series]
        heaviest = float(o.point_weights.max())
        mean = heaviest * float((o.point_weights / heaviest).mean())  # of weights whose sum may overflow
        deviation = convert_difference(math.sqrt(misfit / mean), base[o.series], unit)
        share = o.weight * misfit / objective if objective > 0.0 else 0.0
        test = test_of(problem.forward_model, o.series)
        shares.append(SeriesShare(o.series, test, o.weight, misfit, share, deviation, unit))
    return tuple(shares)


@dataclass(frozen=True, slots=True)
class WeightShare:
    """What the weight of a series makes of it, before anything has been calculated.

    Parameters
    ----------
    series, test
        Names; ``test`` is empty where there is only one.
    weight
        w_g.
    share
        Of the series in the objective if every series is missed by the same part of its range: w_g (max y - min y)^2
        over the sum of all, 0 to 1.
    readings
        Number of readings that the scheme counts, of ``by_error`` independent ones; None where it counts none.
    """

    series: str
    test: str
    weight: float
    share: float
    readings: float | None = None


def weight_shares(problem: Problem) -> tuple[WeightShare, ...]:
    """Return what the weights make of every series, in the order of the problem."""
    weights = np.array([o.weight for o in problem.observations])
    with np.errstate(divide="ignore"):  # sizes may be as small and large as numbers are
        sizes = np.log(weights) + 2.0 * np.log([*_extents(problem.observations).values()])
    parts = np.exp(sizes - sizes.max())
    return tuple(
        WeightShare(
            o.series,
            test_of(problem.forward_model, o.series),
            o.weight,
            float(share),
            _counted(problem.weighting, o),
        )
        for o, share in zip(problem.observations, parts / parts.sum(), strict=True)
    )


def _counted(weighting: Weighting | None, observation: Observation) -> float | None:
    if weighting == "by_error":
        return observation.y.size / observation.mean_error**2
    return observation.readings if weighting == "by_count" else None


def by_test(shares: Sequence[SeriesShare] | Sequence[WeightShare]) -> dict[str, float]:
    """Return the sum of the shares of each test, in their order; empty where there is only one."""
    sums: dict[str, float] = {}
    for one in shares:
        sums[one.test] = sums.get(one.test, 0.0) + one.share
    return sums if len(sums) > 1 else {}


def _extents(observations: Sequence[Observation]) -> dict[str, float]:
    with np.errstate(over="ignore"):
        found = {o.series: o.extent or float(np.abs(o.y).max()) or 1.0 for o in observations}
    return {series: min(extent, sys.float_info.max) for series, extent in found.items()}


def _scaled(sizes: Mapping[str, float]) -> dict[str, float]:
    """Sizes by a common power of two, which is exact, so that the smallest is about 1 and has a square."""
    power = -math.frexp(min(sizes.values()))[1]
    largest = math.sqrt(sys.float_info.max) / 2.0  # what is that much larger counts for nothing
    with np.errstate(over="ignore"):
        return {series: min(float(np.ldexp(size, power)), largest) for series, size in sizes.items()}
