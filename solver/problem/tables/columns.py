"""Measured points from the columns of a file: by heading, with the units that headings name and dates as days."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.problem.tables.cells import Sheet, file_content, moment_in, number_in, read_cells
from geoswarm.solver.problem.tables.headings import guess_unit, known_unit, units_in_comments
from geoswarm.solver.problem.tables.plain_tables import plain_numbers
from geoswarm.solver.problem.tables.reading import TableError
from geoswarm.solver.problem.tables.workbooks import Cell

__all__ = ["Columns", "Heading", "Table", "read_table"]

_MOST_MESSAGES = 10


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading and the unit that it, or a comment, names; ``certain`` when the unit stands in brackets.

    ``dates``: the column holds dates, which are read as days.
    """

    name: str
    unit: str | None = None
    certain: bool = False
    dates: bool = False


@dataclass(frozen=True, slots=True)
class Columns:
    """Which columns of a file are wanted; None for x, y and, if there is one, weight.

    Parameters
    ----------
    sheet
        Of a workbook; the first one with cells if None.
    origin
        Date and time at which x is 0, where x holds dates; the first one if None.
    inputs
        Further columns by the name they are given.
    """

    x: str | None = None
    y: str | None = None
    weight: str | None = None
    sheet: str | None = None
    origin: datetime | None = None
    inputs: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of a table, all of the same length; ``weight`` None when there is no such column."""

    x: list[float]
    y: list[float]
    weight: list[float] | None
    x_heading: Heading = Heading("x")
    y_heading: Heading = Heading("y")
    inputs: dict[str, list[float]] = field(default_factory=dict)


def read_table(path: Path, columns: Columns = Columns()) -> Table:
    """Read the columns x, y and weight of a CSV file or a workbook.

    Parameters
    ----------
    path
        The file. The first line of a CSV file that is neither empty nor a ``#`` comment has the headings; in a workbook
        it is the one above the first row of numbers. A heading may be named with or without its unit, upper and lower
        case alike.

    Raises
    ------
    TableError
        Missing or unreadable file, missing column, or cells that are no finite numbers.
    """
    content = file_content(path)
    numbers = plain_numbers(content)
    sheet = read_cells(content, path.name, columns.sheet) if numbers is None else numbers[0]
    if not sheet.header and not sheet.rows:
        raise TableError(f"{path.name} is empty; a header line x,y is expected")
    reader = _Reader(path.name, sheet, None if numbers is None else numbers[1])
    places = {
        role: reader.place(name or role, role)
        for role, name in (("x", columns.x), ("y", columns.y), ("weight", columns.weight))
        if role != "weight" or name is not None or reader.has("weight")
    }
    further = {name: reader.place(column, f"inputs.{name}") for name, column in columns.inputs.items()}
    if not sheet.rows:
        raise TableError(f"{path.name} has a header but no points")
    x, dates = reader.moments(places["x"], columns.origin)
    if not dates and columns.origin is not None:
        raise TableError(f"{path.name}: x_origin is a date, but column {reader.names[places['x']]} holds no dates")
    data = {role: reader.numbers(place) for role, place in places.items() if role != "x" or not dates}
    inputs = {name: reader.numbers(place) for name, place in further.items()}
    reader.raise_errors()
    return Table(
        x if dates else data["x"],
        data["y"],
        data.get("weight"),
        reader.heading(places["x"], dates),
        reader.heading(places["y"], False),
        inputs,
    )


class _Reader:
    def __init__(self, name: str, sheet: Sheet, numbers: FloatArray | None) -> None:
        self._name = name
        self._numbers = numbers
        self._sheet = sheet
        width = max((len(cells) for _, cells in sheet.rows[:1]), default=0)
        self.names = sheet.header or [f"column {place + 1}" for place in range(width)]
        self._labels = [guess_unit(name)[0] for name in self.names]
        self._messages: list[tuple[int, str]] = []

    def has(self, name: str) -> bool:
        return any(_key(name) in (_key(n), _key(label)) for n, label in zip(self.names, self._labels, strict=True))

    def place(self, wanted: str, role: str) -> int:
        """Index of the column with a heading, or with a heading that is this before its unit."""
        for headings in (self.names, self._labels):
            found = [index for index, name in enumerate(headings) if _key(name) == _key(wanted)]
            if len(found) == 1:
                return found[0]
            if found:
                break
        problem = "there are several columns" if found else "there is no column"
        remedy = f"; say which it is: {role}_column: {self._suggestion(role)}" if wanted == role and not found else ""
        header = f"the header has: {', '.join(self.names)}" if self._sheet.header else "there is no line of headings"
        raise TableError(f"{self._name} line {self._sheet.header_line}: {problem} '{wanted}'; {header}{remedy}")

    def _suggestion(self, role: str) -> str:
        names = [name for name in self.names if name] or ["HEADING"]
        return names[min(("x", "y").index(role), len(names) - 1)] if role in ("x", "y") else names[-1]

    def heading(self, place: int, dates: bool) -> Heading:
        name = self.names[place]
        if dates:
            return Heading(name, "day", certain=True, dates=True)
        unit = guess_unit(name)[1]
        if unit is not None:
            return Heading(name, unit, certain=name.rstrip().endswith(("]", ")", "}")))
        commented = units_in_comments(self._sheet.comments).get(name)
        return Heading(name, None if commented is None else known_unit(commented)[0])

    def moments(self, place: int, origin: datetime | None) -> tuple[list[float], bool]:
        """Days since the origin, if most cells are dates."""
        if self._numbers is not None:
            return [], False
        cells = [self._cell(row, place) for _, row in self._sheet.rows]
        sample = [cell for cell in cells if cell != ""][:20]
        if sum(moment_in(cell) is not None for cell in sample) * 2 <= len(sample):
            return [], False
        days = []
        for (line, _), cell in zip(self._sheet.rows, cells, strict=True):
            moment = moment_in(cell)
            if moment is None:
                self._bad(cell, place, line, "no date, such as 2024-03-01 08:30 or 01.03.2024 08:30")
                continue
            origin = origin or moment
            days.append((moment - origin).total_seconds() / 86400)
        return days, True

    def numbers(self, place: int) -> list[float]:
        if self._numbers is not None:
            column: list[float] = self._numbers[:, place].tolist()
            return column
        values = []
        for line, row in self._sheet.rows:
            cell = self._cell(row, place)
            value = number_in(cell)
            values.append(self._bad(cell, place, line, "no finite number") if value is None else value)
        return values

    @staticmethod
    def _cell(row: list[Cell], place: int) -> Cell:
        return row[place] if place < len(row) else ""

    def _bad(self, cell: Cell, place: int, line: int, what: str) -> float:
        problem = f"'{str(cell)[:50]}' is {what}" if cell != "" else "the cell is empty"
        self._messages.append((line, f"{self._name} line {line}, column {self.names[place]}: {problem}"))
        return 0.0

    def raise_errors(self) -> None:
        if not self._messages:
            return
        shown = [message for _, message in sorted(self._messages)[:_MOST_MESSAGES]]
        more = len(self._messages) - len(shown)
        raise TableError(*shown, *([f"{self._name}: {more} more bad cells"] if more else []))


def _key(cell: str) -> str:
    return " ".join(cell.split()).casefold()
