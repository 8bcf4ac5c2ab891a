"""Measured points from the columns of a file: by heading or by cells, with the units of headings and dates as days."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from operator import itemgetter
from typing import Literal, TypeVar

from geoswarm.solver.problem.tables.blocks import has_unit
from geoswarm.solver.problem.tables.cells import Sheet, number_in, plain_numbers, read_cells, without_units
from geoswarm.solver.problem.tables.dates import (
    DATES_ACCEPTED,
    ELAPSED,
    DateForm,
    day_of,
    doubtful_date,
    elapsed_days,
    form_of,
    is_moment,
    moment_in,
    time_of_day,
)
from geoswarm.solver.problem.tables.headings import Heading, heading_of, units_in_comments
from geoswarm.solver.problem.tables.numerals import (
    DecimalSign,
    is_mark,
    no_reading_doubt,
    number_of,
    refuse_thousands,
    sentinels_in,
)
from geoswarm.solver.problem.tables.packed import FORMULA, Cell
from geoswarm.solver.problem.tables.picking import (
    Picked,
    all_picked,
    area_of,
    column_of,
    is_cells,
    is_range,
    refuse_other_unit,
    refuse_parts_of_time,
    rows_where,
    sheet_of_names,
    text_of,
)
from geoswarm.solver.problem.tables.reading import DoubtError, TableError
from geoswarm.solver.problem.tables.remarks import factors_beside, refuse_changes, refuse_headings, with_factors
from geoswarm.solver.sentences import Sentence, setting

__all__ = ["Columns", "Table", "table_of"]

T = TypeVar("T")

_MOST_MESSAGES = 10
_FIRST = 3


@dataclass(frozen=True, slots=True)
class Columns:
    """Which columns of a file are wanted; None for x, y and, if there is one, weight.

    Parameters
    ----------
    sheet
        Of a workbook; the only one with these columns, else the first one with cells, if None.
    origin
        Date and time at which x is 0, where x holds dates; the first one if None.
    inputs
        Further columns by the name they are given.
    y_minus
        Column that is subtracted from that of y.
    where, turn
        Entries by heading: only rows that have them count; of several runs of such rows only one, see ``rows_where``.
    dates
        How the dates of x are written where it can be read in several ways.
    time
        Column of the times of day beside the dates of x.
    gross_errors
        Column whose entries mark gross errors.
    decimal
        The sign before decimals, where it is not plain; the other one may then stand between thousands.
    incomplete
        What becomes of rows that lack one of the numbers: refused, or ``leave_out``.
    no_reading
        Numbers that stand for no reading; None: nobody said so, and what looks like one is asked for.
    gross
        Numbers of the readings, from 1, that are gross errors.
    units
        Of x and y, as far as they are given: notes between the rows may name others.
    """

    x: str | None = None
    y: str | None = None
    weight: str | None = None
    sheet: str | None = None
    origin: datetime | None = None
    inputs: Mapping[str, str] = field(default_factory=dict)
    y_minus: str | None = None
    where: Mapping[str, str | float] = field(default_factory=dict)
    dates: DateForm | None = None
    time: str | None = None
    gross_errors: str | None = None
    decimal: DecimalSign | None = None
    incomplete: Literal["leave_out"] | None = None
    turn: tuple[int, int] | None = None
    no_reading: tuple[float, ...] | None = None
    gross: tuple[int, ...] = ()
    units: tuple[str | None, str | None] = (None, None)

    def wanted(self) -> dict[str, str]:
        """Columns by what they are for."""
        given = {
            "x": self.x or "x",
            "y": self.y or "y",
            "weight": self.weight,
            "y_minus": self.y_minus,
            "x_time": self.time,
            "gross_error": self.gross_errors,
        }
        further = {f"inputs.{name}": column for name, column in self.inputs.items()}
        return {role: name for role, name in given.items() if name is not None} | further


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of a table, all of the same length; ``weight`` None when there is no such column.

    ``gross_errors`` are the places of marked rows; ``zero`` is the moment of x = 0, where x holds dates. ``left_out``
    counts rows that lacked a number and are not here. ``by_load``: x are the stages whose loads the column holds.
    """

    x: list[float]
    y: list[float]
    weight: list[float] | None
    x_heading: Heading = field(default_factory=lambda: Heading("x"))
    y_heading: Heading = field(default_factory=lambda: Heading("y"))
    inputs: dict[str, list[float]] = field(default_factory=dict)
    input_headings: dict[str, Heading] = field(default_factory=dict)
    gross_errors: list[int] = field(default_factory=list)
    zero: datetime | None = None
    left_out: int = 0
    by_load: bool = False


