"""Which cells of a sheet a column of measurements is: by heading, by letter (B:B), by range (B5:B30) or by name.

A column may lie in a row: B19:K19, with its name before it and its unit before or after it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import dropwhile, groupby, takewhile
from operator import itemgetter

from geoswarm.solver.problem.tables.blocks import is_reading, is_unit_column, key, shown, unit_of_cell
from geoswarm.solver.problem.tables.cells import Area, Sheet, number_in
from geoswarm.solver.problem.tables.headings import Heading, guess_unit, known_unit, units_of, without_brackets
from geoswarm.solver.problem.tables.packed import MAX_COLUMNS, Cell, column_letters, column_number
from geoswarm.solver.problem.tables.reading import TableError, UnnamedColumnsError
from geoswarm.solver.problem.tables.workbooks import named_cells
from geoswarm.solver.sentences import setting
from geoswarm.solver.units import convert
from geoswarm.solver.words import listed

__all__ = [
    "Picked",
    "all_picked",
    "area_of",
    "column_of",
    "is_cells",
    "is_range",
    "lying_rows",
    "refuse_other_unit",
    "refuse_parts_of_time",
    "rows_where",
    "sheet_of_names",
    "text_of",
    "units_beside",
]

_ADDRESS = re.compile(r"\$?([A-Za-z]{1,3})\$?(\d{1,7})(?::\.?\$?([A-Za-z]{1,3})\$?(\d{1,7}))?", re.ASCII)
_LETTERS = re.compile(r"\$?([A-Za-z]{1,3}):\$?([A-Za-z]{1,3})", re.ASCII)
_OF_SHEET = re.compile(r"\$?(?:'(?P<quoted>(?:[^']|'')*)'|(?P<plain>[^'!.]*))[!.](?P<cells>.*)")
_MOST_SHOWN = 10
_LEAST_LYING = 2
_NAME_ENDS = " :="

Rows = list[tuple[int, list[Cell]]]


@dataclass(frozen=True, slots=True)
class Picked:
    """Cells of a column with their lines; ``place`` is that of the column in the rows, None for a range.

    ``heading`` is what stands above, or before, a range.
    """

    name: str
    cells: list[tuple[int, Cell]]
    place: int | None = None
    heading: str = ""


def is_range(wanted: str) -> bool:
    """Whether a column is given by its cells, such as B5:B30."""
    return _ADDRESS.fullmatch(wanted) is not None and ":" in wanted


def is_cells(wanted: str) -> bool:
    """Whether a column is given by its cells or letter."""
    return area_of(wanted) is not None


def area_of(wanted: str) -> Area | None:
    """Cells that a range or a letter means; None for a heading."""
    if is_range(wanted) and (found := _ADDRESS.fullmatch(wanted)) is not None:
        return column_number(found[1]), column_number(found[3]), int(found[2]), int(found[4])
    letters = _LETTERS.fullmatch(wanted)
    return None if letters is None else (column_number(letters[1]), column_number(letters[2]), 1, None)


def column_of(sheet: Sheet, wanted: str) -> list[int]:
    """Places of the columns with a heading, or with a heading that is this before its unit, or of a letter (B:B)."""
    labels = [guess_unit(name)[0] for name in sheet.header]
    for headings in (sheet.header, labels, [without_brackets(name) for name in sheet.header]):
        found = [index for index, name in enumerate(headings) if key(name) == key(wanted)]
        if found:
            return found
    letters = _LETTERS.fullmatch(wanted)
    if letters is not None and letters[1].upper() == letters[2].upper():
        return [column_number(letters[1])]
    if not sheet.header and (unnamed := re.fullmatch(r"column (\d{1,3})", wanted)) is not None:
        return [int(unnamed[1]) - 1]
    return []


def all_picked(sheet: Sheet, rows: Rows, wanted: Mapping[str, str], file: str) -> dict[str, Picked]:
    """All columns by role; all their mistakes are reported together."""
    found: dict[str, Picked] = {}
    errors: list[TableError] = []
    for role, text in wanted.items():
        try:
            found[role] = _picked(sheet, rows, role, text, file)
        except TableError as error:
            errors.append(error)
    if errors:
        unnamed = all(isinstance(error, UnnamedColumnsError) for error in errors)
        sentences = [sentence for error in errors for sentence in error.sentences]
        raise (UnnamedColumnsError if unnamed else TableError)(*sentences)
    return found


def _picked(sheet: Sheet, rows: Rows, role: str, text: str, file: str) -> Picked:
    try:
        return picked(sheet, rows, text, file)
    except TableError as error:
        if text != role or role not in ("x", "y"):
            raise
        if column_of(sheet, text):
            raise UnnamedColumnsError(*error.sentences) from None
        names = [heading for heading in sheet.header if heading] or ["column 1", "column 2"]
        suggested = names[min(("x", "y").index(role), len(names) - 1)]
        raise UnnamedColumnsError((f"{error}; say which it is: ", setting(f"{role}_column", suggested))) from None


def picked(sheet: Sheet, rows: Rows, wanted: str, file: str) -> Picked:
    """Cells of a column.

    Parameters
    ----------
    rows
        Those of the sheet that count, for a heading or a letter; a range has its own.
    file
        Its name, for messages.

    Raises
    ------
    TableError
        There is no such column, or several.
    """
    found = column_of(sheet, wanted)
    if len(found) == 1 and found[0] < MAX_COLUMNS:
        place = found[0]
        name = sheet.header[place] if place < len(sheet.header) else wanted
        return Picked(name or wanted, [(line, _cell(row, place)) for line, row in rows], place)
    if not found and is_range(wanted):
        return _range(sheet, wanted, file)
    what = f"there {'are several columns' if found else 'is no column'} '{wanted}'"
    header = f"; the header has: {', '.join(sheet.header)}" if sheet.header else "; there is no line of headings"
    if len(sheet.sheets) > 1:
        header += f"; this is sheet '{sheet.sheet}' of {', '.join(sheet.sheets)}"
    places = [_cells(sheet, place) for place in found]
    if not places:
        lying = [row for row in lying_rows(sheet) if key(wanted) in map(key, (row.heading, _name(row.heading)))]
        places = [row.name for row in lying]
        header = ", but rows begin with it" if lying else header
    remedy = f"; name the cells of one: {listed(places[:_MOST_SHOWN], 'or')}" if places else ""
    raise TableError(f"{file} line {sheet.header_line}: {what}{header}{remedy}")


def _cells(sheet: Sheet, place: int) -> str:
    """The cells of a column, such as B5:B30."""
    letters, lines = column_letters(place), [line for line, _ in sheet.rows] or [sheet.header_line + 1]
    return f"{letters}{lines[0]}:{letters}{lines[-1]}"


def refuse_parts_of_time(header: Sequence[str], x: Picked, rows: Iterable[Sequence[Cell]], file: str) -> None:
    """Refuse a column of whole hours whose minutes are in the next one, and the like.

    Raises
    ------
    TableError
        The column behind that of x has the same name or none, a smaller unit of time, and other moments.
    """
    if x.place is None or x.place + 1 >= len(header):
        return
    name = header[x.place + 1]
    (label, unit, base), (other_label, smaller, other) = guess_unit(x.name), guess_unit(name)
    if unit is None or smaller is None or not base == other == "day" or other_label not in (label, name):
        return
    parts, pairs = float(convert(1.0, unit, smaller)), []
    for row in rows:
        whole, part = (number_in(_cell(row, place)) for place in (x.place, x.place + 1))
        if whole is None or part is None or not whole.is_integer() or not 0 <= part < parts:
            return
        pairs.append((whole, part))
    if any(part != 0 and not math.isclose(whole * parts, part) for whole, part in pairs):
        raise TableError(
            f"{file}: columns '{x.name}' and '{name}' are parts of one time; put the whole time, in one unit, into one"
        )


def refuse_other_unit(name: str, y: Heading, other: Heading) -> None:
    """Refuse to subtract columns of different units.

    Raises
    ------
    TableError
        They have them.
    """
    if y.unit is not None and other.unit is not None and y.unit != other.unit and (y.certain or other.certain):
        told = f", '{other.name}', in {other.unit}; give them one unit"
        raise TableError((f"{name}: column '{y.name}' is in {y.unit} and ", setting("y_minus"), told))


def units_beside(header: Sequence[str], rows: Sequence[Sequence[Cell]], place: int) -> tuple[str, ...]:
    """Units of a column's readings in a column of their own, behind or before it.

    In the column before them they are those of another column, where there is one of readings without a unit.
    """
    for at in (place + 1, place - 1):
        if not 0 <= at < len(header) or not is_unit_column(header[at]):
            continue
        of = at - 1
        if of != place and of >= 0 and not units_of(header[of]) and any(is_reading(_cell(row, of)) for row in rows):
            continue
        filled = [str(_cell(row, at)).strip() for row in rows if _cell(row, place) != ""]
        units = tuple(dict.fromkeys(unit_of_cell(cell) or cell for cell in filled))
        if any(known_unit(unit)[0] is not None and not is_reading(unit) for unit in units):
            return tuple(unit or "none" for unit in units)
    return ()


def text_of(column: Picked, header: Sequence[str], rows: Rows, file: str) -> str:
    """What stands above a column, with the unit that a column beside it says.

    Raises
    ------
    TableError
        That column has several units.
    """
    units = () if column.place is None else units_beside(header, [row for _, row in rows], column.place)
    if len(units) > 1:
        told = f"{file}: column '{column.name}' is in {listed(units)}; choose the rows of one unit, or convert them"
        raise TableError(told)
    return f"{column.heading or column.name} [{units[0]}]" if units else column.heading


def lying_rows(sheet: Sheet) -> list[Picked]:
    """Rows with a name first and readings behind it."""
    found = []
    for line, row in sheet.grid.items():
        start = next((place for place, cell in enumerate(row) if cell != "" and is_reading(cell)), 0)
        values = list(takewhile(lambda cell: cell != "" and is_reading(cell), row[start:]))
        if start and unit_of_cell(row[start - 1]) is None and len(values) >= _LEAST_LYING and row[start - 1] != "":
            cells = f"{column_letters(start)}{line}:{column_letters(start + len(values) - 1)}{line}"
            found.append(_range(sheet, cells, ""))
    return found


def _name(heading: str) -> str:
    return guess_unit(heading)[0].rstrip(_NAME_ENDS)


def _range(sheet: Sheet, wanted: str, file: str) -> Picked:
    address = area_of(wanted)
    assert address is not None
    first, last, top, bottom = address
    assert bottom is not None
    if (first != last and top != bottom) or first > last or top > bottom:
        raise TableError(f"{file}: cells {wanted} are neither a column such as B5:B30 nor a row such as B5:M5")
    known = max(sheet.grid, default=0)
    if bottom > known or last >= MAX_COLUMNS:
        raise TableError(f"{file}: cells {wanted} reach beyond the sheet, whose last row is {known}")
    if first == last:
        cells = [(line, _cell(sheet.grid.get(line, []), first)) for line in range(top, bottom + 1)]
        before = [_cell(sheet.grid.get(line, []), first) for line in range(top - 1, 0, -1)]
        return Picked(wanted, cells, heading=_heading(before))
    row = sheet.grid.get(top, [])
    after = unit_of_cell(next((cell for cell in row[last + 1 :] if cell == "" or not is_reading(cell)), ""))
    heading = _heading([_cell(row, place) for place in range(first - 1, -1, -1)])
    cells = [(top, _cell(row, place)) for place in range(first, last + 1)]
    return Picked(wanted, cells, heading=heading if after is None else f"{heading} [{after}]")


def _heading(before: list[Cell]) -> str:
    """Name and unit of a range from the cells above it, or before it in its row, the nearest first."""
    words = list(dropwhile(lambda cell: cell == "" or (is_reading(cell) and unit_of_cell(cell) is None), before))
    found: list[str] = []
    for cell in takewhile(lambda cell: isinstance(cell, str) and cell != "", words):
        unit = unit_of_cell(cell)
        found.insert(0, str(cell) if unit is None else f"[{unit}]")
        if unit is None:
            break
    return " ".join(found)


def sheet_of_names(content: bytes, name: str, given: str | None, sheet: Sheet, wanted: dict[str, str]) -> str | None:
    """Replace names that a workbook defines by their cells; return the sheet on which they are.

    Parameters
    ----------
    given
        The sheet that is asked for, if any is.

    Raises
    ------
    TableError
        The names stand for something else, or for cells of several sheets.
    """
    if all(column_of(sheet, text) or is_range(text) for text in wanted.values()):
        return sheet.sheet  # without unpacking the workbook once more
    used = _names_used(sheet, wanted, named_cells(content, name), name)
    if not used:
        return sheet.sheet
    sheets = {of for of, _ in used.values()} | ({given} if given is not None else set())
    if len(sheets) > 1:
        raise TableError(f"{name}: the named cells are on several sheets: {', '.join(sorted(sheets))}")
    wanted.update({role: cells for role, (_, cells) in used.items()})
    return sheets.pop()


def _names_used(
    sheet: Sheet, wanted: Mapping[str, str], names: Mapping[str, str], file: str
) -> dict[str, tuple[str, str]]:
    """Columns that are names of cells: sheet and range of each role."""
    found = {}
    for role, text in wanted.items():
        if text not in names or column_of(sheet, text):
            continue
        parts = _OF_SHEET.fullmatch(names[text])
        cells = "" if parts is None else parts["cells"].replace("$", "").replace(":.", ":")
        if parts is None or not is_range(cells):
            raise TableError(
                f"{file}: name '{text}' stands for {names[text][:80]}; a column such as B5:B30 is expected"
            )
        quoted = parts["quoted"]
        found[role] = (parts["plain"] if quoted is None else quoted.replace("''", "'"), cells)
    return found


def rows_where(sheet: Sheet, where: Mapping[str, str | float], file: str, turn: tuple[int, int] | None = None) -> Rows:
    """Rows with these entries; an empty cell below another one means the same as that, as in merged cells.

    Parameters
    ----------
    turn
        Number of a run of consecutive rows with the last entry, from 0, and number of such runs: ``(1, 2)`` takes the
        second of two.

    Raises
    ------
    TableError
        No row has them, there is no such column, or the runs are not as many.
    """
    rows = sheet.rows
    runs = [rows]
    for heading, value in where.items():
        entries: list[Cell] = []
        for _, cell in picked(sheet, rows, heading, file).cells:
            entries.append(entries[-1] if cell == "" and entries else cell)
        marked = zip((_same(entry, value) for entry in entries), rows, strict=True)
        runs = [[row for _, row in run] for same, run in groupby(marked, key=itemgetter(0)) if same]
        if not runs:
            known = list(dict.fromkeys(str(entry) for entry in entries if entry != ""))
            more = f", ... ({len(known)} in all)" if len(known) > _MOST_SHOWN else ""
            raise TableError(
                f"{file}: no row has {heading} = {value}; there are: {', '.join(known[:_MOST_SHOWN])}{more}"
            )
        rows = [row for run in runs for row in run]
    if turn is None:
        return rows
    if len(runs) != turn[1]:
        told = ", ".join(f"{heading} = {shown(value)}" for heading, value in where.items())
        raise TableError(f"{file}: {turn[1]} blocks have {told}, but {len(runs)} parts of the table; give one for each")
    return runs[turn[0]]


def _same(entry: Cell, value: str | float) -> bool:
    number = number_in(entry)
    wanted = value if isinstance(value, float) else number_in(value)
    if number is not None and wanted is not None:
        return number == wanted
    return key(str(entry)) == key(str(value))


def _cell(row: Sequence[Cell], place: int) -> Cell:
    return row[place] if place < len(row) else ""
