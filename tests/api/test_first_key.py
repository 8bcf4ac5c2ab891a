"""The first key closes a service that runs, at once."""

from __future__ import annotations

import httpx

from geoswarm.solver.problem import parse_problem
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from tests.api.conftest import API, App, LiveServer, line_problem


def make_key(settings: Settings) -> str:
    """What 'geoswarm keys create' does, in a process of its own."""
    store = Store(settings)
    try:
        return ApiKeys(store).create("ann", "admin")[0]
    finally:
        store.close()


def test_the_first_key_closes_a_service_that_runs(app: App, settings: Settings) -> None:
    assert app.get(f"{API}/jobs").status_code == 200
    assert app.post(f"{API}/session", json={"key": "any text"}).json()["key_needed"] is False
    key = make_key(settings)
    assert app.get(f"{API}/jobs").status_code == 401
    for text in ("any text", key[:-1] + "x", ""):
        assert app.get(f"{API}/jobs", headers={"X-API-Key": text}).status_code == 401
    assert app.post(f"{API}/jobs", json=line_problem()).status_code == 401
    page = app.get("/")
    assert (page.status_code, page.headers["location"]) == (303, "/sign-in?next=/")
    assert app.get(f"{API}/jobs", headers={"X-API-Key": key}).status_code == 200
    assert app.get("/health/live").status_code == 200


def test_the_page_for_signing_in_asks_for_the_first_key(app: App, settings: Settings) -> None:
    key = make_key(settings)
    assert 'type="password"' in app.get("/sign-in").text
    assert app.post(f"{API}/session", json={"key": "any text"}).status_code == 401
    signed_in = app.post(f"{API}/session", json={"key": key})
    assert (signed_in.status_code, signed_in.json()["owner"]) == (201, "ann")


def test_revoking_it_does_not_open_the_service_again(app: App, service: JobService, settings: Settings) -> None:
    key = make_key(settings)
    ApiKeys(service.store).revoke(key[4:16])
    assert app.get(f"{API}/jobs").status_code == 401


def test_streams_that_were_opened_without_a_key_end(
    server: LiveServer, service: JobService, settings: Settings
) -> None:
    job = service.submit(parse_problem(line_problem()))[0].id
    with httpx.stream("GET", f"{server.url}{API}/jobs/{job}/events", timeout=30) as answer:
        lines = answer.iter_lines()
        assert next(lines) == "retry: 1000"
        make_key(settings)
        rest = list(lines)  # comes to its end by itself
    assert "event: generation" not in rest
