"""Memory that a worker and its evaluation process share."""

from __future__ import annotations

import mmap
import os
import struct
import time

__all__ = ["BUILDING", "IDLE", "SharedState"]

IDLE, BUILDING = -1, -2


class SharedState:
    """Memory that worker and evaluation process share: which position is being evaluated, since when, and a flag."""

    _STATE = struct.Struct("=qd")
    _SIZE = 64
    _FLAG = 32

    def __init__(self, descriptor: int, *, new: bool) -> None:
        if new:
            os.ftruncate(descriptor, self._SIZE)
        self._memory = mmap.mmap(descriptor, self._SIZE)

    def begin(self, index: int) -> float:
        """Note that a position is begun; return the time [s]."""
        now = time.monotonic()
        self._STATE.pack_into(self._memory, 0, index, now)
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
