"""The asynchronous client against a real service; it shares everything but input and output with the other one."""

from __future__ import annotations

import asyncio
import csv
import inspect
import json
import re
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import pytest

from geoswarm import (
    AsyncClient,
    Client,
    ConnectionFailedError,
    InvalidProblemError,
    JobFailedError,
    NotFoundError,
    WaitTimeoutError,
)
from geoswarm.client import Event
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import BROKEN, LiveServer, line_problem, live_server
from tests.integration.engines import PATIENCE


def public(kind: type) -> dict[str, Callable[..., object]]:
    return {name: member for name, member in inspect.getmembers(kind, inspect.isfunction) if not name.startswith("_")}


def parameters(method: Callable[..., object]) -> list[inspect.Parameter]:
    """All but ``self``, whose annotation tells the clients apart."""
    return list(inspect.signature(method).parameters.values())[1:]


def told(thing: object) -> str:
    """The docstring, with the examples as those of the client that does not wait."""
    return re.sub(r"\bawait |\basync (?=with|for)|Async(?=Client)", "", inspect.getdoc(thing) or "")


def test_both_clients_have_the_same_methods() -> None:
    ours, theirs = public(AsyncClient), public(Client)
    assert set(ours) == set(theirs)
    assert len(ours) == 71
    for name, method in ours.items():
        twin = theirs[name]
        assert parameters(method) == parameters(twin), name
        expected = inspect.signature(twin).return_annotation.replace("Iterator[", "AsyncIterator[")
        assert inspect.signature(method).return_annotation == expected, name
        assert inspect.iscoroutinefunction(method) != inspect.isasyncgenfunction(method), name
        assert inspect.isasyncgenfunction(method) == inspect.isgeneratorfunction(twin), name
        assert not inspect.iscoroutinefunction(twin), name
        assert told(method) == told(twin) != "", name


def test_both_clients_are_made_from_the_same_settings() -> None:
    ours = [
        str(parameter).replace("AsyncBaseTransport", "BaseTransport") for parameter in parameters(AsyncClient.__init__)
    ]
    assert ours == [str(parameter) for parameter in parameters(Client.__init__)]
    documented = told(AsyncClient).partition("Parameters")[2]
    assert documented
    assert documented == told(Client).partition("Parameters")[2]


def test_submit_wait_and_read_the_result(server: LiveServer, tmp_path: Path) -> None:
    (tmp_path / "problem.json").write_text(json.dumps(line_problem()))
    events: list[Event] = []

    async def session() -> None:
        async with AsyncClient(server.url) as client:
            checked = await client.check(line_problem(answer={}))
            assert (checked.planned_evaluations, checked.left_to_answer) == (60, 15)
            submitted = await client.submit(tmp_path / "problem.json", idempotency_key="async-1")
            assert (await client.submit(line_problem(), idempotency_key="async-1")).id == submitted.id
            job = await client.wait(submitted.id, timeout=PATIENCE, on_event=events.append)
            assert job.objective == calibrate(parse_problem(line_problem())).objective
            assert (await client.best(job.id)).parameters == job.parameters
            assert len(await client.generations(job.id)) == 10
            assert [g.diversity is None for g in await client.generations(job.id, diversity=True)] == [False] * 10
            assert job.id in [earlier.job for earlier in await client.warm_starts(line_problem())]
            assert (await client.problem(job.id))["name"] == "line"
            page = await client.evaluations(job.id, limit=5)
            every = [evaluation async for evaluation in client.iterate_evaluations(job.id)]
            assert len(every) == 60
            assert every[:5] == page.items
            path = await client.download_evaluations(job.id, tmp_path / "out.csv")
            with path.open(newline="") as file:
                assert [float(row["objective"]) for row in csv.DictReader(file)] == [e.objective for e in every]
            assert [event async for event in client.events(job.id)] == events
            assert job.id in [found.id async for found in client.iterate_jobs()]
            await client.delete(job.id)

    asyncio.run(session())
    assert events[-1].ends_job


