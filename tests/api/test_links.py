"""Read-only links: one job for people without a key, and nothing else."""

from __future__ import annotations

import re
from typing import Any

import httpx
import pytest
from sqlalchemy import text

from geoswarm.api import ApiSettings
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.hosts.engine import Engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.service.links import MOST_LINKS
from tests.api.conftest import API, App, line_problem, wait_for_end

LINK = re.compile(r"/sign-in\?next=(/jobs/[0-9a-f]{16})#(gsw_[0-9a-f]{12}_[A-Za-z0-9_-]{43})")


class Shared:
    """A service with keys, two jobs of alice, and a link to the first one."""

    def __init__(self, service: JobService) -> None:
        self.app = App(service, ApiSettings(require_key=True))
        self.ring = ApiKeys(service.store)
        self.keys = {owner: self.ring.create(owner, "submit")[0] for owner in ("alice", "bob")}
        made = [self("alice", "POST", f"{API}/jobs", json=line_problem(name=name)) for name in ("shown", "hidden")]
        self.job, self.other = (str(answer.json()["id"]) for answer in made)
        self.links = f"{API}/jobs/{self.job}/links"
        self.made = self("alice", "POST", self.links, json={"label": "reviewer"})
        match = LINK.fullmatch(self.made.json()["path"])
        assert match is not None
        assert match[1] == f"/jobs/{self.job}"
        self.keys["link"] = match[2]

    def __call__(self, sender: str, method: str, path: str, **request: Any) -> httpx.Response:
        return self.app(method, path, headers={"Authorization": f"Bearer {self.keys[sender]}"}, **request)


@pytest.fixture
def shared(service: JobService) -> Shared:
    return Shared(service)


def test_a_link_is_made_listed_used_and_revoked(shared: Shared) -> None:
    assert shared.made.status_code == 201
    view = shared.made.json()["view"]
    assert (view["job"], view["role"], view["label"], view["state"]) == (shared.job, "read", "reviewer", "active")
    listed = shared("alice", "GET", shared.links)
    assert listed.json() == {"items": [view]}
    assert shared.keys["link"] not in listed.text
    assert shared("link", "GET", f"{API}/jobs/{shared.job}").json()["name"] == "shown"
    assert shared("alice", "GET", shared.links).json()["items"][0]["used_at"] is not None
    revoked = shared("alice", "POST", f"{shared.links}/{view['id']}/revoke")
    assert (revoked.status_code, revoked.json()["state"]) == (200, "revoked")
    assert shared("link", "GET", f"{API}/jobs/{shared.job}").status_code == 401


def test_a_browser_signs_in_with_a_link_and_sees_its_page_alone(shared: Shared) -> None:
    answer = shared.app.post(f"{API}/session", json={"key": shared.keys["link"]})
    assert (answer.status_code, answer.json()["role"]) == (201, "read")
    session = {"Cookie": answer.headers["set-cookie"].partition(";")[0]}
    page = shared.app.get(f"/jobs/{shared.job}", headers=session)
    assert page.status_code == 200
    assert "read-only link" in page.text
    assert 'aria-label="Main"' not in page.text
    for path in ("/", "/new", "/compare", "/workers", f"/jobs/{shared.other}"):
        elsewhere = shared.app.get(path, headers=session)
        assert (elsewhere.status_code, elsewhere.headers["location"]) == (303, f"/jobs/{shared.job}"), path
    refused = shared.app.get(f"{API}/jobs", headers=session)
    assert (refused.status_code, refused.json()["type"]) == (403, "urn:geoswarm:error:link-refused")
    revoke = f"{shared.links}/{shared.made.json()['view']['id']}/revoke"
    shared("alice", "POST", revoke)
    ended = shared.app.get(f"/jobs/{shared.job}", headers=session)
    assert (ended.status_code, ended.headers["location"]) == (303, f"/sign-in?next=/jobs/{shared.job}")


def test_no_route_shows_another_job_or_changes_anything(shared: Shared) -> None:
    """Whatever the OpenAPI document names: the link's own job may be read, everything else is refused."""
    tried = 0
    for path, operations in shared.app.get("/openapi.json").json()["paths"].items():
        for method, operation in operations.items():
            if path.startswith("/health") or path == f"{API}/session":
                continue
            values = {p["name"]: p["schema"].get("enum", ["0"])[0] for p in operation.get("parameters", [])}
            for job in (shared.job, shared.other):
                url = re.sub(r"\{(\w+)\}", lambda m: job if m[1] == "job_id" else values.get(m[1], "x"), path)  # noqa: B023
                if method == "get" and job == shared.job and "{job_id}" in path:
                    continue
                body = {"json": {}} if "requestBody" in operation else {}
                answer = shared("link", method.upper(), url, **body)
                assert answer.status_code == 403, (method, url, answer.status_code)
                assert "hidden" not in answer.text
                tried += 1
    assert tried > 80
    assert shared("alice", "GET", f"{API}/jobs/{shared.job}").json()["state"] == "queued"


