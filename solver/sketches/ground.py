"""The shapes of layered ground under a load."""

from __future__ import annotations

from geoswarm.solver.sketches.declared import Ground
from geoswarm.solver.sketches.shapes import Drawing, Ink, Sheet, text_width
from geoswarm.solver.sketches.ticks import ground_length

__all__ = ["draw_ground"]

_WIDTH = 270.0
_LEFT, _RIGHT = 62.0, 196.0
_SURFACE, _DEEP = 66.0, 190.0
_APART = 13.0
"""Least distance of two lines of text."""
_MOST_WATER = 14.0


def draw_ground(ground: Ground) -> Drawing:
    """Draw layers to scale, with their names where these find room, water, drains and instruments."""
    sheet = Sheet(_WIDTH)
    height = sum(layer.thickness for layer in ground.layers)
    bottom = _SURFACE + _DEEP

    def at(depth: float) -> float:
        return _SURFACE + _DEEP * depth / height

    _layers(sheet, ground, height)
    _loads(sheet, ground)
    if ground.drains is not None:
        for part in (0.12, 0.37, 0.62, 0.87):
            x = _LEFT + part * (_RIGHT - _LEFT)
            sheet.line((x, at(ground.drains.top)), (x, at(ground.drains.bottom)), ink="water", width=2.2, dashed=True)
    _water(sheet, ground, height)
    _names(sheet, ground, height)
    for x in (_LEFT, _RIGHT):
        sheet.line((x, _SURFACE), (x, bottom), ink="muted", width=0.8)
    sheet.line((_LEFT - 8.0, _SURFACE), (_RIGHT + 8.0, _SURFACE), width=1.6)
    _base(sheet, ground.base_drained, bottom)
    _depths(sheet, ground, height)
    _instruments(sheet, ground, height)
    return sheet.done(bottom + 34.0)


def _layers(sheet: Sheet, ground: Ground, height: float) -> None:
    depth = 0.0
    for number, layer in enumerate(ground.layers):
        y, tall = _SURFACE + _DEEP * depth / height, _DEEP * layer.thickness / height
        sheet.box(_LEFT, y, _RIGHT - _LEFT, tall, _ink(number), outlined=False)
        sheet.line((_LEFT, y), (_RIGHT, y), ink="muted", width=0.8)
        depth += layer.thickness


def _names(sheet: Sheet, ground: Ground, height: float) -> None:
    """Name and thickness of a layer where they find room, and the law below them."""
    depth, middle = 0.0, 0.5 * (_LEFT + _RIGHT)
    for number, layer in enumerate(ground.layers):
        tall = _DEEP * layer.thickness / height
        y = _SURFACE + _DEEP * (depth + 0.5 * layer.thickness) / height
        depth += layer.thickness
        if tall < _APART:
            continue
        name = f"{layer.soil}, {ground_length(layer.thickness)}"
        room = _RIGHT - _LEFT - 30.0
        size = min(12.0, 12.0 * room / text_width(name))
        two = tall > 2.4 * _APART
        _over(sheet, (middle, y + (-2.0 if two else 4.0)), name, size, _ink(number))
        if two:
            small = min(10.5, 10.5 * room / text_width(layer.material, 10.5))
            _over(sheet, (middle, y + 11.0), layer.material, small, _ink(number))


def _over(sheet: Sheet, at: tuple[float, float], text: str, size: float, ink: Ink) -> None:
    """A text that stays readable over drains and water: it has the colour of its layer behind it."""
    wide = 0.92 * text_width(text, size)
    sheet.box(at[0] - 0.5 * wide, at[1] - 0.8 * size, wide, size, ink, outlined=False)
    sheet.text(at, text, size=size)


def _ink(number: int) -> Ink:
    """Layers take turns."""
    return "soil" if number % 2 else "stone"


