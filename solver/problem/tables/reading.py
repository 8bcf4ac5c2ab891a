"""The text of tables: comma, semicolon, tab or blanks between cells, ``#`` comments, decimal comma or point."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from geoswarm.solver.errors import Issue
from geoswarm.solver.sentences import Sentence, plain

__all__ = [
    "BLANKS",
    "MAX_CELL_CHARACTERS",
    "MAX_LINE_CHARACTERS",
    "MAX_TABLE_BYTES",
    "SEPARATORS",
    "WIDE_BLANKS",
    "DoubtError",
    "TableError",
    "UnnamedColumnsError",
    "cell_number",
    "decoded",
    "file_content",
    "refuse_surplus",
    "table_lines",
    "table_rows",
]

MAX_TABLE_BYTES = 32 * 2**20
"""Largest file of measurements."""

MAX_LINE_CHARACTERS = 100_000
"""Longest line of a CSV file."""

MAX_CELL_CHARACTERS = 32_767
"""Longest text in a cell, as in spreadsheet programs."""

_SAMPLE = 2000
_LAST = 20  # rows in which those of a table would show
BLANKS = " "
WIDE_BLANKS = "  "
SEPARATORS = (";", "\t", ",", WIDE_BLANKS, BLANKS)
"""What may stand between cells: semicolon, tab, comma, at least two blanks or a tab, any blanks."""

_WIDE = re.compile(r"\s*\t\s*|\s{2,}")
_BRACKET = re.compile(r"\[[^\]\[]*\]|\([^()]*\)|\{[^{}]*\}")
_NAMED = re.compile(r"(?<=\S)\s+(?=(?:\[[^\]\[]*\]|\([^()]*\)|\{[^{}]*\})(?:\s|$))")
_EXPONENT_OF_FORTRAN = str.maketrans("dD", "ee")
_MOST_DIGITS = 1100  # a float written out in full has 1075 at most
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+|[dD][+-]?\d{2,3})?", re.ASCII)
_NUMBER_WITH_COMMA = re.compile(r"[+-]?(?:\d+(?:,\d*)?|,\d+)(?:[eE][+-]?\d+)?", re.ASCII)


class TableError(Exception):
    """A table cannot be read; ``sentences`` name every bad cell by line and column, with keys of the observation."""

    def __init__(self, *messages: str | Sentence) -> None:
        self.sentences = tuple((one,) if isinstance(one, str) else one for one in messages)
        self.messages = tuple(map(plain, self.sentences))
        super().__init__("; ".join(self.messages))

    def issues(self, path: str = "", within: str = "") -> list[Issue]:
        """The mistakes at a path of the problem; keys are those ``within`` a part of it."""
        return [Issue.about(path, sentence, within) for sentence in self.sentences]


class UnnamedColumnsError(TableError):
    """Nobody says which columns are those of x and y, and none is called so."""


class DoubtError(TableError):
    """A column can be read in several ways; ``assumed`` is one of the answers, to see what else is open."""

    def __init__(self, assumed: Mapping[str, Any], message: Sentence) -> None:
        super().__init__(message)
        self.assumed = assumed


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


def decoded(content: bytes) -> str:
    """Text of a table: UTF-8, UTF-16 with its mark or without, else Windows-1252 or Latin-1."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):  # spreadsheets call this "Unicode text"
        return content.decode("utf-16", errors="replace")
    for first, encoding in ((0, "utf-16-be"), (1, "utf-16-le")):
        if content[first:_SAMPLE:2].count(0) * 3 > len(content[:_SAMPLE]):  # without its mark: no text has zeros
            return content.decode(encoding, errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        pass
    try:
        return content.decode("cp1252")  # older spreadsheets
    except UnicodeDecodeError:
        return content.decode("latin-1")


def table_lines(text: str, name: str) -> list[tuple[int, str]]:
    """Lines of a table that are neither empty nor comments, with their numbers.

    Raises
    ------
    TableError
        A line is too long.
    """
    lines = []
    for number, line in enumerate(text.splitlines(), start=1):
        if len(line) > MAX_LINE_CHARACTERS:
            raise TableError(
                f"{name} line {number} has {len(line)} characters; at most {MAX_LINE_CHARACTERS} are accepted"
            )
        if _counts(line):
            lines.append((number, line))
    return lines


def table_rows(lines: Sequence[tuple[int, str]], name: str, separator: str) -> list[tuple[int, list[str]]]:
    """Cells of each line, with the number of the line where they begin.

    Parameters
    ----------
    separator
        One of :data:`SEPARATORS`.

    Raises
    ------
    TableError
        Quotes are not closed or the like, or a cell is too long.
    """
    if separator == BLANKS:
        return [(number, _split(line, separator)) for number, line in lines]
    if separator == WIDE_BLANKS:
        return _aligned(lines)
    rows: list[tuple[int, list[str]]] = []
    begins = 0
    while begins < len(lines):
        try:
            for place, cells in _quoted_rows(lines, begins, separator):
                number = lines[place][0]
                longest = max(map(len, cells), default=0)
                if longest > MAX_CELL_CHARACTERS:
                    what = f"a cell of {longest} characters; at most {MAX_CELL_CHARACTERS} are accepted"
                    raise TableError(f"{name} line {number} has {what}")
                rows.append((number, [cell.strip() for cell in cells]))
            break
        except _QuotesError as error:
            begins = error.line
            rows.append((lines[begins][0], [cell.strip() for cell in lines[begins][1].split(separator)]))
            if begins + 2 >= len(lines) or any(_numbers(cells) > 1 for _, cells in rows[-_LAST:]):
                raise TableError(f"{name} line {lines[begins][0]}: {error}") from None
            begins += 1  # a line above the table, whose quotes are not those of cells
    return rows


def _aligned(lines: Sequence[tuple[int, str]]) -> list[tuple[int, list[str]]]:
    """Cells between wide blanks; the first is empty where a line begins below the second cell of a full one above."""
    rows: list[tuple[int, list[str]]] = []
    full, second = 0, 0
    for number, line in lines:
        cells = _split(line, WIDE_BLANKS)
        if len(cells) + 1 == full and 0 < second <= len(line) - len(line.lstrip()):
            cells.insert(0, "")
        else:
            found = _WIDE.search(line.rstrip())
            full, second = len(cells), found.end() if found is not None else 0
        rows.append((number, cells))
    return rows


def _numbers(cells: Sequence[str]) -> int:
    return sum(cell_number(cell.strip('"')) is not None for cell in cells)


class _QuotesError(Exception):
    """Quotes are not closed, or stand in the wrong place, in the row that begins at ``line``, a place in the lines."""

    def __init__(self, line: int, reason: str) -> None:
        self.line = line
        super().__init__(reason)


def _quoted_rows(lines: Sequence[tuple[int, str]], first: int, separator: str) -> Iterator[tuple[int, list[str]]]:
    """Cells of rows from a line on, with the place of the line where each begins: a line break may stand in quotes."""
    reader = csv.reader(
        (f"{line}\n" for _, line in lines[first:]),
        delimiter=separator,
        skipinitialspace=separator != "\t",
        strict=True,
    )
    begins = first
    try:
        for cells in reader:
            yield begins, cells
            begins = first + reader.line_num
    except csv.Error as error:
        raise _QuotesError(min(begins, len(lines) - 1), str(error)) from None


def _split(line: str, separator: str) -> list[str]:
    """Cells of a line between blanks; a unit in brackets belongs to the name before it."""
    if separator == WIDE_BLANKS:
        return _WIDE.split(line.strip())
    if _BRACKET.match(line.lstrip()) is None:
        line = _BRACKET.sub(lambda found: found[0].replace(" ", "\0").replace("\t", "\0"), _NAMED.sub("\0", line))
    return [cell.replace("\0", " ") for cell in line.split()]


def refuse_surplus(rows: Sequence[tuple[int, Sequence[str | float]]], width: int, name: str, separator: str) -> None:
    """Refuse rows that go on behind the last heading, and where blanks separate, rows of another length.

    A number was split there, and its rest would be dropped; between blanks an empty cell cannot be seen.
    """
    blank = separator in (BLANKS, WIDE_BLANKS)
    wrong = [
        (line, cells)
        for line, cells in rows
        if (len(cells) > width and any(cells[width:])) or (blank and len(cells) < width)
    ]
    if not wrong:
        return
    if blank:
        remedy = "where cells are empty, or hold blanks, separate the columns by semicolons or tabs"
    elif width == 1:
        remedy = (
            f"semicolon, tab, comma and blanks were tried as separators; is line {rows[0][0] - 1} the line of headings?"
        )
    elif separator == ",":
        remedy = "a comma inside a number (1,234) splits it: leave it out, or separate the columns by semicolons"
    else:
        remedy = "give every column a heading"
    messages = [
        f"{name} line {line}: {len(cells)} cells under {width} headings ({', '.join(map(str, cells))[:80]}); {remedy}"
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
    cell = cell.replace("\u2212", "-").replace("\u2013", "-")  # a minus as word processors write it
    if _NUMBER.fullmatch(cell):
        value = float(cell.translate(_EXPONENT_OF_FORTRAN))
    elif _NUMBER_WITH_COMMA.fullmatch(cell):
        # Only possible beside another delimiter, or in quotes.
        value = float(cell.replace(",", "."))
    else:
        return None
    return value if abs(value) < float("inf") else None
