"""Stages of loading of a consolidating column: what is done to it, when, and at which times it is looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.element_test.column import BY_LOAD
from geoswarm.solver.element_test.consolidation import Movement

__all__ = ["LATE", "LoadStages", "within"]

LATE = 1.0 + 1.0e-9
"""A reading may be later than an end by this factor: times have been converted."""
_CURVE_POINTS = 24


class Stage(Protocol):
    """A load, kPa, and its times, day."""

    @property
    def stress(self) -> float:
        """At its end."""

    @property
    def duration(self) -> float:
        """Of all."""

    @property
    def loading_time(self) -> float:
        """In which it grows; 0: at once."""


@dataclass(frozen=True)
class LoadStages:
    """Stages of loading, the load before them, kPa, and the stage (from 1) before which time is zero."""

    stages: Sequence[Stage]
    initial: float
    zero_at_stage: int

    @cached_property
    def movements(self) -> tuple[Movement, ...]:
        """Changes of the load since the beginning, and times under it."""
        return tuple(movement for _, movement in self._numbered)

    @cached_property
    def last(self) -> IntArray:
        """Number of the last movement of each stage, from 0."""
        numbers = np.array([number for number, _ in self._numbered])
        return np.flatnonzero(np.diff(np.append(numbers, len(self.stages))))

    @cached_property
    def _numbered(self) -> list[tuple[int, Movement]]:
        found: list[tuple[int, Movement]] = []
        before = 0.0
        for number, stage in enumerate(self.stages):
            name, load = f"{number + 1} ({stage.stress:g} kPa)", stage.stress - self.initial
            found.append((number, Movement(name, BY_LOAD, before, load, stage.loading_time)))
            if stage.loading_time < stage.duration:
                rest = stage.duration - stage.loading_time
                found.append((number, Movement(name, BY_LOAD, load, load, rest)))
            before = load
        return found

    @cached_property
    def ends(self) -> FloatArray:
        """Times of the ends of stages since the first one, day, (s + 1,); 0 before them."""
        return np.cumsum([0.0, *(stage.duration for stage in self.stages)])

    @property
    def zero(self) -> float:
        """Time from the first stage to the zero of time, day."""
        return float(self.ends[self.zero_at_stage - 1])

    @property
    def end(self) -> float:
        """Time of the end since the zero of time, day."""
        return float(self.ends[-1]) - self.zero

    @property
    def since(self) -> str:
        """What the zero of time is, in words."""
        return "the first load began" if self.zero_at_stage == 1 else f"stage {self.zero_at_stage} began"

    @cached_property
    def grid(self) -> FloatArray:
        """Times since its zero at which curves look smooth, day."""
        pieces = [np.zeros(1)]
        for start, stage in list(zip(self.ends, self.stages, strict=False))[self.zero_at_stage - 1 :]:
            parts = [within(stage.duration)]
            if 0.0 < stage.loading_time < stage.duration:
                rest = stage.duration - stage.loading_time
                parts = [
                    np.linspace(0.0, stage.loading_time, _CURVE_POINTS // 2)[1:],
                    stage.loading_time + within(rest),
                ]
            pieces += [start - self.zero + part for part in parts]
        return np.concatenate(pieces)


def within(duration: float) -> FloatArray:
    """Times at which a stage of consolidation looks smooth, day."""
    times: FloatArray = duration * np.geomspace(1.0e-5, 1.0, _CURVE_POINTS)
    return times
