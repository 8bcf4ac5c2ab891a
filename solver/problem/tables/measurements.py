"""Looks into files of measurements before they become observations: columns, their numbers and probable units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from geoswarm.solver.problem.tables.cells import Sheet, number_in, read_cells
from geoswarm.solver.problem.tables.dates import moment_in
from geoswarm.solver.problem.tables.headings import guess_unit, known_unit, units_in_comments
from geoswarm.solver.problem.tables.packed import Cell
from geoswarm.solver.problem.tables.reading import TableError

__all__ = ["Column", "Measurements", "read_measurements"]

MAX_ROWS = 200_000
MAX_COLUMNS = 200


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
    found = read_cells(content, name, sheet)
    if len(found.rows) > MAX_ROWS:
        raise TableError(f"{name} has {len(found.rows)} rows; at most {MAX_ROWS} are read")
    columns = _columns(found)
    if all(value is None for column in columns for value in column.values):
        raise TableError(f"{name} has no column of numbers; a heading with rows of numbers below is expected")
    return Measurements(name, found.sheets, found.sheet, len(found.rows), columns)


def _columns(found: Sheet) -> tuple[Column, ...]:
    body = [cells for _, cells in found.rows]
    width = min(max([len(found.header), *(len(cells) for cells in body)]), MAX_COLUMNS)
    commented = units_in_comments(found.comments)
    columns = []
    for place in range(width):
        heading = found.header[place] if place < len(found.header) else ""
        cells = [row[place] if place < len(row) else "" for row in body]
        if heading or any(cell != "" for cell in cells):
            columns.append(_column(heading[:200] or f"column {place + 1}", cells, commented))
    return tuple(columns)


def _column(heading: str, cells: list[Cell], commented: Mapping[str, str]) -> Column:
    label, unit, base = guess_unit(heading)
    if unit is None and heading in commented:
        unit, base = known_unit(commented[heading])
    values = tuple(number_in(cell) for cell in cells)
    filled = sum(cell != "" for cell in cells)
    numbers = sum(value is not None for value in values)
    if numbers * 2 < filled:
        moments = [moment_in(cell) for cell in cells]
        known = [moment for moment in moments if moment is not None]
        if not known or len(known) * 2 < filled:
            return Column(heading, label, unit, base, "text", (), filled)
        days = tuple(None if moment is None else (moment - known[0]).total_seconds() / 86400 for moment in moments)
        return Column(heading, label, "day", "day", "time", days, filled - len(known))
    return Column(heading, label, unit, base, "number", values, filled - numbers)
