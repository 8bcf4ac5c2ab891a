"""The text of CSV files: comma, semicolon or tab, ``#`` comments, decimal comma beside semicolons."""

from __future__ import annotations

import csv
import re

__all__ = [
    "MAX_CELL_CHARACTERS",
    "MAX_LINE_CHARACTERS",
    "MAX_TABLE_BYTES",
    "TableError",
    "cell_number",
    "decoded",
    "table_rows",
]

MAX_TABLE_BYTES = 32 * 2**20
"""Largest file of measurements."""

MAX_LINE_CHARACTERS = 100_000
"""Longest line of a CSV file."""

MAX_CELL_CHARACTERS = 32_767
"""Longest text in a cell, as in spreadsheet programs."""

_MOST_DIGITS = 1100  # a float written out in full has 1075 at most
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_NUMBER_WITH_COMMA = re.compile(r"[+-]?(?:\d+(?:,\d*)?|,\d+)(?:[eE][+-]?\d+)?", re.ASCII)


class TableError(Exception):
    """A table cannot be read; ``messages`` names every bad cell by line and column."""

    def __init__(self, *messages: str) -> None:
        self.messages = messages
        super().__init__("; ".join(messages))


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
        Quotes are not closed or the like, a line or a cell is too long, or a row has more cells than the first one.
    """
    lines = []
    for number, line in enumerate(text.splitlines(), start=1):
        if len(line) > MAX_LINE_CHARACTERS:
            raise TableError(
                f"{name} line {number} has {len(line)} characters; at most {MAX_LINE_CHARACTERS} are accepted"
            )
        if _counts(line):
            lines.append((number, line))
    if not lines:
        return []
    header = lines[0][1]
    delimiter = next((sign for sign in ";\t" if sign in header), ",")
    reader = csv.reader((line for _, line in lines), delimiter=delimiter, skipinitialspace=True, strict=True)
    rows: list[tuple[int, list[str]]] = []
    try:
        for (number, _), cells in zip(lines, reader, strict=False):
            longest = max(map(len, cells), default=0)
            if longest > MAX_CELL_CHARACTERS:
                what = f"a cell of {longest} characters; at most {MAX_CELL_CHARACTERS} are accepted"
                raise TableError(f"{name} line {number} has {what}")
            rows.append((number, [cell.strip() for cell in cells]))
    except csv.Error as error:
        raise TableError(f"{name} line {lines[min(len(rows), len(lines) - 1)][0]}: {error}") from None
    _refuse_surplus(rows, name, delimiter)
    return rows


def _refuse_surplus(rows: list[tuple[int, list[str]]], name: str, delimiter: str) -> None:
    """Refuse rows that go on behind the last heading: a number was split there, and its rest would be dropped."""
    width = len(rows[0][1])
    wrong = [(line, cells) for line, cells in rows if len(cells) > width and any(cells[width:])]
    if not wrong:
        return
    if width == 1:
        remedy = f"is line {rows[0][0]} the line of headings? Lines above it begin with #"
    elif delimiter == ",":
        remedy = "a comma inside a number (1,234) splits it: leave it out, or separate the columns by semicolons"
    else:
        remedy = "give every column a heading"
    messages = [
        f"{name} line {line}: {len(cells)} cells under {width} headings ({', '.join(cells)[:80]}); {remedy}"
        for line, cells in wrong[:3]
    ]
    raise TableError(*messages, *([f"{name}: {len(wrong) - 3} more such lines"] if len(wrong) > 3 else []))


def _counts(line: str) -> bool:
    content = line.strip()
    return bool(content.strip(",;")) and not content.startswith("#")


def cell_number(cell: str) -> float | None:
    """The finite number that a cell shows, with a decimal point or comma; None for anything else."""
    if len(cell) > _MOST_DIGITS:
        return None
    if _NUMBER.fullmatch(cell):
        value = float(cell)
    elif _NUMBER_WITH_COMMA.fullmatch(cell):
        # Only possible beside another delimiter, or in quotes.
        value = float(cell.replace(",", "."))
    else:
        return None
    return value if abs(value) < float("inf") else None
