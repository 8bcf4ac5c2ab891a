"""Slots: how many evaluations of a kind of forward model may run at once in one group of workers (licences).

The workers of a group share a file without a name; each slot is a byte of it that its holder locks. The system frees
the lock of a process that dies, in whatever way.
"""

from __future__ import annotations

import fcntl
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

__all__ = ["Slots"]


class Slots:
    """The slots of one group, as one of its processes sees them.

    Parameters
    ----------
    limits
        Number of slots by kind of forward model; kinds that are not named have as many as there are workers.
    descriptor
        The file that the processes of the group share.
    """

    def __init__(self, limits: Mapping[str, int], descriptor: int) -> None:
        self._descriptor = descriptor
        self._ranges: dict[str, range] = {}
        self._held: set[int] = set()
        first = 0
        for kind, count in sorted(limits.items()):
            self._ranges[kind] = range(first, first + count)
            first += count

    @classmethod
    def none(cls) -> Slots:
        """Return slots that limit nothing."""
        return cls({}, -1)

    def full(self) -> Sequence[str]:
        """Return the kinds without a free slot."""
        full = []
        for kind, places in self._ranges.items():
            place = self._take(places)
            if place is None:
                full.append(kind)
            else:
                self._free(place)
        return full

    @contextmanager
    def hold(self, kind: str) -> Iterator[bool]:
        """Hold a slot of a kind; gives whether there was one."""
        if kind not in self._ranges:
            yield True
            return
        place = self._take(self._ranges[kind])
        try:
            yield place is not None
        finally:
            if place is not None:
                self._free(place)

    def _take(self, places: range) -> int | None:
        for place in places:
            if place in self._held:
                continue
            try:
                fcntl.lockf(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, place)
            except (BlockingIOError, PermissionError):  # somebody else has it
                continue
            self._held.add(place)
            return place
        return None

    def _free(self, place: int) -> None:
        fcntl.lockf(self._descriptor, fcntl.LOCK_UN, 1, place)
        self._held.discard(place)
