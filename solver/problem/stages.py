"""When the loads of a test in stages are applied, for what runs over the time of such a test."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.sentences import Sentence, setting

if TYPE_CHECKING:
    from geoswarm.solver.forward.base import ForwardModelSpec

__all__ = ["AT_LOAD", "at_load", "same_x_remedy", "section_of_test", "stage_of", "stage_times"]

AT_LOAD: Sentence = (
    setting("repeated_x", "shift"),
    " takes the first as the reading before the load and spreads the others up to the next x; average "
    "takes the mean of several gauges, where every x has a reading of each; or keep one of them",
)
"""Remedy for several readings at the moment of a load."""

_ROUNDING = 1e-9


def section_of_test(spec: ForwardModelSpec, series: str) -> tuple[str, ForwardModelSpec, str]:
    """Return path and section of the test that a series belongs to, and the name of the series there."""
    parts: Any = getattr(spec, "parts", None)
    part, dot, inner = series.partition(".")
    if dot and parts and part in parts:
        return f"forward_model.parts.{part}", parts[part], inner
    return "forward_model", spec, series


def stage_times(spec: ForwardModelSpec, series: str) -> FloatArray:
    """Return the times [day] at which loads are applied, shape (k,), where a series runs over the time of such a test.

    Empty for every other series. Times count from the series' zero; that of the first stage is negative where
    ``zero_at_stage`` is a later one.
    """
    _, test, series = section_of_test(spec, series)
    stages: Any = getattr(test, "stages", ())
    if not stages or not hasattr(stages[0], "stress") or series.startswith(("stage_", "branch_")):
        return np.empty(0)
    durations = np.array([stage.duration for stage in stages], dtype=np.float64)
    starts = np.concatenate([[0.0], np.cumsum(durations)[:-1]])
    return np.asarray(starts - starts[getattr(test, "zero_at_stage", 1) - 1], dtype=np.float64)


def stage_of(x: FloatArray, starts: FloatArray) -> IntArray:
    """Number of the stage, from 1, that each x, shape (m,), belongs to; a reading at a load ends the stage before."""
    return np.maximum(np.searchsorted(starts + _slack(starts), x, side="left"), 1).astype(np.int64)


def at_load(x: FloatArray, starts: FloatArray) -> BoolArray:
    """Whether each x, shape (m,), is the moment of a load."""
    return np.asarray((np.abs(x[:, np.newaxis] - starts) <= _slack(starts)).any(axis=1))


def same_x_remedy(x: float, starts: FloatArray) -> Sentence:
    """What to do about several readings at one x."""
    at_one = at_load(np.array([x]), starts).any()
    return AT_LOAD if at_one else (setting("repeated_x", "average"), " or shift makes them differ")


def _slack(starts: FloatArray) -> float:
    return _ROUNDING * max(1.0, float(np.abs(starts).max(initial=0.0)))
