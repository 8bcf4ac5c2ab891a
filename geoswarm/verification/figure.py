"""The figure of a case: ours as lines, the reference as open circles."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from geoswarm.solver.report.figures.style import BLUE, GREEN, INK, ORANGE, SKY, drawing, finish, plain_ticks
from geoswarm.verification.case import Plot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["plot_figure"]

COLOURS = (BLUE, ORANGE, GREEN, SKY, "#CC79A7", "#E69F00")
"""Those of the reports, and two more of Okabe and Ito."""
DASHES: tuple[Any, ...] = ("solid", (0, (5, 2)), (0, (1.5, 2.5)), (0, (6, 1.5, 1, 1.5)))
"""So that a curve which lies on another one leaves it visible."""
LONG = 16
"""Letters of a label beyond which only two find room beside each other."""


def plot_figure(plot: Plot) -> Figure:
    """Draw a plot; every curve has its colour, and the reference is of ink."""
    from matplotlib.figure import Figure

    with drawing():
        figure = Figure(figsize=(5.2, 3.5), layout="constrained")
        axes = figure.add_subplot()
        for number, curve in enumerate(plot.curves):
            ours: dict[str, Any] = {"linestyle": "none", "marker": "D", "markersize": 5.5, "alpha": 0.8}
            if not plot.dots:
                ours = {"linestyle": DASHES[number % len(DASHES)], "linewidth": 1.7}
            label, colour = curve.label or "geoswarm", COLOURS[number % len(COLOURS)]
            axes.plot(curve.x, curve.y, color=colour, label=label, zorder=3, **ours)
        for number, curve in enumerate(plot.curves):
            axes.plot(
                curve.reference_x,
                curve.reference_y,
                linestyle="none",
                marker="o",
                markersize=4.5,
                markerfacecolor="none",
                markeredgecolor=INK,
                markeredgewidth=0.8,
                label="reference" if number == 0 else None,
                zorder=4,
            )
        plain_ticks(axes, "x", log=plot.log_x, most=7, whole=plot.dots)
        plain_ticks(axes, "y", log=plot.log_y, most=6)
        if plot.downwards:
            axes.invert_yaxis()
        axes.set_xlabel(plot.x)
        axes.set_ylabel(plot.y)
        finish(axes, legend=False)
        longest = max(len(curve.label) for curve in plot.curves)
        columns = 2 if longest > LONG else 3 if len(plot.curves) in (2, 5) else 4
        figure.legend(loc="outside upper left", ncols=columns, frameon=False, columnspacing=1.4)
    return figure
