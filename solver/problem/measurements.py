"""Looks into files of measurements before they become observations: columns, their numbers and probable units."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from geoswarm.solver.problem.tables import MAX_TABLE_BYTES, TableError, cell_number, decoded, table_rows
from geoswarm.solver.problem.units import UnitError, convert
from geoswarm.solver.problem.workbooks import Cell, read_workbook

__all__ = ["Column", "Measurements", "guess_unit", "read_measurements"]

MAX_ROWS = 200_000
MAX_COLUMNS = 200

BASES = ("day", "m", "kPa", "degree", "dimensionless")
ALIASES = {
    "sec": "s",
    "secs": "s",
    "second": "s",
    "seconds": "s",
    "mins": "min",
    "minute": "min",
    "minutes": "min",
    "hr": "h",
    "hrs": "h",
    "hour": "h",
    "hours": "h",
    "d": "day",
    "days": "day",
    "weeks": "week",
    "years": "year",
    "a": "year",
    "µm": "um",
    "μm": "um",
    "kn/m2": "kN/m^2",
    "kn/m²": "kN/m^2",
    "kn/m^2": "kN/m^2",
    "mn/m²": "MPa",
    "n/mm²": "MPa",
    "kpa": "kPa",
    "mpa": "MPa",
    "°": "degree",
    "deg": "degree",
    "percent": "%",
    "-": "dimensionless",
    "1": "dimensionless",
    "–": "dimensionless",
}
"""What laboratories write, and what the registry of units (or a problem file) calls it."""

_BRACKETS = re.compile(r"^(?P<label>.*?)\s*[\[({](?P<unit>[^\])}]{0,20})[\])}]\s*$")
_BEHIND = re.compile(r"^(?P<label>.+?)(?:\s+in\s+|\s*/\s*|\s*,\s*|_)(?P<unit>[^\s,]{1,20})$", re.IGNORECASE)
_COMMENT = re.compile(r"([\w.]+) in ([^\s,;]+)")


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a file.

    Parameters
    ----------
    name
        Heading as it stands, or ``column 3`` without one.
    label
        The heading without its unit.
    unit
        Unit that the heading or a comment seems to name, as a problem file writes it; None when none was found.
    base
        Base unit of that dimension (day, m, kPa, degree, dimensionless); None without a unit.
    kind
        ``number``; ``time`` for dates, whose values are days since the first; ``text`` for what is no numbers.
    values
        One a row; None for empty cells and those that are no finite number. Empty for text.
    bad
        How many cells hold something else.
    """

    name: str
    label: str
    unit: str | None
    base: str | None
    kind: Literal["number", "time", "text"]
    values: tuple[float | None, ...]
    bad: int


@dataclass(frozen=True, slots=True)
class Measurements:
    """What a file holds; ``sheets`` is empty for CSV."""

    name: str
    sheets: tuple[str, ...]
    sheet: str | None
    rows: int
    columns: tuple[Column, ...]


def read_measurements(content: bytes, name: str, sheet: str | None = None) -> Measurements:
    """Read a CSV file or one sheet of an XLSX workbook; which of them it is follows from the content.

    Parameters
    ----------
    content
        The file.
    name
        Its name, for messages.
    sheet
        Of a workbook; the first one with cells unless given.

    Raises
    ------
    TableError
        It cannot be read or holds no rows of numbers.
    """
    if len(content) > MAX_TABLE_BYTES:
        raise TableError(f"{name} is larger than {MAX_TABLE_BYTES} bytes")
    if content.startswith(b"PK"):
        sheets, chosen, cells = read_workbook(content, name, sheet)
        rows = [row for row in cells if any(cell != "" for cell in row)]
        comments = ""
        rows = _from_header(rows)
    elif content.startswith(b"\xd0\xcf\x11\xe0"):
        raise TableError(f"{name} is a workbook of the old form (.xls); save it as .xlsx or .csv")
    else:
        text = decoded(content)
        if "\0" in text:
            raise TableError(f"{name} is neither text (CSV) nor an XLSX workbook")
        sheets, chosen = [], None
        comments = "\n".join(line for line in text.splitlines() if line.lstrip().startswith("#"))
        rows = [list[Cell](cells) for _, cells in table_rows(text, name)]
    if len(rows) > MAX_ROWS:
        raise TableError(f"{name} has {len(rows)} rows; at most {MAX_ROWS} are read")
    columns, count = _columns(rows, dict(_COMMENT.findall(comments)))
    if all(value is None for column in columns for value in column.values):
        raise TableError(f"{name} has no column of numbers; a heading with rows of numbers below is expected")
    return Measurements(name, tuple(sheets), chosen, count, columns)


