"""The legend of a section: what its parts are, a row each, in shapes and in words."""

from __future__ import annotations

import textwrap

from geoswarm.solver.sketches.declared import CrossSection, Region
from geoswarm.solver.sketches.marks import SMALL
from geoswarm.solver.sketches.shapes import Drawing, Ink, Sheet, text_width
from geoswarm.solver.sketches.ticks import number

__all__ = ["WIDTH", "clipped", "draw_legend", "legend_words", "load_symbols", "region_ink", "wrapped"]

WIDTH = 270.0
"""Of the sheet of a legend."""
_ROW, _LINE = 16.0, 13.0
_MOST_ROWS = 16
_INKS: tuple[Ink, ...] = ("soil", "stone", "steel")
"""Of layers in turns; pieces of layers have another one."""
_SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def region_ink(section: CrossSection, region: Region) -> Ink:
    if region.removed:
        return "grid"
    if region.kind == "zone":
        return "marl"
    layers = [one.name for one in section.regions if one.kind == "layer"]
    return _INKS[layers.index(region.name) % len(_INKS)]


def load_symbols(section: CrossSection) -> dict[str, str]:
    """What is written beside a load, by its value: the value itself where it is short, else a symbol."""
    found: dict[str, str] = {}
    for load in section.loads:
        if load.value not in found:
            long = len(load.value) > 10
            found[load.value] = f"p{len(found) + 1}".translate(_SUBSCRIPTS) if long else load.value
    return found


def clipped(text: str, most: int) -> str:
    """A text, cut where it is longer than a number of letters."""
    return text if len(text) <= most else f"{text[: most - 1].rstrip()}…"


def wrapped(text: str, room: float) -> list[str]:
    """A text in up to three lines, cut where it is longer."""
    most = int(room / text_width("x", SMALL))
    return [clipped(line, most) for line in textwrap.wrap(text, most, max_lines=3, placeholder="…")] or [""]


def _region_text(region: Region) -> str:
    """What a region is: size, materials in the order of the phases, and law."""
    text = region.name + (f", {region.size}" if region.size else "")
    if region.materials:
        text += f": {' → '.join(region.materials)}"
    if region.law and region.law != region.materials[-1].replace("_", " "):
        text += f" ({region.law})"
    if region.removed:
        return f"{text}, removed in {region.removed}"
    return f"{text}, from {region.since}" if region.since else text


def draw_legend(section: CrossSection) -> Drawing:
    """Draw what the parts of a section are, a row each."""
    sheet, y, rows = Sheet(WIDTH), 9.0, _rows(section)
    left_out = len(rows) - _MOST_ROWS
    if left_out > 0:
        rows = rows[: _MOST_ROWS - 1]
    for symbol, ink, text in rows:
        _symbol(sheet, symbol, ink, y)
        for line in wrapped(text, WIDTH - 26.0):
            sheet.text((24.0, y + 4.0), line, "start", size=SMALL)
            y += _LINE
        y += _ROW - _LINE
    if left_out > 0:
        sheet.text((24.0, y + 4.0), f"{left_out + 1} more", "start", "muted", SMALL)
        y += _ROW
    return sheet.done(y - 5.0, worded=True)


def legend_words(section: CrossSection) -> str:
    """The same in words."""
    texts = [text for _, _, text in _rows(section)]
    left_out = len(texts) - _MOST_ROWS
    return f"Parts: {'; '.join(texts[:_MOST_ROWS])}" + (f"; and {left_out} more." if left_out > 0 else ".")


def _rows(section: CrossSection) -> list[tuple[str, Ink, str]]:
    """Symbol, ink and text of each row."""
    symbols = load_symbols(section)
    rows: list[tuple[str, Ink, str]] = [
        ("area", region_ink(section, one), _region_text(one)) for one in section.regions
    ]
    rows += [("line", "ink", f"{one.name}: interface, {' → '.join(one.materials)}") for one in section.interfaces]
    for value, symbol in symbols.items():
        named = ", ".join(dict.fromkeys(load.boundary for load in section.loads if load.value == value))
        rows.append(("arrow", "load", f"{value if symbol == value else f'{symbol}: {value}'} on {named}"))
    water = sorted({load.water for load in section.loads if load.water is not None})
    rows += [("water", "water", f"free water up to {number(level)} m") for level in water]
    if section.points:
        rows.append(("dot", "reading", f"observed: {', '.join(name for name, _ in section.points)}"))
    return rows


def _symbol(sheet: Sheet, symbol: str, ink: Ink, y: float) -> None:
    if symbol == "area":
        sheet.box(5.0, y - 5.0, 13.0, 10.0, ink)
    elif symbol == "line":
        sheet.line((5.0, y), (18.0, y), ink=ink, width=1.6)
    elif symbol == "arrow":
        sheet.arrow((4.0, y), (18.0, y), ink)
    elif symbol == "water":
        sheet.line((5.0, y + 3.0), (18.0, y + 3.0), ink=ink, width=1.6)
        sheet.area((7.0, y - 5.0), (16.0, y - 5.0), (11.5, y + 2.5), ink=ink)
    else:
        sheet.dot((11.5, y), 2.6, ink)
