"""The cells of a file of measurements, CSV, XLSX or ODS: what problem files, the command line and the form all read."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from geoswarm.solver.problem.tables.dates import moment_in
from geoswarm.solver.problem.tables.packed import FORMULA, Cell
from geoswarm.solver.problem.tables.reading import MAX_TABLE_BYTES, TableError, cell_number, decoded, table_rows
from geoswarm.solver.problem.tables.workbooks import read_workbook

__all__ = ["Sheet", "file_content", "number_in", "read_cells"]


@dataclass(frozen=True, slots=True)
class Sheet:
    """The rows of a file that are neither empty nor comments.

    Parameters
    ----------
    sheets, sheet
        Names of a workbook's sheets and of the one that was read; empty and None for CSV.
    comments
        Lines that begin with ``#``.
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


def file_content(path: Path) -> bytes:
    """Return what a file holds.

    Raises
    ------
    TableError
        It is missing, unreadable, or too large.
    """
    if path.is_fifo():  # a pipe would be waited for
        raise TableError(f"{path} is a pipe, not a file")
    try:
        with path.open("rb") as file:
            return file.read(MAX_TABLE_BYTES + 1)
    except FileNotFoundError:
        raise TableError(f"no such file: {path}") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise TableError(f"{path} cannot be read: {reason}") from None


def read_cells(content: bytes, name: str, sheet: str | None = None, *, numbers: bool = False) -> Sheet:
    """Read a CSV file or one sheet of a workbook (XLSX, ODS); which of them it is follows from the content.

    Parameters
    ----------
    name
        Of the file, for messages.
    sheet
        Of a workbook; the first one with cells unless given.
    numbers
        Whether the first sheet with a row of numbers is meant where none is given, not a cover before it.

    Raises
    ------
    TableError
        It cannot be read.
    """
    if len(content) > MAX_TABLE_BYTES:
        raise TableError(f"{name} is larger than {MAX_TABLE_BYTES} bytes")
    if content.startswith(b"PK"):
        sheets, chosen, found = read_workbook(content, name, sheet, _has_numbers if numbers else None)
        rows = [(line, cells) for line, cells in enumerate(found, start=1) if any(cell != "" for cell in cells)]
        return _below_header(tuple(sheets), chosen, "", rows, _below_title(rows))
    if content.startswith(b"\xd0\xcf\x11\xe0"):
        raise TableError(f"{name} is a workbook of the old form (.xls); save it as .xlsx, .ods or .csv")
    text = decoded(content)
    if "\0" in text:
        raise TableError(f"{name} is neither text (CSV) nor a workbook (XLSX, ODS)")
    if sheet is not None:
        raise TableError(f"{name} is not a workbook, so it has no sheet '{sheet}'")
    comments = "\n".join(line for line in text.splitlines() if line.lstrip().startswith("#"))
    rows = [(line, list[Cell](cells)) for line, cells in table_rows(text, name)]
    return _below_header((), None, comments, rows, rows)


def _has_numbers(rows: list[list[Cell]]) -> bool:
    """Whether a row has two numbers, dates or formulas, as readings have."""
    return any(sum(_is_reading(cell) for cell in row) >= 2 for row in rows)


def _is_reading(cell: Cell) -> bool:
    return number_in(cell) is not None or str(cell).startswith(FORMULA) or moment_in(cell) is not None


def _below_title(rows: list[tuple[int, list[Cell]]]) -> list[tuple[int, list[Cell]]]:
    """Sheets often begin with titles: leave out what stands above the heading of the first row of numbers."""
    for index, (_, row) in enumerate(rows):
        numbers = sum(_is_reading(cell) for cell in row)
        if numbers >= min(2, max(len(row), 1)):
            return rows[max(index - 1, 0) :]
    return rows


def _below_header(
    sheets: tuple[str, ...],
    sheet: str | None,
    comments: str,
    every: list[tuple[int, list[Cell]]],
    rows: list[tuple[int, list[Cell]]],
) -> Sheet:
    grid = dict(every)
    if not rows:
        return Sheet(sheets, sheet, comments, 1, [], [], grid)
    line, first = rows[0]
    filled = [cell for cell in first if cell != ""]
    if filled and all(number_in(cell) is not None for cell in filled):
        return Sheet(sheets, sheet, comments, line, [], rows, grid)
    return Sheet(sheets, sheet, comments, line, [str(cell).strip() for cell in first], rows[1:], grid)


def number_in(cell: Cell) -> float | None:
    """Return the finite number in a cell; None for anything else."""
    if isinstance(cell, float):
        return cell if math.isfinite(cell) else None
    return cell_number(cell)