def _loads(sheet: Sheet, ground: Ground) -> None:
    level = _SURFACE - 34.0
    for part in (0.1, 0.3, 0.5, 0.7, 0.9):
        x = _LEFT + part * (_RIGHT - _LEFT)
        sheet.arrow((x, level), (x, _SURFACE - 2.0), "load")
    sheet.line(
        (_LEFT + 0.05 * (_RIGHT - _LEFT), level), (_RIGHT - 0.05 * (_RIGHT - _LEFT), level), ink="load", width=1.4
    )
    sheet.text((0.5 * (_LEFT + _RIGHT), level - 8.0), ground.load.symbol)


def _water(sheet: Sheet, ground: Ground, height: float) -> None:
    """The water table with its triangle."""
    depth = ground.water_table
    if depth > height:
        return
    y = _SURFACE + (_DEEP * depth / height if depth >= 0.0 else -min(_MOST_WATER, -_DEEP * depth / height))
    sheet.line((_LEFT - 6.0, y), (_RIGHT + 6.0, y), ink="water", width=1.4, dashed=depth > 0.0)
    x = _LEFT + 9.0
    sheet.area((x - 5.0, y - 9.0), (x + 5.0, y - 9.0), (x, y - 0.5), ink="water")


def _base(sheet: Sheet, drained: bool, bottom: float) -> None:
    if drained:
        sheet.box(_LEFT, bottom, _RIGHT - _LEFT, 8.0, "stone")
        for part in (0.2, 0.5, 0.8):
            x = _LEFT + part * (_RIGHT - _LEFT)
            sheet.dot((x, bottom + 4.0), 1.3, "muted")
            sheet.arrow((x + 8.0, bottom + 4.0), (x + 8.0, bottom + 26.0), "water")
        return
    sheet.line((_LEFT - 8.0, bottom), (_RIGHT + 8.0, bottom), width=1.6)
    count = 13
    for number in range(count):
        x = _LEFT + (number + 0.6) * (_RIGHT - _LEFT) / count
        sheet.line((x, bottom), (x - 7.0, bottom + 8.0), ink="muted", width=0.9)


def _depths(sheet: Sheet, ground: Ground, height: float) -> None:
    """Depths of the bounds of layers, those that do not collide, and of the water."""
    sheet.text((4.0, _SURFACE - 22.0), "depth", "start", "muted", 11.0)
    sheet.text((4.0, _SURFACE - 9.0), "[m]", "start", "muted", 11.0)
    wanted, depth = [0.0, height], 0.0
    for layer in ground.layers[:-1]:
        depth += layer.thickness
        wanted.append(depth)
    if 0.0 < ground.water_table < height:
        wanted.append(ground.water_table)
    taken: list[float] = []
    for one in wanted:
        y = _SURFACE + _DEEP * one / height
        if all(abs(y - other) >= _APART for other in taken):
            taken.append(y)
            sheet.text((_LEFT - 12.0, y + 4.0), f"{one:.4g}", "end", size=11.0)
            sheet.line((_LEFT - 8.0, y), (_LEFT, y), ink="muted", width=0.9)


def _instruments(sheet: Sheet, ground: Ground, height: float) -> None:
    """Marks at their depths, names beside them as far as they find room."""
    last, left_out = _SURFACE - _APART, 0
    for name, depth in sorted(ground.instruments, key=lambda one: one[1]):
        y = _SURFACE + _DEEP * depth / height
        sheet.dot((_RIGHT - 8.0, y), 3.0, "reading")
        place = max(y, last + _APART)
        if place > _SURFACE + _DEEP + 4.0 or text_width(name, 11.0) > _WIDTH - _RIGHT - 14.0:
            left_out += 1
            continue
        sheet.line((_RIGHT - 8.0, y), (_RIGHT + 6.0, y), (_RIGHT + 12.0, place), ink="reading")
        sheet.text((_RIGHT + 15.0, place + 4.0), name, "start", size=11.0)
        last = place
    if left_out:
        sheet.text((_WIDTH - 2.0, _SURFACE + _DEEP + 24.0), f"{left_out} more", "end", "muted", 11.0)