def table_of(content: bytes, name: str, columns: Columns = Columns(), read: Callable[..., Sheet] = read_cells) -> Table:
    """Read the columns x, y and weight of a CSV file or a workbook.

    Parameters
    ----------
    content
        The file. A heading may be named with or without its unit, upper and lower case alike. Rows without any of the
        cells that are wanted are left out.
    name
        Its name, for messages.
    read
        Reads the cells; callers that read several parts of a file may keep them.

    Raises
    ------
    TableError
        Missing or unreadable file, missing column, or cells that are no finite numbers.
    """
    quick = None if _needs_cells(columns) else plain_numbers(content)
    wanted = columns.wanted()
    names = tuple(text for text in (*wanted.values(), *columns.where) if not is_cells(text))
    areas = tuple(area for text in wanted.values() if (area := area_of(text)) is not None)
    sheet = read(content, name, columns.sheet, wanted=names, areas=areas) if quick is None else quick[0]
    if content.startswith(b"PK"):
        of = sheet_of_names(content, name, columns.sheet, sheet, wanted)
        sheet = sheet if of == sheet.sheet else read(content, name, of)
    if not sheet.header and not sheet.rows:
        raise TableError(f"{name} is empty; a header line x,y is expected")
    if "weight" not in wanted and column_of(sheet, "weight") and not is_range(wanted["x"]):
        wanted["weight"] = "weight"
    if not sheet.rows and not is_range(wanted["x"]):
        all_picked(sheet, [], wanted, name)
        raise TableError(f"{name} has a header but no points")
    rows = rows_where(sheet, columns.where, name, columns.turn)
    reader = _Reader(name, sheet, columns, all_picked(sheet, rows, wanted, name))
    body = [row for _, row in rows] if quick is None else quick[1]
    refuse_parts_of_time(sheet.header, reader.columns["x"], body, name)
    if quick is None:
        found = reader.table()
    elif columns.origin is not None:
        raise _no_dates(name, reader.columns["x"])
    else:
        values = {role: quick[1][:, one.place].tolist() for role, one in reader.columns.items()}
        reader.ask_for_sentinels(values, [i for i in range(len(body)) if i + 1 not in columns.gross])
        found = Table(values["x"], values["y"], values.get("weight"), inputs=_of_inputs(values))
    comments, factors = units_in_comments(sheet.comments), factors_beside(sheet, reader.used(), body)
    headings = {
        role: with_factors(
            heading_of(
                column.name,
                comments,
                text=text_of(column, sheet.header, rows, name),
                dates=role == "x" and found.zero is not None,
                in_cells=reader.units.get(role),
            ),
            factors,
        )
        for role, column in reader.columns.items()
        if role in ("x", "y", "y_minus") or role.startswith("inputs.")
    }
    if "y_minus" in headings:
        refuse_other_unit(name, headings["y"], headings["y_minus"])
    refuse_changes(name, sheet, reader.columns, reader.used(), [headings["x"], headings["y"]], columns.units)
    return replace(
        found,
        x_heading=replace(headings["x"], first=tuple(found.x[:_FIRST])),
        y_heading=replace(headings["y"], first=tuple(found.y[:_FIRST])),
        input_headings=_of_inputs(headings),
    )


def _needs_cells(columns: Columns) -> bool:
    """Whether more than numbers of columns is asked for."""
    texts = columns.wanted()
    return bool(
        columns.where
        or columns.dates
        or columns.sheet
        or columns.decimal
        or columns.no_reading
        or texts.keys() & {"y_minus", "x_time", "gross_error"}
    ) or any(is_range(text) for text in texts.values())


def _of_inputs(by_role: Mapping[str, T]) -> dict[str, T]:
    return {role.removeprefix("inputs."): given for role, given in by_role.items() if role.startswith("inputs.")}


def _mostly(column: Picked, holds: Callable[[Cell], bool]) -> bool:
    """Whether something holds for more than half of the first filled cells of a column."""
    sample = [cell for _, cell in column.cells if cell != ""][:20]
    return sum(map(holds, sample)) * 2 > len(sample)


def _is_clock(cell: Cell) -> bool:  # a number may be anything
    return isinstance(cell, str) and time_of_day(cell) is not None


def _no_dates(name: str, x: Picked) -> TableError:
    told = f" is a date, but column {x.name} holds no dates; "
    return TableError((f"{name}: ", setting("x_origin"), told, setting("x_dates", "serial"), " reads numbers"))


