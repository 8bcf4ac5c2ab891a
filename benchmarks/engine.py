"""What the engine costs: real service, Redis and PostgreSQL against ideal, a bare pool and the run in process.

    python benchmarks/engine.py [--rounds 5] [--samples 100000]

1. Forward runs that sleep 100 ms, 10 particles, 2 workers: share of the ideal speed, and how busy the workers are from
   the submission of the job to its end.
2. Forward runs that compute for 100 ms: the same against a bare process pool that makes these runs.
3. The published oedometer with 1590 evaluations over HTTP, Redis and PostgreSQL, against the run in process on one core
   and with as many processes as there are workers.
4. From pausing or cancelling a job to the end of its run that would go on for ever.
5. Monte Carlo with the isotropic test: evaluations stored per second, and memory.

All methods of a round run one after the other; medians and ratios are over the rounds.
"""

# ruff: noqa: E402  the number of threads must be set before the numerical libraries are imported

from __future__ import annotations

import argparse
import multiprocessing
import os
import secrets
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
MODELS = ROOT / "tests" / "models"
sys.path[:0] = [str(ROOT), str(MODELS)]
os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), str(MODELS)])
os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")

from geoswarm import Client, GeoswarmError
from geoswarm.records.job import Job
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.course import Course
from geoswarm.solver.problem import load_problem, parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.system.processes import memory_below
from tests.servers import PostgresServer, RedisServer, free_port

WORKERS, PARTICLES, GENERATIONS, SECONDS = 2, 10, 10, 0.1
OEDOMETER = ROOT / "examples" / "oedometer" / "problem.yaml"
ISOTROPIC = ROOT / "examples" / "isotropic_compression" / "problem.yaml"
KEY = secrets.token_hex(16)


def slow_problem(behaviour: str) -> dict[str, Any]:
    """A swarm on a forward model that takes 100 ms."""
    return {
        "name": behaviour,
        "forward_model": {"kind": "misbehaving", "behaviour": behaviour, "seconds": SECONDS, "above": -2.0},
        "parameters": {"slope": {"lower": -1, "upper": 1}},
        "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [0, 0.5, 1]}}],
        "method": {"kind": "particle_swarm", "particles": PARTICLES, "acceleration": "none"},
        "stopping": {"max_evaluations": PARTICLES * GENERATIONS},
        "answer": {"max_evaluations": "off"},
        "seed": 3,
    }


def oedometer() -> dict[str, Any]:
    """The published problem with its published number of runs."""
    document = load_problem(OEDOMETER).document() | {"stopping": {"max_evaluations": 1590}}
    document["method"] = {"kind": "particle_swarm", "particles": 10, "acceleration": "none"}
    return document | {"answer": {"max_evaluations": "off"}}


def monte_carlo(samples: int) -> dict[str, Any]:
    """The isotropic test, sampled."""
    document = load_problem(ISOTROPIC).document()
    document["method"] = {"kind": "monte_carlo", "samples": samples, "batch": 1000}
    return document | {"stopping": {}}


@contextmanager
def service() -> Iterator[tuple[Client, list[int]]]:
    """Serve on real servers with two Celery workers; give a client and the numbers of the processes."""
    with ExitStack() as stack:
        postgres = stack.enter_context(PostgresServer())
        redis = stack.enter_context(RedisServer())
        port = free_port()
        backends = ("--database", postgres.url, "--broker", redis.url)
        commands = [("serve", "--port", str(port)), ("worker", "--concurrency", str(WORKERS))]
        processes = []
        for command in commands:
            process = subprocess.Popen(
                [sys.executable, "-m", "geoswarm", *command, *backends],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=os.environ | {"GEOSWARM_API_KEY": KEY, "GEOSWARM_REQUESTS_PER_SECOND": "0"},
            )
            stack.callback(process.wait, 30)
            stack.callback(process.terminate)
            processes.append(process.pid)
        client = stack.enter_context(Client(f"http://127.0.0.1:{port}", api_key=KEY, patience=60.0))
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            try:
                if len(client.workers()) == WORKERS:
                    break
            except GeoswarmError:
                pass  # not up yet
            time.sleep(0.1)
        yield client, processes


def served(client: Client, document: dict[str, Any]) -> float:
    """Return the wall time [s] from submitting a job to its end, seen from outside."""
    return finished(client, document)[0]


def finished(client: Client, document: dict[str, Any]) -> tuple[float, Job]:
    """Return the same, and the job."""
    began = time.perf_counter()
    job = client.wait(client.submit(document).id, timeout=600)
    if job.state != "finished":
        raise SystemExit(f"{job.name}: {job.state}, {job.error}")
    return time.perf_counter() - began, job


def busy(client: Client, document: dict[str, Any]) -> tuple[float, float]:
    """Return the wall time [s] of a job, and the share of its time in which its workers were running evaluations."""
    seconds, job = finished(client, document)
    evaluations = sum(evaluation.seconds or 0.0 for evaluation in client.iterate_evaluations(job.id))
    if job.finished_at is None:
        raise SystemExit(f"{job.name} has no end")
    return seconds, evaluations / (WORKERS * (job.finished_at - job.created_at).total_seconds())


