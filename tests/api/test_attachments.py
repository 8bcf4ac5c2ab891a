"""Files attached to jobs, over HTTP: what is answered, with which headers, to whom."""

from __future__ import annotations

import hashlib
import socket
import time
from urllib.parse import unquote

import httpx
import pytest
from pydantic import SecretStr

from geoswarm.api import ApiSettings
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, App, line_problem, live_server
from tests.integration.engines import PATIENCE

JPEG = b"\xff\xd8\xff\xe0 a photo"
PDF = b"%PDF-1.7 a report"


@pytest.fixture
def files(app: App) -> str:
    """Path of the files of a job."""
    return f"{API}/jobs/{app.post(f'{API}/jobs', json=line_problem()).json()['id']}/attachments"


def attach(app: App, files: str, name: str, content: bytes) -> httpx.Response:
    return app.post(files, params={"name": name}, content=content)


def test_a_file_is_attached_listed_downloaded_and_deleted(app: App, files: str) -> None:
    made = attach(app, files, "Schürf 2.jpg", JPEG)
    assert made.status_code == 201
    sha256 = hashlib.sha256(JPEG).hexdigest()
    assert made.headers["location"] == f"{files}/{sha256}"
    expected = {"sha256": sha256, "name": "Schürf 2.jpg", "media_type": "image/jpeg", "size": len(JPEG)}
    assert {name: value for name, value in made.json().items() if name != "created_at"} == expected
    again = attach(app, files, "other name.jpg", JPEG)
    assert (again.status_code, again.json()) == (200, made.json())
    assert app.get(files).json() == {"items": [made.json()]}
    downloaded = app.get(made.headers["location"])
    assert downloaded.content == JPEG
    assert app("DELETE", made.headers["location"]).status_code == 204
    assert app.get(files).json() == {"items": []}
    gone = app("DELETE", made.headers["location"])
    assert (gone.status_code, gone.json()["type"]) == (404, "urn:geoswarm:error:attachment-not-found")
    assert app.get(made.headers["location"]).status_code == 404


@pytest.mark.parametrize(
    ("name", "content", "shown"),
    [
        ("a.jpg", JPEG, "inline"),
        ("a.pdf", PDF, "attachment"),
        ("a.txt", "Prüfung".encode("latin-1"), "attachment"),
        ('a"; x=y.csv', b"1;2", "attachment"),
    ],
)
def test_nothing_in_a_file_acts_as_a_page_of_the_service(
    app: App, files: str, name: str, content: bytes, shown: str
) -> None:
    place = attach(app, files, name, content).headers["location"]
    answer = app.get(place)
    assert answer.content == content
    kind, quoted = answer.headers["content-disposition"].split("; filename*=UTF-8''")
    assert (kind, unquote(quoted)) == (shown, name)
    assert ";" not in quoted
    assert "charset" not in answer.headers["content-type"]
    assert answer.headers["x-content-type-options"] == "nosniff"
    policy = answer.headers["content-security-policy"]
    assert policy.startswith("sandbox; default-src 'none'")
    assert "script" not in policy
    assert answer.headers["cross-origin-resource-policy"] == "same-origin"


def test_a_file_is_sent_again_only_when_it_is_another_one(app: App, files: str) -> None:
    place = attach(app, files, "a.jpg", JPEG).headers["location"]
    head = app("HEAD", place)
    assert (head.status_code, head.content) == (200, b"")
    assert head.headers["content-length"] == str(len(JPEG))
    assert head.headers["etag"] == f'"{hashlib.sha256(JPEG).hexdigest()}"'
    known = app.get(place, headers={"If-None-Match": head.headers["etag"]})
    assert (known.status_code, known.content) == (304, b"")
    for header in ("etag", "cache-control", "content-security-policy", "content-disposition", "content-type"):
        assert known.headers[header] == head.headers[header]
    assert app.get(place, headers={"If-None-Match": '"another"'}).status_code == 200
    assert "no-store" not in head.headers["cache-control"]


def test_mistakes_are_named_by_their_field(app: App, files: str) -> None:
    answer = attach(app, files, "a.svg", b"<svg/>")
    assert (answer.status_code, answer.json()["type"]) == (422, "urn:geoswarm:error:invalid-attachment")
    (issue,) = answer.json()["issues"]
    assert issue["path"] == "name"
    assert "accepted: images (PNG, JPEG, WebP), PDF" in issue["message"]
    empty = app.post(files, params={"name": "a.jpg"})
    assert (empty.status_code, empty.json()["issues"][0]["path"]) == (422, "content")
    assert app.post(files, content=JPEG).status_code == 422
    for strange in ("ABC", "%00", "a" * 10_000):
        assert app.get(f"{files}/{strange}").json()["type"] == "urn:geoswarm:error:attachment-not-found"
    assert attach(app, f"{API}/jobs/0123456789abcdef/attachments", "a.jpg", JPEG).status_code == 404


def test_keys_that_only_read_see_files_and_change_none(service: JobService) -> None:
    app = App(service, ApiSettings(api_key=SecretStr("k" * 40)))
    keys = {role: ApiKeys(service.store).create("alice", role)[0] for role in ("submit", "read", "agent")}
    keys["stranger"] = ApiKeys(service.store).create("bob", "submit")[0]
    app.headers = {"X-API-Key": keys["submit"]}
    files = f"{API}/jobs/{app.post(f'{API}/jobs', json=line_problem()).json()['id']}/attachments"
    place = attach(app, files, "a.jpg", JPEG).headers["location"]
    for who, read, changed in (("read", 200, 403), ("agent", 403, 403), ("stranger", 404, 404)):
        app.headers = {"X-API-Key": keys[who]}
        assert app.get(place).status_code == app("HEAD", place).status_code == app.get(files).status_code == read
        assert attach(app, files, "b.jpg", JPEG + b"b").status_code == changed
        assert app("DELETE", place).status_code == changed
    app.headers = {}
    assert app.get(place).status_code == 401


def test_a_body_that_is_cut_off_attaches_nothing(service: JobService) -> None:
    with live_server(service) as server, httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        files = f"{API}/jobs/{client.post(f'{API}/jobs', json=line_problem()).json()['id']}/attachments"
        with socket.create_connection(server.listener.getsockname()[:2], timeout=PATIENCE) as raw:
            head = f"POST {files}?name=a.jpg HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3000000\r\n\r\n"
            raw.sendall(head.encode() + JPEG + b"x" * 1_000_000)
        time.sleep(0.2)
        assert client.get(files).json() == {"items": []}
        large = JPEG + b"y" * 3_000_000
        made = client.post(files, params={"name": "a.jpg"}, content=large)
        assert made.status_code == 201
        assert client.get(made.headers["location"]).content == large
        chunked = client.post(files, params={"name": "b.jpg"}, content=iter([JPEG, b"z" * 100_000]))
        assert (chunked.status_code, chunked.json()["size"]) == (201, len(JPEG) + 100_000)


def test_a_file_that_is_too_large_is_refused_before_it_is_sent(service: JobService) -> None:
    with live_server(service, ApiSettings(max_body_bytes=100_000)) as server:
        files = f"{server.url}{API}/jobs/0123456789abcdef/attachments?name=a.jpg"
        answer = httpx.post(files, content=b"x" * 100_001, timeout=PATIENCE)
    assert answer.status_code == 413
    assert "100000 bytes" in answer.json()["detail"]
