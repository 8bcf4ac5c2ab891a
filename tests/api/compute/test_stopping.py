"""A server that ends cancels what is still at work: its clients are told to come again, not of a fault."""

from __future__ import annotations

import asyncio
import json
from typing import Any, cast

from geoswarm.api import ApiSettings
from geoswarm.api.compute.middleware import ComputeMiddleware
from geoswarm.api.compute.pool import ComputePool


class Waiting:
    """A pool whose processes are long in coming."""

    def __init__(self) -> None:
        self.asked = asyncio.Event()

    async def take(self, job: str | None) -> None:
        del job
        self.asked.set()
        await asyncio.Event().wait()


def test_a_request_that_the_server_cancels_is_answered_503() -> None:
    told: list[dict[str, Any]] = []

    async def receive() -> dict[str, Any]:
        if not told and not body.is_set():
            body.set()
            return {"type": "http.request", "body": b"", "more_body": False}
        await asyncio.Event().wait()
        raise AssertionError

    async def send(message: Any) -> None:
        told.append(message)

    async def unused(*_: Any) -> None:
        raise AssertionError

    async def work() -> None:
        pool = Waiting()
        middleware = ComputeMiddleware(unused, cast("ComputePool", pool), ApiSettings())
        scope = {"type": "http", "method": "GET", "path": "/api/v1/jobs/1f/statistics", "headers": []}
        request = asyncio.ensure_future(middleware(scope, receive, send))
        await pool.asked.wait()
        request.cancel()
        await request

    body = asyncio.Event()
    asyncio.run(work())
    start, answer = told[0], json.loads(told[1]["body"])
    assert start["status"] == 503
    assert (b"retry-after", b"5") in start["headers"]
    assert "stopping" in answer["detail"]
