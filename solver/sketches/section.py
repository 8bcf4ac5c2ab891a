"""The shapes of a vertical section: layers, interfaces, points, loads, water and what is held, to scale."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

from geoswarm.solver.sketches.declared import BoundaryLoad, CrossSection, Place, Support
from geoswarm.solver.sketches.legend import clipped, region_ink
from geoswarm.solver.sketches.marks import SMALL
from geoswarm.solver.sketches.section_names import To, name_parts, span_at
from geoswarm.solver.sketches.shapes import Drawing, Ink, Line, Point, Sheet, Text
from geoswarm.solver.sketches.ticks import linear_scale, number

__all__ = ["draw_section", "enlarged", "size_of"]

_WIDTH = 340.0
_LEFT, _RIGHT = 46.0, 306.0
_TOP = 64.0
_TALLEST, _FLAT, _LEAST = 210.0, 70.0, 110.0
"""Height that a section takes at most, and below which its heights are enlarged, to at least the last one."""
_FACTORS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 7.5, 10.0)
_ARROW = 22.0
_VISIBLE = 2.6
"""Thickness at which a layer is drawn at least."""
_ROLLER = 2.6
_APART = 15.0
"""Of arrows and of rollers."""


def draw_section(section: CrossSection) -> Drawing:
    """Draw a section with its axes in metres."""
    sheet = Sheet(_WIDTH)
    left, right, low, high = _extent(section)
    across, factor = _scale(section)
    middle = 0.5 * (_LEFT + _RIGHT)

    def at(place: Place) -> Point:
        x, y = place
        return middle + across * (x - 0.5 * (left + right)), _TOP + across * factor * (high - y)

    _regions(sheet, section, at)
    for interface in section.interfaces:
        for line in interface.lines:
            sheet.line(*map(at, line), width=1.5)
    sheet.line(*map(at, section.surface), width=1.6)
    rollers = [place for support in section.supports for place in _support(sheet, support, at)]
    arrows = [_load(sheet, load, at) for load in section.loads]
    levels = [one for load in section.loads if (one := _water(sheet, load, at)) is not None]
    for _, place in section.points:
        sheet.dot(at(place), 2.6, "reading")
    lowest = name_parts(sheet, section, at, arrows, levels, rollers)
    foot = max(lowest + 12.0, at((left, low))[1] + 16.0)
    _axes(sheet, section, at, foot)
    end = _size(sheet, section, foot + 32.0) + 4.0
    lines = [y for shape in sheet.shapes if isinstance(shape, Line) for _, y in shape.points]
    spare = min(*lines, *(shape.at[1] - shape.size for shape in sheet.shapes if isinstance(shape, Text))) - 4.0
    sheet.raise_by(spare)
    return sheet.done(end - spare, worded=True)


def size_of(section: CrossSection) -> tuple[float, float]:
    """Width and height, m."""
    left, right, low, high = _extent(section)
    return right - left, high - low


def enlarged(section: CrossSection) -> float:
    """By which factor heights are drawn larger than widths."""
    return _scale(section)[1]


def _extent(section: CrossSection) -> tuple[float, float, float, float]:
    x = [one for one, _ in section.surface]
    y = [one for _, one in (*section.surface, *section.bottom)]
    return x[0], x[-1], min(y), max(y)


def _scale(section: CrossSection) -> tuple[float, float]:
    """Units of the sheet for a metre across, and by how much heights are enlarged."""
    wide, tall = size_of(section)
    tall = max(tall, 1e-9 * wide)
    across = min((_RIGHT - _LEFT) / wide, _TALLEST / tall)
    if across * tall >= _FLAT:
        return across, 1.0
    return across, next((one for one in _FACTORS if one * across * tall >= _LEAST), _FACTORS[-1])


def _regions(sheet: Sheet, section: CrossSection, at: To) -> None:
    thin: list[tuple[list[Point], Ink]] = []
    for region in section.regions:
        ink = region_ink(section, region)
        for piece in region.pieces:
            corners = [at(place) for place in piece]
            sheet.area(*corners, ink=ink)
            sheet.line(*corners, corners[0], ink="muted", width=0.8, dashed=bool(region.removed))
            if (middle := _thin_middle(piece, at)) and not region.removed:
                thin.append((middle, ink))
    for width in (4.0, 2.6):  # the band and its edges
        for middle, ink in thin:
            sheet.line(*middle, ink="muted" if width > 3.0 else ink, width=width)


def _thin_middle(piece: Sequence[Place], at: To) -> list[Point]:
    """The middle of a piece that would be too thin to be seen, from left to right; nothing for others."""
    places = sorted({x for x, _ in piece})
    spans = [(x, span) for x in places if (span := span_at(piece, x)) is not None]
    middle = [at((x, 0.5 * (low + high))) for x, (low, high) in spans]
    tall = [at((x, low))[1] - at((x, high))[1] for x, (low, high) in spans]
    wide = middle[-1][0] - middle[0][0] if middle else 0.0
    return middle if len(middle) > 1 and max(tall) < _VISIBLE and wide > 2.0 * _VISIBLE else []


def _even(line: Sequence[Point], apart: float, least: int = 1) -> Iterator[tuple[Point, Point, float]]:
    """Places along a line at equal distances: place, direction, and the index of the corner with the part after it."""
    lengths = [math.dist(a, b) for a, b in pairwise(line)]
    total = sum(lengths)
    count = max(least, round(total / apart))
    for one in range(count):
        gone, index = total * (one + 0.5) / count, 0
        while index + 1 < len(lengths) and gone > lengths[index]:
            gone -= lengths[index]
            index += 1
        if lengths[index] == 0.0:
            continue
        (x, y), (to_x, to_y) = line[index], line[index + 1]
        part, along = gone / lengths[index], ((to_x - x) / lengths[index], (to_y - y) / lengths[index])
        yield (x + part * (to_x - x), y + part * (to_y - y)), along, index + part


def _support(sheet: Sheet, support: Support, at: To) -> list[Point]:
    """Rollers where one displacement is zero, hatching where both are; where rollers stand."""
    line = [at(place) for place in support.line]
    inwards = _inwards(support.boundary)
    if support.how == "both":
        for (x, y), along, _ in _even(line, 9.0):
            across, down = inwards(along)
            sheet.line((x, y), (x - 6.0 * across - 4.0 * along[0], y - 6.0 * down - 4.0 * along[1]), ink="muted")
        return []
    rollers = []
    for (x, y), along, _ in _even(line, _APART):
        across, down = inwards(along)
        rollers.append((x - 3.4 * across, y - 3.4 * down))
        sheet.dot(rollers[-1], _ROLLER, "muted", filled=False)
    return rollers


def _inwards(boundary: str) -> Callable[[Point], Point]:
    """At right angles to a line of a boundary, into the body; it goes from left to right, or downwards."""
    sign = -1.0 if boundary.partition(".")[0] in ("left", "bottom") else 1.0
    return lambda along: (-sign * along[1], sign * along[0])


def _load(sheet: Sheet, load: BoundaryLoad, at: To) -> list[list[Point]]:
    """Arrows of a load, whose lengths are its size; their lines."""
    line, inwards = [at(place) for place in load.line], _inwards(load.boundary)
    arrows: list[list[Point]] = []
    for place, along, where in _even(line, _APART, 2):
        first = min(int(where), len(load.sizes) - 2)
        size = load.sizes[first] + (where - first) * (load.sizes[first + 1] - load.sizes[first])
        normal = inwards(along)
        into = normal if load.towards is None else (load.towards[0], -load.towards[1])
        onto = into[0] * normal[0] + into[1] * normal[1]
        reach = _reach(size)
        if abs(size) <= 0.05:
            continue
        if abs(onto) < 0.5:  # along the boundary
            beside = (place[0] - 6.0 * normal[0], place[1] - 6.0 * normal[1])
            start, end = ((beside[0] + d * into[0], beside[1] + d * into[1]) for d in (-6.0, 6.0))
        elif onto * size > 0.0:
            start, end = (place[0] - reach * into[0], place[1] - reach * into[1]), place
        else:
            sign = -1.0 if size < 0.0 else 1.0
            start, end = place, (place[0] + sign * reach * into[0], place[1] + sign * reach * into[1])
        sheet.arrow(start, end, "load", 1.2)
        arrows.append([start, end])
    if load.towards is None and arrows:
        arrows.append(_edge(line, load.sizes, inwards))
        sheet.line(*arrows[-1], ink="load", width=1.2)
    return arrows


def _reach(size: float) -> float:
    return 4.0 + (_ARROW - 4.0) * abs(size)


def _edge(line: Sequence[Point], sizes: Sequence[float], inwards: Callable[[Point], Point]) -> list[Point]:
    """Where arrows at right angles to a line begin."""
    found = []
    for index, ((x, y), size) in enumerate(zip(line, sizes, strict=True)):
        before, after = line[max(index - 1, 0)], line[min(index + 1, len(line) - 1)]
        length = math.dist(before, after) or 1.0
        across, down = inwards(((after[0] - before[0]) / length, (after[1] - before[1]) / length))
        found.append((x - _reach(size) * across, y - _reach(size) * down))
    return found


def _water(sheet: Sheet, load: BoundaryLoad, at: To) -> list[Point] | None:
    """The level of free water over the part of the boundary that lies below it, with its triangle."""
    level = load.water
    if level is None:
        return None
    wet = [x for x, y in load.line if y < level]
    for (x, y), (to_x, to_y) in pairwise(load.line):
        if (y - level) * (to_y - level) < 0.0:
            wet.append(x + (level - y) / (to_y - y) * (to_x - x))
    if not wet:
        return None
    start, end = at((min(wet), level)), at((max(wet), level))
    if end[0] - start[0] < 20.0:  # against a side
        start, end = (start[0] - 26.0, start[1]), start
        if not load.boundary.startswith("left"):
            start, end = end, (end[0] + 26.0, end[1])
    sheet.line(start, end, ink="water", width=1.6)
    x, y = 0.5 * (start[0] + end[0]), start[1]
    sheet.area((x - 5.0, y - 9.0), (x + 5.0, y - 9.0), (x, y - 0.5), ink="water")
    for down, half in ((3.0, 6.0), (6.0, 3.5)):
        sheet.line((x - half, y + down), (x + half, y + down), ink="water", width=1.2)
    return [start, end]


def _axes(sheet: Sheet, section: CrossSection, at: To, foot: float) -> None:
    """Axes in metres, with the size of the section, and how heights are drawn."""
    left, right, low, high = _extent(section)
    first, last = at((left, high)), at((right, low))
    x_axis = first[0] - 16.0
    sheet.line((first[0], foot), (last[0], foot), ink="muted", width=0.9)
    sheet.line((x_axis, first[1]), (x_axis, last[1]), ink="muted", width=0.9)
    for tick in linear_scale(left, right).ticks:
        if left <= tick <= right:
            x = at((tick, low))[0]
            sheet.line((x, foot), (x, foot + 3.0), ink="muted", width=0.9)
            sheet.text((x, foot + 14.0), number(tick), size=SMALL)
    previous = math.inf
    for tick in linear_scale(low, high).ticks:
        y = at((left, tick))[1]
        if low <= tick <= high and previous - y >= 12.0:
            sheet.line((x_axis - 3.0, y), (x_axis, y), ink="muted", width=0.9)
            sheet.text((x_axis - 5.0, y + 4.0), number(tick), "end", size=SMALL)
            previous = y
    sheet.text((x_axis - 26.0, first[1] - 16.0), "y [m]", "start", size=SMALL)
    sheet.text((min(last[0] + 36.0, _WIDTH - 1.0), foot - 2.0), "x [m]", "end", size=SMALL)


def _size(sheet: Sheet, section: CrossSection, y: float) -> float:
    """Write how large the section is and how it is drawn; where that ends."""
    wide, tall = size_of(section)
    text = f"{number(round(wide, 3))} m wide, {number(round(tall, 3))} m high"
    if enlarged(section) > 1.0:
        text += f"; heights drawn {enlarged(section):g} times larger"
    sheet.text((4.0, y), text, "start", "muted", SMALL)
    if not section.given:
        return y
    drawn = f"drawn for {', '.join(f'{name} = {value:g}' for name, value in section.given)}"
    sheet.text((4.0, y + 14.0), clipped(drawn, 50), "start", "muted", SMALL)
    return y + 14.0
