"""Celery over real Redis and PostgreSQL servers, with real worker processes."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
import redis

from geoswarm.workers.errors import BrokerUnavailableError
from geoswarm.workers.hosts.celery_app import QUEUE
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.settings import Settings
from tests.integration.engines import (
    PATIENCE,
    STEADY,
    Gated,
    celery_workers,
    process_exists,
    wait_for,
    wait_until_ended,
)
from tests.servers import RedisServer
from tests.servers import free_port as unused_port
from tests.workers.problems import expected_history, line, recorded_history


@pytest.fixture
def settings(fresh_postgres_url: str, fresh_redis_url: str) -> Settings:
    return Settings(database_url=fresh_postgres_url, broker_url=fresh_redis_url, **STEADY)


@pytest.mark.slow
def test_same_history_as_in_process_for_1_and_2_workers(settings: Settings) -> None:
    problem = line(stopping={"max_evaluations": 300})
    plain = settings.model_copy(update={"local_batch_seconds": 0.02, "cheap_seconds": 0.05})
    with open_engine(plain) as engine:
        for count in (1, 2):
            with celery_workers(plain, count):
                wait_for(lambda n=count: len(engine.service.workers()) == n, "workers")
                job_id = engine.service.submit(problem)[0].id
                assert wait_until_ended(engine.service, job_id).state == "finished"
                assert recorded_history(engine.service, job_id) == expected_history(problem)
                assert engine.service.health() == {"database": "ok", "broker": "ok"}
                assert {w.engine for w in engine.service.workers()} == {"celery"}
            assert engine.service.workers() == []  # they have signed off


@pytest.mark.slow
@pytest.mark.usefixtures("misbehaving_models")
def test_an_emptied_redis_and_killed_workers_change_nothing(
    settings: Settings, redis_server: RedisServer, tmp_path: Path
) -> None:
    gated = Gated(tmp_path)
    with open_engine(settings) as engine, celery_workers(settings, count=2) as processes:
        service = engine.service
        wait_for(lambda: len(service.workers()) == 2, "two workers")
        job_id = service.submit(gated.problem)[0].id

        gated.go_on(service, job_id)
        redis_server.restart(empty=True)
        gated.go_on(service, job_id)
        os.kill(service.workers()[0].pid, signal.SIGKILL)  # a pool process: its Celery worker starts another
        gated.go_on(service, job_id)
        processes[1].kill()  # a whole Celery worker
        gated.gate.open()
        assert wait_until_ended(service, job_id).state == "finished"
        assert recorded_history(service, job_id) == gated.history()
        assert sum(e.kind == "generation" for e in service.events(job_id)) == gated.generations


@pytest.mark.slow
def test_a_job_submitted_while_redis_is_down_runs_when_it_is_back(
    settings: Settings, redis_server: RedisServer
) -> None:
    with open_engine(settings) as engine, celery_workers(settings):
        wait_for(lambda: len(engine.service.workers()) == 1, "a worker")
        redis_server.stop()
        try:
            assert engine.service.health()["broker"].startswith("broker redis://127.0.0.1")
            job_id = engine.service.submit(line())[0].id
            engine.service.submit(line())
        finally:
            redis_server.start()
        assert wait_until_ended(engine.service, job_id).state == "finished"


@pytest.mark.slow
def test_what_is_no_message_in_the_queue_is_dropped(settings: Settings) -> None:
    assert settings.broker_url is not None
    with open_engine(settings) as engine, celery_workers(settings) as (process,):
        wait_for(lambda: len(engine.service.workers()) == 1, "a worker")
        client = redis.Redis.from_url(settings.broker_url)
        rubbish = [
            b"no JSON",
            b"\xff\xfe",
            b"5",
            b"[]",
            b"null",
            b'"text"',
            b"{}",
            b'{"properties": 1}',
            b"[" * 100_000,
        ]
        rubbish.append(b'{"properties": {"delivery_tag": "x", "delivery_info": {}}, "headers": 7, "body": "x"}')
        for message in rubbish:
            client.lpush(QUEUE, message)
        wait_for(lambda: client.llen(QUEUE) == 0, "an empty queue")
        client.close()
        job_id = engine.service.submit(line())[0].id
        assert wait_until_ended(engine.service, job_id).state == "finished"
        assert process.poll() is None


def test_an_unreachable_broker_is_one_clear_line(fresh_postgres_url: str) -> None:
    url = f"redis://:topsecret@127.0.0.1:{unused_port()}/0"
    with pytest.raises(BrokerUnavailableError, match=r"broker redis://:\*\*\*@127\.0\.0\.1") as caught:
        open_engine(Settings(database_url=fresh_postgres_url, broker_url=url))
    assert "topsecret" not in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
@pytest.mark.usefixtures("misbehaving_models")
def test_a_worker_ends_although_one_of_its_processes_hangs(settings: Settings, tmp_path: Path) -> None:
    gated = Gated(tmp_path)
    hasty = settings.model_copy(update={"grace_seconds": 0.5})
    with open_engine(hasty) as engine, celery_workers(hasty, count=1, concurrency=2) as (process,):
        service = engine.service
        wait_for(lambda: len(service.workers()) == 2, "two processes")
        gated.go_on(service, service.submit(gated.problem)[0].id)
        pids = [worker.pid for worker in service.workers()]
        os.kill(pids[0], signal.SIGSTOP)
        process.terminate()
        assert process.wait(PATIENCE) == 0
        wait_for(lambda: not any(process_exists(pid) for pid in pids), "the end of its processes")
