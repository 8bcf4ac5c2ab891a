"""An agent's side of the routes ``/api/v1/agents``."""

from __future__ import annotations

import math
import random
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import httpx

from geoswarm.agent.errors import (
    KeyRefusedError,
    LeaseEndedError,
    RejectedError,
    UnknownError,
    UnreachableError,
)
from geoswarm.solver.registered.signed import MOST_BYTES

__all__ = ["Backoff", "Lease", "Patience", "Run", "Server", "Terms"]

CONNECT_SECONDS, ANSWER_SECONDS = 10.0, 60.0
WAIT_SECONDS = 50.0  # where the service does not say: proxies end what takes a minute
SPARE_SECONDS = 30.0  # beyond what the service was asked to wait
BUSY = frozenset({408, 425, 429, 500, 502, 503, 504})
QUOTA_SECONDS = 10.0
LONGEST_TOLD = 300
PIECE = 256 * 1024


@dataclass(frozen=True, slots=True)
class Terms:
    """How often to beat, how long a lease lasts without, what this agent is given, how long to wait for work."""

    heartbeat_seconds: float
    lease_seconds: float
    accepted: tuple[str, ...]
    wait_seconds: float = WAIT_SECONDS


@dataclass(frozen=True, slots=True)
class Run:
    """One run to make: values of all parameters by name."""

    particle: int
    attempt: int
    values: Mapping[str, float]
    refused: bool


@dataclass(frozen=True, slots=True)
class Lease:
    """What a slot is to do; ``shared`` is None where the agent knows the frame."""

    id: str
    job: str
    frame: str
    shared: Mapping[str, Any] | None
    runs: Sequence[Run]


class Server:
    """The service, for several threads.

    Every method may raise :class:`geoswarm.agent.errors.UnreachableError` and
    :class:`geoswarm.agent.errors.KeyRefusedError`.

    Parameters
    ----------
    url
        Its address, for example ``https://calibration.example.org``.
    key
        API key of role ``agent``; None for a service that asks for none.
    """

    def __init__(self, url: str, key: str | None, *, transport: httpx.BaseTransport | None = None) -> None:
        headers = {"User-Agent": "geoswarm-agent"} | ({} if key is None else {"Authorization": f"Bearer {key}"})
        self._http = httpx.Client(
            base_url=f"{url.rstrip('/')}/api/v1/agents",
            headers=headers,
            timeout=httpx.Timeout(ANSWER_SECONDS, connect=CONNECT_SECONDS),
            limits=httpx.Limits(max_connections=None, max_keepalive_connections=20, keepalive_expiry=4.0),
            transport=transport,
        )

    def announce(self, agent: Mapping[str, Any]) -> Terms:
        """Tell the service of this agent and what it runs."""
        found = self._ask("PUT", "/models", agent)
        waits = float(found.get("wait_seconds", WAIT_SECONDS))
        return Terms(float(found["heartbeat_seconds"]), float(found["lease_seconds"]), tuple(found["accepted"]), waits)

    def sign_off(self, agent: str) -> None:
        """Tell the service that this agent ends."""
        self._ask("DELETE", f"/{agent}", None)

    def lease(self, wanted: Mapping[str, Any]) -> Lease | None:
        """Request a lease, and wait for it.

        Raises
        ------
        UnknownError
        """
        found = self._ask("POST", "/leases", wanted, wanted["wait"] + SPARE_SECONDS)
        return _lease(found["lease"])

    def beat(self, lease_id: str) -> None:
        """Keep a lease.

        Raises
        ------
        LeaseEndedError
            It is not wanted any more.
        """
        self._ask("POST", f"/leases/{lease_id}/beat", {})

    def submit(self, lease_id: str, brought: Mapping[str, Any]) -> Lease | None:
        """Bring what came of a lease; return the next one, if it was asked for and there is one.

        Raises
        ------
        LeaseEndedError
            It ended long ago, or its job is gone.
        RejectedError
        """
        return _lease(self._ask("POST", f"/leases/{lease_id}/results", brought)["lease"])

    def signed_models(self) -> bytes:
        """Return the signed list of models that the service hands out, as it sends it.

        Raises
        ------
        RejectedError
            It hands out none, or cannot now.
        """
        return b"".join(self._read("/models", MOST_BYTES))

    def model_file(self, sha256: str) -> Iterator[bytes]:
        """Give a file of one of these models, piece by piece.

        Raises
        ------
        RejectedError
        """
        return self._read(f"/models/files/{sha256}", None)

    def close(self) -> None:
        """Close all connections."""
        self._http.close()

    def _read(self, path: str, most: int | None) -> Iterator[bytes]:
        """Give what the service answers, a byte more than ``most`` at the utmost."""
        size = 0
        try:
            with self._http.stream("GET", path, headers={"Accept-Encoding": "identity"}) as answer:
                if not answer.is_success:
                    answer.read()
                    raise _error(answer)
                for piece in answer.iter_raw(PIECE):
                    size += len(piece)
                    yield piece
                    if most is not None and size > most:
                        return
        except (httpx.TransportError, RuntimeError) as error:
            raise UnreachableError(f"{type(error).__name__}: {error}") from None

    def _ask(self, method: str, path: str, body: Mapping[str, Any] | None, seconds: float | None = None) -> Any:
        timeout = httpx.USE_CLIENT_DEFAULT if seconds is None else httpx.Timeout(seconds, connect=CONNECT_SECONDS)
        try:
            answer = self._http.request(method, path, json=body, timeout=timeout)
        except (httpx.TransportError, RuntimeError) as error:  # RuntimeError: this agent has closed it
            raise UnreachableError(f"{type(error).__name__}: {error}") from None
        if answer.status_code == httpx.codes.NO_CONTENT:
            return None
        if answer.is_success:
            try:
                return answer.json()
            except ValueError:
                raise UnreachableError("the address does not answer as a geoswarm service") from None
        raise _error(answer)


