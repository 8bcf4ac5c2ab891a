"""Dates and times of day in the cells of a table, as programs and laboratories write them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, timedelta
from typing import Literal, TypeAlias

from geoswarm.solver.problem.tables.packed import Cell
from geoswarm.solver.problem.tables.reading import cell_number

__all__ = [
    "DATES_ACCEPTED",
    "ELAPSED",
    "DateForm",
    "day_of",
    "doubtful_date",
    "elapsed_days",
    "elapsed_form",
    "form_of",
    "is_moment",
    "moment_in",
    "time_of_day",
]

DateForm: TypeAlias = Literal["day_first", "month_first", "year_first", "serial", "hh:mm:ss", "hh:mm", "mm:ss"]
"""How dates are written that can be read in several ways: 03/04/2024, a number of days as spreadsheets count, or 0:15
since the start.
"""

ELAPSED = ("hh:mm:ss", "hh:mm", "mm:ss")
"""The forms of a time since the start, not of a date."""

DATES_ACCEPTED = "2024-03-01 08:30 or 01.03.2024 08:30"

# 31.12.2024 and 31/12/2024, with 13:45 or 13:45:10 behind it. A large file has millions of cells that may be
# dates: strptime takes ten times as long.
_BEHIND = r"(?:,?\s+(?:[-–]\s+)?(\d{1,2}):(\d{1,2})(?::(\d{1,2})(?:[.,]\d{1,6})?)?\s?([AaPp][Mm]|Uhr|h)?)?"
_NUMBERS = re.compile(rf"(\d{{1,2}})([./-])\s?(\d{{1,2}})\2\s?(\d{{4}}|\d{{2}}){_BEHIND}", re.ASCII)
_YEAR_FIRST = re.compile(rf"(\d{{4}})([/.-])(\d{{1,2}})\2(\d{{1,2}}){_BEHIND}", re.ASCII)
_NAMED = re.compile(
    r"(?:(\d{1,2})(?:\.|[snrt][tdh])?[\s/-]*([A-Za-zÄä]{3,9})[.,]?[\s/-]*"
    r"|([A-Za-zÄä]{3,9})\.?[\s/-]*(\d{1,2})(?:[snrt][tdh])?[.,\s/-]+)"
    rf"(\d{{4}}|\d{{2}}){_BEHIND}"
)
_WEEKDAY = re.compile(
    r"^(?:mo|di|mi|do|fr|sa|so|mon|tue|wed|thu|fri|sat|sun|\w{3,7}tag|mittwoch|\w{3,6}day)[.,]*\s+", re.IGNORECASE
)
_MONTHS = ("jan", "feb", "mar", "apr", "mai", "jun", "jul", "aug", "sep", "okt", "nov", "dez")
_ALIKE = {"mär": "mar", "mrz": "mar", "mae": "mar", "may": "mai", "oct": "okt", "dec": "dez", "jän": "jan"}
_MONTH = re.compile(
    "jan(uar|uary)?|jänner|feb(ruar|ruary)?|mar(ch)?|mrz|m(ä|ae)r(z)?|apr(il)?|may|mai|jun[ei]?|jul[yi]?"
    "|aug(ust)?|sept?|september|o[kc]t(ober)?|nov(ember)?|de[zc](ember)?",
    re.IGNORECASE,
)
_CLOCK = re.compile(r"(\d{1,2}):(\d{1,2})(?::(\d{1,2})(?:[.,]\d{1,6})?)?\s?([AaPp][Mm]|Uhr|h)?", re.ASCII)
_ELAPSED = re.compile(r"\d{1,6}(?::[0-5]?\d){1,3}(?:[.,]\d{1,6})?", re.ASCII)
_STEP = "(?:tage?|d{1,3}|std|hrs?|h{1,3}|min|m{1,2}|sec|sek|s{1,3})"
_FORM = re.compile(rf"(?<![\w:]){_STEP}(?:\s?:\s?{_STEP})+(?:[.,][0s]+)?(?![\w:])", re.IGNORECASE)
_SECONDS = {"d": 86400, "h": 3600, "m": 60, "s": 1}
_SINCE = re.compile(r"elapsed|dauer|duration|since|seit|versuchszeit|laufzeit|test time", re.IGNORECASE)
_ZERO = datetime(1899, 12, 30)
_LARGEST_SERIAL = 2_958_465.0  # the last day of the year 9999
_ORDERS: tuple[DateForm, ...] = ("day_first", "month_first", "year_first")
_LONGEST_MONTH = 31
_CENTURY = 70  # 69 is 2069, 70 is 1970


def moment_in(cell: Cell, form: DateForm | None = None) -> datetime | None:
    """Return date and time of a cell; None for what is none.

    Without a ``form``: ISO 8601, with an offset in UTC, or as written in much of Europe (31.12.2024 13:45, 31.12.24).
    ``day_first``, ``month_first`` and ``year_first`` read 31/12/2024, 12/31/2024 and 24/12/31, with / - or points,
    besides ISO 8601; ``serial`` reads days since 1899-12-30, as spreadsheets store dates.
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
        return _spelled_out(cell)
    if form is None and found[2] != ".":
        return None  # 03/04/2024 may mean either
    if form == "year_first":
        return _moment(found[1], int(found[3]), found[4], found.groups()[4:]) if len(found[4]) == 2 else None
    month_first = form == "month_first"
    month, day = (found[1], found[3]) if month_first else (found[3], found[1])
    return _moment(found[4], int(month), day, found.groups()[4:])


