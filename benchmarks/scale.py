"""How many workers the engine carries: simulated ones against the real coordinator and store on PostgreSQL.

    python benchmarks/scale.py [--workers 16,64,128,256,400,1000] [--seconds 1,10] [--particles 100,1000] [--jobs 1,100]
    python benchmarks/scale.py --workers 1000 --seconds 10 --jobs 1 --alone    # one transaction for each exchange
    python benchmarks/scale.py --costs    # processor time of an exchange, without load

A simulated worker claims and hands in through :class:`geoswarm.workers.coordinator.runtime.Runtime`, as an agent's
requests do inside a service, and sleeps in place of the forward run, whose result is made up. They are tasks of one
process with a pool of threads, as those of a service, and share its connections. They renew their leases, and a sweep
ends those that are overdue. Particles: 0 means as many as the job has workers. PostgreSQL is started beside it and
flushes to the disk.

Columns: exchanges a second; latency from asking to the answer, median and 95th percentile; share of the time in which
workers have a run (100 % would be ideal, as the runs of a generation take equally long); processor time of an
exchange in this process and in PostgreSQL; how long a transaction has the job locked, median, and that time for each
exchange, mean; backends that wait for a lock, in the mean; WAL an evaluation; connections; memory of this process and
of all backends (proportional); leases that were lost; whether the accounts agree (every generation complete and counted
once).
"""

# ruff: noqa: E402  the number of threads must be set before the numerical libraries are imported

from __future__ import annotations

import argparse
import asyncio
import itertools
import os
import statistics
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]
os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")

import numpy as np
import psutil
import psycopg

from benchmarks._postgres import LockTimes, PostgresWork, accounts
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.course import Course
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.system.processes import memory_of
from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.coordinator.work import Asked, Claim, Exchange, Result, Submission
from geoswarm.workers.operations.sweep import Sweeper
from geoswarm.workers.queries.jobs import get_problem
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.problems import problem_of
from geoswarm.workers.waker import NoWaker
from tests.servers import PostgresServer

IDLE_SECONDS = 2.0  # a worker that nobody wakes for looks by itself
READINGS = 20
HEADINGS = (
    "workers | jobs | particles | run s | exchanges/s | median ms | p95 ms | busy % | own ms | PostgreSQL ms |"
    " locked ms | waiting | WAL kB | connections | MB | lost | accounts"
)


def problem(particles: int) -> dict[str, Any]:
    """A job whose runs are made up; it does not end while it is watched."""
    x = list(range(READINGS))
    return {
        "name": f"{particles} particles",
        "forward_model": {"kind": "formula", "series": {"y": {"expression": "a + b * x + c * x * x"}}},
        "parameters": {name: {"lower": -5, "upper": 5} for name in "abc"},
        "observations": [{"series": "y", "points": {"x": x, "y": x}}],
        "method": {"kind": "particle_swarm", "particles": particles, "acceleration": "none"},
        "stopping": {"max_evaluations": 10**7},
        "answer": {"max_evaluations": "off"},
        "seed": 7,
    }


@dataclass
class Tally:
    """What is counted while ``open``."""

    open: bool = False
    began: float = 0.0
    latencies: list[float] = field(default_factory=list)
    evaluations: int = 0
    busy: float = 0.0
    under_way: dict[object, float] = field(default_factory=dict)  # since when, of runs that have not ended

    def close(self) -> None:
        """Count no longer; what is under way counts up to now."""
        self.open = False
        now = time.perf_counter()
        self.busy += sum(now - max(began, self.began) for began in self.under_way.values())


class Job:
    """A job and the bell that its workers listen for."""

    def __init__(self, store: Store, job_id: str, workers: int) -> None:
        row = store.read(lambda connection: get_problem(connection, job_id))
        assert row is not None
        self.id = job_id
        self.workers = workers
        self.course = Course(Calibration(problem_of(row.problem), row.seed))
        self.bell = asyncio.Condition()

    async def wake(self, times: int) -> None:
        """Wake some of those that wait."""
        async with self.bell:
            self.bell.notify(times)

    async def wait(self) -> None:
        """Wait for a wake-up, or for a while."""
        async with self.bell:
            try:
                async with asyncio.timeout(IDLE_SECONDS):
                    await self.bell.wait()
            except TimeoutError:
                return