def test_steering_and_the_catalogue(server: LiveServer) -> None:
    async def session() -> None:
        async with AsyncClient(server.url) as client:
            job = await client.submit(line_problem(stopping={"max_seconds": 600}))
            assert (await client.pause(job.id)).state == "paused"
            assert (await client.resume(job.id)).state in ("queued", "running")
            began = time.monotonic()
            with pytest.raises(WaitTimeoutError):
                await client.wait(job.id, timeout=0.5)
            assert time.monotonic() - began >= 0.5
            waiting = asyncio.create_task(client.wait(job.id, timeout=PATIENCE))
            await asyncio.sleep(0.2)
            assert (await client.cancel(job.id)).state == "cancelled"
            assert (await waiting).state == "cancelled"
            assert (await client.list(limit=1, search="line", sort="created", order="descending")).items[0].id == job.id
            going = await client.change_stopping(job.id, {"max_seconds": 900})
            assert going.state in ("queued", "running")
            assert (await client.cancel(job.id)).state == "cancelled"
            assert (await client.health()).ok
            while len(await client.workers()) != 1:  # it may not have begun when this test is the first one
                await asyncio.sleep(0.05)
            assert (await client.forward_model("formula")).depends_on_section
            assert "formula" in [info.kind for info in await client.forward_models()]

    asyncio.run(session())


def test_errors_are_the_same(server: LiveServer, free_port: int, tmp_path: Path) -> None:
    async def session() -> None:
        async with AsyncClient(server.url) as client:
            with pytest.raises(InvalidProblemError) as caught:
                await client.submit(line_problem(name=3))
            assert [issue.path for issue in caught.value.issues] == ["name"]
            with pytest.raises(NotFoundError):
                await client.wait("nobody")
            with pytest.raises(NotFoundError):
                await client.download_evaluations("nobody", tmp_path / "out.csv")
            assert list(tmp_path.iterdir()) == []
        async with AsyncClient(f"http://127.0.0.1:{free_port}") as client:
            with pytest.raises(ConnectionFailedError, match="'geoswarm serve' starts one"):
                await client.list()

    asyncio.run(session())


def test_a_failed_job_raises(server: LiveServer) -> None:
    async def session() -> None:
        async with AsyncClient(server.url) as client:
            job = await client.submit(line_problem(forward_model=BROKEN, stopping={"max_evaluations": 12}))
            with pytest.raises(JobFailedError, match="all 12 evaluations failed"):
                await client.wait(job.id, timeout=PATIENCE)

    asyncio.run(session())


def test_events_survive_a_restart_of_the_service(service: JobService, free_port: int) -> None:
    """No worker takes part: of many generations at once the stream leaves some out."""

    async def session() -> tuple[list[int], str]:
        with ExitStack() as first:
            await asyncio.to_thread(first.enter_context, live_server(service, port=free_port))
            async with AsyncClient(f"http://127.0.0.1:{free_port}", patience=PATIENCE) as client:
                job = await client.submit(line_problem())
                await client.pause(job.id)
                await client.resume(job.id)
                seen: list[int] = []
                reached = asyncio.Event()

                async def follow() -> None:
                    async for event in client.events(job.id):
                        seen.append(event.id)
                        if len(seen) > 2:
                            reached.set()

                following = asyncio.create_task(follow())
                await asyncio.wait_for(reached.wait(), PATIENCE)
                await asyncio.to_thread(first.close)
                service.pause(job.id)
                with ExitStack() as second:
                    await asyncio.to_thread(second.enter_context, live_server(service, port=free_port))
                    service.resume(job.id)
                    service.cancel(job.id)
                    await asyncio.wait_for(following, PATIENCE)
                    await asyncio.to_thread(second.close)
                return seen, job.id

    seen, job_id = asyncio.run(session())
    assert len(seen) == 6
    assert seen == [event.id for event in service.events(job_id)]