def guess_unit(heading: str) -> tuple[str, str | None, str | None]:
    """Split a heading such as ``settlement [mm]`` or ``time in min`` into label, unit and base unit."""
    heading = " ".join(heading.split())
    found = _BRACKETS.match(heading)
    if found is None or not found["label"]:
        found = _BEHIND.match(heading)
    if found is not None:
        unit, base = _known(found["unit"])
        if unit is not None:
            return found["label"], unit, base
    return heading, None, None


def _known(text: str) -> tuple[str | None, str | None]:
    unit = ALIASES.get(text.strip().lower(), text.strip())
    if not unit:
        return None, None
    for base in BASES:
        try:
            convert([1.0], unit, base)
        except UnitError:
            continue
        return unit, base
    return None, None


def _from_header(rows: list[list[Cell]]) -> list[list[Cell]]:
    """Sheets often begin with titles: leave out what stands above the heading of the first row of numbers."""
    for index, row in enumerate(rows):
        numbers = sum(_number(cell) is not None or _moment(cell) is not None for cell in row)
        if numbers >= min(2, max(len(row), 1)):
            return rows[max(index - 1, 0) :]
    return rows


def _columns(rows: list[list[Cell]], commented: dict[str, str]) -> tuple[tuple[Column, ...], int]:
    if not rows:
        return (), 0
    first = [cell for cell in rows[0] if cell != ""]
    has_header = not first or any(_number(cell) is None for cell in first)
    header, body = (rows[0], rows[1:]) if has_header else ([], rows)
    width = min(max((len(row) for row in rows), default=0), MAX_COLUMNS)
    columns = []
    for place in range(width):
        heading = str(header[place]).strip() if place < len(header) else ""
        cells = [row[place] if place < len(row) else "" for row in body]
        if heading or any(cell != "" for cell in cells):
            columns.append(_column(heading[:200] or f"column {place + 1}", cells, commented))
    return tuple(columns), len(body)


def _column(heading: str, cells: list[Cell], commented: dict[str, str]) -> Column:
    label, unit, base = guess_unit(heading)
    if unit is None and heading in commented:
        unit, base = _known(commented[heading])
    values = tuple(_number(cell) for cell in cells)
    filled = sum(cell != "" for cell in cells)
    numbers = sum(value is not None for value in values)
    if numbers * 2 < filled:
        moments = [_moment(cell) for cell in cells]
        known = [moment for moment in moments if moment is not None]
        if not known or len(known) * 2 < filled:
            return Column(heading, label, unit, base, "text", (), filled)
        days = tuple(None if moment is None else (moment - known[0]).total_seconds() / 86400 for moment in moments)
        return Column(heading, label, "day", "day", "time", days, filled - len(known))
    return Column(heading, label, unit, base, "number", values, filled - numbers)


def _number(cell: Cell) -> float | None:
    if isinstance(cell, float):
        return cell if math.isfinite(cell) else None
    return cell_number(cell)


def _moment(cell: Cell) -> datetime | None:
    """Date and time in ISO 8601 or as written in much of Europe (31.12.2024 13:45)."""
    if isinstance(cell, float) or not 8 <= len(cell) <= 40:
        return None
    try:
        return datetime.fromisoformat(cell).replace(tzinfo=None)
    except ValueError:
        pass
    for form in ("%d.%m.%Y", "%d.%m.%Y %H:%M", "%d.%m.%Y %H:%M:%S", "%d/%m/%Y %H:%M:%S"):
        try:
            return datetime.strptime(cell, form)
        except ValueError:
            continue
    return None
