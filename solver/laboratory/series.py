"""Series of shear tests: each quantity over strain, over time, over stages and cycles, and over a stress."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.trace import Sample
from geoswarm.solver.forward.base import SeriesInfo
from geoswarm.solver.laboratory.quantities import Quantity, Seen
from geoswarm.solver.laboratory.record import Record
from geoswarm.solver.laboratory.shear_stages import Axes

__all__ = [
    "Axis",
    "TestSeries",
    "after_consolidation",
    "at_cycles",
    "at_stages",
    "at_times",
    "in_cycles",
    "where_strain",
    "where_stress",
]

Look: TypeAlias = Callable[[Sample], FloatArray]
"""A quantity of states."""

Pick: TypeAlias = Callable[[Record, FloatArray], Callable[[Look], FloatArray]]
"""(test, x (m,)) -> quantity -> its values (m,)."""


@dataclass(frozen=True)
class Axis:
    """What a series runs over: prefix of its name, end of its description, x, and how values are picked."""

    prefix: str
    words: str
    x_quantity: str
    x_unit: str
    pick: Pick
    grid: FloatArray
    x_lower: float | None = None
    x_upper: float | None = None
    x_integer: bool = False
    shearing: bool = True
    """Whether shearing has to be calculated."""
    dense: bool = True
    """Whether values between the ends of steps are needed."""


@dataclass(frozen=True)
class TestSeries:
    """A quantity over an axis."""

    axis: Axis
    quantity: Quantity

    @property
    def info(self) -> SeriesInfo:
        """As users see it."""
        axis, one = self.axis, self.quantity
        return SeriesInfo(
            f"{axis.prefix}{one.name}",
            f"{one.description.rstrip('.')}, {axis.words}.",
            axis.x_quantity,
            axis.x_unit,
            one.quantity,
            one.unit,
            axis.x_lower,
            axis.x_upper,
            axis.x_integer,
            x_increasing=False,
        )

    def values(self, test: Record, picked: Callable[[Look], FloatArray]) -> FloatArray:
        """Values at what the axis has picked from a test."""
        consolidating = not self.axis.shearing

        def look(sample: Sample) -> FloatArray:
            reference = test.initial if consolidating else test.reference
            excess = np.zeros(len(sample.rows)) if consolidating else test.excess(sample)
            pore = test.back_pressure + excess
            return self.quantity.of(Seen(sample.rows, reference, pore, test.components, test.voids))

        with np.errstate(divide="ignore", invalid="ignore"):
            return picked(look)


def _states(sample: Sample) -> Callable[[Look], FloatArray]:
    return lambda look: look(sample)


def at_times(test: Record, x: FloatArray) -> Callable[[Look], FloatArray]:
    """States at times since the beginning of shearing, day; later than its end those at the end."""
    return _states(test.trace.at_times(x))


def at_stages(test: Record, x: FloatArray) -> Callable[[Look], FloatArray]:
    """States at the ends of stages of shearing, by their number from 1."""
    return _states(test.trace.ends(test.last_legs[x.astype(np.int64) - 1]))


def after_consolidation(test: Record, x: FloatArray) -> Callable[[Look], FloatArray]:
    """States at the ends of stages of consolidation, by their number from 1."""
    return _states(Sample(test.consolidation[x.astype(np.int64) - 1], np.zeros(x.size, dtype=np.int64)))


def at_cycles(test: Record, x: FloatArray) -> Callable[[Look], FloatArray]:
    """States at the ends of cycles, by their number from 1."""
    return _states(test.trace.ends(test.cycles[x.astype(np.int64) - 1, 1]))


def in_cycles(largest: bool) -> Pick:
    """Largest or smallest value in cycles, their beginning included, by their number from 1."""

    def pick(test: Record, x: FloatArray) -> Callable[[Look], FloatArray]:
        everywhere = test.trace.everywhere
        cycles = test.cycles[x.astype(np.int64) - 1]
        first = np.maximum(np.searchsorted(everywhere.load_path, cycles[:, 0], side="left") - 1, 0)
        last = np.searchsorted(everywhere.load_path, cycles[:, 1], side="right")
        parts = list(zip(first.tolist(), last.tolist(), strict=True))

        def extremes(look: Look) -> FloatArray:
            values = look(everywhere)
            return np.array([values[low:high].max() if largest else values[low:high].min() for low, high in parts])

        return extremes

    return pick


def where_strain(axes: Axes, stage: int | None = None) -> Pick:
    """States where the strain led is first reached, in all stages or in one (0-based)."""

    def pick(test: Record, x: FloatArray) -> Callable[[Look], FloatArray]:
        n = test.components
        functional = np.zeros(test.initial.size)
        functional[n : 2 * n] = axes.strain
        return _states(
            test.trace.where_first(functional, axes.inner(x) + functional @ test.reference, _legs(test, stage))
        )

    return pick


def where_stress(combination: FloatArray) -> Pick:
    """States where a combination (n,) of stress is first reached."""

    def pick(test: Record, x: FloatArray) -> Callable[[Look], FloatArray]:
        functional = np.zeros(test.initial.size)
        functional[: combination.size] = combination
        return _states(test.trace.where_first(functional, x))

    return pick


def _legs(test: Record, stage: int | None) -> range | None:
    if stage is None:
        return None
    ends = [-1, *test.last_legs.tolist()]
    return range(ends[stage] + 1, ends[stage + 1] + 1)
