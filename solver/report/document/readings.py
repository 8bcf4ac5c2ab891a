"""What a report says of the readings and residuals: where they come from, what was done to them, what is left."""

from __future__ import annotations

from collections.abc import Iterator

from geoswarm.solver.identifiability import Statistics
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.checks.consolidation import find_consolidation
from geoswarm.solver.problem.stages import section_of_test, stage_times
from geoswarm.solver.report.document.parts import Table
from geoswarm.solver.units import convert
from geoswarm.solver.words import number

__all__ = ["gross_error_table", "not_modelled", "reading_notes", "residual_table"]

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


def residual_table(statistics: Statistics) -> Table:
    """Return a line for each series; with a loss also how many of its readings are outliers."""
    robust = any(r.loss_weights is not None for r in statistics.residuals)
    rows = []
    for r in statistics.residuals:
        runs = "–" if r.runs is None else f"{r.runs} of {number(r.expected_runs, 3)}"
        cells = (r.series, str(r.residuals.size), number(r.deviation, 3), number(r.bias, 2), runs)
        outliers = ("–" if r.outliers is None else str(r.outliers),) if robust else ()
        rows.append((*cells, number(r.durbin_watson, 3), *outliers))
    usual = ("series", "points", "deviation", "bias", "runs of expected", "Durbin-Watson")
    headings = (*usual, "outliers") if robust else usual
    where = "minimum" if statistics.residuals_at_optimum else "best evaluation"
    note = f"Residuals of the {where} in base units; Durbin-Watson is 2 for independent residuals."
    note += " Outliers: points to which the loss gives a weight below a third." if robust else ""
    return Table("Residuals", headings, tuple(rows), tuple(range(1, len(headings))), note)


def not_modelled(problem: Problem) -> tuple[str, ...]:
    """Sentences on primary consolidation in readings over the time of a test in stages; empty for other problems."""
    spec = problem.forward_model
    timed = [
        o
        for o in problem.observations
        if stage_times(spec, o.series).size and not section_of_test(spec, o.series)[1].consolidates
    ]
    if not timed:
        return ()
    counts = ", ".join(f"{o.left_out} of {len(o.points.x)} of {o.series}" for o in timed)
    general = (
        "Primary consolidation is not modelled: readings before its end in a stage make the parameters wrong. Readings "
        f"that were left out: {counts}."
    )
    return (general, *(found.sentence for found in find_consolidation(problem)))
