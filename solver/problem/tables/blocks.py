"""Where a table begins in the rows of a file: below titles and preambles, with its headings and their units.

A table is a row of names, then perhaps rows of units, then rows with at least two readings below the names.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from geoswarm.solver.problem.tables.dates import is_moment, time_of_day
from geoswarm.solver.problem.tables.headings import (
    best_unit,
    guess_unit,
    is_unit,
    known_unit,
    number_with_unit,
    unclear_unit,
    units_of,
    without_brackets,
)
from geoswarm.solver.problem.tables.numerals import two_readings
from geoswarm.solver.problem.tables.packed import FORMULA, Cell, Covered
from geoswarm.solver.problem.tables.quantities import dimension_of, quantities_of
from geoswarm.solver.problem.tables.reading import cell_number

__all__ = [
    "SAMPLE",
    "Block",
    "Rows",
    "begin",
    "has_unit",
    "is_heading",
    "is_reading",
    "is_unit_column",
    "key",
    "shown",
    "unit_of_cell",
    "with_units",
]

Rows = Sequence[tuple[int, Sequence[Cell]]]
"""Rows of a file that are not empty, with the numbers of their lines."""

_DEEPEST = 1000
"""Rows within which the headings are looked for."""
_MOST_SPARSE = 20
_NO_UNITS = "-–—1"
_JOINING = ("in", "/", "-", "–", ":", "|", "=")
_MOST_HEADINGS = 4
_NUMBER_FIRST = re.compile(
    r"[+−-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?\s*(?=[^\s\d.,])|[+−-]?\d+(?:[.,]\d+)?\s+(?=\S)"
)
_LONGEST_SYMBOL = 5
_LONG_ENOUGH = 3
_MOST_TITLES = 20
_UNIT_COLUMN = re.compile(r"(?:maß|mass)?einheit(?:en)?|units?", re.IGNORECASE)
_ALL = re.compile(r"(?:alle?\s+)?(?:(?:mess)?werte|values|readings|angaben)|einheit(?:en)?|units?", re.IGNORECASE)
_NO_WORDS = re.compile(r"[\[\](){}:]|\bin\b", re.IGNORECASE)
_TITLE_WORDS = re.compile(r"\b(?:alle?|sind|are|values|werte)\b", re.IGNORECASE)
SAMPLE = 2000
"""Rows that show where a table is, and what separates its columns."""


@dataclass(frozen=True, slots=True)
class Block:
    """A table: place of the row of names in the rows, its headings with their units, place of the first row below.

    ``length`` counts the rows that look like those of a table, ``width`` its columns of readings; ``named`` says
    whether it has all the columns that are wanted.
    """

    place: int
    header: list[str]
    below: int
    length: int
    width: int
    named: bool = False


def key(cell: str) -> str:
    """What two headings have in common that are the same to a reader."""
    return " ".join(cell.split()).casefold()


def is_reading(cell: Cell) -> bool:
    """Whether a cell holds a number, with its unit or without, a date, a time of day or a formula."""
    if isinstance(cell, float):
        return True
    if not cell or not (cell[0].isdigit() or cell[0] in "+-\u2212\u2013.,=("):
        return cell[-1:].isdigit() and is_moment(cell)  # March 1, 2024
    return (
        cell_number(cell) is not None
        or cell.startswith(FORMULA)
        or bool(two_readings(cell))
        or is_moment(cell)
        or time_of_day(cell) is not None
        or number_with_unit(cell) is not None
    )


def has_unit(cell: Cell) -> bool:
    """Whether a cell is a number with a unit, or with that of an instrument: ``5 µm``, ``40 div``."""
    if not isinstance(cell, str) or (found := _NUMBER_FIRST.match(cell)) is None:
        return False
    unit = cell[found.end() :].strip(" []()")
    return unit[:1] not in "*×·" and is_unit(unit)


def is_heading(cell: Cell) -> bool:
    """Whether a cell is the name of a quantity, or a unit."""
    if not isinstance(cell, str) or is_reading(cell):
        return False
    unit = unit_of_cell(cell)
    return (unit or "-") not in _NO_UNITS or any(one.certain for one in units_of(cell)) or quantities_of(cell) != ()


def is_unit_column(name: str) -> bool:
    """Whether a heading is that of the units of another column."""
    return _UNIT_COLUMN.fullmatch(name.strip()) is not None


def unit_of_cell(cell: Cell) -> str | None:
    """The text of a unit that has a cell of its own, with brackets or without; None for what is none."""
    text = cell.strip().removeprefix("in ") if isinstance(cell, str) else ""
    if not text:
        return None
    if text[:1] in "[({" and text[-1:] in "])}":
        inner = text[1:-1].strip()
        return inner if inner and (text[0] == "[" or is_unit(inner)) else None
    return text if is_unit(text) else None


def with_units(cells: Sequence[str], width: int) -> Sequence[str]:
    """Headings between blanks with their units, where these then are as many as there are columns; else as they are.

    Each column has one word with a unit or without, or each ends with a unit. A letter, which may be a name, is a unit
    behind a sign, else only where the columns are as many then, and the word before it suits: ``Zeit h``.
    """
    names, ends = _joined(cells)
    suited = names if len(names) == width else _joined(cells, letters=True)[0]
    if len(suited) == width:
        return suited
    if ends and ends[-1] and sum(ends) == width:
        starts = [0, *(place for place, end in enumerate(ends, 1) if end)]
        return [" ".join(names[start:end]) for start, end in itertools.pairwise(starts)]
    return cells


def _joined(cells: Sequence[str], *, letters: bool = False) -> tuple[list[str], list[bool]]:
    """Words with the units behind them, and which of them end with one."""
    names: list[str] = []
    ends: list[bool] = []
    place = 0
    while place < len(cells):
        joined = cells[place] in _JOINING or (place > 0 and cells[place - 1][-1:] in ":=/")
        first = place + (cells[place] in _JOINING)
        for count in (3, 2, 1):
            unit = " ".join(cells[first : first + count])
            letter = len(unit) == 1 and unit not in "%‰°" and not (letters and names and _suits(unit, names[-1]))
            if names and is_unit(unit) and (joined or not letter):
                names[-1] = " ".join([names[-1], *cells[place : first + count]])
                ends[-1] = True
                place = first + count
                break
        else:
            names.append(cells[place])
            ends.append(cells[place][-1:] in "])}")
            place += 1
    return names, ends


def _suits(letter: str, name: str) -> bool:
    """Whether a letter is a unit of what a name means: ``h`` of a time, ``m`` of a settlement."""
    base, meant = known_unit(letter)[1], quantities_of(name)
    return (base == "day" and "time" in meant) or (base == "m" and "settlement" in meant)


def _is_units(row: Sequence[Cell], *, letters: bool = False) -> bool:
    """Whether a row holds units: no reading, and one in brackets or of several letters, or all are units."""
    units = [(cell, unit_of_cell(cell)) for cell in row if cell != ""]
    if any(
        is_reading(cell) and (unit is None or (cell != "1" and cell_number(str(cell)) is not None))
        for cell, unit in units
    ):
        return False
    sure = (
        unit for cell, unit in units if unit is not None and (cell != unit or not (unit[0].isdigit() or unit in "-–—"))
    )
    return any(len(unit) > 1 or unit in "%‰°" for unit in sure) or (
        letters
        and any(unit not in _NO_UNITS and not unit[0].isdigit() for _, unit in units if unit)
        and all(unit is not None for _, unit in units)
    )


def _symbols(row: Sequence[Cell]) -> list[str] | None:
    """Units of a row of symbols with their units, ``t [min]``, as it stands below names; None for any other row."""
    found = [None if cell == "" else best_unit(units_of(str(cell))) for cell in row]
    if not any(found) or any(
        cell != "" and (one is None or not one.certain or len(one.label) > _LONGEST_SYMBOL)
        for cell, one in zip(row, found, strict=True)
    ):
        return None
    return ["" if one is None else one.text for one in found]


def begin(rows: Rows, wanted: Iterable[str] = ()) -> Block | None:
    """Find the table: the first with all columns that are wanted, by name; else the first of some length.

    None where no row of names stands above rows of readings.
    """
    names = {key(name) for name in wanted}
    longest: Block | None = None
    readings = [_readings(row) for _, row in rows[:SAMPLE]]
    if not any(len(found) > 1 for found in readings):
        return None
    for place, (_, row) in enumerate(rows[:_DEEPEST]):
        if readings[place] and not _names_all(row, readings[place], names):
            continue
        if not any(cell != "" for cell in row) or _is_units(row):
            continue
        block = _block(rows, readings, place, names)
        if block is None:
            continue
        if block.named:
            return block
        if longest is None or longest.length < min(block.length, _LONG_ENOUGH):
            longest = block
    return longest


def _names_all(row: Sequence[Cell], readings: frozenset[int], names: set[str]) -> bool:
    """Whether a row with numbers has all names that are wanted: loads may be headings."""
    words = any(cell != "" and index not in readings for index, cell in enumerate(row))
    headings = [shown(cell) for cell in row] if words and names else []
    return bool(headings) and all(any(name in _keys(heading) for heading in headings) for name in names)


def shown(cell: Cell) -> str:
    """A cell as text, a number without a needless fraction."""
    return f"{cell:.15g}" if isinstance(cell, float) else cell.strip()


def _below_names(rows: Rows, place: int, index: int) -> bool:
    """Whether each cell of a row stands below a name."""
    return all(_at(rows[place][1], column) != "" for column, cell in enumerate(rows[index][1]) if cell != "")


def _block(rows: Rows, readings: Sequence[frozenset[int]], place: int, names: set[str]) -> Block | None:
    below = place + 1
    for index in range(below, min(below + _MOST_HEADINGS, len(readings))):
        row, below_names = rows[index][1], _below_names(rows, place, index)
        units = _is_units(row, letters=below_names) or (below_names and _symbols(row) is not None)
        units = units and not _has_unit_column(rows, place, index)
        if readings[index] and not units:
            break
        if units:
            below = index + 1
    header = _header(rows, place, below)
    places = {index for index, name in enumerate(header) if name}
    named = bool(names) and all(any(name in _keys(heading) for heading in header) for name in names)
    columns: frozenset[int] = frozenset()
    for found in readings[below : below + _MOST_SPARSE]:
        if not found and not named:
            break
        columns = found & places
        if len(columns) >= 2:
            break
    if len(columns) < 2:
        return None
    length = 0
    for found in readings[below:]:
        length += columns <= found
        if not found and not named:
            break
    return Block(place, header, below, length, len(columns), named)


def _readings(row: Sequence[Cell]) -> frozenset[int]:
    return frozenset(index for index, cell in enumerate(row) if cell != "" and is_reading(cell))


def _keys(heading: str) -> tuple[str, ...]:
    return key(heading), key(guess_unit(heading)[0]), key(without_brackets(heading))


def _header(rows: Rows, place: int, below: int) -> list[str]:
    """Names with their units; a name left empty is that of the row directly above, as in merged cells, or below."""
    line, row = rows[place]
    above = rows[place - 1] if place else (0, [])
    over = above[1] if above[0] == line - 1 and not _readings(above[1]) else []
    parts = [_parts(row) for _, row in rows[place + 1 : below]]
    if _is_units(over):
        parts.append(_parts(over))
        over = []
    elif sum(cell != "" for cell in over) < 2:  # a title
        over = []
    spanning = _spanning(above[1]) if above[0] == line - 1 else {}
    for _, units in rows[place + 1 : below]:
        spanning |= _spanning(units)
    titles = _titles(rows, place)
    header = []
    for index in range(max(len(row), *(len(one) for one in parts), 0)):
        name = shown(_at(row, index)) or shown(_at(over, index))
        for one in parts:
            further, unit = one[index] if index < len(one) else ("", "")
            name = name or further
            if unit:
                name = f"{name} [{unit}]".strip()
        if name and index in spanning:
            name = _with_unit(name, spanning[index])
        for meant, unit in titles if name else ():
            named = quantities_of(without_brackets(name))[:1]
            if named and dimension_of(named[0]) == known_unit(unit)[1] and meant in ("", named[0]):
                name = _with_unit(name, unit)
        header.append(name)
    return header


def _has_unit_column(rows: Rows, place: int, index: int) -> bool:
    """Whether a row such as ``1;1;mm`` holds readings, with their unit in a column of its own."""
    row, next_row = rows[index][1], rows[index + 1][1] if index + 1 < len(rows) else []
    if not _readings(row):
        return False
    words = [column for column, cell in enumerate(row) if cell != "" and not is_reading(cell)]
    return any(
        is_unit_column(shown(_at(rows[place][1], column))) or row[column] == _at(next_row, column) for column in words
    )


def _spanning(row: Sequence[Cell]) -> dict[int, str]:
    """Units of merged cells, by the columns that these span."""
    found = {}
    for index, cell in enumerate(row):
        if isinstance(cell, Covered) and (unit := _unit_in(cell.text)) is not None:
            found[index] = unit
            if not isinstance(row[index - 1], Covered):
                found[index - 1] = unit
    return found


def _unit_in(text: str) -> str | None:
    """The only unit that a heading or a title names for certain."""
    if (unit := unit_of_cell(text)) is not None:
        return unit
    best = best_unit(named := units_of(text))
    return best.text if best is not None and best.certain and unclear_unit(named) is None else None


def _titles(rows: Rows, place: int) -> list[tuple[str, str]]:
    """What lines such as ``Setzungen in mm`` say above a table: quantity, empty for all, and unit."""
    found = []
    for _, row in reversed(rows[max(place - _MOST_TITLES, 0) : place]):
        filled = [cell for cell in row if cell != ""]
        if len(_readings(row)) > 1:
            break  # another table
        if len(filled) != 1 or not isinstance(filled[0], str) or (unit := _unit_in(filled[0])) is None:
            continue
        label = " ".join(_NO_WORDS.sub(" ", filled[0].replace(unit, " ", 1)).split())
        words = _TITLE_WORDS.sub(" ", label).split()
        meant = quantities_of(words[0].removesuffix("en").removesuffix("s")) if len(words) == 1 else ()
        if _ALL.fullmatch(label) is not None:
            found.append(("", unit))
        elif meant:
            found.append((meant[0], unit))
    return found


def _with_unit(name: str, unit: str) -> str:
    """A heading with the unit that a merged cell or a title adds; with both where they contradict each other."""
    named = units_of(name)
    best, added = best_unit(named), known_unit(unit)
    if not named:
        return f"{name} [{unit}]"
    other = best is not None and best.base == added[1] and best.unit != added[0]
    return f"{name} [{unit}]" if other else name


def _parts(row: Sequence[Cell]) -> list[tuple[str, str]]:
    """Name and unit in each cell of a row of headings; in a row of units a word is an unknown unit, too.

    Where units are in brackets, ``[min]``, ``Gauge 2``, words without them are names.
    """
    if not _is_units(row, letters=True):
        return [("", unit) for unit in _symbols(row) or ()] or [(shown(cell), "") for cell in row]
    cells = [str(cell).strip() for cell in row]
    brackets = any(cell[:1] in "[({" and unit_of_cell(cell) is not None for cell in cells if cell)
    parts = []
    for cell in cells:
        unit, best = unit_of_cell(cell), best_unit(units_of(cell))
        if unit is None and best is not None and best.certain:
            parts.append((best.label, best.text))
        else:
            named = unit is None and brackets and cell[:1] not in "[({"
            parts.append((cell, "") if named else ("", unit or cell))
    return parts


def _at(row: Sequence[Cell], index: int) -> Cell:
    return row[index] if index < len(row) else ""
