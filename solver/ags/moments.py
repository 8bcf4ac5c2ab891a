"""Dates and times in the form that the unit of a column states: ``yyyy-mm-ddThh:mm:ss``."""

from __future__ import annotations

import re
from datetime import datetime

__all__ = ["moment_of"]

_TOKEN = re.compile(r"y+|m+|d+|h+|s+|[^A-Za-z]+|[A-Za-z]", re.IGNORECASE)
_NAMES = {"yyyy": "%Y", "yy": "%y", "dd": "%d", "hh": "%H", "ss": "%S", "s": "%f", "sss": "%f"}


def moment_of(text: str, form: str) -> datetime | None:
    """Return a date, or date and time, without its time zone; None where the text is none.

    ``form`` is that of the column. What it says behind the text's end may be missing, so that a column of times holds
    dates, too; ISO 8601 is accepted in any column.

    >>> moment_of("2003-02-20T13:40", "yyyy-mm-ddThh:mm:ss")
    datetime.datetime(2003, 2, 20, 13, 40)
    >>> moment_of("20/02/2003 13:40", "dd/mm/yyyy hh:mm")
    datetime.datetime(2003, 2, 20, 13, 40)
    >>> moment_of("dry", "yyyy-mm-dd") is None
    True
    """
    try:
        return datetime.fromisoformat(text).replace(tzinfo=None)
    except ValueError:
        pass
    pieces = _pieces(re.sub(r"\(?[Zz]?\(?\+hh:mm\)?$", "", form.strip()))
    for count in range(len(pieces), 0, -1):
        try:
            return datetime.strptime(text, "".join(pieces[:count]))
        except ValueError:
            continue
    return None


def _pieces(form: str) -> list[str]:
    """Directives of ``strptime``: ``mm`` is a minute behind ``hh``, else a month."""
    found: list[str] = []
    hour = False
    for token in _TOKEN.findall(form):
        word = token.lower()
        if word == "mm":
            found.append("%M" if hour else "%m")
        else:
            found.append(_NAMES.get(word, token.replace("%", "%%")))
        hour = hour or word == "hh"
    return found
