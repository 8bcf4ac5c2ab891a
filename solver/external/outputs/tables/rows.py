"""Points from the rows of one table."""

from __future__ import annotations

import csv
import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from geoswarm.solver.expressions import Expression, parse_expression
from geoswarm.solver.external.errors import OutputError, OutputReason, place
from geoswarm.solver.external.outputs.base import Point
from geoswarm.solver.external.outputs.numbers import looks_like_number, number_of, reason_of
from geoswarm.solver.external.outputs.tables.quantities import Quantity, bound, column_number, column_of
from geoswarm.solver.words import visible

__all__ = [
    "Chosen",
    "Separator",
    "TableShape",
    "cell_splitter",
    "guessed_separator",
    "has_number",
    "split_row",
    "table_points",
]

_MOST_COMMENTS = 20


_SIGNS = {",": ",", ";": ";", "tab": "\t"}


@dataclass(frozen=True, slots=True)
class TableShape:
    """How the lines of a table are read; the fields are those of the section."""

    file: str
    x: int | str
    y: int | str
    separator: Separator
    fixed: tuple[tuple[int, int], ...] | None
    header: int | None
    comment: tuple[str, ...]
    decimal: str
    rows: int | None
    where: str | None

    def wrong(self, line: int, message: str, reason: OutputReason = "bad_output") -> OutputError:
        """Return the error of a line."""
        return OutputError(reason, f"{place(self.file, line)}: {message}")

    def is_comment(self, line: str) -> bool:
        """Whether a line is blank or a comment."""
        text = line.strip()
        return not text or (bool(self.comment) and text.startswith(self.comment))


class Chosen:
    """What is taken of each row: x, y, and whether the row counts.

    Parameters
    ----------
    header
        Names of columns.
    given
        Names that have a value in each row without being columns.
    line
        Where the header stands, for messages.
    """

    def __init__(self, shape: TableShape, header: Sequence[str], given: Sequence[str], line: int) -> None:
        self._shape = shape
        known = [*header, *(name for name in given if name not in header)]
        try:
            quantities = [column_of(shape.x, known), column_of(shape.y, known)]
            where = None if shape.where is None else column_of(shape.where, known)
        except ValueError as error:
            raise shape.wrong(line, str(error)) from None
        self._quantities = quantities
        self._x, self._y = bound(quantities[0]), bound(quantities[1])
        self._where: Expression | None = None if shape.where is None else parse_expression(shape.where)
        self._given = frozenset(given) - frozenset(header)
        self._of_points = self._places(quantities, header)
        self._of_where = {} if where is None else self._places([where], header)

    @property
    def columns(self) -> tuple[int, int] | None:
        """Places of x and y where they are columns as they stand and every row counts; None otherwise."""
        x, y = (self._of_points.get(one.names[0]) if one.expression is None else None for one in self._quantities)
        plain = self._where is None and self._shape.decimal == "."
        return None if x is None or y is None or not plain else (x, y)

    def _places(self, quantities: Sequence[Quantity], header: Sequence[str]) -> dict[str, int]:
        places: dict[str, int] = {}
        for name in (name for quantity in quantities for name in quantity.names):
            if name in header:
                places[name] = list(header).index(name)
            elif name not in self._given:
                places[name] = (column_number(name) or 1) - 1
        return places

    def counts(self, cells: Sequence[str], given: Mapping[str, float], line: int) -> bool:
        """Whether ``where`` takes the row."""
        if self._where is None:
            return True
        return bool(self._where.value(self._values(self._of_where, cells, given, line)))

    def may_count(self, cells: Sequence[str]) -> bool:
        """Whether the columns of ``where`` hold numbers at all."""
        return all(at < len(cells) and looks_like_number(cells[at]) for at in self._of_where.values())

    def point(self, cells: Sequence[str], given: Mapping[str, float], line: int, text: str) -> Point:
        """Return the point of a row."""
        values = self._values(self._of_points, cells, given, line)
        return Point(self._x(values), self._y(values), line, text)

    def _values(
        self, places: Mapping[str, int], cells: Sequence[str], given: Mapping[str, float], line: int
    ) -> dict[str, float]:
        values = dict(given)
        for name, at in places.items():
            try:
                values[name] = number_of(cells[at], self._shape.decimal)
            except IndexError:
                message = f"found {len(cells)} columns, but {name} is column {at + 1}; the row may be truncated"
                raise self._shape.wrong(line, message) from None
            except ValueError as error:
                message = f"{name} (column {at + 1}): {visible(str(error))}"
                raise self._shape.wrong(line, message, reason_of(error)) from None
        return values


def split_row(shape: TableShape, line: str) -> Callable[[str], list[str]]:
    """Return the function from a line to its cells, chosen by the first row of numbers."""
    separator = guessed_separator(line, shape.decimal) if shape.separator == "auto" else shape.separator
    return cell_splitter(separator, shape.fixed)


