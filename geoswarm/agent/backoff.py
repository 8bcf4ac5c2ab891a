"""How long to wait before the next try at a service that does not answer."""

from __future__ import annotations

import random

__all__ = ["Backoff"]

FIRST_SECONDS, LONGEST_SECONDS = 0.5, 30.0


class Backoff:
    """Waits that double up to half a minute, each by chance half as long at least: a crowd does not come at once.

    >>> waits = Backoff()
    >>> 0.25 <= waits.next() <= 0.5
    True
    >>> 0.5 <= waits.next() <= 1.0
    True
    >>> waits.next(at_least=7.0) >= 7.0
    True
    """

    def __init__(self) -> None:
        self._longest = FIRST_SECONDS
        self._chance = random.SystemRandom()

    def next(self, at_least: float = 0.0) -> float:
        """Return the next wait [s]."""
        wait = self._longest * self._chance.uniform(0.5, 1.0)
        self._longest = min(2.0 * self._longest, LONGEST_SECONDS)
        return max(wait, at_least * self._chance.uniform(1.0, 1.2))
