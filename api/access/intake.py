"""Takes in the bodies of requests: every route gets its own complete, of limited size and after a limited time.

What has arrived of a body counts against budgets until its request is answered, and lies in a temporary file once it is
larger than a few numbers of a form.
"""

from __future__ import annotations

import asyncio
import contextlib
import re
from collections.abc import Iterator
from tempfile import SpooledTemporaryFile

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from geoswarm.api.access.limits import Shares
from geoswarm.api.errors import DetailError, detail_response
from geoswarm.api.settings import API_PREFIX, ApiSettings
from geoswarm.workers.access.principal import Principal

__all__ = ["LARGE_BODIES", "SMALL_BODY_BYTES", "Intake"]

LARGE_BODIES = frozenset(
    ("POST", API_PREFIX + path)
    for path in (
        "/jobs",
        "/problems/check",
        "/problems/warm-starts",
        "/problems/read",
        "/problems/tests",
        "/measurements",
        "/measurements/points",
        "/measurements/stages",
        "/measurements/ags",
        "/measurements/ags/problem",
    )
)
"""Requests that carry a problem or measurements."""

LARGE_PATHS = re.compile(rf"{API_PREFIX}/(?:agents/leases/[^/]*/results|jobs/[^/]+/attachments)")
"""The same with an id in their paths: they carry results or a file."""

SMALL_BODY_BYTES = 64_000
"""The most that all other requests may carry."""

MOST_DIGITS = 18
IN_MEMORY_BYTES = 64_000
PIECE_BYTES = 256 * 1024
OPEN_BYTES, OPEN_BYTES_PER_ADDRESS = 16 * 2**20, 2**20
"""Budgets of requests without a key (signing in)."""


class _GoneError(Exception):
    """The client hung up before its body was there."""


class Intake:
    """ASGI middleware that reads the whole body of a request before the application sees the request.

    A route that needs no copy of it in memory finds the file in ``request.state.body``.

    Parameters
    ----------
    settings
        Limits of size, time and bytes in flight.
    """

    def __init__(self, app: ASGIApp, settings: ApiSettings) -> None:
        self._app = app
        self._settings = settings
        largest = settings.max_body_bytes
        self._keyed = Shares(max(settings.body_bytes, largest), max(settings.body_bytes_per_key, largest))
        self._open = Shares(OPEN_BYTES, OPEN_BYTES_PER_ADDRESS)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        headers = Headers(scope=scope) if scope["type"] == "http" else Headers()
        if headers.get("content-length", "0") == "0" and "transfer-encoding" not in headers:
            await self._app(scope, receive, send)
            return
        with self._account(scope) as account, SpooledTemporaryFile(max_size=IN_MEMORY_BYTES) as body:
            try:
                await self._take_in(scope, headers, receive, account, body)
            except DetailError as refusal:
                await detail_response(refusal)(scope, receive, send)
            except _GoneError:  # the client has left; pages give up a request when the user types on
                return
            else:
                scope.setdefault("state", {})["body"] = body
                await self._app(scope, _again(body, account.taken, receive), send)

    @contextlib.contextmanager
    def _account(self, scope: Scope) -> Iterator[_Account]:
        principal: Principal | None = scope.get("state", {}).get("principal")
        if principal is not None:
            account = _Account(self._keyed, principal.key_id or "", "this API key")
        else:
            client = scope.get("client")
            account = _Account(self._open, client[0] if client else "", "this address")
        try:
            yield account
        finally:
            account.close()

    async def _take_in(
        self,
        scope: Scope,
        headers: Headers,
        receive: Receive,
        account: _Account,
        body: SpooledTemporaryFile[bytes],
    ) -> None:
        """Read the body to its end; DetailError when it is too large, too slow, or one too many."""
        large = (scope["method"], scope["path"]) in LARGE_BODIES or LARGE_PATHS.fullmatch(scope["path"])
        limit = self._settings.max_body_bytes if large else min(SMALL_BODY_BYTES, self._settings.max_body_bytes)
        declared = headers.get("content-length", "")
        if declared.isdecimal():
            if len(declared) > MOST_DIGITS or int(declared) > limit:
                raise _too_large(limit)
            if large:  # told before it is sent, not in the middle
                account.take(int(declared))
        arrived = 0
        try:
            async with asyncio.timeout(self._settings.body_seconds):
                more = True
                while more:
                    message = await receive()
                    if message["type"] == "http.disconnect":
                        raise _GoneError
                    piece = message.get("body", b"")
                    more = message.get("more_body", False)
                    arrived += len(piece)
                    if arrived > limit:
                        raise _too_large(limit)
                    account.take(max(0, arrived - account.taken))
                    body.write(piece)
        except TimeoutError:
            raise DetailError(408, f"The body did not arrive within {self._settings.body_seconds:g} s.") from None
        except OSError as error:
            raise DetailError(
                503,
                f"The body cannot be kept in a temporary file: {error.strerror or error}.",
                kind="unavailable",
                headers={"Retry-After": "5"},
            ) from None
        account.settle(arrived)
        body.seek(0)


class _Account:
    """What one request holds of a budget."""

    def __init__(self, shares: Shares, client: str, whose: str) -> None:
        self.taken = 0
        self._shares = shares
        self._client = client
        self._whose = whose

    def take(self, amount: int) -> None:
        """Take some more bytes; DetailError when they are not there."""
        hindered = self._shares.take(self._client, amount)
        if hindered == "each":
            raise DetailError(
                429,
                f"Requests of {self._whose} that are not answered yet hold {self._shares.held(self._client)} bytes of "
                f"at most {self._shares.each}; send this one when they are answered.",
                kind="rate-limited",
                headers={"Retry-After": "2"},
            )
        if hindered == "in_all":
            raise DetailError(
                503,
                f"Requests that are not answered yet hold {self._shares.taken} bytes of at most {self._shares.in_all}; "
                "send this one again in a moment.",
                kind="unavailable",
                headers={"Retry-After": "5"},
            )
        self.taken += amount

    def settle(self, amount: int) -> None:
        """Give back what was declared and did not come."""
        self._shares.give_back(self._client, self.taken - amount)
        self.taken = amount

    def close(self) -> None:
        """Give back everything."""
        self.settle(0)


def _too_large(limit: int) -> DetailError:
    return DetailError(413, f"The body is larger than {limit} bytes, the maximum here.")


def _again(body: SpooledTemporaryFile[bytes], size: int, receive: Receive) -> Receive:
    """Hand out a body that was taken in, then what the server says."""
    handed = 0
    over = False

    async def hand_out() -> Message:
        nonlocal handed, over
        if over:
            return await receive()
        piece = body.read(PIECE_BYTES)
        handed += len(piece)
        over = handed >= size
        return {"type": "http.request", "body": piece, "more_body": not over}

    return hand_out
