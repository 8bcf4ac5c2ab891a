"""Helpers for tests that run whole engines."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from geoswarm.records.job import Job
from geoswarm.solver.problem import Problem
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from tests.workers.problems import History, expected_history, line

__all__ = [
    "PATIENCE",
    "STEADY",
    "Gate",
    "Gated",
    "celery_workers",
    "must_end",
    "process_exists",
    "wait_for",
    "wait_until_ended",
]

# How long to wait for anything: a busy machine may take its time, and pytest's own limit must not come first.
PATIENCE = 240.0
# Every evaluation on its own, so that there are many moments at which something may happen to a job. A loss is noticed
# while a test waits; a machine that stands still for some seconds is no loss.
STEADY: dict[str, Any] = {
    "lease_seconds": 8.0,
    "heartbeat_seconds": 0.5,
    "sweep_seconds": 0.5,
    "slice_seconds": 0.3,
    "local_batch_seconds": 0.0,
    "cheap_seconds": 0.0,
    "single_seconds": 0.0,
}


class Gate:
    """Lets runs through as a test allows: each draws the next number, by lengthening a file, and waits for its turn."""

    def __init__(self, folder: Path) -> None:
        self.file, self.numbers = folder / "gate", folder / "numbers"
        self.numbers.touch()
        self._let(0)

    @property
    def waiting(self) -> bool:
        """Whether a run has come that is not let through; its worker may have been killed since."""
        return self._drawn() > self._passing

    def let_through(self, more: int = 0) -> None:
        """Let all runs through that have come, and some more."""
        self._let(self._drawn() + more)

    def open(self) -> None:
        """Let all runs through."""
        self._let(1_000_000)

    def _drawn(self) -> int:
        return self.numbers.stat().st_size

    def _let(self, passing: int) -> None:
        self._passing = passing
        new = self.file.with_name("new gate")
        new.write_text(str(passing))
        new.replace(self.file)


class Gated:
    """A job of 24 generations, the runs of which pass a gate: it is in its middle for as long as a test wants.

    Its forward model is one of tests/models: tests use the fixture ``misbehaving_models``.
    """

    particles, generations = 10, 24

    def __init__(self, folder: Path, stopping: dict[str, float] | None = None) -> None:
        self.gate = Gate(folder)
        model = {"kind": "misbehaving", "behaviour": "gated", "above": -9}
        self.problem: Problem = line(
            forward_model=model | {"gate": str(self.gate.file), "notes": str(self.gate.numbers)},
            parameters={"slope": {"lower": -8, "upper": 8}},
            observations=[{"series": "y", "points": {"x": [0, 1, 2], "y": [0.1, 1, 2.2]}}],
            method={"kind": "particle_swarm", "particles": self.particles, "acceleration": "none"},
            stopping=stopping or {"max_evaluations": self.particles * self.generations},
            failures={"retry": {"worker_lost": 1000}},
        )

    def go_on(self, service: JobService, job_id: str) -> None:
        """Let some runs through, wait until a few generations more are complete, and leave the others at the gate."""
        wanted = service.get(job_id).generations + 3

        def reached() -> bool:
            done = service.get(job_id).generations
            if done < wanted and self.gate.waiting:  # one that was let through may have been lost
                self.gate.let_through(self.particles)
            return done >= wanted

        wait_for(reached, f"{wanted} generations")
        assert service.get(job_id).state == "running"

    def history(self) -> History:
        """What the undisturbed run in process gives; the gate is opened for it."""
        self.gate.open()
        return expected_history(self.problem)


RUN_WORKER = (
    "import json, sys; from geoswarm.workers.hosts.celery_app import run_celery_worker;"
    "from geoswarm.workers.settings import Settings;"
    "run_celery_worker(Settings(**json.loads(sys.argv[1])), int(sys.argv[2]))"
)


def wait_for(condition: Callable[[], bool], what: str, seconds: float = PATIENCE) -> None:
    """Wait until a condition holds."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"not within {seconds} s: {what}"
        time.sleep(0.02)


def wait_until_ended(service: JobService, job_id: str, seconds: float = PATIENCE) -> Job:
    """Wait for the end of a job and return it."""
    wait_for(
        lambda: service.get(job_id).state in ("finished", "failed", "cancelled"), f"the end of job {job_id}", seconds
    )
    return service.get(job_id)


def process_exists(pid: int) -> bool:
    """Whether a process runs; a zombie does not."""
    try:
        with open(f"/proc/{pid}/stat") as stat:  # noqa: PTH123  may vanish between two looks
            return stat.read().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def must_end(process: subprocess.Popen[bytes]) -> None:
    """Wait for the end of a process that was asked to; fail, and kill it, when it does not come."""
    try:
        process.wait(PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        raise


@contextmanager
def celery_workers(settings: Settings, count: int = 1, concurrency: int = 1) -> Iterator[list[subprocess.Popen[bytes]]]:
    """Run real Celery workers; whoever is left at the end is asked to stop, and must."""
    command = [sys.executable, "-c", RUN_WORKER, settings.model_dump_json(), str(concurrency)]
    processes = [subprocess.Popen(command, stderr=subprocess.DEVNULL) for _ in range(count)]
    try:
        yield processes
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            must_end(process)