def has_number(cells: Sequence[str]) -> bool:
    """Whether some cell is meant as a number."""
    return any(looks_like_number(cell) for cell in cells)


def table_points(lines: Iterable[tuple[int, str]], shape: TableShape) -> Iterator[Point]:
    """Give the points of a table.

    Without ``header`` the lines before the first number are headings, the first of them with the names; where there are
    none, comments before are looked at, the last first, for one with as many words as the first row has cells and the
    names wanted.

    Raises
    ------
    OutputError
        A row cannot be read, a column does not exist, or there are fewer rows than were asked for.
    """
    headings: list[tuple[int, str]] = []
    comments: deque[tuple[int, str]] = deque(maxlen=_MOST_COMMENTS)
    chosen: Chosen | None = None
    columns: tuple[int, int] | None = None
    split: Callable[[str], list[str]] = str.split
    found, last = 0, 0
    for number, line in lines:
        last = number
        if shape.is_comment(line):
            if chosen is None and line.strip():
                comments.append((number, line))
            continue
        if chosen is None:
            split = split_row(shape, line)
            if len(headings) < shape.header if shape.header is not None else not has_number(split(line)):
                headings.append((number, line))
                continue
            chosen = _chosen(shape, headings, comments, split(line), split, number)
            columns = chosen.columns
        cells = split(line)
        point = _plain_point(cells, columns, number, line)
        if point is None:
            given = {"row": float(found + 1)}
            if not chosen.counts(cells, given, number):
                continue
            point = chosen.point(cells, given, number, line)
        yield point
        found += 1
        if found == shape.rows:
            return
    if shape.rows is not None or not found:
        expected = f"{shape.rows} rows" if shape.rows is not None else "a row of numbers"
        raise shape.wrong(last, f"the file ends after {found} rows; {expected} expected")


def _plain_point(cells: Sequence[str], columns: tuple[int, int] | None, number: int, line: str) -> Point | None:
    """Return the point of a row of plain numbers, which most are; None for others, where more is looked at."""
    if columns is None or "_" in line:
        return None
    try:
        x, y = float(cells[columns[0]]), float(cells[columns[1]])
    except (ValueError, IndexError):
        return None
    return Point(x, y, number, line) if math.isfinite(x) and math.isfinite(y) else None


def _chosen(
    shape: TableShape,
    headings: Sequence[tuple[int, str]],
    comments: Sequence[tuple[int, str]],
    cells: Sequence[str],
    split: Callable[[str], list[str]],
    line: int,
) -> Chosen:
    if headings:
        line, text = headings[0]
        header = split(text)
        if len(header) != len(cells) and shape.separator == "auto" and shape.fixed is None:
            header = _resplit(text, len(cells), shape.decimal) or header
        return Chosen(shape, header, ("row",), line)
    for number, text in reversed(comments) if shape.header is None else ():
        sign = next(sign for sign in shape.comment if text.strip().startswith(sign))
        header = split(text.strip().removeprefix(sign).strip())
        if len(header) == len(cells):
            try:
                return Chosen(shape, header, ("row",), number)
            except OutputError:
                continue  # a line of units, or a remark
    return Chosen(shape, (), ("row",), line)


def _resplit(text: str, count: int, decimal: str) -> list[str] | None:
    """Split headings that have another separator than the rows below."""
    cells = cell_splitter(guessed_separator(text, decimal), None)(text)
    return cells if len(cells) == count else None


Separator: TypeAlias = Literal["auto", ",", ";", "tab", "blanks"]
"""What stands between cells; ``auto`` decides by the first row of numbers."""


def guessed_separator(line: str, decimal: str) -> Separator:
    """Return the separator that a line seems to have: semicolon, tab, comma, else blanks."""
    if ";" in line:
        return ";"
    if "\t" in line.strip():
        return "tab"
    return "," if "," in line and decimal != "," else "blanks"


def cell_splitter(separator: Separator, fixed: Sequence[tuple[int, int]] | None) -> Callable[[str], list[str]]:
    """Return the function from a line to its cells, without blanks around them.

    Parameters
    ----------
    separator
        Not ``auto``.
    fixed
        First and last character of each column, from 1; None when cells are separated.
    """
    if fixed is not None:
        return lambda line: [line[first - 1 : last].strip() for first, last in fixed]
    if separator == "blanks":
        return lambda line: _quoted(line.strip(), " ") if '"' in line else line.split()
    sign = _SIGNS[separator]
    return lambda line: _quoted(line, sign) if '"' in line else [cell.strip() for cell in line.split(sign)]


def _quoted(line: str, sign: str) -> list[str]:
    try:
        (cells,) = csv.reader([line], delimiter=sign, skipinitialspace=True)
    except (csv.Error, ValueError):  # a cell larger than csv admits
        cells = line.split(sign)
    return [cell.strip() for cell in cells if cell.strip() or sign != " "]
