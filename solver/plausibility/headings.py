"""Units of the problem file against those that the headings of the data name."""

from __future__ import annotations

from collections.abc import Iterator

from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.tables.headings import Heading, known_unit
from geoswarm.solver.sentences import Key, Sentence, setting
from geoswarm.solver.units import UnitError, convert, same_unit

__all__ = ["contradicted_headings"]


def contradicted_headings(problem: Problem) -> Iterator[Sentence]:
    """Columns whose headings name another unit than ``x_unit`` and ``y_unit`` say."""
    for index, one in enumerate(problem.observations):
        axes = (("x", one.x_unit, one.points.x_heading), ("y", one.y_unit, one.points.y_heading))
        for axis, unit, heading in axes:
            if unit is None or heading is None or heading.unit is None or heading.dates:
                continue
            if not _same(unit, heading):
                path = f"observations[{index}].{axis}_unit"
                yield (
                    Key(path, path),
                    f" = {unit}, but according to its heading column '{heading.name}' is in {heading.unit}; ",
                    setting(path),
                    f" holds: leave it out for {heading.unit}, or correct the heading",
                )


def _same(unit: str, heading: Heading) -> bool:
    """Whether two names mean one unit; what follows a dash or "in" without brackets need not be a unit at all."""
    assert heading.unit is not None
    if same_unit(unit, heading.unit):
        return True
    try:
        return float(convert(1.0, heading.unit, known_unit(unit)[0] or unit)) == 1.0
    except UnitError:
        return not heading.certain
