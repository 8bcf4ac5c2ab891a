"""Limits of what clients may take of this process: how often, and how much at once."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable
from typing import Literal

from cachetools import LRUCache

__all__ = ["RateLimiter", "Shares"]

MOST_CLIENTS = 10_000


class RateLimiter:
    """Lets each client make ``burst`` requests at once and ``rate`` a second [1/s] in the long run.

    Parameters
    ----------
    rate
        0: no limit.
    clock
        Seconds that only grow.
    """

    def __init__(self, rate: float, burst: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.rate = rate
        self.burst = burst
        self._clock = clock
        # Client: tokens, when. The longest silent one, which is dropped, has a full bucket by now, or nearly so.
        self._buckets: LRUCache[str, tuple[float, float]] = LRUCache(MOST_CLIENTS)

    def take(self, client: str) -> int | None:
        """Take a token; None when there was one, else the whole seconds until there is one."""
        if self.rate <= 0:
            return None
        tokens = self.tokens(client)
        granted = tokens >= 1.0
        self._buckets[client] = (tokens - granted, self._clock())
        return None if granted else self._seconds(tokens)

    def wait(self, client: str) -> int | None:
        """Return the whole seconds until there is a token; None when there is one. Takes none."""
        if self.rate <= 0:
            return None
        tokens = self.tokens(client)
        return None if tokens >= 1.0 else self._seconds(tokens)

    def tokens(self, client: str) -> float:
        """Return how many tokens a client has now."""
        tokens, at = self._buckets.get(client, (float(self.burst), self._clock()))
        return min(self.burst, tokens + (self._clock() - at) * self.rate)

    def _seconds(self, tokens: float) -> int:
        return max(1, math.ceil((1.0 - tokens) / self.rate))


class Shares:
    """What clients hold at once of something that there is only so much of.

    Parameters
    ----------
    in_all, each
        The most that all clients together, and one of them, may hold.
    """

    def __init__(self, in_all: int, each: int) -> None:
        self.in_all = in_all
        self.each = each
        self.taken = 0
        self._held: Counter[str] = Counter()

    def take(self, client: str, amount: int = 1) -> Literal["each", "in_all"] | None:
        """Take an amount; None when it was there, else the limit that is in the way."""
        if self._held[client] + amount > self.each:
            return "each"
        if self.taken + amount > self.in_all:
            return "in_all"
        self._held[client] += amount
        self.taken += amount
        return None

    def give_back(self, client: str, amount: int = 1) -> None:
        """Give back what was taken."""
        self.taken -= amount
        self._held[client] -= amount
        if self._held[client] <= 0:
            del self._held[client]

    def held(self, client: str) -> int:
        """Return what a client holds now."""
        return self._held.get(client, 0)
