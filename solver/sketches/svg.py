"""Shapes as an SVG element for a page, whose style sheet gives each class its colour; no style is inside."""

from __future__ import annotations

from collections.abc import Iterable
from xml.sax.saxutils import escape, quoteattr

from geoswarm.solver.sketches.shapes import SIZE, Area, Dot, Drawing, Line, Point, Shape, Text

__all__ = ["svg_element"]

_COLUMN = 300.0


def svg_element(drawing: Drawing, label: str) -> str:
    """Return an ``svg`` element of class ``sketch``, also ``wide`` where it is made for more than a column,
    and ``worded`` where its words stand in it.

    Lines have the class ``line`` and that of their ink, areas ``area``, texts ``text``.

    Parameters
    ----------
    label
        The same in words, for those who do not see it.
    """
    looks = (" wide" if drawing.width > _COLUMN else "") + (" worded" if drawing.worded else "")
    inside = "".join(_element(shape) for shape in drawing.shapes)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="sketch{looks}" role="img" font-size="{SIZE:g}" '
        f'aria-label={quoteattr(label)} viewBox="0 0 {drawing.width:g} {drawing.height:g}">{inside}</svg>'
    )


def _element(shape: Shape) -> str:
    if isinstance(shape, Line):
        dashes = ' stroke-dasharray="4 3"' if shape.dashed else ""
        return (
            f'<polyline class="line {shape.ink}" fill="none" stroke-width="{shape.width:g}"{dashes} '
            f'points="{_points(shape.points)}"/>'
        )
    if isinstance(shape, Area):
        return f'<polygon class="area {shape.ink}" points="{_points(shape.points)}"/>'
    if isinstance(shape, Dot):
        x, y = shape.centre
        look = (
            f'class="area {shape.ink}"' if shape.filled else f'class="line {shape.ink}" fill="none" stroke-width="1.3"'
        )
        return f'<circle {look} cx="{x:.1f}" cy="{y:.1f}" r="{shape.radius:g}"/>'
    return _written(shape)


def _written(text: Text) -> str:
    x, y = text.at
    turned = f' transform="rotate(-90 {x:.1f} {y:.1f})"' if text.upwards else ""
    size = "" if text.size == SIZE else f' font-size="{text.size:g}"'
    return (
        f'<text class="text {text.ink}" x="{x:.1f}" y="{y:.1f}" text-anchor="{text.anchor}"{size}{turned}>'
        f"{escape(text.text)}</text>"
    )


def _points(points: Iterable[Point]) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
