"""Authentication of a request: by the API key in its headers or the session of a browser."""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
from dataclasses import dataclass

import anyio.to_thread
from cachetools import LRUCache
from starlette.datastructures import Headers

from geoswarm.api.access.limits import RateLimiter
from geoswarm.api.errors import DetailError
from geoswarm.api.settings import ApiSettings
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.access.principal import LOCAL, Principal
from geoswarm.workers.access.sessions import SessionView, SignInSessions
from geoswarm.workers.service.job_service import JobService

__all__ = ["SESSION_COOKIE", "Authenticator", "Identity", "given_key", "given_token"]

SESSION_COOKIE = "geoswarm_session"

BOOTSTRAP = Principal(None, "admin", "environment")
"""Bearer of the key that the environment gives: the first administrator, which owns no jobs and sees all."""

FAILURES_PER_SECOND = 0.5
FAILURE_BURST = 20
SIGN_INS_PER_SECOND = 0.1
SIGN_IN_BURST = 30
TRUSTED_KEYS = 10_000
LONG_KEY = 32  # characters; longer keys cannot be guessed


@dataclass(frozen=True, slots=True)
class Identity:
    """Sender of a request; ``session`` is the one of a browser, None with a key or where none is needed."""

    principal: Principal
    session: SessionView | None = None


class Authenticator:
    """Authenticates requests.

    Parameters
    ----------
    settings
        Whether a key is needed from the beginning, and the one of the environment.
    service
        Its store holds the other keys.
    """

    def __init__(self, settings: ApiSettings, service: JobService) -> None:
        self.needed = settings.needs_key
        self._static = settings.api_key.get_secret_value().encode() if settings.api_key else None
        self._service = service
        self._requests = RateLimiter(settings.requests_per_second, settings.request_burst)
        self._failures = RateLimiter(FAILURES_PER_SECOND, FAILURE_BURST)
        self._agents = RateLimiter(settings.agent_requests_per_second, int(2 * settings.agent_requests_per_second) + 1)
        self._sign_ins = RateLimiter(SIGN_INS_PER_SECOND, SIGN_IN_BURST)
        self._seen: LRUCache[bytes, None] = LRUCache(TRUSTED_KEYS)  # hashes of long keys that were valid here

    async def asks(self) -> bool:
        """Whether a key is needed now; from the moment when the first one is made, by whatever process.

        Raises
        ------
        StoreUnavailableError
            When it cannot be known whether there are keys.
        """
        return self.needed or await anyio.to_thread.run_sync(self.asks_here)

    def asks_here(self) -> bool:
        """Do what :meth:`asks` does, in this thread."""
        self.needed = self.needed or ApiKeys(self._service.store).used()  # revoking a key does not open the door again
        return self.needed

    @property
    def sessions(self) -> SignInSessions:
        """Sessions of browsers that have signed in with a key."""
        return SignInSessions(self._service.store, None if self._static is None else (self._static, BOOTSTRAP))

    async def identify(self, headers: Headers, address: str, challenge: str) -> Identity:
        """Return the sender of a request; a key in its headers takes precedence over a session.

        Raises
        ------
        DetailError
            401 without a valid key or session, 429 when there were too many requests.
        StoreUnavailableError
            When keys cannot be looked up.
        """
        if not await self.asks():
            return Identity(LOCAL)
        key, token = given_key(headers), given_token(headers)
        if key is None and token is not None:
            session = await anyio.to_thread.run_sync(self.sessions.find, token)
            if session is None:
                raise unauthorized("This session has ended; an API key is needed.", challenge)
            found = Identity(session.principal, session)
        elif key is None:
            raise unauthorized("An API key is needed.", challenge)
        else:
            found = Identity(await self.holder(key, address, challenge))
        self._meter(found.principal)
        return found

    async def admits(self, headers: Headers) -> bool:
        """Whether the sender of an earlier request is still admitted: the key is valid, the session goes on.

        Raises
        ------
        StoreUnavailableError
            When it cannot be looked up.
        """
        if not await self.asks():
            return True
        key, token = given_key(headers), given_token(headers)
        if key is not None:
            return await self._find(key) is not None
        return token is not None and await anyio.to_thread.run_sync(self.sessions.find, token) is not None

    async def holder(self, key: bytes, address: str, challenge: str) -> Principal:
        """Return the holder of a key; guessing is slowed down.

        From an address with too many wrong keys no key is judged any more, unless it is a long one that was valid here
        before: neighbours behind the same address go on.

        Raises
        ------
        DetailError, StoreUnavailableError
        """
        fingerprint = hashlib.sha256(key).digest()
        if fingerprint not in self._seen and (wait := self._failures.wait(address)) is not None:
            raise _too_many(wait)
        found = await self._find(key)
        if found is None:
            self._seen.pop(fingerprint, None)
            self._failures.take(address)
            raise unauthorized("This API key is not valid, has expired or was revoked.", challenge)
        if len(key) >= LONG_KEY:
            self._seen[fingerprint] = None
        return found

    async def sign_in(self, key: bytes, address: str, challenge: str) -> Principal:
        """Do what :meth:`holder` does, at a sign-in: with a limited rate, as each session is a row in the database.

        Raises
        ------
        DetailError, StoreUnavailableError
        """
        principal = await self.holder(key, address, challenge)
        self._meter(principal)
        wait = self._sign_ins.take(principal.key_id or "")
        if wait is not None:
            raise _too_many(wait)
        return principal

    def _meter(self, principal: Principal) -> None:
        limiter = self._agents if principal.role == "agent" else self._requests
        wait = limiter.take(principal.key_id or "")
        if wait is not None:
            raise _too_many(wait)

    async def _find(self, given: bytes) -> Principal | None:
        if self._static is not None and hmac.compare_digest(given, self._static):
            return BOOTSTRAP
        try:
            text = given.decode("ascii")
        except UnicodeDecodeError:
            return None
        return await anyio.to_thread.run_sync(self._look_up, text)

    def _look_up(self, key: str) -> Principal | None:
        return ApiKeys(self._service.store).principal(key)


def unauthorized(reason: str, challenge: str) -> DetailError:
    """The answer to unauthenticated requests."""
    return DetailError(
        401,
        f"{reason} Send it as 'Authorization: Bearer KEY' or 'X-API-Key: KEY'; browsers sign in at /sign-in.",
        kind="unauthorized",
        headers={"WWW-Authenticate": challenge},
    )


def _too_many(wait: int) -> DetailError:
    return DetailError(
        429,
        f"Too many requests; try again in {wait} s.",
        kind="rate-limited",
        headers={"Retry-After": str(wait)},
    )


def given_key(headers: Headers) -> bytes | None:
    """Return the key that a request brings, None when it brings none."""
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


def given_token(headers: Headers) -> str | None:
    """Return the token of the session that a browser brings, None when it brings none."""
    for pair in headers.get("cookie", "").split(";"):  # http.cookies takes the square of the length in some versions
        name, equals, value = pair.partition("=")
        if equals and name.strip() == SESSION_COOKIE:
            return value.strip().strip('"')
    return None
