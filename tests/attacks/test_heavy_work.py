"""Requests that calculate for ever, die or take all memory: they end, and nobody else notices."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from geoswarm.solver.system.processes import descendants
from tests.attacks.attacks import bad
from tests.attacks.services import Service, serving, watched
from tests.integration.engines import PATIENCE, wait_for
from tests.servers import free_port

OTHERS = ("problems/check", "jobs")  # work on a problem in the same way
LIMITS = {"GEOSWARM_COMPUTE_SECONDS": "10", "GEOSWARM_COMPUTE_MEMORY_MB": "900"}


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("attacked"), free_port(), "--workers", "1", **LIMITS) as running:
        yield running


@pytest.mark.parametrize(
    ("builds", "detail", "title"),
    [
        ("crash", "was ended by SIGSEGV", "Process ended"),
        ("hang", "took longer than 10 s", "Too heavy"),
        ("eat", "used more than 900 MiB of memory", "Too heavy"),
        ("raise", "cannot be built: it raised SilentError", "Invalid problem"),
    ],
)
@pytest.mark.parametrize(
    "route", ["problems/read", *(pytest.param(r, marks=pytest.mark.slow) for r in ("problems/check", "jobs"))]
)
@pytest.mark.slow
def test_a_model_that_fails_while_it_is_built_fails_its_request_alone(
    service: Service, builds: str, detail: str, title: str, route: str
) -> None:
    key = service.key_of("attacker")
    with service.client(key) as client:
        answer = client.post(f"/api/v1/{route}", json=bad(builds))
        assert detail in answer.text
        assert answer.status_code == (200 if route == "problems/read" and builds == "raise" else 422)
        assert answer.status_code == 200 or answer.json()["title"] == title
        assert client.post("/api/v1/problems/read", json=bad()).status_code == 200


@pytest.mark.slow
@pytest.mark.timing  # how long a neighbour waits
def test_a_neighbour_that_hangs_everything_is_not_noticed(service: Service) -> None:
    attacker, victim = service.key_of("attacker"), service.key_of("victim")

    def attack() -> None:
        with service.client(attacker) as client:
            answer = client.post("/api/v1/problems/check", json=bad("hang"))
            assert answer.status_code in (422, 503), answer.text

    attacks = [threading.Thread(target=attack) for _ in range(30)]
    with watched(service, victim) as seconds, service.client(victim) as client:
        for thread in attacks:
            thread.start()
        job = client.post("/api/v1/jobs", json=bad())
        assert job.status_code == 201, job.text
        place = f"/api/v1/jobs/{job.json()['id']}"
        wait_for(lambda: client.get(place).json()["state"] == "finished", "the victim's job")
        assert client.get(f"{place}/statistics").status_code == 200
        for thread in attacks:
            thread.join()
    assert len(seconds) > 20
    assert sorted(seconds)[len(seconds) // 2] < 1.0


# 15 s; tests/api/compute/test_stopping.py cancels a request without a service
@pytest.mark.slow
def test_a_request_whose_client_has_left_is_ended(tmp_path: Path) -> None:
    with serving(tmp_path, free_port(), "--workers", "1", GEOSWARM_COMPUTE_SECONDS="3600") as service:
        body = json.dumps(bad("hang"))
        head = f"POST /api/v1/problems/read HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {service.key}\r\n"
        head += f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
        with socket.create_connection(("127.0.0.1", urlsplit(service.url).port or 0), timeout=PATIENCE) as client:
            client.sendall((head + body).encode())
            wait_for(lambda: _hangs(service), "a request that hangs")
        wait_for(lambda: not _hangs(service), "the end of what hangs")
        with service.client() as other:
            assert other.post("/api/v1/problems/read", json=bad()).status_code == 200


def _hangs(service: Service) -> bool:
    """Whether a process of the service is one that answers requests and does so now."""
    with service.client() as client:
        return "geoswarm_compute_busy 0" not in client.get("/metrics").text


@pytest.mark.slow
def test_the_service_takes_its_processes_with_it(tmp_path: Path) -> None:
    with serving(tmp_path, free_port(), "--workers", "1") as running:
        with running.client() as client:
            assert client.post("/api/v1/problems/read", json=bad()).status_code == 200
        below = descendants(running.pid)
        assert len(below) >= 2
    wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in below), "the end of all processes")
