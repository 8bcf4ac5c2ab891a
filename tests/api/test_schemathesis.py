"""Requests made up from the OpenAPI document: never a 5xx or a word of another owner's job, with and without keys."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings

from geoswarm.api import ApiSettings, create_app
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.execution.worker import Worker
from geoswarm.workers.identity import Identity
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.api.conftest import line_problem
from tests.variants import variants

SECRET = "confidential-embankment"
FEW, MANY = 3, 150


class World:
    """A service with a job of alice that is finished, and keys of others."""

    def __init__(self, folder: Path) -> None:
        engine = Settings(database_url=f"sqlite:///{folder}/jobs.db", workers=1, quota_jobs=10**6, slice_seconds=60)
        self.store = Store(engine)
        self.service = JobService(self.store, NoWaker(), engine)
        document = line_problem(name=SECRET)
        from geoswarm.solver.problem import parse_problem

        alice = self.service.on_behalf_of(Principal("alice", "submit"))
        self.job = alice.submit(parse_problem(document))[0].id
        worker = Worker(self.store, NoWaker(), engine, Identity.new("embedded"))
        worker.serve(self.job)
        worker.close()
        ring = ApiKeys(self.store)
        self.keys = {
            "bob": ring.create("bob", "submit")[0],
            "reader": ring.create("carol", "read")[0],
            "nobody": "gsw_000000000000_" + "A" * 43,
        }
        limits = ApiSettings(require_key=True, requests_per_second=0.0)
        app = create_app(self.service, limits)
        self.schema = schemathesis.openapi.from_asgi("/openapi.json", app)
        self.operations = [result.ok() for result in self.schema.get_all_operations()]


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    made = World(tmp_path_factory.mktemp("world"))
    yield made
    made.store.close()


def check_answers(world: World, who: str, examples: int) -> int:
    """Send made-up requests to every operation as somebody, and return how many."""
    sent = 0
    for operation in world.operations:
        if operation.path.endswith("/events"):
            continue  # a stream; it has its own tests

        @given(case=operation.as_strategy())
        @settings(
            max_examples=examples,
            deadline=None,
            database=None,
            derandomize=True,
            phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )
        def ask(case: Any) -> None:
            nonlocal sent
            if "job_id" in (case.path_parameters or {}) and sent % 2:
                case.path_parameters["job_id"] = world.job
            headers = {"X-API-Key": world.keys[who]} if who in world.keys else {}
            answer = case.call(headers=headers)
            sent += 1
            text = answer.content.decode("utf-8", "replace")
            assert answer.status_code < 500, (case.method, case.path, text[:500])
            assert SECRET not in text, (case.method, case.path)
            if case.path.endswith("/session"):  # signing in is open to everybody; it has its own tests
                return
            if who in ("nobody", "nothing") and case.path.startswith("/api"):
                assert answer.status_code in (401, 429), (case.method, case.path, answer.status_code)
            if who == "reader" and case.method not in ("GET", "HEAD"):
                assert answer.status_code in (403, 404, 405), (case.method, case.path, answer.status_code)

        ask()
    assert world.service.get(world.job).name == SECRET
    return sent


@pytest.mark.parametrize("who", variants(["bob", "reader", "nobody", "nothing"], {"nobody"}))
def test_made_up_requests_break_and_leak_nothing(world: World, who: str) -> None:
    refused = who in ("nobody", "nothing")  # before anything of a request is read
    assert check_answers(world, who, 2 if refused else FEW) > 100


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("who", ["bob", "reader", "nothing"])
def test_many_made_up_requests_break_and_leak_nothing(world: World, who: str) -> None:
    assert check_answers(world, who, MANY) > 1000
