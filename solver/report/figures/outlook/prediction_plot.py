"""Predicted series with their bands, and the basins that make them up."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.identifiability.prediction.bands import PredictedSeries, Prediction
from geoswarm.solver.report.compression import compression_curves
from geoswarm.solver.report.curves import series_curves
from geoswarm.solver.report.diagrams import diagram_curves
from geoswarm.solver.report.figures.diagram_plot import overlay_figure
from geoswarm.solver.report.figures.extent import set_limits
from geoswarm.solver.report.figures.style import (
    BLUE,
    GREEN,
    MUTED,
    ORANGE,
    SKY,
    drawing,
    finish,
    head,
    plain_ticks,
    plot_measured,
    point_settlement_down,
    with_unit,
)
from geoswarm.solver.report.overlays import MANY_TESTS, Overlay, overlays
from geoswarm.solver.words import per_cent

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["prediction_figure", "prediction_rows"]

_ONE_COLUMN = 2  # more series stand in two columns
_FEW = 12  # points of a series that are marked
_COLOURS = (ORANGE, GREEN, MUTED)


def prediction_figure(title: str, prediction: Prediction) -> Figure:
    """Draw median and band of every series; of several basins the band and the optimum of each.

    A series at one x, or with fewer than three, has bars instead of a band. Four tests or more, all of them measured,
    stand in one diagram each kind, measured and calculated at the best optimum, without bands.
    """
    from matplotlib.figure import Figure

    tests = _tests(prediction)
    if any(len(one.lines) >= MANY_TESTS for one in tests):
        return overlay_figure(title, tests)
    series = prediction.series
    columns = 1 if len(series) <= _ONE_COLUMN else 2
    rows = -(-len(series) // columns)
    with drawing():
        figure = Figure(figsize=(4.9 * columns, 0.9 + 2.9 * rows), layout="constrained")
        head(figure, title)
        panels = [figure.add_subplot(rows, columns, index + 1) for index in range(len(series))]
        for axes, one in zip(panels, series, strict=True):
            _panel(axes, one, prediction)
        named: dict[str, Artist] = {}
        for axes in panels:
            named |= {
                word: handle
                for handle, word in zip(*axes.get_legend_handles_labels(), strict=True)
                if word not in named
            }
        figure.legend(
            list(named.values()), list(named), loc="outside lower center", ncols=2 if columns == 1 else 4, frameon=False
        )
    return figure


def _tests(prediction: Prediction) -> tuple[Overlay, ...]:
    """Diagrams that several tests have; none where a series was not measured, or the best optimum lacks one."""
    lacks = any(o.series not in prediction.responses for o in prediction.problem.observations)
    if lacks or any(one.measured is None for one in prediction.series):
        return ()
    problem, optimum = prediction.problem, prediction.basins[0].parameters
    values = problem.values([optimum[name] for name in problem.free_names])
    curves = [curve.thinned() for curve in series_curves(problem, prediction.responses, values)]
    return overlays(curves, diagram_curves(problem, values), compression_curves(problem, values, None))


def prediction_rows(prediction: Prediction) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: one row a point."""
    basins = len(prediction.basins)
    header = ["series", "x", "x_unit", "median", "lower", "upper", "reading_lower", "reading_upper", "measured"]
    header += [f"basin_{number + 1}" for number in range(basins)] + ["y_unit"]
    rows: list[list[object]] = []
    for one in prediction.series:
        for i, x in enumerate(one.x.tolist()):
            optional = [
                None if values is None else float(values[i])
                for values in (one.reading_lower, one.reading_upper, one.measured)
            ]
            optima = [float(curve[i]) if np.isfinite(curve[i]) else None for curve in one.optima]
            numbers = [float(values[i]) for values in (one.median, one.lower, one.upper)]
            rows.append([one.series, x, one.x_unit, *numbers, *optional, *optima, one.y_unit])
    return header, rows


