"""The shapes of a loading programme: panels below each other, loads or strains over time or over stages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from geoswarm.solver.sketches.declared import Panel, Track
from geoswarm.solver.sketches.shapes import Drawing, Point, Sheet, text_width
from geoswarm.solver.sketches.ticks import Scale, linear_scale, log_scale, short

__all__ = ["draw_programme"]

Place: TypeAlias = Callable[[Point], Point]
"""From x and y of a panel to a point of the sheet."""
Box: TypeAlias = tuple[float, float, float, float]
"""x from, x to, y from, y to."""

_WIDTH = 270.0
_LEFT, _RIGHT = 46.0, 256.0
_HEIGHTS = {1: 150.0, 2: 84.0}
_LOWEST = 72.0
"""Of each of many panels."""
_HEAD, _FOOT = 22.0, 34.0
_SMALL = 11.0
_WIDE_STRESS, _WIDE_TIME = 20.0, 50.0
"""Largest over smallest value from which an axis is logarithmic."""
_BEFORE = 0.1
"""Where a logarithmic time begins, as a part of the first duration."""


def draw_programme(panels: Sequence[Panel]) -> Drawing:
    """Draw the panels of a programme."""
    sheet = Sheet(_WIDTH)
    top, tall = 0.0, _HEIGHTS.get(len(panels), _LOWEST)
    for panel in panels:
        _panel(sheet, panel, top + _HEAD, tall)
        top += _HEAD + tall + _FOOT
    return sheet.done(top)


def _panel(sheet: Sheet, panel: Panel, top: float, tall: float) -> None:
    x, y = _x_scale(panel), _y_scale(panel)

    def at(point: tuple[float, float]) -> tuple[float, float]:
        return _LEFT + (_RIGHT - _LEFT) * x.part(point[0]), top + tall * (1.0 - y.part(point[1]))

    bottom = top + tall
    for tick in y.ticks:
        level = at((x.low, tick))[1]
        sheet.line((_LEFT, level), (_RIGHT, level), ink="grid", width=0.7)
        sheet.text((_LEFT - 5.0, level + 4.0), short(tick), "end", size=_SMALL)
    if not y.log and y.low < 0.0 < y.high:
        level = at((x.low, 0.0))[1]
        sheet.line((_LEFT, level), (_RIGHT, level), ink="muted", width=0.8)
    sheet.line((_LEFT, top), (_LEFT, bottom), (_RIGHT, bottom), ink="muted", width=0.9)
    _x_ticks(sheet, x, bottom)
    sheet.text((4.0, top - 10.0), f"{panel.symbol} [{panel.unit or '-'}]", "start")
    title = f"{panel.x} [{panel.x_unit}]" if panel.x_unit else panel.x
    if x.log:
        title += ", logarithmic"
    sheet.text((_RIGHT, bottom + 27.0), title, "end", size=_SMALL)
    for start, end, words in panel.cycles:
        first, last = at((start, y.high))[0], at((end, y.high))[0]
        half = 0.5 * text_width(words, _SMALL)
        middle = min(max(0.5 * (first + last), _LEFT + 20.0 + half), _WIDTH - half)
        sheet.text((middle, top - 4.0), words, size=_SMALL)
    for track in panel.tracks:
        _line(sheet, track, at)
    taken: list[Box] = []
    for track in panel.tracks:
        _marks(sheet, track, at, taken, named=len(panel.tracks) > 1, over=top)


def _x_scale(panel: Panel) -> Scale:
    values = [x for track in panel.tracks for x, _ in track.points]
    if panel.x == "stage":
        last = max(*values, panel.last)
        every = max(1, -(-int(last) // 8))
        return Scale(0.0, max(last, 1.0), tuple(float(n) for n in range(every, int(last) + 1, every)))
    ends = sorted({x for x in (*values, panel.last) if x > 0.0})
    steps = [b - a for a, b in zip([0.0, *ends], ends, strict=False)]
    longest = max(steps)
    if longest > _WIDE_TIME * ends[0]:
        return log_scale(_BEFORE * ends[0], ends[-1])
    found = linear_scale(0.0, ends[-1])
    return Scale(0.0, ends[-1], tuple(tick for tick in found.ticks if tick <= ends[-1]))


def _y_scale(panel: Panel) -> Scale:
    values = [y for track in panel.tracks for _, y in track.points]
    low, high = min(values), max(values)
    if panel.unit == "kPa" and low > 0.0 and high > _WIDE_STRESS * low:
        return log_scale(low / 1.3, high * 1.3)
    return linear_scale(min(low, 0.0), max(high, 0.0))


def _x_ticks(sheet: Sheet, x: Scale, bottom: float) -> None:
    end = -1.0
    for tick in x.ticks:
        place = _LEFT + (_RIGHT - _LEFT) * x.part(tick)
        sheet.line((place, bottom), (place, bottom + 3.0), ink="muted", width=0.9)
        half = 0.5 * text_width(short(tick), _SMALL)
        if place - half > end and place + half <= _WIDTH:
            sheet.text((place, bottom + 14.0), short(tick), size=_SMALL)
            end = place + half + 4.0


def _line(sheet: Sheet, track: Track, at: Place) -> None:
    """Solid, dotted where something else is led."""
    piece = [at(track.points[0])]
    for number, point in enumerate(track.points[1:], start=1):
        if number in track.free:
            if len(piece) > 1:
                sheet.line(*piece, ink="load", width=1.8)
            sheet.line(piece[-1], at(point), ink="load", width=1.2, dashed=True)
            piece = [at(point)]
        else:
            piece.append(at(point))
    if len(piece) > 1:
        sheet.line(*piece, ink="load", width=1.8)


def _marks(sheet: Sheet, track: Track, at: Place, taken: list[Box], *, named: bool, over: float) -> None:
    """Values, as far as they find room: over the middle of what stays, else at the end of what moves."""
    if named:
        x, y = at(track.points[-1])
        _placed(sheet, (x - 0.5 * text_width(track.symbol, _SMALL), y), track.symbol, taken, over)
    for number in track.marks:
        x, y = at(track.points[number])
        text = short(track.points[number][1])
        before, level = at(track.points[number - 1]) if number else (x, y)
        after = at(track.points[number + 1])[1] if number + 1 < len(track.points) else y
        if level == y:
            x = 0.5 * (x + before)
        elif level > y or after == y:  # left of the end, on the free side of the line
            x -= 0.5 * text_width(text, _SMALL) + (0.0 if level > y else 16.0)
            y += 0.0 if level > y else 3.0
        _placed(sheet, (x, y), text, taken, over, below=level < y and after < y)


def _placed(sheet: Sheet, at: Point, text: str, taken: list[Box], over: float, *, below: bool = False) -> None:
    """Write a text above a point or below it, unless something is there."""
    wide = text_width(text, _SMALL)
    middle = min(max(at[0], _LEFT + 0.5 * wide + 2.0), _WIDTH - 0.5 * wide)
    places = (at[1] + 13.0, at[1] - 4.0) if below else (at[1] - 4.0, at[1] + 13.0)
    for y in places:
        box = (middle - 0.5 * wide, middle + 0.5 * wide, y - 9.0, y + 2.0)
        free = all(box[0] > b or box[1] < a or box[2] > d or box[3] < c for a, b, c, d in taken)
        if free and y - 9.0 > over - (_HEAD if box[0] > _LEFT + 24.0 else 8.0):
            taken.append(box)
            sheet.text((middle, y), text, size=_SMALL)
            return
