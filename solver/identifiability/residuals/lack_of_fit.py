"""Whether the model describes the data: the verdict that comes before all others.

Intervals and verdicts about parameters hold only for a model that describes the data up to independent noise of the
stated size. Two things are tested at the optimum, with a level of 5 % over all series and stages: patterns in the
residuals (:mod:`.residual_tests`), with repeats the lack of fit against their scatter,
and the size of the residuals against a stated error. Readings that the others exclude (:mod:`.gross_errors`) are named
before and left out of these tests. docs/statistics.md says how often the tests are wrong.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.misfits import DOES_NOT_HOLD, Closeness, Misfit, headline_of, sentence_of
from geoswarm.solver.identifiability.remedies import Remedy, check_readings, follow_up, remedies_of
from geoswarm.solver.identifiability.residuals.closeness import closeness_of
from geoswarm.solver.identifiability.residuals.gross_errors import GROSS_LEVEL, excluded_readings
from geoswarm.solver.identifiability.residuals.independence import repeats_test
from geoswarm.solver.identifiability.residuals.readings import (
    FEWEST_FREE,
    Readings,
    along_and_rest,
    by_noise,
    is_exact,
    left_over,
    met_to_rounding,
    readings_at,
    spread_of,
)
from geoswarm.solver.identifiability.residuals.residual_tests import (
    FEWEST_IN_PART,
    Part,
    PartResult,
    examine_parts,
    examine_size,
    smooth_share,
    weighted_basis,
)
from geoswarm.solver.plausibility.readings import doubtful_readings
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.stages import stage_of, stage_times
from geoswarm.solver.words import FITS

__all__ = ["LEVEL", "FitKind", "FitVerdict", "examine_fit", "unfit_readings", "untested"]

FitKind: TypeAlias = Literal["describes", "gross_error", "doubtful", "lack_of_fit", "error_not_met", "untested"]

LEVEL = 0.04
"""Probability of doubting a right model, over all series and stages."""

_WRONG_LEVEL = 0.01  # below which a pattern is a lack of fit, and no more a doubt
_OTHER_LEVEL = 0.01  # each, of the test against repeats, and of that against the stated error
_SMALL = 0.01  # of the noise: a smooth deviation or a correlation that changes nothing, however many readings show it
_ERROR_RATIO = 1.2  # residuals that exceed the stated error by less are let pass: intervals are that much too narrow
_FAR = 4.0  # mean square of what a step to the minimum would take away, over that of the rest
_SLIPS = (0.1, 10.0, 0.01, 100.0, 1e-3, 1e3, -1.0)  # of a decimal point, or a sign
_FITS = 3.0  # standard deviations
_NOT_YET = "the best parameters are not the minimum yet; polish them first"


@dataclass(frozen=True, slots=True)
class FitVerdict:
    """Whether the model describes the data.

    Parameters
    ----------
    kind
        ``describes``: no lack of fit was found; ``gross_error``: the same without readings that the others exclude;
        ``doubtful``: a right model leaves such a pattern once in 25 to 100 sets of readings; ``lack_of_fit``;
        ``error_not_met``: the residuals exceed the stated error, without a pattern; ``untested``.
    sentence
        The verdict in words.
    misfits
        Where, the clearest first.
    remedies
        What to do.
    level
        Of the test.
    closeness
        How close the calculated curves come, by quantity; empty where nothing was tested.
    tests
        Number of tests that count as one piece of information each in the intervals, which hold then although the model
        or the stated error is wrong; 0 otherwise.
    """

    kind: FitKind
    sentence: str
    misfits: tuple[Misfit, ...] = ()
    remedies: tuple[Remedy, ...] = ()
    level: float = LEVEL
    closeness: tuple[Closeness, ...] = ()
    tests: int = 0

    @property
    def wrong(self) -> bool:
        """Whether the model or the stated error is wrong: intervals do not hold unless they count whole tests."""
        return self.kind in ("lack_of_fit", "error_not_met")

    @property
    def unreached(self) -> bool:
        """Whether it was not tested because the minimum is too far away."""
        return self.kind == "untested" and any(remedy.kind == "sensitivity" for remedy in self.remedies)

    @property
    def caution(self) -> str:
        """What stands beside an interval; empty where it holds."""
        return DOES_NOT_HOLD[self.kind] if self.wrong and not self.tests else ""

    @property
    def words(self) -> str:
        """The kind in a clause."""
        return f"{FITS[self.kind]}, so no interval holds" if self.caution else FITS[self.kind]

    def between(self, tests: int) -> FitVerdict:
        """The same where intervals count each test as one piece of information.

        What is missed by far, or no soil can have, is no matter of tests that differ.
        """
        if not self.wrong or not self.misfits or any(one.reason == "missed" for one in self.misfits):
            return self
        said = sentence_of(self.misfits, self.closeness, tests=tests)
        remedies = tuple(one for one in self.remedies if one.kind != "thin")  # dependent readings are allowed for
        return replace(self, tests=tests, sentence=said, remedies=remedies)

    @property
    def headline(self) -> str:
        """What stands above all results; empty where nothing has to."""
        unfit = not self.misfits and any(remedy.kind == "check_readings" for remedy in self.remedies)
        return "The readings do not fit this specimen" if unfit else headline_of(self.kind, self.misfits)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        remedies = [remedy.to_json() for remedy in self.remedies]
        lists = {"misfits": [asdict(m) for m in self.misfits], "remedies": [one["text"] for one in remedies]}
        return asdict(self) | lists | {"what_to_do": remedies, "headline": self.headline, "words": self.words}


def untested(why: str, *remedies: Remedy) -> FitVerdict:
    """The verdict where nothing could be tested."""
    return FitVerdict("untested", f"Whether the model describes the data was not tested: {why}.", (), remedies)


def unfit_readings(problem: Problem, *, at_bound: bool = False) -> FitVerdict | None:
    """The verdict on readings that no soil can have; None where there are none. No model can describe them.

    Where parameters lie at their bounds (``at_bound``), also on those that soils hardly have and would have in another
    unit, unless the problem accepts them.
    """
    doubts = [
        doubt
        for doubt in doubtful_readings(problem)
        if doubt.impossible or (at_bound and doubt.unit is not None and doubt.series not in problem.accept)
    ]
    if not doubts:
        return None
    each = ". ".join(f"{doubt.series}: {doubt.seen}" for doubt in doubts)
    return FitVerdict("lack_of_fit", f"{each}.", (), (check_readings(doubts),))


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
    if (unfit := unfit_readings(calibration.problem, at_bound=at_bound)) is not None:
        return unfit
    whole = readings_at(calibration, responses, derivatives)
    readings = whole.averaged()
    if at_bound and (missed := _missed(readings, known)):
        return _verdict(calibration.problem, readings, missed)
    basis = weighted_basis(readings.weighted)
    count, rank = len(readings.x), basis.shape[1]
    free = count - rank
    too_few = untested(f"{count} readings for {rank} parameters leave too few to test it")
    if free < (FEWEST_FREE - 1 if known is None else 1):
        return too_few
    rho = readings.scaled * readings.factors
    along, rest = along_and_rest(rho, basis)
    if known is None and rank and not met_to_rounding(readings.observed, responses) and along > _FAR * rest:
        return untested(_NOT_YET, follow_up("sensitivity"))
    readings, deviations = by_noise(readings, known)
    gross, excluded = _gross(*by_noise(whole, known), known)
    exceeded = [] if known is None else _exceeded(readings, deviations)
    if gross:
        readings, deviations = by_noise(whole.without(excluded).averaged(), known)
        free -= len(excluded)
    elif known is None and free < FEWEST_FREE:
        return too_few
    if gross or free < FEWEST_FREE:
        along, rest = along_and_rest(readings.scaled / deviations, weighted_basis(readings.weighted))
        moved = rank and along > _FAR * max(rest, 1.0)  # what the others say of themselves is known at their minimum
        if moved and not gross:
            return untested(_NOT_YET, follow_up("sensitivity"))
        if moved or free < FEWEST_FREE:  # too few for a pattern; their size is tested from the first on
            return _verdict(calibration.problem, readings, [*gross, *exceeded], patterns=False)
    parts, places = _parts(calibration.problem, readings)
    misfits = [*_patterns(readings, parts, places, deviations, known is not None)]
    misfits += _repeats(readings, deviations, rank, known)
    if exceeded and not misfits:
        misfits += _patterns(readings, parts, places, spread_of(readings, readings.scaled), False)
    return _verdict(calibration.problem, readings, [*gross, *misfits, *exceeded])


def _gross(
    readings: Readings, deviations: FloatArray, known: Mapping[str, float] | None
) -> tuple[list[Misfit], list[int]]:
    """Readings that the others of their series exclude; a robust loss copes with them by itself.

    Of a series with distances from its curve none: they do not say what a reading would have to be.

    Returns
    -------
    tuple
        The readings, and the indices of those without which patterns are looked for. Neighbours on the same side of the
        curve stay in, unless a slip explains them: they may as well be what the model does not describe.
    """
    misfits, excluded = [], []
    basis, scaled = weighted_basis(readings.weighted), readings.scaled / deviations
    for index, (o, measured) in enumerate(zip(readings.observed, readings.measured, strict=True)):
        unlike = o.loss is not None or o.along is not None
        if unlike or (known is None and is_exact(o, measured.values)):
            continue
        own = readings.of(index)
        found = excluded_readings(scaled, basis, own, known=known is not None)
        for one in found:
            place = int(one.index - own[0])
            apart = one.expected * deviations[one.index] / readings.inside[one.index]
            slip = _slip(float(measured.y[place]), float(apart), abs(one.deviations))
            if slip is not None or not any(one.is_beside(other) for other in found):
                excluded.append(one.index)
            misfits.append(
                Misfit(
                    o.series,
                    None,
                    "gross_error",
                    GROSS_LEVEL,
                    abs(apart),
                    float(apart),
                    float(measured.x[place]),
                    abs(one.deviations),
                    "",
                    "",
                    int(measured.numbers[place]),
                    slip,
                )
            )
    return misfits, excluded


def _slip(y: float, apart: float, deviations: float) -> float | None:
    """The power of ten, or -1, by which a reading would have to be multiplied to be what the others say; or None.

    ``apart``: what they say - the reading, which is ``deviations`` standard deviations.
    """
    if y == 0.0:
        return None
    near = _FITS * abs(apart) / deviations
    return next((factor for factor in _SLIPS if abs(y * factor - (y + apart)) <= near), None)


def _parts(problem: Problem, readings: Readings) -> tuple[list[Part], list[tuple[int, int | None]]]:
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


def _patterns(
    readings: Readings,
    parts: list[Part],
    places: list[tuple[int, int | None]],
    deviations: FloatArray,
    known: bool,
) -> list[Misfit]:
    residuals, basis = left_over(readings, deviations)
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
        for (part, place), result in zip(chosen, found, strict=True)
        if result.adjusted < LEVEL and _is_seen(readings, place[0], part, residuals)
    ]
    return sorted(misfits, key=lambda misfit: (misfit.probability, misfit.stage is not None))


def _is_seen(readings: Readings, index: int, part: Part, residuals: FloatArray) -> bool:
    """Whether a pattern is more than a hundredth of the noise of a reading."""
    averaged = readings.measured[index].x.size / readings.of(index).size
    smooth, follows = smooth_share(part.x, residuals[part.indices])
    return smooth / averaged > _SMALL**2 or follows > _SMALL


def _misfit(
    readings: Readings,
    place: tuple[int, int | None],
    reason: Literal["pattern", "repeats", "stated_error", "missed"],
    probability: float,
    ratio: float | None = None,
) -> Misfit:
    index, stage = place
    deviation, largest, x = readings.measured[index].size(stage)
    series = readings.observed[index].series
    return Misfit(series, stage, reason, probability, deviation, largest, x, ratio, "", "")


def _missed(readings: Readings, known: Mapping[str, float] | None) -> list[Misfit]:
    """Series that are missed by far, and by more than their stated error."""
    found = [_misfit(readings, (i, None), "missed", 0.0) for i, one in enumerate(readings.measured) if one.is_missed]
    return [one for one in found if known is None or one.deviation > _FAR * known[one.series]]


def _repeats(readings: Readings, deviations: FloatArray, rank: int, known: Mapping[str, float] | None) -> list[Misfit]:
    """Lack of fit against the scatter of repeats; the level is shared among the series that have any (Holm 1979)."""
    residuals, _ = left_over(readings, deviations)
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


def _exceeded(readings: Readings, deviations: FloatArray) -> list[Misfit]:
    """Series whose residuals exceed the stated error, by more than chance and by a fifth at least.

    Tested where each series counts by its noise; the ratio in words is that of the result's residuals, which must
    exceed the error as well.
    """
    residuals, basis = left_over(readings, deviations)
    own = [readings.of(index) for index in range(len(readings.observed))]
    found = []
    results = examine_size(residuals, readings.factors, deviations, basis, own)
    for index, (ratio, probability) in enumerate(results):
        if probability < _OTHER_LEVEL and ratio > _ERROR_RATIO:
            moved = np.linalg.norm(readings.scaled[own[index]]) / np.linalg.norm(residuals[own[index]])
            of_result = ratio * float(moved)
            if of_result > _ERROR_RATIO:
                found.append(_misfit(readings, (index, None), "stated_error", probability, of_result))
    return sorted(found, key=lambda misfit: -(misfit.ratio or 0.0))


def _verdict(problem: Problem, readings: Readings, misfits: Sequence[Misfit], *, patterns: bool = True) -> FitVerdict:
    """The verdict from what was found; ``patterns``: whether there were enough readings to look for them."""
    found = tuple(misfit.in_units_of(problem) for misfit in misfits)
    close = closeness_of(problem, [o.series for o in readings.observed], readings.measured)
    if not found:
        looks = "looks like independent noise" if patterns else "is within the stated error; too few readings for more"
        said = f"No lack of fit was found: what the model leaves {looks}."
        return FitVerdict("describes", said, closeness=close)
    kind = _kind(found)
    said = sentence_of(found, close, doubtful=kind == "doubtful")
    return FitVerdict(kind, said, found, remedies_of(problem, found), closeness=close)


def _kind(misfits: Sequence[Misfit]) -> FitKind:
    reasons = {m.reason for m in misfits}
    patterns = [m for m in misfits if m.reason in ("pattern", "repeats", "missed")]
    if patterns and min(m.probability for m in patterns) < _WRONG_LEVEL:
        return "lack_of_fit"
    if "stated_error" in reasons:
        return "lack_of_fit" if patterns else "error_not_met"
    return "doubtful" if patterns else "gross_error"
