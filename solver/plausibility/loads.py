"""Loads of a test in stages that the readings do not show: stages without readings, and loads without a step.

A virgin load (more than any before) compresses a soil faster at once. It counts as not shown where the readings early
in its stage lie no further from those late in the stage before than creep alone would have brought them.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.plausibility.staged import StagedReadings, staged_readings
from geoswarm.solver.problem import Problem
from geoswarm.solver.sentences import Sentence, setting
from geoswarm.solver.units import convert

__all__ = ["ends_early_in", "loads_not_shown"]

_GROWTH, _PART = 1.5, 0.05
"""Increases of stress that must be seen: over the stress before, and over the largest one of the test."""
_EARLY, _LATE = 0.3, 0.5
"""First part of a stage (or its first reading) and last part of the one before (or its last two) are compared."""
_STEP = 0.05
"""Least step, over the one that the range of all readings and the increase of ln(stress) let expect."""
_BACK = 0.05
"""Movement against the load, over the range of all readings."""
_AGREES = 0.1
_TIME_UNITS = ("s", "min", "h", "day")


def loads_not_shown(problem: Problem) -> Iterator[Sentence]:
    """Stages without a reading, and virgin loads at which the readings show no step or go the other way."""
    for readings in staged_readings(problem):
        if not readings.by_stage:
            yield from _unread(readings)
        if readings.drains_at_once:
            yield from _steps(readings)


def ends_early_in(readings: StagedReadings) -> tuple[str, str | None] | None:
    """Say that times end before the last stages begin, and the unit in which they would not; None where they do not."""
    missing, stages = _missing(readings), len(readings.spec.stages)
    last = int(readings.stages.max())
    if readings.by_stage or not missing or missing[0] <= last or len(missing) != stages - last:
        return None
    end = float(convert(readings.x[-1], "day", readings.x_unit))
    whole = float(sum(stage.duration for stage in readings.spec.stages[readings.spec.zero_at_stage - 1 :]))
    seen = (
        f"the readings end at {end:g} {readings.x_unit}, in stage {last} of {stages}, which end after "
        f"{float(convert(whole, 'day', readings.x_unit)):g} {readings.x_unit}"
    )
    return seen, _time_unit(readings, whole)


def _missing(readings: StagedReadings) -> list[int]:
    """Stages without a reading."""
    wanted = range(readings.spec.zero_at_stage, len(readings.spec.stages) + 1)
    return sorted(set(wanted) - set(readings.stages.astype(int).tolist()) - _left_out(readings))


def _unread(readings: StagedReadings) -> Iterator[Sentence]:
    missing = _missing(readings)
    if not missing:
        return
    ends = ends_early_in(readings)
    if ends is not None and ends[1] is None:
        unit = setting(f"{readings.path}.x_unit")
        yield (
            *(readings.title, f": {ends[0]}; check ", unit, f" (now {readings.x_unit}) and "),
            *(readings.key("stages[].duration"), " (day), or leave out the stages without readings"),
        )
    elif ends is None:
        yield (
            *(readings.title, f": there is no reading in {_named(missing)} of {len(readings.spec.stages)}; check "),
            *(readings.key("stages"), " against the record of the test"),
        )


def _left_out(readings: StagedReadings) -> set[int]:
    return set(readings.observation.selection.get("leave_out_stages") or ())


def _time_unit(readings: StagedReadings, whole: float) -> str | None:
    """Unit of time in which the last reading would be at the end of the test."""
    end = float(convert(readings.x[-1], "day", readings.x_unit))
    for unit in _TIME_UNITS:
        if unit != readings.x_unit and abs(float(convert(end, unit, "day")) / whole - 1.0) <= _AGREES:
            return unit
    return None


def _steps(readings: StagedReadings) -> Iterator[Sentence]:
    stresses = readings.stresses
    span = float(np.ptp(readings.y))
    if span == 0.0:
        if readings.y.size > 1:
            yield readings.title, f": all readings are {readings.in_data(float(readings.y[0]))}; check the column"
        return
    downwards = -1.0 if readings.quantity == "void_ratio" else 1.0
    whole = float(np.log(stresses[1:].max() / stresses[0]))
    missed, backwards = [], []
    for number in range(readings.spec.zero_at_stage + 1, len(stresses)):
        past = float(stresses[:number].max())
        if stresses[number] < max(_GROWTH * past, past + _PART * float(stresses.max())):
            continue
        found = _movement(readings, number)
        if found is None:
            continue
        step, creep = downwards * found[0], downwards * found[1]
        expected = _STEP * span * float(np.log(stresses[number] / past)) / whole
        if step < -_BACK * span:
            backwards.append(number)
        elif step <= max(creep, 0.0) + expected:
            missed.append(number)
    if backwards:
        yield (
            readings.title,
            f": the readings go back at {_loads(readings, backwards)}, where the stress rises; check ",
            readings.key("stages"),
            " against the record of the test, and the sign of the readings",
        )
    if missed:
        yield (
            readings.title,
            f": the readings show no step at {_loads(readings, missed)}; check stress and duration of ",
            *(readings.key("stages"), " and ", readings.key("zero_at_stage", short=True)),
            " against the record of the test, and ",
            *(setting(f"{readings.path}.x_unit"), f", now {readings.x_unit or 'stage'}"),
        )


def _movement(readings: StagedReadings, number: int) -> tuple[float, float] | None:
    """Movement across the application of a load and, for comparison, by creep before it; None with too few readings."""
    before, within = readings.stages == number - 1, readings.stages == number
    if readings.by_stage:
        if not (before.any() and within.any()):
            return None
        return float(readings.y[within][0] - readings.y[before][0]), 0.0
    durations = np.array([stage.duration for stage in readings.spec.stages])
    first = readings.spec.zero_at_stage - 1
    start = float(durations[first : number - 1].sum())
    last = readings.y[before & (readings.x >= start - _LATE * durations[number - 2])]
    late = readings.y[before][-2:] if last.size < 2 else last
    soon = readings.y[within & (readings.x <= start + _EARLY * durations[number - 1])]
    early = readings.y[within][:1] if soon.size == 0 else soon
    if not (early.size and late.size):
        return None
    return float(early.mean() - late.mean()), _ends(late)


def _ends(y: FloatArray) -> float:
    """Movement from the first third to the last third of some readings: noise does not count much."""
    third = max(1, y.size // 3)
    return float(y[-third:].mean() - y[:third].mean())


def _loads(readings: StagedReadings, numbers: list[int]) -> str:
    stresses = ", ".join(f"{readings.stresses[n - 1]:g} to {readings.stresses[n]:g}" for n in numbers)
    return f"the load{'s' if len(numbers) > 1 else ''} of {_named(numbers)} ({stresses} kPa)"


def _named(numbers: list[int]) -> str:
    return f"stage{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))}"
