"""Models behind the UM-Bridge protocol 1.0, the client's side: requests with limits and further tries, and answers."""

from __future__ import annotations

import http.client
import json
import math
import re
import socket
import ssl
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, get_args
from urllib.parse import urlsplit

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import FailureReason
from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.words import did_you_mean

__all__ = ["LARGEST", "PROTOCOL", "Server", "address_of", "checked_info", "checked_sizes", "vectors"]


def checked_info(answer: Any, name: str, url: str) -> None:
    """Look at the answer to ``/Info``.

    Raises
    ------
    RunFailedError
        ``bad_output``: another version of the protocol, or no model of that name.
    """
    version = answer.get("protocolVersion") if isinstance(answer, dict) else None
    models = answer.get("models") if isinstance(answer, dict) else None
    if not isinstance(version, int | float) or not abs(version) < 1e6 or not isinstance(models, list):
        raise RunFailedError("bad_output", f"{url} is not an UM-Bridge server: {str(answer)[:100]}")
    if int(version) != int(PROTOCOL):
        raise RunFailedError("bad_output", f"{url} speaks version {version:g} of the protocol, not {PROTOCOL:g}")
    names = [str(one) for one in models]
    if name not in names:
        hint = did_you_mean(name, names)
        raise RunFailedError("bad_output", f"{url} has no model '{name}'{hint}; it has {', '.join(names[:50])}")


def checked_sizes(answer: Any, key: str, url: str) -> list[int]:
    """Sizes of vectors, of the answer to ``/InputSizes`` or ``/OutputSizes``.

    Raises
    ------
    RunFailedError
        ``bad_output``: they are something else.
    """
    found = answer.get(key) if isinstance(answer, dict) else None
    if not isinstance(found, list) or not all(isinstance(one, int) and not isinstance(one, bool) for one in found):
        raise RunFailedError("bad_output", f"{url} answered without {key}: {str(answer)[:100]}")
    return list(found)


def vectors(answer: Any, sizes: Sequence[int], url: str) -> list[FloatArray]:
    """Output vectors, of the answer to ``/Evaluate``; each of its size, all finite.

    Raises
    ------
    RunFailedError
        ``bad_output``: other sizes, or no numbers. ``not_finite``: a number is NaN or infinite.
    """
    output = answer.get("output") if isinstance(answer, dict) else None
    if not isinstance(output, list) or not all(isinstance(one, list) for one in output):
        raise RunFailedError(
            "bad_output", f"{url} answered with an output that is not a list of lists: {str(answer)[:100]}"
        )
    got = [len(one) for one in output]
    if got != list(sizes):
        raise RunFailedError("bad_output", f"{url} answered output vectors of {_list(got)} numbers, not {_list(sizes)}")
    found = []
    for index, one in enumerate(output):
        if any(isinstance(value, bool) or not isinstance(value, int | float | None) for value in one):
            raise RunFailedError("bad_output", f"{url}: output {index} contains what is not a number: {str(one)[:100]}")
        values = np.array([_number(value) for value in one], dtype=np.float64)
        wrong = np.flatnonzero(~np.isfinite(values))
        if wrong.size:
            place = int(wrong[0])
            raise RunFailedError("not_finite", f"{url}: output {index} is {values[place]} at number {place + 1}")
        found.append(values)
    return found


def _number(value: float | None) -> float:
    """NaN for null, which stands for it in some JSON; infinity for whole numbers beyond all floats."""
    try:
        return np.nan if value is None else float(value)
    except OverflowError:
        return np.inf


def _list(sizes: Sequence[int]) -> str:
    return ", ".join(map(str, sizes[:20])) or "none"


PROTOCOL = 1.0

LARGEST = 256 * 2**20
"""Bytes of the largest answer that is read."""

_CONNECT_SECONDS = 10.0
_PIECE = 2**20
_BUSY = (502, 503, 504)
_REASONS = frozenset(get_args(FailureReason))
"""Types of errors that say why: those of ``geoswarm umbridge``."""


def address_of(url: str) -> tuple[str, str, int, str]:
    """Return scheme, host, port and path of a server's address.

    Raises
    ------
    ValueError

    Examples
    --------
    >>> address_of("http://localhost:4242/models/")
    ('http', 'localhost', 4242, '/models')
    """
    accepted = "write for example http://localhost:4242"
    try:
        parts = urlsplit(url.strip())
        port = parts.port
    except ValueError as error:
        raise ValueError(f"'{url[:100]}' is not an address: {error}; {accepted}") from None
    if parts.scheme not in ("http", "https") or not parts.hostname or not url.isprintable():
        raise ValueError(f"'{url[:100]}' is not the address of a server; {accepted}")
    if parts.username or parts.password or parts.query or parts.fragment:
        raise ValueError(f"an address has a host, a port and a path only, no user, password or ?; {accepted}")
    return parts.scheme, parts.hostname, port or (443 if parts.scheme == "https" else 80), parts.path.rstrip("/")


