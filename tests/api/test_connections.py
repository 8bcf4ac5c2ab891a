"""Many connections, and such that keep the service waiting: others are answered, and the log stays short."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import httpx
import pytest

import geoswarm.api.access.connections
from geoswarm.api import ApiSettings
from geoswarm.api.access.connections import LEAST_CONNECTIONS, Phase, most_connections
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, LiveServer, line_problem, live_server, wait_until
from tests.integration.engines import PATIENCE

SCRIPT = """
import os, resource, sys, threading
from geoswarm.api import ApiSettings, serve
from geoswarm.workers.waker import NoWaker
from geoswarm.workers.logs import start_logging
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store

soft, hard = int(sys.argv[1]), int(sys.argv[2])
resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))

def waste():
    for _ in sys.stdin:
        files = []
        try:
            while True:
                files.append(os.open("/dev/null", os.O_RDONLY))
        except OSError:
            print("wasted", flush=True)
        sys.stdin.readline()
        for file in files:
            os.close(file)

threading.Thread(target=waste, daemon=True).start()
start_logging("warning")
settings = Settings(database_url="sqlite:///jobs.db")
store = Store(settings)
patient = ApiSettings(head_seconds=10_000)  # who waits for the end of an unfinished head waits for ever
service = JobService(store, NoWaker(), settings)
serve(service, port=0, settings=patient, on_started=lambda url: print(url, flush=True))
store.close()
"""


@contextmanager
def served(folder: Path, soft: int, hard: int) -> Iterator[tuple[str, Path, subprocess.Popen[bytes]]]:
    """A service in a process of its own, which may open so many files."""
    log = folder / "log"
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    with log.open("wb") as errors:
        process = subprocess.Popen(
            [sys.executable, "-c", SCRIPT, str(soft), str(hard)],
            cwd=folder,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
        )
    try:
        assert process.stdout is not None
        yield process.stdout.readline().decode().strip(), log, process
    finally:
        process.kill()
        process.communicate()


def connect(url: str, sent: bytes, buffer: int | None = None) -> socket.socket:
    """Open a connection and send something."""
    raw = socket.socket()
    if buffer is not None:
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
    raw.settimeout(60)
    raw.connect(("127.0.0.1", int(url.rsplit(":", 1)[1])))
    raw.sendall(sent)
    return raw


def is_closed(raw: socket.socket) -> bool:
    """Whether the other side has closed."""
    raw.settimeout(0.01)
    try:
        return raw.recv(1_000_000) == b""
    except TimeoutError:
        return False
    except ConnectionError:
        return True


@pytest.mark.parametrize(("soft", "hard"), [pytest.param(256, 4096, marks=pytest.mark.slow), (256, 256)])
def test_unfinished_heads_do_not_keep_others_out(tmp_path: Path, soft: int, hard: int) -> None:
    with served(tmp_path, soft, hard) as (url, log, _), ExitStack() as attack:
        for number in range(1100):
            attack.enter_context(connect(url, b"GET / HTTP/1.1\r\nHost: localhost\r\nX-Number: %d" % number))
        for _ in range(10):
            assert httpx.get(f"{url}/health/live", timeout=PATIENCE).status_code == 200
            assert httpx.get(f"{url}{API}/jobs", timeout=PATIENCE).status_code == 200
        assert log.stat().st_size < 2000


def test_unfinished_sign_ins_do_not_keep_others_out(service: JobService) -> None:
    key, _ = ApiKeys(service.store).create("alice", "submit")
    begun = b"POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nContent-Length: 50000\r\n\r\n{"
    settings = ApiSettings(require_key=True, max_connections=50, body_seconds=60)
    with live_server(service, settings) as server, ExitStack() as attack:
        for _ in range(120):
            attack.enter_context(connect(server.url, begun))
        answer = httpx.get(f"{server.url}{API}/jobs", headers={"X-API-Key": key}, timeout=PATIENCE)
        assert answer.status_code == 200


@pytest.mark.slow
def test_no_descriptor_left_is_survived_with_a_short_log(tmp_path: Path) -> None:
    with served(tmp_path, 256, 256) as (url, log, process), ExitStack() as waiting:
        assert httpx.get(f"{url}/health/live", timeout=PATIENCE).status_code == 200
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(b"waste\n")
        process.stdin.flush()
        assert process.stdout.readline() == b"wasted\n"
        for _ in range(20):
            waiting.enter_context(connect(url, b"GET / HTTP/1.1\r\n"))
        wait_until(lambda: "no connection can be accepted now: Too many open files" in log.read_text())
        process.stdin.write(b"give back\n")
        process.stdin.flush()
        assert httpx.get(f"{url}/health/live", timeout=PATIENCE).status_code == 200
        text = log.read_text()
        assert "Traceback" not in text
        assert len(text.splitlines()) <= 5


def test_the_head_of_a_request_must_arrive_in_time(service: JobService) -> None:
    with live_server(service, ApiSettings(head_seconds=0.5)) as server:
        silent, begun = connect(server.url, b""), connect(server.url, b"GET / HT")
        with silent, begun:
            wait_until(lambda: is_closed(silent) and is_closed(begun))


def test_the_rest_of_an_answered_body_must_come_soon(service: JobService, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(geoswarm.api.access.connections, "REST_SECONDS", 0.5)
    with live_server(service) as server:
        head = b"POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5000000\r\n\r\n"
        with connect(server.url, head + b" " * 1000) as raw:
            assert b" 413 " in raw.recv(100_000)
            wait_until(lambda: is_closed(raw))


@pytest.mark.slow
def test_who_does_not_read_an_answer_is_left(service: JobService, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(geoswarm.api.access.connections, "STALL_SECONDS", 0.5)
    x = [i / 7 for i in range(190_000)]
    long = line_problem(observations=[{"series": "y", "points": {"x": x, "y": x}}])
    with live_server(service) as server:
        job = httpx.post(f"{server.url}{API}/jobs", json=long, timeout=120).json()["id"]
        ask = f"GET {API}/jobs/{job}/problem HTTP/1.1\r\nHost: localhost\r\n\r\n"
        connections = server.server.config.connections
        with connect(server.url, ask.encode(), buffer=4096):
            wait_until(lambda: connections.open == 1)
            wait_until(lambda: connections.open == 0)


def streams(server: LiveServer, key: str, job: str) -> Iterator[int]:
    """Open streams one after the other and tell how each was answered."""
    with (
        httpx.Client(base_url=server.url, headers={"X-API-Key": key}, timeout=PATIENCE) as client,
        ExitStack() as opened,
    ):
        while True:
            yield opened.enter_context(client.stream("GET", f"{API}/jobs/{job}/events")).status_code


def test_event_streams_are_limited_for_each_key_and_in_all(service: JobService) -> None:
    ring = ApiKeys(service.store)
    keys = [ring.create("alice", "submit")[0], *(ring.create("alice", "read")[0] for _ in range(2))]
    settings = ApiSettings(require_key=True, event_streams_per_key=3, event_streams=5)
    with live_server(service, settings) as server, httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        job = client.post(f"{API}/jobs", json=line_problem(), headers={"X-API-Key": keys[0]}).json()["id"]
        first, second, third = (streams(server, key, job) for key in keys)
        assert [next(first) for _ in range(4)] == [200, 200, 200, 429]
        assert [next(second) for _ in range(3)] == [200, 200, 503]
        assert next(third) == 503
        refused = client.get(f"{API}/jobs/{job}/events", headers={"X-API-Key": keys[0]})
        assert "open event streams, 3 of this API key, is reached" in refused.json()["detail"]
        assert refused.headers["retry-after"]
        first.close()  # type: ignore[attr-defined]  # a generator
        wait_until(lambda: next(third) == 200)
        second.close()  # type: ignore[attr-defined]
        third.close()  # type: ignore[attr-defined]
        wait_until(lambda: server.server.config.app.state.streams.taken == 0, 30)  # type: ignore[union-attr]


def test_unanswered_requests_of_a_key_are_limited(service: JobService) -> None:
    ring = ApiKeys(service.store)
    alice, ben = ring.create("alice", "submit")[0], ring.create("ben", "submit")[0]
    begun = f"POST {API}/jobs HTTP/1.1\r\nHost: localhost\r\nX-API-Key: {alice}\r\nContent-Length: 9\r\n\r\n{{"
    settings = ApiSettings(require_key=True, requests_at_once=3)
    with live_server(service, settings) as server, ExitStack() as opened:
        for _ in range(3):
            opened.enter_context(connect(server.url, begun.encode()))
        ask = {
            key: lambda key=key: httpx.get(f"{server.url}{API}/jobs", headers={"X-API-Key": key}, timeout=PATIENCE)
            for key in (alice, ben)
        }

        def refused() -> bool:
            """Whether there is no place; one that was asked too early took it from an unfinished request."""
            if ask[alice]().status_code == 429:
                return True
            opened.enter_context(connect(server.url, begun.encode()))
            return False

        wait_until(refused)
        assert ask[ben]().status_code == 200


def test_when_all_connections_are_being_answered_others_wait(service: JobService) -> None:
    begun = f"POST {API}/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n{{".encode()
    with live_server(service, ApiSettings(max_connections=16, body_seconds=60)) as server:
        connections = server.server.config.connections
        busy = [connect(server.url, begun) for _ in range(16)]
        wait_until(lambda: [c.phase for c in connections._live].count(Phase.BUSY) == 16)
        with connect(server.url, b"GET /health/live HTTP/1.1\r\nHost: localhost\r\n\r\n") as waiting:
            waiting.settimeout(1)
            with pytest.raises(TimeoutError):
                waiting.recv(1000)
            busy.pop().close()
            waiting.settimeout(60)
            assert waiting.recv(1000).startswith(b"HTTP/1.1 200")
        for raw in busy:
            raw.close()


@pytest.mark.parametrize(
    ("wanted", "descriptors", "most"), [(1000, 20_000, 1000), (1000, 1024, 412), (1000, 100, LEAST_CONNECTIONS)]
)
def test_descriptors_are_kept_in_reserve(wanted: int, descriptors: int, most: int) -> None:
    assert most_connections(wanted, descriptors) == most
