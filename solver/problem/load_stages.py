"""The load stages of a test, from a column of loads beside the readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.problem.issues import number, validated
from geoswarm.solver.problem.observation_section import ObservationSection
from geoswarm.solver.problem.points import columns_of
from geoswarm.solver.problem.readings.units import unit_of_data
from geoswarm.solver.problem.tables.columns import table_of
from geoswarm.solver.problem.tables.headings import Heading
from geoswarm.solver.problem.tables.reading import TableError
from geoswarm.solver.problem.text.reading import read_document
from geoswarm.solver.units import UnitError, convert

__all__ = ["LoadStage", "LoadStages", "in_base_unit", "measured_stages"]

_MOST = 200
_LOAD = "load"


@dataclass(frozen=True, slots=True)
class LoadStage:
    """A stress [kPa] and the days for which it acts, as stages of a forward model; ``load`` as the file has it."""

    stress: float
    duration: float
    load: float


@dataclass(frozen=True, slots=True)
class LoadStages:
    """Stages of a test, the first of which begins at x = 0.

    ``initial_stress`` [kPa] is the load that the first reading alone has. ``elapsed``: x begins anew in every stage, so
    that readings need ``blocks`` with their stage.
    """

    stages: tuple[LoadStage, ...]
    initial_stress: float | None
    elapsed: bool


def measured_stages(
    observation: str, content: bytes, name: str, load_column: str, load_unit: str | None = None
) -> LoadStages:
    """Stages from a column of loads, each of which is constant over the readings of its stage.

    A load is applied at the last reading under the one before; at the first reading under it if that is the nearer one
    to the readings that follow.

    Parameters
    ----------
    observation
        Where x is, as JSON, as for the points of the file; x must be a time.
    content, name
        The file, and what it is called in messages.
    load_column, load_unit
        The column and, where its heading does not name it, the unit of the loads.

    Raises
    ------
    ProblemError
        The file cannot be read so, a unit is missing, or the column does not hold loads of stages.
    """
    given = {"series": _LOAD, **read_document(observation, "json"), "file": name, "y_column": load_column}
    section, issues = validated(ObservationSection, {key: given[key] for key in given if key != "y_minus"}, "")
    if section is None:
        raise ProblemError(issues)
    try:
        table = table_of(content, name, columns_of(section))
    except TableError as error:
        raise ProblemError(error.issues()) from None
    days = section.x_factor * in_base_unit("x", table.x, section.x_unit, "day", table.x_heading)
    loads = in_base_unit("load", table.y, load_unit, "kPa", table.y_heading)
    return _stages(days, loads, table.y, load_column)


def in_base_unit(
    axis: str, values: Sequence[float], given: str | None, base: str, heading: Heading | None
) -> FloatArray:
    """Values of an axis (x, y, load) in a base unit, from the unit given or that of their heading.

    Raises
    ------
    ProblemError
        The unit is unknown, missing or of another quantity; its path is ``AXIS_unit`` or ``AXIS_column``.
    """
    unit, wrong = unit_of_data(axis, given, base, heading, unitless=False)
    try:
        if wrong is None:
            return np.asarray(convert(values, unit or base, base), dtype=np.float64)
    except UnitError as error:
        wrong = (str(error),)
    raise ProblemError([Issue.about(f"{axis}_unit" if given else f"{axis}_column", wrong)])


def _stages(days: FloatArray, loads: FloatArray, given: Sequence[float], column: str) -> LoadStages:
    begins = [0, *(np.flatnonzero(np.diff(loads) != 0.0) + 1).tolist()]
    ends = [*(place - 1 for place in begins[1:]), len(loads) - 1]
    initial = None
    if len(begins) > 1 and ends[0] == 0 and days[0] <= 0.0:  # the reading before the first load
        initial, begins, ends = float(loads[0]), begins[1:], ends[1:]
    if len(begins) * 2 > len(loads) or len(begins) > _MOST:
        what = f"changes {len(begins) - 1} times over {len(loads)} readings"
        raise _refused(f"column '{column}' {what}; loads are constant over the readings of a stage, of at most {_MOST}")
    if (loads[begins] <= 0.0).any():
        raise _refused(f"column '{column}' has the load {number(float(loads[begins].min()))} kPa; stresses are above 0")
    steps = np.diff(days)
    again = [bool(steps[place - 1] < 0.0) for place in begins[1:]]
    inside = np.delete(steps, [place - 1 for place in begins[1:]])
    if (inside < 0.0).any() or (any(again) and not all(again)):
        raise _refused("x falls from one reading to the next; put the rows in order of time first")
    if any(again):
        durations = [float(days[end]) for end in ends]
    else:
        moments = [0.0, *(_moment(days, place) for place in begins[1:]), float(days[-1])]
        durations = np.diff(moments).tolist()
    if min(durations) <= 0.0:
        raise _refused("a stage would last no time; x counts from the load of the first stage, or of each")
    found = tuple(
        LoadStage(float(loads[begin]), float(f"{duration:.12g}"), given[begin])
        for begin, duration in zip(begins, durations, strict=True)
    )
    return LoadStages(found, initial, any(again))


def _moment(days: FloatArray, place: int) -> float:
    """When the load that the reading at ``place`` is the first to have was applied."""
    last, first = float(days[place - 1]), float(days[place])
    following = float(days[place + 1]) if place + 1 < len(days) else np.inf
    return last if first - last <= following - first else first


def _refused(message: str) -> ProblemError:
    return ProblemError([Issue("load_column", message)])
