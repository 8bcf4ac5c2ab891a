"""Memory that a worker and its evaluation process share."""

from __future__ import annotations

import mmap
import os
import struct
import time
from typing import NamedTuple

__all__ = ["BUILDING", "IDLE", "Progress", "SharedState"]

IDLE, BUILDING = -1, -2

_MOST_READS = 1000
"""After which a reader takes what it has: a writer that never pauses must not hold it up."""


class Progress(NamedTuple):
    """What an evaluation process is at, as it was at one moment."""

    position: int
    """Position under evaluation, or ``IDLE``, ``BUILDING``."""
    since: float
    """Monotonic time [s]."""
    waited: float
    """How long that has waited until now [s]."""


class SharedState:
    """Memory that worker and evaluation process share.

    Which position is being evaluated, since when, how long it has waited and what it does (a listener of
    :mod:`geoswarm.solver.system.activity`), and a flag. The worker writes before it asks for something, the
    evaluation process until it has answered; the worker reads at any time. So what belongs together has two places, and
    a byte that counts says which of them was written last.
    """

    _STATE = struct.Struct("=qddd")  # position; since when; seconds waited so far; since when it waits now, 0: not
    _COUNT, _FIRST = 0, 8
    _FLAG = _FIRST + 2 * _STATE.size
    _TEXT = _FLAG + 8  # its length in a byte, then UTF-8
    _SIZE = _TEXT + 200

    def __init__(self, descriptor: int, *, new: bool) -> None:
        if new:
            os.ftruncate(descriptor, self._SIZE)
        self._memory = mmap.mmap(descriptor, self._SIZE)
        if new:
            self.idle()

    def begin(self, index: int) -> float:
        """Note that a position is begun; return the time [s]."""
        now = time.monotonic()
        self._write(index, now, 0.0, 0.0)
        self.do("")
        return now

    def idle(self) -> None:
        """Note that nothing is being evaluated."""
        self._write(IDLE, time.monotonic(), 0.0, 0.0)

    def build(self) -> None:
        """Note that a job's problem is being built."""
        self._write(BUILDING, time.monotonic(), 0.0, 0.0)

    def wait(self) -> None:
        """Note that the position under evaluation begins to wait."""
        index, since, waited, _ = self._read()
        self._write(index, since, waited, time.monotonic())

    def go_on(self, seconds: float) -> None:
        """Note that it has waited so long [s], and does not wait now."""
        index, since, waited, _ = self._read()
        self._write(index, since, waited + seconds, 0.0)

    @property
    def current(self) -> Progress:
        """What it is at."""
        index, since, waited, waiting_since = self._read()
        return Progress(index, since, waited + (time.monotonic() - waiting_since if waiting_since else 0.0))

    def _write(self, *state: float) -> None:
        count = (self._memory[self._COUNT] + 1) % 256
        self._STATE.pack_into(self._memory, self._place(count), *state)
        self._memory[self._COUNT] = count

    def _read(self) -> tuple[int, float, float, float]:
        """The state as it was at one moment: read again if it was written meanwhile."""
        for _ in range(_MOST_READS):
            count = self._memory[self._COUNT]
            index, since, waited, waiting_since = self._STATE.unpack_from(self._memory, self._place(count))
            if self._memory[self._COUNT] == count:
                break
        return index, since, waited, waiting_since

    def _place(self, count: int) -> int:
        return self._FIRST + count % 2 * self._STATE.size

    def do(self, what: str) -> None:
        """Note what it does, in words."""
        text = what.encode()[: self._SIZE - self._TEXT - 1]
        self._memory[self._TEXT] = 0
        self._memory[self._TEXT + 1 : self._TEXT + 1 + len(text)] = text
        self._memory[self._TEXT] = len(text)

    @property
    def doing(self) -> str:
        """What it does, in words; empty: nothing was said."""
        length = self._memory[self._TEXT]
        return self._memory[self._TEXT + 1 : self._TEXT + 1 + length].decode(errors="replace")

    @property
    def stopped(self) -> bool:
        """Whether the worker wants no more after the position under evaluation."""
        return self._memory[self._FLAG] == 1

    @stopped.setter
    def stopped(self, value: bool) -> None:
        self._memory[self._FLAG] = int(value)

    def close(self) -> None:
        """Unmap it."""
        self._memory.close()
