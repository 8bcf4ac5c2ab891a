"""Until when an agent runs: a time of this machine's clock, or a span from now."""

from __future__ import annotations

import re
from datetime import datetime, timedelta

__all__ = ["ACCEPTED", "seconds_until"]

ACCEPTED = "accepted: +SPAN (+90m, +3600), seconds since 1970, HH:MM, or 2026-05-01T18:00 (this machine's time)"

_UNITS = {"": 1.0, "s": 1.0, "m": 60.0, "h": 3600.0, "d": 86_400.0}
_SPAN = re.compile(r"\+(\d{1,9}(?:\.\d{1,9})?)([smhd]?)")
_EPOCH = re.compile(r"\d{9,11}(?:\.\d{1,9})?")
_CLOCK = re.compile(r"([01]?\d|2[0-3]):([0-5]\d)(?::([0-5]\d))?")


def seconds_until(text: str, now: datetime) -> float:
    """Return how long it is until then [s].

    >>> seconds_until("+1.5h", datetime(2026, 5, 1, 12, 0))
    5400.0
    >>> seconds_until("06:00", datetime(2026, 5, 1, 12, 0))
    64800.0

    Parameters
    ----------
    now
        By this machine's clock; with a zone where the text has one.

    Raises
    ------
    ValueError
        It cannot be read, or is over; the message says what is accepted.
    """
    given = text.strip()
    if (span := _SPAN.fullmatch(given)) is not None:
        return float(span[1]) * _UNITS[span[2]]
    if _EPOCH.fullmatch(given):
        seconds = float(given) - now.timestamp()
    elif (clock := _CLOCK.fullmatch(given)) is not None:
        then = now.replace(hour=int(clock[1]), minute=int(clock[2]), second=int(clock[3] or 0), microsecond=0)
        seconds = (then - now if then > now else then + timedelta(days=1) - now).total_seconds()
    else:
        try:
            moment = datetime.fromisoformat(given)
        except ValueError:
            raise ValueError(f"{text!r} is not a time; {ACCEPTED}") from None
        seconds = moment.timestamp() - now.timestamp()
    if seconds <= 0.0:
        raise ValueError(f"{text!r} is over by this machine's clock; {ACCEPTED}")
    return seconds
