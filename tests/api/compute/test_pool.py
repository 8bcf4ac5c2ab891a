"""Processes for requests that calculate are made when they are needed."""

from __future__ import annotations

import asyncio
import socket
from http.client import HTTPResponse
from typing import Any

import pytest

from geoswarm.api import ApiSettings, bind
from geoswarm.api.compute.middleware import ComputeMiddleware
from geoswarm.api.compute.pool import ComputePool
from geoswarm.api.server import build_server
from geoswarm.workers.service.job_service import JobService


def test_a_service_that_nobody_asks_to_calculate_starts_no_process(
    service: JobService, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    told: list[str] = []

    class Process:
        alive, job = True, ""

        def __init__(self, *_: Any) -> None:
            made.append("process")

        async def ready(self) -> None:
            pass

        async def close(self) -> None:
            made.append("closed")

    async def work() -> None:
        server = build_server(service, listener, on_started=told.append, compute=True)
        server.config.load()
        server.lifespan = server.config.lifespan_class(server.config)
        await server.startup([listener])
        assert (len(told), made) == (1, [])
        pool = server.config.app.state.pool  # type: ignore[union-attr]
        pool.put_back(await pool.take("1f"))
        assert await pool.take("1f")
        assert made == ["process"]
        await server.shutdown([listener])
        assert made == ["process", "closed"]

    monkeypatch.setattr("geoswarm.api.compute.pool.ComputeProcess", Process)
    listener = bind("127.0.0.1", 0)
    with listener:
        asyncio.run(work())


def test_a_page_has_the_first_process_started(service: JobService) -> None:
    async def work() -> None:
        pool = ComputePool(service, ApiSettings())

        async def nothing(*_: Any) -> Any:
            pass

        middleware = ComputeMiddleware(nothing, pool, pool.settings)
        for path, started in (("/api/v1/jobs", 0), ("/static/js/base.js", 0), ("/", 1), ("/jobs/1f/fit", 1)):
            await middleware({"type": "http", "method": "GET", "path": path}, nothing, nothing)
            await asyncio.sleep(0)
            assert pool.busy == started
        try:
            process = await pool.take("1f")
            assert (process.alive, process.job, pool.busy) == (True, "1f", 1)
            pool.put_back(process)
            pool.prepare()
            assert await pool.take("2f") is process
        finally:
            await pool.close()

    asyncio.run(work())


def test_a_pool_is_closed_while_its_first_process_starts(service: JobService) -> None:
    async def work() -> None:
        pool = ComputePool(service, ApiSettings())
        pool.prepare()
        await asyncio.sleep(0)
        await pool.close()
        assert pool.busy == 0

    asyncio.run(work())


def test_a_process_never_closes_a_connection_that_a_request_may_take(service: JobService) -> None:
    """Its server would, after 5 s: a request that comes just then would be told that the process ended."""

    async def work() -> None:
        pool = ComputePool(service, ApiSettings())
        process = await pool.take(None)
        try:
            with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
                connection.connect(str(process._folder / "socket"))
                connection.sendall(b"GET /health/live HTTP/1.1\r\nHost: compute\r\n\r\n")
                answer = HTTPResponse(connection)
                answer.begin()
                assert (answer.status, answer.read()) == (200, b'{"status":"ok"}')
                connection.settimeout(7.0)
                with pytest.raises(TimeoutError):  # b"" would be its end
                    connection.recv(1)
        finally:
            await pool.close()

    asyncio.run(work())
