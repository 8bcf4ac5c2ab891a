"""Event streams over a real connection."""

from __future__ import annotations

import asyncio
import gc
import json
import threading
import time
from collections.abc import Iterator, Mapping
from typing import Any

import httpx
import pytest

from geoswarm.api import ApiSettings
from geoswarm.api.events.feed import MOST_GENERATIONS, BatchTexts, EventFeed, encode_event, thinned
from geoswarm.records.job import Event
from geoswarm.solver.problem import parse_problem
from geoswarm.workers.hosts.engine import Engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.store.event_listener import insert_events
from tests.api.conftest import API, LiveServer, line_problem, live_server, wait_until
from tests.integration.engines import PATIENCE


def submit(server: LiveServer, **changes: Any) -> str:
    return str(httpx.post(f"{server.url}{API}/jobs", json=line_problem(**changes), timeout=PATIENCE).json()["id"])


def act(server: LiveServer, job: str, *actions: str) -> None:
    for action in actions:
        assert httpx.post(f"{server.url}{API}/jobs/{job}/{action}", timeout=PATIENCE).status_code == 200


def read(server: LiveServer, job: str, query: str = "", headers: dict[str, str] | None = None) -> list[dict[str, str]]:
    """Read a stream to its end."""
    answer = httpx.get(f"{server.url}{API}/jobs/{job}/events{query}", headers=headers, timeout=PATIENCE)
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"].startswith("text/event-stream")
    return [
        dict(line.split(": ", 1) for line in block.splitlines() if not line.startswith(":"))
        for block in answer.text.split("\n\n")
        if "data: " in block
    ]


def states(events: list[dict[str, str]]) -> list[str]:
    return [json.loads(event["data"])["state"] for event in events if event["event"] == "state"]


def test_a_whole_job_is_told_from_the_first_to_the_last_event(engine: Engine) -> None:
    with live_server(engine.service, ApiSettings(poll_seconds=0.05)) as server:
        events = read(server, submit(server))
    generations = [json.loads(event["data"]) for event in events if event["event"] == "generation"]
    assert states(events)[-1] == "finished"
    assert [generation["number"] for generation in generations] == list(range(10))
    assert set(generations[0]) >= {"number", "evaluations", "failed", "best_objective", "objective", "parameters"}
    ids = [int(event["id"]) for event in events]
    assert ids == sorted(set(ids))


@pytest.mark.parametrize("how", ["header", "query"])
def test_replay_goes_on_after_the_last_event_received(server: LiveServer, how: str) -> None:
    job = submit(server)
    act(server, job, "pause", "resume", "cancel")
    whole = read(server, job)
    assert states(whole)[-3:] == ["paused", states(whole)[-2], "cancelled"]
    for index, event in enumerate(whole[:-1]):
        last = event["id"]
        rest = (
            read(server, job, headers={"Last-Event-ID": last})
            if how == "header"
            else read(server, job, f"?after={last}")
        )
        assert rest == whole[index + 1 :]


def test_nothing_after_the_end_means_do_not_come_again(server: LiveServer) -> None:
    job = submit(server)
    act(server, job, "cancel")
    last = read(server, job)[-1]["id"]
    answer = httpx.get(f"{server.url}{API}/jobs/{job}/events", headers={"Last-Event-ID": last}, timeout=PATIENCE)
    assert (answer.status_code, answer.content) == (204, b"")


@pytest.mark.parametrize("last", ["x", "-1", "1.5", "9" * 30])
def test_a_last_event_id_that_is_none_is_refused(server: LiveServer, last: str) -> None:
    answer = httpx.get(
        f"{server.url}{API}/jobs/{submit(server)}/events", headers={"Last-Event-ID": last}, timeout=PATIENCE
    )
    assert answer.status_code == 422
    assert "Last-Event-ID" in answer.json()["detail"]


def lines(server: LiveServer, job: str, after: int = 0) -> Iterator[str]:
    url = f"{server.url}{API}/jobs/{job}/events?after={after}"
    with httpx.stream("GET", url, timeout=PATIENCE) as answer:
        yield from answer.iter_lines()


def test_a_silent_stream_gives_signs_of_life(server: LiveServer) -> None:
    stream = lines(server, submit(server))
    assert sum(1 for _, line in zip(range(12), stream, strict=False) if line.startswith(":")) >= 2
    stream.close()  # type: ignore[attr-defined]


def test_events_arrive_as_they_happen(server: LiveServer) -> None:
    job = submit(server)
    stream = lines(server, job)
    timer = threading.Timer(0.3, act, (server, job, "pause"))
    timer.start()
    seen = next(line for line in stream if line.startswith("data:") and "paused" in line)
    timer.join()
    assert json.loads(seen.removeprefix("data: "))["state"] == "paused"
    stream.close()  # type: ignore[attr-defined]


def test_a_deleted_job_ends_its_streams(server: LiveServer, service: JobService) -> None:
    job = submit(server)
    after = service.events(job)[-1].id if service.events(job) else 0
    stream = lines(server, job, after)
    assert next(stream).startswith("retry")
    service.store.write(lambda connection: connection.exec_driver_sql(f"delete from jobs where id = '{job}'"))
    assert all(not line.startswith("data:") for line in stream)


