"""Helpers for tests that run whole engines."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from geoswarm.records.job import Job
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from tests.workers.problems import History, expected_history, line

__all__ = [
    "LONG",
    "STEADY",
    "celery_workers",
    "long_history",
    "must_end",
    "process_exists",
    "wait_for",
    "wait_until_ended",
]

# Short times, so that a loss is noticed while a test waits; and every evaluation on its own, so that a job lasts for
# seconds, with many moments at which something may happen to it.
STEADY: dict[str, Any] = {
    "lease_seconds": 2.0,
    "heartbeat_seconds": 0.5,
    "sweep_seconds": 0.5,
    "slice_seconds": 0.3,
    "burst_seconds": 0.0,
    "cheap_seconds": 0.0,
    "single_seconds": 0.0,
}
# Some 1.5 ms an evaluation: the job takes seconds on any machine.
_X = [0.006 * i for i in range(500)]
LONG = line(
    forward_model={"kind": "formula", "series": {"y": "a * x + b" + " + 0*sin(exp(a*x))" * 45}},
    observations=[{"series": "y", "points": {"x": _X, "y": [2.0 * x + 1.0 for x in _X]}}],
    method={"kind": "particle_swarm", "particles": 10, "acceleration": "none"},
    stopping={"max_evaluations": 900},
)


@cache
def long_history() -> History:
    """What LONG gives in process."""
    return expected_history(LONG)


RUN_WORKER = (
    "import json, sys; from geoswarm.workers.hosts.celery_app import run_celery_worker;"
    "from geoswarm.workers.settings import Settings;"
    "run_celery_worker(Settings(**json.loads(sys.argv[1])), int(sys.argv[2]))"
)


def wait_for(condition: Callable[[], bool], what: str, seconds: float = 120.0) -> None:
    """Wait until a condition holds."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"not within {seconds} s: {what}"
        time.sleep(0.02)


def wait_until_ended(service: JobService, job_id: str, seconds: float = 300.0) -> Job:
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
        process.wait(20)
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
