"""Ten million evaluations of a thousand jobs: what listings, pages, statistics, export and retention take then.

    python benchmarks/many_jobs.py [--jobs 1000] [--evaluations 10000]     # of each job; 10 million rows are some 5 GB

PostgreSQL is started beside it, in the folder for temporary files; the rows are copies that it makes itself of one job.
Times are of whole requests to the application in this process: the first one, and 20 more. Every tenth job failed,
every tenth was cancelled; every second one belongs to one of 25 owners.
"""

# ruff: noqa: E402  modules beside this folder are found only once the path is set

from __future__ import annotations

import argparse
import asyncio
import os
import shutil
import statistics
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

import httpx
from sqlalchemy import text

from benchmarks.large_history import API, PROBLEM, exported, fill
from geoswarm.api import ApiSettings, create_app
from geoswarm.solver.problem import parse_problem
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.operations.retention import delete_job, prune
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import evaluations, events, generations, jobs
from geoswarm.workers.waker import NoWaker
from tests.servers import PostgresServer

BYTES_A_ROW = 700  # with indexes, generations and events, and the write-ahead log meanwhile
JOBS_A_TRANSACTION = 20
REPETITIONS = 20
LIMIT_MILLISECONDS = 200.0
OWNERS = 50


def copies(store: Store, template: str, count: int) -> None:
    """Make further jobs like the first one, each a minute older than the one before."""
    names = {column.name for column in jobs.columns}
    changed = {
        "id": "left(md5(i::text), 16)",
        "name": "'copy ' || i",
        "idempotency_key": "NULL",
        "state": "CASE i % 10 WHEN 8 THEN 'failed' WHEN 9 THEN 'cancelled' ELSE 'finished' END",
        "created_at": "created_at - 60.0 * i",
        "finished_at": "finished_at - 60.0 * i",
        "owner": f"CASE i % 2 WHEN 1 THEN 'owner-' || i % {OWNERS} END",
    }
    kept = ", ".join(changed.get(name, name) for name in sorted(names))
    into = ", ".join(sorted(names))
    series = "generate_series(CAST(:first AS int), CAST(:last AS int)) i"
    statements = [f"INSERT INTO jobs ({into}) SELECT {kept} FROM jobs, {series} WHERE id = :template"]
    for table in (evaluations, generations, events):
        columns = [column.name for column in table.columns if not (table is events and column.name == "id")]
        values = ", ".join("left(md5(i::text), 16)" if name == "job_id" else name for name in columns)
        statements.append(
            f"INSERT INTO {table.name} ({', '.join(columns)}) SELECT {values} FROM {table.name}, {series}"
            " WHERE job_id = :template"
        )
    for first in range(1, count, JOBS_A_TRANSACTION):
        given = {"first": first, "last": min(first + JOBS_A_TRANSACTION, count) - 1, "template": template}
        store.write(lambda c, g=given: [c.execute(text(one), g) for one in statements])


def generation_events(store: Store, job_id: str) -> None:
    """Enter the results of each generation."""
    store.write(
        lambda c: c.execute(
            text(
                "INSERT INTO events (job_id, kind, data, created_at) SELECT job_id, 'generation', "
                ' \'{"number": \' || number || \', "evaluations": 10, "objective": 0.25}\', created_at'
                " FROM generations WHERE job_id = :job_id ORDER BY number"
            ),
            {"job_id": job_id},
        )
    )


async def timed(name: str, call: Callable[[], Awaitable[Any]], repetitions: int = REPETITIONS) -> bool:
    """Print how long a call takes; whether it is fast enough."""
    times = []
    for _ in range(repetitions + 1):
        began = time.perf_counter()
        await call()
        times.append(1e3 * (time.perf_counter() - began))
    first, *later = times  # what this process keeps is made then
    p95 = statistics.quantiles(later, n=20)[18]
    print(
        f"  {name:36s} median {statistics.median(later):8.1f} ms   p95 {p95:8.1f} ms   first {first:8.1f} ms",
        flush=True,
    )
    return p95 < LIMIT_MILLISECONDS


