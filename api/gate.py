"""The door of the service: host and origin checks, the API key, and security headers on every answer."""

from __future__ import annotations

import base64
import binascii
import hmac
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from api.errors import DetailError, detail_response
from api.headers import add_security_headers
from api.settings import LOOPBACK_HOSTS, ApiSettings

__all__ = ["Gate"]

OPEN_PREFIXES = ("/health/", "/static/")
OPEN_PATHS = frozenset({"/openapi.json"})
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})


class Gate:
    """ASGI middleware that lets only admissible requests in.

    - Without an API key the ``Host`` header must be a loopback name (or an allowed one): a page on the internet
      cannot make the user's browser talk to the service under its own name.
    - A changing request that a browser sends from another origin is refused: passwords that the browser remembers
      and a service without a key must not be usable from foreign pages.
    - With an API key, everything except health, static files and /openapi.json asks for it: ``Authorization: Bearer
      KEY``, ``X-API-Key: KEY``, or, for browsers, HTTP Basic with the key as the password.
    """

    def __init__(self, app: ASGIApp, settings: ApiSettings) -> None:
        self._app = app
        self._key = settings.api_key.get_secret_value().encode() if settings.api_key else None
        self._hosts = LOOPBACK_HOSTS | settings.allowed_hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                add_security_headers(MutableHeaders(scope=message), scope["path"])
            await send(message)

        refusal = self._refusal(scope["method"], scope["path"], Headers(scope=scope))
        if refusal is not None:
            await detail_response(refusal)(scope, receive, send_with_headers)
            return
        await self._app(scope, receive, send_with_headers)

    def _refusal(self, method: str, path: str, headers: Headers) -> DetailError | None:
        host = headers.get("host", "")
        if self._key is None and _host_name(host) not in self._hosts:
            return DetailError(
                403,
                f"Host {host!r} is not answered without an API key; accepted: {', '.join(sorted(self._hosts))}.",
                kind="host-refused",
                title="Host refused",
            )
        origin = headers.get("origin")
        if method not in SAFE_METHODS and origin is not None and not _same_origin(origin, host):
            return DetailError(
                403,
                f"A page of {origin!r} may not change anything here; only pages of this service may.",
                kind="origin-refused",
                title="Origin refused",
            )
        if self._key is None or path in OPEN_PATHS or path.startswith(OPEN_PREFIXES):
            return None
        given = _given_key(headers)
        if given is not None and hmac.compare_digest(given, self._key):
            return None
        detail = "This API key is not valid." if given is not None else "An API key is needed."
        challenge = 'Bearer realm="geoswarm"' if path.startswith("/api/") else 'Basic realm="geoswarm", charset="UTF-8"'
        return DetailError(
            401,
            f"{detail} Send it as 'Authorization: Bearer KEY' or 'X-API-Key: KEY'.",
            kind="unauthorized",
            headers={"WWW-Authenticate": challenge},
        )


def _host_name(host: str) -> str:
    """Host header without its port, lower case."""
    name, colon, port = host.rpartition(":")
    return (name if colon and port.isdigit() else host).lower()


def _same_origin(origin: str, host: str) -> bool:
    try:
        return urlsplit(origin).netloc.lower() == host.lower()
    except ValueError:  # brackets that do not match
        return False


def _given_key(headers: Headers) -> bytes | None:
    key = headers.get("x-api-key")
    if key is not None:
        return key.encode()
    scheme, _, credentials = headers.get("authorization", "").partition(" ")
    if scheme.lower() == "bearer":
        return credentials.strip().encode()
    if scheme.lower() == "basic":
        try:
            return base64.b64decode(credentials, validate=True).partition(b":")[2]
        except (binascii.Error, ValueError):
            return b""
    return None
