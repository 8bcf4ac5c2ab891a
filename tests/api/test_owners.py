"""Over HTTP: nobody learns of another owner's jobs, whatever the route; roles, quotas and rates are kept."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from pydantic import SecretStr

from geoswarm.api import ApiSettings
from geoswarm.records.account import Role
from geoswarm.solver.problem import parse_problem
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.errors import JobNotFoundError
from geoswarm.workers.hosts.engine import Engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from tests.api.conftest import API, App, line_problem, wait_for_end

STATIC = "environment-key-of-the-operator"


BODIES: dict[str, dict[str, Any]] = {"predict": {"problem": {}}, "design": {"candidates": {}}}


class Users:
    """The application with keys in its database."""

    def __init__(self, service: JobService, settings: ApiSettings | None = None) -> None:
        self.app = App(service, settings or ApiSettings(require_key=True))
        self.ring = ApiKeys(service.store)
        self.keys: dict[str, str] = {}

    def __call__(self, owner: str, method: str, path: str, role: Role = "submit", **request: Any) -> Any:
        name = f"{owner}/{role}"
        if name not in self.keys:
            self.keys[name] = self.ring.create(owner, role)[0]
        headers = {"Authorization": f"Bearer {self.keys[name]}"} | request.pop("headers", {})
        return self.app(method, path, headers=headers, **request)


@pytest.fixture
def users(service: JobService) -> Users:
    return Users(service)


@pytest.fixture
def secret_job(users: Users) -> str:
    answer = users("alice", "POST", f"{API}/jobs", json=line_problem(name="confidential-embankment"))
    assert answer.status_code == 201
    return str(answer.json()["id"])


def test_every_route_with_a_job_answers_others_as_if_it_were_not_there(users: Users, secret_job: str) -> None:
    document = users.app.get("/openapi.json").json()
    tried: set[tuple[str, str]] = set()
    for path, operations in document["paths"].items():
        if "{job_id}" not in path:
            continue
        for method, operation in operations.items():
            parameters = {
                p["name"]: p["schema"].get("enum", ["0"])[0]
                for p in operation.get("parameters", [])
                if p.get("required")
            }
            given = BODIES.get(path.rpartition("/")[2], {}) if method == "post" else {}
            given = {"stopping": {"max_evaluations": 10}} if method == "patch" else given
            body = {"json": given} if "requestBody" in operation else {}
            url = re.sub(r"\{(\w+)\}", lambda m: secret_job if m[1] == "job_id" else parameters.get(m[1], "x"), path)  # noqa: B023
            query = {
                p["name"]: "1" for p in operation.get("parameters", []) if p["in"] == "query" and p.get("required")
            }
            answer = users("bob", method.upper(), url, params=query, **body)
            tried.add((method, path.removeprefix(f"{API}/jobs/{{job_id}}")))
            assert answer.status_code == 404, (method, path, answer.status_code)
            assert "confidential" not in answer.text
            nowhere = users("bob", method.upper(), url.replace(secret_job, "0" * 16), params=query, **body)
            assert nowhere.json() == json.loads(answer.text.replace(secret_job, "0" * 16))
    assert len(tried) >= 16
    assert tried > {
        ("get", "/statistics"),
        ("post", "/reweight"),
        ("get", "/report.html"),
        ("get", "/report.pdf"),
        ("get", "/figures"),
        ("get", "/figures/{name}.{form}"),
    }
    assert users("alice", "GET", f"{API}/jobs/{secret_job}").json()["state"] == "queued"


def test_what_an_owner_had_made_is_kept_from_others(engine: Engine) -> None:
    users = Users(engine.service)
    problem = line_problem(name="confidential-embankment", method={"kind": "monte_carlo", "samples": 40}, stopping={})
    job = users("alice", "POST", f"{API}/jobs", json=problem).json()["id"]
    assert wait_for_end(engine.service, job).state == "finished"
    routes: list[tuple[str, str, dict[str, Any]]] = [
        ("GET", "statistics", {}),
        ("GET", "report.html", {}),
        ("GET", "report.pdf", {}),
        ("GET", "figures", {}),
        ("GET", "figures/fit.svg", {}),
        ("GET", "figures/fit.png", {}),
        ("GET", "figures/fit.csv", {}),
        ("POST", "reweight", {"json": {"weights": {"y": 2.0}}}),
    ]
    for method, path, request in routes:
        for owner, role in (("alice", "submit"), ("root", "admin")):
            assert users(owner, method, f"{API}/jobs/{job}/{path}", role=role, **request).status_code == 200, path
        refused = users("bob", method, f"{API}/jobs/{job}/{path}", **request)
        assert (refused.status_code, refused.json()["type"]) == (404, "urn:geoswarm:error:job-not-found"), path
        assert "confidential" not in refused.text


def test_copies_of_a_service_share_what_is_made_and_ask_for_themselves(engine: Engine) -> None:
    alice, bob = (engine.service.on_behalf_of(Principal(name, "submit")) for name in ("alice", "bob"))
    job, _ = alice.submit(parse_problem(line_problem(method={"kind": "monte_carlo", "samples": 40}, stopping={})))
    assert wait_for_end(engine.service, job.id).state == "finished"
    report = alice.statistics.report(job.id)
    assert alice.statistics.report(job.id) is report
    assert engine.service.statistics.report(job.id) is report
    again = alice.on_behalf_of(Principal("bob", "submit"))
    for stranger in (bob, again):
        for ask in (
            stranger.statistics.stored,
            stranger.statistics.report,
            stranger.statistics.reweighted,
            lambda id, statistics=stranger.statistics: statistics.rendered(id, "html", lambda _report: b""),
        ):
            with pytest.raises(JobNotFoundError):
                ask(job.id)


def test_lists_and_pages_hold_only_own_jobs(users: Users, secret_job: str) -> None:
    for path in (f"{API}/jobs", "/", f"{API}/workers", "/metrics", f"{API}/jobs?state=queued"):
        answer = users("bob", "GET", path)
        assert answer.status_code == 200
        assert secret_job not in answer.text
        assert "confidential" not in answer.text
        assert "alice" not in answer.text
    assert users("bob", "GET", f"/jobs/{secret_job}").status_code == 404
    assert secret_job in users("alice", "GET", f"{API}/jobs", role="read").text
    assert secret_job in users("root", "GET", f"{API}/jobs", role="admin").text
    assert users("alice", "GET", f"/jobs/{secret_job}").status_code == 200


def test_who_may_only_read_changes_nothing(users: Users, secret_job: str) -> None:
    for method, path in (
        ("POST", f"{API}/jobs"),
        ("POST", f"{API}/problems/check"),
        ("POST", f"{API}/problems/warm-starts"),
        ("POST", f"{API}/jobs/{secret_job}/cancel"),
        ("DELETE", f"{API}/jobs/{secret_job}"),
        ("GET", f"{API}/jobs/{secret_job}/report.html?compare=a:%201"),
    ):
        answer = users("alice", method, path, role="read", json=line_problem())
        assert (answer.status_code, answer.json()["type"]) == (403, "urn:geoswarm:error:role-refused")
    assert users("root", "POST", f"{API}/jobs/{secret_job}/cancel", role="admin").json()["state"] == "cancelled"


def test_a_revoked_key_is_refused_at_once(users: Users) -> None:
    assert users("alice", "GET", f"{API}/jobs").status_code == 200
    (view,) = users.ring.list()
    users.ring.revoke(view.id)
    answer = users("alice", "GET", f"{API}/jobs")
    assert answer.status_code == 401
    assert "was revoked" in answer.json()["detail"]
    assert users.keys["alice/submit"] not in answer.text


def test_the_key_of_the_environment_is_an_administrator_beside_those_of_the_database(service: JobService) -> None:
    users = Users(service, ApiSettings(api_key=SecretStr(STATIC)))
    job = users("alice", "POST", f"{API}/jobs", json=line_problem()).json()["id"]
    operator = {"X-API-Key": STATIC}
    assert users.app.get(f"{API}/jobs/{job}", headers=operator).status_code == 200
    own = users.app.post(f"{API}/jobs", headers=operator, json=line_problem(name="own")).json()["id"]
    assert users("alice", "GET", f"{API}/jobs/{own}").status_code == 404


def test_without_keys_no_door_is_open_by_another_way(service: JobService) -> None:
    closed = App(service, ApiSettings(require_key=True))
    for path in (f"{API}/jobs", "/", "/metrics", f"{API}/forward-models", "//api/v1/jobs", "/health/../api/v1/jobs"):
        assert closed.get(path).status_code in (303, 401, 404), path
    assert closed.get("/health/live").status_code == 200


def test_a_quota_is_told_as_such(settings: Settings) -> None:
    store = Store(settings)
    tight = JobService(store, _Mute(), settings.model_copy(update={"quota_jobs": 1}))
    users = Users(tight)
    assert users("alice", "POST", f"{API}/jobs", json=line_problem()).status_code == 201
    answer = users("alice", "POST", f"{API}/jobs", json=line_problem())
    assert (answer.status_code, answer.json()["type"]) == (403, "urn:geoswarm:error:quota-exceeded")
    assert "at most 1" in answer.json()["detail"]
    store.close()


class _Mute:
    def wake(self, job_id: str, times: int = 1, kind: str = "") -> None:
        """Wake no worker."""

    def health(self) -> str:
        return "embedded"

    def close(self) -> None:
        """Hold nothing."""


def test_requests_beyond_the_rate_are_sent_away_with_a_time(service: JobService) -> None:
    users = Users(service, ApiSettings(require_key=True, requests_per_second=0.01, request_burst=3))
    statuses = [users("alice", "GET", f"{API}/jobs").status_code for _ in range(5)]
    assert statuses == [200, 200, 200, 429, 429]
    answer = users("alice", "GET", f"{API}/jobs")
    assert 1 <= int(answer.headers["retry-after"]) <= 100
    assert answer.json()["type"] == "urn:geoswarm:error:rate-limited"
    assert users("bob", "GET", f"{API}/jobs").status_code == 200
    assert users.app.get("/health/live").status_code == 200


def test_who_guesses_keys_is_slowed_down_but_not_others(users: Users) -> None:
    assert users("alice", "GET", f"{API}/jobs").status_code == 200
    wrong = {"X-API-Key": f"gsw_{'0' * 12}_{'A' * 43}"}
    statuses = [users.app.get(f"{API}/jobs", headers=wrong).status_code for _ in range(25)]
    assert statuses[:20] == [401] * 20
    assert statuses[-1] == 429
    assert users("alice", "GET", f"{API}/jobs").status_code == 200


@pytest.mark.parametrize(
    "key", ["gsw_é", "\u00ff" * 60, "gsw_" + "0" * 100_000, "Bearer", "gsw_000000000000_" + "A" * 43]
)
def test_odd_keys_are_just_wrong(users: Users, key: str) -> None:
    answer = users.app.get(
        f"{API}/jobs", headers={"X-API-Key": key.encode("latin-1").decode("latin-1").encode("latin-1")}
    )
    assert answer.status_code == 401


def test_an_administrator_follows_up_the_job_of_another(engine: Engine) -> None:
    users = Users(engine.service)
    job = users("alice", "POST", f"{API}/jobs", json=line_problem(name="followed")).json()["id"]
    assert wait_for_end(engine.service, job).state == "finished"
    assert users("bob", "POST", f"{API}/jobs/{job}/sensitivity").status_code == 404
    made = users("chief", "POST", f"{API}/jobs/{job}/sensitivity", role="admin").json()
    assert (made["owner"], made["parent"]) == ("chief", job)
    below = made["id"]
    assert wait_for_end(engine.service, below).state == "finished"

    # The administrator finds it below its job, and is led back from it.
    listed = users("chief", "GET", f"{API}/jobs", role="admin", params={"parent": job}).json()["items"]
    assert [one["id"] for one in listed] == [below]
    page = users("chief", "GET", f"/jobs/{below}", role="admin").text
    assert f'follow-up of <a href="/jobs/{job}" translate="no">followed</a>' in page
    found = users("chief", "GET", f"{API}/jobs/{job}/uncertainty", role="admin").json()
    assert [one["id"] for one in found["follow_ups"]] == [below]

    # The owner of the job has what it found, and not the job that found it.
    shown = users("alice", "GET", f"{API}/jobs/{job}/uncertainty")
    assert shown.json()["linearisation"] == found["linearisation"] is not None
    assert below not in shown.text
    assert users("alice", "GET", f"{API}/jobs/{below}").status_code == 404
    assert users("alice", "GET", f"{API}/jobs", params={"parent": job}).json()["items"] == []

    # With a key that sees only its owner's, the follow-up has no job to stand below.
    alone = users("chief", "GET", f"{API}/jobs", params={"parent": "none"}).json()["items"]
    assert [one["id"] for one in alone] == [below]
    assert "follow-up of a job that you may not see" in users("chief", "GET", f"/jobs/{below}").text
    problem = users("chief", "GET", f"{API}/jobs/{below}/problem").json()
    assert users("bob", "POST", f"{API}/jobs", json=problem).json()["parent"] is None
