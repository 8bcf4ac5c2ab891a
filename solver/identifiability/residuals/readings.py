"""The readings that count at the optimum, weighed by their noise, for the tests of the fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.residuals.residual_tests import FEWEST_IN_PART, weighted_basis
from geoswarm.solver.objective import ObservedSeries, counted_in_order
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.stages import stage_of, stage_times

__all__ = [
    "FEWEST_FREE",
    "Readings",
    "MeasuredResiduals",
    "along_and_rest",
    "by_noise",
    "is_exact",
    "left_over",
    "met_to_rounding",
    "readings_at",
    "spread_of",
]

FEWEST_FREE = 4
"""Readings beyond the parameters that a test without a stated error needs."""

_ROUNDING = 1e-10  # of the readings: less is no spread, and leaves nothing to minimise
_EXACT = 1e-4  # of the range of a series: residuals that are numerical, not measured
_MISSED = 0.5  # of the scatter of the readings around their mean: residuals that a constant would hardly exceed
_FOLLOWS = 0.5  # Durbin-Watson below which residuals lie on one side for long
_MOST_POINTS = 2000  # more are averaged in blocks


@dataclass(frozen=True, slots=True)
class MeasuredResiduals:
    """Residuals and calculated values at the readings of one series that count, in the order of x, shape (m,).

    They are those of every table and figure: the tests themselves look at other ones, after a step to where each series
    counts by its noise. ``numbers``: of the readings in the observation, from 1; ``stages``: of the stage of each, from
    1, None without stages.
    """

    numbers: IntArray
    x: FloatArray
    y: FloatArray
    calculated: FloatArray
    values: FloatArray
    weights: FloatArray
    stages: IntArray | None

    @classmethod
    def of(cls, problem: Problem, o: ObservedSeries, calculated: FloatArray) -> MeasuredResiduals:
        used = counted_in_order(o.x, o.point_weights)
        starts = stage_times(problem.forward_model, o.series)
        stages = stage_of(o.x[used], starts) if starts.size >= 2 else None
        values = o.residuals(calculated)[used]
        return cls(used + 1, o.x[used], o.y[used], calculated[used], values, o.point_weights[used], stages)

    def without(self, excluded: BoolArray) -> MeasuredResiduals:
        """The same without some readings."""
        kept = ~excluded
        stages = None if self.stages is None else self.stages[kept]
        x, y, calculated = self.x[kept], self.y[kept], self.calculated[kept]
        return MeasuredResiduals(self.numbers[kept], x, y, calculated, self.values[kept], self.weights[kept], stages)

    @property
    def is_missed(self) -> bool:
        """Whether a constant would be about as close, and neighbours are missed to the same side."""
        mean = np.average(self.y, weights=self.weights)
        left, whole = (float(np.sum(self.weights * part**2)) for part in (self.values, self.y - mean))
        follow = float(np.sum(np.diff(self.values) ** 2)) < _FOLLOWS * float(np.sum(self.values**2))
        return self.x.size >= FEWEST_IN_PART and left > _MISSED * whole and follow

    def size(self, stage: int | None) -> tuple[float, float, float]:
        """Root mean square, the largest residual, and its x: of the series, or of one stage."""
        own = slice(None) if stage is None or self.stages is None else self.stages == stage
        x, values, weights = self.x[own], self.values[own], self.weights[own]
        worst = int(np.argmax(np.abs(values)))
        return float(np.sqrt(np.sum(weights * values**2) / np.sum(weights))), float(values[worst]), float(x[worst])


@dataclass(frozen=True, slots=True)
class Readings:
    """All readings that count, in the order of series and x, of shape (n,); ``measured``: those of each series."""

    observed: tuple[ObservedSeries, ...]
    measured: tuple[MeasuredResiduals, ...]
    series: IntArray
    x: FloatArray
    residuals: FloatArray
    inside: FloatArray
    factors: FloatArray
    weighted: FloatArray

    @property
    def scaled(self) -> FloatArray:
        return self.residuals * self.inside

    def of(self, index: int) -> IntArray:
        return np.flatnonzero(self.series == index)

    def without(self, excluded: Sequence[int]) -> Readings:
        """The same without some readings, of which none are means yet."""
        kept = np.ones(len(self.x), dtype=np.bool_)
        kept[list(excluded)] = False
        measured = [one.without(np.isin(self.of(index), excluded)) for index, one in enumerate(self.measured)]
        return replace(
            self,
            measured=tuple(measured),
            series=self.series[kept],
            x=self.x[kept],
            residuals=self.residuals[kept],
            inside=self.inside[kept],
            factors=self.factors[kept],
            weighted=self.weighted[kept],
        )

    def averaged(self) -> Readings:
        """The same with means over blocks of neighbours where a series has very many; patterns only stand out more."""
        if max(one.x.size for one in self.measured) <= _MOST_POINTS:
            return self
        columns = (self.series.astype(np.float64), self.x, self.residuals, self.inside, self.factors, self.weighted)
        means = [_block_means(tuple(c[own] for c in columns)) for own in map(self.of, range(len(self.observed)))]
        series, *others = (np.concatenate(parts) for parts in zip(*means, strict=True))
        return Readings(self.observed, self.measured, series.astype(np.int64), *others)


def readings_at(
    calibration: Calibration, responses: Mapping[str, FloatArray], derivatives: Mapping[str, FloatArray]
) -> Readings:
    pseudo = calibration.objective.pseudo_readings(responses)
    observed = tuple(o for o in pseudo.observed if o.weight > 0)
    columns: list[list[FloatArray]] = [[] for _ in range(6)]
    for index, o in enumerate(observed):
        used = counted_in_order(o.x, o.point_weights)
        inside = np.sqrt(o.point_weights[used])
        factor = np.full(used.size, np.sqrt(o.weight / o.y.size))
        residuals = pseudo.residuals[o.series][used]
        weighted = derivatives[o.series][used] * (inside * factor)[:, None]
        rows = (np.full(used.size, index), o.x[used], residuals, inside, factor, weighted)
        for column, values in zip(columns, rows, strict=True):
            column.append(values)
    series, *others = (np.concatenate(column) for column in columns)
    measured = tuple(MeasuredResiduals.of(calibration.problem, o, responses[o.series]) for o in observed)
    return Readings(observed, measured, series.astype(np.int64), *others)


def _block_means(rows: tuple[FloatArray, ...]) -> tuple[FloatArray, ...]:
    size = len(rows[0])
    block = -(-size // _MOST_POINTS)
    if block == 1:
        return rows
    starts = np.arange(0, size, block)
    counts = np.diff(np.append(starts, size)).astype(np.float64)
    index, x, residuals, inside, factor, weighted = rows
    weights = inside**2
    total = np.add.reduceat(weights, starts)
    return (
        index[starts],
        np.add.reduceat(x, starts) / counts,
        np.add.reduceat(residuals * weights, starts) / total,
        np.sqrt(total),
        factor[starts],
        np.add.reduceat(weighted * inside[:, None], starts) / np.sqrt(total)[:, None],
    )


def along_and_rest(rho: FloatArray, basis: FloatArray) -> tuple[float, float]:
    """Mean squares of residuals, shape (n,): of what the parameters can take away, and of the rest."""
    along = basis.T @ rho
    rank = max(basis.shape[1], 1)
    return float(along @ along) / rank, float(rho @ rho - along @ along) / (len(rho) - basis.shape[1])


def by_noise(readings: Readings, known: Mapping[str, float] | None) -> tuple[Readings, FloatArray]:
    """Weigh every series by its noise, shape (n,): weights chosen by hand carry noise from series to series."""
    deviations = spread_of(readings, readings.scaled) if known is None else _stated(readings, known)
    weighted = readings.weighted / (readings.factors * deviations)[:, None]
    return replace(readings, factors=1.0 / deviations, weighted=weighted), deviations


def left_over(readings: Readings, deviations: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Scaled residuals after a step to the minimum, shape (n,), and the basis of what the parameters can change."""
    basis = weighted_basis(readings.weighted)
    rho = readings.scaled / deviations
    return (rho - basis @ (basis.T @ rho)) * deviations, basis


