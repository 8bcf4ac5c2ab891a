"""Dates and times of day in the cells of a table, as programs and laboratories write them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, timedelta
from typing import Literal, TypeAlias

from geoswarm.solver.problem.tables.packed import Cell
from geoswarm.solver.problem.tables.reading import cell_number

__all__ = ["DATES_ACCEPTED", "DateForm", "day_of", "elapsed_days", "form_of", "is_moment", "moment_in", "time_of_day"]

DateForm: TypeAlias = Literal["day_first", "month_first", "serial"]
"""How dates are written that can be read in several ways: 03/04/2024, or a number of days as spreadsheets count."""

DATES_ACCEPTED = "2024-03-01 08:30 or 01.03.2024 08:30"

# 31.12.2024 and 31/12/2024, with 13:45 or 13:45:10 behind it. A large file has millions of cells that may be
# dates: strptime takes ten times as long.
_NUMBERS = re.compile(
    r"(\d{1,2})([./-])(\d{1,2})\2(\d{4}|\d{2})(?:,?\s+(\d{1,2}):(\d{1,2})(?::(\d{1,2})(?:[.,]\d{1,6})?)?\s?([AaPp][Mm])?)?",
    re.ASCII,
)
_CLOCK = re.compile(r"(\d{1,2}):(\d{1,2})(?::(\d{1,2})(?:[.,]\d{1,6})?)?\s?([AaPp][Mm])?", re.ASCII)
_ELAPSED = re.compile(r"(\d{1,5}):([0-5]?\d):([0-5]?\d(?:[.,]\d{1,6})?)", re.ASCII)
_ZERO = datetime(1899, 12, 30)
_LARGEST_SERIAL = 2_958_465.0  # the last day of the year 9999
_CENTURY = 70  # 69 is 2069, 70 is 1970


def moment_in(cell: Cell, form: DateForm | None = None) -> datetime | None:
    """Return date and time of a cell; None for what is none.

    Without a ``form``: ISO 8601, with an offset in UTC, or as written in much of Europe (31.12.2024 13:45, 31.12.24).
    ``day_first`` and ``month_first`` read 31/12/2024 and 12/31/2024, with / - or points, besides ISO 8601; ``serial``
    reads days since 1899-12-30, as spreadsheets store dates.
    """
    if form == "serial":
        number = cell if isinstance(cell, float) else cell_number(cell)
        if number is not None:
            if not 1.0 <= number <= _LARGEST_SERIAL:
                return None
            return _ZERO + timedelta(milliseconds=round(number * 86_400_000))
    if isinstance(cell, float) or not 6 <= len(cell) <= 40:
        return None
    try:
        moment = datetime.fromisoformat(cell) if len(cell) >= 8 else None
    except ValueError:
        moment = None
    if moment is not None:
        return moment if moment.tzinfo is None else moment.astimezone(UTC).replace(tzinfo=None)
    found = _NUMBERS.fullmatch(cell)
    if found is None:
        return None
    if form is None and found[2] != ".":
        return None  # who writes 03/04/2024 may mean either
    month_first = form == "month_first" and found[2] != "."
    month, day = (found[1], found[3]) if month_first else (found[3], found[1])
    year = int(found[4])
    if len(found[4]) == 2:
        year += 2000 if year < _CENTURY else 1900
    clock = _clock(found[5] or "0", found[6] or "0", found[7] or "0", found[8])
    try:
        return None if clock is None else datetime(year, int(month), int(day)) + clock
    except ValueError:
        return None


def is_moment(cell: Cell) -> bool:
    """Whether a cell is a date, with day or month first."""
    return moment_in(cell, "day_first") is not None or moment_in(cell, "month_first") is not None


def form_of(cells: Iterable[Cell]) -> DateForm | None:
    """Return which of day and month is first in dates such as 31/12/2024, where a day above 12 shows it."""
    found = [one for cell in cells if isinstance(cell, str) and (one := _NUMBERS.fullmatch(cell)) and one[2] != "."]
    day_first, month_first = any(int(one[1]) > 12 for one in found), any(int(one[3]) > 12 for one in found)
    if day_first == month_first:
        return None
    return "day_first" if day_first else "month_first"


def time_of_day(cell: Cell) -> timedelta | None:
    """Return the time since midnight of a cell: 8:30, 08:30:15, 8:30 PM, a date with a time, or a part of a day."""
    if isinstance(cell, float):
        return timedelta(seconds=round(cell * 86400.0, 3)) if 0.0 <= cell < 1.0 else None
    found = _CLOCK.fullmatch(cell)
    if found is not None:
        return _clock(found[1], found[2], found[3] or "0", found[4])
    moment = moment_in(cell, "day_first") or moment_in(cell, "month_first")
    return None if moment is None else moment - day_of(moment)


def elapsed_days(cells: Sequence[Cell]) -> list[Cell] | None:
    """Return times such as 25:30:00 in days, where they cannot be times of day: they begin at 0, or pass 24 hours.

    None for anything else; empty cells stay empty.
    """
    found = [_ELAPSED.fullmatch(cell) if isinstance(cell, str) else None for cell in cells]
    if not any(found) or any(one is None and cell != "" for one, cell in zip(found, cells, strict=True)):
        return None
    days: list[Cell] = [
        "" if one is None else (int(one[1]) * 3600 + int(one[2]) * 60 + float(one[3].replace(",", "."))) / 86400.0
        for one in found
    ]
    numbers = [day for day in days if isinstance(day, float)]
    return days if numbers[0] == 0.0 or max(numbers) >= 1.0 else None


def day_of(moment: datetime) -> datetime:
    """Midnight of the day."""
    return moment.replace(hour=0, minute=0, second=0, microsecond=0)


def _clock(hour: str, minute: str, second: str, half: str | None) -> timedelta | None:
    hours, minutes, seconds = int(hour), int(minute), int(second)
    if half is not None:
        if not 1 <= hours <= 12:
            return None
        hours = hours % 12 + (12 if half.lower() == "pm" else 0)
    if hours > 23 or minutes > 59 or seconds > 59:
        return None
    return timedelta(hours=hours, minutes=minutes, seconds=seconds)