def test_neither_links_nor_files_nor_other_jobs_are_listed(shared: Shared, service: JobService) -> None:
    assert shared("link", "GET", shared.links).status_code == 404
    files = f"{API}/jobs/{shared.job}/attachments"
    made = shared("alice", "POST", files, params={"name": "a.txt"}, content=b"hidden").json()
    assert shared("link", "GET", files).json() == {"items": []}
    assert shared("link", "GET", f"{files}/{made['sha256']}").status_code == 404
    behind = service.on_behalf_of(Principal("alice", "read", "k", shared.job))  # also without the gate
    assert (behind.list().items, behind.count()) == ([], 0)
    for path in ("..", f"x/../../{shared.other}", f"%2e%2e/{shared.other}"):
        answer = shared("link", "GET", f"/jobs/{shared.job}/{path}")
        assert answer.status_code in (403, 404)
        assert "hidden" not in answer.text


def test_results_of_a_finished_job_are_shown(engine: Engine) -> None:
    shared = Shared(engine.service)
    assert wait_for_end(engine.service, shared.job).state == "finished"
    for path in ("", "/problem", "/best", "/fit", "/statistics", "/uncertainty", "/evaluations", "/report.html"):
        assert shared("link", "GET", f"{API}/jobs/{shared.job}{path}").status_code == 200, path
    compare = shared("link", "GET", f"/compare?ids={shared.job}&ids={shared.other}")
    assert compare.status_code == 403


def test_only_who_sees_a_job_links_it_and_only_its_own_links_are_revoked(shared: Shared) -> None:
    assert shared("bob", "POST", shared.links, json={}).status_code == 404
    assert shared("bob", "GET", shared.links).status_code == 404
    view = shared.made.json()["view"]
    other = f"{API}/jobs/{shared.other}/links"
    for key_id in (view["id"], "0" * 12, shared.keys["alice"].split("_")[1], "ü"):
        answer = shared("alice", "POST", f"{other}/{key_id}/revoke")
        assert (answer.status_code, answer.json()["type"]) == (404, "urn:geoswarm:error:unknown-key")
    assert shared("alice", "GET", shared.links).json()["items"][0]["state"] == "active"


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ({"valid_days": 0}, "greater than 0"),
        ({"valid_days": 367}, "366"),
        ({"label": "x" * 201}, "200"),
        ({"label": "a\nb"}, "printable"),
        ({"day": 3}, "day"),
    ],
)
def test_what_is_not_acceptable_is_refused(shared: Shared, body: dict[str, Any], said: str) -> None:
    answer = shared("alice", "POST", shared.links, json=body)
    assert answer.status_code == 422
    assert said in answer.text


def test_a_link_expires_and_goes_with_its_job(shared: Shared, service: JobService) -> None:
    with service.store.engine.begin() as connection:
        connection.execute(text("UPDATE api_keys SET expires_at = expires_at - 15 * 86400 WHERE job_id IS NOT NULL"))
    assert shared("link", "GET", f"{API}/jobs/{shared.job}").status_code == 401
    assert shared("alice", "GET", shared.links).json()["items"][0]["state"] == "expired"
    shared("alice", "POST", f"{API}/jobs/{shared.job}/cancel")
    assert shared("alice", "DELETE", f"{API}/jobs/{shared.job}").status_code == 204
    assert [key.job for key in shared.ring.list()] == [None, None]


def test_a_job_has_a_limited_number_of_valid_links(shared: Shared, service: JobService) -> None:
    links = service.on_behalf_of(Principal("alice", "submit")).links
    for _ in range(MOST_LINKS - 1):
        links.create(shared.job, valid_seconds=60.0)
    answer = shared("alice", "POST", shared.links, json={})
    assert (answer.status_code, answer.json()["type"]) == (403, "urn:geoswarm:error:quota-exceeded")


def test_a_service_without_keys_makes_no_links(app: App) -> None:
    """A first key would close the service for everybody else."""
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    answer = app.post(f"{API}/jobs/{job}/links", json={})
    assert (answer.status_code, answer.json()["type"]) == (409, "urn:geoswarm:error:no-key-needed")
    assert app.get(f"{API}/jobs/{job}").status_code == 200
