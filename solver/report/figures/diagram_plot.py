"""Figures of diagrams that engineers draw of a test, and of several tests in one: measured and calculated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.report.diagrams import DiagramCurve
from geoswarm.solver.report.figures.extent import set_limits
from geoswarm.solver.report.figures.style import (
    BLUE,
    GREEN,
    INK,
    MUTED,
    ORANGE,
    SKY,
    drawing,
    finish,
    head,
    plain_ticks,
    plot_measured,
    with_unit,
)
from geoswarm.solver.report.overlays import Overlay, OverlayLine

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["diagram_figure", "diagram_rows", "overlay_figure", "overlay_rows"]

_COLOURS = (BLUE, ORANGE, GREEN, SKY, "#CC79A7", "#E69F00", MUTED)
_MARKERS = ("o", "s", "^", "v", "D")
_MOST_MARKS = 30
"""Measured points of a test that are drawn: more hide the lines of the others."""


def diagram_figure(title: str, curve: DiagramCurve) -> Figure:
    """Draw the calculated line and the measured points; an axis of stresses begins at zero unless it is logarithmic."""
    from matplotlib.figure import Figure

    diagram = curve.diagram
    with drawing():
        figure = Figure(figsize=(4.6, 3.8), layout="constrained")
        head(figure, title)
        axes = figure.add_subplot()
        axes.plot(curve.x, curve.y, color=BLUE, linewidth=1.6, label="identified", zorder=3)
        plot_measured(axes, curve.measured_x, curve.measured_y)
        drawn = np.isfinite(curve.x)
        x = np.concatenate([curve.x[drawn], curve.measured_x])
        y = np.concatenate([curve.y[drawn], curve.measured_y])
        if diagram.log:
            x = x[x > 0.0]
        low = float(x.min()) if diagram.log else min(float(x.min()), 0.0)
        set_limits(axes, "x", low, float(x.max()), log=diagram.log, margin=0.04)
        from_zero = curve.y_info.y_unit == "kPa"
        set_limits(axes, "y", min(float(y.min()), 0.0) if from_zero else float(y.min()), float(y.max()), margin=0.05)
        plain_ticks(axes, "x", log=diagram.log, most=6)
        plain_ticks(axes, "y", log=False, most=7)
        if diagram.downwards:
            axes.invert_yaxis()
        axes.set_xlabel(with_unit(curve.x_info.y_quantity, curve.x_info.y_unit))
        axes.set_ylabel(with_unit(curve.y_info.y_quantity, curve.y_info.y_unit))
        finish(axes)
    return figure


def diagram_rows(curve: DiagramCurve) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers, the measured ones first."""
    header = ["kind", curve.diagram.x, "x_unit", curve.diagram.y, "y_unit"]
    rows: list[list[object]] = []
    drawn = np.isfinite(curve.x)
    lines = (("measured", curve.measured_x, curve.measured_y), ("calculated", curve.x[drawn], curve.y[drawn]))
    for kind, xs, ys in lines:
        pairs = zip(xs.tolist(), ys.tolist(), strict=True)
        rows += [[kind, x, curve.x_info.y_unit, y, curve.y_info.y_unit] for x, y in pairs]
    return header, rows


def overlay_figure(title: str, found: Sequence[Overlay], compared: str = "") -> Figure:
    """Draw a panel for each diagram, with a colour and a mark for each test in all of them.

    Parameters
    ----------
    compared
        Name of the other set of parameters; its lines are dashed.
    """
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    tests = list(dict.fromkeys(line.test for one in found for line in one.lines))
    looks = {test: _look(place) for place, test in enumerate(tests)}
    rows = -(-len(found) // 2)
    columns = min(len(found), 2)
    below = -(-(len(tests) + 3) // (4 * columns))
    with drawing():
        figure = Figure(figsize=(4.6 * columns, 0.7 + 3.4 * rows + 0.2 * below), layout="constrained")
        head(figure, title)
        for place, one in enumerate(found):
            _panel(figure.add_subplot(rows, columns, place + 1), one, looks)
        handles: list[Artist] = [
            Line2D([], [], color=colour, marker=mark, markersize=4, markerfacecolor="none", label=test)
            for test, (colour, mark) in looks.items()
        ]
        handles.append(Line2D([], [], color=INK, linestyle="none", marker="o", fillstyle="none", label="measured"))
        handles.append(Line2D([], [], color=INK, label="calculated"))
        if compared:
            handles.append(Line2D([], [], color=INK, linestyle="--", linewidth=1.0, label=compared))
        figure.legend(handles=handles, loc="outside lower center", ncols=4 * columns, frameon=False)
    return figure


def _look(place: int) -> tuple[str, str]:
    round_, colour = divmod(place, len(_COLOURS))
    return _COLOURS[colour], _MARKERS[round_ % len(_MARKERS)]


def _panel(axes: Axes, one: Overlay, looks: dict[str, tuple[str, str]]) -> None:
    for line in one.lines:
        colour, mark = looks[line.test]
        axes.plot(line.x, line.y, color=colour, linewidth=1.3, zorder=3)
        if line.compared is not None:
            axes.plot(*line.compared, color=colour, linewidth=0.9, linestyle="--", zorder=2)
        x, y = _marks(line)
        axes.plot(x, y, linestyle="none", marker=mark, markersize=3.2, fillstyle="none", color=colour, zorder=4)
    x = np.concatenate([part for line in one.lines for part in (line.x[np.isfinite(line.x)], line.measured_x)])
    if one.log:
        x = x[x > 0.0]
    set_limits(axes, "x", float(x.min()), float(x.max()), log=one.log, margin=0.04)
    plain_ticks(axes, "x", log=one.log, most=6)
    plain_ticks(axes, "y", log=False, most=7)
    if one.downwards:
        axes.invert_yaxis()
    axes.set_xlabel(with_unit(*one.x_axis))
    axes.set_ylabel(with_unit(*one.y_axis))
    finish(axes, legend=False)


def _marks(line: OverlayLine) -> tuple[FloatArray, FloatArray]:
    count = len(line.measured_x)
    places = np.unique(np.linspace(0, count - 1, min(count, _MOST_MARKS)).round().astype(np.int64))
    return line.measured_x[places], line.measured_y[places]


def overlay_rows(found: Sequence[Overlay]) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the numbers of all panels, test by test, the measured ones first."""
    header = ["diagram", "test", "kind", "x", "x_unit", "y", "y_unit"]
    rows: list[list[object]] = []
    for one in found:
        for line in one.lines:
            kinds = [("measured", line.measured_x, line.measured_y), ("calculated", line.x, line.y)]
            kinds += [] if line.compared is None else [("compared", *line.compared)]
            for kind, xs, ys in kinds:
                pairs = zip(xs.tolist(), ys.tolist(), strict=True)
                rows += [
                    [one.name, line.test, kind, x, one.x_axis[1], y, one.y_axis[1]]
                    for x, y in pairs
                    if x == x  # nan
                ]
    return header, rows
