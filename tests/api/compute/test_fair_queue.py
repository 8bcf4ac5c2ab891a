"""Fair queue."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Any

import pytest

from geoswarm.api.compute.fair_queue import BusyError, FairQueue
from geoswarm.api.compute.middleware import is_compute


def run(work: Coroutine[Any, Any, None]) -> None:
    asyncio.run(work)


async def settled() -> None:
    for _ in range(10):
        await asyncio.sleep(0)


def test_one_client_never_has_all_places() -> None:
    async def work() -> None:
        queue = FairQueue(places=3, per_client=2, waiting=5)
        order: list[str] = []

        async def ask(client: str) -> None:
            await queue.take(client)
            order.append(client)

        asked = [asyncio.create_task(ask("greedy")) for _ in range(6)]
        await settled()
        assert order == ["greedy", "greedy"]
        asked.append(asyncio.create_task(ask("modest")))
        await settled()
        assert order == ["greedy", "greedy", "modest"]
        asked += [asyncio.create_task(ask("third")) for _ in range(2)]
        await settled()
        for client in ("greedy", "modest", "greedy", "third"):
            queue.give_back(client)
            await settled()
        # The places go round: whoever got one goes behind the others.
        assert order[3:] in (["greedy", "third", "greedy", "third"], ["third", "greedy", "third", "greedy"])
        for task in asked:
            task.cancel()

    run(work())


def test_too_many_waiting_are_refused_at_once() -> None:
    async def work() -> None:
        queue = FairQueue(places=1, per_client=1, waiting=2)
        await queue.take("a")
        waiting = [asyncio.create_task(queue.take("a")) for _ in range(2)]
        await settled()
        with pytest.raises(BusyError):
            await queue.take("a")
        other = asyncio.create_task(queue.take("b"))
        await settled()
        waiting[0].cancel()  # it has given up
        await settled()
        queue.give_back("a")
        await settled()
        assert waiting[1].done() != other.done()
        queue.give_back("a" if waiting[1].done() else "b")
        await settled()
        assert waiting[1].done()
        assert other.done()

    run(work())


@pytest.mark.parametrize(
    ("method", "path", "compute"),
    [
        ("POST", "/api/v1/jobs", True),
        ("GET", "/api/v1/jobs", False),
        ("PATCH", "/api/v1/jobs/1f", True),
        ("GET", "/api/v1/jobs/1f", False),
        ("DELETE", "/api/v1/jobs/1f", False),
        *(("POST", f"/api/v1/jobs/1f/{kind}", True) for kind in ("sensitivity", "profile", "jackknife", "explore")),
        ("POST", "/api/v1/jobs/1f/cancel", False),
        ("GET", "/api/v1/jobs/1f/events", False),
        ("GET", "/api/v1/jobs/1f/report.pdf", True),
        ("GET", "/api/v1/jobs/1f/figures/fit.svg", True),
        ("GET", "/api/v1/jobs/1f/mesh/fields", True),
        ("POST", "/api/v1/problems/check", True),
        ("GET", "/api/v1/problems/schema", False),
        ("POST", "/api/v1/session", False),
        ("GET", "/health/ready", False),
        ("GET", "/jobs/1f/statistics", False),
    ],
)
def test_what_calculates(method: str, path: str, compute: bool) -> None:
    assert is_compute({"type": "http", "method": method, "path": path}) == compute
