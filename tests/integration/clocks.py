"""A wrong clock, for one process and what it starts: Debian's ``libfaketime`` lies to it about the time of day."""

from __future__ import annotations

from pathlib import Path

__all__ = ["an_hour_ahead"]

LIBRARY = "faketime/libfaketimeMT.so.1"


def an_hour_ahead() -> dict[str, str]:
    """Return the variables under which a process believes that it is an hour later; clocks that only run forward stay.

    Raises
    ------
    FileNotFoundError
        The library is not installed: the loader would only print a warning, and the clock would be right.
    """
    found = sorted(Path("/usr/lib").glob(f"*/{LIBRARY}"))
    if not found:
        raise FileNotFoundError(f"/usr/lib/*/{LIBRARY}: install Debian's package libfaketime")
    return {"LD_PRELOAD": str(found[0]), "FAKETIME": "+1h", "DONT_FAKE_MONOTONIC": "1"}
