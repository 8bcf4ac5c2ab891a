"""The commands as an operator starts them: serve, worker and sweep as processes, jobs over HTTP, the published problem.

Each history must equal that of the in-process run bit for bit.
"""

from __future__ import annotations

import os
import secrets
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import psutil
import pytest

from geoswarm import Client
from geoswarm.solver.problem import load_problem, parse_problem
from geoswarm.solver.runs.local import calibrate
from tests.documentation.service import answers
from tests.integration.engines import must_end, wait_for
from tests.servers import RedisServer, free_port

PROBLEM = Path(__file__).parents[2] / "examples" / "oedometer" / "problem.yaml"
# Runs to its last evaluation, so that there is time to disturb it.
WHOLE: dict[str, Any] = load_problem(PROBLEM).document() | {
    "method": {"kind": "particle_swarm", "particles": 10, "acceleration": "none"},
    "stopping": {"max_evaluations": 1590},
    "answer": {"max_evaluations": "off"},
}

KEY = secrets.token_hex(16)

# Learns from stored responses, so these must come back from the database bit for bit.
ACCELERATED: dict[str, Any] = WHOLE | {
    "method": {"kind": "particle_swarm", "particles": 10, "acceleration": "response_surface"},
    "stopping": {"max_evaluations": 150},
    "answer": {},
}

Bits = list[tuple[int, int, float | None, tuple[tuple[str, float], ...], tuple[float, ...]]]


@cache
def in_process(*, accelerated: bool = False) -> Bits:
    """The history of the reference."""
    document = ACCELERATED if accelerated else WHOLE
    return [
        (
            record.generation,
            record.particle,
            record.evaluation.objective,
            tuple(zip(("lambda_star", "kappa_star", "c"), record.evaluation.parameters.tolist(), strict=True)),
            tuple(record.evaluation.responses["settlement"].tolist()),
        )
        for record in calibrate(parse_problem(document)).history
    ]


def over_http(client: Client, job_id: str) -> Bits:
    """The history as the service tells it."""
    bits: Bits = []
    cursor: str | None = None
    while True:
        page = client.evaluations(job_id, responses=True, limit=500, cursor=cursor)
        bits += [
            (
                item.generation,
                item.particle,
                item.objective,
                tuple((name, item.parameters[name]) for name in ("lambda_star", "kappa_star", "c")),
                tuple((item.responses or {})["settlement"].y),
            )
            for item in page.items
        ]
        cursor = page.next_cursor
        if cursor is None:
            return bits


@contextmanager
def geoswarm(*arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run a command until the end of the block; then it must end by itself when asked to."""
    process = subprocess.Popen(
        [sys.executable, "-m", "geoswarm", *arguments],
        stdout=subprocess.DEVNULL,
        env=os.environ | {"GEOSWARM_API_KEY": KEY},
    )
    try:
        yield process
    finally:
        process.terminate()
        must_end(process)


@contextmanager
def served(*arguments: str) -> Iterator[Client]:
    """Serve, and give a client when the service is ready."""
    port = free_port()
    url = f"http://127.0.0.1:{port}"

    with geoswarm("serve", "--port", str(port), *arguments), Client(url, api_key=KEY) as client:
        wait_for(lambda: answers(url), "a service that is ready")
        yield client


def finish(client: Client, job_id: str, evaluations: int = 1590) -> None:
    job = client.wait(job_id, timeout=120)
    assert job.state == "finished", job.error
    assert (job.evaluations, job.failed_evaluations, job.stop_reasons) == (evaluations, 0, ["max_evaluations"])


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2, 4])
def test_embedded_service_gives_the_in_process_history(workers: int, tmp_path: Path) -> None:
    with served("--database", f"sqlite:///{tmp_path / 'jobs.db'}", "--workers", str(workers)) as client:
        job = client.submit(WHOLE)
        finish(client, job.id)
        assert over_http(client, job.id) == in_process()


@pytest.mark.slow
def test_an_accelerated_job_gives_the_in_process_history(tmp_path: Path) -> None:
    with served("--database", f"sqlite:///{tmp_path / 'jobs.db'}", "--workers", "2") as client:
        job = client.submit(ACCELERATED)
        finish(client, job.id, 150)
        assert over_http(client, job.id) == in_process(accelerated=True)


@pytest.mark.slow
@pytest.mark.parametrize(("workers", "accelerated"), [(2, True), (1, False), (2, False), (4, False)])
def test_redis_and_postgresql_give_the_in_process_history(
    workers: int, accelerated: bool, fresh_postgres_url: str, fresh_redis_url: str
) -> None:
    backends = ("--database", fresh_postgres_url, "--broker", fresh_redis_url)
    with served(*backends) as client, geoswarm("worker", "--concurrency", str(workers), *backends):
        wait_for(lambda: len(client.workers()) == workers, f"{workers} workers")
        job = client.submit(ACCELERATED if accelerated else WHOLE)
        finish(client, job.id, 150 if accelerated else 1590)
        assert over_http(client, job.id) == in_process(accelerated=accelerated)


@pytest.mark.slow
def test_a_killed_worker_and_a_restarted_redis_change_nothing(
    fresh_postgres_url: str, fresh_redis_url: str, redis_server: RedisServer
) -> None:
    backends = ("--database", fresh_postgres_url, "--broker", fresh_redis_url)
    with ExitStack() as stack:
        client = stack.enter_context(served(*backends))
        stack.enter_context(geoswarm("sweep", *backends))
        workers = [stack.enter_context(geoswarm("worker", "--concurrency", "1", *backends)) for _ in range(2)]
        wait_for(lambda: len(client.workers()) == 2, "2 workers")
        jobs = [client.submit(WHOLE | {"name": f"job {number}"}) for number in range(4)]

        wait_for(lambda: client.get(jobs[0].id).generations > 2, "progress")
        redis_server.restart(empty=True)
        workers[0].kill()
        os.kill(psutil.Process(workers[1].pid).children()[0].pid, signal.SIGKILL)  # the other one starts a new process
        assert client.get(jobs[-1].id).state in ("queued", "running")

        for job in jobs:
            finish(client, job.id)
            assert over_http(client, job.id) == in_process()
