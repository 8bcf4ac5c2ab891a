"""The connection to a service: address, key, timeouts, and one request at a time."""

from __future__ import annotations

from types import TracebackType
from typing import IO, Self, TypeVar

import httpx

from geoswarm.client.calls import LIMITS, Call, authorities, connection_failed, connection_settings, error_of

__all__ = ["AsyncConnection"]

T = TypeVar("T")


class AsyncConnection:
    """Sends requests to a service and reads its answers; parameters as in :class:`geoswarm.client.AsyncClient`."""

    def __init__(
        self,
        base_url: str | None = None,
        api_key: str | None = None,
        *,
        timeout: float = 60.0,
        patience: float = 60.0,
        stream_timeout: float = 45.0,
        transport: httpx.AsyncBaseTransport | None = None,
    ) -> None:
        self.base_url, headers = connection_settings(base_url, api_key)
        self._patience = patience
        self._stream_timeout = stream_timeout
        self._timeout = timeout
        self._http = httpx.AsyncClient(
            base_url=self.base_url,
            headers=headers,
            timeout=httpx.Timeout(timeout, connect=min(timeout, 10.0)),
            transport=transport
            or httpx.AsyncHTTPTransport(verify=authorities(self.base_url), limits=LIMITS, retries=1),
        )

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Close all connections."""
        await self._http.aclose()

    async def _send(self, call: Call[T]) -> T:
        """Send a request and read its answer."""
        try:
            response = await self._http.request(
                call.method, call.path, params=dict(call.query), headers=dict(call.headers), content=call.content
            )
        except httpx.HTTPError as error:
            raise connection_failed(self.base_url, error) from error
        if not response.is_success and response.status_code not in call.accepted:
            raise error_of(response)
        return call.read(response)

    async def _download(self, call: Call[None], file: IO[bytes]) -> None:
        """Send a request and write its answer to a file as it comes."""
        try:
            async with self._http.stream(call.method, call.path, params=dict(call.query)) as response:
                if not response.is_success:
                    await response.aread()
                    raise error_of(response)
                async for chunk in response.aiter_bytes():
                    file.write(chunk)
        except httpx.HTTPError as error:
            raise connection_failed(self.base_url, error) from error
