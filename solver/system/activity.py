"""What an evaluation does besides calculating: it waits for its turn, or reads.

A forward model says it with :func:`waiting` and :func:`doing`; what is waited is no time of the run. The process that
watches another one gets it through a :class:`Listener`, the measured time of an evaluation through :func:`counting`.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Protocol

__all__ = ["Listener", "Waited", "counting", "doing", "has_waited", "listen", "waiting"]


class Listener(Protocol):
    """Hears what the evaluation under way does."""

    def wait(self) -> None:
        """It begins to wait."""

    def go_on(self, seconds: float) -> None:
        """It has waited this long [s], and waits no longer."""

    def do(self, what: str) -> None:
        """It does this, in words such as "reading series y from out.csv"; empty: it calculates."""


@dataclass
class Waited:
    """Seconds [s] that were waited."""

    seconds: float = 0.0


_counts: ContextVar[Waited | None] = ContextVar("waited", default=None)
_listeners: list[Listener] = []


def listen(listener: Listener) -> None:
    """Tell a listener of all evaluations of this process from now on, and of those of its forks."""
    _listeners[:] = [listener]


@contextmanager
def counting() -> Iterator[Waited]:
    """Count what is waited in the body, in this thread."""
    token = _counts.set(found := Waited())
    try:
        yield found
    finally:
        _counts.reset(token)


@contextmanager
def waiting() -> Iterator[None]:
    """Wait in the body: for a slot, for a licence."""
    began = time.monotonic()
    for listener in _listeners:
        listener.wait()
    try:
        yield
    finally:
        has_waited(time.monotonic() - began)


def has_waited(seconds: float) -> None:
    """Count the last seconds [s] as waiting: what they were for turned out in the end."""
    for listener in _listeners:
        listener.go_on(seconds)
    found = _counts.get()
    if found is not None:
        found.seconds += seconds


@contextmanager
def doing(what: str) -> Iterator[None]:
    """Do something in the body for which a message has words."""
    for listener in _listeners:
        listener.do(what)
    try:
        yield
    finally:
        for listener in _listeners:
            listener.do("")
