"""The sketch of a test as a figure: the same shapes as in the form of a new job."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geoswarm.solver.report.figures.style import (
    BLUE,
    GREEN,
    GRID,
    INK,
    MARL,
    MUTED,
    ORANGE,
    SOIL,
    STEEL,
    STONE,
    drawing,
    head,
)
from geoswarm.solver.sketches.declared import CrossSection, Sketch
from geoswarm.solver.sketches.drawing import DrawnSketch
from geoswarm.solver.sketches.shapes import Area, Dot, Drawing, Ink, Line, Shape, Text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["sketch_figure", "sketch_rows"]

_UNIT = 0.0122
"""Inches of a unit of the sheet."""
_GAP = 14.0
_HEAD = 34.0
_LINE = 72.0 * _UNIT
_LETTERS = 0.88
"""Of the height of letters: those of figures are wider than those of a page."""
_COLOURS: dict[Ink, str] = {
    "ink": INK,
    "muted": MUTED,
    "grid": GRID,
    "soil": SOIL,
    "steel": STEEL,
    "stone": STONE,
    "marl": MARL,
    "water": BLUE,
    "load": ORANGE,
    "reading": GREEN,
}


def sketch_figure(title: str, sketch: DrawnSketch) -> Figure:
    """Draw the specimen, the ground or the section, with the loading programme next to it."""
    from matplotlib.figure import Figure

    columns = _columns([one.drawing for one in sketch.drawings])
    widths = [max(one.width for one in column) for column in columns]
    width = sum(widths) + _GAP * (len(widths) - 1)
    height = max(sum(one.height for one in column) + _GAP * (len(column) - 1) for column in columns) + _HEAD
    with drawing():
        figure = Figure(figsize=(width * _UNIT, height * _UNIT))
        left = 0.0
        for column, wide in zip(columns, widths, strict=True):
            top = _HEAD
            for own in column:
                place = (left / width, 1.0 - (top + own.height) / height, own.width / width, own.height / height)
                axes = figure.add_axes(place)
                axes.set_axis_off()
                axes.set_xlim(0.0, own.width)
                axes.set_ylim(own.height, 0.0)
                for order, shape in enumerate(own.shapes):
                    _put(axes, shape, 1.0 + 0.001 * order)
                top += own.height + _GAP
            left += wide + _GAP
        head(figure, title)
    return figure


def _columns(drawings: list[Drawing]) -> list[list[Drawing]]:
    """Next to each other; of more than two, the first one with the second one below it, and the others."""
    return [[one] for one in drawings] if len(drawings) <= 2 else [drawings[:2], drawings[2:]]


def sketch_rows(sketch: Sketch) -> tuple[list[str], list[list[object]]]:
    """Return header and rows of the figure's numbers: corners of regions, and those of the lines of the programme."""
    header = ["panel", "quantity", "x", "x_quantity", "x_unit", "y", "y_unit"]
    rows: list[list[object]] = []
    if isinstance(sketch.body, CrossSection):
        regions = [(one.name, piece) for one in sketch.body.regions for piece in one.pieces]
        rows += [[0, name, x, "x", "m", y, "m"] for name, piece in regions for x, y in piece]
    for number, panel in enumerate(sketch.programme, start=1):
        for track in panel.tracks:
            symbol = track.symbol or panel.symbol
            rows += [[number, symbol, x, panel.x, panel.x_unit, y, panel.unit] for x, y in track.points]
    return header, rows


def _put(axes: Axes, shape: Shape, order: float) -> None:
    from matplotlib.patches import Circle, Polygon

    if isinstance(shape, Line):
        axes.plot(
            *zip(*shape.points, strict=True),
            color=_COLOURS[shape.ink],
            linewidth=_LINE * shape.width,
            linestyle=(0, (4, 3)) if shape.dashed else "-",
            solid_joinstyle="round",
            clip_on=False,
            zorder=order,
        )
    elif isinstance(shape, Area):
        colour = _COLOURS[shape.ink]
        axes.add_patch(Polygon(shape.points, facecolor=colour, linewidth=0.0, clip_on=False, zorder=order))
    elif isinstance(shape, Dot):
        colour = _COLOURS[shape.ink]
        look = {"facecolor": colour, "linewidth": 0.0} if shape.filled else {"fill": False, "linewidth": 1.3 * _LINE}
        axes.add_patch(Circle(shape.centre, shape.radius, edgecolor=colour, clip_on=False, zorder=order, **look))
    else:
        _write(axes, shape, order)


def _write(axes: Axes, text: Text, order: float) -> None:
    sides = {"start": "left", "middle": "center", "end": "right"}
    axes.text(
        *text.at,
        text.text,
        ha=sides[text.anchor] if not text.upwards else "right",
        va="baseline" if not text.upwards else "center",
        rotation=90.0 if text.upwards else 0.0,
        fontsize=_LINE * _LETTERS * text.size,
        color=INK if text.ink == "ink" else MUTED,
        zorder=order + 1.0,
    )