@dataclass(frozen=True, slots=True)
class Server:
    """A server.

    Parameters
    ----------
    url
        Its address.
    seconds
        Wall time of one request; None: any.
    tries
        How often it is called when it cannot be reached or is busy.
    pause
        Between tries [s].
    """

    url: str
    seconds: float | None
    tries: int
    pause: float

    def call(self, route: str, body: Mapping[str, Any] | None = None) -> Any:
        """POST a body, or GET where there is none; return the answer.

        Raises
        ------
        RunFailedError
            ``not_started``: it cannot be reached. ``timeout``. ``program_failed``: an HTTP error, or it hung up.
            ``bad_output``: the answer is no JSON.
        """
        text = None if body is None else json.dumps(body, allow_nan=False).encode()
        for left in range(self.tries - 1, -1, -1):
            try:
                status, answer = self._once(route, text)
            except (OSError, http.client.HTTPException) as error:
                if left:
                    time.sleep(self.pause)
                    continue
                raise self._lost(error) from None
            if status in _BUSY and left:
                time.sleep(self.pause)
                continue
            return self._read(route, status, answer)
        raise AssertionError("at least one try")

    def _once(self, route: str, body: bytes | None) -> tuple[int, bytes]:
        scheme, host, port, path = address_of(self.url)
        deadline = math.inf if self.seconds is None else time.monotonic() + self.seconds
        wait = min(_CONNECT_SECONDS, self.seconds or _CONNECT_SECONDS)
        connection = (
            http.client.HTTPSConnection(host, port, timeout=wait, context=ssl.create_default_context())
            if scheme == "https"
            else http.client.HTTPConnection(host, port, timeout=wait)
        )
        try:
            try:
                connection.connect()
            except TimeoutError:
                raise OSError(f"no answer in {wait:g} s") from None
            channel = connection.sock
            try:
                _limit(channel, deadline)
                headers = {"Content-Type": "application/json", "Accept": "application/json", "Connection": "close"}
                connection.request("GET" if body is None else "POST", f"{path}{route}", body, headers)
                response = connection.getresponse()
                told = response.length
                pieces: list[bytes] = []
                size = 0
                while size <= LARGEST:
                    _limit(channel, deadline)
                    piece = response.read1(_PIECE)
                    if not piece:
                        if told is not None and size < told:
                            raise http.client.IncompleteRead(b"", told - size)
                        return response.status, b"".join(pieces)
                    pieces.append(piece)
                    size += len(piece)
            except TimeoutError:
                if self.seconds is None:  # the system has given up the connection
                    raise ConnectionAbortedError("the connection has timed out") from None
                raise RunFailedError("timeout", f"{self.url}{route} has not answered in {self.seconds:g} s") from None
            raise RunFailedError("bad_output", f"{self.url}{route} answered more than {LARGEST // 2**20} MB")
        finally:
            connection.close()

    def _lost(self, error: OSError | http.client.HTTPException) -> RunFailedError:
        if isinstance(error, ConnectionRefusedError | socket.gaierror) or (
            isinstance(error, OSError) and not isinstance(error, ConnectionError | http.client.HTTPException)
        ):
            tried = f" ({self.tries} tries)" if self.tries > 1 else ""
            why = getattr(error, "strerror", None) or str(error)
            return RunFailedError("not_started", f"{self.url} cannot be reached: {why}{tried}; is the server running?")
        return RunFailedError("program_failed", f"{self.url} closed the connection: {type(error).__name__}: {error}")

    def _read(self, route: str, status: int, answer: bytes) -> Any:
        text = answer.decode("utf-8", errors="replace")
        try:
            found = json.loads(_numbers(text))
        except (ValueError, RecursionError):
            found = None
        told = found.get("error") if isinstance(found, dict) else None
        if isinstance(told, dict) or status != 200:
            kind = str(told.get("type", "")) if isinstance(told, dict) else ""
            message = str(told.get("message", "")) if isinstance(told, dict) else " ".join(text.split())
            words = ": ".join(part[:500] for part in (kind, message) if part) or "no word why"
            reason = kind if kind in _REASONS else "program_failed"
            raise RunFailedError(reason, f"{self.url}{route} answered with HTTP {status}: {words}")
        if found is None:
            raise RunFailedError("bad_output", f"{self.url}{route} did not answer with JSON: '{text[:100]}'")
        return found


def _limit(channel: socket.socket | None, deadline: float) -> None:
    """Let the next wait for the socket end at the deadline."""
    if channel is None or channel.fileno() < 0:
        return
    left = deadline - time.monotonic()
    if left <= 0.0:
        raise TimeoutError
    channel.settimeout(None if math.isinf(left) else left)


def _numbers(text: str) -> str:
    """Python's nan and inf, which the server of umbridge writes, as Python's JSON has them."""
    if not re.search(r"\b(?:nan|inf)\b", text):
        return text
    return re.sub(
        r'"(?:[^"\\]|\\.)*"|\bnan\b|\binf\b', lambda m: {"nan": "NaN", "inf": "Infinity"}.get(m[0], m[0]), text
    )
