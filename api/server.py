"""Runs the HTTP service under uvicorn."""

from __future__ import annotations

import asyncio
import errno
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

import uvicorn

from geoswarm.api.access.connections import Config, Connection, Connections, most_connections, raise_descriptors
from geoswarm.api.app import create_app
from geoswarm.api.assets import Assets
from geoswarm.api.compute.pool import ComputePool
from geoswarm.api.errors import PortInUseError
from geoswarm.api.events.feed import EventFeed
from geoswarm.api.events.open_work import OpenWorkWatch
from geoswarm.api.settings import ApiSettings
from geoswarm.workers.service.job_service import JobService

__all__ = ["DEFAULT_HOST", "DEFAULT_PORT", "Server", "bind", "serve"]

DEFAULT_HOST = "127.0.0.1"
DEFAULT_PORT = 8765
MAX_PORT = 65535
GRACE_SECONDS = 2


def bind(host: str, port: int) -> socket.socket:
    """Take an address to listen on; port 0 takes any free one.

    Raises
    ------
    PortInUseError
        When it is taken, forbidden or unknown.
    """
    if not 0 <= port <= MAX_PORT:
        raise PortInUseError(f"cannot listen on {host}:{port}: the port must be from 0 (any free one) to {MAX_PORT}")
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except OSError as error:
        raise PortInUseError(f"cannot listen on {host}:{port}: {error}") from None
    listener = socket.socket(family, kind, protocol)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(1024)
    except OSError as error:
        listener.close()
        if error.errno == errno.EADDRINUSE:
            why = "the port is already in use; stop the other program or choose another port"
        elif error.errno == errno.EACCES:
            why = "not permitted; choose a port above 1023"
        else:
            why = error.strerror or str(error)
        raise PortInUseError(f"cannot listen on {host}:{port}: {why}") from None
    listener.setblocking(False)
    return listener


class Server(uvicorn.Server):
    """uvicorn that watches its connections, ends waiting requests when it stops, and returns after a signal."""

    config: Config

    def __init__(
        self,
        config: Config,
        feed: EventFeed,
        open_work: OpenWorkWatch,
        assets: Assets,
        on_started: Callable[[], None] | None = None,
        pool: ComputePool | None = None,
    ) -> None:
        super().__init__(config)
        self._pool = pool
        self._assets = assets
        self._feed = feed
        self._open_work = open_work
        self._on_started = on_started

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup([])
        self.config.connections.start(sockets or [], self._connection)
        threading.Thread(target=self._assets.prepare, name="prepare assets", daemon=True).start()
        if self.started and self._on_started is not None:
            self._on_started()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self.config.connections.close()
        self._feed.close()
        self._open_work.close()
        await super().shutdown(sockets)
        if self._pool is not None:
            await self._pool.close()

    def _connection(self) -> asyncio.Protocol:
        return Connection(self.config, self.server_state, self.lifespan.state)

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Stop gracefully on SIGINT and SIGTERM without raising them again: the caller has things to close."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        previous = {number: signal.signal(number, self._stop) for number in (signal.SIGINT, signal.SIGTERM)}
        try:
            yield
        finally:
            for number, handler in previous.items():
                signal.signal(number, handler)

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self.force_exit = self.should_exit
        self.should_exit = True


def serve(
    service: JobService,
    host: str = DEFAULT_HOST,
    port: int = DEFAULT_PORT,
    settings: ApiSettings | None = None,
    *,
    listener: socket.socket | None = None,
    on_started: Callable[[str], None] | None = None,
    compute: bool = False,
) -> None:
    """Serve until SIGINT or SIGTERM, then stop gracefully within some 2 s and return.

    Parameters
    ----------
    service
        What the routes work on; the caller closes it afterwards.
    host, port
        Address to listen on.
    settings
        API key and limits.
    listener
        From :func:`bind`, to have the port checked before the engine starts; replaces ``host`` and ``port``.
    on_started
        Called with the base URL as soon as requests are answered.
    compute
        Requests that calculate get processes of their own.

    Raises
    ------
    PortInUseError
        Before anything starts.
    """
    taken = listener or bind(host, port)
    try:
        server = build_server(service, taken, settings, on_started, compute=compute)
        server.run(sockets=[taken])
    finally:
        taken.close()


def build_server(
    service: JobService,
    listener: socket.socket,
    settings: ApiSettings | None = None,
    on_started: Callable[[str], None] | None = None,
    *,
    compute: bool = False,
) -> Server:
    """Put application and uvicorn together for a listening socket.

    ``compute``: requests that calculate get processes of their own.
    """
    settings = settings or ApiSettings()
    pool = ComputePool(service, settings) if compute and settings.compute_processes else None
    app = create_app(service, settings, pool=pool)
    most = most_connections(settings.max_connections, raise_descriptors())
    app.state.streams.in_all = min(settings.event_streams, most // 2)  # there is always room for other requests
    config = Config(
        app,
        Connections(most, settings.head_seconds),
        log_config=None,
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=bool(settings.trusted_proxies),
        forwarded_allow_ips=list(settings.trusted_proxies),
        lifespan="off",
        timeout_graceful_shutdown=GRACE_SECONDS,
    )
    url = base_url(listener)
    told = None if on_started is None else lambda: on_started(url)
    return Server(config, app.state.feed, app.state.open_work, app.state.assets, told, pool)


def base_url(listener: socket.socket) -> str:
    """Address under which a listening socket is reached from this machine."""
    host, port = listener.getsockname()[:2]
    host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"
