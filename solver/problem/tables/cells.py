"""The cells of a file of measurements, CSV, XLSX or ODS: what problem files, the command line and the form all read."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.problem.tables.blocks import SAMPLE, Block, begin, is_reading, shown, unit_of_cell, with_units
from geoswarm.solver.problem.tables.headings import known_unit, number_with_unit
from geoswarm.solver.problem.tables.packed import Cell
from geoswarm.solver.problem.tables.reading import (
    BLANKS,
    MAX_TABLE_BYTES,
    SEPARATORS,
    WIDE_BLANKS,
    TableError,
    cell_number,
    decoded,
    refuse_surplus,
    table_lines,
    table_rows,
)
from geoswarm.solver.problem.tables.workbooks import read_workbook
from geoswarm.solver.sentences import Key
from geoswarm.solver.units import convert

_SUMMARY = re.compile(
    r"(?:mittel(?:wert)?|mean|average|avg|durchschnitt|summe|sum|total|gesamt|min(?:imum)?|max(?:imum)?|median"
    r"|std\.?(?:abw| ?dev)\.?|standard(?:abweichung| deviation)|anzahl|count)\s*\.?\s*:?",
    re.IGNORECASE,
)
_PEST = re.compile(r"\s*(?:(pcf)(?:\s+version\b.*)?|(?:pif|[pj]tf)\s+[^\w\s])\s*$", re.IGNORECASE | re.MULTILINE)
_WORD = re.compile(r"[^\W\d_]{3}")
_SOME_ROWS = 3
_MANY_ROWS = 50
_TITLES = 10
_WORTH_IT = 2**17
_PLAIN_BODY = re.compile(rb"[0-9eE+\-., \r\n]*")

__all__ = [
    "Area",
    "Sheet",
    "number_in",
    "plain_numbers",
    "read_cells",
    "without_units",
]

Area: TypeAlias = tuple[int, int, int, int | None]
"""Cells: places of the first and the last column from 0, lines of the first and the last row, None to the end."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """The rows of a file that are neither empty nor comments.

    Parameters
    ----------
    sheets, sheet
        Names of a workbook's sheets and of the one that was read; empty and None for CSV.
    comments
        Lines that begin with ``#``; the others are empty.
    header
        Headings; empty where the first row has numbers only.
    rows
        Number of the line and the cells of each row below.
    grid
        The same of all rows, titles and headings too, by number of the line.
    """

    sheets: tuple[str, ...]
    sheet: str | None
    comments: str
    header_line: int
    header: list[str]
    rows: list[tuple[int, list[Cell]]]
    grid: dict[int, list[Cell]]


def read_cells(
    content: bytes,
    name: str,
    sheet: str | None = None,
    *,
    numbers: bool = False,
    wanted: Iterable[str] = (),
    areas: Iterable[Area] = (),
) -> Sheet:
    """Read a table of text or one sheet of a workbook (XLSX, ODS); which of them it is follows from the content.

    Parameters
    ----------
    name
        Of the file, for messages.
    sheet
        Of a workbook; unless given, the only one with the headings and the cells that are wanted, else the first one
        with cells.
    numbers
        Whether the first sheet with a table, or a row of numbers, is meant where none is given, not a cover before it.
    wanted
        Headings by which the table is found where a file holds several.
    areas
        Cells in which the sheet has readings.

    Raises
    ------
    TableError
        It cannot be read.
    """
    wanted, areas = list(wanted), list(areas)
    if len(content) > MAX_TABLE_BYTES:
        raise TableError(f"{name} is larger than {MAX_TABLE_BYTES} bytes")
    if content.startswith(b"PK"):
        alone = not numbers and bool(wanted or areas)
        suits = _looks_like_table if numbers else (lambda rows: _has_columns(rows, wanted, areas)) if alone else None
        sheets, chosen, found = read_workbook(content, name, sheet, suits, alone=alone)
        rows = _filled(found)
        return _sheet(tuple(sheets), chosen, "", rows, begin(rows, wanted), _first_numbers(rows))
    if content.startswith(b"\xd0\xcf\x11\xe0"):
        raise TableError(f"{name} is a workbook of the old form (.xls); save it as .xlsx, .ods or .csv")
    text = decoded(content)
    if "\0" in text:
        raise TableError(f"{name} is neither text (CSV) nor a workbook (XLSX, ODS)")
    if text.lstrip().startswith('"GROUP"'):
        problem = Key("files", f"geoswarm import ags {name} makes a problem of it", "ags")
        raise TableError((f"{name} is an AGS file, which is not a table; ", problem))
    if (kind := _PEST.match(text)) is not None:
        case = name if kind[1] else "CASE.pst"
        what = f"{name} is a {'control' if kind[1] else 'template or instruction'} file of PEST"
        raise TableError(f"{what}; geoswarm import pest {case} --output DIR makes a problem of it and its files")
    if sheet is not None:
        raise TableError(f"{name} is not a workbook, so it has no sheet '{sheet}'")
    comments = "\n".join(line if line.lstrip().startswith("#") else "" for line in text.splitlines()).rstrip("\n")
    lines = table_lines(text, name)
    separator, block = _separated(lines, name, wanted)
    rows = [(line, list[Cell](cells)) for line, cells in _rows(lines, name, separator)]
    read = _sheet((), None, comments, rows, block, 0)
    width = len(read.header) or len(rows[0][1]) if rows else 0
    refuse_surplus(read.rows, width, name, separator)
    return read


def _separated(lines: list[tuple[int, str]], name: str, wanted: list[str]) -> tuple[str, Block | None]:
    """The separator with which the most rows look like those of a table, and where that begins."""
    best: tuple[tuple[bool, int, int], str, Block] | None = None
    for separator in SEPARATORS:
        try:
            rows = _rows(lines[:SAMPLE], name, separator)
        except TableError:
            continue
        block = begin(rows, wanted)
        if block is not None and separator in (BLANKS, WIDE_BLANKS):
            cells = len(rows[block.below][1])  # blanks inside a name, or empty cells
            block = block if cells == len(block.header) else None
        if block is not None:
            merit = (block.named, block.length, block.width)
            if best is None or merit > best[0]:
                best = merit, separator, block
    if best is not None:
        return best[1], best[2]
    first = lines[0][1] if lines else ""
    return next((sign for sign in ";\t" if sign in first), _without_heading(lines)), None


def _rows(lines: list[tuple[int, str]], name: str, separator: str) -> list[tuple[int, list[str]]]:
    """Cells of the lines; between blanks, a heading of several words is one cell where its unit shows where it ends."""
    rows = table_rows(lines, name, separator)
    if separator == BLANKS:
        for place, (_, cells) in enumerate(rows[1:SAMPLE]):
            line, above = rows[place]
            if len(above) > len(cells) > 1 and all(cell_number(cell) is not None for cell in cells):
                rows[place] = line, list(with_units(above, len(cells)))
    return rows


def _without_heading(lines: list[tuple[int, str]]) -> str:
    """Blanks where they separate the numbers of the first lines, and no comma does."""
    first, second = ([*(line.split() for _, line in lines[:2]), [], []])[:2]
    numbers = [cell_number(cell) is not None for cell in first]
    return BLANKS if sum(numbers) > 1 and (all(numbers) or len(second) == len(first)) else ","


def _filled(rows: list[list[Cell]]) -> list[tuple[int, list[Cell]]]:
    """Rows with cells and their lines; of a group in the AGS format its headings with their units, and its data."""
    filled = [(line, cells) for line, cells in enumerate(rows, start=1) if any(cell != "" for cell in cells)]
    place = next((place for place, (_, row) in enumerate(filled[:_TITLES]) if row[0] == "HEADING"), None)
    if place is None or place + 1 == len(filled) or filled[place + 1][1][0] != "UNIT":
        return filled
    (line, names), (_, units) = filled[place : place + 2]
    header = [f"{name} [{unit}]" if name and unit else name for name, unit in zip_longest(names, units, fillvalue="")]
    return [(line, [names[0], *header[1:]]), *(row for row in filled[place + 2 :] if row[1][0] == "DATA")]


def _looks_like_table(rows: list[list[Cell]]) -> int:
    """2: some rows of readings stand below names; 1: a row has two numbers, dates or formulas, as readings have."""
    block = begin(_filled(rows))
    if block is not None and block.length >= _SOME_ROWS:
        return 2
    return int(any(sum(is_reading(cell) for cell in row) >= 2 for row in rows))


def _has_columns(rows: list[list[Cell]], wanted: list[str], areas: list[Area]) -> int:
    block = begin(_filled(rows), wanted) if wanted else None
    named = not wanted or (block is not None and block.named)
    return 2 if named and all(_has_readings(rows, area) for area in areas) else 0


def _has_readings(rows: list[list[Cell]], area: Area) -> bool:
    first, last, top, bottom = area
    return any(is_reading(cell) for row in rows[top - 1 : bottom] for cell in row[first : last + 1])


def _first_numbers(rows: list[tuple[int, list[Cell]]]) -> int:
    """Sheets often begin with titles: place of the row above the first row of numbers."""
    for index, (_, row) in enumerate(rows):
        if sum(is_reading(cell) for cell in row) >= min(2, max(len(row), 1)):
            return max(index - 1, 0)
    return 0


def _sheet(
    sheets: tuple[str, ...],
    sheet: str | None,
    comments: str,
    rows: list[tuple[int, list[Cell]]],
    block: Block | None,
    first: int,
) -> Sheet:
    """What is read; ``first`` is the place of the headings where no table was found."""
    grid = dict(rows)
    if not rows:
        return Sheet(sheets, sheet, comments, 1, [], [], grid)
    if block is not None and (block.named or not _only_numbers(rows[0][1])):
        return Sheet(sheets, sheet, comments, rows[block.place][0], block.header, _body(rows, block), grid)
    line, cells = rows[first]
    if _only_numbers(cells) or _continues(cells, [row for _, row in rows[first + 1 : first + _MANY_ROWS]]):
        return Sheet(sheets, sheet, comments, line, [], rows[first:], grid)
    return Sheet(sheets, sheet, comments, line, [shown(cell) for cell in cells], rows[first + 1 :], grid)


def _body(rows: list[tuple[int, list[Cell]]], block: Block) -> list[tuple[int, list[Cell]]]:
    """Rows below the headings, without the same headings once more and without lines of words at the end."""
    heads = [row for _, row in rows[block.place : block.below]]
    body = [(line, row) for line, row in rows[block.below :] if row not in heads]
    while body and (_is_line_of_words(body[-1][1]) or _is_summary(body[-1][1], body[0][1])):
        body.pop()
    return body


def _is_line_of_words(row: list[Cell]) -> bool:
    filled = [cell for cell in row if cell != ""]
    return len(filled) == 1 and not is_reading(filled[0]) and _WORD.search(str(filled[0])) is not None


def _is_summary(row: list[Cell], first: list[Cell]) -> bool:
    """Whether a row below the readings says what it sums up: ``Mittelwert;0,47``; not ``min`` in a column of units."""
    return any(
        isinstance(cell, str) and _SUMMARY.fullmatch(cell) is not None and not unit_of_cell(above)
        for cell, above in zip_longest(row, first[: len(row)], fillvalue="")
    )


def _continues(row: list[Cell], below: list[list[Cell]]) -> bool:
    """Whether the rows below go on with what a row has: numbers in the same columns, texts of the same form."""
    numbers, first = ({i for i, cell in enumerate(one) if is_reading(cell)} for one in [row, *below, []][:2])
    if len(numbers) < 2 or not first or not first <= numbers:
        return False
    texts = [(place, _form(cell)) for place, cell in enumerate(row) if cell != "" and place not in numbers]
    return all(any(_form(other[place]) == form for other in below if place < len(other)) for place, form in texts)


def _form(cell: Cell) -> str:
    """Capitals, small letters and figures of a text: ``A0`` of ``S1``."""
    text = re.sub(r"[^\W\d_]", lambda found: "A" if found[0].isupper() else "a", str(cell))
    return re.sub(r"\d+", "0", text)


def _only_numbers(row: list[Cell]) -> bool:
    filled = [cell for cell in row if cell != ""]
    return bool(filled) and all(number_in(cell) is not None for cell in filled)


def without_units(cells: Sequence[Cell]) -> tuple[list[Cell], str | None]:
    """Cells without the unit that each of them ends with, such as ``0,1 %``, and that unit; 0 needs none.

    Of several units of one dimension, ``15 s`` and ``1 min``, the base unit. The cells themselves and None where they
    have no unit, or units of several dimensions.
    """
    kept: list[Cell] = []
    units: list[str | None] = []
    for cell in cells:
        split = number_with_unit(cell) if isinstance(cell, str) and cell else None
        own, base = (None, None) if split is None else known_unit(split[1])
        plain = split is None and number_in(cell) not in (None, 0.0)
        if plain or (split is not None and own is None):
            return list(cells), None  # of most columns the first cell says so
        kept.append(cell if split is None else split[0])
        units.append(own)
    several = set(units) - {None}
    if len(several) < 2:
        return kept, next(iter(several), None)
    bases = {known_unit(unit)[1] for unit in several if unit is not None}
    base = bases.pop()
    if bases or base is None:
        return list(cells), None
    values = [(number_in(cell), unit) for cell, unit in zip(kept, units, strict=True)]
    converted = (None if value is None or unit is None else float(convert(value, unit, base)) for value, unit in values)
    return [cell if value is None else value for cell, value in zip(kept, converted, strict=True)], base


def number_in(cell: Cell) -> float | None:
    """Return the finite number in a cell; None for anything else."""
    if isinstance(cell, float):
        return cell if math.isfinite(cell) else None
    return cell_number(cell)


def plain_numbers(content: bytes) -> tuple[Sheet, FloatArray] | None:
    """Read headings, with the first row as a sample, and all numbers, shape (rows, columns).

    None for what is small, is no such file, or has a mistake: then the reader that names lines is asked.
    """
    if not _WORTH_IT < len(content) <= MAX_TABLE_BYTES:
        return None
    first, newline, body = content.partition(b"\n")
    heading = first.removeprefix(b"\xef\xbb\xbf").strip()
    if not newline or any(sign in heading for sign in b';\t"#') or _PLAIN_BODY.fullmatch(body) is None:
        return None
    try:
        header = [cell.strip() for cell in heading.decode("ascii").split(",")]
        numbers = np.loadtxt(io.BytesIO(body), delimiter=",", ndmin=2)
    except ValueError:  # not ASCII, an empty cell, rows of several lengths
        return None
    if numbers.shape[1] != len(header) or not np.isfinite(numbers).all() or _PLAIN_BODY.fullmatch(heading) is not None:
        return None
    sample: list[Cell] = [float(number) for number in numbers[0]]
    return Sheet((), None, "", 1, header, [(2, sample)], {}), numbers
