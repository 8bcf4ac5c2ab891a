"""The service is killed in mid-job and started again while a page is open: the page goes on by itself, to the end."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import expect

from geoswarm import Client, ConnectionFailedError
from tests.chaos.fleet import Fleet
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened
from tests.dashboard.layout import check_layout, leaf_through
from tests.dashboard.test_job import SOON, counted, state
from tests.dashboard.test_stream import goes_on
from tests.integration.engines import wait_for
from tests.servers import free_port
from tests.workers.problems import line

Visit = Callable[..., Opened]

MOST = 6000
X = [0.006 * i for i in range(500)]
JOB: dict[str, Any] = line(
    name="interrupted",
    forward_model={"kind": "formula", "series": {"y": "a * x + b" + " + 0*sin(exp(a*x))" * 45}},
    observations=[{"series": "y", "points": {"x": X, "y": [2.0 * x + 1.0 for x in X]}}],
    method={"kind": "particle_swarm", "particles": 10, "acceleration": "none"},
    stopping={"max_evaluations": MOST},
).document()
"""Seconds of work: some 1.5 ms an evaluation."""


@dataclass(frozen=True, slots=True)
class Address:
    """Where a service of this test answers."""

    url: str


@pytest.fixture(params=["embedded", "full"])
def commands(request: pytest.FixtureRequest, tmp_path: Path) -> dict[str, tuple[str, ...]]:
    """What an operator starts: everything in one, or api and workers on PostgreSQL and Redis."""
    if request.param == "embedded":
        return {"api": ("serve", "--database", f"sqlite:///{tmp_path}/jobs.db", "--workers", "1")}
    database, broker = (request.getfixturevalue(f"fresh_{name}_url") for name in ("postgres", "redis"))
    backends = ("--database", database, "--broker", broker)
    return {"api": ("serve", *backends), "worker": ("worker", "--concurrency", "1", *backends)}


@pytest.mark.slow
def test_a_page_outlives_a_killed_service(commands: dict[str, tuple[str, ...]], tmp_path: Path, visit: Visit) -> None:
    key, port = secrets.token_hex(16), free_port()
    commands["api"] = (*commands["api"], "--port", str(port))
    site = Address(f"http://127.0.0.1:{port}")
    with (
        Fleet(commands, tmp_path, {"GEOSWARM_API_KEY": key}) as fleet,
        Client(site.url, api_key=key, patience=SOON / 1000) as client,
    ):
        wait_for(lambda: ready(client), "a service that is ready")
        job = client.submit(JOB)
        page, guard = visit(site, f"/jobs/{job.id}/search", key=key)
        guard.allow("ERR_CONNECTION_REFUSED", "ERR_CONNECTION_RESET", "ERR_INCOMPLETE_CHUNKED", "ERR_EMPTY_RESPONSE")
        state(page).to_have_text("running", timeout=SOON)
        goes_on(page)
        assert fleet.kill("api")
        before = counted(page)
        assert 0 < before < MOST
        expect(page.locator("#connection")).to_contain_text("Connection lost", timeout=SOON)
        fleet.supervise()
        expect(page.locator("#connection")).to_be_hidden(timeout=SOON)
        state(page).to_have_text("finished", timeout=SOON)
        assert counted(page) == client.get(job.id).evaluations == MOST
        expect(page.locator("[data-field=stopped]")).to_have_text("max evaluations")
        leaf_through(page)
        check_layout(page)
        check_accessibility(page)
        page.goto("about:blank")  # what it has asked for is not answered by a service that stops
        fleet.stop()


def ready(client: Client) -> bool:
    try:
        return client.health().ok
    except ConnectionFailedError:
        return False
