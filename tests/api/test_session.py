"""Signing in: a cookie that scripts cannot read, that ends with its key, and that foreign pages cannot use."""

from __future__ import annotations

from http.cookies import Morsel, SimpleCookie
from typing import Any

import httpx
import pytest
from pydantic import SecretStr
from sqlalchemy import text

from geoswarm.api import ApiSettings
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, App, line_problem, live_server
from tests.integration.engines import PATIENCE

STATIC = "environment-key-of-the-operator"
OWN = {"X-Requested-With": "geoswarm"}


@pytest.fixture
def guarded(service: JobService) -> App:
    return App(service, ApiSettings(require_key=True))


def cookie(answer: httpx.Response) -> Morsel[str]:
    return SimpleCookie(answer.headers["set-cookie"])["geoswarm_session"]


def signed_in(app: App, key: str) -> dict[str, str]:
    answer = app.post(f"{API}/session", json={"key": key})
    assert answer.status_code == 201, answer.text
    return {"Cookie": f"geoswarm_session={cookie(answer).value}"}


def test_a_key_opens_a_session_that_scripts_and_foreign_pages_cannot_use(guarded: App, service: JobService) -> None:
    key, view = ApiKeys(service.store).create("alice", "submit")
    answer = guarded.post(f"{API}/session", json={"key": key})
    body = answer.json()
    assert (body["owner"], body["role"], body["key_needed"], body["signed_in"]) == ("alice", "submit", True, True)
    made = cookie(answer)
    assert made["httponly"] is True
    assert made["samesite"].lower() == "strict"
    assert made["path"] == "/"
    assert not made["secure"]
    assert key not in answer.text + answer.headers["set-cookie"]
    headers = {"Cookie": f"geoswarm_session={made.value}"}
    told = guarded.get(f"{API}/session", headers=headers).json()
    assert told["owner"] == "alice"
    assert told["expires_at"][:13] == body["expires_at"][:13]
    with service.store.engine.connect() as connection:
        ((key_id, token_hash),) = connection.execute(text("SELECT key_id, hash FROM sessions")).all()
    assert key_id == view.id
    assert made.value not in token_hash


@pytest.mark.parametrize("how", ["key", "session", "signed out"])
@pytest.mark.parametrize("busy", [False, True])
def test_event_streams_end_with_their_key_or_session(service: JobService, how: str, busy: bool) -> None:
    key, view = ApiKeys(service.store).create("alice", "submit")
    with live_server(service, ApiSettings(require_key=True, heartbeat_seconds=0.3, poll_seconds=0.05)) as server:
        sign_in = httpx.post(f"{server.url}{API}/session", json={"key": key})
        headers = {"X-API-Key": key} if how == "key" else {"Cookie": f"geoswarm_session={cookie(sign_in).value}"}
        job = httpx.post(f"{server.url}{API}/jobs", json=line_problem(), headers={"X-API-Key": key}).json()["id"]
        with httpx.stream("GET", f"{server.url}{API}/jobs/{job}/events", headers=headers, timeout=PATIENCE) as answer:
            lines = answer.iter_lines()
            while next(lines) != ": still here":  # longer than a heartbeat
                pass
            while next(lines) != ": still here":
                pass
            if how == "signed out":
                httpx.delete(f"{server.url}{API}/session", headers=headers | OWN)
            else:
                ApiKeys(service.store).revoke(view.id)
            told = 0
            for line in lines:
                told += line.startswith(("event:", ":"))
                if busy and told < 100:  # each line brings the next event
                    (service.resume if service.get(job).state == "paused" else service.pause)(job)
    assert told < 100


def test_over_tls_the_cookie_never_travels_without_it(guarded: App, service: JobService) -> None:
    key, _ = ApiKeys(service.store).create("alice", "submit")
    answer = guarded.post("https://localhost/api/v1/session", json={"key": key})
    assert cookie(answer)["secure"] is True


@pytest.mark.parametrize("key", ["wrong", "gsw_000000000000_" + "A" * 43])
def test_a_wrong_key_opens_none(guarded: App, key: str) -> None:
    answer = guarded.post(f"{API}/session", json={"key": key})
    assert answer.status_code == 401
    assert "set-cookie" not in answer.headers


def test_who_guesses_at_the_sign_in_is_slowed_down(guarded: App) -> None:
    statuses = [guarded.post(f"{API}/session", json={"key": "wrong-key"}).status_code for _ in range(22)]
    assert statuses[:20] == [401] * 20
    assert statuses[-1] == 429


