"""Reads an event stream (text/event-stream) as the HTML standard describes it.

Line by line, so that :class:`geoswarm.client.follow.Follower` hears comments, too: they are the signs of life (why not
httpx-sse: docs/decisions/0003-dependencies.md). Lines come from the HTTP library, which has joined split ones.
"""

from __future__ import annotations

import json

from geoswarm.records.job import Event

__all__ = ["EventReader"]


class EventReader:
    """Takes the lines of a stream one by one and gives an event when one is complete.

    ``last_id`` is the id of the last complete event; a new connection goes on after it. Lines that belong to an
    incomplete event are dropped by :meth:`reset`, as a broken connection leaves them.
    """

    def __init__(self, last_id: int = 0) -> None:
        self.last_id = last_id
        self.reset()

    def reset(self) -> None:
        """Forget the lines of an incomplete event."""
        self._id: int | None = None
        self._kind = "message"
        self._data: list[str] = []

    def feed(self, line: str) -> Event | None:
        """Take one line without its end; an empty one completes an event."""
        if not line:
            return self._complete()
        name, _, value = line.partition(":")
        value = value.removeprefix(" ")
        if name == "data":
            self._data.append(value)
        elif name == "event":
            self._kind = value
        elif name == "id" and value.isascii() and value.isdigit():
            self._id = int(value)
        return None

    def _complete(self) -> Event | None:
        number, kind, data = self._id, self._kind, "\n".join(self._data)
        self.reset()
        if number is None or not data:
            return None
        self.last_id = number
        return Event(id=number, kind=kind, data=json.loads(data))
