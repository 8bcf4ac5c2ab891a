from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path

import httpx
import pytest

import geoswarm.api.server
from geoswarm.api import ApiSettings, PortInUseError, bind, serve
from geoswarm.api.server import base_url
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, LiveServer, line_problem
from tests.integration.engines import PATIENCE
from tests.variants import variants


def test_a_port_in_use_is_told_before_anything_starts(service: JobService) -> None:
    with bind("127.0.0.1", 0) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(PortInUseError, match=f"cannot listen on 127.0.0.1:{port}: the port is already in use"):
            serve(service, "127.0.0.1", port)


@pytest.mark.parametrize(("host", "port"), [("no-such-host.invalid", 80), ("127.0.0.1", 70_000), ("192.0.2.1", 8765)])
def test_an_address_that_cannot_be_had_is_reported(host: str, port: int) -> None:
    with pytest.raises(PortInUseError, match=f"cannot listen on {host}:{port}"):
        bind(host, port)


def test_urls_of_listening_sockets() -> None:
    with bind("127.0.0.1", 0) as listener:
        assert base_url(listener) == f"http://127.0.0.1:{listener.getsockname()[1]}"
    with bind("0.0.0.0", 0) as listener:
        assert base_url(listener) == f"http://127.0.0.1:{listener.getsockname()[1]}"


def test_stopping_ends_open_streams(service: JobService, monkeypatch: pytest.MonkeyPatch) -> None:
    """As an end of the stream, not because the time that answers have is over."""
    monkeypatch.setattr(geoswarm.api.server, "GRACE_SECONDS", 10_000)
    server = LiveServer(service, ApiSettings())
    job = httpx.post(f"{server.url}{API}/jobs", json=line_problem(), timeout=PATIENCE).json()["id"]
    ended = threading.Event()
    first = threading.Event()

    def listen() -> None:
        with httpx.stream("GET", f"{server.url}{API}/jobs/{job}/events", timeout=PATIENCE) as answer:
            for _ in answer.iter_lines():
                first.set()
        ended.set()

    thread = threading.Thread(target=listen)
    thread.start()
    try:
        assert first.wait(PATIENCE)
    finally:
        server.stop()
    thread.join(PATIENCE)
    assert ended.is_set()


def test_a_body_over_the_limit_gets_its_answer_over_a_real_connection(service: JobService) -> None:
    server = LiveServer(service, ApiSettings(max_body_bytes=10_000))
    try:
        answer = httpx.post(
            f"{server.url}{API}/jobs", content=b" " * 3_000_000, headers={"Content-Type": "application/json"}
        )
        assert answer.status_code == 413
        assert httpx.get(f"{server.url}/health/live", timeout=PATIENCE).status_code == 200
    finally:
        server.stop()


def test_a_broken_request_gets_no_traceback(server: LiveServer) -> None:
    with socket.create_connection(server.listener.getsockname()[:2], timeout=PATIENCE) as raw:
        raw.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: x\r\n\r\n")
        answer = raw.recv(10_000)
    assert answer.startswith(b"HTTP/1.1 400")
    assert b"Traceback" not in answer


SCRIPT = """
import sys
import geoswarm.api.server
from geoswarm.api import serve
from geoswarm.workers.waker import NoWaker
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store

geoswarm.api.server.GRACE_SECONDS = 10_000  # it would wait for an open stream as long
settings = Settings(database_url="sqlite:///jobs.db")
store = Store(settings)
serve(JobService(store, NoWaker(), settings), port=0, on_started=lambda url: print(url, flush=True))
store.close()
print("closed", flush=True)
"""


@pytest.mark.parametrize("number", variants([signal.SIGTERM, signal.SIGINT], {signal.SIGTERM}))
def test_a_signal_ends_the_process_gracefully_with_an_open_stream(tmp_path: Path, number: signal.Signals) -> None:
    root = Path(__file__).parents[2]
    environment = os.environ | {"PYTHONPATH": str(root)}
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT], cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    try:
        assert process.stdout is not None
        url = process.stdout.readline().decode().strip()
        job = httpx.post(f"{url}{API}/jobs", json=line_problem(), timeout=PATIENCE).json()["id"]
        with httpx.stream("GET", f"{url}{API}/jobs/{job}/events", timeout=PATIENCE) as answer:
            lines = answer.iter_lines()
            assert next(lines).startswith("retry")
            process.send_signal(number)
            assert all(not line.startswith("Traceback") for line in lines)
        output, errors = process.communicate(timeout=PATIENCE)
        assert process.returncode == 0
        assert output.decode().strip() == "closed"
        assert errors.decode() == ""
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()
