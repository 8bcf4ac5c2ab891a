"""Memory that a worker and its evaluation process share."""

from __future__ import annotations

import mmap
import os
import struct
import time

__all__ = ["BUILDING", "IDLE", "SharedState"]

IDLE, BUILDING = -1, -2


class SharedState:
    """Memory that worker and evaluation process share.

    Which position is being evaluated, since when, how long it has waited and what it does (a listener of
    :mod:`geoswarm.solver.system.activity`), and a flag.
    """

    _STATE = struct.Struct("=qd")
    _WAIT = struct.Struct("=dd")  # seconds waited so far; since when it waits now, 0: it does not
    _WAIT_AT = 16
    _FLAG = 32
    _TEXT, _SIZE = 40, 240  # its length in a byte, then UTF-8

    def __init__(self, descriptor: int, *, new: bool) -> None:
        if new:
            os.ftruncate(descriptor, self._SIZE)
        self._memory = mmap.mmap(descriptor, self._SIZE)

    def begin(self, index: int) -> float:
        """Note that a position is begun; return the time [s]."""
        now = time.monotonic()
        self._STATE.pack_into(self._memory, 0, index, now)
        self._WAIT.pack_into(self._memory, self._WAIT_AT, 0.0, 0.0)
        self.do("")
        return now

    def idle(self) -> None:
        """Note that nothing is being evaluated."""
        self._STATE.pack_into(self._memory, 0, IDLE, time.monotonic())

    @property
    def current(self) -> tuple[int, float]:
        """Index of the position under evaluation, or ``IDLE``, ``BUILDING``; since when (monotonic time [s])."""
        index, since = self._STATE.unpack_from(self._memory, 0)
        return index, since

    def build(self) -> None:
        """Note that a job's problem is being built."""
        self._STATE.pack_into(self._memory, 0, BUILDING, time.monotonic())

    def wait(self) -> None:
        """Note that the position under evaluation begins to wait."""
        waited, _ = self._WAIT.unpack_from(self._memory, self._WAIT_AT)
        self._WAIT.pack_into(self._memory, self._WAIT_AT, waited, time.monotonic())

    def go_on(self, seconds: float) -> None:
        """Note that it has waited so long [s], and does not wait now."""
        waited, _ = self._WAIT.unpack_from(self._memory, self._WAIT_AT)
        self._WAIT.pack_into(self._memory, self._WAIT_AT, waited + seconds, 0.0)

    @property
    def waited(self) -> float:
        """How long the position under evaluation has waited until now [s]."""
        waited, since = self._WAIT.unpack_from(self._memory, self._WAIT_AT)
        return float(waited + (time.monotonic() - since if since else 0.0))

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
