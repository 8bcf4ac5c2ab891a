"""The table of the residuals at the optimum."""

from __future__ import annotations

from geoswarm.solver.identifiability import Statistics
from geoswarm.solver.report.document.parts import Table
from geoswarm.solver.words import number

__all__ = ["residual_table"]


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
