"""When to reconnect to an event stream, when to give up; decides only, so that both clients share it."""

from __future__ import annotations

from time import monotonic

import httpx

from geoswarm.client.errors import ConnectionFailedError, GeoswarmError, ServerError
from geoswarm.client.sse import EventReader
from geoswarm.records.job import Event

__all__ = ["Follower", "SilentStreamError", "pause_before"]

FIRST_PAUSE = 0.2
LONGEST_PAUSE = 3.0
SILENT_CONNECTIONS = 2
SHORTEST_READ = 0.05
POLL_SECONDS = 1.0


def pause_before(deadline: float | None) -> float:
    """How long to pause before asking again, without the stream [s]; 0 when the deadline has passed."""
    return POLL_SECONDS if deadline is None else min(POLL_SECONDS, max(0.0, deadline - monotonic()))


class SilentStreamError(ConnectionFailedError):
    """Connections open, but neither data nor heartbeats arrive: something in between holds them back."""


class Follower:
    """State of one reader of an event stream over any number of connections.

    Parameters
    ----------
    after
        Id of the last event already known.
    patience
        How long the service may be unreachable before the reader gives up [s].
    silence
        A connection is given up after this time without data or heartbeats [s].
    deadline
        On the clock of ``time.monotonic`` [s]; None for no end.
    """

    def __init__(self, after: int, *, patience: float, silence: float, deadline: float | None = None) -> None:
        self._reader = EventReader(after)
        self._patience = patience
        self._silence = silence
        self._deadline = deadline
        self._failing_since: float | None = None
        self._pause = FIRST_PAUSE
        self._silent = 0
        self._heard = False
        self.ended = False

    @property
    def last_id(self) -> int:
        """Id of the last event received."""
        return self._reader.last_id

    @property
    def expired(self) -> bool:
        """Whether the deadline has passed."""
        return self._remaining <= 0.0

    @property
    def _remaining(self) -> float:
        return float("inf") if self._deadline is None else self._deadline - monotonic()

    def read_timeout(self) -> float:
        """How long a new connection may be silent: never much past the deadline [s]."""
        self._reader.reset()
        self._heard = False
        self._timeout = min(self._silence, max(self._remaining, SHORTEST_READ))
        return self._timeout

    def hear(self, line: str) -> Event | None:
        """Take a line of the stream; ``ended`` is set with the event that ends the job."""
        self._heard = True
        self._failing_since = None
        self._pause = FIRST_PAUSE
        self._silent = 0
        event = self._reader.feed(line)
        if event is not None:
            self.ended = event.ends_job
        return event

    @property
    def should_reconnect(self) -> bool:
        """Whether the deadline has come so near that a silent connection would overrun it."""
        return self._remaining < self._timeout / 2

    def broken(self, error: Exception | None) -> float:
        """A connection ended before the job did; how long to pause before the next one [s].

        Raises
        ------
        GeoswarmError
            ``error`` when it is final, or when the service has been out of reach for too long.
        """
        if isinstance(error, GeoswarmError) and not (
            isinstance(error, ServerError) and error.status in (502, 503, 504)
        ):
            raise error
        if isinstance(error, httpx.ReadTimeout):
            if self._timeout < self._silence:  # cut short for the deadline
                return 0.0
            self._silent += not self._heard
            if self._silent >= SILENT_CONNECTIONS:
                raise SilentStreamError(f"the event stream stayed silent for {self._silence:g} s, {self._silent} times")
        now = monotonic()
        if self._failing_since is None:
            self._failing_since = now
        elif now - self._failing_since > self._patience:
            if isinstance(error, GeoswarmError):
                raise error
            raise ConnectionFailedError(
                f"the event stream broke and could not be taken up for {self._patience:g} s: {error or 'it ended'}"
            )
        pause, self._pause = self._pause, min(self._pause * 2, LONGEST_PAUSE)
        return min(pause, max(self._remaining, 0.0))
