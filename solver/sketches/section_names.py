"""Names in a section: in its regions and at its points, interfaces and loads, each where it finds room."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import TypeAlias

from geoswarm.solver.sketches.declared import CrossSection, Place, Region
from geoswarm.solver.sketches.legend import clipped, load_symbols
from geoswarm.solver.sketches.marks import SMALL, Labels
from geoswarm.solver.sketches.shapes import Point, Sheet, text_width

__all__ = ["To", "name_parts", "span_at"]

_MOST_LABELLED, _MOST_BESIDE = 30, 12
"""Points, and regions beside which a name is written."""
_LONGEST = 24
"""Letters of a name."""

To: TypeAlias = Callable[[Place], Point]
"""From a place to a point of the sheet."""


def name_parts(
    sheet: Sheet,
    section: CrossSection,
    at: To,
    arrows: Sequence[Sequence[Sequence[Point]]],
    levels: Sequence[Sequence[Point]],
    rollers: Sequence[Point],
) -> float:
    """Names, as far as they find room; where the lowest one ends."""
    lines = [[at(place) for place in (*piece, piece[0])] for region in section.regions for piece in region.pieces]
    lines += [[at(place) for place in line] for interface in section.interfaces for line in interface.lines]
    lines += [list(arrow) for one in arrows for arrow in one]
    lowest = max(at(place)[1] for place in section.bottom)
    labels = Labels([*lines, *levels], (at(section.surface[0])[0] + 2.0, sheet.width - 2.0), (2.0, lowest + 44.0))
    for _, place in section.points:
        x, y = at(place)
        labels.keep_free(x - 2.6, x + 2.6, y - 2.6, y + 2.6)
    for x, y in rollers:
        labels.keep_free(x - 2.6, x + 2.6, y - 2.6, y + 2.6)
    symbols, written = load_symbols(section), set[str]()
    for load, drawn in zip(section.loads, arrows, strict=True):
        if load.value not in written and drawn:
            written.add(load.value)
            _value(sheet, labels, symbols[load.value], drawn)
    for name, place in section.points[:_MOST_LABELLED]:
        _flag(sheet, labels, name, at(place))
    beside = [one for one in section.regions if not _inside(sheet, labels, one, at)]
    for interface in section.interfaces:
        (x, y), (to_x, to_y) = at(interface.lines[0][0]), at(interface.lines[0][-1])
        if not _flag(sheet, labels, interface.name, (x, y)):
            half = 0.5 * text_width(interface.name, SMALL) + 4.0
            middle = (0.5 * (x + to_x), 0.5 * (y + to_y) + 4.0)
            labels.place(sheet, interface.name, [(middle[0] + d * half, middle[1]) for d in (-1.0, 1.0)])
    for region in beside[:_MOST_BESIDE]:
        lowest = max(lowest, _outside(sheet, labels, region, section, at))
    return lowest


def _value(sheet: Sheet, labels: Labels, text: str, arrows: Sequence[Sequence[Point]]) -> None:
    """The value of a load: over its arrows, or beside them."""
    tails = [arrow[0] for arrow in arrows if len(arrow) == 2] or [arrows[0][0]]
    half = 0.5 * text_width(text, SMALL)
    x, y = tails[len(tails) // 2]
    right, top = max(one for one, _ in tails), min(one for _, one in tails)
    left = min(one for one, _ in tails)
    middle = 0.5 * (left + right)
    labels.place(
        sheet,
        text,
        [(middle, top - 4.0), (right + half + 4.0, y + 4.0), (left - half - 4.0, y + 4.0), (x, y + 13.0)],
    )


def _flag(sheet: Sheet, labels: Labels, name: str, target: Point) -> bool:
    """Write a name over a place, or near it with a line to it; whether it found room."""
    half, (x, y) = 0.5 * text_width(name, SMALL), target
    if labels.place(sheet, name, [(x, y - 6.0), (x, y + 13.0)] if half < 12.0 else [(x, y - 6.0)]) is not None:
        return True
    levels = [-12.0, -25.0, -38.0, -51.0, 22.0, 35.0]
    places = [(x + d * (half + 4.0), y + down) for down in levels for d in (0.0, 0.7, -0.7, 1.4, -1.4)]
    return labels.place(sheet, name, places, of=lambda at: (x, y + math.copysign(3.6, at[1] - y))) is not None


def _middles(region: Region, at: To) -> Iterator[tuple[float, Point, float]]:
    """x of places in a region, the middle of the region there on the sheet, and its height on the sheet."""
    for piece in region.pieces:
        start, end = min(x for x, _ in piece), max(x for x, _ in piece)
        for part in (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9):
            x = start + part * (end - start)
            span = span_at(piece, x)
            if span is not None:
                (across, bottom), (_, top) = (at((x, y)) for y in span)
                yield x, (across, 0.5 * (bottom + top)), bottom - top


def _inside(sheet: Sheet, labels: Labels, region: Region, at: To) -> bool:
    """Write the name of a region where it finds room in it; whether it did."""
    places = [(tall, (x, y + 3.5)) for _, (x, y), tall in _middles(region, at) if tall > 11.5]
    places.sort(key=lambda one: -round(one[0] / 8.0))
    return labels.place(sheet, clipped(region.name, _LONGEST), [place for _, place in places]) is not None


def _outside(sheet: Sheet, labels: Labels, region: Region, section: CrossSection, at: To) -> float:
    """Write the name of a region over or below the section, with a line to the region; where it ends."""
    targets: list[tuple[Point, Point]] = []
    for x, middle, _ in _middles(region, at):
        top, base = (_height(line, x, at) for line in (section.surface, section.bottom))
        beside = [top - up for up in (8.0, 20.0)] if middle[1] - top < base - middle[1] else []
        targets += [((middle[0], y), middle) for y in (*beside, base + 18.0, base + 31.0)]
    targets.sort(key=lambda one: abs(one[0][1] - one[1][1]))

    def target(stands: Point) -> Point:
        return min(targets, key=lambda one: math.dist(one[0], stands))[1]

    found = labels.place(sheet, clipped(region.name, _LONGEST), [place for place, _ in targets], of=target)
    if found is None:
        return 0.0
    sheet.dot(target(found), 1.6, "muted")
    return found[1]


def _height(line: Sequence[Place], x: float, at: To) -> float:
    """Where a line from left to right lies at x, on the sheet."""
    for (a, y), (b, to_y) in pairwise(line):
        if a <= x <= b:
            return at((x, y + (x - a) / (b - a) * (to_y - y)))[1]
    return at(line[-1])[1]


def span_at(piece: Sequence[Place], x: float) -> tuple[float, float] | None:
    """Lowest and highest point of a region at x."""
    found = []
    for (a, y), (b, to_y) in pairwise([*piece, piece[0]]):
        if a != b and min(a, b) <= x <= max(a, b):
            found.append(y + (x - a) / (b - a) * (to_y - y))
    return (min(found), max(found)) if found else None
