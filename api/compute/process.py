"""One process for requests that calculate: asked over a socket of this machine, watched, ended at its limits."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import os
import shutil
import signal
import socket
import ssl
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import httpx

from geoswarm.environment import without_secrets
from geoswarm.solver.system.environment import numerics
from geoswarm.solver.system.processes import child_program, descendants, kill_session, memory_of

__all__ = ["PRINCIPAL_HEADER", "ROUTE_HEADER", "EndedError", "ComputeProcess"]

log = logging.getLogger(__name__)

PRINCIPAL_HEADER = "x-geoswarm-principal"
ROUTE_HEADER = "x-geoswarm-route"  # of the answer: the template of the route that answered
BOOTSTRAP = child_program("geoswarm.api.compute_program")
START_SECONDS = 120.0
WATCH_SECONDS = 0.1
GONE = frozenset(
    name.encode()
    for name in (
        *("connection", "content-length", "transfer-encoding"),
        *("authorization", "cookie", "x-api-key", PRINCIPAL_HEADER),
    )
)
"""Headers that are not passed on: the request is authenticated, and the connection is another."""


class EndedError(Exception):
    """The process ended by itself before it had answered."""


class ComputeProcess:
    """A process that answers one request at a time.

    Parameters
    ----------
    given
        What its program needs, see :func:`geoswarm.api.compute_program.main`.
    descriptors
        What it inherits.
    """

    def __init__(self, given: Mapping[str, Any], descriptors: tuple[int, ...]) -> None:
        self._folder = Path(tempfile.mkdtemp(prefix="geoswarm-compute-"))
        address = str(self._folder / "socket")
        self.job: str | None = None
        """The job that it was asked about last: it remembers what it has read of it."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listener:
            listener.bind(address)
            listener.listen(8)
            self._process = subprocess.Popen(
                [sys.executable, "-c", BOOTSTRAP],
                stdin=subprocess.PIPE,
                pass_fds=(*descriptors, listener.fileno()),
                env=without_secrets(os.environ) | numerics(),
                start_new_session=True,
            )
            text = json.dumps({**given, "path": sys.path, "listener": listener.fileno()})
        with contextlib.suppress(BrokenPipeError):  # died at once: the next request sees it
            if self._process.stdin is not None:
                self._process.stdin.write(text.encode() + b"\n")
                self._process.stdin.flush()
        self._client = httpx.AsyncClient(
            # a context of its own: httpx would read the authorities of TLS, which takes longer than a request
            transport=httpx.AsyncHTTPTransport(verify=ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT), uds=address),
            timeout=httpx.Timeout(None),
            trust_env=False,
        )

    @property
    def alive(self) -> bool:
        """Whether it can be asked."""
        return self._process.poll() is None

    async def ready(self) -> None:
        """Wait until it answers.

        Raises
        ------
        EndedError
        """
        deadline = time.monotonic() + START_SECONDS
        while time.monotonic() < deadline and self.alive:
            with contextlib.suppress(httpx.TransportError):
                await self._client.get("http://compute/health/live", timeout=2.0)
                return
            await asyncio.sleep(0.05)
        raise EndedError(f"it did not start within {START_SECONDS:g} s")

    async def ask(self, scope: Mapping[str, Any], body: bytes, principal: str) -> httpx.Response:
        """Pass a request on; the answer's body has not been read.

        Raises
        ------
        EndedError
        """
        query = scope.get("query_string", b"")
        path = scope.get("raw_path") or scope["path"].encode()
        url = httpx.URL(scheme="http", host="compute", raw_path=path + (b"?" + query if query else b""))
        headers = [(name, value) for name, value in scope["headers"] if name.lower() not in GONE]
        headers.append((PRINCIPAL_HEADER.encode(), principal.encode()))
        request = self._client.build_request(scope["method"], url, headers=headers, content=body)
        try:
            return await self._client.send(request, stream=True)
        except httpx.TransportError as error:
            raise EndedError(self._how_it_ended()) from error

    async def watch(self, seconds: float, memory_mb: float) -> str:
        """Return what it exceeds, as soon as it does: wall time [s] or memory [MiB] of it and all that it started."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            await asyncio.sleep(WATCH_SECONDS)
            used = sum(memory_of(pid) for pid in (self._process.pid, *descendants(self._process.pid)))
            if used > memory_mb:
                return f"used more than {memory_mb:g} MiB of memory"
        return f"took longer than {seconds:g} s"

    def _how_it_ended(self) -> str:
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(1.0)
        code = self._process.returncode
        if code is not None and code < 0:
            with contextlib.suppress(ValueError):
                return f"was ended by {signal.Signals(-code).name}"
        return "broke off" if code is None else f"ended with exit code {code}"

    async def close(self) -> None:
        """End it with all that it has started, and close the connection to it."""
        await asyncio.to_thread(self._kill)
        await self._client.aclose()

    def _kill(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        self._process.wait()
        if self._process.stdin is not None:
            with contextlib.suppress(BrokenPipeError):
                self._process.stdin.close()
        kill_session(self._process.pid)
        shutil.rmtree(self._folder, ignore_errors=True)
