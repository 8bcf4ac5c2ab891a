"""Who guesses keys, whose address is believed, and how often one may sign in."""

from __future__ import annotations

import httpx
import pytest
from pydantic import SecretStr

from geoswarm.api import ApiError, ApiSettings
from geoswarm.api.access import authentication
from geoswarm.api.access.authentication import FAILURE_BURST, SIGN_IN_BURST
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, App, live_server
from tests.integration.engines import PATIENCE

STATIC = "the-key-of-the-operator"


@pytest.fixture(autouse=True)
def no_refill(monkeypatch: pytest.MonkeyPatch) -> None:
    """However long a test takes on a busy machine, no further attempts are granted meanwhile."""
    monkeypatch.setattr(authentication, "FAILURES_PER_SECOND", 1e-6)
    monkeypatch.setattr(authentication, "SIGN_INS_PER_SECOND", 1e-6)


def status(app: App, key: str) -> int:
    return app.get(f"{API}/jobs", headers={"X-API-Key": key}).status_code


def test_no_key_is_judged_while_too_many_were_wrong(service: JobService) -> None:
    app = App(service, ApiSettings(api_key=SecretStr(STATIC)))
    assert [status(app, f"guess-{i}") for i in range(FAILURE_BURST)] == [401] * FAILURE_BURST
    assert status(app, "one-guess-more") == 429
    assert status(app, STATIC) == 429  # or guessing would go on
    assert app.post(f"{API}/session", json={"key": STATIC}).status_code == 429


def test_neighbours_with_a_long_key_that_was_valid_go_on(service: JobService) -> None:
    key, view = ApiKeys(service.store).create("alice", "submit")
    app = App(service, ApiSettings(api_key=SecretStr(STATIC)))
    assert (status(app, key), status(app, STATIC)) == (200, 200)
    for i in range(FAILURE_BURST):
        status(app, f"guess-{i}")
    assert (status(app, key), status(app, STATIC)) == (200, 429)
    ApiKeys(service.store).revoke(view.id)
    assert status(app, key) == 401
    assert status(app, key) == 429


def test_sessions_are_not_begun_without_end(service: JobService) -> None:
    key, _ = ApiKeys(service.store).create("alice", "submit")
    app = App(service, ApiSettings(require_key=True))
    answers = [app.post(f"{API}/session", json={"key": key}) for _ in range(SIGN_IN_BURST + 1)]
    assert [answer.status_code for answer in answers] == [201] * SIGN_IN_BURST + [429]
    assert int(answers[-1].headers["retry-after"]) > 0
    assert status(app, key) == 200


@pytest.mark.parametrize(("trusted", "refused"), [((), True), (("127.0.0.0/8",), False), (("192.0.2.1",), True)])
def test_only_trusted_proxies_say_whose_request_it_is(
    service: JobService, trusted: tuple[str, ...], refused: bool
) -> None:
    settings = ApiSettings(api_key=SecretStr(STATIC), trusted_proxies=trusted)
    with live_server(service, settings) as server, httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        answers = [
            client.get(f"{API}/jobs", headers={"X-API-Key": "wrong", "X-Forwarded-For": f"198.51.100.{i}"}).status_code
            for i in range(FAILURE_BURST + 1)
        ]
        assert (answers[-1] == 429) is refused
        headers = {"X-Forwarded-Proto": "https", "X-Forwarded-For": "198.51.100.99"}
        signed_in = client.post(f"{API}/session", json={"key": STATIC}, headers=headers)
        assert (signed_in.status_code == 429) is refused
        if not refused:
            assert "secure" in signed_in.headers["set-cookie"].lower()


def test_a_proxy_that_is_no_address_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEOSWARM_TRUSTED_PROXIES", "10.0.0.0/8, ::1")
    assert ApiSettings.from_environment().trusted_proxies == ("10.0.0.0/8", "::1")
    monkeypatch.setenv("GEOSWARM_TRUSTED_PROXIES", "proxy.example")
    with pytest.raises(ApiError, match=r"GEOSWARM_TRUSTED_PROXIES.*'proxy.example' is not an address"):
        ApiSettings.from_environment()
