"""Which of the measured points take part: from and to an x, late enough after a load, not in stages left out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.errors import Issue
from geoswarm.solver.forward.base import SeriesInfo
from geoswarm.solver.problem.issues import number
from geoswarm.solver.problem.stages import stage_of, stage_times
from geoswarm.solver.sentences import setting
from geoswarm.solver.units import convert

if TYPE_CHECKING:
    from geoswarm.solver.forward.base import ForwardModelSpec
    from geoswarm.solver.problem.observation_section import ObservationSection

__all__ = ["SELECTION", "chosen_points"]

SELECTION = ("x_from", "x_to", "stage_x_from", "leave_out_stages")
"""Fields of an observation that leave points out."""


def chosen_points(
    section: ObservationSection, path: str, x: FloatArray, unit: str | None, info: SeriesInfo, spec: ForwardModelSpec
) -> tuple[BoolArray, BoolArray, list[Issue]]:
    """Whether each point takes part, whether ``stage_x_from`` alone leaves it out, shapes (m,), and what is wrong.

    Parameters
    ----------
    path
        Of the observation, for messages.
    x
        Of all points, shape (m,), base units.
    unit
        Of the data, in which the choice is given; None: the base unit.
    """
    chosen, late = np.ones((2, len(x)), dtype=np.bool_)
    low, high = section.x_from, section.x_to
    if low is not None and high is not None and low > high:
        below = f"{number(high)} is below ", setting(f"{path}.x_from"), f", {number(low)}"
        return chosen, ~late, [Issue.about(f"{path}.x_to", below)]
    if low is not None or high is not None:
        given = x if unit is None else convert(x, info.x_unit, unit)
        slack = 1e-9 * float(np.abs(given).max(initial=0.0))
        chosen &= given >= (-np.inf if low is None else low - slack)
        chosen &= given <= (np.inf if high is None else high + slack)
    staged = "stage_x_from" if section.stage_x_from is not None else "leave_out_stages"
    if section.stage_x_from is not None or section.leave_out_stages:
        starts = stage_times(spec, section.series)
        if info.x_integer and section.stage_x_from is None:
            stages = np.round(x).astype(np.int64)
        elif starts.size:
            stages = stage_of(x, starts)
        else:
            instead = setting(f"{path}.x_from"), " and ", setting(f"{path}.x_to")
            why = f"series '{section.series}' does not run over the time of a test in stages"
            return chosen, ~late, [Issue.about(f"{path}.{staged}", (f"{why}; use ", *instead))]
        if section.stage_x_from is not None:
            since = x - starts[stages - 1]
            least = section.stage_x_from
            if unit is not None:
                zero, moved = convert([0.0, least], unit, info.x_unit)
                least = float(moved - zero)
            late = since >= least * (1.0 - 1e-9)
        chosen &= ~np.isin(stages, section.leave_out_stages)
    early = chosen & ~late
    chosen &= late
    if not chosen.any():
        named = ", ".join(name for name in SELECTION if getattr(section, name))
        return chosen, early, [Issue(f"{path}.{named.split(', ')[0]}", f"{named}: no point is left of {len(x)}")]
    return chosen, early, []
