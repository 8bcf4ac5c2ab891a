"""Loads of a test in stages: when they are applied, and which stage has a load."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.problem.tables.columns import Table
from geoswarm.solver.problem.tables.headings import Heading
from geoswarm.solver.sentences import Sentence, setting
from geoswarm.solver.units import UnitError, convert

if TYPE_CHECKING:
    from geoswarm.solver.forward.base import ForwardModelSpec
    from geoswarm.solver.problem.observation_section import ObservationSection

__all__ = ["AT_LOAD", "at_load", "by_stage", "same_x_remedy", "section_of_test", "stage_of", "stage_times"]

AT_LOAD: Sentence = (
    setting("repeated_x", "shift"),
    " takes the first as the reading before the load and spreads the others up to the next x; average "
    "takes the mean of several gauges, where every x has a reading of each; or keep one of them",
)
"""Remedy for several readings at the moment of a load."""

_ROUNDING = 1e-9
_SAME_LOAD = 0.005
"""Relative difference of a load in a file, which is rounded, and that of the forward model."""


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


def by_stage(table: Table, section: ObservationSection, spec: ForwardModelSpec | None) -> tuple[Table, Sentence | None]:
    """The table of a series of the ends of stages with their numbers, where its x are the loads of these stages.

    Loads before that of the first stage, as of the state from which it begins, are stage 0 where ``x_from`` leaves
    that out.

    Returns
    -------
    The table, and what is wrong with its loads, if anything is.
    """
    unit = section.x_unit or table.x_heading.unit
    if spec is None or unit is None or not section.series.rpartition(".")[2].startswith("stage_"):
        return table, None
    try:
        loads = np.asarray(convert(table.x, unit, "kPa"), dtype=np.float64)
    except UnitError:
        return table, None
    _, test, _ = section_of_test(spec, section.series)
    stresses = [stage.stress for stage in getattr(test, "stages", ())]
    numbers: list[float] = []
    for place, load in enumerate(loads.tolist(), start=1):
        past = int(numbers[-1]) if numbers else 0
        after = [n for n, stress in enumerate(stresses, 1) if n > past and abs(load - stress) <= _SAME_LOAD * stress]
        before = past == 0 and stresses != [] and load < stresses[0]
        if not after and before and (section.x_from or 0.0) > 0.0:
            after = [0]
        if not after:
            known = ", ".join(f"{stress:g}" for stress in stresses[past:]) or "none"
            which = f"after stage {past} " if past else ""
            found = f"x = {load:.4g} kPa (point {place}) is the load of no stage {which}of the forward model ({known})"
            out: Sentence = (", or leave out what is before them: ", setting("x_from", "1")) if before else ()
            return table, (f"{found}; give the cells of the others, or correct its stages", *out)
        numbers.append(float(after[0]))
    return replace(table, x=numbers, x_heading=Heading(table.x_heading.name), by_load=True), None


def at_load(x: FloatArray, starts: FloatArray) -> BoolArray:
    """Whether each x, shape (m,), is the moment of a load."""
    return np.asarray((np.abs(x[:, np.newaxis] - starts) <= _slack(starts)).any(axis=1))


def same_x_remedy(x: float, starts: FloatArray) -> Sentence:
    """What to do about several readings at one x."""
    at_one = at_load(np.array([x]), starts).any()
    return AT_LOAD if at_one else (setting("repeated_x", "average"), " or shift makes them differ")


def _slack(starts: FloatArray) -> float:
    return _ROUNDING * max(1.0, float(np.abs(starts).max(initial=0.0)))
