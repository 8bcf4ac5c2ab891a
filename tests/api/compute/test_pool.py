"""Processes for requests that calculate are made when they are needed."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from geoswarm.api import bind
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
