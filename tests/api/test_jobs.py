from __future__ import annotations

import json
from typing import Any

import pytest

from geoswarm.api import ApiSettings
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, App, line_problem

FIELDS = {
    "id", "name", "state", "forward_model", "method", "stop_reasons", "objective", "parameters", "at_bounds",
    "intervals", "verdicts", "verdict_words", "fit", "shares", "search_best", "evaluations", "search_evaluations",
    "answer_evaluations", "generations", "failed_evaluations", "created_at", "started_at", "finished_at", "seconds",
    "error", "seed", "free_parameters", "max_evaluations", "priority", "retrying", "owner", "parent", "tags", "note",
    "last_event", "trend", "versions", "warnings",
}  # fmt: skip


def submit(app: App, **changes: Any) -> dict[str, Any]:
    answer = app.post(f"{API}/jobs", json=line_problem(**changes))
    assert answer.status_code == 201, answer.text
    return dict(answer.json())


def test_submitting_creates_a_job_and_tells_where_it_is(app: App) -> None:
    answer = app.post(f"{API}/jobs", json=line_problem())
    job = answer.json()
    assert answer.status_code == 201
    assert answer.headers["location"] == f"{API}/jobs/{job['id']}"
    assert set(job) == FIELDS
    assert (job["state"], job["evaluations"], job["max_evaluations"]) == ("queued", 0, 60)
    assert job["created_at"].endswith("Z")
    assert app.get(answer.headers["location"]).json() == job


def test_yaml_is_a_problem_too(app: App) -> None:
    text = json.dumps(line_problem(name="from YAML"))  # JSON is YAML
    answer = app.post(f"{API}/jobs", content=text, headers={"Content-Type": "application/yaml; charset=utf-8"})
    assert (answer.status_code, answer.json()["name"]) == (201, "from YAML")


def test_the_stored_problem_can_be_submitted_again(app: App) -> None:
    problem = app.get(f"{API}/jobs/{submit(app)['id']}/problem").json()
    assert problem["observations"][0]["points"]["y"] == [1.0, 3.0, 5.0]
    again = app.post(f"{API}/jobs", json=problem)
    assert again.status_code == 201
    assert app.get(f"{API}/jobs/{again.json()['id']}/problem").json() == problem


def test_idempotency_key_creates_one_job_only(app: App) -> None:
    headers = {"Idempotency-Key": "one"}
    first = app.post(f"{API}/jobs", json=line_problem(), headers=headers)
    replay = app.post(f"{API}/jobs", json=line_problem(), headers=headers)
    other = app.post(f"{API}/jobs", json=line_problem(name="other"), headers=headers)
    assert (first.status_code, replay.status_code, other.status_code) == (201, 200, 409)
    assert replay.json() == first.json()
    assert replay.headers["location"] == first.headers["location"]
    assert other.json()["type"] == "urn:geoswarm:error:idempotency-conflict"
    assert len(app.get(f"{API}/jobs").json()["items"]) == 1


def test_list_comes_in_pages_newest_first(app: App) -> None:
    ids = [submit(app)["id"] for _ in range(5)]
    seen, cursor = [], None
    for _ in range(3):
        page = app.get(f"{API}/jobs", params={"limit": 2} | ({"cursor": cursor} if cursor else {})).json()
        seen += [job["id"] for job in page["items"]]
        cursor = page["next_cursor"]
    assert seen == ids[::-1]
    assert cursor is None


def test_list_by_state(app: App) -> None:
    cancelled, queued = submit(app)["id"], submit(app)["id"]
    app.post(f"{API}/jobs/{cancelled}/cancel")
    assert [job["id"] for job in app.get(f"{API}/jobs?state=cancelled").json()["items"]] == [cancelled]
    assert [job["id"] for job in app.get(f"{API}/jobs?state=queued").json()["items"]] == [queued]
    unknown = app.get(f"{API}/jobs?state=sleeping")
    assert unknown.status_code == 422
    assert "'queued', 'running', 'paused', 'finished', 'failed' or 'cancelled'" in unknown.json()["detail"]


