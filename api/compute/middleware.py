"""Sends requests that calculate to processes of their own, and answers in their place when nothing came of it."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import re
from collections.abc import Mapping
from dataclasses import asdict
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import httpx
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from geoswarm.api.compute.fair_queue import BusyError, FairQueue
from geoswarm.api.compute.pool import ComputePool
from geoswarm.api.compute.process import ROUTE_HEADER, ComputeProcess, EndedError
from geoswarm.api.errors import DetailError, detail_response
from geoswarm.workers.access.principal import LOCAL, Principal

if TYPE_CHECKING:
    from geoswarm.api.settings import ApiSettings

__all__ = ["ComputeMiddleware", "is_compute", "job_of"]

log = logging.getLogger(__name__)

PER_CLIENT = 2
WAITING = 20  # requests of one client
OWN_HEADERS = frozenset({b"connection", ROUTE_HEADER.encode()})  # between the two processes
GRACE_SECONDS = 1.0  # for a request whose client has left


_ALWAYS = re.compile(
    r"/api/v1/(?:"
    r"problems/(?:check|warm-starts|read|tests)|measurements(?:/(?:points|ags(?:/problem)?))?|forward-models(?:/[^/]+)?"
    r"|jobs/[^/]+/(?:fit|diagrams|points|statistics|reweight|report\.(?:html|pdf)|figures(?:/[^/]+)?|sensitivity|profile"
    r"|jackknife|explore|predict|design|follow-ups|global-sensitivity|uncertainty|posterior|surface|mesh(?:/fields)?)"
    r")"
)
_CHANGES = {"POST": re.compile(r"/api/v1/jobs"), "PATCH": re.compile(r"/api/v1/jobs/[^/]+")}
_JOB = re.compile(r"/api/v1/jobs/([^/]+)")
_PAGE = re.compile(r"/(?:new|compare|jobs/[^/]+(?:/.*)?)?")


class ComputeMiddleware:
    """ASGI middleware behind the gate."""

    def __init__(self, app: ASGIApp, pool: ComputePool, settings: ApiSettings) -> None:
        self._app = app
        self._pool = pool
        self._settings = settings
        self._queue = FairQueue(settings.compute_processes, PER_CLIENT, WAITING)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if not is_compute(scope):
            if scope["type"] == "http" and _PAGE.fullmatch(scope["path"]):
                self._pool.prepare()
            await self._app(scope, receive, send)
            return
        body = await _whole_body(receive)
        if body is None:
            return
        principal: Principal = scope.get("state", {}).get("principal") or LOCAL
        client = principal.owner or principal.key_id or ""
        answer = _Answer(send)
        work = asyncio.ensure_future(self._in_turn(scope, body, principal, client, answer))
        left = asyncio.ensure_future(_departure(receive))
        stopping = False
        try:
            await asyncio.wait({work, left}, return_when=asyncio.FIRST_COMPLETED)
            if not work.done():
                await asyncio.wait({work}, timeout=GRACE_SECONDS)
        except asyncio.CancelledError:  # by the server, which ends and waits no longer
            stopping = True
        left.cancel()
        work.cancel()  # has no effect when it has ended
        with contextlib.suppress(asyncio.CancelledError):
            await work
        if stopping and not answer.begun:
            again = {"Retry-After": "5"}
            await _refuse(scope, send, DetailError(503, "The service is stopping.", kind="unavailable", headers=again))

    async def _in_turn(self, scope: Scope, body: bytes, principal: Principal, client: str, send: _Answer) -> None:
        try:
            async with asyncio.timeout(self._settings.compute_wait_seconds):
                await self._queue.take(client)
        except (BusyError, TimeoutError):
            await _refuse(
                scope,
                send,
                DetailError(
                    503,
                    "All processes for requests that calculate are busy; try again in a few seconds.",
                    kind="busy",
                    title="Busy",
                    headers={"Retry-After": "5"},
                ),
            )
            return
        try:
            await self._passed_on(scope, body, principal, send)
        finally:
            self._queue.give_back(client)

    async def _passed_on(self, scope: Scope, body: bytes, principal: Principal, send: _Answer) -> None:
        try:
            process = await self._pool.take(job_of(scope["path"]))
        except EndedError as error:
            log.error("no process for requests that calculate: %s", error)
            refusal = "No process for requests that calculate could be started; see the server's log."
            await _refuse(scope, send, DetailError(503, refusal, kind="unavailable", headers={"Retry-After": "5"}))
            return
        asking = asyncio.ensure_future(_answered(process, scope, body, json.dumps(asdict(principal)), send))
        watching = asyncio.ensure_future(
            process.watch(self._settings.compute_seconds, self._settings.compute_memory_mb)
        )
        why: str | None = None
        refuse = _too_heavy
        try:
            await asyncio.wait({asking, watching}, return_when=asyncio.FIRST_COMPLETED)
            if asking.done():
                asking.result()
            else:
                why = watching.result()
        except (EndedError, httpx.TransportError) as error:
            why, refuse = str(error) or "broke off", _process_ended
        finally:
            watching.cancel()
            if asking.done() and why is None and not asking.cancelled() and asking.exception() is None:
                self._pool.put_back(process)
            else:
                asking.cancel()
                await asyncio.shield(self._pool.discard(process))
        if why is not None:
            log.warning("the process that worked on %s %s %s", scope["method"], scope["path"], why)
            if not send.begun:
                await _refuse(scope, send, refuse(why))


class _Answer:
    """Sends, and knows whether the answer has begun."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self.begun = False

    async def __call__(self, message: Message) -> None:
        self.begun = True
        await self._send(message)


