"""Who sends a request: the API key in its headers, and whose it is."""

from __future__ import annotations

import base64
import binascii
import hmac

import anyio.to_thread
from starlette.datastructures import Headers

from api.errors import DetailError
from api.limits import RateLimiter
from api.settings import ApiSettings
from workers.access import LOCAL, Principal
from workers.keys import KeyRing
from workers.service import JobService

__all__ = ["Authenticator"]

BOOTSTRAP = Principal(None, "admin", "environment")
"""Bearer of the key that the environment gives: the first administrator, who owns no jobs and sees all."""

FAILURES_PER_SECOND = 0.5
FAILURE_BURST = 20


class Authenticator:
    """Finds out who sends a request.

    Parameters
    ----------
    settings
        Whether a key is needed at all, and the one of the environment.
    service
        Its store holds the other keys.
    """

    def __init__(self, settings: ApiSettings, service: JobService) -> None:
        self._needed = settings.needs_key
        self._static = settings.api_key.get_secret_value().encode() if settings.api_key else None
        self._service = service
        self._requests = RateLimiter(settings.requests_per_second, settings.request_burst)
        self._failures = RateLimiter(FAILURES_PER_SECOND, FAILURE_BURST)

    async def principal(self, headers: Headers, address: str, challenge: str) -> Principal:
        """Return who sends a request.

        Raises
        ------
        DetailError
            401 without a valid key, 429 when there were too many requests.
        StoreUnavailableError
            When keys cannot be looked up.
        """
        if not self._needed:
            return LOCAL
        given = given_key(headers)
        found = None if given is None else await self._find(given)
        if found is None:
            wait = None if given is None else self._failures.take(address)
            raise self._unauthorized(given, challenge) if wait is None else _too_many(wait)
        wait = self._requests.take(found.key_id or "")
        if wait is not None:
            raise _too_many(wait)
        return found

    async def _find(self, given: bytes) -> Principal | None:
        if self._static is not None and hmac.compare_digest(given, self._static):
            return BOOTSTRAP
        try:
            text = given.decode("ascii")
        except UnicodeDecodeError:
            return None
        return await anyio.to_thread.run_sync(self._look_up, text)

    def _look_up(self, key: str) -> Principal | None:
        return KeyRing(self._service.store).principal(key)

    @staticmethod
    def _unauthorized(given: bytes | None, challenge: str) -> DetailError:
        detail = "An API key is needed." if given is None else "This API key is not valid, or no longer."
        return DetailError(
            401,
            f"{detail} Send it as 'Authorization: Bearer KEY' or 'X-API-Key: KEY'.",
            kind="unauthorized",
            headers={"WWW-Authenticate": challenge},
        )


def _too_many(wait: int) -> DetailError:
    return DetailError(
        429,
        f"Too many requests; come again in {wait} s.",
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
