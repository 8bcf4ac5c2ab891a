"""Signed requests, after the Standard Webhooks specification (https://www.standardwebhooks.com).

Three headers: ``webhook-id``, the same at every try, ``webhook-timestamp`` [s since 1970], and ``webhook-signature``:
``v1,`` and the HMAC-SHA256 of ``id.timestamp.body`` in base64, with the bytes of the secret after ``whsec_``.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import secrets
import ssl
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import httpcore

from geoswarm.workers.notices.addresses import resolve
from geoswarm.workers.notices.settings import Network

__all__ = ["NotDeliveredError", "new_secret", "post", "signature"]

PREFIX = "whsec_"
MOST_BYTES = 65_536  # of an answer, headers included
SUCCESS = range(200, 300)
CONNECTION_SECONDS = 5.0


class NotDeliveredError(Exception):
    """A message was not accepted; the text gives the owner of the hook the reason. ``final``: never will be."""

    def __init__(self, message: str, *, final: bool = False) -> None:
        self.final = final
        super().__init__(message)


def new_secret() -> str:
    """Return a secret with 256 random bits."""
    return PREFIX + base64.b64encode(secrets.token_bytes(32)).decode()


def signature(secret: str, message_id: str, timestamp: int, body: bytes) -> str:
    """Return the header ``webhook-signature``."""
    key = base64.b64decode(secret.removeprefix(PREFIX))
    digest = hmac.new(key, f"{message_id}.{timestamp}.".encode() + body, hashlib.sha256).digest()
    return f"v1,{base64.b64encode(digest).decode()}"


def post(
    url: str,
    secret: str,
    message_id: str,
    body: bytes,
    *,
    networks: Sequence[Network],
    seconds: float,
    now: Callable[[], float] = time.time,
) -> None:
    """Send one message and wait for an answer of 2xx; redirections are not followed, proxies not used.

    Parameters
    ----------
    networks
        Private networks that it may go to.
    seconds
        Time in all, from the look-up of the name to the last byte of the answer [s].

    Raises
    ------
    NotDeliveredError
    """
    timestamp = int(now())
    headers: dict[bytes | str, bytes | str] = {
        "content-type": "application/json",
        "user-agent": "geoswarm-webhook",
        "webhook-id": message_id,
        "webhook-timestamp": str(timestamp),
        "webhook-signature": signature(secret, message_id, timestamp, body),
    }
    network = _Network(networks, encrypted=url.startswith("https://"), deadline=time.monotonic() + seconds)
    try:
        with httpcore.ConnectionPool(
            ssl_context=ssl.create_default_context(), max_connections=1, retries=0, network_backend=network
        ) as pool:
            answer = pool.request("POST", url, headers=headers, content=body, extensions={"timeout": _phases(seconds)})
    except (httpcore.TimeoutException, TimeoutError):
        raise NotDeliveredError(f"no answer within {seconds:g} s") from None
    except (httpcore.NetworkError, httpcore.ProtocolError, OSError) as error:
        raise NotDeliveredError(str(error) or type(error).__name__) from None
    if answer.status not in SUCCESS:
        gone = answer.status == 410
        raise NotDeliveredError(f"answered with status {answer.status}{', which means: gone' * gone}", final=gone)


def _phases(seconds: float) -> dict[str, float]:
    return {"connect": min(seconds, CONNECTION_SECONDS), "read": seconds, "write": seconds, "pool": seconds}


class _Network(httpcore.NetworkBackend):
    """Connects to the very address that was judged, until a deadline."""

    def __init__(self, networks: Sequence[Network], *, encrypted: bool, deadline: float) -> None:
        self._networks = networks
        self._encrypted = encrypted
        self._deadline = deadline
        self._sockets = httpcore.SyncBackend()

    def connect_tcp(
        self,
        host: str,
        port: int,
        timeout: float | None = None,
        local_address: str | None = None,
        socket_options: Iterable[Any] | None = None,
    ) -> httpcore.NetworkStream:
        """Look the name up, judge, connect."""
        address = resolve(host, port, self._networks, encrypted=self._encrypted)
        stream = self._sockets.connect_tcp(address, port, timeout, local_address, socket_options)
        return _Stream(stream, self._deadline)


class _Stream(httpcore.NetworkStream):
    """A connection that ends at a deadline, however slowly the other side sends, and after a number of bytes."""

    def __init__(self, stream: httpcore.NetworkStream, deadline: float) -> None:
        self._stream = stream
        self._deadline = deadline
        self._read = 0

    def read(self, max_bytes: int, timeout: float | None = None) -> bytes:  # noqa: ARG002  the deadline is stricter
        """Read what is there."""
        data = self._stream.read(max_bytes, self._left())
        self._read += len(data)
        if self._read > MOST_BYTES:
            raise httpcore.ReadError(f"the answer is longer than {MOST_BYTES} bytes")
        return data

    def write(self, buffer: bytes, timeout: float | None = None) -> None:  # noqa: ARG002
        """Write."""
        self._stream.write(buffer, self._left())

    def close(self) -> None:
        """Close."""
        self._stream.close()

    def start_tls(
        self, ssl_context: ssl.SSLContext, server_hostname: str | None = None, timeout: float | None = None
    ) -> httpcore.NetworkStream:
        """Go on encrypted, with the certificate of the name that was asked for."""
        left = self._left() if timeout is None else min(timeout, self._left())
        return _Stream(self._stream.start_tls(ssl_context, server_hostname, left), self._deadline)

    def get_extra_info(self, info: str) -> Any:
        """Tell of the connection below."""
        return self._stream.get_extra_info(info)

    def _left(self) -> float:
        left = self._deadline - time.monotonic()
        if left <= 0:
            raise httpcore.ReadTimeout
        return left
