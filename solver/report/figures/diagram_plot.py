"""Figure of a diagram that engineers draw of a test: measured and calculated, one quantity over another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.report.diagrams import DiagramCurve
from geoswarm.solver.report.figures.extent import set_limits
from geoswarm.solver.report.figures.style import BLUE, drawing, finish, head, plain_ticks, plot_measured, with_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["diagram_figure", "diagram_rows"]


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