def _panel(axes: Axes, one: PredictedSeries, prediction: Prediction) -> None:
    level = per_cent(prediction.level)
    few = one.x.size < 3
    several = len(prediction.basins) > 1
    if one.reading_lower is not None and one.reading_upper is not None:
        words = f"{level} of future readings"
        if few:
            _bars(axes, one.x, one.median, one.reading_lower, one.reading_upper, MUTED, words, 0.8, 4.0)
        else:
            for edge, word in ((one.reading_lower, words), (one.reading_upper, "")):
                axes.plot(one.x, edge, color=MUTED, linewidth=0.8, linestyle=":", label=word or None, zorder=1)
    if few:
        _bars(axes, one.x, one.median, one.lower, one.upper, BLUE, f"{level} band", 2.2, 5.0)
    else:
        axes.fill_between(
            one.x, one.lower, one.upper, color=SKY, alpha=0.35, linewidth=0, label=f"{level} band", zorder=2
        )
    if several:
        for number, basin in enumerate(prediction.basins):
            colour, part = _COLOURS[number % len(_COLOURS)], f"basin {number + 1}, {per_cent(basin.share)}"
            low, high, curve = one.basin_lower[number], one.basin_upper[number], one.optima[number]
            if np.isfinite(curve).all():
                style = {"marker": "D", "markersize": 3.5, "linestyle": "none"} if few else {"linestyle": "--"}
                axes.plot(one.x, curve, color=colour, linewidth=1.2, label=part, zorder=3, **style)
            if not few and np.isfinite(low).all():
                hatch = "///" if number % 2 else "xxx"
                axes.fill_between(
                    one.x, low, high, facecolor="none", edgecolor=colour, linewidth=0.6, hatch=hatch, alpha=0.35
                )
    elif not few and np.isfinite(one.optima[0]).all():
        axes.plot(one.x, one.optima[0], color=ORANGE, linewidth=1.0, linestyle="--", label="at the optimum", zorder=3)
    mark = "o" if one.x.size <= _FEW else None
    axes.plot(
        one.x, one.median, color=BLUE, linewidth=1.6, marker=mark, markersize=3.0, label="median", zorder=4,
        linestyle="none" if few else "-",
    )  # fmt: skip
    if one.measured is not None:
        plot_measured(axes, one.x, one.measured)
    axes.set_title(one.series, loc="left")
    axes.set_xlabel(with_unit(one.x_quantity, one.x_unit))
    axes.set_ylabel(with_unit(one.y_quantity, one.y_unit))
    if one.x.size > 1 and _logarithmic(one.x):
        plain_ticks(axes, "x", log=True, most=5)
    else:
        if one.x.size == 1:
            half = abs(float(one.x[0])) * 0.5 or 1.0
            set_limits(axes, "x", float(one.x[0]) - half, float(one.x[0]) + half)
        plain_ticks(axes, "x", log=False, most=6)
    plain_ticks(axes, "y", log=False, most=6)
    point_settlement_down(axes, one.series, one.y_quantity)
    finish(axes, legend=False)


def _bars(
    axes: Axes,
    x: FloatArray,
    middle: FloatArray,
    low: FloatArray,
    high: FloatArray,
    colour: str,
    words: str,
    width: float,
    cap: float,
) -> None:
    axes.errorbar(
        x, middle, yerr=[np.maximum(middle - low, 0.0), np.maximum(high - middle, 0.0)], fmt="none", ecolor=colour,
        elinewidth=width, capsize=cap, label=words, zorder=2,
    )  # fmt: skip


def _logarithmic(x: FloatArray) -> bool:
    """Whether the points are spread evenly over the logarithm rather than over x: by the median of their gaps."""
    if x.size < 5 or x.min() <= 0.0 or x.max() < 30.0 * x.min():
        return False
    return bool(np.median(x) < x.min() + 0.2 * np.ptp(x))
