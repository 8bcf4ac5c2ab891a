"""What a bad neighbour does to a service over HTTP; each attack takes a few seconds and ends by itself.

An attack is given the service and a submit key of its own. It raises when the service answers what it never should.
``python -m tests.attacks.attacks`` runs some at once: in a process of their own, so that nobody else waits for them.
"""

from __future__ import annotations

import json
import random
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from urllib.parse import urlsplit

import httpx

from geoswarm.solver.examples import example_file
from geoswarm.solver.problem.text.reading import read_problem_file
from tests.attacks.services import Service
from tests.models.geoswarm_bad_models import REASONS

__all__ = ["ATTACKS", "bad", "line"]

API = "/api/v1"
REFUSALS = {400, 401, 403, 404, 405, 408, 409, 413, 415, 422, 429, 503}
PATIENCE = 8.0
"""How long an attacker waits for an answer before it leaves [s]."""

Attack = Callable[[Service, str], None]
ATTACKS: dict[str, Attack] = {}


def attack(name: str) -> Callable[[Attack], Attack]:
    """Add an attack to the list."""

    def add(function: Attack) -> Attack:
        ATTACKS[name] = function
        return function

    return add


def bad(builds: str = "", behaviour: str = "good", **changes: Any) -> dict[str, Any]:
    """A problem whose forward model misbehaves."""
    return {
        "forward_model": {"kind": "bad", "builds": builds, "behaviour": behaviour},
        "parameters": {"slope": {"lower": -5, "upper": 5}},
        "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [0, 1, 2]}}],
        "stopping": {"max_evaluations": 12},
        "seed": 1,
        **changes,
    }


def line(points: int = 3, evaluations: int = 40, **changes: Any) -> dict[str, Any]:
    """A cheap problem."""
    x = [float(i) for i in range(points)]
    return {
        "forward_model": {"kind": "formula", "series": {"y": "a + b * x"}},
        "parameters": {"a": {"lower": 0, "upper": 5}, "b": {"lower": 0, "upper": 5}},
        "observations": [{"series": "y", "points": {"x": x, "y": [1.0 + 2.0 * v for v in x]}}],
        "method": {"kind": "monte_carlo", "samples": evaluations},
        "seed": 1,
        **changes,
    }


