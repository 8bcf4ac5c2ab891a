"""Hooks over HTTP: one's own, refused with reasons, told by the engine that serves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from geoswarm import Client
from geoswarm.api import ApiSettings
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from tests.api.conftest import API, App, line_problem, live_server, wait_until
from tests.api.test_owners import Users
from tests.workers.notices.conftest import receiving


@pytest.fixture(autouse=True)
def reach_this_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEOSWARM_HOOK_NETWORKS", "127.0.0.0/8")


def test_a_hook_is_made_listed_and_removed(app: App) -> None:
    made = app.post(f"{API}/hooks", json={"target": "https://example.org/hook"})
    assert made.status_code == 201
    secret, view = made.json()["secret"], made.json()["view"]
    assert secret.startswith("whsec_")
    assert view["states"] == ["finished", "failed", "cancelled"]
    listed = app.get(f"{API}/hooks")
    assert listed.json()["items"] == [view]
    assert secret not in listed.text
    assert app("DELETE", f"{API}/hooks/{view['id']}").status_code == 204
    gone = app("DELETE", f"{API}/hooks/{view['id']}")
    assert (gone.status_code, gone.json()["type"]) == (404, "urn:geoswarm:error:hook-not-found")


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ({"target": "https://10.0.0.1/"}, "target: 10.0.0.1 is not an address that this service may send"),
        ({"target": "ftp://example.org"}, "target: must be an address like https://example.org/hook"),
        ({"target": "anna@example.org"}, "target: this service sends no e-mail"),
        ({"target": "https://example.org", "states": ["running"]}, "states"),
        ({"target": "https://example.org", "states": []}, "states"),
        ({"target": "https://example.org", "secret": "mine"}, "secret"),
        ({}, "target"),
    ],
)
def test_mistakes_are_named(app: App, body: dict[str, Any], words: str) -> None:
    answer = app.post(f"{API}/hooks", json=body)
    assert answer.status_code == 422
    assert words in answer.json()["detail"]


def test_hooks_of_others_are_not_there(service: JobService) -> None:
    users = Users(service)
    view = users("alice", "POST", f"{API}/hooks", json={"target": "https://example.org/alice"}).json()["view"]
    job = users("alice", "POST", f"{API}/jobs", json=line_problem()).json()["id"]
    assert users("bob", "GET", f"{API}/hooks").json()["items"] == []
    assert users("bob", "DELETE", f"{API}/hooks/{view['id']}").status_code == 404
    assert users("bob", "POST", f"{API}/hooks/{view['id']}/test").status_code == 404
    body = {"target": "https://example.org/bob", "job": job}
    refused = users("bob", "POST", f"{API}/hooks", json=body)
    assert (refused.status_code, refused.json()["type"]) == (404, "urn:geoswarm:error:job-not-found")
    assert users("alice", "POST", f"{API}/hooks", role="read", json=body).status_code == 403
    assert [hook["owner"] for hook in users("root", "GET", f"{API}/hooks", role="admin").json()["items"]] == ["alice"]


def test_too_many_are_refused(app: App, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEOSWARM_HOOKS_PER_OWNER", "1")
    assert app.post(f"{API}/hooks", json={"target": "https://example.org/1"}).status_code == 201
    refused = app.post(f"{API}/hooks", json={"target": "https://example.org/2"})
    assert (refused.status_code, refused.json()["type"]) == (403, "urn:geoswarm:error:quota-exceeded")


def test_the_service_tells_of_a_job_that_has_ended(tmp_path: Path) -> None:
    with (
        receiving() as receiver,
        open_engine(Settings(database_url=f"sqlite:///{tmp_path}/jobs.db", workers=1)) as engine,
        live_server(engine.service, ApiSettings()) as server,
        Client(server.url) as client,
    ):
        made = client.create_hook(receiver.url, states=["finished"])
        job = client.submit(line_problem(name="told"))
        wait_until(lambda: client.hooks()[0].last_state == "delivered", 120)
        (told,) = receiver.documents()
        assert told["data"]["id"] == job.id
        assert told["data"]["objective"] == client.get(job.id).objective
        assert client.test_hook(made.view.id).last_state == "waiting"
        client.delete_hook(made.view.id)
        assert client.hooks() == ()
