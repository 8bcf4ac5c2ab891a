"""A limit of time for Python code in this thread, regular expressions included."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["OutOfTimeError", "time_limit"]


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
