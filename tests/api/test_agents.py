"""The routes of agents: what a key of role ``agent`` opens, and that it opens nothing else."""

from __future__ import annotations

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import httpx
import pytest

from geoswarm.api import ApiSettings
from geoswarm.api.errors import ApiSettingsError
from geoswarm.api.events.open_work import OpenWorkWatch
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.registered.signed import SignedList, listed
from geoswarm.solver.system.versions import versions
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, App, line_problem, live_server, wait_until
from tests.api.operations import OPEN, operations
from tests.integration.agents import line_model
from tests.integration.engines import PATIENCE

AGENTS = f"{API}/agents/"


@pytest.fixture
def keys(service: JobService) -> dict[str, str]:
    return {role: ApiKeys(service.store).create("somebody", role)[0] for role in ("agent", "read", "submit", "admin")}  # type: ignore[arg-type]


@pytest.fixture
def app(service: JobService, keys: dict[str, str]) -> App:
    made = App(service, ApiSettings(require_key=True))
    made.headers = {"Authorization": f"Bearer {keys['agent']}"}
    return made


def announced(**changes: Any) -> dict[str, Any]:
    return {
        "agent": "pc-1",
        "host": "pc",
        "system": "Windows 11 AMD64",
        "pid": 12,
        "slots": 2,
        "versions": dict(versions()),
        "kinds": ["formula"],
        "models": {},
    } | changes


def test_an_agent_reaches_its_own_routes_and_no_other(app: App, service: JobService) -> None:
    job_id = service.submit(parse_problem(line_problem()))[0].id
    tried = operations(app.get("/openapi.json").json())
    assert len(tried) > 50
    refused = 0
    for method, path in [*tried, ("GET", f"{API}/jobs/{job_id}/problem"), ("GET", "/"), ("GET", "/workers")]:
        answer = app(method, path, **({} if method in ("GET", "DELETE") else {"json": {}}))
        if path.startswith(AGENTS):
            assert answer.status_code in (204, 404, 410, 422), (method, path, answer.text)
            assert answer.status_code != 404 or "hands out no models" in answer.text
        elif path.startswith(OPEN):
            assert answer.status_code < 400, (method, path)
        elif (method, path) == ("POST", f"{API}/session"):
            assert answer.status_code == 422
        else:
            assert answer.status_code == 403, (method, path, answer.text)
            assert "This API key has the role 'agent'" in answer.text
            refused += 1
    assert refused > 50


def test_an_agent_cannot_sign_in(app: App, keys: dict[str, str]) -> None:
    answer = app.post(f"{API}/session", json={"key": keys["agent"]})
    assert answer.status_code == 403
    assert "opens no pages" in answer.json()["detail"]
    assert "set-cookie" not in answer.headers


@pytest.mark.parametrize("role", ["read", "submit"])
def test_other_keys_do_not_open_the_routes_of_agents(app: App, keys: dict[str, str], role: str) -> None:
    app.headers = {"X-API-Key": keys[role]}
    answer = app("PUT", f"{AGENTS}models", json=announced())
    assert answer.status_code == 403
    assert answer.json()["detail"].endswith("needs 'agent' or 'admin'.")