async def requests(service: JobService, job_id: str, generation: int) -> list[str]:
    """Time what users look at; return what took too long."""
    transport = httpx.ASGITransport(create_app(service, ApiSettings()))
    slow = []
    async with httpx.AsyncClient(transport=transport, base_url="http://localhost", timeout=None) as client:
        cursor: str | None = None
        for _ in range(3):
            page = (
                await client.get(f"{API}/jobs", params={"limit": 100} | ({"cursor": cursor} if cursor else {}))
            ).json()
            cursor = page["next_cursor"]
        base = f"{API}/jobs/{job_id}"
        paths = {
            "jobs, first page": f"{API}/jobs",
            "jobs, third page of a hundred": f"{API}/jobs?limit=100" + (f"&cursor={cursor}" if cursor else ""),
            "jobs that failed": f"{API}/jobs?state=failed",
            "jobs that run (none)": f"{API}/jobs?state=running",
            "job": base,
            "best": f"{base}/best",
            "generations, first 1000": f"{base}/generations",
            "evaluations, first 100": f"{base}/evaluations",
            "evaluations of a late generation": f"{base}/evaluations?generation={generation}",
            "evaluations by objective": f"{base}/evaluations?sort=objective",
            "evaluations that failed": f"{base}/evaluations?state=failed",
            "objective below few": f"{base}/evaluations?max_objective=1e-3",
            "statistics": f"{base}/statistics",
            "uncertainty": f"{base}/uncertainty",
            "progress": f"{base}/progress",
            "figure of the convergence (CSV)": f"{base}/figures/convergence.csv",
            "workers": f"{API}/workers",
            "metrics": "/metrics",
            "ready": "/health/ready",
            "page: jobs": "/",
            "page: jobs, searched and by name": "/?search=7&sort=name",
            "page: a job": f"/jobs/{job_id}",
            "page: workers": "/workers",
        }
        for name, path in paths.items():

            async def get(path: str = path) -> None:
                answer = await client.get(path)
                assert answer.status_code == 200, (path, answer.text)

            if not await timed(name, get):
                slow.append(name)
    return slow


async def engine(store: Store, job_id: str) -> list[str]:
    """Time what is done for every job, with all of that history beside it; return what took too long."""
    slow = []
    own = JobService(store, NoWaker(), Settings(database_url=store.engine.url.render_as_string(False)))
    owner = own.on_behalf_of(Principal("owner-3", "submit"))
    number = iter(range(10_000))

    async def submit() -> None:
        owner.submit(parse_problem(PROBLEM | {"name": f"new {next(number)}"}))

    async def list_own() -> None:
        owner.list(limit=50)

    async def look_for_old() -> None:
        prune(store, 3600.0, dry_run=True)

    for name, call in {
        "submit, with quotas": submit,
        "list of one owner": list_own,
        "prune --dry-run": look_for_old,
    }.items():
        if not await timed(name, call):
            slow.append(name)
    del job_id
    return slow


def retention(store: Store, job_id: str, seconds: float) -> None:
    """Delete one job, then those that ended longer ago."""
    began = time.perf_counter()
    delete_job(store, job_id)
    print(f"  one job deleted in {time.perf_counter() - began:.2f} s", flush=True)
    began = time.perf_counter()
    gone = prune(store, seconds)
    elapsed = time.perf_counter() - began
    rows = sum(job.evaluations for job in gone)
    print(f"  prune: {len(gone)} jobs, {rows} evaluations in {elapsed:.1f} s, VACUUM included", flush=True)


def sizes(store: Store) -> str:
    """What the tables take of the disk with their indexes."""
    with store.engine.connect() as connection:
        rows = connection.execute(
            text(
                "SELECT relname, pg_total_relation_size(oid), pg_indexes_size(oid) FROM pg_class"
                " WHERE relname IN ('evaluations', 'events', 'generations', 'jobs') ORDER BY 2 DESC"
            )
        )
        return ", ".join(f"{name} {size / 2**20:.0f} MB ({index / 2**20:.0f} indexes)" for name, size, index in rows)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=1000)
    parser.add_argument("--evaluations", type=int, default=10_000, help="of each job")
    options = parser.parse_args()
    needed = BYTES_A_ROW * 2 * options.jobs * options.evaluations
    free = shutil.disk_usage(tempfile.gettempdir()).free
    if free < 2 * needed:
        raise SystemExit(f"{tempfile.gettempdir()}: {free / 1e9:.0f} GB are free; {2 * needed / 1e9:.0f} GB are wanted")
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}", flush=True)
    with PostgresServer() as server:
        url = server.create_database()
        store = Store(Settings(database_url=url, workers=1))
        service = JobService(store, NoWaker())
        template = service.submit(parse_problem(PROBLEM))[0].id
        began = time.perf_counter()
        fill(store, template, options.evaluations)
        generation_events(store, template)
        copies(store, template, options.jobs)
        with store.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            connection.execute(text("VACUUM ANALYZE"))
        total = options.jobs * options.evaluations
        print(
            f"{total} evaluations of {options.jobs} jobs in {time.perf_counter() - began:.0f} s: {sizes(store)}",
            flush=True,
        )
        middle = store.read(
            lambda c: c.scalar(text("SELECT left(md5(:n), 16)"), {"n": str(options.jobs // 2 // 10 * 10)})
        )
        slow = asyncio.run(requests(service, middle, max(0, options.evaluations // 10 - 5)))
        flat = asyncio.run(exported(service, middle, options.evaluations))
        slow += asyncio.run(engine(store, middle))
        retention(store, middle, 60.0 * options.jobs * 0.9)
        store.close()
    print(f"slower than {LIMIT_MILLISECONDS:.0f} ms: {', '.join(slow) or 'nothing'}")
    print("memory of the export " + ("stayed flat" if flat else "grew"))


if __name__ == "__main__":
    main()
