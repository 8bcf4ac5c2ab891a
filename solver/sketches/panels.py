"""The shapes of a loading programme: panels below each other, loads or strains over time or over stages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from geoswarm.solver.sketches.declared import Panel, Track
from geoswarm.solver.sketches.marks import SMALL, Labels, mark
from geoswarm.solver.sketches.shapes import Drawing, Point, Sheet, text_width
from geoswarm.solver.sketches.ticks import Scale, linear_scale, log_scale, short

__all__ = ["draw_programme"]

Place: TypeAlias = Callable[[Point], Point]
"""From x and y of a panel to a point of the sheet."""

_WIDTH = 270.0
_LEFT, _RIGHT = 46.0, 256.0
_HEIGHTS = {1: 150.0, 2: 84.0}
_LOWEST = 72.0
"""Of each of many panels."""
_HEAD, _FOOT = 22.0, 34.0
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
        sheet.text((_LEFT - 5.0, level + 4.0), short(tick), "end", size=SMALL)
    if not y.log and y.low < 0.0 < y.high:
        level = at((x.low, 0.0))[1]
        sheet.line((_LEFT, level), (_RIGHT, level), ink="muted", width=0.8)
    sheet.line((_LEFT, top), (_LEFT, bottom), (_RIGHT, bottom), ink="muted", width=0.9)
    _x_ticks(sheet, x, bottom)
    head = f"{panel.symbol} [{panel.unit or '-'}]"
    sheet.text((4.0, top - 10.0), head, "start")
    title = f"{panel.x} [{panel.x_unit}]" if panel.x_unit else panel.x
    if x.log:
        title += ", logarithmic"
    sheet.text((_RIGHT, bottom + 27.0), title, "end", size=SMALL)
    for start, end, words in panel.cycles:
        left, right = _of_cycles(at((start, y.high))[0], at((end, y.high))[0], words)
        sheet.text((0.5 * (left + right), top - 4.0), words, size=SMALL)
    for track in panel.tracks:
        _line(sheet, track, at)
    corners = [[at(point) for point in track.points] for track in panel.tracks]
    labels = Labels(corners, (_LEFT + 2.0, _WIDTH), (top - 18.0, bottom - 1.0))
    labels.keep_free(4.0, 4.0 + text_width(head), top - 20.0, top - 6.0)
    for start, end, words in panel.cycles:
        labels.keep_free(*_of_cycles(at((start, y.high))[0], at((end, y.high))[0], words), top - 14.0, top - 2.0)
    for track, points in zip(panel.tracks, corners, strict=True):
        mark(sheet, labels, track, points, named=len(panel.tracks) > 1)


def _of_cycles(first: float, last: float, words: str) -> tuple[float, float]:
    """Where what is said of cycles between two x begins and ends."""
    half = 0.5 * text_width(words, SMALL)
    middle = min(max(0.5 * (first + last), _LEFT + 20.0 + half), _WIDTH - half)
    return middle - half, middle + half


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
        half = 0.5 * text_width(short(tick), SMALL)
        if place - half > end and place + half <= _WIDTH:
            sheet.text((place, bottom + 14.0), short(tick), size=SMALL)
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
