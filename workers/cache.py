"""What was made lately, kept in memory and made by one thread at a time."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from typing import Any, TypeVar

from cachetools import LRUCache, cached

__all__ = ["Cache"]

Made = TypeVar("Made")


class Cache:
    """Keeps the things that were used last; safe to use from several threads.

    Parameters
    ----------
    size
        Number of things that are kept.
    """

    def __init__(self, size: int = 16) -> None:
        cache: LRUCache[Hashable, Any] = LRUCache(size)
        self._once = cached(cache, key=_key, condition=threading.Condition())(_make)

    def once(self, key: Hashable, make: Callable[[], Made]) -> Made:
        """Return what was made for a key, or make it while other threads that want it wait."""
        made: Made = self._once(key, make)
        return made


def _key(key: Hashable, _: Callable[[], Any]) -> Hashable:
    return key


def _make(_: Hashable, make: Callable[[], Any]) -> Any:
    return make()