def test_pause_resume_cancel_delete(app: App) -> None:
    path = f"{API}/jobs/{submit(app)['id']}"
    assert app.post(f"{path}/pause").json()["state"] == "paused"
    assert app.post(f"{path}/resume").json()["state"] in ("queued", "running")
    refused = app("DELETE", path)
    assert refused.status_code == 409
    assert "finished" in refused.json()["detail"]
    cancelled = app.post(f"{path}/cancel").json()
    assert cancelled["state"] == "cancelled"
    assert app.post(f"{path}/cancel").json() == cancelled
    late = app.post(f"{path}/resume")
    assert (late.status_code, late.json()["type"]) == (409, "urn:geoswarm:error:invalid-transition")
    assert "paused" in late.json()["detail"]
    deleted = app("DELETE", path)
    assert (deleted.status_code, deleted.content) == (204, b"")
    assert app.get(path).status_code == 404


@pytest.mark.parametrize(
    ("method", "suffix"),
    [
        ("GET", ""),
        ("DELETE", ""),
        ("GET", "/problem"),
        ("POST", "/cancel"),
        ("POST", "/pause"),
        ("POST", "/resume"),
        ("GET", "/best"),
        ("GET", "/generations"),
        ("GET", "/evaluations"),
        ("GET", "/evaluations?format=csv"),
        ("GET", "/events"),
    ],
)
def test_an_unknown_job_is_not_found(app: App, method: str, suffix: str) -> None:
    answer = app(method, f"{API}/jobs/nobody{suffix}")
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["title"] == "Job not found"
    assert "'nobody'" in answer.json()["detail"]


@pytest.mark.parametrize("job_id", ["a%00b", "x" * 100, "%F0%9F%92%A9", "a%20b", "..%2fjobs"])
@pytest.mark.parametrize("prefix", [f"{API}/jobs/", "/jobs/"])
def test_an_id_that_can_be_none_is_not_found(app: App, prefix: str, job_id: str) -> None:
    assert app.get(prefix + job_id).status_code == 404


def test_a_bad_problem_is_refused_with_every_mistake_and_nothing_is_stored(app: App) -> None:
    problem = line_problem(parameters={"a": {"lower": 2, "upper": 1}, "b": {"lower": 0, "upper": 4, "scale": "log"}})
    answer = app.post(f"{API}/jobs", json=problem)
    detail = answer.json()
    assert answer.status_code == 422
    assert detail["type"] == "urn:geoswarm:error:invalid-problem"
    assert {issue["path"].partition(".lower")[0] for issue in detail["issues"]} >= {"parameters.a", "parameters.b"}
    assert app.get(f"{API}/jobs").json()["items"] == []


def test_constraints_that_nobody_can_satisfy_are_refused(app: App) -> None:
    answer = app.post(f"{API}/jobs", json=line_problem(constraints=["a > b + 10"]))
    assert answer.status_code == 422
    assert answer.json()["issues"][0]["path"].startswith("constraints")


def test_files_are_not_read_from_the_server(app: App) -> None:
    observations = [{"series": "y", "file": "/etc/hosts"}]
    answer = app.post(f"{API}/jobs", json=line_problem(observations=observations))
    assert answer.status_code == 422
    assert "file" in answer.json()["issues"][0]["path"]


@pytest.mark.parametrize(
    ("content", "media_type", "status", "said"),
    [
        (b'{"name": "a", "name": "b"}', "application/json", 400, "given twice"),
        (b'{"name": ', "application/json", 400, "line 1"),
        (b"\xff\xfe", "application/json", 400, "UTF-8"),
        (b"[1, 2]", "application/json", 400, "mapping"),
        (b"", "application/json", 400, "JSON syntax error"),
        (b"a: [", "application/yaml", 400, "YAML syntax error"),
        (b"{}", "text/plain", 415, "application/json or application/yaml"),
        (b"{}", None, 415, "application/json or application/yaml"),
        (b"[" * 100_000, "application/json", 400, "nested"),
    ],
)
@pytest.mark.parametrize("path", ["/jobs", "/problems/check"])
def test_a_body_that_cannot_be_read_is_reported(
    app: App, path: str, content: bytes, media_type: str | None, status: int, said: str
) -> None:
    headers = {} if media_type is None else {"Content-Type": media_type}
    answer = app.post(API + path, content=content, headers=headers)
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    assert said in answer.json()["detail"]


def test_a_body_over_the_limit_is_refused_with_or_without_its_length(service: JobService) -> None:
    app = App(service, ApiSettings(max_body_bytes=1000))
    text = json.dumps(line_problem(name="x" * 1000)).encode()
    told = app.post(f"{API}/jobs", content=text, headers={"Content-Type": "application/json"})

    async def chunks() -> Any:
        for start in range(0, len(text), 100):
            yield text[start : start + 100]

    streamed = app.post(f"{API}/jobs", content=chunks(), headers={"Content-Type": "application/json"})
    for answer in (told, streamed):
        assert answer.status_code == 413
        assert "1000 bytes" in answer.json()["detail"]


