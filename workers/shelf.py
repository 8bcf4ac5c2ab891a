"""What was made lately, kept in memory and made by one thread at a time."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any, TypeVar

__all__ = ["Shelf"]

Made = TypeVar("Made")


class Shelf:
    """Keeps the things that were used last; safe to use from several threads.

    Parameters
    ----------
    size
        Number of things that are kept.
    """

    def __init__(self, size: int = 16) -> None:
        self._size = size
        self._lock = threading.Lock()
        self._kept: OrderedDict[Hashable, Any] = OrderedDict()
        self._at_work: dict[Hashable, threading.Lock] = {}

    def once(self, key: Hashable, make: Callable[[], Made]) -> Made:
        """Return what was made for a key, or make it while other threads that want it wait."""
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                found: Made = self._kept[key]
                return found
            working = self._at_work.setdefault(key, threading.Lock())
        with working:
            with self._lock:
                if key in self._kept:
                    again: Made = self._kept[key]
                    return again
            made = make()
            with self._lock:
                self._kept[key] = made
                self._at_work.pop(key, None)
                while len(self._kept) > self._size:
                    self._kept.popitem(last=False)
        return made
