"""Looks into files of measurements before they become observations: columns, numbers, probable units and meaning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from geoswarm.solver.problem.tables.blocks import begin, key
from geoswarm.solver.problem.tables.cells import Sheet, number_in, read_cells, without_units
from geoswarm.solver.problem.tables.dates import doubtful_date, elapsed_days, form_of, is_moment, moment_in, time_of_day
from geoswarm.solver.problem.tables.headings import (
    BASES,
    best_unit,
    guess_unit,
    heading_of,
    unclear_unit,
    units_in_comments,
)
from geoswarm.solver.problem.tables.numerals import doubtful_cell, two_readings
from geoswarm.solver.problem.tables.packed import FORMULA, Cell, column_letters
from geoswarm.solver.problem.tables.picking import Picked, lying_rows, units_beside
from geoswarm.solver.problem.tables.quantities import quantities_of
from geoswarm.solver.problem.tables.reading import TableError
from geoswarm.solver.problem.tables.remarks import Beside, factors_beside, with_factors
from geoswarm.solver.units import base_unit, convert
from geoswarm.solver.words import listed

__all__ = ["Column", "Measurements", "read_measurements"]

MAX_ROWS = 200_000
MAX_COLUMNS = 200
_FIRST_ROWS = 8
_MOST_ENTRIES = 50
_LONGEST_CELL = 60
_MOST_FORMULAS = 10
_MOST_BYTES_OF_SHEETS = 2**24


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a file.

    Parameters
    ----------
    name
        Heading as it stands, or ``column 3`` without one.
    letters
        Of the column, as spreadsheets call it; its cells, ``B19:K19``, where it is a row.
    label
        The heading without its unit.
    unit
        Unit that the heading or a comment seems to name, as a problem file writes it; None when none was found.
    base
        Base unit of that dimension (day, m, kPa, degree, dimensionless); None without a unit.
    other_unit
        Unit that it certainly names, of a dimension that no series has, such as kN; None for others.
    unclear
        Why the heading leaves the unit open though it names some; None where it does not, or names none.
    quantities
        What its words may stand for, the likeliest first: ``settlement``, ``time``, ``specimen``.
    kind
        ``number``; ``time`` for dates, whose values are days since the earliest; ``clock`` for times of day; ``text``.
    values
        One a row; None for empty cells and those that are no finite number, or may be several. Empty for text.
    bad
        How many cells hold something else.
    doubt
        A cell that can be read in two ways, a number (``1,000``) or a date (``03/04/2024``): it is to be asked for.
    entries
        What its cells hold, where these are a few: specimens; each with the number of its rows, those below it that
        are empty among them.
    first
        The first cells, as they stand.
    """

    name: str
    letters: str
    label: str
    unit: str | None
    base: str | None
    other_unit: str | None
    unclear: str | None
    quantities: tuple[str, ...]
    kind: Literal["number", "time", "clock", "text"]
    values: tuple[float | None, ...]
    bad: int
    doubt: str | None
    entries: dict[str, int]
    first: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Measurements:
    """What a file holds; ``sheets`` is empty for CSV. ``formulas`` names cells whose formula has no stored value.

    ``alike`` are the sheets with these headings, where there are several.
    """

    name: str
    sheets: tuple[str, ...]
    sheet: str | None
    rows: int
    columns: tuple[Column, ...]
    formulas: tuple[str, ...] = ()
    alike: tuple[str, ...] = ()


def read_measurements(content: bytes, name: str, sheet: str | None = None) -> Measurements:
    """Read a CSV file or one sheet of a workbook; which of them it is follows from the content.

    Parameters
    ----------
    content
        The file.
    name
        Its name, for messages.
    sheet
        Of a workbook; the first one with numbers unless given. Where it has none there is no error as long as there are
        other sheets to choose from.

    Raises
    ------
    TableError
        It cannot be read or holds no rows of numbers.
    """
    found = read_cells(content, name, sheet, numbers=True)
    if len(found.rows) > MAX_ROWS:
        raise TableError(f"{name} has {len(found.rows)} rows; at most {MAX_ROWS} are read")
    columns = _columns(found)
    rows = len(found.rows)
    if found.sheet is not None and begin(tuple(found.grid.items())) is None and (lying := lying_rows(found)):
        columns, rows = _lying(found, lying), max(len(row.cells) for row in lying)
    formulas = _formulas(found)
    if len(found.sheets) < 2 and not any(_has_numbers(column) for column in columns):
        told = f"; these cells hold formulas without a stored value: {', '.join(formulas)}" if formulas else ""
        raise TableError(f"{name} has no column of numbers; a heading with rows of numbers below is expected{told}")
    return Measurements(name, found.sheets, found.sheet, rows, columns, formulas, _alike(content, found))


def _alike(content: bytes, found: Sheet) -> tuple[str, ...]:
    """Sheets with the headings of this one, such as stages on sheets of their own; none of a large workbook."""
    header = list(map(key, found.header))
    if len(found.sheets) < 2 or not any(header) or len(found.sheets) * len(content) > _MOST_BYTES_OF_SHEETS:
        return ()
    others = {sheet: read_cells(content, "", sheet).header for sheet in found.sheets if sheet != found.sheet}
    alike = tuple(s for s in found.sheets if s == found.sheet or list(map(key, others[s])) == header)
    return alike if len(alike) > 1 else ()


def _lying(found: Sheet, rows: Sequence[Picked]) -> tuple[Column, ...]:
    """Columns of a sheet without a table below headings, whose readings lie in rows."""
    body = [cells for _, cells in found.rows]
    return tuple(
        _column(row.heading[:200], row.name, [cell for _, cell in row.cells], body, {}, (), ())
        for row in rows[:MAX_COLUMNS]
    )


