"""The gate of the service: host and origin checks, authentication, permissions, security headers on every answer."""

from __future__ import annotations

import sys
from urllib.parse import quote, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from geoswarm.api.access.authentication import Authenticator, Identity, given_key
from geoswarm.api.access.limits import Shares
from geoswarm.api.errors import DetailError, detail_response, role_refused, translate
from geoswarm.api.headers import add_security_headers
from geoswarm.api.settings import LOOPBACK_HOSTS, ApiSettings
from geoswarm.workers.errors import StoreUnavailableError

__all__ = ["SIGN_IN", "Gate"]

OPEN_PREFIXES = ("/health/", "/static/", "/help/")
OPEN_PATHS = frozenset({"/openapi.json", "/sign-in", "/help"})
SIGN_IN = ("POST", "/api/v1/session")
FOR_PROGRAMS = ("/api/", "/metrics", "//")  # answered with 401, not sent to the page for signing in
AGENTS = "/api/v1/agents/"
"""Routes of agents, and all that a key of theirs opens."""
AGENT_REQUESTS_AT_ONCE = 4000  # of one key: each agent that waits for work has one
OWN_HEADER = "x-requested-with"
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})


class _OutsideLinkError(DetailError):
    """A read-only link does not show what was asked for."""

    def __init__(self, job_id: str) -> None:
        self.page = f"/jobs/{job_id}"
        detail = f"This link shows one job and nothing else: {self.page}."
        super().__init__(403, detail, kind="link-refused", title="Not shown by this link")


class Gate:
    """ASGI middleware that admits only permitted requests, and passes their sender on to the application.

    - Without API keys the ``Host`` header must be a loopback name (or an allowed one): a page on the internet cannot
      make the user's browser talk to the service under its own name.
    - A changing request that a browser sends from another origin is refused: passwords that the browser remembers
      and a service without a key must not be usable from foreign pages.
    - With API keys, everything except health, static files, the documentation and /openapi.json asks for one:
      ``Authorization: Bearer KEY``, ``X-API-Key: KEY``, or, for browsers, HTTP Basic with the key as the password.
    - Pages send a browser that has not signed in to ``/sign-in``, and the visitor of a link back to its job.
    - The session of a browser is a cookie, so what changes something needs a header of our own beside it, which foreign
      pages cannot set.
    - What changes something, or makes the service calculate, needs the role ``submit``.
    - A key of role ``agent`` opens the routes of agents, and nothing else that asks for a key.
    - The key of a read-only link opens the pages and results of its job, and nothing else that asks for a key.

    The principal is in ``request.state.principal``, the complete identity in ``request.state.identity``.
    """

    def __init__(self, app: ASGIApp, settings: ApiSettings, authenticator: Authenticator) -> None:
        self._app = app
        self._hosts = LOOPBACK_HOSTS | settings.allowed_hosts
        self._authenticator = authenticator
        self._unanswered = Shares(sys.maxsize, settings.requests_at_once)
        self._agents = Shares(sys.maxsize, AGENT_REQUESTS_AT_ONCE)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                add_security_headers(MutableHeaders(scope=message))
            await send(message)

        try:
            identity = await self._admit(scope, Headers(scope=scope))
        except (DetailError, StoreUnavailableError) as refusal:
            response: Response = detail_response(translate(refusal))
            if (address := _page_instead(scope, refusal)) is not None:
                response = RedirectResponse(address, status_code=303)
            await response(scope, receive, send_with_headers)
            return
        if identity is None:
            await self._app(scope, receive, send_with_headers)
            return
        scope.setdefault("state", {}).update(principal=identity.principal, identity=identity)
        key = identity.principal.key_id or ""
        unanswered = self._agents if identity.principal.role == "agent" else self._unanswered
        if unanswered.take(key) is not None:
            await detail_response(_too_many(unanswered.each))(scope, receive, send_with_headers)
            return
        try:
            await self._app(scope, receive, send_with_headers)
        finally:
            unanswered.give_back(key)

    async def _admit(self, scope: Scope, headers: Headers) -> Identity | None:
        """Return the sender, None for what everybody may see; raise DetailError for what is refused."""
        method, path = scope["method"], scope["path"]
        host = headers.get("host", "")
        if not self._authenticator.needed and _host_name(host) not in self._hosts:
            raise DetailError(
                403,
                f"Host {host!r} needs an API key; accepted without one: {', '.join(sorted(self._hosts))}.",
                kind="host-refused",
                title="Host refused",
            )
        origin = headers.get("origin")
        if method not in SAFE_METHODS and origin is not None and not _same_origin(origin, host):
            raise DetailError(
                403,
                f"A page of {origin!r} may not change anything here; only pages of this service may.",
                kind="origin-refused",
                title="Origin refused",
            )
        if path in OPEN_PATHS or path.startswith(OPEN_PREFIXES) or (method, path) == SIGN_IN:
            return None
        challenge = 'Bearer realm="geoswarm"' if path.startswith("/api/") else 'Basic realm="geoswarm", charset="UTF-8"'
        client = scope.get("client")
        identity = await self._authenticator.identify(headers, client[0] if client else "", challenge)
        if (job_id := identity.principal.job_id) is not None and not _of_job(job_id, path):
            raise _OutsideLinkError(job_id)
        if (wants := _role_wanted(identity, method, path)) is not None:
            raise role_refused(identity.principal.role, f"{method} {path[:80]} needs {wants}")
        if method in SAFE_METHODS:
            return identity
        if identity.session is not None and not headers.get(OWN_HEADER):
            raise DetailError(
                403,
                f"{method} with a session needs the header X-Requested-With (any value), which only own pages send.",
                kind="origin-refused",
                title="Origin refused",
            )
        return identity


