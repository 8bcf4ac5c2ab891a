"""Connections of the service: how many, how long each may keep it waiting, and what happens when there are too many.

The connection that keeps the service waiting longest (for the head or the rest of a request) makes room for others. A
connection that is being answered stays. When all are, new ones wait in the system's queue.
"""

from __future__ import annotations

import asyncio
import contextlib
import enum
import logging
import resource
import socket
from collections.abc import Callable
from typing import Any

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

__all__ = ["Config", "Connection", "Connections", "most_connections", "raise_descriptors"]

log = logging.getLogger("geoswarm.api")

REST_SECONDS = 5.0
"""How long the rest of a body may still come after its request was answered [s]."""
STALL_SECONDS = 30.0
"""How long a client may read nothing of its answer [s]."""
LOOK_SECONDS = 1.0
ACCEPTED_AT_ONCE = 64
FIRST_PAUSE, LONGEST_PAUSE = 0.1, 1.0
TELL_SECONDS = 10.0
RESERVED_DESCRIPTORS = 200  # database, workers, figures, the program's own files
LEAST_CONNECTIONS = 16


def raise_descriptors() -> int:
    """Let this process open as many files as the system allows it; return how many."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft != hard:
        with contextlib.suppress(OSError, ValueError):  # a system whose "unlimited" is not meant for this
            resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
        soft = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    return 2**31 if soft == resource.RLIM_INFINITY else soft


def most_connections(wanted: int, descriptors: int) -> int:
    """Return how many connections may be open: each may need a second descriptor, for a body in a file."""
    return min(wanted, max(LEAST_CONNECTIONS, (descriptors - RESERVED_DESCRIPTORS) // 2))


class Phase(enum.IntEnum):
    """What a connection is about; those with smaller numbers go first when room is needed."""

    HEAD = 0  # nothing, or a part of the head of a request, has come
    REST = 1  # answered; the rest of the body still comes
    STUCK = 2  # not authenticated, and reads nothing of the answer
    BODY = 3  # a body comes, not authenticated
    BUSY = 4


class Connections:
    """The connections of one server.

    Parameters
    ----------
    most
        How many may be open.
    head_seconds
        Time in which the head of a request must arrive [s].
    """

    def __init__(self, most: int, head_seconds: float) -> None:
        self.most = most
        self.head_seconds = head_seconds
        self._live: set[Connection] = set()
        self._coming: set[asyncio.Protocol] = set()
        self._tasks: set[asyncio.Task[None]] = set()
        self._accepting: list[tuple[socket.socket, Callable[[], asyncio.Protocol]]] = []
        self._listening = False
        self._paused = False
        self._closed = False
        self._pause = FIRST_PAUSE
        self._told_at = float("-inf")
        self._look: asyncio.TimerHandle | None = None

    @property
    def open(self) -> int:
        """Number of connections."""
        return len(self._live) + len(self._coming)

    def start(self, listeners: list[socket.socket], make: Callable[[], asyncio.Protocol]) -> None:
        """Accept connections on listening sockets; called in the event loop."""
        self._accepting = [(listener, make) for listener in listeners]
        self._listen()
        self._look_after()

    def close(self) -> None:
        """Accept no more."""
        self._closed = True
        self._rest()
        if self._look is not None:
            self._look.cancel()

    def add(self, connection: Connection) -> None:
        """Count a connection that has come."""
        self._coming.discard(connection)
        self._live.add(connection)

    def discard(self, connection: Connection) -> None:
        """Forget a connection."""
        self._live.discard(connection)
        self.go_on()

    def go_on(self) -> None:
        """Accept waiting connections, where there may be a place."""
        if not self._paused:
            self._listen()

    def _listen(self) -> None:
        if not self._closed and not self._listening:
            self._listening = True
            for listener, make in self._accepting:
                asyncio.get_running_loop().add_reader(listener.fileno(), self._accept, listener, make)

    def _rest(self) -> None:
        if self._listening:
            self._listening = False
            for listener, _ in self._accepting:
                asyncio.get_running_loop().remove_reader(listener.fileno())

    def _accept(self, listener: socket.socket, make: Callable[[], asyncio.Protocol]) -> None:
        for number in range(ACCEPTED_AT_ONCE):
            full = self.open >= self.most
            if full and number:  # the first one waits for sure; room is made for no other
                return
            if full and not self._make_room():
                if self._coming:  # they have no phase yet
                    return
                self._rest()  # until a request is answered
                self._tell("all %d connections are in use; others wait", self.most)
                return
            try:
                accepted, _ = listener.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError as error:
                self._tell("no connection can be accepted now: %s", error.strerror or error)
                self._make_room()
                self._rest()
                self._paused = True
                asyncio.get_running_loop().call_later(self._pause, self._resume)
                self._pause = min(2 * self._pause, LONGEST_PAUSE)
                return
            self._pause = FIRST_PAUSE
            accepted.setblocking(False)
            protocol = make()
            self._coming.add(protocol)
            task = asyncio.get_running_loop().create_task(self._connect(accepted, protocol))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _connect(self, accepted: socket.socket, protocol: asyncio.Protocol) -> None:
        try:
            await asyncio.get_running_loop().connect_accepted_socket(lambda: protocol, accepted)
        except OSError:  # gone already
            self._coming.discard(protocol)
            accepted.close()

    def _resume(self) -> None:
        self._paused = False
        self._listen()

    def _make_room(self) -> bool:
        """Close the connection that keeps the service waiting longest; False when none does."""
        waiting = [(phase, c.since, id(c), c) for c in self._live if (phase := c.phase) is not Phase.BUSY]
        if not waiting:
            return False
        victim = min(waiting)[-1]
        victim.end()
        self._live.discard(victim)
        return True

    def _look_after(self) -> None:
        """End the connections that keep the service waiting for too long."""
        loop = asyncio.get_running_loop()
        now = loop.time()
        for connection in [c for c in self._live if c.overdue(now, self.head_seconds)]:
            connection.end()
        self.go_on()
        if not self._closed:
            self._look = loop.call_later(LOOK_SECONDS, self._look_after)

    def _tell(self, message: str, *values: object) -> None:
        now = asyncio.get_running_loop().time()
        if now - self._told_at >= TELL_SECONDS:
            self._told_at = now
            log.warning(message, *values)


class Config(uvicorn.Config):
    """Configuration of uvicorn whose connections are counted and watched."""

    def __init__(self, app: Any, connections: Connections, **options: Any) -> None:
        super().__init__(app, http=Connection, ws="none", **options)
        self.connections = connections


class Connection(H11Protocol):
    """uvicorn's HTTP/1.1 on one connection, which knows what it waits for and since when."""

    config: Config
    since = 0.0
    _unsent = 0
    _sent_at = 0.0

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as uvicorn has it
        """Begin to wait for the head of a request."""
        super().connection_made(transport)
        self.since = self._sent_at = self.loop.time()
        self.config.connections.add(self)

    def connection_lost(self, exc: Exception | None) -> None:
        """Make room."""
        super().connection_lost(exc)
        self.config.connections.discard(self)

    def data_received(self, data: bytes) -> None:
        """Take what has come; the head of a further request gets its own time."""
        if self.timeout_keep_alive_task is not None:
            self.since = self.loop.time()
        super().data_received(data)

    def on_response_complete(self) -> None:
        """Begin to wait for the rest of the body, or for the next request."""
        self.since = self.loop.time()
        super().on_response_complete()
        self.config.connections.go_on()

    @property
    def phase(self) -> Phase:
        """What the connection is about now."""
        cycle = self.cycle
        if cycle is None:
            return Phase.HEAD
        if cycle.response_complete:
            return Phase.REST if self.conn.their_state is h11.SEND_BODY or self._unsent else Phase.HEAD
        if "identity" in self.scope["state"]:
            return Phase.BUSY
        if cycle.more_body:
            return Phase.BODY
        return Phase.STUCK if self._unsent and self.loop.time() - self._sent_at > REST_SECONDS else Phase.BUSY

    def overdue(self, now: float, head_seconds: float) -> bool:
        """Whether the client has kept the service waiting for too long; asked once in a while."""
        unsent = self.transport.get_write_buffer_size()
        if unsent == 0 or unsent < self._unsent:
            self._sent_at = now
        self._unsent = unsent
        if unsent and now - self._sent_at > STALL_SECONDS:
            return True
        waited = now - self.since
        phase = self.phase
        if phase is Phase.REST and not unsent:
            return waited > REST_SECONDS
        return phase is Phase.HEAD and waited > head_seconds

    def end(self) -> None:
        """Close the connection at once."""
        self.transport.abort()
