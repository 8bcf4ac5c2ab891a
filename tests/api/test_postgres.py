"""The service on a real PostgreSQL server, and what a caller sees when the server goes away."""

from __future__ import annotations

from collections.abc import Iterator

import httpx
import pytest

from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.api.conftest import API, App, LiveServer, line_problem
from tests.integration.engines import PATIENCE
from tests.servers import PostgresServer


@pytest.fixture
def service(fresh_postgres_url: str) -> Iterator[JobService]:
    settings = Settings(database_url=fresh_postgres_url, connect_seconds=2)
    store = Store(settings)
    made = JobService(store, NoWaker(), settings)
    yield made
    made.close()
    store.close()


def test_jobs_and_events(server: LiveServer) -> None:
    headers = {"Idempotency-Key": "one"}
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        job = client.post(f"{API}/jobs", json=line_problem(), headers=headers).json()
        assert client.post(f"{API}/jobs", json=line_problem(), headers=headers).status_code == 200
        assert client.get(f"{API}/jobs").json()["items"] == [job]
        assert client.post(f"{API}/jobs/{job['id']}/cancel").json()["state"] == "cancelled"
        events = client.get(f"{API}/jobs/{job['id']}/events").text
        assert '"state":"cancelled"' in events
        assert client.get(f"{API}/jobs/{job['id']}/evaluations?format=csv").status_code == 200
        assert client.delete(f"{API}/jobs/{job['id']}").status_code == 204


def test_text_that_the_database_cannot_store_does_no_harm(app: App) -> None:
    answer = app.post(f"{API}/jobs", json=line_problem(name="a\0b"))
    assert (answer.status_code, answer.json()["issues"][0]["path"]) == (422, "name")
    assert app.get(f"{API}/jobs/a%00b").status_code == 404


def test_a_server_that_went_away_is_503_until_it_is_back(app: App, postgres_server: PostgresServer) -> None:
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    postgres_server.stop()
    for answer in (app.get(f"{API}/jobs/{job}"), app.get(f"{API}/jobs/{job}/events"), app.get("/")):
        assert answer.status_code == 503
        assert answer.json()["title"] == "Database unavailable"
    ready = app.get("/health/ready")
    assert ready.status_code == 503
    assert ready.json()["dependencies"]["database"] != "ok"
    assert ready.json()["dependencies"]["broker"] == "embedded"
    postgres_server.start()
    assert app.get(f"{API}/jobs/{job}").status_code == 200
    assert app.get("/health/ready").status_code == 200
