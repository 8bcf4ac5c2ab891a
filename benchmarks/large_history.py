"""A million stored evaluations: how fast listings and filters answer, what an export and watchers cost.

    python benchmarks/large_history.py [--evaluations 1000000] [--database URL] [--watchers 200]

Without a database a temporary SQLite file is used. Times are of whole requests to the application in this process, 95th
percentile of 40; memory is the growth of the resident set while the export streams.
"""

from __future__ import annotations

import argparse
import asyncio
import resource
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

import httpx
import numpy as np
from sqlalchemy import event, insert, text, update

from geoswarm.api import ApiSettings, create_app
from geoswarm.api.events.feed import GATHER_SECONDS
from geoswarm.solver.problem import parse_problem
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.codec import pack_array, pack_json, pack_responses
from geoswarm.workers.store.tables import evaluations, events, generations, jobs
from geoswarm.workers.waker import NoWaker

API = "/api/v1"
PARTICLES = 10
ROWS_A_TRANSACTION = 50_000
REPETITIONS = 40
LIMIT_MILLISECONDS = 200.0
TICK_SECONDS = ApiSettings().poll_seconds + GATHER_SECONDS
PROBLEM: dict[str, Any] = {
    "name": "large",
    "forward_model": {"kind": "formula", "series": {"y": {"expression": "a + b * x"}}},
    "parameters": {"a": {"lower": -5, "upper": 5}, "b": {"lower": 0, "upper": 4}},
    "observations": [{"series": "y", "points": {"x": list(range(20)), "y": list(range(20))}}],
    "method": {"kind": "particle_swarm", "particles": PARTICLES},
    "stopping": {"max_evaluations": 10},
    "answer": {"max_evaluations": "off"},
}


def fill(store: Store, job_id: str, count: int) -> None:
    """Store a finished history: the objective falls slowly with noise, one in a thousand runs failed."""
    random = np.random.default_rng(1)
    responses = pack_responses({"y": np.linspace(0.0, 1.0, 20)})
    misfits = pack_json({"y": 0.25})
    best = np.inf
    for start in range(0, count, ROWS_A_TRANSACTION):
        rows, records = [], []
        for first in range(start, min(start + ROWS_A_TRANSACTION, count), PARTICLES):
            number = first // PARTICLES
            objectives = np.exp(-8.0 * first / count) * random.lognormal(0.0, 1.0, PARTICLES)
            failed = random.random(PARTICLES) < 1e-3
            rows += [
                {
                    "job_id": job_id,
                    "generation": number,
                    "particle": particle,
                    "state": "failed" if failed[particle] else "finished",
                    "parameters": pack_array(random.random(2)),
                    "objective": None if failed[particle] else float(objectives[particle]),
                    "misfits": None if failed[particle] else misfits,
                    "responses": None if failed[particle] else responses,
                    "reason": "diverged" if failed[particle] else None,
                    "message": "the solver diverged" if failed[particle] else None,
                    "attempts": 1,
                    "worker": "worker-1",
                    "started_at": 1.7e9,
                    "finished_at": 1.7e9,
                    "seconds": 0.001,
                }
                for particle in range(PARTICLES)
            ]
            best = min(best, float(objectives.min()))
            records.append(
                {
                    "job_id": job_id,
                    "number": number,
                    "evaluations": first + PARTICLES,
                    "failed": 0,
                    "best_objective": float(objectives[~failed].min()) if not failed.all() else None,
                    "objective": best,
                    "parameters": pack_json({"a": 1.0, "b": 2.0}),
                    "created_at": 1.7e9,
                    "finished_at": 1.7e9,
                }
            )
        store.write(lambda c, r=rows, g=records: (c.execute(insert(evaluations), r), c.execute(insert(generations), g)))
    last = count // PARTICLES - 1
    values = {
        "state": "finished",
        "generation": last,
        "generations": last + 1,
        "evaluations": count,
        "objective": best,
        "parameters": pack_json({"a": 1.0, "b": 2.0}),
        "best_generation": last,
        "best_particle": 0,
        "started_at": database_now(),
        "finished_at": database_now(),
    }
    store.write(lambda c: c.execute(update(jobs).where(jobs.c.id == job_id).values(**values)))
    if store.engine.dialect.name == "postgresql":
        with store.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            connection.execute(text("VACUUM ANALYZE"))