def test_an_empty_idempotency_key_is_refused(app: App) -> None:
    answer = app.post(f"{API}/jobs", json=line_problem(), headers={"Idempotency-Key": ""})
    assert answer.status_code == 422
    assert "idempotency-key" in answer.json()["issues"][0]["path"]


@pytest.mark.parametrize(
    "query", ["generations?after=99999999999999999999", "evaluations?generation=9223372036854775808"]
)
def test_numbers_beyond_every_database_are_refused(app: App, query: str) -> None:
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    assert app.get(f"{API}/jobs/{job}/{query}").status_code == 422


def test_tags_and_note_are_replaced_and_found(app: App) -> None:
    job = submit(app)
    path = f"{API}/jobs/{job['id']}"
    assert (job["tags"], job["note"]) == ([], None)
    changed = app("PATCH", path, json={"tags": [" dam ", "B 2", "dam"], "note": "*Disturbed*\n"}).json()
    assert (changed["tags"], changed["note"]) == (["B 2", "dam"], "*Disturbed*\n")
    assert app("PATCH", path, json={"note": ""}).json()["tags"] == ["B 2", "dam"]
    found = app.get(f"{API}/jobs?tag=dam").json()["items"]
    assert [(one["id"], one["tags"], one["note"]) for one in found] == [(job["id"], ["B 2", "dam"], None)]
    assert app.get(f"{API}/jobs?tag=da").json()["items"] == []
    both = app("PATCH", path, json={"tags": [], "stopping": {"max_evaluations": 90}}).json()
    assert (both["tags"], both["max_evaluations"]) == ([], 90)


def test_a_job_has_its_new_name_everywhere(app: App) -> None:
    job = submit(app)
    path = f"{API}/jobs/{job['id']}"
    changed = app("PATCH", path, json={"name": "Dam, core", "stopping": {"max_evaluations": 90}}).json()
    assert (changed["name"], changed["max_evaluations"]) == ("Dam, core", 90)
    assert app("PATCH", path, json={"note": "x"}).json()["name"] == "Dam, core"
    assert [one["id"] for one in app.get(f"{API}/jobs?q=core").json()["items"]] == [job["id"]]
    problem = app.get(f"{path}/problem").json()
    assert (problem["name"], problem["stopping"]) == ("Dam, core", {"max_evaluations": 90})
    for page in ("", "/fit", "/data", "/search", "/statistics"):
        shown = app.get(f"/jobs/{job['id']}{page}", headers={"Accept": "text/html"}).text
        assert "Dam, core · geoswarm</title>" in shown
        assert ">Dam, core</span>" in shown


def test_a_renamed_job_is_still_the_one_of_its_request(app: App) -> None:
    key = {"Idempotency-Key": "monday"}
    job = app.post(f"{API}/jobs", json=line_problem(), headers=key).json()
    app("PATCH", f"{API}/jobs/{job['id']}", json={"name": "other"})
    again = app.post(f"{API}/jobs", json=line_problem(), headers=key)
    assert (again.status_code, again.json()["id"], again.json()["name"]) == (200, job["id"], "other")
    assert app.post(f"{API}/jobs", json=line_problem(name="other"), headers=key).status_code == 409


@pytest.mark.parametrize(
    ("given", "where"),
    [
        ({}, ""),
        ({"name": ""}, "name"),
        ({"name": "x" * 201}, "name"),
        ({"name": "a\nb"}, "name"),
        ({"name": "a\0b"}, "name"),
        ({"name": 7}, "name"),
        ({"tags": ["a,b"]}, "tags.0"),
        ({"tags": ["  "]}, "tags.0"),
        ({"tags": ["x" * 41]}, "tags.0"),
        ({"tags": [str(n) for n in range(21)]}, "tags"),
        ({"note": "a\0b"}, "note"),
        ({"tags": ["a\nb"]}, "tags.0"),
        ({"note": "x" * 10_001}, "note"),
    ],
)
def test_tags_and_notes_that_cannot_be_kept_are_refused(app: App, given: dict[str, Any], where: str) -> None:
    path = f"{API}/jobs/{submit(app)['id']}"
    answer = app("PATCH", path, json=given)
    assert answer.status_code == 422
    issue = answer.json()["issues"][0]
    assert where in str(issue["path"])
    assert "pattern" not in issue["message"]
    assert (app.get(path).json()["name"], app.get(path).json()["tags"]) == ("line", [])
