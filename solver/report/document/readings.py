"""What a report says of the readings: where they come from, what was done to them, and those that do not count."""

from __future__ import annotations

from collections.abc import Iterator

from geoswarm.solver.problem import Problem
from geoswarm.solver.report.document.parts import Table
from geoswarm.solver.units import convert
from geoswarm.solver.words import number

__all__ = ["gross_error_table", "reading_notes"]

_MOST_ROWS = 50


def reading_notes(problem: Problem) -> Iterator[str]:
    """One sentence for each series with notes."""
    for o in problem.observations:
        if o.notes:
            yield f"Readings of {o.series}: {'; '.join(o.notes)}."


def gross_error_table(problem: Problem) -> Table | None:
    """Readings that the user marked as gross errors; None without any."""
    base = {info.name: info for info in problem.model.series}
    rows = []
    for o in problem.observations:
        info = base[o.series]
        x_unit, y_unit = o.x_unit or info.x_unit, o.y_unit or info.y_unit
        x, y = convert(o.gross_x, info.x_unit, x_unit), convert(o.gross_y, info.y_unit, y_unit)
        rows += [
            (o.series, f"{number(one)} {x_unit}".rstrip(), f"{number(other)} {y_unit}".rstrip())
            for one, other in zip(x.tolist(), y.tolist(), strict=True)
        ]
    if not rows:
        return None
    note = "They are shown as crosses in the figures and left out of misfits, statistics and classical values."
    if len(rows) > _MOST_ROWS:
        note += f" The first {_MOST_ROWS} of {len(rows)} are listed."
    return Table("Readings marked as gross errors", ("series", "x", "measured"), tuple(rows[:_MOST_ROWS]), (1, 2), note)
