"""Limits the time for reading the output of a run: a regular expression can take forever on a single line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.system.activity import doing
from geoswarm.solver.system.time_limit import OutOfTimeError, time_limit

__all__ = ["LONGEST_READING", "reading"]

LONGEST_READING = 600.0
"""Where a call has no limit of its own [s]."""


@contextmanager
def reading(what: str, seconds: float | None) -> Iterator[None]:
    """Read something in the body.

    Parameters
    ----------
    what
        For messages.
    seconds
        Limit of the call [s], which holds once more for each thing that is read; None: 600.

    Raises
    ------
    RunFailedError
        ``timeout``: it took longer. In threads beside the main one, and on Windows, nothing is limited.
    """
    most = LONGEST_READING if seconds is None else seconds
    try:
        with doing(f"reading {what}"), time_limit(most):
            yield
    except OutOfTimeError:
        limit = "" if seconds is None else " (seconds)"
        raise RunFailedError("timeout", f"reading {what} took longer than {most:g} s{limit}; {_HINT}") from None


_HINT = "a regular expression in it may try too many ways, such as (a+)+b"