def test_changes_with_a_session_need_the_own_header_and_the_own_origin(guarded: App, service: JobService) -> None:
    session = signed_in(guarded, ApiKeys(service.store).create("alice", "submit")[0])
    refused = guarded.post(f"{API}/jobs", json=line_problem(), headers=session)
    assert (refused.status_code, refused.json()["type"]) == (403, "urn:geoswarm:error:origin-refused")
    foreign = session | OWN | {"Origin": "http://evil.example"}
    assert guarded.post(f"{API}/jobs", json=line_problem(), headers=foreign).status_code == 403
    own = session | OWN | {"Origin": "http://localhost"}
    assert guarded.post(f"{API}/jobs", json=line_problem(), headers=own).status_code == 201
    elsewhere = {"Origin": "http://evil.example"}
    assert guarded.post(f"{API}/session", json={"key": "x"}, headers=elsewhere).status_code == 403


def test_a_session_sees_and_may_what_its_key_does(guarded: App, service: JobService) -> None:
    ring = ApiKeys(service.store)
    alice, bob, reader = (
        signed_in(guarded, ring.create(*who)[0]) for who in (("alice", "submit"), ("bob", "submit"), ("alice", "read"))
    )
    job = guarded.post(f"{API}/jobs", json=line_problem(), headers=alice | OWN).json()["id"]
    for path in (f"{API}/jobs/{job}", f"/jobs/{job}", f"/jobs/{job}/statistics", f"/compare?job={job}"):
        assert guarded.get(path, headers=alice).status_code == 200
        assert guarded.get(path, headers=reader).status_code == 200
        assert guarded.get(path, headers=bob).status_code == 404
    assert guarded.post(f"{API}/jobs/{job}/cancel", headers=reader | OWN).status_code == 403


@pytest.mark.parametrize("how", ["signed out", "revoked", "over"])
def test_a_session_ends(guarded: App, service: JobService, how: str) -> None:
    ring = ApiKeys(service.store)
    key, view = ring.create("alice", "read")
    session = signed_in(guarded, key)
    assert guarded.get(f"{API}/jobs", headers=session).status_code == 200
    if how == "signed out":
        assert guarded("DELETE", f"{API}/session", headers=session).status_code == 403
        gone = guarded("DELETE", f"{API}/session", headers=session | OWN)
        assert (gone.status_code, cookie(gone).value) == (204, "")
    elif how == "revoked":
        ring.revoke(view.id)
    else:
        with service.store.engine.connect() as connection:
            connection.execution_options(write=True)
            with connection.begin():
                connection.execute(text("UPDATE sessions SET expires_at = created_at - 1"))
    answer = guarded.get(f"{API}/jobs", headers=session)
    assert answer.status_code == 401
    assert "session has ended" in answer.json()["detail"]
    assert guarded.get("/", headers=session).headers["location"] == "/sign-in?next=/"


def test_another_key_in_the_environment_ends_sessions_of_the_old_one(service: JobService) -> None:
    first = App(service, ApiSettings(api_key=SecretStr(STATIC)))
    session = signed_in(first, STATIC)
    assert first.get(f"{API}/session", headers=session).json()["role"] == "admin"
    for settings in (ApiSettings(api_key=SecretStr(STATIC + "2")), ApiSettings(require_key=True)):
        assert App(service, settings).get(f"{API}/jobs", headers=session).status_code == 401
    assert App(service, ApiSettings(api_key=SecretStr(STATIC))).get(f"{API}/jobs", headers=session).status_code == 200


def test_without_the_need_of_a_key_there_is_nothing_to_sign_in_to(app: App) -> None:
    answer = app.post(f"{API}/session", json={"key": "any"})
    assert "set-cookie" not in answer.headers
    assert answer.json() == app.get(f"{API}/session").json()
    assert answer.json() == {
        "owner": None, "role": "admin", "key_needed": False, "signed_in": False, "expires_at": None
    }  # fmt: skip
    assert "needs no key" in app.get("/sign-in").text
    assert app("DELETE", f"{API}/session").status_code == 204


@pytest.mark.parametrize(
    ("path", "location"),
    [
        ("/", "/sign-in?next=/"),
        ("/jobs/x/statistics", "/sign-in?next=/jobs/x/statistics"),
        ("/compare?job=a&job=b", "/sign-in?next=/compare%3Fjob%3Da%26job%3Db"),
    ],
)
def test_pages_send_browsers_to_the_sign_in(guarded: App, path: str, location: str) -> None:
    answer = guarded.get(path)
    assert (answer.status_code, answer.headers["location"]) == (303, location)
    assert guarded.get(location).status_code == 200


@pytest.mark.parametrize("value", ["", "x", "a" * 43, "é" * 43, '"', "a" * 5000])
def test_odd_cookies_are_no_session(guarded: App, value: str) -> None:
    headers: Any = {"Cookie": f"geoswarm_session={value}".encode("latin-1")}
    assert guarded.get(f"{API}/jobs", headers=headers).status_code == 401
