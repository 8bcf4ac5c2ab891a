"""Whether the model describes the data: the verdict that comes before all others.

Intervals and verdicts about parameters hold only for a model that describes the data up to independent noise of the
stated size. Two things are tested at the optimum, with a level of 5 % over all series and stages: patterns in the
residuals (:mod:`.residual_tests`), with repeats the lack of fit against their scatter,
and the size of the residuals against a stated error. docs/statistics.md tells how often it is wrong.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.misfits import UNITS_FIRST, Misfit, remedies_of, sentence_of
from geoswarm.solver.identifiability.residuals.independence import repeats_test
from geoswarm.solver.identifiability.residuals.residual_tests import (
    FEWEST_IN_PART,
    Part,
    PartResult,
    examine_parts,
    examine_size,
    weighted_basis,
)
from geoswarm.solver.objective import ObservedSeries
from geoswarm.solver.plausibility.readings import doubtful_readings
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.stages import stage_of, stage_times

__all__ = ["LEVEL", "FitKind", "FitVerdict", "examine_fit", "is_exact", "met_to_rounding", "unfit_readings", "untested"]

FitKind: TypeAlias = Literal["describes", "lack_of_fit", "error_not_met", "untested"]

LEVEL = 0.04
"""Probability of calling a right model wrong, over all series and stages."""

_OTHER_LEVEL = 0.01  # each, of the test against repeats, and of that against the stated error
_ERROR_RATIO = 1.2  # residuals that exceed the stated error by less are let pass: intervals are that much too narrow
_FEWEST_FREE = 4  # readings beyond the parameters
_ROUNDING = 1e-10  # of the readings: less is no spread, and leaves nothing to minimise
_EXACT = 1e-4  # of the range of a series: residuals that are numerical, not measured
_FAR = 4.0  # mean square of what a step to the minimum would take away, over that of the rest
_MISSED = 0.5  # of the scatter of the readings around their mean: residuals that a constant would hardly exceed
_FOLLOWS = 0.5  # Durbin-Watson below which residuals lie on one side for long
_MOST_POINTS = 2000  # more are averaged in blocks
_NOT_YET = "the best parameters are not the minimum yet; polish them first (geoswarm sensitivity)"


@dataclass(frozen=True, slots=True)
class FitVerdict:
    """Whether the model describes the data.

    Parameters
    ----------
    kind
        ``describes``: no lack of fit was found; ``lack_of_fit``; ``error_not_met``: the residuals exceed the stated
        error, without a pattern; ``untested``.
    sentence
        The verdict in words.
    misfits
        Where, the clearest first.
    remedies
        What to do, in sentences.
    level
        Of the test.
    """

    kind: FitKind
    sentence: str
    misfits: tuple[Misfit, ...] = ()
    remedies: tuple[str, ...] = ()
    level: float = LEVEL

    @property
    def wrong(self) -> bool:
        """Whether intervals do not hold, because the model or the stated error is wrong."""
        return self.kind in ("lack_of_fit", "error_not_met")

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return asdict(self) | {"misfits": [asdict(m) for m in self.misfits], "remedies": list(self.remedies)}


def untested(why: str) -> FitVerdict:
    """The verdict where nothing could be tested."""
    return FitVerdict("untested", f"Whether the model describes the data was not tested: {why}.")


def unfit_readings(problem: Problem) -> FitVerdict | None:
    """The verdict on readings that no soil can have; None where there are none. No model can describe them."""
    doubts = [doubt for doubt in doubtful_readings(problem) if doubt.impossible]
    if not doubts:
        return None
    each = ". ".join(f"{doubt.series}: {doubt.message}" for doubt in doubts)
    return FitVerdict("lack_of_fit", f"The readings do not fit this specimen. {each}.", (), (UNITS_FIRST,))


@dataclass(frozen=True, slots=True)
class _Residuals:
    """Calculated - measured of the readings of one series that count, in the order of x, shape (m,).

    They are those of every table and figure: the tests themselves look at other ones, after a step to where each series
    counts by its noise. ``stages``: number of the stage of each, from 1; None without stages.
    """

    x: FloatArray
    y: FloatArray
    values: FloatArray
    weights: FloatArray
    stages: IntArray | None

    @classmethod
    def of(cls, problem: Problem, o: ObservedSeries, calculated: FloatArray) -> _Residuals:
        used = np.flatnonzero(o.point_weights > 0)
        used = used[np.argsort(o.x[used], kind="stable")]
        starts = stage_times(problem.forward_model, o.series)
        stages = stage_of(o.x[used], starts) if starts.size >= 2 else None
        return cls(o.x[used], o.y[used], (calculated - o.y)[used], o.point_weights[used], stages)

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
class _Readings:
    """All readings that count, in the order of series and x, of shape (n,); ``measured``: those of each series."""

    observed: tuple[ObservedSeries, ...]
    measured: tuple[_Residuals, ...]
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


def examine_fit(
    calibration: Calibration,
    responses: Mapping[str, FloatArray],
    derivatives: Mapping[str, FloatArray],
    known: Mapping[str, float] | None = None,
    *,
    at_bound: bool = False,
) -> FitVerdict:
    """Test whether the model describes the data, at the optimum or near it.

    Parameters
    ----------
    responses
        Calculated values at the optimum, shape (m_g,), base units.
    derivatives
        Of the responses to the free parameters, shape (m_g, k) by series, in any units and combinations: only what they
        span counts. Leave out those to parameters that lie at a bound.
    known
        Stated standard deviation of a reading by series, base units.
    at_bound
        Whether parameters lie at their bounds: readings that are then missed by far are no question of the minimum.
    """
    if (unfit := unfit_readings(calibration.problem)) is not None:
        return unfit
    readings = _readings(calibration, responses, derivatives)
    if at_bound and (missed := _missed(readings, known)):
        return _verdict(calibration.problem, missed, [])
    basis = weighted_basis(readings.weighted)
    count, rank = len(readings.x), basis.shape[1]
    free = count - rank
    if free < (_FEWEST_FREE if known is None else 1):
        return untested(f"{count} readings for {rank} parameters leave too few to test it")
    rho = readings.scaled * readings.factors
    along = basis.T @ rho
    rest = float(rho @ rho - along @ along) / free
    rounding = met_to_rounding(readings.observed, responses)
    if known is None and rank and not rounding and float(along @ along) / rank > _FAR * rest:
        return untested(_NOT_YET)
    # one step to where every series counts by its noise: weights chosen by hand carry noise from series to series
    deviations = _spread(readings, readings.scaled) if known is None else _stated(readings, known)
    readings = replace(
        readings, factors=1.0 / deviations, weighted=readings.weighted / (readings.factors * deviations)[:, None]
    )
    basis = weighted_basis(readings.weighted)
    rho = readings.scaled / deviations
    along = basis.T @ rho
    residuals = (rho - basis @ along) * deviations
    if known is not None and free < _FEWEST_FREE:  # too few for a pattern; their size tells from the first on
        rest = float(rho @ rho - along @ along) / free
        if rank and float(along @ along) / rank > _FAR * max(rest, 1.0):
            return untested(_NOT_YET)
        return _verdict(calibration.problem, [], _exceeded(readings, residuals, basis, deviations), patterns=False)
    parts, places = _parts(calibration.problem, readings)
    misfits = [*_patterns(readings, residuals, basis, parts, places, deviations, known is not None)]
    misfits += _repeats(readings, residuals, rank, known)
    exceeded = [] if known is None else _exceeded(readings, residuals, basis, deviations)
    if exceeded and not misfits:
        misfits += _patterns(readings, residuals, basis, parts, places, _spread(readings, readings.scaled), False)
    return _verdict(calibration.problem, misfits, exceeded)


def _readings(
    calibration: Calibration, responses: Mapping[str, FloatArray], derivatives: Mapping[str, FloatArray]
) -> _Readings:
    pseudo = calibration.objective.pseudo_readings(responses)
    observed = tuple(o for o in pseudo.observed if o.weight > 0)
    columns: list[list[FloatArray]] = [[] for _ in range(6)]
    for index, o in enumerate(observed):
        used = np.flatnonzero(o.point_weights > 0)
        used = used[np.argsort(o.x[used], kind="stable")]
        inside = np.sqrt(o.point_weights[used])
        factor = np.full(used.size, np.sqrt(o.weight / o.y.size))
        residuals = pseudo.residuals[o.series][used]
        weighted = derivatives[o.series][used] * (inside * factor)[:, None]
        rows = (np.full(used.size, index), o.x[used], residuals, inside, factor, weighted)
        for column, values in zip(columns, _averaged(rows, used.size), strict=True):
            column.append(values)
    series, *others = (np.concatenate(column) for column in columns)
    measured = tuple(_Residuals.of(calibration.problem, o, responses[o.series]) for o in observed)
    return _Readings(observed, measured, series.astype(np.int64), *others)


def _averaged(rows: tuple[FloatArray, ...], size: int) -> tuple[FloatArray, ...]:
    """Means over blocks of neighbours where there are very many readings; patterns only stand out more."""
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


def _parts(problem: Problem, readings: _Readings) -> tuple[list[Part], list[tuple[int, int | None]]]:
    """Series and stages with enough readings, and where they are: index of the series and number of the stage."""
    parts: list[Part] = []
    places: list[tuple[int, int | None]] = []
    for index, o in enumerate(readings.observed):
        own = readings.of(index)
        if own.size < FEWEST_IN_PART:
            continue
        parts.append(Part(own, readings.x[own], own))
        places.append((index, None))
        starts = stage_times(problem.forward_model, o.series)
        if starts.size < 2:
            continue
        stages = stage_of(readings.x[own], starts)
        numbers, counts = np.unique(stages, return_counts=True)
        for number in numbers[counts >= FEWEST_IN_PART] if numbers.size > 1 else ():
            inside = own[stages == number]
            parts.append(Part(inside, readings.x[inside], own))
            places.append((index, int(number)))
    return parts, places


def _spread(readings: _Readings, residuals: FloatArray) -> FloatArray:
    """Estimated standard deviation of the scaled noise of each series, repeated to shape (n,).

    Of what no change of the parameters takes away from the series alone; so the fit of other series does not enter.
    """
    spread = np.empty(len(residuals))
    for index in range(len(readings.observed)):
        own = readings.of(index)
        basis = weighted_basis(readings.weighted[own])
        left = residuals[own] - basis @ (basis.T @ residuals[own])
        free = own.size - basis.shape[1]
        if free < _FEWEST_FREE - 1:
            left, free = residuals[own], own.size
        least = _ROUNDING * max(float(np.abs(readings.observed[index].y).max()), 1e-290)
        spread[own] = max(float(np.sqrt(np.sum(left**2) / free)), least * float(readings.inside[own].max()))
    return spread


def is_exact(o: ObservedSeries, residuals: FloatArray, most: float = _EXACT) -> bool:
    """Whether the residuals are numerical, ``most`` of the range: nothing that anybody has measured so well."""
    scale = max(float(np.ptp(o.y)), 1e-6 * float(np.abs(o.y).max()))
    return float(np.sqrt(np.mean(residuals**2))) <= most * scale


def met_to_rounding(observed: Sequence[ObservedSeries], responses: Mapping[str, FloatArray]) -> bool:
    """Whether the responses equal all readings but for rounding: there is nothing left to minimise."""
    return all(is_exact(o, responses[o.series] - o.y, _ROUNDING) for o in observed)


def _patterns(
    readings: _Readings,
    residuals: FloatArray,
    basis: FloatArray,
    parts: list[Part],
    places: list[tuple[int, int | None]],
    deviations: FloatArray,
    known: bool,
) -> list[Misfit]:
    chosen = [
        (part, place)
        for part, place in zip(parts, places, strict=True)
        if known or not is_exact(readings.observed[place[0]], (residuals / readings.inside)[part.indices])
    ]
    if not chosen:
        return []
    found: tuple[PartResult, ...] = examine_parts(
        residuals, readings.factors, deviations, basis, [part for part, _ in chosen], known=known
    )
    misfits = [
        _misfit(readings, place, "pattern", result.adjusted)
        for (_, place), result in zip(chosen, found, strict=True)
        if result.adjusted < LEVEL
    ]
    return sorted(misfits, key=lambda misfit: (misfit.probability, misfit.stage is not None))


def _misfit(
    readings: _Readings,
    place: tuple[int, int | None],
    reason: Literal["pattern", "repeats", "stated_error", "missed"],
    probability: float,
    ratio: float | None = None,
) -> Misfit:
    index, stage = place
    deviation, largest, x = readings.measured[index].size(stage)
    series = readings.observed[index].series
    return Misfit(series, stage, reason, probability, deviation, largest, x, ratio, "", "")


def _missed(readings: _Readings, known: Mapping[str, float] | None) -> list[Misfit]:
    """Series that are missed by far, and by more than their stated error."""
    found = [_misfit(readings, (i, None), "missed", 0.0) for i, one in enumerate(readings.measured) if one.is_missed]
    return [one for one in found if known is None or one.deviation > _FAR * known[one.series]]


def _repeats(readings: _Readings, residuals: FloatArray, rank: int, known: Mapping[str, float] | None) -> list[Misfit]:
    """Lack of fit against the scatter of repeats; the level is shared among the series that have any (Holm 1979)."""
    found = []
    for index in range(len(readings.observed)):
        own = readings.of(index)
        natural = (residuals / readings.inside)[own]
        lack = repeats_test(readings.x[own], residuals[own], readings.inside[own] ** 2, rank)
        if lack is None or lack.probability is None or is_exact(readings.observed[index], natural):
            continue
        if known is not None and lack.noise * _ERROR_RATIO < known[readings.observed[index].series]:
            continue  # the stated error covers more than the repeats show
        found.append(_misfit(readings, (index, None), "repeats", lack.probability))
    found.sort(key=lambda misfit: misfit.probability)
    kept = []
    for tried, misfit in enumerate(found):
        if misfit.probability >= _OTHER_LEVEL / (len(found) - tried):
            break
        kept.append(misfit)
    return kept


def _stated(readings: _Readings, known: Mapping[str, float]) -> FloatArray:
    return np.array([known[readings.observed[index].series] for index in readings.series], dtype=np.float64)


def _exceeded(readings: _Readings, residuals: FloatArray, basis: FloatArray, deviations: FloatArray) -> list[Misfit]:
    """Series whose residuals exceed the stated error, by more than chance and by a fifth at least."""
    own = [readings.of(index) for index in range(len(readings.observed))]
    found = []
    results = examine_size(residuals, readings.factors, deviations, basis, own)
    for index, (ratio, probability) in enumerate(results):
        if probability < _OTHER_LEVEL and ratio > _ERROR_RATIO:
            found.append(_misfit(readings, (index, None), "stated_error", probability, ratio))
    return sorted(found, key=lambda misfit: -(misfit.ratio or 0.0))


def _verdict(
    problem: Problem, misfits: list[Misfit], exceeded: list[Misfit], *, patterns: bool = True
) -> FitVerdict:
    """The verdict from what was found; ``patterns``: whether there were enough readings to look for them."""
    found = tuple(misfit.in_units_of(problem) for misfit in (*misfits, *exceeded))
    if not found:
        looks = "looks like independent noise" if patterns else "is within the stated error; too few readings for more"
        return FitVerdict("describes", f"No lack of fit was found: what the model leaves {looks}.")
    kind: FitKind = "lack_of_fit" if misfits else "error_not_met"
    return FitVerdict(kind, sentence_of(found), found, remedies_of(problem, found))
