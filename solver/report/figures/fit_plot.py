"""Fit plots: measured and calculated series with their residuals, and stage by stage over the logarithm of time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.report.curves import SeriesCurve
from geoswarm.solver.report.figures.extent import set_limits
from geoswarm.solver.report.figures.style import (
    BLUE,
    GREEN,
    GRID,
    MUTED,
    ORANGE,
    drawing,
    finish,
    head,
    plain_ticks,
    plot_gross_errors,
    plot_measured,
    point_settlement_down,
    with_unit,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["MOST_BELOW_EACH_OTHER", "fit_figure", "fit_rows", "has_stages", "stages_figure"]

MOST_BELOW_EACH_OTHER = 3
"""More series stand in two columns: a page of paper is not that long."""
_CROWDED = 0.02
"""Half of the points within this share of the range: only a log axis shows them."""
_FEWEST = 3
"""Fewer points in a stage need no panel."""
_MOST_STAGES = 24


def fit_figure(
    title: str, curves: Sequence[SeriesCurve], other: tuple[str, Sequence[SeriesCurve]] | None = None
) -> Figure:
    """Draw measured points, the initial and the identified curve of every series, with the residuals below each.

    Parameters
    ----------
    title
        Line above the panels.
    curves
        Series in the user's units; compression is positive and drawn upwards, as in the data, but for settlements. An
        axis is logarithmic when half of the points would be crowded into its first 2 %.
    other
        Name and curves of another set of parameters, in the same order.
    """
    from matplotlib.figure import Figure

    with drawing():
        columns = 1 if len(curves) <= MOST_BELOW_EACH_OTHER else 2
        rows = -(-len(curves) // columns)
        figure = Figure(figsize=(4.6 * columns, 0.5 + 3.5 * rows), layout="constrained")
        head(figure, title)
        grid = figure.add_gridspec(2 * rows, columns, height_ratios=[3.0, 1.0] * rows)
        for index, curve in enumerate(curves):
            row, column = divmod(index, columns)
            upper = figure.add_subplot(grid[2 * row, column])
            lower = figure.add_subplot(grid[2 * row + 1, column], sharex=upper)
            if other is not None:
                line = other[1][index]
                upper.plot(line.x, line.y, color=ORANGE, linewidth=1.2, linestyle="--", label=other[0], zorder=2)
            _fit(upper, curve)
            _residuals(lower, curve)
            for axes in (upper, lower):
                point_settlement_down(axes, curve.series, curve.y_quantity)
            if _crowded(curve):
                plain_ticks(lower, "x", log=True, most=6)
                first = float(curve.measured_x[curve.measured_x > 0].min())
                set_limits(upper, "x", first * 0.7, float(curve.measured_x.max()) * 1.4, log=True)
            else:
                plain_ticks(lower, "x", log=False, most=6, whole=curve.x_integer)
            upper.tick_params(labelbottom=False)
    return figure


def has_stages(curve: SeriesCurve) -> bool:
    """Return whether a series was measured during at least two loads, often enough to be shown stage by stage."""
    return len(_stages(curve)) >= 2


def stages_figure(title: str, curve: SeriesCurve) -> Figure:
    """Draw one series stage by stage over the logarithm of the time since the load was applied.

    The first 24 stages with at least three points each after the load are drawn.
    """
    from matplotlib.figure import Figure

    stages = _stages(curve)[:_MOST_STAGES]
    columns = 4 if len(stages) > 6 else min(len(stages), 3)
    rows = -(-len(stages) // columns)
    with drawing():
        figure = Figure(figsize=(7.4 if columns == 4 else 4.6, 0.8 + 1.45 * rows), layout="constrained")
        head(figure, title)
        for place, (number, start, end) in enumerate(stages):
            axes = figure.add_subplot(rows, columns, place + 1)
            _stage(axes, curve, start, end)
            point_settlement_down(axes, curve.series, curve.y_quantity)
            axes.set_title(f"stage {number}", fontsize=8, loc="left", pad=2)
        figure.supxlabel(with_unit(f"{curve.x_quantity} since the load", curve.x_unit), fontsize=9)
        figure.supylabel(with_unit(curve.y_quantity, curve.y_unit), fontsize=9)
    return figure


def fit_rows(curves: Sequence[SeriesCurve]) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: one row a measured point, those of gross errors last."""
    header = ["series", "x", "x_unit", "measured", "calculated", "residual", "y_unit"]
    weighted = any(c.loss_weights is not None for c in curves)
    header += ["loss_weight"] if weighted else []
    rows: list[list[object]] = []
    for c in curves:
        columns = (c.measured_x, c.measured_y, c.at_points, c.residuals)
        numbers = zip(*(column.tolist() for column in columns), strict=True)
        own: list[list[object]] = [[c.series, x, c.x_unit, y, f, r, c.y_unit] for x, y, f, r in numbers]
        if weighted:
            weights = [""] * len(own) if c.loss_weights is None else c.loss_weights.tolist()
            own = [[*row, weight] for row, weight in zip(own, weights, strict=True)]
        rows += own
        gross = zip(c.gross_x.tolist(), c.gross_y.tolist(), strict=True)
        rows += [[c.series, x, c.x_unit, y, "gross error", "", c.y_unit, *([""] if weighted else [])] for x, y in gross]
    return header, rows


