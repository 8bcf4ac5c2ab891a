"""Reads measured points from CSV files: comma, semicolon or tab, ``#`` comments, decimal comma beside semicolons."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

__all__ = ["MAX_TABLE_BYTES", "Table", "TableError", "cell_number", "decoded", "read_table", "table_rows"]

MAX_TABLE_BYTES = 32 * 2**20
"""Largest CSV file."""

_MOST_MESSAGES = 10
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_NUMBER_WITH_COMMA = re.compile(r"[+-]?(?:\d+,?\d*|,\d+)(?:[eE][+-]?\d+)?", re.ASCII)


class TableError(Exception):
    """A table cannot be read; ``messages`` names every bad cell by line and column."""

    def __init__(self, *messages: str) -> None:
        self.messages = messages
        super().__init__("; ".join(messages))


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of a table, all of the same length; ``weight`` None when there is no such column."""

    x: list[float]
    y: list[float]
    weight: list[float] | None


def read_table(path: Path, x: str | None = None, y: str | None = None, weight: str | None = None) -> Table:
    """Read the columns x, y and weight of a CSV file.

    Parameters
    ----------
    path
        The file. Its first line that is neither empty nor a ``#`` comment is the header.
    x, y, weight
        Names of the columns, upper and lower case alike; None stands for ``x``, ``y`` and, if there is one, ``weight``.

    Raises
    ------
    TableError
        Missing or unreadable file, missing column, or cells that are no finite numbers.
    """
    rows = table_rows(_text(path), path.name)
    if not rows:
        raise TableError(f"{path.name} is empty; a header line x,y is expected")
    (line, header), *body = rows
    columns = {"x": x or "x", "y": y or "y"}
    if weight is not None or "weight" in (_key(cell) for cell in header):
        columns["weight"] = weight or "weight"
    places = {role: _place(header, name, f"{path.name} line {line}") for role, name in columns.items()}
    if not body:
        raise TableError(f"{path.name} has a header but no points")
    reader = _Cells(path.name, header)
    data = {role: [reader.number(cells, place, line) for line, cells in body] for role, place in places.items()}
    reader.raise_errors()
    return Table(data["x"], data["y"], data.get("weight"))


def _text(path: Path) -> str:
    if path.is_fifo():  # a pipe would be waited for
        raise TableError(f"{path} is a pipe, not a file")
    try:
        with path.open("rb") as file:
            content = file.read(MAX_TABLE_BYTES + 1)
    except FileNotFoundError:
        raise TableError(f"no such file: {path}") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise TableError(f"{path} cannot be read: {reason}") from None
    if len(content) > MAX_TABLE_BYTES:
        raise TableError(f"{path.name} is larger than {MAX_TABLE_BYTES} bytes")
    return decoded(content)


def decoded(content: bytes) -> str:
    """Text of a table: UTF-8 or UTF-16 with its mark, else Latin-1."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):  # spreadsheets call this "Unicode text"
        return content.decode("utf-16", errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")  # older spreadsheets; numbers and most headers are the same in both


def table_rows(text: str, name: str) -> list[tuple[int, list[str]]]:
    """Rows of a table that are neither empty nor comments: number of the line and its cells, the header first.

    Raises
    ------
    TableError
        Quotes are not closed or the like.
    """
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if _counts(line)]
    if not lines:
        return []
    header = lines[0][1]
    delimiter = next((sign for sign in ";\t" if sign in header), ",")
    reader = csv.reader((line for _, line in lines), delimiter=delimiter, skipinitialspace=True, strict=True)
    rows: list[tuple[int, list[str]]] = []
    try:
        for (number, _), cells in zip(lines, reader, strict=False):
            rows.append((number, [cell.strip() for cell in cells]))
    except csv.Error as error:
        raise TableError(f"{name} line {lines[min(len(rows), len(lines) - 1)][0]}: {error}") from None
    return rows


def _counts(line: str) -> bool:
    content = line.strip()
    return bool(content.strip(",;")) and not content.startswith("#")


def cell_number(cell: str) -> float | None:
    """The finite number that a cell shows, with a decimal point or comma; None for anything else."""
    if _NUMBER.fullmatch(cell):
        value = float(cell)
    elif _NUMBER_WITH_COMMA.fullmatch(cell):
        # Only possible beside another delimiter, or in quotes.
        value = float(cell.replace(",", "."))
    else:
        return None
    return value if abs(value) < float("inf") else None


def _key(cell: str) -> str:
    return cell.strip().casefold()


def _place(header: list[str], name: str, where: str) -> int:
    found = [index for index, cell in enumerate(header) if _key(cell) == _key(name)]
    if len(found) == 1:
        return found[0]
    problem = "there is no column" if not found else "there are several columns"
    raise TableError(f"{where}: {problem} '{name}'; the header has: {', '.join(header)}")


class _Cells:
    def __init__(self, name: str, header: list[str]) -> None:
        self._name = name
        self._header = header
        self._messages: list[tuple[int, str]] = []

    def number(self, cells: list[str], place: int, line: int) -> float:
        cell = cells[place] if place < len(cells) else ""
        value = cell_number(cell)
        return self._bad(cell, place, line) if value is None else value

    def _bad(self, cell: str, place: int, line: int) -> float:
        what = f"'{cell[:50]}' is no finite number" if cell else "the cell is empty"
        self._messages.append((line, f"{self._name} line {line}, column {self._header[place]}: {what}"))
        return 0.0

    def raise_errors(self) -> None:
        if not self._messages:
            return
        shown = [message for _, message in sorted(self._messages)[:_MOST_MESSAGES]]
        more = len(self._messages) - len(shown)
        raise TableError(*shown, *([f"{self._name}: {more} more bad cells"] if more else []))