class Load:
    """Simulated workers on some jobs; ``alone``: each exchange in a transaction of its own, whoever else waits."""

    def __init__(
        self, runtime: Runtime, jobs: list[Job], seconds: float, spread: float, threads: int, *, alone: bool = False
    ) -> None:
        self.runtime = runtime
        self.jobs = jobs
        self.seconds = seconds
        self.spread = spread
        self.alone = alone
        self.tally = Tally()
        self.under_way: dict[object, float] = {}
        self.held: dict[str, Claim] = {}
        self.pool = ThreadPoolExecutor(threads, "exchange")
        self.template = np.zeros(READINGS)
        self.random = np.random.default_rng(1)

    async def worker(self, number: int, job: Job) -> None:
        """Claim, sleep, hand in, for ever."""
        name = f"simulated-{number}"
        loop = asyncio.get_running_loop()
        submission, turn = Submission(), True
        await asyncio.sleep(self.random.random() * min(self.seconds, 1.0))
        while True:
            asked = time.perf_counter()
            answer = await loop.run_in_executor(self.pool, self._exchange, job, name, submission, turn)
            self._count(time.perf_counter() - asked, len(submission.results))
            submission, turn = Submission(), False
            if answer.queued:
                start = job.course.start(job.workers)
                await loop.run_in_executor(self.pool, self.runtime.start, job.id, start)
                await job.wake(job.workers)
                continue
            if answer.wakes:
                await job.wake(answer.wakes)
            if answer.claim is None:
                await job.wait()
                continue
            self.held[name] = answer.claim
            submission = await self._run(answer.claim)
            del self.held[name]

    async def beat(self) -> None:
        """Renew all leases, for ever, as each worker does for its own."""
        loop = asyncio.get_running_loop()
        while True:
            await asyncio.sleep(self.runtime.settings.heartbeat_seconds)
            held = list(self.held.items())
            renew = self.runtime.renew
            await asyncio.gather(*(loop.run_in_executor(self.pool, renew, claim, name) for name, claim in held))

    def _exchange(self, job: Job, name: str, submission: Submission, turn: bool) -> Exchange:
        if self.alone:
            return self.together(job, [Asked(name, submission, job.workers, want=True, taken_up=turn)])[0]
        return self.runtime.exchange(
            job.id, name, job.course, submission, live_workers=job.workers, want=True, taken_up=turn
        )

    def together(self, job: Job, asked: list[Asked]) -> list[Exchange]:
        """Exchange for several workers in one transaction."""
        return self.runtime._exchange(job.id, job.course, asked)

    async def _run(self, claim: Claim) -> Submission:
        results = self.made_up(claim)
        for result in results:
            run = object()
            began = self.under_way[run] = time.perf_counter()
            await asyncio.sleep(result.evaluation.seconds)
            del self.under_way[run]
            if self.tally.open:
                self.tally.busy += time.perf_counter() - max(began, self.tally.began)
        return Submission(claim, (), claim.generation, results)

    def made_up(self, claim: Claim) -> list[Result]:
        """Return results as forward runs would give them."""
        results = []
        for particle, attempt, position in zip(claim.particles, claim.attempts, claim.positions, strict=True):
            seconds = self.seconds * (1.0 + self.spread * (2.0 * self.random.random() - 1.0))
            objective = float(position @ position)
            evaluation = Evaluation(position, objective, {"y": objective}, {"y": self.template}, None, None, seconds)
            results.append(Result(particle, attempt, evaluation, claim.now, claim.now + seconds))
        return results

    def _count(self, latency: float, evaluations: int) -> None:
        if self.tally.open:
            self.tally.latencies.append(latency)
            self.tally.evaluations += evaluations


class Server(PostgresWork):
    """What PostgreSQL does meanwhile, with its locks, connections and memory."""

    def __init__(self, url: str, pid: int) -> None:
        super().__init__(url, pid)
        self.ended = threading.Event()
        self.waiting: list[int] = []
        self.connections = 0
        self.memory = 0.0
        self.thread = threading.Thread(target=self._look, daemon=True)
        self.thread.start()

    def _look(self) -> None:
        with psycopg.connect(self.connection.info.dsn, password=self.connection.info.password, autocommit=True) as own:
            while not self.ended.wait(0.2):
                row = own.execute(
                    "SELECT count(*) FILTER (WHERE wait_event_type = 'Lock'), count(*) FROM pg_stat_activity"
                    " WHERE datname = current_database() AND application_name = 'geoswarm'"
                ).fetchone()
                assert row is not None
                self.waiting.append(row[0])
                self.connections = max(self.connections, row[1])
            self.memory = sum(memory_of(child.pid) for child in self.process.children(recursive=True))

    def close(self) -> None:
        """End the look-out."""
        self.ended.set()
        self.thread.join()
        self.connection.close()


