"""Limits of time that regular expressions keep, and timers that go on."""

from __future__ import annotations

import re
import signal
import threading

import pytest

from geoswarm.solver.external.reading_time import OutOfTimeError, time_limit


def test_a_regular_expression_is_ended() -> None:
    with pytest.raises(OutOfTimeError), time_limit(0.2):
        re.search("(a+)+b", "a" * 60)


def test_nothing_is_left_of_it() -> None:
    """A timer that ran before (pytest's own, too) goes on, and its handler is there again."""
    heard: list[int] = []
    handler = signal.signal(signal.SIGALRM, lambda number, _: heard.append(number))
    timer = signal.setitimer(signal.ITIMER_REAL, 1000.0)
    try:
        with time_limit(100.0):
            assert signal.getitimer(signal.ITIMER_REAL)[0] <= 100.0
        left = signal.getitimer(signal.ITIMER_REAL)[0]
        assert 100.0 < left <= 1000.0
        with pytest.raises(ZeroDivisionError), time_limit(100.0):
            raise ZeroDivisionError
        signal.raise_signal(signal.SIGALRM)
        assert heard == [signal.SIGALRM]
    finally:
        signal.setitimer(signal.ITIMER_REAL, *timer)
        signal.signal(signal.SIGALRM, handler)


def test_other_threads_are_not_limited() -> None:
    done = threading.Event()

    def body() -> None:
        with time_limit(1e-6):
            done.set()

    thread = threading.Thread(target=body)
    thread.start()
    thread.join()
    assert done.is_set()