def _fit(axes: Axes, curve: SeriesCurve) -> None:
    for start in curve.breaks[1:] if curve.breaks.size <= _MOST_STAGES else ():
        axes.axvline(start, color=GRID, linewidth=0.6, zorder=0)
    if curve.initial is not None:
        axes.plot(curve.x, curve.initial, color=GREEN, linewidth=1.2, linestyle="--", label="initial", zorder=2)
    axes.plot(curve.x, curve.y, color=BLUE, linewidth=1.6, label="identified", zorder=3)
    plot_measured(axes, curve.measured_x, curve.measured_y)
    plot_gross_errors(axes, curve.gross_x, curve.gross_y)
    axes.set_ylabel(with_unit(curve.y_quantity, curve.y_unit))
    axes.set_title(curve.series, loc="left")
    plain_ticks(axes, "y", log=False, most=7)
    finish(axes)
    axes.grid(visible=not curve.breaks.size, axis="x")


def _residuals(axes: Axes, curve: SeriesCurve) -> None:
    axes.axhline(0.0, color=MUTED, linewidth=0.8, zorder=1)
    axes.plot(
        curve.measured_x, curve.residuals, linestyle="none", marker="o", markersize=2.6, color=BLUE, markeredgewidth=0
    )
    if curve.outliers.any():
        far = curve.outliers
        axes.plot(
            curve.measured_x[far], curve.residuals[far], linestyle="none", marker="o", markersize=6.0,
            markerfacecolor="none", markeredgecolor=MUTED, label="outlier",
        )  # fmt: skip
    axes.set_xlabel(with_unit(curve.x_quantity, curve.x_unit))
    axes.set_ylabel(with_unit("distance" if curve.distances else "residual", curve.y_unit))
    finish(axes, legend=bool(curve.outliers.any()))
    plain_ticks(axes, "y", log=False, most=4)


def _stage(axes: Axes, curve: SeriesCurve, start: float, end: float) -> None:
    inside = (curve.measured_x > start) & (curve.measured_x <= end)
    along = (curve.x > start) & (curve.x <= end)
    x = curve.x[along] - start
    if curve.initial is not None:
        axes.plot(x, curve.initial[along], color=GREEN, linewidth=1.1, linestyle="--")
    axes.plot(x, curve.y[along], color=BLUE, linewidth=1.5)
    plot_measured(axes, curve.measured_x[inside] - start, curve.measured_y[inside])
    struck = (curve.gross_x > start) & (curve.gross_x <= end)
    plot_gross_errors(axes, curve.gross_x[struck] - start, curve.gross_y[struck])
    first = float((curve.measured_x[inside] - start).min())
    set_limits(axes, "x", first * 0.6, (end - start) * 1.5, log=True)
    shown = np.concatenate([curve.y[along & (curve.x - start >= first * 0.6)], curve.measured_y[inside]])
    margin = 0.12 * float(np.ptp(shown)) or 1.0
    set_limits(axes, "y", float(shown.min()) - margin, float(shown.max()) + margin)
    plain_ticks(axes, "x", log=True, most=4)
    plain_ticks(axes, "y", log=False, most=3)
    axes.tick_params(labelsize=7)
    finish(axes, legend=False)


def _stages(curve: SeriesCurve) -> list[tuple[int, float, float]]:
    """Number (from 1), begin and end of every stage with enough points."""
    edges = np.append(curve.breaks, np.inf)
    last = float(max(curve.measured_x.max(), curve.x.max()))
    found = []
    for index in range(len(edges) - 1):
        start, end = float(edges[index]), min(float(edges[index + 1]), last)
        if int(((curve.measured_x > start) & (curve.measured_x <= end)).sum()) >= _FEWEST:
            found.append((index + 1, start, end))
    return found


def _crowded(curve: SeriesCurve) -> bool:
    x = curve.measured_x[curve.measured_x > 0.0]
    if x.size < 8 or curve.breaks.size > 1 or x.size < curve.measured_x.size - 1:
        return False
    return bool(np.median(x) <= x.min() + _CROWDED * np.ptp(curve.measured_x))
