"""The shapes of a specimen in its apparatus."""

from __future__ import annotations

import textwrap

from geoswarm.solver.sketches.declared import End, SpecimenSketch
from geoswarm.solver.sketches.shapes import Drawing, Sheet, text_width
from geoswarm.solver.sketches.ticks import specimen_length

__all__ = ["draw_specimen"]

_WIDTH = 270.0
_WIDEST = {"ring": 124.0, "membrane": 84.0, "sliding rings": 124.0}
_TALLEST = 128.0
_USUAL = {"ring": 0.42, "membrane": 1.8, "sliding rings": 0.42}
"""Height over diameter where the problem does not give both."""
_FLATTEST, _SLIMMEST = 0.28, 1.8
_TOP = 52.0
"""Of the platen."""
_PLATEN, _STONE, _RING = 7.0, 10.0, 9.0
_NAME = 11.0


def draw_specimen(specimen: SpecimenSketch) -> Drawing:
    """Draw a specimen with what acts on it, to scale as far as it can be read."""
    sheet = Sheet(_WIDTH)
    width, height = _size(specimen)
    left = 0.5 * (_WIDTH - width)
    top = _TOP + _PLATEN + _STONE
    base = top + height
    sheet.box(left - 2.0, _TOP, width + 4.0, _PLATEN, "steel")
    _end(sheet, specimen.top, left, top - _STONE, width)
    sheet.box(left, top, width, height, "soil")
    _end(sheet, specimen.base, left, base, width)
    sheet.box(left - 24.0, base + _STONE, width + 48.0, _PLATEN, "steel")
    outside = _side(sheet, specimen, left, top, width, height)
    _name(sheet, specimen.material, left, top, width, height)
    _loads(sheet, specimen, left, top, width, height)
    _water(sheet, specimen, left, base)
    _readings(sheet, specimen, left, top, width, height)
    if specimen.height is not None:
        sheet.dimension((left - outside, top), (left - outside, base), f"h = {specimen_length(specimen.height)}")
    bottom = base + _STONE + _PLATEN
    drips = specimen.base == "drained"
    if specimen.diameter is not None:
        level = bottom + (26.0 if drips else 12.0)
        sheet.dimension((left, level), (left + width, level), f"d = {specimen_length(specimen.diameter)}")
        bottom = level + 14.0
    elif drips or any(one.where == "base" for one in specimen.readings):
        bottom += 20.0
    return sheet.done(bottom + 6.0)


def _size(specimen: SpecimenSketch) -> tuple[float, float]:
    ratio = _USUAL[specimen.held]
    if specimen.height is not None and specimen.diameter is not None:
        ratio = specimen.height / specimen.diameter
    ratio = min(max(ratio, _FLATTEST), _SLIMMEST)
    width = min(_WIDEST[specimen.held], _TALLEST / ratio)
    return width, width * ratio


def _end(sheet: Sheet, end: End, left: float, y: float, width: float) -> None:
    """A porous stone, or a plate."""
    if end == "closed":
        sheet.box(left, y, width, _STONE, "steel")
        return
    sheet.box(left, y, width, _STONE, "stone")
    count = max(int(width / 9.0), 2)
    for number in range(count):
        x = left + (number + 0.5) * width / count
        sheet.dot((x, y + _STONE * (0.33 if number % 2 else 0.67)), 1.1, "muted")


def _side(sheet: Sheet, specimen: SpecimenSketch, left: float, top: float, width: float, height: float) -> float:
    """What holds the side; how far from the specimen the height can be written."""
    right, base = left + width, top + height
    if specimen.held == "ring":
        for x in (left - _RING, right):
            sheet.box(x, top - _STONE + 2.0, _RING, height + _STONE * 2.0 - 2.0, "steel")
        return _RING + 18.0
    if specimen.held == "sliding rings":
        count = 7
        for x in (left - _RING, right):
            for number in range(count):
                sheet.box(x, top + number * height / count, _RING, height / count - 1.5, "steel")
        return _RING + 18.0
    for x in (left - 2.0, right + 2.0):
        sheet.line((x, top - _STONE), (x, base + _STONE), ink="ink", width=1.6)
    return 14.0 if specimen.lateral is None else 46.0


def _name(sheet: Sheet, material: str, left: float, top: float, width: float, height: float) -> None:
    """The law, inside."""
    lines = textwrap.wrap(material, max(int((width - 6.0) / text_width("x", _NAME)), 9)) or [""]
    size = min(
        _NAME, _NAME * (width - 4.0) / max(text_width(line, _NAME) for line in lines if line) if material else _NAME
    )
    first = top + 0.5 * height - 0.5 * (len(lines) - 1) * (size + 2.0) + 0.35 * size
    for number, line in enumerate(lines):
        sheet.text((left + 0.5 * width, first + number * (size + 2.0)), line, size=size)