async def measure(load: Load, locks: LockTimes, server: Server, warm: float, window: float) -> dict[str, float]:
    """Run the load; return what one line of the table says."""
    numbers = itertools.count()
    tasks = [asyncio.create_task(load.worker(next(numbers), job)) for job in load.jobs for _ in range(job.workers)]
    beating = asyncio.create_task(load.beat())
    await asyncio.sleep(warm)
    own = psutil.Process()
    server.waiting.clear()
    locks.seconds.clear()
    wal, cpu, mine = server.wal(), server.seconds(), sum(own.cpu_times()[:2])
    tally = load.tally = Tally(open=True, began=time.perf_counter(), under_way=load.under_way)
    await asyncio.sleep(window)
    tally.close()
    elapsed = time.perf_counter() - tally.began
    wal, cpu, mine = server.wal() - wal, server.seconds() - cpu, sum(own.cpu_times()[:2]) - mine
    locked = list(locks.seconds)
    for task in (*tasks, beating):
        task.cancel()
    await asyncio.gather(*tasks, beating, return_exceptions=True)
    count = len(tally.latencies)
    workers = len(tasks)
    cuts = statistics.quantiles(tally.latencies, n=20) if count > 1 else [0.0] * 19
    return {
        "exchanges": count / elapsed,
        "evaluations": tally.evaluations / elapsed,
        "median": 1e3 * cuts[9],
        "p95": 1e3 * cuts[18],
        "busy": 100.0 * tally.busy / (workers * elapsed),
        "own": 1e3 * mine / max(count, 1),
        "postgres": 1e3 * cpu / max(count, 1),
        "locked": 1e3 * statistics.median(locked or [0.0]),
        "locked_each": 1e3 * sum(locked) / max(count, 1),
        "locks": statistics.fmean(server.waiting) if server.waiting else 0.0,
        "wal": wal / max(tally.evaluations, 1) / 1e3,
        "memory": own.memory_info().rss / 2**20,
    }


