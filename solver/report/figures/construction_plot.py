"""Figure of the constructions of a classical evaluation: readings, lines and results, one panel each."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.parameter_estimates.values import Construction
from geoswarm.solver.report.figures.extent import set_limits
from geoswarm.solver.report.figures.style import (
    BLUE,
    GREEN,
    GRID,
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

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["chosen_constructions", "construction_figure", "construction_rows"]

_MOST = 6
"""Panels of one figure."""
_COLOURS = (BLUE, GREEN, SKY, MUTED)


def chosen_constructions(found: Sequence[Construction]) -> tuple[Construction, ...]:
    """Those of one figure: of each kind that of the last stage, at most six."""
    kinds: dict[tuple[str, str], Construction] = {}
    for one in found:
        kind = one.name.rstrip("0123456789")
        if one.first_loading or (one.part, kind) not in kinds:
            kinds[one.part, kind] = one
    return tuple(kinds.values())[:_MOST]


def construction_figure(title: str, constructions: Sequence[Construction]) -> Figure:
    """Draw constructions side by side."""
    from matplotlib.figure import Figure

    columns = 2 if len(constructions) > 1 else 1
    lines = math.ceil(len(constructions) / columns)
    with drawing():
        figure = Figure(figsize=(4.6 * columns, 3.7 * lines), layout="constrained")
        head(figure, title)
        for index, one in enumerate(constructions):
            _panel(figure.add_subplot(lines, columns, index + 1), one)
    return figure


def _panel(axes: Axes, one: Construction) -> None:
    part = f"{one.part}: " if one.part else ""
    axes.set_title(textwrap.fill(f"{part}{one.heading}", 46))
    for index, line in enumerate(one.lines):
        main = line.role == "main"
        axes.plot(
            line.x,
            line.y,
            color=_COLOURS[index % len(_COLOURS)],
            linewidth=1.5 if main else 1.0,
            linestyle="-" if main else "--",
            label=line.label,
            zorder=3,
        )
    angle = np.linspace(0.0, math.pi, 91)
    for arc in one.arcs:
        centre, radius = 0.5 * (arc.largest + arc.smallest), 0.5 * (arc.largest - arc.smallest)
        axes.plot(centre + radius * np.cos(angle), radius * np.sin(angle), color=INK, linewidth=0.9, zorder=2)
    if one.joined:
        axes.plot(one.x, one.y, color=GRID, linewidth=0.9, zorder=1)
    if one.x.size:
        plot_measured(axes, one.x, one.y)
    for index, mark in enumerate(one.marks):
        last = index == len(one.marks) - 1  # what was looked for
        axes.plot(
            [mark.x],
            [mark.y],
            linestyle="none",
            marker="D" if last else "s",
            markersize=5.0 if last else 4.0,
            color=ORANGE if last else INK,
            label=mark.label,
            zorder=6 if last else 5,
        )
    x, y = _extent(one)
    set_limits(axes, "x", float(x.min()), float(x.max()), log=one.log, margin=0.04)
    set_limits(axes, "y", float(y.min()), float(y.max()), margin=0.0 if one.arcs else 0.05)
    plain_ticks(axes, "x", log=one.log, most=6)
    plain_ticks(axes, "y", log=False, most=6)
    if one.arcs:
        axes.set_aspect("equal", adjustable="box")
    if one.downwards:
        axes.invert_yaxis()
    axes.set_xlabel(with_unit(one.x_quantity, one.x_unit))
    axes.set_ylabel(with_unit(one.y_quantity, one.y_unit))
    finish(axes)


def _extent(one: Construction) -> tuple[FloatArray, FloatArray]:
    """All that has to be seen."""
    x = [one.x, *(line.x for line in one.lines), np.array([mark.x for mark in one.marks])]
    y = [one.y, *(line.y for line in one.lines), np.array([mark.y for mark in one.marks])]
    for arc in one.arcs:
        x.append(np.array([0.0, arc.largest]))
        y.append(np.array([0.0, 0.5 * (arc.largest - arc.smallest)]))
    return np.concatenate(x), np.concatenate(y)


def construction_rows(constructions: Sequence[Construction]) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: readings, ends of lines, marks and circles of each panel."""
    header = ["construction", "test", "kind", "label", "x", "x_unit", "y", "y_unit"]
    rows: list[list[object]] = []
    for one in constructions:
        kinds: list[tuple[str, str, Sequence[float], Sequence[float]]] = [
            ("measured", "", one.x.tolist(), one.y.tolist()),
            *(("line", line.label, line.x.tolist(), line.y.tolist()) for line in one.lines),
            *(("point", mark.label, [mark.x], [mark.y]) for mark in one.marks),
            *(("circle", "", [arc.smallest, arc.largest], [0.0, 0.0]) for arc in one.arcs),
        ]
        for kind, label, xs, ys in kinds:
            rows += [
                [one.name, one.part, kind, label, x, one.x_unit, y, one.y_unit] for x, y in zip(xs, ys, strict=True)
            ]
    return header, rows