def ended_after(client: Client, action: str) -> float:
    """Return the time [s] from an action to the moment at which no worker is at the job's endless run any more."""
    endless = slow_problem("for_ever") | {"method": {"kind": "monte_carlo", "samples": 1}, "stopping": {}}
    job = client.submit(endless).id
    while not any(worker.job == job for worker in client.workers()):
        time.sleep(0.05)
    began = time.perf_counter()
    getattr(client, action)(job)
    while any(worker.job == job for worker in client.workers()):
        time.sleep(0.02)
    seconds = time.perf_counter() - began
    if action != "cancel":
        client.cancel(job)
    return seconds


_pool_calibration: Calibration | None = None


def _prepare(document: dict[str, Any]) -> None:
    global _pool_calibration
    _pool_calibration = Calibration(parse_problem(document), 3)
    _pool_calibration.evaluate(Course(_pool_calibration).start().positions[0])


def _evaluate(position: Any) -> float | None:
    if _pool_calibration is None:
        raise RuntimeError("the pool was not prepared")
    return _pool_calibration.evaluate(position).objective


def bare_pool(document: dict[str, Any]) -> float:
    """Return the wall time [s] of as many runs in generations in a process pool."""
    calibration = Calibration(parse_problem(document), 3)
    positions = list(Course(calibration).start().positions)
    with multiprocessing.get_context("fork").Pool(WORKERS, _prepare, (document,)) as pool:
        pool.map(_evaluate, positions[:WORKERS], chunksize=1)
        began = time.perf_counter()
        for _ in range(GENERATIONS):
            pool.map(_evaluate, positions, chunksize=1)
        return time.perf_counter() - began


def memory(pids: list[int]) -> float:
    """Return the memory [MiB] of processes with all below them."""
    return sum(memory_below(pid) for pid in pids)


def line(text: str, seconds: Sequence[float], ratio: str = "") -> None:
    """Print a result."""
    print(f"{text:58s} {statistics.median(seconds):8.3f} s   {ratio}", flush=True)


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--samples", type=int, default=100_000)
    arguments = parser.parse_args()
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, {arguments.rounds} rounds")
    ideal = PARTICLES * GENERATIONS * SECONDS / WORKERS
    sleeping, computing, pool, http, inside, side_by_side = [], [], [], [], [], []
    ends: dict[str, list[float]] = {"pause": [], "cancel": []}
    whole = parse_problem(oedometer())
    calibrate(whole)
    with service() as (client, processes):
        for document in (slow_problem("sleep"), slow_problem("compute"), oedometer()):
            served(client, document | {"stopping": {"max_evaluations": 2 * PARTICLES}})  # every process is warm
        for _ in range(arguments.rounds):
            sleeping.append(busy(client, slow_problem("sleep")))
            pool.append(bare_pool(slow_problem("compute")))
            computing.append(busy(client, slow_problem("compute")))
            inside.append(calibrate(whole).seconds)
            began = time.perf_counter()
            calibrate(whole, workers=WORKERS)
            side_by_side.append(time.perf_counter() - began)
            for action, seconds in ends.items():
                seconds.append(ended_after(client, action))
            http.append(served(client, oedometer()))
        median = statistics.median
        seconds, shares = ([found[i] for found in sleeping] for i in (0, 1))
        text = f"{100 * ideal / median(seconds):.1f} % of ideal, workers {100 * median(shares):.1f} % busy"
        line("100 runs that sleep 100 ms", seconds, text)
        line("100 runs that compute 100 ms, bare pool", pool)
        seconds, shares = ([found[i] for found in computing] for i in (0, 1))
        ratios = [a / b for a, b in zip(pool, seconds, strict=True)]
        text = f"{100 * median(ratios):.1f} % of the bare pool, workers {100 * median(shares):.1f} % busy"
        line("100 runs that compute 100 ms, service", seconds, text)
        line("oedometer, 1590 runs, in process, one core", inside)
        line(f"oedometer, 1590 runs, in process, {WORKERS} processes", side_by_side)
        ratios = [a / b for a, b in zip(http, inside, strict=True)]
        several = median([a / b for a, b in zip(http, side_by_side, strict=True)])
        text = f"{median(ratios):.2f} times one core, {several:.2f} times {WORKERS} processes"
        line("oedometer, 1590 runs, HTTP + Redis + PostgreSQL", http, text)
        for action, found in ends.items():
            line(f"an endless run after {action}", found, f"longest {max(found):.2f} s")
        served(client, monte_carlo(arguments.samples // 5))
        before = memory(processes)
        stored = served(client, monte_carlo(arguments.samples))
        after = memory(processes)
        rate = f"{arguments.samples / stored:.0f} a second, memory {before:.0f} -> {after:.0f} MiB"
        line(f"isotropic, {arguments.samples} samples stored", [stored], rate)


if __name__ == "__main__":
    main()