async def _answered(process: ComputeProcess, scope: Scope, body: bytes, principal: str, send: Send) -> None:
    response = await process.ask(scope, body, principal)
    try:
        headers = [(name.lower(), value) for name, value in response.headers.raw if name.lower() not in OWN_HEADERS]
        if (route := response.headers.get(ROUTE_HEADER)) is not None:
            scope["route"] = SimpleNamespace(path=route)  # what metrics and logs call this request
        await send({"type": "http.response.start", "status": response.status_code, "headers": headers})
        async for part in response.aiter_raw():
            await send({"type": "http.response.body", "body": part, "more_body": True})
        await send({"type": "http.response.body", "body": b""})
    finally:
        await response.aclose()


async def _whole_body(receive: Receive) -> bytes | None:
    """The body of a request, limited by the middleware before; None when the client left."""
    parts: list[bytes] = []
    while True:
        message = await receive()
        if message["type"] == "http.disconnect":
            return None
        parts.append(message.get("body", b""))
        if not message.get("more_body", False):
            return b"".join(parts)


async def _departure(receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass


async def _refuse(scope: Scope, send: Send, error: DetailError) -> None:
    async def nothing() -> Message:
        return {"type": "http.disconnect"}

    await detail_response(error)(scope, nothing, send)


def _too_heavy(why: str) -> DetailError:
    """The process was ended at a limit."""
    return DetailError(
        422,
        f"The process that worked on this request {why}. Ask for less; if a forward model of another package is "
        "involved, it may be to blame.",
        kind="too-heavy",
        title="Too heavy",
    )


def _process_ended(why: str) -> DetailError:
    """The process ended by itself."""
    return DetailError(
        422,
        f"The process that worked on this request {why} before it had answered. Code that ends its process (a forward "
        "model, soil law or method of another package) must be mended; without such code, see the server's log.",
        kind="process-ended",
        title="Process ended",
    )


def is_compute(scope: Mapping[str, Any]) -> bool:
    """Whether a request of an ASGI scope calculates.

    >>> is_compute({"type": "http", "method": "GET", "path": "/api/v1/jobs/1f/statistics"})
    True
    >>> is_compute({"type": "http", "method": "GET", "path": "/api/v1/jobs"})
    False
    """
    if scope["type"] != "http":
        return False
    changing = _CHANGES.get(scope["method"])
    return _ALWAYS.fullmatch(scope["path"]) is not None or (
        changing is not None and changing.fullmatch(scope["path"]) is not None
    )


def job_of(path: str) -> str | None:
    """The job that a request is about."""
    found = _JOB.match(path)
    return None if found is None else found[1]
