"""Bodies of requests, over real connections: how large, how long, and how many at once."""

from __future__ import annotations

import gc
import os
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import httpx
import pytest
from pydantic import SecretStr

from geoswarm.api import ApiSettings
from geoswarm.api.access.intake import LARGE_BODIES, LARGE_PATHS, SMALL_BODY_BYTES
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, App, LiveServer, line_problem, live_server
from tests.integration.engines import PATIENCE

MB = 2**20


@contextmanager
def unfinished(server: LiveServer, path: str, declared: int, sent: bytes, key: str = "") -> Iterator[socket.socket]:
    """A POST whose body has begun and goes on when the test says so."""
    with socket.create_connection(server.listener.getsockname()[:2], timeout=PATIENCE) as raw:
        head = f"POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        head += f"Content-Length: {declared}\r\n" + (f"X-API-Key: {key}\r\n" if key else "") + "\r\n"
        raw.sendall(head.encode())
        raw.sendall(sent)
        yield raw


def status(raw: socket.socket) -> int:
    return int(raw.recv(100_000).split(b" ", 2)[1])


def answers(server: LiveServer, path: str, status: int, key: str, size: int = 1000) -> httpx.Response:
    """Send a whole body until it is answered with a status: what others sent may not have been counted yet."""
    headers = {"X-API-Key": key, "Content-Type": "application/json"}
    for _ in range(300):
        answer = httpx.post(server.url + path, content=b" " * size, headers=headers, timeout=PATIENCE)
        if answer.status_code == status:
            break
        time.sleep(0.05)
    assert answer.status_code == status, answer.text
    return answer


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("POST", "/session"),
        ("POST", "/keys"),
        ("PATCH", "/jobs/0123456789abcdef"),
        ("POST", "/jobs/0123456789abcdef/reweight"),
        ("POST", "/jobs/0123456789abcdef/sensitivity"),
        ("POST", "/jobs/0123456789abcdef/explore"),
        ("POST", "/jobs/0123456789abcdef/cancel"),
        ("GET", "/jobs"),
    ],
)
@pytest.mark.parametrize("declared", [True, False])
def test_small_routes_take_small_bodies(server: LiveServer, method: str, path: str, declared: bool) -> None:
    body = b" " * (SMALL_BODY_BYTES + 1)
    content = body if declared else iter([body[:30_000], body[30_000:]])
    headers = {"Content-Type": "application/json"}
    answer = httpx.request(method, server.url + API + path, content=content, headers=headers, timeout=PATIENCE)
    assert answer.status_code == 413
    assert str(SMALL_BODY_BYTES) in answer.json()["detail"]
    assert answer.headers["x-content-type-options"] == "nosniff"


def test_who_has_no_key_cannot_send_slowly_for_ever(service: JobService) -> None:
    settings = ApiSettings(api_key=SecretStr("k" * 20 + "abcdefghijkl"), body_seconds=0.5)
    with live_server(service, settings) as server, unfinished(server, f"{API}/session", 1000, b"{") as raw:
        assert status(raw) == 408


def test_the_routes_of_large_bodies_are_those_that_take_problems_and_files(app: App) -> None:
    found = set()
    for path, operations in app.get("/openapi.json").json()["paths"].items():
        for method, operation in operations.items():
            content = operation.get("requestBody", {}).get("content", {})
            if {"application/yaml", "application/octet-stream"} & set(content):
                found.add((method.upper(), path))
    attaching = "/api/v1/jobs/{job_id}/attachments"
    assert found == LARGE_BODIES | {("POST", attaching)}
    assert LARGE_PATHS.fullmatch(attaching)


def test_a_body_arrives_whole_whatever_its_size(app: App) -> None:
    for points in (3, 3000, 30_000):
        x = [i / 7 for i in range(points)]
        sent = line_problem(observations=[{"series": "y", "points": {"x": x, "y": x}}])
        made = app.post(f"{API}/jobs", json=sent)
        assert made.status_code == 201
        stored = app.get(f"{API}/jobs/{made.json()['id']}/problem").json()
        assert stored["observations"][0]["points"]["x"] == x


def test_bytes_in_flight_are_limited_for_each_key_and_in_all(service: JobService) -> None:
    keys = [ApiKeys(service.store).create(name, "submit")[0] for name in ("alice", "ben", "carol")]
    settings = ApiSettings(
        require_key=True, max_body_bytes=100_000, body_bytes_per_key=150_000, body_bytes=250_000, body_seconds=60
    )
    path = f"{API}/jobs"
    with live_server(service, settings) as server, ExitStack() as open_requests:
        begun = [open_requests.enter_context(unfinished(server, path, 90_000, b" ", key)) for key in keys[:2]]
        told = answers(server, path, 429, keys[0], 90_000)
        assert "of this API key" in told.json()["detail"]
        assert int(told.headers["retry-after"]) > 0
        told = answers(server, path, 503, keys[2], 90_000)
        assert "at most 250000" in told.json()["detail"]
        assert answers(server, path, 400, keys[2], 1000).json()["type"].endswith("malformed-body")
        for raw in begun:
            raw.sendall(b" " * 89_999)
            assert status(raw) == 400
        for key in keys:
            answers(server, path, 400, key, 90_000)


def test_who_hangs_up_holds_nothing(service: JobService) -> None:
    settings = ApiSettings(max_body_bytes=100_000, body_bytes=150_000, body_seconds=60)
    with live_server(service, settings) as server:
        for _ in range(20):
            with unfinished(server, f"{API}/jobs", 90_000, b" "):
                pass
        assert answers(server, f"{API}/jobs", 400, "", 90_000).json()["type"].endswith("malformed-body")


def memory() -> int:
    """Resident memory of this process, in which the server runs [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_unfinished_bodies_are_not_in_memory(service: JobService) -> None:
    settings = ApiSettings(body_bytes_per_key=400 * MB, body_bytes=400 * MB, body_seconds=120)
    sent = b" " * (10 * MB)
    with live_server(service, settings) as server, ExitStack() as open_requests:
        answers(server, f"{API}/jobs", 400, "")
        gc.collect()
        before = memory()
        for _ in range(10):
            open_requests.enter_context(unfinished(server, f"{API}/jobs", len(sent) + 1, sent))
        most = 0
        for _ in range(20):  # while the service reads what was sent
            answers(server, f"{API}/jobs", 400, "")
            most = max(most, memory())
        assert most - before < 50 * MB
