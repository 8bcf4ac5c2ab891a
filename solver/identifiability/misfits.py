"""Where a model does not describe the data, and by how much, in words; :mod:`.remedies` says what to do about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

from geoswarm.solver.problem import Problem
from geoswarm.solver.units import convert, convert_difference, shown_unit
from geoswarm.solver.words import listed, number, per_cent

__all__ = [
    "DOES_NOT_HOLD",
    "SHORT",
    "Closeness",
    "Misfit",
    "headline_of",
    "in_words",
    "sentence_of",
    "unit_of",
]

_MOST_NAMED = 3

DOES_NOT_HOLD = {
    "lack_of_fit": "the model does not describe the data: the interval does not hold",
    "error_not_met": "the stated error is not met: the interval is too narrow",
}
"""What stands beside an interval, by the kind of the verdict on the fit."""

_HEADLINES = {
    "lack_of_fit": "The model does not describe the data",
    "error_not_met": "The stated error is not met",
    "doubtful": "The fit is doubtful",
}

SHORT = {"lack_of_fit": "model does not fit", "error_not_met": "stated error not met", "doubtful": "fit doubtful"}
"""The kind of the verdict on the fit in the heading of a column."""


@dataclass(frozen=True, slots=True)
class Misfit:
    """One series, or one stage of it, that the model does not describe.

    Parameters
    ----------
    series, stage
        Where; ``stage`` None for the series as a whole, else from 1.
    reason
        ``pattern`` in the residuals, ``repeats`` that scatter less, a ``stated_error`` that is exceeded, ``missed``: a
        constant would be about as close, or ``gross_error``: the other readings of the series exclude this one.
    probability
        Of as much by chance, were the model right; over all parts together.
    deviation
        Root mean square of the residuals of the result [unit]; of one reading, its distance from what the others say.
    largest, x
        The largest of them in size (calculated - measured) [unit] and where [x_unit].
    ratio
        ``deviation`` over the stated error, of one reading over its standard deviation by the others; None without one.
    unit, x_unit
        Those of the data.
    reading
        Number of the one reading, from 1, in the observation; None for a series.
    slip
        What would make it fit if it were multiplied by it: a power of ten, or -1; None where nothing of the kind does.
    """

    series: str
    stage: int | None
    reason: Literal["pattern", "repeats", "stated_error", "missed", "gross_error"]
    probability: float
    deviation: float
    largest: float
    x: float
    ratio: float | None
    unit: str
    x_unit: str
    reading: int | None = None
    slip: float | None = None

    def in_units_of(self, problem: Problem) -> Misfit:
        """The same with the numbers in the units of the data."""
        observation = next(o for o in problem.observations if o.series == self.series)
        info = next(i for i in problem.model.series if i.name == self.series)
        unit, x_unit = unit_of(problem, self.series), observation.x_unit or info.x_unit
        return replace(
            self,
            deviation=convert_difference(self.deviation, info.y_unit, unit),
            largest=convert_difference(self.largest, info.y_unit, unit),
            x=float(convert([self.x], info.x_unit, x_unit)[0]),
            unit=unit,
            x_unit=shown_unit(x_unit),
        )

    @property
    def place(self) -> str:
        """Series and stage in words."""
        return self.series if self.stage is None else f"{self.series}, stage {self.stage}"


@dataclass(frozen=True, slots=True)
class Closeness:
    """How close one quantity comes to its readings, over all series of it.

    Parameters
    ----------
    quantity
        What was measured: ``q``, ``settlement``.
    series
        Number of series.
    largest, deviation
        The largest residual in size, and the root mean square, each series counting alike [unit].
    peak
        Largest relative difference between the largest calculated and the largest measured value of a series; None for
        quantities whose largest value is no strength.
    unit
        Of the data, of the first series; empty for pure numbers.
    """

    quantity: str
    series: int
    largest: float
    deviation: float
    peak: float | None
    unit: str


def unit_of(problem: Problem, series: str) -> str:
    """Unit in which the values of a series were given; empty for pure numbers."""
    observation = next(o for o in problem.observations if o.series == series)
    info = next(i for i in problem.model.series if i.name == series)
    return shown_unit(observation.y_unit or info.y_unit)


def headline_of(kind: str, misfits: Sequence[Misfit]) -> str:
    """What stands above all results, by the kind of the verdict on the fit; empty where nothing has to."""
    if kind == "gross_error":
        several = len(misfits) > 1
        return f"{len(misfits)} readings do not fit the others" if several else "One reading does not fit the others"
    return _HEADLINES.get(kind, "")


def sentence_of(
    misfits: Sequence[Misfit], closeness: Sequence[Closeness] = (), *, doubtful: bool = False, tests: int = 0
) -> str:
    """Say where and by how much.

    Parameters
    ----------
    closeness
        Of all readings, said where more series are missed than can be named.
    doubtful
        Patterns that a right model leaves now and then.
    tests
        That count as one piece of information each in the intervals; 0: intervals do not hold.
    """
    gross = [m for m in misfits if m.reason == "gross_error"]
    patterns = _patterns_of(misfits)
    exceeded = [m for m in misfits if m.reason == "stated_error"]
    parts = [_excluded(m) for m in gross[:_MOST_NAMED]]
    if len(gross) > len(parts):
        parts.append(f"So do {len(gross) - len(parts)} more: see the table.")
    series = list(dict.fromkeys(m.series for m in patterns))
    if patterns and doubtful:
        once = round(1.0 / min(m.probability for m in patterns))
        parts.append(
            f"The fit of {listed(series)} is doubtful: a correct model fits this badly in one of {once} sets of "
            f"readings. {'It misses' if len(series) == 1 else 'They are missed:'} "
            f"{'; '.join(_how_far([m for m in patterns if m.series == name], name) for name in series[:_MOST_NAMED])}."
        )
    elif patterns:
        if len(series) > _MOST_NAMED and closeness:
            parts.append(f"The model does not describe {len(series)} series: {_reason(patterns)}.")
            parts.append(f"Over all readings, {in_words(closeness)}.")
        else:
            parts.append(f"The model does not describe {listed(series)}{_of_each(patterns, series)}")
        hold = f"their intervals {_counted(tests)}" if tests else "their intervals do not hold"
        parts.append(f"The parameters are those of the closest curve, and {hold}.")
    if exceeded:
        parts.append(_too_small(exceeded, 0 if patterns else tests))
    return " ".join(parts)


def in_words(closeness: Sequence[Closeness]) -> str:
    """How close each quantity comes: ``q is met within 12 kPa (root mean square 3 kPa, peaks within 4 %) and ...``."""
    return listed([_within(one) for one in closeness])


def _within(one: Closeness) -> str:
    peak = "" if one.peak is None else f", peaks within {per_cent(one.peak)}"
    mean = _amount(one.deviation, one.unit)
    return f"{one.quantity} is met within {_amount(one.largest, one.unit)} (root mean square {mean}{peak})"


def _counted(tests: int) -> str:
    return f"count each of the {tests} tests as one piece of information"


def _patterns_of(misfits: Sequence[Misfit]) -> list[Misfit]:
    """Series and stages that the model misses as a whole."""
    return [m for m in misfits if m.reason not in ("stated_error", "gross_error")]


def _place(m: Misfit) -> str:
    x = number(m.x, plain=True)
    return f"{x} {m.x_unit}" if m.x_unit else f"x = {x}"


def _excluded(m: Misfit) -> str:
    """One reading that the others exclude."""
    at = _place(m)
    side = "above" if m.largest < 0 else "below"
    found = (
        f"Reading {m.reading} of {m.series} (at {at}) lies {m.ratio or 0.0:.2g} standard deviations "
        f"({_amount(m.deviation, m.unit)}) {side} what the others say"
    )
    if m.slip is None:
        return f"{found}."
    if m.slip < 0:
        return f"{found}; with the other sign it would fit."
    factor = max(m.slip, 1.0 / m.slip)
    size = "smaller" if m.slip < 1 else "larger"
    return f"{found}; {factor:.0f} times {size} it would fit: a slip of the decimal point?"


def _of_each(patterns: Sequence[Misfit], series: Sequence[str]) -> str:
    """How far the first series are missed, and how likely noise is to do the same."""
    named = {name: [m for m in patterns if m.series == name] for name in series[:_MOST_NAMED]}
    reasons = {name: _reason(misfits) for name, misfits in named.items()}
    if len(series) == 1:
        return f": it misses {_how_far(named[series[0]], '')}; {reasons[series[0]]}."
    once = len(set(reasons.values())) == 1
    each = [f"{_how_far(misfits, name)}{'' if once else f'; {reasons[name]}'}" for name, misfits in named.items()]
    left = len(series) - len(named)
    others = f"; and {left} {'others' if left > 1 else 'other'}" if left else ""
    end = f"; of each, {reasons[series[0]]}" if once else ""
    return f". It misses {'; '.join(each)}{others}{end}."


def _how_far(misfits: Sequence[Misfit], name: str) -> str:
    """One series (without a name the only one): its stages, the largest residual and its place."""
    whole = next((m for m in misfits if m.stage is None), None)
    worst = max(misfits, key=lambda m: abs(m.largest))
    stages = sorted(m.stage for m in misfits if m.stage is not None)
    places = name or "the readings"
    if stages:
        staged = f"stage{'s' if len(stages) > 1 else ''} {listed(_spans(stages))}"
        places = f"{name} in {staged}" if name else staged
    side = "above" if worst.largest > 0 else "below"
    rest = "" if whole is None else f", root mean square {_amount(whole.deviation, whole.unit)}"
    at = _place(worst)
    return f"{places} by up to {_amount(abs(worst.largest), worst.unit)} (calculated {side} measured, near {at}){rest}"


def _reason(misfits: Sequence[Misfit]) -> str:
    """Why this is no noise."""
    if all(m.reason == "missed" for m in misfits):
        return "a constant would be about as close, and parameters are at their bounds"
    if all(m.reason == "repeats" for m in misfits):
        return "more than the scatter of repeats explains"
    least = min(m.probability for m in misfits)
    return f"noise has such a pattern with a probability {'below 0.2 %' if least <= 0.002 else f'of {per_cent(least)}'}"


def _too_small(exceeded: Sequence[Misfit], tests: int) -> str:
    """Stated errors that the residuals exceed."""
    each = [
        f"of {m.series} ({_amount(m.deviation, m.unit)}) {'' if place else 'are '}{m.ratio or 0.0:.2g} times"
        for place, m in enumerate(exceeded[:_MOST_NAMED])
    ]
    several = len(exceeded) > 1
    left = len(exceeded) - len(each)
    others = f" ({left} more: see the table)" if left else ""
    rest = f"intervals that rest on {'them' if several else 'it'} are about as many times too narrow"
    return (
        f"{'Stated errors are' if several else 'The stated error is'} not met: the residuals {listed(each)} as large"
        f"{others}, so {f'intervals {_counted(tests)}' if tests else rest}."
    )


def _spans(numbers: Sequence[int]) -> list[str]:
    """Numbers in words, three or more in a row as "2 to 6"."""
    groups: list[list[int]] = []
    for one in numbers:
        if groups and one == groups[-1][-1] + 1:
            groups[-1].append(one)
        else:
            groups.append([one])
    return [
        word
        for group in groups
        for word in ([f"{group[0]} to {group[-1]}"] if len(group) > 2 else [str(one) for one in group])
    ]


def _amount(value: float, unit: str) -> str:
    return f"{number(value, 2, plain=True)} {unit}".strip()