class Attacker:
    """Asks again and again, and takes every answer that a service may give."""

    def __init__(self, service: Service, key: str | None) -> None:
        self._service = service
        self._key = key

    def ask(self, method: str, path: str, **request: Any) -> httpx.Response | None:
        """Ask once; None when it became too long, or the connection was cut."""
        with self._service.client(self._key, PATIENCE) as client:
            try:
                answer = client.request(method, path, **request)
            except httpx.TransportError:
                return None
        assert answer.status_code < 400 or answer.status_code in REFUSALS, (method, path, answer.status_code)
        assert "Traceback" not in answer.text[:100_000]
        return answer

    def many(self, times: int, method: str, path: str, **request: Any) -> None:
        """Ask so often at once."""
        errors: list[BaseException] = []

        def once() -> None:
            try:
                self.ask(method, path, **request)
            except BaseException as error:  # noqa: BLE001  told by the thread that waits
                errors.append(error)

        threads = [threading.Thread(target=once) for _ in range(times)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for error in errors:
            raise error

    def job(self, document: dict[str, Any]) -> str | None:
        """Submit a job; None when it is refused."""
        answer = self.ask("POST", f"{API}/jobs", json=document)
        return None if answer is None or answer.status_code != 201 else str(answer.json()["id"])

    def finished(self, document: dict[str, Any], seconds: float = 60.0) -> str | None:
        """Submit a job and wait for its end for a while."""
        job = self.job(document)
        until = time.monotonic() + seconds
        while job is not None and time.monotonic() < until:
            answer = self.ask("GET", f"{API}/jobs/{job}")
            if answer is not None and answer.status_code == 200 and answer.json()["state"] == "finished":
                break
            time.sleep(0.2)
        return job


@contextmanager
def raw(service: Service) -> Iterator[Callable[[bytes], socket.socket | None]]:
    """Open connections and send what is given; all are closed at the end."""
    address = urlsplit(service.url)
    with ExitStack() as opened:

        def open_one(data: bytes) -> socket.socket | None:
            try:
                connection = socket.create_connection((str(address.hostname), int(address.port or 0)), timeout=2.0)
                opened.enter_context(connection)
                connection.sendall(data)
            except OSError:  # refused, or cut off again: as it may be
                return None
            return connection

        yield open_one


@attack("long cells and digits")
def _(service: Service, key: str) -> None:
    attacker = Attacker(service, key)
    for text in (f"x,y\n1,{'1' * 40_000}\n", f"x,y\n1,{'a ' * 12_000}\n", "# c\n" * 20_000, "1,2\n" + "9" * 99_000):
        attacker.many(5, "POST", f"{API}/measurements", content=text.encode(), headers={"Content-Type": "text/csv"})


@attack("unknown keys")
def _(service: Service, key: str) -> None:
    attacker = Attacker(service, key)
    attacker.many(3, "POST", f"{API}/jobs", json=line() | {f"key{i}": 1 for i in range(200_000)})
    attacker.many(3, "POST", f"{API}/problems/check", json=line() | {"method": {f"key{i}": 1 for i in range(9000)}})


@attack("merge keys of YAML")
def _(service: Service, key: str) -> None:
    levels = ["a0: &a0 {x: 1}"] + [f"a{i}: &a{i} {{<<: [{', '.join([f'*a{i - 1}'] * 10)}]}}" for i in range(1, 20)]
    headers = {"Content-Type": "application/yaml"}
    attacker = Attacker(service, key)
    for count in (8, 20):
        attacker.many(5, "POST", f"{API}/jobs", content="\n".join(levels[:count]).encode(), headers=headers)


@attack("a slip of a unit")
def _(service: Service, key: str) -> None:
    with example_file("slope") as path:
        document = read_problem_file(path)
    document["observations"] = [{"series": "A.ux", "points": {"x": [1.0], "y": [0.1]}}]
    attacker = Attacker(service, key)
    for length in (1e-4, 5e-324):
        document["forward_model"]["element_length"] = length
        for route in ("jobs", "problems/check", "problems/read"):
            attacker.many(3, "POST", f"{API}/{route}", json=document)


@attack("many checks")
def _(service: Service, key: str) -> None:
    Attacker(service, key).many(30, "POST", f"{API}/problems/check", json=line(40_000))


@attack("models that cannot be built")
def _(service: Service, key: str) -> None:
    attacker = Attacker(service, key)
    for builds in ("crash", "hang", "eat", "raise"):
        attacker.many(4, "POST", f"{API}/problems/read", json=bad(builds))


@attack("models that misbehave")
def _(service: Service, key: str) -> None:
    attacker = Attacker(service, key)
    limits = {"seconds_per_evaluation": 1, "memory_mb": 300}
    for name in random.Random(1).sample(list(REASONS), 12):
        attacker.job(bad(behaviour=name, limits=limits, method={"kind": "monte_carlo", "samples": 4}, stopping={}))


@attack("posteriors and reports")
def _(service: Service, key: str) -> None:
    attacker = Attacker(service, key)
    job = attacker.finished(line(30, 400))
    for what in ("posterior", "surface", "statistics", "points", "report.html", "uncertainty"):
        attacker.many(12, "GET", f"{API}/jobs/{job}/{what}")


@attack("large answers")
def _(service: Service, key: str) -> None:
    attacker = Attacker(service, key)
    job = attacker.finished(line(20_000, 300))
    query = {"responses": "true", "limit": "1000"}
    attacker.many(6, "GET", f"{API}/jobs/{job}/evaluations", params=query)
    request = f"GET {API}/jobs/{job}/evaluations?responses=true HTTP/1.1\r\nHost: localhost\r\nX-API-Key: {key}\r\n\r\n"
    with raw(service) as connect:
        for _ in range(20):
            connect(request.encode())  # and nothing of the answer is read
        time.sleep(3.0)


@attack("large bodies")
def _(service: Service, key: str) -> None:
    attacker = Attacker(service, key)
    for path in ("session", "keys", "jobs", "measurements", "jobs/1/reweight"):
        attacker.many(2, "POST", f"{API}/{path}", content=b"{" + b" " * 33_000_000)
    with raw(service) as connect:
        for path in ("session", "jobs") * 15:
            head = f"POST {API}/{path} HTTP/1.1\r\nHost: localhost\r\nX-API-Key: {key}\r\nContent-Length: 31000000"
            connect(head.encode() + b"\r\n\r\n" + b" " * 1_000_000)
        time.sleep(2.0)


@attack("half requests")
def _(service: Service, key: str) -> None:
    del key
    with raw(service) as connect:
        for _ in range(1100):
            connect(b"GET /health/live HTTP/1.1\r\nHost: localhost\r\nX-Slow: ")
        time.sleep(3.0)


@attack("event streams")
def _(service: Service, key: str) -> None:
    attacker = Attacker(service, key)
    job = attacker.job(line(3, 20_000, method={"kind": "monte_carlo", "samples": 20_000, "batch": 20}))
    head = f"GET {API}/jobs/{job}/events HTTP/1.1\r\nHost: localhost\r\nX-API-Key: {key}\r\n\r\n"
    with raw(service) as connect:
        for _ in range(300):
            connect(head.encode())
        time.sleep(4.0)
    attacker.ask("POST", f"{API}/jobs/{job}/cancel")


@attack("a hundred jobs")
def _(service: Service, key: str) -> None:
    attacker = Attacker(service, key)
    for _ in range(110):
        attacker.job(line(3, 300, priority=10))


@attack("jobs that fill the disk")
def _(service: Service, key: str) -> None:
    attacker = Attacker(service, key)
    for _ in range(5):
        attacker.job(line(100_000, 9000))
    jobs = [attacker.job(line(5000, 4000)) for _ in range(3)]
    time.sleep(5.0)
    for job in jobs:
        attacker.ask("POST", f"{API}/jobs/{job}/cancel")


@attack("extreme numbers")
def _(service: Service, key: str) -> None:
    attacker = Attacker(service, key)
    job = attacker.finished(line())
    for number in ("1e-300", "1e300", "nan", "inf", "-1", "1e308", "9" * 400):
        for what in ("statistics", "posterior", "surface", "uncertainty"):
            attacker.ask("GET", f"{API}/jobs/{job}/{what}", params={"noise": number, "threshold": number})
        attacker.ask("POST", f"{API}/jobs", content=b'{"seed": ' + number.encode() + b"}")


@attack("wrong keys and sign-ins")
def _(service: Service, key: str) -> None:
    wrong, right = Attacker(service, "gsw_000000000000_" + "x" * 43), Attacker(service, key)
    wrong.many(30, "GET", f"{API}/jobs")
    for _ in range(60):
        right.ask("POST", f"{API}/session", json={"key": key})


@attack("long paths and odd bytes")
def _(service: Service, key: str) -> None:
    attacker = Attacker(service, key)
    for path in ("/a" * 20_000, "/%0d%0a%1b[31mforged", "/..%2f..%2fetc/passwd", f"{API}/jobs/{'x' * 5000}"):
        attacker.many(10, "GET", path)
    with raw(service) as connect:
        for data in (b"\x00" * 70_000, b"GET " + b"a" * 70_000, b"POST / HTTP/9.9\r\n\r\n", b"\x16\x03\x01" * 100):
            connect(data)
        time.sleep(1.0)


@attack("readiness")
def _(service: Service, key: str) -> None:
    del key
    Attacker(service, None).many(100, "GET", "/health/ready")


def main(given: dict[str, Any]) -> int:
    """Run attacks at once, each with a key of its own; return how many saw what they should not."""
    service = Service(**given["service"])
    wrong: list[str] = []

    def run(name: str) -> None:
        try:
            ATTACKS[name](service, service.key_of("attacker-" + name.replace(" ", "-")))
        except Exception as error:  # noqa: BLE001  told by the exit code and this line
            wrong.append(name)
            sys.stderr.write(f"{name}: {error!r}\n")

    threads = [threading.Thread(target=run, args=(name,)) for name in given["names"]]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return len(wrong)


if __name__ == "__main__":
    sys.exit(main(json.loads(sys.argv[1])))
