"""Candidate tests by their worth."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.identifiability.worth.outcome import Design
from geoswarm.solver.report.figures.extent import set_limits
from geoswarm.solver.report.figures.labels import ParameterLabel
from geoswarm.solver.report.figures.style import BLUE, GREEN, INK, MUTED, ORANGE, SKY, drawing, finish, head

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["CRITERIA", "design_figure", "design_rows"]

CRITERIA = {
    "widths": "all intervals, geometric mean",
    "volume": "common region",
    "prediction": "band of the prediction",
}
_MARKS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "*")
_COLOURS = (ORANGE, GREEN, INK, MUTED)
_MOST = 40


def design_figure(title: str, design: Design, labels: Mapping[str, ParameterLabel]) -> Figure:
    """Draw a bar for the criterion of each candidate, the best above, and a mark for each parameter."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import PercentFormatter

    shown = design.candidates[:_MOST]
    with drawing():
        figure = Figure(figsize=(6.4, 1.5 + 0.34 * len(shown)), layout="constrained")
        head(figure, title)
        axes = figure.add_subplot()
        places = np.arange(len(shown))[::-1]
        axes.barh(
            places, [c.by(design.criterion) for c in shown], height=0.62, color=SKY, edgecolor=BLUE, linewidth=0.8,
            label=CRITERIA[design.criterion], zorder=2,
        )  # fmt: skip
        for index, name in enumerate(shown[0].parameters):
            axes.plot(
                [c.parameters[name] for c in shown], places, linestyle="none", marker=_MARKS[index % len(_MARKS)],
                markersize=5.0, markerfacecolor="none", markeredgecolor=_COLOURS[index % len(_COLOURS)],
                markeredgewidth=1.2, label=labels[name].symbol if name in labels else name, zorder=3,
            )  # fmt: skip
        axes.set_yticks(places, [textwrap.shorten(c.name, 44, placeholder="…") for c in shown])
        longest = max(max(c.by(design.criterion), *c.parameters.values()) for c in shown)
        set_limits(axes, "x", 0.0, min(1.0, max(1.15 * longest, 0.05)))
        axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0, symbol=" %"))
        axes.set_xlabel("expected reduction of the width")
        finish(axes, legend=False)
        axes.grid(visible=False, axis="y")
        handles, words = axes.get_legend_handles_labels()
        figure.legend(handles, words, loc="outside lower center", ncols=min(len(words), 4), frameon=False)
    return figure


def design_rows(design: Design) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: one row a candidate, the best first; reductions are parts."""
    names = list(design.best.parameters)
    header = ["candidate", "readings", "cost", *(f"reduction.{name}" for name in names)]
    header += ["reduction.widths", "reduction.volume", "reduction.prediction", "distinguishes", "per_cost"]
    return header, [
        [
            c.name,
            c.readings,
            c.cost,
            *(c.parameters[name] for name in names),
            c.widths,
            c.volume,
            c.prediction,
            c.distinguishes,
            c.per_cost,
        ]
        for c in design.candidates
    ]
