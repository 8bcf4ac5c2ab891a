from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import pytest

from geoswarm.api import ApiSettings
from geoswarm.api.access.limits import MOST_CLIENTS, RateLimiter
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, App


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def test_a_burst_then_the_rate() -> None:
    clock = Clock()
    limiter = RateLimiter(2.0, 3, clock)
    assert [limiter.take("a") for _ in range(4)] == [None, None, None, 1]
    clock.now += 0.5
    assert limiter.take("a") is None
    assert limiter.take("a") == 1
    assert limiter.take("b") is None
    clock.now += 1000
    assert limiter.tokens("a") == 3


def test_the_wait_is_the_time_until_the_next_token() -> None:
    clock = Clock()
    limiter = RateLimiter(0.1, 1, clock)
    assert limiter.take("a") is None
    assert limiter.take("a") == 10
    clock.now += 9.0
    assert limiter.take("a") == 1
    clock.now += 1.01
    assert limiter.take("a") is None


def test_zero_is_no_limit() -> None:
    limiter = RateLimiter(0.0, 1)
    assert [limiter.take("a") for _ in range(100)] == [None] * 100


@pytest.mark.parametrize("extra", [1, 50])
def test_clients_are_forgotten_so_that_memory_stays_small(extra: int) -> None:
    limiter = RateLimiter(1.0, 5, Clock())
    for number in range(MOST_CLIENTS + extra):
        limiter.take(str(number))
    assert len(limiter._buckets) == MOST_CLIENTS
    assert limiter.tokens("0") == 5


def test_yaml_is_limited_as_it_is_read_slowly(app: App) -> None:
    text = "name: " + "x" * 250_000
    answer = app.post(f"{API}/jobs", content=text, headers={"Content-Type": "application/yaml"})
    assert answer.status_code == 413
    assert "application/json" in answer.json()["detail"]


def test_a_body_must_arrive_in_time(service: JobService) -> None:
    slow = App(service, ApiSettings(body_seconds=0.2))

    async def drip() -> AsyncIterator[bytes]:
        for _ in range(20):
            yield b" "
            await asyncio.sleep(0.1)

    answer = slow.post(f"{API}/jobs", content=drip(), headers={"Content-Type": "application/json"})
    assert answer.status_code == 408
