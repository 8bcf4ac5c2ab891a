"""Keys and operations over HTTP: for administrators only, and the secret is told once."""

from __future__ import annotations

import pytest

from geoswarm.api import ApiSettings
from geoswarm.solver.problem import parse_problem
from geoswarm.workers.access.keys import KEY_PATTERN, ApiKeys
from geoswarm.workers.operations.counters import process_counters
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, App, line_problem


@pytest.fixture
def keyed(service: JobService) -> App:
    app = App(service, ApiSettings(require_key=True))
    app.headers["X-API-Key"] = ApiKeys(service.store).create("root", "admin")[0]
    return app


def test_a_key_is_made_used_and_revoked(service: JobService, keyed: App) -> None:
    made = keyed.post(f"{API}/keys", json={"owner": "anna", "role": "read", "label": "laptop", "valid_seconds": 60})
    assert made.status_code == 201
    assert made.headers["cache-control"] == "no-store"
    key, view = made.json()["key"], made.json()["view"]
    assert KEY_PATTERN.fullmatch(key) is not None
    assert (view["owner"], view["role"], view["label"], view["state"]) == ("anna", "read", "laptop", "active")
    assert keyed.get(f"{API}/jobs", headers={"X-API-Key": key}).status_code == 200
    listed = keyed.get(f"{API}/keys")
    assert [item["owner"] for item in listed.json()["items"]] == ["root", "anna"]
    assert key not in listed.text
    revoked = keyed.post(f"{API}/keys/{view['id']}/revoke")
    assert revoked.json()["state"] == "revoked"
    assert keyed.get(f"{API}/jobs", headers={"X-API-Key": key}).status_code == 401
    assert ApiKeys(service.store).principal(key) is None


@pytest.mark.parametrize(
    ("body", "path"),
    [
        ({"owner": "an na"}, "body.owner"),
        ({"owner": "anna", "role": "king"}, "body.role"),
        ({"owner": "anna", "valid_seconds": 0}, "body.valid_seconds"),
        ({"owner": "anna", "label": "a\nb"}, "body"),
    ],
)
def test_wrong_keys_are_refused_by_field(keyed: App, body: dict[str, object], path: str) -> None:
    answer = keyed.post(f"{API}/keys", json=body)
    assert answer.status_code == 422
    assert answer.json()["issues"][0]["path"] == path


def test_an_unknown_key_cannot_be_revoked(keyed: App) -> None:
    answer = keyed.post(f"{API}/keys/{'0' * 12}/revoke")
    assert answer.status_code == 404
    assert answer.json()["type"] == "urn:geoswarm:error:unknown-key"


@pytest.mark.parametrize("role", ["read", "submit"])
@pytest.mark.parametrize(("method", "path"), [("GET", "/keys"), ("GET", "/operations"), ("POST", "/keys")])
def test_others_are_refused(service: JobService, keyed: App, role: str, method: str, path: str) -> None:
    key = ApiKeys(service.store).create("bob", role)[0]  # type: ignore[arg-type]
    answer = keyed(method, f"{API}{path}", headers={"X-API-Key": key}, json={"owner": "bob", "role": "admin"})
    assert answer.status_code == 403
    assert answer.json()["type"] == "urn:geoswarm:error:role-refused"
    assert [item.owner for item in ApiKeys(service.store).list()] == ["root", "bob"]


def test_operations_count_what_waits_and_how_runs_ended(service: JobService, app: App) -> None:
    service.submit(parse_problem(line_problem()))
    process_counters.run("finished", 0.1)
    process_counters.run("diverged", 0.1)
    process_counters.flush(service.store)
    found = app.get(f"{API}/operations").json()
    assert found["jobs"] == {"queued": 1}
    assert found["outcomes"]["diverged"] >= 1
    assert found["workers"] == {"idle": 0, "busy": 0, "lost": 0}
    assert found["oldest_wait"] >= 0.0
