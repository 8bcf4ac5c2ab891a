from __future__ import annotations

import base64

import pytest
from pydantic import SecretStr

from geoswarm.api import ApiError, ApiSettings
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, App

KEY = "a-very-secret-key"


@pytest.fixture
def guarded(service: JobService) -> App:
    return App(service, ApiSettings(api_key=SecretStr(KEY)))


def basic(key: str) -> str:
    return "Basic " + base64.b64encode(f"any:{key}".encode()).decode()


@pytest.mark.parametrize("path", ["/jobs", "/jobs/x/events", "/workers", "/forward-models", "/nothing"])
def test_every_route_of_the_api_asks_for_the_key(guarded: App, path: str) -> None:
    answer = guarded.get(API + path)
    assert answer.status_code == 401
    assert answer.headers["www-authenticate"].startswith("Bearer")
    assert answer.headers["content-type"] == "application/problem+json"
    assert "Authorization: Bearer KEY" in answer.json()["detail"]
    assert KEY not in answer.text


@pytest.mark.parametrize(
    "headers", [{"Authorization": f"Bearer {KEY}"}, {"X-API-Key": KEY}, {"Authorization": basic(KEY)}]
)
def test_the_key_opens(guarded: App, headers: dict[str, str]) -> None:
    assert guarded.get(f"{API}/jobs", headers=headers).status_code == 200
    assert guarded.get("/", headers=headers).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"Authorization": f"Bearer {KEY}x"},
        {"Authorization": "Bearer"},
        {"Authorization": KEY},
        {"X-API-Key": ""},
        {"X-API-Key": "wrong"},
        {"Authorization": basic("wrong")},
        {"Authorization": "Basic ???"},
        {"Authorization": b"Basic \xfc"},
    ],
)
def test_a_wrong_key_does_not(guarded: App, headers: dict[str, str]) -> None:
    answer = guarded.get(f"{API}/jobs", headers=headers)
    assert answer.status_code == 401


def test_pages_send_browsers_to_the_sign_in(guarded: App) -> None:
    answer = guarded.get("/")
    assert (answer.status_code, answer.headers["location"]) == (303, "/sign-in?next=/")
    wrong = guarded.get("/", headers={"Authorization": basic("wrong")})
    assert wrong.status_code == 401
    assert wrong.headers["www-authenticate"].startswith("Basic")


@pytest.mark.parametrize(
    "path", ["/health/live", "/health/ready", "/openapi.json", "/static/css/base.css", "/sign-in", "/help/search"]
)
def test_health_and_what_is_no_secret_stay_open(guarded: App, path: str) -> None:
    assert guarded.get(path).status_code == 200


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1:8765", "[::1]:8765", "LOCALHOST:1"])
def test_without_a_key_loopback_names_are_answered(app: App, host: str) -> None:
    assert app.get(f"{API}/jobs", headers={"Host": host}).status_code == 200


@pytest.mark.parametrize("host", ["evil.example", "localhost.evil.example:8765", "127.0.0.1.evil.example", "10.0.0.1"])
def test_without_a_key_other_names_are_refused(app: App, host: str) -> None:
    answer = app.get(f"{API}/jobs", headers={"Host": host})
    assert answer.status_code == 403
    assert answer.json()["type"] == "urn:geoswarm:error:host-refused"
    assert "localhost" in answer.json()["detail"]


def test_allowed_hosts_and_a_key_open_other_names(service: JobService) -> None:
    allowed = App(service, ApiSettings(allowed_hosts=frozenset({"api"})))
    assert allowed.get(f"{API}/jobs", headers={"Host": "api:8765"}).status_code == 200
    keyed = App(service, ApiSettings(api_key=SecretStr(KEY)))
    assert keyed.get(f"{API}/jobs", headers={"Host": "any.example", "X-API-Key": KEY}).status_code == 200


def test_pages_of_other_origins_may_read_nothing_and_change_nothing(app: App) -> None:
    for origin in ("http://evil.example", "null", "http://localhost:1", "http://["):
        answer = app.post(f"{API}/jobs/x/cancel", headers={"Origin": origin})
        assert (answer.status_code, answer.json()["type"]) == (403, "urn:geoswarm:error:origin-refused")
    own = app.post(f"{API}/jobs/x/cancel", headers={"Origin": "http://localhost"})
    assert own.status_code == 404
    read = app.get(f"{API}/jobs", headers={"Origin": "http://evil.example"})
    assert "access-control-allow-origin" not in read.headers


@pytest.mark.parametrize("path", [f"{API}/jobs", "/", "/nothing", f"{API}/jobs/x"])
def test_security_headers_are_on_every_answer(app: App, path: str) -> None:
    headers = app.get(path).headers
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["x-frame-options"] == "DENY"
    assert headers["cache-control"] == "no-store"
    assert headers["content-security-policy"].startswith("default-src 'none'; script-src 'self'")


def test_settings_come_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEOSWARM_API_KEY", KEY)
    monkeypatch.setenv("GEOSWARM_ALLOWED_HOSTS", "api, Lab.Example ")
    settings = ApiSettings.from_environment()
    assert settings.api_key is not None
    assert settings.api_key.get_secret_value() == KEY
    assert settings.allowed_hosts == {"api", "lab.example"}
    assert KEY not in repr(settings)
    assert ApiSettings.from_environment(max_body_bytes=2000).max_body_bytes == 2000


@pytest.mark.parametrize(
    ("variable", "value", "said"),
    [("GEOSWARM_API_KEY", "short", "at least 8"), ("GEOSWARM_MAX_BODY_BYTES", "much", "'much': .*valid integer")],
)
def test_wrong_settings_name_the_variable(
    monkeypatch: pytest.MonkeyPatch, variable: str, value: str, said: str
) -> None:
    monkeypatch.setenv(variable, value)
    with pytest.raises(ApiError, match=f"{variable}.*{said}") as caught:
        ApiSettings.from_environment()
    assert "short" not in str(caught.value)
