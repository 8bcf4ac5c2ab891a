"""Limits the time for reading the output of a run: a regular expression can take forever on a single line."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.system.activity import doing

__all__ = ["LONGEST_READING", "OutOfTimeError", "reading", "time_limit"]

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


class OutOfTimeError(BaseException):
    """The body took longer than its limit; no error that a body may take for its own."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """End the body with :class:`OutOfTimeError` after some wall time [s].

    By SIGALRM, which Python looks at between its instructions and within the matching of regular expressions. So it
    holds in the main thread of systems that have it; elsewhere the body is not limited. A timer that runs already goes
    on afterwards.
    """
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "setitimer"):
        yield
        return

    def ring(number: int, frame: FrameType | None) -> None:
        del number, frame
        if not over:
            raise OutOfTimeError

    over = False
    began = time.monotonic()
    handler = signal.signal(signal.SIGALRM, ring)
    before, interval = signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        try:
            yield
        finally:
            over = True  # a signal that comes now is late
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, handler)
        if before:
            signal.setitimer(signal.ITIMER_REAL, max(before - (time.monotonic() - began), 1e-3), interval)