@contextmanager
def case(
    server: PostgresServer, workers: int, jobs: int, particles: int, options: argparse.Namespace, seconds: float
) -> Iterator[tuple[Load, LockTimes, str]]:
    """A database with jobs, and workers for them; how long jobs are locked, and the URL of the database."""
    url = server.create_database()
    settings = Settings(database_url=url, workers=1)
    store = Store(settings)
    service = JobService(store, NoWaker(), settings)
    share = max(1, workers // jobs)
    count = min(jobs, workers)
    ids = [service.submit(parse_problem(problem(particles or max(share, 2))))[0].id for _ in range(count)]
    made = [Job(store, job_id, share) for job_id in ids]
    load = Load(Runtime(store, settings), made, seconds, options.spread, options.threads, alone=options.alone)
    locks = LockTimes(store)
    sweeper = Sweeper(load.runtime, NoWaker())
    sweeper.start()
    try:
        yield load, locks, url
    finally:
        sweeper.stop()
        locks.close()
        load.pool.shutdown(wait=True, cancel_futures=True)
        store.close()
        server.drop_database(url)


def costs(server: PostgresServer, together: list[int]) -> None:
    """Print the processor time of an exchange, hand-in and claim of one run, by the size of the generation."""
    print("| particles | together | own ms | PostgreSQL ms | wall ms | WAL kB |")
    print("|---|---|---|---|---|---|", flush=True)
    for particles in (10, 100, 1000):
        for size in together:
            if size > particles // 2:
                continue
            url = server.create_database()
            settings = Settings(database_url=url, workers=1)
            store = Store(settings)
            service = JobService(store, NoWaker(), settings)
            job = Job(store, service.submit(parse_problem(problem(particles)))[0].id, particles)
            runtime = Runtime(store, settings)
            runtime.start(job.id, job.course.start(particles))
            assert server.pid is not None
            watch = Server(url, server.pid)
            load = Load(runtime, [job], 60.0, 0.0, 1)
            names = [f"simulated-{number}" for number in range(size)]
            submissions = [Submission() for _ in names]
            rounds = max(20, 1000 // size)
            for _ in range(rounds // 2):  # until statements are prepared, and it is known what a run costs
                exchange(load, job, names, submissions)
            cpu, wal = watch.seconds(), watch.wal()
            wall = own = 0.0
            for _ in range(rounds):
                times = exchange(load, job, names, submissions)
                wall, own = wall + times[0], own + times[1]
            count = rounds * size
            cpu, wal = watch.seconds() - cpu, watch.wal() - wal
            print(
                f"| {particles} | {size} | {1e3 * own / count:.2f} | {1e3 * cpu / count:.2f} |"
                f" {1e3 * wall / count:.2f} | {wal / count / 1e3:.1f} |",
                flush=True,
            )
            watch.close()
            store.close()
            server.drop_database(url)


def exchange(load: Load, job: Job, names: list[str], submissions: list[Submission]) -> tuple[float, float]:
    """Hand in and claim, for all names in one transaction; the runs take no time but say that they took a minute.

    Return the wall and the processor time of the exchange, without that of making up results [s].
    """
    asked = [Asked(name, one, job.workers, want=True) for name, one in zip(names, submissions, strict=True)]
    began, own = time.perf_counter(), time.process_time()
    answers = load.together(job, asked)
    wall, own = time.perf_counter() - began, time.process_time() - own
    for number, answer in enumerate(answers):
        claim = answer.claim
        submissions[number] = (
            Submission() if claim is None else Submission(claim, (), claim.generation, load.made_up(claim))
        )
    return wall, own


def numbers(text: str, kind: type[Any]) -> list[Any]:
    """Numbers with commas between them."""
    return [kind(part) for part in text.split(",")]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--workers", default="16,64,128,256,400,1000")
    parser.add_argument("--seconds", default="1,10")
    parser.add_argument("--particles", default="100,1000", help="of a generation; 0: as many as workers of the job")
    parser.add_argument("--jobs", default="1,100")
    parser.add_argument("--window", type=float, default=20.0, help="time that is measured, at least two runs [s]")
    parser.add_argument("--threads", type=int, default=16, help="threads and connections of the service")
    parser.add_argument("--spread", type=float, default=0.0, help="runs take so much more or less, as a share")
    parser.add_argument("--alone", action="store_true", help="one transaction for each exchange")
    parser.add_argument("--costs", action="store_true", help="only the processor time of an exchange")
    parser.add_argument("--together", default="1,10,100,500", help="exchanges in one transaction, of --costs")
    options = parser.parse_args()
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, {options.threads} threads", flush=True)
    if options.costs:
        with PostgresServer(durable=True) as server:
            costs(server, numbers(options.together, int))
        return
    print(f"| {HEADINGS} |")
    print("|" + (HEADINGS.count("|") + 1) * "---|", flush=True)
    with PostgresServer(durable=True) as server:
        for jobs, particles, seconds, workers in itertools.product(
            numbers(options.jobs, int),
            numbers(options.particles, int),
            numbers(options.seconds, float),
            numbers(options.workers, int),
        ):
            if workers < jobs and jobs > 1:
                continue
            with case(server, workers, jobs, particles, options, seconds) as (load, locks, url):
                assert server.pid is not None
                watch = Server(url, server.pid)
                warm = max(3.0, 1.5 * seconds)
                found = asyncio.run(measure(load, locks, watch, warm, max(options.window, 2.0 * seconds)))
                watch.close()
                lost, agree = accounts(load.runtime.store)
            print(
                f"| {workers} | {min(jobs, workers)} | {particles or 'as workers'} | {seconds:g} |"
                f" {found['exchanges']:.1f} | {found['median']:.1f} | {found['p95']:.1f} | {found['busy']:.1f} |"
                f" {found['own']:.2f} | {found['postgres']:.2f} | {found['locked']:.1f}, {found['locked_each']:.2f} |"
                f" {found['locks']:.1f} | {found['wal']:.1f} | {watch.connections} |"
                f" {found['memory']:.0f} + {watch.memory:.0f} | {lost} | {agree} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