class _Reader:
    """Makes numbers of the cells of the columns that are wanted; ``columns`` by role, all of one length."""

    def __init__(self, name: str, sheet: Sheet, wanted: Columns, columns: dict[str, Picked]) -> None:
        self._name = name
        self._sheet = sheet
        self._wanted = wanted
        self._messages: list[tuple[int, Sentence]] = []
        self._incomplete: set[int] = set()
        self.units: dict[str, str] = {}
        first = columns["x"]
        for one in columns.values():
            if len(one.cells) != len(first.cells):
                raise TableError(
                    f"{name}: {one.name} has {len(one.cells)} cells, {first.name} has {len(first.cells)}; "
                    "where one column is a range such as B5:B30, all are, of one length"
                )
        marks = columns.get("gross_error")
        needed = [one.cells for one in columns.values() if one is not marks]
        filled = [i for i in range(len(first.cells)) if any(cells[i][1] != "" for cells in needed)]
        self.columns = columns
        if len(filled) < len(first.cells):
            self.columns = {role: replace(one, cells=[one.cells[i] for i in filled]) for role, one in columns.items()}

    def table(self) -> Table:
        """All columns as numbers."""
        x, wanted = self.columns["x"], self._wanted
        if not x.cells:
            raise TableError(f"{self._name}: the cells of {x.name} are all empty")
        moments, elapsed = None, None
        said = wanted.dates if wanted.dates in ELAPSED else None
        if wanted.dates in (None, said) and wanted.time is None:
            elapsed = elapsed_days([cell for _, cell in x.cells], x.heading or x.name, said)
        if elapsed is not None:
            self.units["x"] = "day"
            self.columns["x"] = x = replace(
                x, cells=[(line, value) for (line, _), value in zip(x.cells, elapsed, strict=True)]
            )
        elif said is not None:
            cell = next((cell for _, cell in x.cells if cell != "" and elapsed_days([cell], form=said) is None), "")
            told = f"{self._name}, column {x.name}: '{cell}' is not written as {said}, as "
            raise TableError((told, setting("x_dates"), " says"))
        elif wanted.dates is not None or wanted.time is not None or _mostly(x, is_moment):
            moments = self._moments(x)
        elif _mostly(x, _is_clock):
            clock = next(cell for _, cell in x.cells if _is_clock(cell))
            told = f"{self._name}, column {x.name}: '{clock}' is a time of day; "
            columns = setting("x_column"), " is the column of the dates, ", setting("x_time_column"), " this one"
            elapsed_time = setting("x_dates", _SINCE_START[str(clock).count(":")])
            raise TableError((told, *columns, "; if it is the time since the start, give ", elapsed_time))
        elif wanted.origin is not None:
            raise _no_dates(self._name, x)
        values = {
            role: self._numbers(role, one)
            for role, one in self.columns.items()
            if role not in ("gross_error", "x_time") and not (role == "x" and moments is not None)
        }
        refuse_headings(self._name, list(self.columns.values()), self._incomplete)
        self._raise_errors()
        kept = [i for i in range(len(x.cells)) if i not in self._incomplete]
        if not kept:
            raise TableError(f"{self._name}: no row has a number in every column that is wanted")
        marks = self.columns.get("gross_error")
        marked = [] if marks is None else [place for place, i in enumerate(kept) if is_mark(marks.cells[i][1])]
        counted = [i for place, i in enumerate(kept) if place not in marked and place + 1 not in wanted.gross]
        self.ask_for_sentinels(values, counted)
        values = {role: [numbers[i] for i in kept] for role, numbers in values.items()}
        zero = None
        if moments is not None:
            zero = wanted.origin or min(moments[i] for i in kept)
            values["x"] = [(moments[i] - zero).total_seconds() / 86400 for i in kept]
        y = values["y"]
        if "y_minus" in values:
            y = [one - other for one, other in zip(y, values["y_minus"], strict=True)]
        return Table(
            values["x"],
            y,
            values.get("weight"),
            inputs=_of_inputs(values),
            gross_errors=marked,
            zero=zero,
            left_out=len(self._incomplete),
        )

    def used(self) -> set[int]:  # lines
        return {line for i, (line, _) in enumerate(self.columns["x"].cells) if i not in self._incomplete}

    def _moments(self, x: Picked) -> list[datetime]:
        """Date and time of each row."""
        clock, form = self.columns.get("x_time"), self._wanted.dates or form_of(cell for _, cell in x.cells)
        expected = DATES_ACCEPTED if form in (None, "serial") else f"{_AS_WRITTEN[form]} or {DATES_ACCEPTED}"
        doubtful, moments = None if form is not None else doubtful_date(cell for _, cell in x.cells), []
        for i, (_, cell) in enumerate(x.cells):
            moment = None if cell == doubtful else moment_in(cell, form)
            if moment is None and form is None and is_moment(cell):
                other, assumed = ("year", "year_first") if cell == doubtful else ("month", "day_first")
                told = f"{self._name}, column {x.name}: '{cell}' is a date whose day or {other} may be first; give "
                raise DoubtError({"dates": assumed}, (told, _FIRST_OF_DATES))
            if moment is None:
                self._bad(i, x, f"not a date, such as {expected}")
            elif clock is not None:
                since = time_of_day(clock.cells[i][1])
                if since is None:
                    self._bad(i, clock, "not a time of day, such as 08:30 or 08:30:15")
                else:
                    moment = day_of(moment) + since
            moments.append(moment or datetime.min)  # those without one are not used
        return moments

    def _numbers(self, role: str, column: Picked) -> list[float]:
        sign = self._wanted.decimal
        cells, unit = without_units([cell for _, cell in column.cells])
        if unit is not None:
            self.units[role] = unit
            column = replace(column, cells=[(line, cell) for (line, _), cell in zip(column.cells, cells, strict=True)])
        if sign is None:
            others = (cell for _, cells in self._sheet.rows for cell in cells)
            refuse_thousands(self._name, column.name, column.cells, others)
        values = []
        for i, (_, cell) in enumerate(column.cells):
            value = number_in(cell) if sign is None else number_of(cell, sign)
            if value is None:
                self._bad(i, column, "not a finite number")
            elif value in (self._wanted.no_reading or ()) and role != "weight":
                self._incomplete.add(i)
            values.append(0.0 if value is None else value)
        return values

    def ask_for_sentinels(self, values: Mapping[str, Sequence[float]], rows: Sequence[int]) -> None:
        """Ask whether numbers such as -999 are readings; ``rows`` are the places of those that count."""
        counted = {role: [own[row] for row in rows] for role, own in values.items() if role != "weight"}
        rises = counted.get("x", []) == sorted(counted.get("x", []))  # 1, 10, 99.9
        found = {role: sentinels_in(own) for role, own in counted.items() if role != "x" or not rises}
        role = next((role for role, sentinels in found.items() if sentinels), None)
        if role is None or self._wanted.no_reading is not None:
            return
        column = self.columns[role]
        line = next((line for line, cell in column.cells if number_in(cell) == found[role][0]), None)
        where = self._name if line is None else f"{self._name} line {line}"
        raise no_reading_doubt(f"{where}, column {column.name}", [one for own in found.values() for one in own])

    def _bad(self, row: int, column: Picked, what: str) -> None:
        line, cell = column.cells[row]
        formula = isinstance(cell, str) and cell.startswith(FORMULA)
        own_unit = has_unit(cell) and all(one.cells[row][1] != "" for one in self.columns.values())
        if self._wanted.incomplete is not None and not formula and not own_unit:
            self._incomplete.add(row)
            return
        problem = f"'{str(cell)[:50]}' is {what}" if cell != "" else "the cell is empty"
        if formula:
            problem = f"{str(cell)[:50]} has no stored value; let a spreadsheet program calculate and save the workbook"
        remedy: Sentence = ()
        if own_unit:
            problem += ": it has a unit of its own, unlike others; write it in the unit of the column, without the unit"
        if what == "not a finite number" and is_moment(cell):
            remedy = "; ", _FIRST_OF_DATES, " says how a date is written"
        elif not (formula or self._messages or any(map(str.isdigit, str(cell)))):
            remedy = "; ", setting("incomplete_rows", "leave_out"), " passes over such rows"
        self._messages.append((line, (f"{self._name} line {line}, column {column.name}: {problem}", *remedy)))

    def _raise_errors(self) -> None:
        if not self._messages:
            return
        shown = [sentence for _, sentence in sorted(self._messages, key=itemgetter(0))[:_MOST_MESSAGES]]
        more = len(self._messages) - len(shown)
        raise TableError(*shown, *([f"{self._name}: {more} more bad cells"] if more else []))


_FIRST_OF_DATES = setting("x_dates", "day_first, month_first or year_first")
_SINCE_START = {1: "hh:mm or mm:ss", 2: "hh:mm:ss"}
_AS_WRITTEN = {"day_first": "31/12/2024 08:30", "month_first": "12/31/2024 08:30", "year_first": "24/12/31 08:30"}
