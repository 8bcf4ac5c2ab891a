"""The proxy that loses and doubles messages, against a real Redis."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
import redis
from redis.backoff import NoBackoff
from redis.retry import Retry

from tests.chaos.proxy import LossyProxy, split_frames
from tests.servers import RedisServer


@contextmanager
def through(server: RedisServer, url: str, **shares: float) -> Iterator[tuple[redis.Redis, LossyProxy]]:
    number = int(url.rsplit("/", 1)[-1])
    with (
        LossyProxy(server.port, random.Random(1), **shares) as proxy,
        redis.Redis(host="127.0.0.1", port=proxy.port, db=number, retry=Retry(NoBackoff(), 0)) as client,
    ):
        yield client, proxy


def test_frames_are_split_however_they_arrive() -> None:
    whole = b"+OK\r\n:3\r\n$-1\r\n$5\r\na\r\nbc\r\n*2\r\n$1\r\nx\r\n*0\r\n%1\r\n+k\r\n*1\r\n:1\r\n-ERR no\r\n"
    expected = [
        b"+OK\r\n",
        b":3\r\n",
        b"$-1\r\n",
        b"$5\r\na\r\nbc\r\n",
        b"*2\r\n$1\r\nx\r\n*0\r\n",
        b"%1\r\n+k\r\n*1\r\n:1\r\n",
        b"-ERR no\r\n",
    ]
    assert split_frames(bytearray(whole)) == expected
    buffer = bytearray()
    found = []
    for byte in whole:
        buffer.append(byte)
        found += split_frames(buffer)
    assert (found, buffer) == (expected, bytearray())
    with pytest.raises(ValueError, match="no RESP value begins with"):
        split_frames(bytearray(b"?1\r\n"))


def test_messages_are_lost_and_doubled_and_all_else_passes(redis_server: RedisServer, fresh_redis_url: str) -> None:
    with through(redis_server, fresh_redis_url, dropped=1.0, doubled=0.0) as (client, proxy):
        assert client.lpush("geoswarm", "a message") == 1
        assert client.lpush("geoswarm.oedometer", "a message") == 1
        assert client.lpush("other", "x", "y") == 2
        assert client.set("word", "kept")
        assert (client.get("word"), client.llen("geoswarm"), client.llen("other")) == (b"kept", 0, 2)
        with client.pipeline(transaction=False) as pipe:
            pipe.get("word")
            pipe.lpush("geoswarm", "a message")
            pipe.get("word")
            assert pipe.execute() == [b"kept", 1, b"kept"]
        assert proxy.counts == {"dropped": 3}
    with through(redis_server, fresh_redis_url, dropped=0.0, doubled=1.0) as (client, proxy):
        assert client.lpush("geoswarm", "a message") == 1
        with client.pipeline(transaction=True) as pipe:  # its replies are counted: left alone
            pipe.lpush("geoswarm", "another")
            pipe.get("word")
            assert pipe.execute() == [3, b"kept"]
        assert client.lrange("geoswarm", 0, -1) == [b"another", b"a message", b"a message"]
        assert proxy.counts == {"doubled": 1}


def test_the_shares_are_kept(redis_server: RedisServer, fresh_redis_url: str) -> None:
    with through(redis_server, fresh_redis_url) as (client, proxy):
        for number in range(2000):
            client.lpush("geoswarm", number)
        stored = client.llen("geoswarm")
    assert proxy.counts.total() == 2000
    # five standard deviations of a binomial number around 100
    assert all(51 <= proxy.counts[fate] <= 149 for fate in ("dropped", "doubled"))
    assert stored == 2000 - proxy.counts["dropped"] + proxy.counts["doubled"]


def test_a_server_that_is_down_closes_connections_until_it_is_back(
    redis_server: RedisServer, fresh_redis_url: str
) -> None:
    with through(redis_server, fresh_redis_url) as (client, _):
        assert client.ping()
        redis_server.kill()
        with pytest.raises(redis.ConnectionError):
            client.ping()
        with pytest.raises(redis.ConnectionError):
            client.ping()
        redis_server.start()
        assert client.ping()