def _spelled_out(cell: str) -> datetime | None:
    """A date with the year first, ``2024/03/01`` or ``2024-3-1``, or with the name of its month, German or English."""
    if (plain := _WEEKDAY.sub("", cell, count=1)) != cell:
        return moment_in(plain)
    found = _YEAR_FIRST.fullmatch(cell)
    if found is not None:
        return _moment(found[1], int(found[3]), found[4], found.groups()[4:])
    found = _NAMED.fullmatch(cell)
    name = "" if found is None else (found[2] or found[3]).casefold()
    if found is None or _MONTH.fullmatch(name) is None:
        return None
    return _moment(
        found[5], _MONTHS.index(_ALIKE.get(name[:3], name[:3])) + 1, found[1] or found[4], found.groups()[5:]
    )


def _moment(year: str, month: int, day: str, time: Sequence[str | None]) -> datetime | None:
    whole = int(year)
    if len(year) == 2:
        whole += 2000 if whole < _CENTURY else 1900
    hour, minute, second, half = time
    clock = _clock(hour or "0", minute or "0", second or "0", half)
    try:
        return None if clock is None else datetime(whole, month, int(day)) + clock
    except ValueError:
        return None


def is_moment(cell: Cell) -> bool:
    """Whether a cell is a date, with day, month or year first."""
    return any(moment_in(cell, form) is not None for form in _ORDERS)


def form_of(cells: Iterable[Cell]) -> DateForm | None:
    """Return which of day, month and year is first in dates such as 31/12/2024, where a day above 12 shows it.

    It does not where the last number takes more values than the first: 24-11-10, 24-11-11 may begin with the year.
    """
    found = [one for cell in cells if isinstance(cell, str) and (one := _NUMBERS.fullmatch(cell)) and one[2] != "."]
    if any(int(one[1]) > _LONGEST_MONTH and len(one[4]) == 2 for one in found):
        return "year_first"
    day_first, month_first = any(int(one[1]) > 12 for one in found), any(int(one[3]) > 12 for one in found)
    years_last = len({one[1] for one in found}) >= len({one[4] for one in found})
    if day_first == month_first or (day_first and not years_last):
        return None
    return "day_first" if day_first else "month_first"


def doubtful_date(cells: Iterable[Cell]) -> str | None:
    """First of the dates with points that may begin with the year: 24.11.10, 24.11.11; None where the day is first."""
    found = [one for cell in cells if isinstance(cell, str) and (one := _NUMBERS.fullmatch(cell)) and one[2] == "."]
    years_last = len({one[1] for one in found}) >= len({one[4] for one in found})
    return None if years_last or any(len(one[4]) == 4 for one in found) else found[0][0]


def time_of_day(cell: Cell) -> timedelta | None:
    """Return the time since midnight of a cell: 8:30, 08:30:15, 8:30 PM, a date with a time, or a part of a day."""
    if isinstance(cell, float):
        return timedelta(seconds=round(cell * 86400.0, 3)) if 0.0 <= cell < 1.0 else None
    found = _CLOCK.fullmatch(cell)
    if found is not None:
        return _clock(found[1], found[2], found[3] or "0", found[4])
    moment = moment_in(cell, "day_first") or moment_in(cell, "month_first")
    return None if moment is None else moment - day_of(moment)


def elapsed_form(heading: str) -> str | None:
    """How a heading says that times are written, ``Zeit [mm:ss]``: the letters of the steps; None where it does not.

    >>> elapsed_form("Zeit [mm:ss]"), elapsed_form("Dauer (Std:Min:Sek)"), elapsed_form("Zeit [min]")
    ('ms', 'hms', None)
    """
    found = _FORM.search(heading)
    steps = "" if found is None else "".join("h" if one[:2] == "st" else one[0] for one in _steps(found[0]))
    steps = steps.replace("t", "d")
    return steps if steps and steps in "dhms" else None


def _steps(form: str) -> list[str]:
    return [one.strip().casefold() for one in form.split(":")]


def elapsed_days(cells: Sequence[Cell], heading: str = "", form: str | None = None) -> list[Cell] | None:
    """Return times such as 25:30:00 in days, where they cannot be times of day: they begin at 0, or pass 24 hours.

    None for anything else; empty cells stay empty.

    Parameters
    ----------
    heading
        Which may say how they are written (``[mm:ss]``), and that they count from the start.
    form
        One of :data:`ELAPSED`, where the user says so.
    """
    filled = [cell for cell in cells if cell != ""]
    if not filled or any(isinstance(cell, float) or _ELAPSED.fullmatch(cell) is None for cell in filled):
        return None
    said = elapsed_form(form or heading)
    parts = [[float(one) for one in str(cell).replace(",", ".").split(":")] for cell in filled]
    count = len(parts[0])
    steps = said or {3: "hms", 4: "dhms"}.get(count, "")
    if any(len(one) != len(steps) for one in parts):
        return None
    days = [sum(value * _SECONDS[step] for value, step in zip(one, steps, strict=True)) / 86400.0 for one in parts]
    certain = form is not None or (said is not None and not said.startswith("h")) or _SINCE.search(heading) is not None
    latest = 1.0 / 1440 if said is not None else 0.0  # of a first reading; a clock may say 08:30
    if not certain and days[0] > latest and max(days) < 1.0:
        return None
    left = iter(days)
    return ["" if cell == "" else next(left) for cell in cells]


def day_of(moment: datetime) -> datetime:
    """Midnight of the day."""
    return moment.replace(hour=0, minute=0, second=0, microsecond=0)


def _clock(hour: str, minute: str, second: str, half: str | None) -> timedelta | None:
    hours, minutes, seconds = int(hour), int(minute), int(second)
    if half is not None and half[0] in "AaPp":
        if not 1 <= hours <= 12:
            return None
        hours = hours % 12 + (12 if half.lower() == "pm" else 0)
    if hours > 23 or minutes > 59 or seconds > 59:
        return None
    return timedelta(hours=hours, minutes=minutes, seconds=seconds)