def _of_job(job_id: str, path: str) -> bool:
    """Whether a path belongs to a job, or to the session that shows it."""
    pages = f"/jobs/{job_id}"
    return path == SIGN_IN[1] or any(path == root or path.startswith(f"{root}/") for root in (pages, f"/api/v1{pages}"))


def _role_wanted(identity: Identity, method: str, path: str) -> str | None:
    """Return the roles that a request needs, where its sender has none of them."""
    principal = identity.principal
    if path.startswith(AGENTS):
        return None if principal.may("agent") else "'agent' or 'admin'"
    if principal.role == "agent":
        return "'read', 'submit' or 'admin'" if method in SAFE_METHODS else "'submit' or 'admin'"
    if method in SAFE_METHODS or path == SIGN_IN[1]:  # every session may sign out
        return None
    return None if principal.may("submit") else "'submit' or 'admin'"


def _page_instead(scope: Scope, refusal: Exception) -> str | None:
    """Return the address of the page that a browser is sent to instead of one that was refused; None: of none."""
    wants_page = scope["method"] in ("GET", "HEAD") and not scope["path"].startswith(FOR_PROGRAMS)
    if not wants_page or given_key(Headers(scope=scope)) is not None or not isinstance(refusal, DetailError):
        return None
    if isinstance(refusal, _OutsideLinkError):
        return refusal.page
    return f"/sign-in?next={quote(_asked(scope), safe='/')}" if refusal.status == 401 else None


def _too_many(most: int) -> DetailError:
    return DetailError(
        429,
        f"This API key has {most} requests in progress, the maximum at a time.",
        kind="rate-limited",
        headers={"Retry-After": "1"},
    )


def _asked(scope: Scope) -> str:
    query = scope.get("query_string", b"").decode("latin-1")
    return f"{scope['path']}?{query}" if query else str(scope["path"])


def _host_name(host: str) -> str:
    """Host header without its port, lower case."""
    name, colon, port = host.rpartition(":")
    return (name if colon and port.isdigit() else host).lower()


def _same_origin(origin: str, host: str) -> bool:
    try:
        return urlsplit(origin).netloc.lower() == host.lower()
    except ValueError:  # brackets that do not match
        return False
