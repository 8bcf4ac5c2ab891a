"""The values beside the line of a loading programme: each where it touches neither a line nor another value."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
from typing import TypeAlias

from geoswarm.solver.sketches.declared import Track
from geoswarm.solver.sketches.shapes import Point, Sheet, text_width
from geoswarm.solver.sketches.ticks import short

__all__ = ["SMALL", "Labels", "mark"]

SMALL = 11.0
"""Height of letters at axes and lines."""
_ABOVE, _BELOW, _BESIDE = 5.0, 13.0, 5.0
"""Of a baseline over and under a line, and of a text from a line at its side."""
_TALL = 8.5
"""Of figures."""
_AIR = 1.5
"""Between a text and a line or another text."""
_MOST_TRIED = 120

Box: TypeAlias = tuple[float, float, float, float]
"""x from, x to, y from, y to."""


class Labels:
    """What is written beside the lines of a panel.

    Parameters
    ----------
    lines
        Corners of each line, on the sheet.
    across, down
        x and y between which texts stand.
    """

    def __init__(
        self, lines: Sequence[Sequence[Point]], across: tuple[float, float], down: tuple[float, float]
    ) -> None:
        self._pieces = [_bounded(*piece) for line in lines for piece in pairwise(line)]
        self._across, self._down = across, down
        self._taken: list[Box] = []

    def keep_free(self, left: float, right: float, top: float, bottom: float) -> None:
        """Let nothing be written there."""
        self._taken.append((left, right, top, bottom))

    def place(
        self, sheet: Sheet, text: str, places: Iterable[Point], *, of: Callable[[Point], Point] | None = None
    ) -> Point | None:
        """Write a text at the first of the places, middles of baselines, where it is free; nowhere where none is.

        Parameters
        ----------
        of
            Gives for a place what the text belongs to: a thin line leads there, and crosses no other text.

        Returns
        -------
        Where it stands; None where it does not.
        """
        half = 0.5 * text_width(text, SMALL)
        low, high = self._across
        for x, y in places:
            middle = min(max(x, low + half), high - half)
            box = (middle - half - _AIR, middle + half + _AIR, y - _TALL - _AIR, y + _AIR)
            if not (self._down[0] <= y - _TALL and y <= self._down[1] and self._free(box)):
                continue
            if of is not None:
                end = of((middle, y))
                start = (middle, y + 2.0 if end[1] > y else y - _TALL - 1.0)
                if any(_crossing(start, end, taken) for taken in self._taken):
                    continue
                sheet.line(start, end, ink="muted", width=0.7)
                self._pieces.append(_bounded(start, end))
            self._taken.append(box)
            sheet.text((middle, y), text, size=SMALL)
            return middle, y
        return None

    def _free(self, box: Box) -> bool:
        left, right, top, bottom = box
        if any(left < b and right > a and top < d and bottom > c for a, b, c, d in self._taken):
            return False
        near = (
            piece
            for (a, b, c, d), piece in self._pieces
            if a < right and b > left and c < bottom and d > top  # most pieces of large sections lie elsewhere
        )
        return not any(_crossing(start, end, box) for start, end in near)


def _bounded(start: Point, end: Point) -> tuple[Box, tuple[Point, Point]]:
    (x, y), (to_x, to_y) = start, end
    return (min(x, to_x), max(x, to_x), min(y, to_y), max(y, to_y)), (start, end)


def _crossing(start: Point, end: Point, box: Box) -> bool:
    """Whether a piece of a line passes through a box: whether its parts within both strips overlap."""
    enter, leave = 0.0, 1.0
    for one, other, low, high in ((start[0], end[0], *box[:2]), (start[1], end[1], *box[2:])):
        if max(one, other) <= low or min(one, other) >= high:
            return False
        if one != other:
            first, last = sorted(((low - one) / (other - one), (high - one) / (other - one)))
            enter, leave = max(enter, first), min(leave, last)
    return enter < leave


def mark(sheet: Sheet, labels: Labels, track: Track, points: Sequence[Point], *, named: bool) -> None:
    """Write the values of a track as far as they find room, turning points first.

    Parameters
    ----------
    points
        Its corners on the sheet.
    named
        Whether its symbol stands at its end.
    """
    if named:
        x, y = points[-1]
        text = track.symbol
        labels.place(sheet, text, iter([(x - 0.5 * text_width(text, SMALL), y + d) for d in (-_ABOVE, _BELOW)]))
    for number in sorted(track.marks, key=lambda number: (not _turns(points, number), number))[:_MOST_TRIED]:
        text = short(track.points[number][1])
        labels.place(sheet, text, _places(points, number, text_width(text, SMALL)))


def _level(points: Sequence[Point], number: int) -> tuple[int, int]:
    """First and last corner of the level part that a corner is on."""
    first = last = number
    while first > 0 and points[first - 1][1] == points[number][1]:
        first -= 1
    while last + 1 < len(points) and points[last + 1][1] == points[number][1]:
        last += 1
    return first, last


def _sides(points: Sequence[Point], number: int) -> tuple[float, float]:
    """How far below a corner, on the sheet, the line comes from and goes to; 0 at its ends."""
    first, last = _level(points, number)
    y = points[number][1]
    before = points[first - 1][1] - y if first else 0.0
    return before, points[last + 1][1] - y if last + 1 < len(points) else 0.0


def _turns(points: Sequence[Point], number: int) -> bool:
    before, after = _sides(points, number)
    return before * after >= 0.0


def _places(points: Sequence[Point], number: int, wide: float) -> Iterator[Point]:
    """Over or under the middle of what stays level, then at its free side; at the end of what moves."""
    first, last = _level(points, number)
    before, after = _sides(points, number)
    y = points[number][1]
    begin, end = points[first][0], points[last][0]
    middle = 0.5 * (begin + end) if end > begin else begin - (0.5 * wide if before > 0.0 else 0.0)
    valley = before < 0.0 or (before == 0.0 and after < 0.0)
    over, under = (middle, y - _ABOVE), (middle, y + _BELOW)
    yield from (under, over) if valley and after <= 0.0 else (over, under)
    left, right = begin - _BESIDE - 0.5 * wide, end + _BESIDE + 0.5 * wide
    for level in (y + 0.35 * _TALL, y - 1.0, y + _TALL):
        yield (left, level) if before > 0.0 else (right, level)
    yield begin - 0.5 * wide, y - _ABOVE
    yield end + 0.5 * wide, y - _ABOVE
