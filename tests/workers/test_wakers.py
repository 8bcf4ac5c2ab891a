from __future__ import annotations

import logging
import os

import pytest

from geoswarm.workers.errors import SettingsError
from geoswarm.workers.hosts.celery_app import QUEUE, CeleryWaker, create_celery
from geoswarm.workers.hosts.embedded import PipeWaker
from geoswarm.workers.settings import Settings
from tests.servers import RedisServer


def test_a_ring_wakes_one_waiter_and_rings_do_not_pile_up() -> None:
    waker = PipeWaker(2)
    assert not waker.wait(0.01)
    for _ in range(100):
        waker.wake("any", 5)
    assert [waker.wait(seconds) for seconds in (60, 60, 0.01)] == [True, True, False]
    assert waker.health() == "embedded"
    waker.close()
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(waker.read_end)


def test_celery_rings_lie_in_redis_as_json(fresh_redis_url: str, redis_server: RedisServer) -> None:
    waker = CeleryWaker(Settings(broker_url=fresh_redis_url))
    waker.wake("0123456789abcdef", 2)
    assert waker.health() == "ok"
    assert redis_server.running
    assert waker._redis.llen(QUEUE) == 2
    message = str(waker._redis.lindex(QUEUE, 0))
    assert "application/json" in message
    assert "pickle" not in message
    waker.close()


def test_a_dead_redis_is_reported_once_and_rings_are_dropped(caplog: pytest.LogCaptureFixture) -> None:
    with RedisServer() as server:
        waker = CeleryWaker(Settings(broker_url=server.url))
        server.stop()
        with caplog.at_level(logging.INFO, logger="geoswarm.workers.hosts.celery_app"):
            waker.wake("job")
            waker._silent_until = 0.0
            waker.wake("job")
            server.start()
            waker.wake("job")  # still silent
            assert waker._redis.llen(QUEUE) == 0
            waker._silent_until = 0.0
            waker.wake("job")
            assert waker._redis.llen(QUEUE) == 1
        waker.close()
    told = [record.getMessage().split(" ", 2)[2] for record in caplog.records]
    assert [text.split(":")[0] for text in told] == ["does not take messages", "takes messages again"]


def test_celery_needs_a_broker() -> None:
    with pytest.raises(SettingsError, match="broker_url is not set"):
        create_celery(Settings())
    with pytest.raises(SettingsError, match="broker_url is not set"):
        CeleryWaker(Settings())