def spread_of(readings: Readings, residuals: FloatArray) -> FloatArray:
    """Estimated standard deviation of the scaled noise of each series, repeated to shape (n,).

    Of what no change of the parameters takes away from the series alone; so the fit of other series does not enter.
    """
    spread = np.empty(len(residuals))
    for index in range(len(readings.observed)):
        own = readings.of(index)
        basis = weighted_basis(readings.weighted[own])
        left = residuals[own] - basis @ (basis.T @ residuals[own])
        free = own.size - basis.shape[1]
        if free < FEWEST_FREE - 1:
            left, free = residuals[own], own.size
        least = _ROUNDING * max(float(np.abs(readings.observed[index].y).max()), 1e-290)
        spread[own] = max(float(np.sqrt(np.sum(left**2) / free)), least * float(readings.inside[own].max()))
    return spread


def _stated(readings: Readings, known: Mapping[str, float]) -> FloatArray:
    return np.array([known[readings.observed[index].series] for index in readings.series], dtype=np.float64)


def is_exact(o: ObservedSeries, residuals: FloatArray, most: float = _EXACT) -> bool:
    """Whether the residuals are numerical, ``most`` of the range: nothing that anybody has measured so well."""
    scale = max(float(np.ptp(o.y)), 1e-6 * float(np.abs(o.y).max()))
    return float(np.sqrt(np.mean(residuals**2))) <= most * scale


def met_to_rounding(observed: Sequence[ObservedSeries], responses: Mapping[str, FloatArray]) -> bool:
    """Whether the responses equal all readings but for rounding: there is nothing left to minimise."""
    return all(is_exact(o, o.residuals(responses[o.series]), _ROUNDING) for o in observed)
