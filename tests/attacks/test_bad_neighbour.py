"""One client attacks the service in every way that is known; the jobs and requests of another owner go on as ever."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path

import pytest

from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.system.processes import descendants, memory_of
from tests.attacks.attacks import API, ATTACKS, line
from tests.attacks.services import ROOT, Service, serving
from tests.integration.engines import wait_for
from tests.servers import free_port

AT_ONCE = 10
ENOUGH = 100  # answers for a percentile
MOST_ROUNDS = 5
MOST_MEMORY = 1000.0  # MiB, of the process that answers
MOST_LOG = 2_000_000  # bytes, of one attack
QUOTA = 600  # MB, of stored and planned data of an owner
MOST_DISK = 2_000_000_000  # bytes, of everything: two owners at their quotas, and the write-ahead log
LONGEST_WAIT = 1.0
"""What a GET of the second owner may take on a machine that is not used by others: the 99th percentile [s]."""

OWN = line(4, 60, method={"kind": "particle_swarm", "particles": 10}, stopping={"max_evaluations": 60})


@cache
def history() -> list[float | None]:
    """What the second owner must find."""
    return [e.evaluation.objective for e in calibrate(parse_problem(OWN)).history]


@dataclass
class Neighbour:
    """The second owner, who lists, submits, follows and finishes jobs for as long as the body runs."""

    service: Service
    key: str
    waits: list[float] = field(default_factory=list)
    jobs: int = 0
    memory: float = 0.0
    wrong: list[str] = field(default_factory=list)
    _stop: threading.Event = field(default_factory=threading.Event)

    def __enter__(self) -> Neighbour:
        history()  # before others measure
        self._threads = [threading.Thread(target=self._guard, args=(work,)) for work in (self._look, self._calibrate)]
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        for thread in self._threads:
            thread.join()

    def _guard(self, work: Callable[[], None]) -> None:
        try:
            work()
        except Exception as error:  # noqa: BLE001  told by the test
            self.wrong.append(repr(error))

    def _look(self) -> None:
        with self.service.client(self.key) as client:
            while not self._stop.wait(0.05):
                began = time.monotonic()
                answer = client.get(f"{API}/jobs")
                self.waits.append(time.monotonic() - began)
                assert answer.status_code == 200, answer.text
                self.memory = max(self.memory, memory_of(self.service.pid))

    def _calibrate(self) -> None:
        with self.service.client(self.key) as client:
            while not self._stop.is_set():
                answer = client.post(f"{API}/jobs", json=OWN)
                assert answer.status_code in (201, 503), answer.text
                if answer.status_code == 503:  # all processes that build problems are busy: said, with a time to wait
                    self._stop.wait(float(answer.headers["retry-after"]))
                    continue
                place = f"{API}/jobs/{answer.json()['id']}"
                wait_for(lambda at=place: client.get(at).json()["state"] == "finished", "the neighbour's job", 240.0)
                found = client.get(f"{place}/evaluations", params={"limit": 1000}).json()["items"]
                assert [e["objective"] for e in found] == history()
                client.delete(place)
                self.jobs += 1

    def judge(self, calm: Neighbour) -> None:
        """See that nothing was noticed, measured against a calm run on this machine."""
        assert not self.wrong
        assert self.jobs
        waits, usual = sorted(self.waits), sorted(calm.waits)
        slow, slow_usually = (w[int(0.99 * len(w))] for w in (waits, usual))
        figures = f"99 % of {len(waits)} GETs: {slow:.3f} s ({slow_usually:.3f} s calm); {self.memory:.0f} MiB"
        print(figures)  # noqa: T201  for who runs it with -s
        # Attackers need the processor, too: where a calm answer takes long already, the machine is busy with others.
        assert slow < max(LONGEST_WAIT, 20.0 * slow_usually), figures
        assert self.memory < MOST_MEMORY, figures


@contextmanager
def attacked(folder: Path) -> Iterator[tuple[Service, Neighbour, Neighbour]]:
    """A service, a second owner's calm run on it, and one that is to come; at the end nothing must be left."""
    limits = {"GEOSWARM_COMPUTE_SECONDS": "20", "GEOSWARM_QUOTA_MB": str(QUOTA)}
    with serving(folder, free_port(), "--workers", "2", **limits) as service:
        key = service.key_of("neighbour")
        with Neighbour(service, key) as calm:
            wait_for(lambda: calm.jobs >= 3 or calm.wrong, "calm jobs")
        assert not calm.wrong
        usual = len(descendants(service.pid))
        yield service, calm, Neighbour(service, key)
        with service.client() as client:
            for job in client.get(f"{API}/jobs", params={"limit": 200, "state": "running"}).json()["items"]:
                client.post(f"{API}/jobs/{job['id']}/cancel")
        wait_for(lambda: len(descendants(service.pid)) <= usual + 6, "the end of what was started", 120.0)
        pids = descendants(service.pid)
    wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in pids), "the end of all processes")
    log = (folder / "log").read_text(errors="replace")
    assert "Traceback" not in log
    taken = sum(f.stat().st_size for f in folder.rglob("*") if f.is_file())
    print(f"{taken / 1e6:.0f} MB of disk")  # noqa: T201  for who runs it with -s
    assert taken < MOST_DISK


def run(service: Service, names: list[str]) -> None:
    """Run attacks at once, in a process of their own."""
    given = json.dumps({"service": asdict(service), "names": names})
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests" / "models")])}
    command = [sys.executable, "-m", "tests.attacks.attacks", given]
    done = subprocess.run(command, env=environment, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 0, done.stderr


def log_size(folder: Path) -> int:
    return (folder / "log").stat().st_size


@pytest.mark.timing  # how long a neighbour waits
@pytest.mark.timeout(900)
@pytest.mark.slow
def test_some_attacks_at_once_are_not_noticed(tmp_path: Path) -> None:
    names = [
        "long cells and digits",
        "merge keys of YAML",
        "a slip of a unit",
        "large bodies",
        "half requests",
        "readiness",
    ]
    with attacked(tmp_path) as (service, calm, neighbour):
        before = log_size(tmp_path)
        with neighbour:
            run(service, names)
        neighbour.judge(calm)
        assert log_size(tmp_path) - before < MOST_LOG


@pytest.mark.timing  # how long a neighbour waits
@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", ATTACKS)
def test_an_attack_is_not_noticed(name: str, tmp_path: Path) -> None:
    with attacked(tmp_path) as (service, calm, neighbour):
        before = log_size(tmp_path)
        with neighbour:
            for _ in range(MOST_ROUNDS):
                run(service, [name])
                if len(neighbour.waits) >= ENOUGH and neighbour.jobs:
                    break
        neighbour.judge(calm)
        assert log_size(tmp_path) - before < MOST_LOG


@pytest.mark.timing  # how long a neighbour waits
@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_all_attacks_ten_at_once_are_not_noticed(tmp_path: Path) -> None:
    names = list(ATTACKS)
    with attacked(tmp_path) as (service, calm, neighbour):
        before = log_size(tmp_path)
        with neighbour:
            for first in range(0, len(names), AT_ONCE // 2):
                chosen = (names * 2)[first : first + AT_ONCE]
                run(service, chosen)
        neighbour.judge(calm)
        assert log_size(tmp_path) - before < 10 * MOST_LOG
