"""A real service under attack, and the keys of two owners."""

from __future__ import annotations

import os
import secrets
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx

from tests.integration.engines import wait_for

__all__ = ["ROOT", "Service", "serving"]

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Service:
    """A service that runs."""

    url: str
    pid: int
    key: str

    def client(self, key: str | None = None, seconds: float = 300.0) -> httpx.Client:
        """A client with a key; the administrator's when none is given."""
        headers = {"Authorization": f"Bearer {key or self.key}"}
        return httpx.Client(base_url=self.url, headers=headers, timeout=seconds, trust_env=False)

    def key_of(self, owner: str, role: str = "submit") -> str:
        """A new key."""
        with self.client() as client:
            answer = client.post("/api/v1/keys", json={"owner": owner, "role": role})
            assert answer.status_code == 201, answer.text
            return str(answer.json()["key"])


@contextmanager
def serving(folder: Path, port: int, *arguments: str, **environment: str) -> Iterator[Service]:
    """``geoswarm serve`` on a database in a folder, the models of the tests installed; ``log`` there is its log."""
    key = secrets.token_urlsafe(32)
    models = str(ROOT / "tests" / "models")
    with (folder / "log").open("wb") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "geoswarm", "serve", "--port", str(port), *arguments],
            cwd=folder,
            env={
                **os.environ,
                "PYTHONPATH": os.pathsep.join([models, str(ROOT)]),
                "GEOSWARM_API_KEY": key,
                "GEOSWARM_DATABASE_URL": f"sqlite:///{folder / 'jobs.db'}",
                **environment,
            },
            stderr=log,
        )
    service = Service(f"http://127.0.0.1:{port}", process.pid, key)

    def live() -> bool:
        assert process.poll() is None, "the service has ended"
        try:
            return httpx.get(f"{service.url}/health/live", trust_env=False).status_code == 200
        except httpx.TransportError:
            return False

    try:
        wait_for(live, "the service")
        yield service
    finally:
        process.terminate()
        try:
            process.wait(60.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


@contextmanager
def watched(service: Service, key: str) -> Iterator[list[float]]:
    """What a second owner waits for a list of jobs [s], again and again while the body runs."""
    seconds: list[float] = []
    stop = threading.Event()

    def look() -> None:
        with service.client(key) as client:
            while not stop.wait(0.05):
                began = time.monotonic()
                assert client.get("/api/v1/jobs").status_code == 200
                seconds.append(time.monotonic() - began)

    thread = threading.Thread(target=look)
    thread.start()
    try:
        yield seconds
    finally:
        stop.set()
        thread.join()
