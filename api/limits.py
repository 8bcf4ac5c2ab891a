"""Rate limits: a bucket of tokens for every client, in this process."""

from __future__ import annotations

import math
import time
from collections import OrderedDict
from collections.abc import Callable

__all__ = ["RateLimiter"]

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
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()  # client: tokens, when

    def take(self, client: str) -> int | None:
        """Take a token; None when there was one, else the whole seconds until there is one."""
        if self.rate <= 0:
            return None
        tokens = self.tokens(client)
        granted = tokens >= 1.0
        self._buckets[client] = (tokens - granted, self._clock())
        self._buckets.move_to_end(client)
        if len(self._buckets) > MOST_CLIENTS:  # the longest silent has a full bucket by now, or nearly so
            self._buckets.popitem(last=False)
        return None if granted else max(1, math.ceil((1.0 - tokens) / self.rate))

    def tokens(self, client: str) -> float:
        """Return how many tokens a client has now."""
        tokens, at = self._buckets.get(client, (float(self.burst), self._clock()))
        return min(self.burst, tokens + (self._clock() - at) * self.rate)
