"""Lines, areas and texts of a sketch, and the sheet that they are put on."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

__all__ = ["SIZE", "Area", "Dot", "Drawing", "Ink", "Line", "Point", "Shape", "Sheet", "Text", "text_width"]

Ink: TypeAlias = Literal["ink", "muted", "grid", "soil", "steel", "stone", "marl", "water", "load", "reading"]
"""What something is; the renderer chooses the colours."""

Point: TypeAlias = tuple[float, float]
"""x to the right, y downwards; a unit is a pixel where the sketch is as wide as it was meant to be."""

SIZE = 12.0
"""Usual height of letters."""
_LETTER = 0.58
_ARROW = 7.0


@dataclass(frozen=True, slots=True)
class Line:
    """An open line through at least two points."""

    points: tuple[Point, ...]
    ink: Ink = "ink"
    width: float = 1.0
    dashed: bool = False


@dataclass(frozen=True, slots=True)
class Area:
    """A closed area."""

    points: tuple[Point, ...]
    ink: Ink


@dataclass(frozen=True, slots=True)
class Dot:
    """A disc, or a ring: what is inside stays free."""

    centre: Point
    radius: float
    ink: Ink
    filled: bool = True


@dataclass(frozen=True, slots=True)
class Text:
    """A line of text; ``at`` is its baseline. ``upwards``: turned by a quarter, read from below."""

    at: Point
    text: str
    anchor: Literal["start", "middle", "end"] = "middle"
    ink: Literal["ink", "muted"] = "ink"
    size: float = SIZE
    upwards: bool = False


Shape: TypeAlias = Line | Area | Dot | Text


@dataclass(frozen=True, slots=True)
class Drawing:
    """Shapes on a sheet of a width and a height; what comes later lies above.

    ``worded``: what it says in words stands in it, and need not be repeated below it.
    """

    width: float
    height: float
    shapes: tuple[Shape, ...]
    worded: bool = False


def text_width(text: str, size: float = SIZE) -> float:
    """About how wide a text gets, in whatever font."""
    return _LETTER * size * len(text)


@dataclass
class Sheet:
    """A drawing in the making."""

    width: float
    shapes: list[Shape] = field(default_factory=list)

    def line(self, *points: Point, ink: Ink = "ink", width: float = 1.0, dashed: bool = False) -> None:
        """Draw a line through points."""
        self.shapes.append(Line(points, ink, width, dashed))

    def box(self, x: float, y: float, width: float, height: float, ink: Ink, outlined: bool = True) -> None:
        """Fill a rectangle, from its upper left corner."""
        corners = ((x, y), (x + width, y), (x + width, y + height), (x, y + height))
        self.shapes.append(Area(corners, ink))
        if outlined:
            self.line(*corners, corners[0], ink="muted", width=0.8)

    def area(self, *points: Point, ink: Ink) -> None:
        """Fill an area."""
        self.shapes.append(Area(points, ink))

    def dot(self, at: Point, radius: float, ink: Ink, filled: bool = True) -> None:
        """Draw a disc or a ring."""
        self.shapes.append(Dot(at, radius, ink, filled))

    def arrow(self, start: Point, end: Point, ink: Ink, width: float = 1.4) -> None:
        """Draw an arrow with its tip at ``end``."""
        length = math.dist(start, end)
        along = ((end[0] - start[0]) / length, (end[1] - start[1]) / length)
        size = min(_ARROW, 0.6 * length)
        neck = (end[0] - size * along[0], end[1] - size * along[1])
        side = (-0.42 * size * along[1], 0.42 * size * along[0])
        self.line(start, neck, ink=ink, width=width)
        self.area(end, (neck[0] + side[0], neck[1] + side[1]), (neck[0] - side[0], neck[1] - side[1]), ink=ink)

    def text(
        self,
        at: Point,
        text: str,
        anchor: Literal["start", "middle", "end"] = "middle",
        ink: Literal["ink", "muted"] = "ink",
        size: float = SIZE,
        upwards: bool = False,
    ) -> None:
        """Write a line of text."""
        self.shapes.append(Text(at, text, anchor, ink, size, upwards))

    def dimension(self, start: Point, end: Point, text: str) -> None:
        """Draw a dimension line, upright or level, with its text to the left of it or below."""
        upright = start[0] == end[0]
        tick = (4.0, 0.0) if upright else (0.0, 4.0)
        self.line(start, end, ink="muted", width=0.9)
        for x, y in (start, end):
            self.line((x - tick[0], y - tick[1]), (x + tick[0], y + tick[1]), ink="muted", width=0.9)
        middle = (0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1]))
        if upright:
            self.text((middle[0] - 6.0, middle[1]), text, upwards=True)
        else:
            self.text((middle[0], middle[1] + 14.0), text)

    def raise_by(self, units: float) -> None:
        """Move everything that was put on the sheet upwards."""
        self.shapes = [_raised(shape, units) for shape in self.shapes]

    def done(self, height: float, *, worded: bool = False) -> Drawing:
        """The drawing, of a height."""
        return Drawing(self.width, height, tuple(self.shapes), worded)


def _raised(shape: Shape, units: float) -> Shape:
    if isinstance(shape, Line | Area):
        return replace(shape, points=tuple((x, y - units) for x, y in shape.points))
    if isinstance(shape, Dot):
        return replace(shape, centre=(shape.centre[0], shape.centre[1] - units))
    return replace(shape, at=(shape.at[0], shape.at[1] - units))