def _error(answer: httpx.Response) -> Exception:
    kind, told = "", answer.reason_phrase
    try:
        problem = answer.json()
        kind, told = str(problem["type"]).rpartition(":")[2], str(problem["detail"])
    except (ValueError, KeyError, TypeError):
        pass  # a proxy in between
    told, status = told[:LONGEST_TOLD], answer.status_code
    if status == httpx.codes.GONE:
        return LeaseEndedError(told)
    if kind == "quota-exceeded":
        return UnreachableError(told, QUOTA_SECONDS)
    if kind == "unknown-agent":
        return UnknownError(told)
    if status == httpx.codes.UNAUTHORIZED or kind in ("role-refused", "host-refused"):
        return KeyRefusedError(told)
    if status == httpx.codes.REQUEST_ENTITY_TOO_LARGE:  # also by a proxy in between
        return RejectedError(f"{status}: {told}")
    if status in BUSY or not kind:
        return UnreachableError(f"{status}: {told}", _seconds(answer.headers.get("retry-after")))
    return RejectedError(f"{status}: {told}")


def _seconds(text: str | None) -> float:
    try:
        return min(max(float(text or 0.0), 0.0), 60.0)
    except ValueError:
        return 0.0


def _lease(found: Mapping[str, Any] | None) -> Lease | None:
    if found is None:
        return None
    runs = [Run(run["particle"], run["attempt"], run["values"], run["refused"]) for run in found["runs"]]
    return Lease(found["id"], found["job"], found["frame"], found["shared"], runs)


FIRST_SECONDS, LONGEST_SECONDS = 0.5, 30.0


class Backoff:
    """Waits that double up to half a minute, each by chance half as long at least: a crowd does not come at once.

    >>> waits = Backoff()
    >>> 0.25 <= waits.next() <= 0.5
    True
    >>> 0.5 <= waits.next() <= 1.0
    True
    >>> waits.next(at_least=7.0) >= 7.0
    True
    """

    def __init__(self) -> None:
        self._longest = FIRST_SECONDS
        self._chance = random.SystemRandom()

    def next(self, at_least: float = 0.0) -> float:
        """Return the next wait [s]."""
        wait = self._longest * self._chance.uniform(0.5, 1.0)
        self._longest = min(2.0 * self._longest, LONGEST_SECONDS)
        return max(wait, at_least * self._chance.uniform(1.0, 1.2))


LONGEST_WAIT_SECONDS, UNTRIED_SECONDS = 300.0, 3600.0


class Patience:
    """How long a request for work may wait: twice as long each time that there was none, up to five minutes.

    The fewer requests, the less idle agents cost the service. A proxy in between may break off what takes long: then
    half as long is waited, and for an hour nothing longer is tried.

    >>> patience = Patience()
    >>> patience.answered(50.0, after=50.0)
    >>> patience.seconds(50.0)
    100.0
    >>> patience.broken_off(50.0, after=60.0)
    >>> patience.answered(50.0, after=50.0)
    >>> patience.seconds(50.0)
    50.0
    """

    def __init__(self) -> None:
        self._factor = 1.0
        self._untried_until = -math.inf

    def seconds(self, usual: float) -> float:
        """Return how long to wait, where the service names a wait that proxies usually let through [s]."""
        return min(self._factor * usual, max(LONGEST_WAIT_SECONDS, usual))

    def answered(self, usual: float, *, after: float) -> None:
        """Note that the service has answered after a time [s] that there is no work."""
        longest = self.seconds(usual)
        if longest <= after and longest < LONGEST_WAIT_SECONDS and time.monotonic() >= self._untried_until:
            self._factor *= 2.0

    def broken_off(self, usual: float, *, after: float) -> None:
        """Note that a request was broken off after a time [s]; the wait is to blame if it was longer than usual."""
        if after > usual:
            self._factor = max(self._factor / 2.0, 1.0)
            self._untried_until = time.monotonic() + UNTRIED_SECONDS