def test_models_of_a_signed_list_are_handed_out(
    service: JobService, keys: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    models = line_model(tmp_path / "models")
    monkeypatch.setenv("GEOSWARM_MODELS", str(models))
    file = tmp_path / "list.json"
    monkeypatch.setenv("GEOSWARM_SIGNED_MODELS", str(file))
    with pytest.raises(ApiSettingsError, match=r"GEOSWARM_SIGNED_MODELS.*geoswarm models sign"):
        ApiSettings.from_environment()
    file.write_bytes(SignedList.signed({"line": listed(models / "line")}, 1, b"s" * 32).document())
    app = App(service, ApiSettings.from_environment(require_key=True))
    app.headers = {"Authorization": f"Bearer {keys['agent']}"}
    assert SignedList.read(app.get(f"{AGENTS}models").content, b"s" * 32).models == {"line": listed(models / "line")}
    for one in listed(models / "line").files:
        answer = app.get(f"{AGENTS}models/files/{one.sha256}")
        assert answer.content == (models / "line" / one.path).read_bytes()
    for wrong in ("../../keys", "%2e%2e%2fmodel.yaml", "model.yaml", "0" * 63):
        assert app.get(f"{AGENTS}models/files/{wrong}").status_code in (404, 405, 422)
    absent = app.get(f"{AGENTS}models/files/{'0' * 64}")
    assert (absent.status_code, absent.json()["type"]) == (404, "urn:geoswarm:error:not-handed-out")
    (models / "line" / "run.sh").write_text("exit 1\n")
    changed = [
        app.get(f"{AGENTS}models/files/{one.sha256}")
        for one in SignedList.read(file.read_bytes(), None).models["line"].files
    ]
    assert [answer.status_code for answer in changed] == [200, 409, 200]
    assert "run.sh has changed since; sign the list again" in changed[1].json()["detail"]
    app.headers = {"Authorization": f"Bearer {keys['submit']}"}
    assert app.get(f"{AGENTS}models").status_code == 403


def test_a_lease_its_beat_and_its_results(app: App, service: JobService) -> None:
    terms = app("PUT", f"{AGENTS}models", json=announced()).json()
    assert terms["wait_seconds"] == 50.0
    assert terms["accepted"] == ["formula"]
    assert 2 * terms["heartbeat_seconds"] <= terms["lease_seconds"]
    assert app.post(f"{AGENTS}leases", json={"agent": "pc-1", "slot": 0}).json() == {"lease": None}
    job_id = service.submit(parse_problem(line_problem()))[0].id
    lease = app.post(f"{AGENTS}leases", json={"agent": "pc-1", "slot": 0, "wait": 5}).json()["lease"]
    assert (lease["job"], len(lease["runs"])) == (job_id, 1)
    assert app.post(f"{AGENTS}leases/{lease['id']}/beat").status_code == 204
    values = lease["runs"][0]["values"]
    x = lease["shared"]["points"]["y"]
    run = {"particle": 0, "attempt": 1, "seconds": 0.01, "began": 0.0, "ended": 0.01}
    run |= {"responses": {"y": [values["a"] + values["b"] * one for one in x]}}
    known = {"agent": "pc-1", "slot": 0, "frames": [lease["frame"]]}
    answer = app.post(f"{AGENTS}leases/{lease['id']}/results", json={"runs": [run], "next": known}).json()
    assert answer["taken"] is True
    assert answer["lease"]["shared"] is None
    again = app.post(f"{AGENTS}leases/{lease['id']}/results", json={"runs": [run]}).json()
    assert again == {"taken": False, "lease": None}
    assert service.evaluation(job_id, 0, 0).state == "finished"
    service.cancel(job_id)
    gone = app.post(f"{AGENTS}leases/{answer['lease']['id']}/beat")
    assert (gone.status_code, gone.json()["type"]) == (410, "urn:geoswarm:error:lease-over")
    assert app("DELETE", f"{AGENTS}pc-1").status_code == 204
    unknown = app.post(f"{AGENTS}leases", json={"agent": "pc-1", "slot": 0})
    assert (unknown.status_code, unknown.json()["type"]) == (404, "urn:geoswarm:error:unknown-agent")


@pytest.mark.parametrize(
    ("body", "where"),
    [
        ({"runs": [{"particle": -1}]}, "body.runs.0.particle"),
        ({"runs": [], "more": 1}, "body.more"),
        ({"runs": [{"particle": 0, "attempt": 1, "reason": "tired", "seconds": 0, "began": 0, "ended": 0}]}, "reason"),
        ({"runs": [{"particle": 0, "attempt": 1, "seconds": -1, "began": 0, "ended": 0}]}, "seconds"),
    ],
)
def test_what_is_wrong_with_results_is_reported(app: App, body: dict[str, Any], where: str) -> None:
    answer = app.post(f"{AGENTS}leases/{'0' * 32}/results", json=body)
    assert answer.status_code == 422
    assert any(where in issue["path"] for issue in answer.json()["issues"])
    assert app.post(f"{AGENTS}leases/{'0' * 32}/results", content=b"{").status_code == 422


def test_who_waits_is_woken_by_work(app: App, service: JobService) -> None:
    """The look for work is made while the request waits: the job comes after it."""
    app("PUT", f"{AGENTS}models", json=announced())
    timer = threading.Timer(0.5, lambda: service.submit(parse_problem(line_problem())))
    timer.start()
    began = time.monotonic()
    lease = app.post(f"{AGENTS}leases", json={"agent": "pc-1", "slot": 1, "wait": 60}).json()["lease"]
    timer.join()
    assert lease is not None
    assert time.monotonic() - began < 50.0


def test_who_waits_again_is_spared_a_look_that_was_just_made(app: App, service: JobService) -> None:
    watch, offers = OpenWorkWatch(service), frozenset({"formula"})
    assert not watch.nothing_for(offers, None)  # nobody has looked
    watch._looked_at = time.monotonic() + 3600.0
    assert watch.nothing_for(offers, None)
    watch._work = [(frozenset({"formula"}), 10.0)]
    assert not watch.nothing_for(offers, None)
    assert watch.nothing_for(frozenset({"oedometer"}), None)
    assert watch.nothing_for(offers, 5.0)  # it ends before
    watch.close()
    assert not watch.nothing_for(frozenset(), None)
    # Who does not wait is told what there is now, whatever was seen before.
    app("PUT", f"{AGENTS}models", json=announced())
    asked = {"agent": "pc-1", "slot": 0}
    assert app.post(f"{AGENTS}leases", json=asked | {"wait": 0.2}).json() == {"lease": None}
    service.submit(parse_problem(line_problem()))
    assert app.post(f"{AGENTS}leases", json=asked).json()["lease"] is not None


def test_a_key_that_is_revoked_meanwhile_gets_no_work(app: App, service: JobService) -> None:
    app("PUT", f"{AGENTS}models", json=announced())
    keys = ApiKeys(service.store)

    def revoke() -> None:
        keys.revoke(next(key.id for key in keys.list() if key.role == "agent"))
        service.submit(parse_problem(line_problem()))

    timer = threading.Timer(0.5, revoke)
    timer.start()
    asked = {"agent": "pc-1", "slot": 1, "wait": 60}
    assert app.post(f"{AGENTS}leases", json=asked).json() == {"lease": None}
    timer.join()
    assert app.post(f"{AGENTS}leases", json=asked).status_code == 401


def test_who_signs_off_or_leaves_waits_no_longer(service: JobService) -> None:
    with live_server(service) as server, httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        watch: OpenWorkWatch = server.server.config.app.state.open_work  # type: ignore[union-attr]
        asked = {"agent": "pc-1", "slot": 0, "wait": 300.0}
        with ThreadPoolExecutor(1) as pool:
            client.put(f"{AGENTS}models", json=announced()).raise_for_status()
            waiting = pool.submit(client.post, f"{AGENTS}leases", json=asked)
            wait_until(lambda: watch.waiting == 1)
            assert client.delete(f"{AGENTS}pc-1").status_code == 204
            assert waiting.result(30.0).json() == {"lease": None}
        client.put(f"{AGENTS}models", json=announced()).raise_for_status()
        with pytest.raises(httpx.ReadTimeout):
            client.post(f"{AGENTS}leases", json=asked, timeout=1.0)
        wait_until(lambda: watch.waiting == 0)


def test_workers_show_slots(app: App, keys: dict[str, str]) -> None:
    app("PUT", f"{AGENTS}models", json=announced(models={"footing": "b" * 64}))
    app.headers = {"X-API-Key": keys["read"]}
    items = app.get(f"{API}/workers").json()["items"]
    assert [item["id"] for item in items] == ["pc-1/0", "pc-1/1"]
    assert items[0]["agent"] == {
        "id": "pc-1",
        "slots": 2,
        "system": "Windows 11 AMD64",
        "version": versions()["geoswarm"],
        "models": {"footing": "b" * 64},
    }