class CountingService(JobService):
    """Counts how often events are asked for, and in which threads."""

    def __init__(self, service: JobService) -> None:
        self.__dict__ |= service.__dict__
        self.reads = 0
        self.threads: set[int] = set()

    def news(self, after: Mapping[str, int], *, limit: int = 500) -> Any:
        self.reads += 1
        self.threads.add(threading.get_ident())
        return super().news(after, limit=limit)


def test_many_listeners_share_one_poller_and_leave_nothing_behind(service: JobService) -> None:
    counting = CountingService(service)
    with live_server(counting, ApiSettings(poll_seconds=0.1)) as server:
        job = submit(server)

        async def listen_all(count: int) -> list[list[str]]:
            limits = httpx.Limits(max_connections=count)
            async with httpx.AsyncClient(limits=limits, timeout=PATIENCE) as client:

                async def listen() -> list[str]:
                    async with client.stream("GET", f"{server.url}{API}/jobs/{job}/events") as answer:
                        return [line async for line in answer.aiter_lines() if line.startswith("data:")]

                async def end() -> None:
                    while server.feed.listeners < count - 1:
                        await asyncio.sleep(0.01)
                    before, began = counting.reads, time.monotonic()
                    while counting.reads < before + 5:
                        await asyncio.sleep(0.1)
                    rate = (counting.reads - before) / (time.monotonic() - began)
                    assert rate <= 20  # ten a second, and fewer on a busy machine; not ten a listener
                    assert server.feed.watched == 1
                    await client.post(f"{server.url}{API}/jobs/{job}/cancel")

                listening = [asyncio.create_task(listen()) for _ in range(count - 1)]
                await end()
                return await asyncio.gather(*listening)

        heard = asyncio.run(listen_all(60))
        assert len({tuple(lines) for lines in heard}) == 1
        assert "cancelled" in heard[0][-1]
        assert len(counting.threads) <= 12  # not one a listener
        wait_until(lambda: server.feed.watched == 0)


def test_a_listener_that_leaves_stops_the_poller(server: LiveServer) -> None:
    stream = lines(server, submit(server))
    next(stream)
    wait_until(lambda: server.feed.watched == 1)
    stream.close()  # type: ignore[attr-defined]
    wait_until(lambda: server.feed.watched == 0)


def event(number: int, kind: str = "generation") -> Event:
    return Event(id=number, kind=kind, data={"number": number})


def test_of_many_generations_at_once_some_are_told_and_the_last() -> None:
    batch = [event(number, "state" if number in (7, 180, 200) else "generation") for number in range(201)]
    told = [one.id for one in thinned(batch)]
    assert {7, 180, 199, 200} <= set(told)
    assert told == sorted(set(told))
    assert len(told) <= MOST_GENERATIONS + 4
    assert thinned(batch[:MOST_GENERATIONS]) == batch[:MOST_GENERATIONS]


def test_a_batch_is_written_once_for_all() -> None:
    texts, batch = BatchTexts(), [event(1), event(2)]
    assert texts.of(batch) is texts.of(list(batch))
    assert texts.of(batch) == "".join(map(encode_event, batch))


@pytest.mark.slow
@pytest.mark.timing  # how long the loop is held
def test_many_watchers_of_a_busy_job_do_not_hold_up_the_loop(service: JobService) -> None:
    """200 streams of a job with some 400 generations a second: the loop comes round soon, all hear the end."""
    service.submit(parse_problem(line_problem()))
    job = service.list().items[0].id
    last = 3000
    done = threading.Event()

    def work() -> None:
        for first in range(0, last, 20):
            rows = [
                {
                    "job_id": job,
                    "kind": "generation",
                    "data": json.dumps({"number": n, "parameters": {"a": 0.1, "b": 0.2}}),
                    "created_at": 1.0,
                }
                for n in range(first, first + 20)
            ]
            service.store.write(lambda connection, rows=rows: insert_events(connection, rows))
            time.sleep(0.05)
        done.set()

    async def follow() -> tuple[list[int], float, int]:
        feed = EventFeed(service, poll_seconds=0.01)
        heard = [0] * 200
        texts = 0

        async def watch(place: int) -> None:
            nonlocal texts
            async for text in feed.listen(job, 0):
                if text is not None:
                    texts += 1
                    heard[place] = int(text.rsplit("id: ", 1)[1].partition("\n")[0])

        watching = [asyncio.create_task(watch(place)) for place in range(200)]
        thread = threading.Thread(target=work)
        thread.start()
        longest = 0.0
        while not done.is_set() or min(heard) < max(heard) or max(heard) < last:
            before = time.thread_time()  # of the loop alone, whatever else the machine does
            await asyncio.sleep(0.005)
            longest = max(longest, time.thread_time() - before)
        feed.close()
        await asyncio.gather(*watching)
        thread.join()
        return heard, longest, texts

    gc.collect()
    gc.freeze()  # to look through what other tests left may take half a second, which is not the loop's
    heard, longest, texts = asyncio.run(asyncio.wait_for(follow(), PATIENCE))
    assert len(set(heard)) == 1
    assert heard[0] >= last
    assert texts < 60_000  # one for each event and listener would be 600 000
    assert longest < 0.5
