"""A fair queue: some requests at once, few of them of one client, and waiting clients in turn."""

from __future__ import annotations

import asyncio
from collections import Counter, OrderedDict, deque

__all__ = ["BusyError", "FairQueue"]


class BusyError(Exception):
    """Too many are waiting already."""


class FairQueue:
    """Gives places to clients in fair turn. For one event loop.

    Parameters
    ----------
    places
        Places in all.
    per_client
        Places that one client may have at once.
    waiting
        Requests of one client that may wait.
    """

    def __init__(self, places: int, per_client: int, waiting: int) -> None:
        self._free = places
        self._per_client = per_client
        self._most_waiting = waiting
        self._held: Counter[str] = Counter()
        self._waiting: OrderedDict[str, deque[asyncio.Future[None]]] = OrderedDict()

    async def take(self, client: str) -> None:
        """Wait for a place.

        Raises
        ------
        BusyError
            At once, when the client has too many waiting.
        """
        line = self._waiting.get(client)
        if not line and self._may(client):
            self._give(client)
            return
        if line is not None and len(line) >= self._most_waiting:
            raise BusyError
        place = asyncio.get_running_loop().create_future()
        self._waiting.setdefault(client, deque()).append(place)
        try:
            await place
        except BaseException:
            if place.done() and not place.cancelled():
                self.give_back(client)  # it was given just now, but the client has left
            self._forget(client, place)
            raise

    def give_back(self, client: str) -> None:
        """Leave a place; the next client in turn that may have it gets it."""
        self._free += 1
        self._held[client] -= 1
        if not self._held[client]:
            del self._held[client]
        for other, line in list(self._waiting.items()):
            if not self._may(other):
                continue
            while line:
                place = line.popleft()
                if not place.done():
                    self._give(other)
                    place.set_result(None)
                    break
            if line:
                self._waiting.move_to_end(other)  # the others first
            else:
                del self._waiting[other]
            if not self._free:
                return

    def _may(self, client: str) -> bool:
        return self._free > 0 and self._held[client] < self._per_client

    def _give(self, client: str) -> None:
        self._free -= 1
        self._held[client] += 1

    def _forget(self, client: str, place: asyncio.Future[None]) -> None:
        line = self._waiting.get(client)
        if line is not None and place in line:
            line.remove(place)
            if not line:
                del self._waiting[client]