def _has_numbers(column: Column) -> bool:
    return column.kind == "number" and (column.doubt is not None or any(value is not None for value in column.values))


def _formulas(found: Sheet) -> tuple[str, ...]:
    """Addresses and text of formulas without a stored value."""
    named: list[str] = []
    left = 0
    for line, cells in found.rows:
        for place, cell in enumerate(cells):
            if isinstance(cell, str) and cell.startswith(FORMULA) and found.sheet is not None:
                if len(named) < _MOST_FORMULAS:
                    named.append(f"{column_letters(place)}{line} ({cell})")
                else:
                    left += 1
    return (*named, *([f"{left} more"] if left else []))


def _columns(found: Sheet) -> tuple[Column, ...]:
    body = [cells for _, cells in found.rows]
    width = min(max([len(found.header), *(len(cells) for cells in body)]), MAX_COLUMNS)
    commented = units_in_comments(found.comments)
    used = {line for line, cells in found.rows if sum(number_in(cell) is not None for cell in cells) > 1}
    factors = factors_beside(found, used, body)
    columns = []
    for place in range(width):
        heading = found.header[place] if place < len(found.header) else ""
        cells = [row[place] if place < len(row) else "" for row in body]
        if heading or any(cell != "" for cell in cells):
            columns.append(
                _column(
                    heading[:200] or f"column {place + 1}",
                    column_letters(place),
                    cells,
                    body,
                    commented,
                    units_beside(found.header, body, place),
                    factors,
                )
            )
    return tuple(columns)


def _column(
    heading: str,
    letters: str,
    cells: list[Cell],
    body: Sequence[Sequence[Cell]],
    commented: Mapping[str, str],
    units: Sequence[str],
    factors: Sequence[Beside],
) -> Column:
    label = guess_unit(heading)[0]
    since = elapsed_days(cells, heading)
    cells, in_cells = without_units(cells) if since is None else (since, "day")
    filled = [cell for cell in cells if cell != ""]
    kind, doubt = _kind([cell for cell in filled if not str(cell).startswith(FORMULA)], body)
    values: tuple[float | None, ...] = ()
    if kind == "number":
        values = tuple(None if doubt and _is_doubtful(cell) else number_in(cell) for cell in cells)
    elif kind == "time":
        form = form_of(cells)
        moments = [moment_in(cell, form) for cell in cells]
        first = min((moment for moment in moments if moment is not None), default=None)
        values = tuple(
            None if moment is None or first is None else (moment - first).total_seconds() / 86400 for moment in moments
        )
    text = f"{heading} [{units[0]}]" if len(units) == 1 else ""
    whole = heading_of(heading, commented, text=text, dates=kind == "time", in_cells=in_cells)
    named = with_factors(whole, factors).named
    best = best_unit(named, BASES)
    several = f"is in {listed(units)}" if len(units) > 1 else None
    other = best_unit(named) if best is None else None
    other_unit = other.unit if other is not None and other.certain else None
    unclear = several or unclear_unit(named) or (other_unit and _other_quantity(other_unit))
    best = best if unclear is None else None
    read = sum(value is not None for value in values)
    shown = tuple(_shown(cell) for cell in cells[:_FIRST_ROWS])
    return Column(
        heading,
        letters,
        label,
        None if best is None else best.unit,
        None if best is None else best.base,
        other_unit,
        unclear,
        quantities_of(label),
        kind,
        values,
        len(filled) - read,
        doubt,
        _entries(cells),
        shown,
    )


def _other_quantity(unit: str) -> str:
    """What a column is in whose unit no series has."""
    if base_unit(unit) != "kN":
        return f"is in {unit}, which is not a length, time, stress, angle or number"
    factor = f"{float(convert(1.0, unit, 'kN')):g} / A"
    return f"is in {unit}, a force; for a stress in kPa the factor is {factor} with the area A in m2"


def _kind(
    filled: list[Cell], body: Sequence[Sequence[Cell]]
) -> tuple[Literal["number", "time", "clock", "text"], str | None]:
    """What most of the filled cells are, and one that can be read in two ways."""
    half = len(filled) / 2
    numbers = sum(number_in(cell) is not None or bool(two_readings(cell)) for cell in filled)
    if numbers >= half:
        return "number", doubtful_cell(filled, (cell for row in body for cell in row))
    form = form_of(filled)
    if sum(moment_in(cell, form) is not None for cell in filled) >= half:
        return "time", doubtful_date(filled) if form is None else None
    either = [str(cell) for cell in filled if is_moment(cell)]
    if len(either) >= half:
        return "time", either[0]
    return ("clock" if sum(time_of_day(cell) is not None for cell in filled) >= half else "text"), None


def _is_doubtful(cell: Cell) -> bool:
    return isinstance(cell, str) and len(set(two_readings(cell).values())) > 1


def _entries(cells: Sequence[Cell]) -> dict[str, int]:
    """How many rows each entry has, an empty cell meaning the one above; empty where there are too many."""
    counts: dict[str, int] = {}
    last = ""
    for cell in cells:
        last = _shown(cell) if cell != "" else last
        if last:
            counts[last] = counts.get(last, 0) + 1
            if len(counts) > _MOST_ENTRIES:
                return {}
    return counts


def _shown(cell: Cell) -> str:
    return f"{cell:.15g}" if isinstance(cell, float) else cell[:_LONGEST_CELL]