def _loads(sheet: Sheet, specimen: SpecimenSketch, left: float, top: float, width: float, height: float) -> None:
    middle = left + 0.5 * width
    for part in (0.3, 0.5, 0.7):
        sheet.arrow((left + part * width, 22.0), (left + part * width, _TOP - 1.0), "load")
    sheet.text((middle, 16.0), specimen.vertical.symbol)
    if specimen.lateral is not None:
        for part in (0.15, 0.5, 0.85):
            y = top + part * height
            sheet.arrow((left - 36.0, y), (left - 5.0, y), "load")
            sheet.arrow((left + width + 36.0, y), (left + width + 5.0, y), "load")
        sheet.text((left + width + 40.0, top + 0.5 * height + 4.0), specimen.lateral.symbol, "start")
    if specimen.shear is not None:
        level = _TOP + 3.5
        sheet.arrow((left - 40.0, level), (left - 4.0, level), "load", 2.0)
        sheet.text((left - 22.0, level - 7.0), specimen.shear.symbol)


def _water(sheet: Sheet, specimen: SpecimenSketch, left: float, base: float) -> None:
    """Where water leaves, and under which pressure; a cross where a valve is shut."""
    below = base + _STONE + _PLATEN
    x = left + 5.0
    ends = ((specimen.top, (x, _TOP + _PLATEN + 5.0), (x, 28.0)), (specimen.base, (x, base + 5.0), (x, below + 18.0)))
    for end, start, out in ends:
        if end == "drained":
            sheet.arrow(start, out, "water")
        elif end == "shut":
            level = 0.5 * (start[1] + out[1]) + (0.25 * (out[1] - start[1]))
            sheet.line(start, (start[0], level), ink="water", width=1.4)
            for way in (-4.0, 4.0):
                sheet.line((start[0] - 4.0, level - way), (start[0] + 4.0, level + way), ink="water", width=1.4)
    if specimen.back_pressure > 0.0:
        sheet.text((left - 3.0, 31.0), "u₀ =", "end")
        sheet.text((left - 3.0, 45.0), f"{specimen.back_pressure:g} kPa", "end")


def _readings(sheet: Sheet, specimen: SpecimenSketch, left: float, top: float, width: float, height: float) -> None:
    """A gauge with its symbol wherever something is measured."""
    right, base = left + width, top + height
    beside = right + 26.0
    symbols: dict[str, str] = {}
    for one in specimen.readings:
        symbols[one.where] = f"{symbols[one.where]}, {one.symbol}" if one.where in symbols else one.symbol
    if "top" in symbols:
        sheet.line(
            (right + 2.0, _TOP + 2.0), (beside - 6.0, _TOP + 2.0), (beside - 6.0, 30.0), ink="reading", width=1.4
        )
        _gauge(sheet, (beside - 6.0, 24.0), symbols["top"])
    if "base" in symbols:
        y = base + _STONE + _PLATEN + 10.0
        sheet.line((right - 12.0, base + 2.0), (right - 12.0, y), (beside, y), ink="reading", width=1.4)
        _gauge(sheet, (beside + 6.0, y), symbols["base"])
    if "inside" in symbols:
        y = top + 0.82 * height
        sheet.dot((right - 12.0, y), 2.6, "reading")
        sheet.line((right - 12.0, y), (beside, y), ink="reading", width=1.4)
        _gauge(sheet, (beside + 6.0, y), symbols["inside"])
    if "side" in symbols:
        y = top + 0.325 * height
        sheet.line((right + 2.0, y), (beside + 22.0, y), ink="reading", width=1.4)
        _gauge(sheet, (beside + 28.0, y), symbols["side"])
    if "water" in symbols:
        y = base + _STONE + _PLATEN + 10.0
        sheet.line((left + 5.0, y), (left - 14.0, y), ink="reading", width=1.4)
        sheet.dot((left - 20.0, y), 6.0, "reading", filled=False)
        sheet.text((left - 30.0, y + 4.0), symbols["water"], "end")


def _gauge(sheet: Sheet, centre: tuple[float, float], symbol: str) -> None:
    sheet.dot(centre, 6.0, "reading", filled=False)
    sheet.line(centre, (centre[0] + 3.0, centre[1] - 3.0), ink="reading")
    sheet.text((centre[0] + 10.0, centre[1] + 4.0), symbol, "start")
