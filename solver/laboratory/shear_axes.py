"""What the series of shear tests run over: the strain led, time, stages, cycles, a stress, stages of consolidation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.laboratory.quantities import Quantity
from geoswarm.solver.laboratory.series import (
    Axis,
    TestSeries,
    after_consolidation,
    at_cycles,
    at_stages,
    at_times,
    in_cycles,
    where_strain,
    where_stress,
)
from geoswarm.solver.laboratory.shear_stages import Axes, ShearStage

__all__ = ["path_series", "shear_series"]

_CURVE_POINTS = 100
_MOST_POINTS = 4000
_NOTHING = np.empty(0)


def shear_series(
    axes: Axes,
    stages: Sequence[ShearStage],
    consolidation: int,
    strain: str,
    shearing: Sequence[Quantity],
    over_strain: Sequence[Quantity],
    consolidating: Sequence[Quantity],
    whole: str = "shearing",
) -> Iterator[TestSeries]:
    """All series of a test but those over a stress.

    Parameters
    ----------
    consolidation
        Number of stages of consolidation.
    strain
        The strain led, in words; series over it have no prefix.
    shearing, over_strain, consolidating
        What is measured while the specimen is sheared, over the strain alone, and while it is consolidated.
    whole
        What consists of the stages, in words.
    """
    known = _strains(stages)
    for axis in _strain_axes(axes, stages, strain, known, whole):
        yield from (TestSeries(axis, one) for one in [*shearing, *over_strain] if one.name != strain.replace(" ", "_"))
    for axis in _other_axes(stages, whole):
        yield from (TestSeries(axis, one) for one in shearing)
    if consolidation:
        axis = Axis(
            "consolidation_",
            "at the end of a stage of consolidation",
            "stage",
            "",
            after_consolidation,
            np.arange(1.0, consolidation + 1.0),
            1.0,
            float(consolidation),
            x_integer=True,
            shearing=False,
            dense=False,
        )
        yield from (TestSeries(axis, one) for one in consolidating)


def path_series(stress: str, combination: FloatArray, quantity: Quantity, whole: str = "shearing") -> TestSeries:
    """A stress path: a quantity over the stress that a combination (n,) gives."""
    words = f"where the {stress} is first reached in {whole}"
    return TestSeries(Axis("path_", words, stress, "kPa", where_stress(combination), _NOTHING), quantity)


def _strain_axes(
    axes: Axes, stages: Sequence[ShearStage], strain: str, known: Sequence[float | None], whole: str
) -> Iterator[Axis]:
    ends = [value for value in known if value is not None]
    sure = len(ends) == len(known) and not any(stage.in_cycle for stage in stages)
    low, high = (min(ends), max(ends)) if sure else (None, None)
    words = f"where the {strain} is first reached"
    grid = _between(known[0], ends) if sure else _NOTHING
    yield Axis("", words, strain, "", where_strain(axes), grid, low, high)
    movements = [number for number, stage in enumerate(stages) if not stage.hold and not stage.in_cycle]
    if len(stages) == 1:
        return
    for number in movements:
        first, last = known[number], known[number + 1]
        low, high, grid = None, None, _NOTHING
        if first is not None and last is not None:
            low, high = min(first, last), max(first, last)
            grid = np.linspace(low, high, _CURVE_POINTS)
        words = f"where the {strain} is first reached in stage {number + 1} of {whole}"
        pick = where_strain(axes, number)
        yield Axis(f"branch_{number + 1}.", words, strain, "", pick, grid, low, high)


def _strains(stages: Sequence[ShearStage]) -> list[float | None]:
    """Strain at the beginning of shearing and at the end of each stage; None where it depends on the soil."""
    known: list[float | None] = [0.0]
    for stage in stages:
        last = known[-1]
        if stage.control == "stress":
            known.append(None)
        elif stage.relative:
            known.append(None if last is None else last + stage.targets[-1])
        else:
            known.append(stage.targets[-1])
    return known


def _between(first: float | None, ends: Sequence[float]) -> FloatArray:
    low, high = min(ends), max(ends)
    start = 0.0 if first is None else first
    near = np.geomspace(1.0e-4, 1.0, _CURVE_POINTS // 2)
    parts = [start + (end - start) * near for end in (low, high) if end != start]
    return np.unique(np.concatenate([[start], *parts, np.linspace(low, high, _CURVE_POINTS)]))


def _other_axes(stages: Sequence[ShearStage], whole: str) -> Iterator[Axis]:
    durations = [duration for stage in stages for duration in stage.durations or ()]
    sure = all(stage.durations is not None for stage in stages)
    grid, end = _NOTHING, None
    if sure:
        ends = np.cumsum([0.0, *durations])
        end = float(ends[-1])
        pieces = max(2, min(_CURVE_POINTS, _MOST_POINTS // len(durations)))
        load_path = np.unique(np.concatenate([np.geomspace(1.0e-4, 1.0, pieces // 2), np.linspace(0.0, 1.0, pieces)]))
        grid = np.unique(np.concatenate([a + (b - a) * load_path for a, b in pairwise(ends.tolist())]))
    words = f"over the time since the beginning of {whole}"
    yield Axis("time_", words, "time", "day", at_times, grid, 0.0, end)
    numbers = np.arange(1.0, len(stages) + 1.0)
    words = f"at the end of a stage of {whole}"
    yield Axis("stage_", words, "stage", "", at_stages, numbers, 1.0, numbers[-1], x_integer=True, dense=False)
    count = sum(len(stage.targets) // stage.in_cycle for stage in stages if stage.in_cycle)
    if not count:
        return
    numbers = np.arange(1.0, count + 1.0)
    for prefix, words, pick, dense in (
        ("cycle_", "at the end of a cycle", at_cycles, False),
        ("cycle_max_", "the largest value in a cycle", in_cycles(True), True),
        ("cycle_min_", "the smallest value in a cycle", in_cycles(False), True),
    ):
        yield Axis(prefix, words, "cycle", "", pick, numbers, 1.0, float(count), x_integer=True, dense=dense)