def memory() -> float:
    """Resident set now [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


async def listings(client: httpx.AsyncClient, job_id: str, count: int) -> bool:
    """Time every listing and filter; whether all are fast enough."""
    last = count // PARTICLES - 1
    base = f"{API}/jobs/{job_id}/evaluations"
    deep = (await client.get(f"{base}?limit=1000&generation={last // 2}")).json()
    first = (await client.get(f"{base}?limit=1")).json()
    assert deep["items"]
    assert first["next_cursor"]
    paths = {
        "jobs": f"{API}/jobs",
        "job": f"{API}/jobs/{job_id}",
        "best": f"{API}/jobs/{job_id}/best",
        "generations, first 1000": f"{API}/jobs/{job_id}/generations",
        "generations, last 1000": f"{API}/jobs/{job_id}/generations?after={last - 1000}",
        "evaluations, first 100": base,
        "evaluations, 100 with responses": f"{base}?responses=true",
        "evaluations of a late generation": f"{base}?generation={last - 5}",
        "evaluations that failed": f"{base}?state=failed",
        "evaluations that finished": f"{base}?state=finished",
        "evaluations that run": f"{base}?state=running",
        "evaluations by objective": f"{base}?sort=objective",
        "objective below nearly all": f"{base}?max_objective=1e9",
        "objective below few, late ones": f"{base}?max_objective=1e-4",
        "objective below none": f"{base}?max_objective=-1",
        "failed, with an objective": f"{base}?state=failed&max_objective=1",
        "dashboard page of the job": f"/jobs/{job_id}",
        "statistics": f"{API}/jobs/{job_id}/statistics",
        "statistics, a threshold": f"{API}/jobs/{job_id}/statistics?threshold=0.01",
        "uncertainty": f"{API}/jobs/{job_id}/uncertainty",
        "figure of the convergence (CSV)": f"{API}/jobs/{job_id}/figures/convergence.csv",
        "metrics": "/metrics",
    }
    good = True
    for name, path in paths.items():
        times = []
        for _ in range(REPETITIONS):
            began = time.perf_counter()
            answer = await client.get(path)
            times.append(1e3 * (time.perf_counter() - began))
            assert answer.status_code == 200, (path, answer.text)
        p95 = statistics.quantiles(times, n=20)[18]
        good &= p95 < LIMIT_MILLISECONDS
        print(f"  {name:36s} median {statistics.median(times):7.1f} ms   p95 {p95:7.1f} ms   first {times[0]:7.1f} ms")
    return good


async def export(client: httpx.AsyncClient, job_id: str, count: int) -> bool:
    """Stream the whole history as CSV; whether memory stayed flat."""
    before, most, lines, size = memory(), 0.0, 0, 0
    began = time.perf_counter()
    async with client.stream("GET", f"{API}/jobs/{job_id}/evaluations?format=csv") as answer:
        async for chunk in answer.aiter_bytes():
            lines += chunk.count(b"\n")
            size += len(chunk)
            most = max(most, memory())
    seconds = time.perf_counter() - began
    assert lines == count + 1, lines
    print(f"  export: {size / 1e6:.0f} MB in {seconds:.1f} s, memory grew by {most - before:.1f} MB")
    return most - before < 50.0


async def watch(service: JobService, url: str, ids: list[str], watchers: int) -> bool:
    """Open event streams and count queries a tick."""
    queries: list[str] = []
    event.listen(service.store.engine, "before_cursor_execute", lambda _c, _k, s, *_: queries.append(s))
    limits = httpx.Limits(max_connections=watchers + 5)
    async with httpx.AsyncClient(base_url=url, limits=limits, timeout=30) as client:
        heard = 0

        async def listen(job_id: str) -> None:
            nonlocal heard
            async with client.stream("GET", f"{API}/jobs/{job_id}/events") as answer:
                async for line in answer.aiter_lines():
                    heard += line.startswith("data:")

        tasks = [asyncio.create_task(listen(ids[i % len(ids)])) for i in range(watchers)]
        while heard < watchers:
            await asyncio.sleep(0.1)
        queries.clear()
        began = time.perf_counter()
        await asyncio.sleep(5.0)
        news = sum("FROM events" in query for query in queries)
        others = sum(query.lstrip().startswith("SELECT") for query in queries) - news
        ticks = (time.perf_counter() - began) / TICK_SECONDS
        service.store.write(lambda c: c.execute(insert(events), [_event(job_id) for job_id in ids]))
        sent = time.perf_counter()
        while heard < 2 * watchers:
            await asyncio.sleep(0.01)
        delay = time.perf_counter() - sent
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
    print(f"  {watchers} watchers of {len(ids)} jobs: {news / ticks:.2f} queries a tick")
    print(
        f"  and {others / 5:.1f} others a second; an event of every job reached all of them within {delay * 1e3:.0f} ms"
    )
    return news <= 1.3 * ticks


def _event(job_id: str) -> dict[str, Any]:
    return {"job_id": job_id, "kind": "note", "data": "{}", "created_at": 1.7e9}


def watched(service: JobService, watchers: int) -> bool:
    """Run a real server in a thread and watch as many jobs as there are watchers."""
    import threading

    from geoswarm.api.server import base_url, bind, build_server

    ids = [service.submit(parse_problem(PROBLEM))[0].id for _ in range(watchers)]
    listener = bind("127.0.0.1", 0)
    started = threading.Event()
    server = build_server(service, listener, ApiSettings(), lambda _: started.set())
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
    thread.start()
    started.wait(10)
    try:
        return asyncio.run(watch(service, base_url(listener), ids, watchers))
    finally:
        server.should_exit = True
        thread.join()
        listener.close()


async def requests(service: JobService, job_id: str, count: int) -> bool:
    """Ask the application in this process."""
    transport = httpx.ASGITransport(create_app(service, ApiSettings()))
    async with httpx.AsyncClient(transport=transport, base_url="http://localhost", timeout=None) as client:
        return await listings(client, job_id, count)


async def exported(service: JobService, job_id: str, count: int) -> bool:
    """Export over a real server, as the transport in this process keeps the whole answer."""
    import threading

    from geoswarm.api.server import base_url, bind, build_server

    listener = bind("127.0.0.1", 0)
    started = threading.Event()
    server = build_server(service, listener, ApiSettings(), lambda _: started.set())
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
    thread.start()
    started.wait(10)
    try:
        async with httpx.AsyncClient(base_url=base_url(listener), timeout=None) as client:
            return await export(client, job_id, count)
    finally:
        server.should_exit = True
        thread.join()
        listener.close()


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--evaluations", type=int, default=1_000_000)
    parser.add_argument("--watchers", type=int, default=200)
    parser.add_argument("--database")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        url = options.database or f"sqlite:///{folder}/jobs.db"
        store = Store(Settings(database_url=url, workers=1))
        service = JobService(store, NoWaker())
        job_id = service.submit(parse_problem(PROBLEM))[0].id
        began = time.perf_counter()
        fill(store, job_id, options.evaluations)
        print(f"{store.engine.dialect.name}: {options.evaluations} evaluations in {time.perf_counter() - began:.0f} s")
        results = [
            asyncio.run(requests(service, job_id, options.evaluations)),
            asyncio.run(exported(service, job_id, options.evaluations)),
            watched(service, options.watchers),
        ]
        store.close()
    print("all within limits" if all(results) else "NOT all within limits")


if __name__ == "__main__":
    main()
