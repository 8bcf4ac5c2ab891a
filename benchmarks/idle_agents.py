"""What agents cost that have nothing to do: processor time of a service and of PostgreSQL while they wait for work.

    python benchmarks/idle_agents.py [--agents 0,500,2000] [--window 60] [--wait 50]

Each agent is announced, and has one request for work open, which the service answers after ``--wait`` seconds at most;
then it asks again, as ``geoswarm agent`` does. The service is a process of its own, with PostgreSQL and no worker; the
agents are connections of this process. Columns: processor time of the service and of PostgreSQL as a share of a core;
requests answered a second; transactions a second; WAL a second; memory of the service; connections to PostgreSQL; how
long it took until an agent had a run of a job that was submitted then.
"""

# ruff: noqa: E402  modules beside this folder are found only once the path is set

from __future__ import annotations

import argparse
import asyncio
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

import httpx
import psutil

from benchmarks._postgres import PostgresWork
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.system.versions import versions
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.servers import PostgresServer, free_port

AGENTS_A_KEY = 1000
PROBLEM = {
    "name": "woken",
    "forward_model": {"kind": "formula", "series": {"y": {"expression": "a + b * x"}}},
    "parameters": {"a": {"lower": -5, "upper": 5}, "b": {"lower": 0, "upper": 4}},
    "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [1, 2, 3]}}],
    "method": {"kind": "particle_swarm", "particles": 10},
    "stopping": {"max_evaluations": 100},
}


class Line:
    """A connection to the service, which asks one thing after the other: no client of 2000 of them is as cheap."""

    def __init__(self, port: int, key: str) -> None:
        self.port, self.key = port, key
        self._streams: tuple[asyncio.StreamReader, asyncio.StreamWriter] | None = None

    async def ask(self, method: str, path: str, body: dict[str, Any]) -> Any:
        """Return what is answered; on a new connection when the service has closed the last one meanwhile."""
        while True:
            try:
                return await self._ask(method, path, json.dumps(body).encode())
            except (OSError, asyncio.IncompleteReadError):
                self.close()
                await asyncio.sleep(0.2)

    async def _ask(self, method: str, path: str, body: bytes) -> Any:
        if self._streams is None:
            self._streams = await asyncio.open_connection("127.0.0.1", self.port)
        reader, writer = self._streams
        head = (
            f"{method} /api/v1/agents{path} HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\n"
            f"Authorization: Bearer {self.key}\r\nContent-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
        )
        writer.write(head.encode() + body)
        told = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1").lower()
        length = int(told.partition("content-length:")[2].partition("\r\n")[0])
        content = await reader.readexactly(length)
        if not told.startswith("http/1.1 200"):
            raise SystemExit(f"{method} {path}: {told}{content.decode()}")
        if "connection: close" in told:
            self.close()
        return json.loads(content)

    def close(self) -> None:
        """Close it."""
        if self._streams is not None:
            self._streams[1].close()
        self._streams = None


class Agents:
    """Agents that wait."""

    def __init__(self, port: int, keys: list[str], count: int, wait: float) -> None:
        self.port, self.keys, self.count, self.wait = port, keys, count, wait
        self.answers = 0
        self.first: float | None = None

    async def serve(self, ready: asyncio.Event) -> None:
        """Announce all, then wait for work with all."""
        start = asyncio.Semaphore(8)
        asked = 0

        async def one(number: int) -> None:
            nonlocal asked
            line, name = Line(self.port, self.keys[number // AGENTS_A_KEY]), f"idle-{number}"
            try:
                async with start:
                    told = {"agent": name, "host": "h", "system": "s", "pid": 1, "slots": 1, "models": {}}
                    await line.ask("PUT", "/models", told | {"versions": dict(versions()), "kinds": ["formula"]})
                    line.close()  # it may be kept for a few seconds only
                asked += 1
                if asked == self.count:
                    ready.set()
                wait = self.wait * (0.1 + 0.9 * number / self.count)  # the first ones end at different times
                while True:
                    found = await line.ask("POST", "/leases", {"agent": name, "slot": 0, "runs": 1, "wait": wait})
                    self.answers += 1
                    if found["lease"] is not None and self.first is None:
                        self.first = time.monotonic()
                    wait = self.wait
            finally:
                line.close()

        await asyncio.gather(*(one(number) for number in range(self.count)))


async def measure(
    service: subprocess.Popen[bytes], agents: Agents, counters: PostgresWork, store: Store, window: float
) -> dict[str, Any]:
    """Let agents wait; return what that takes."""
    ready = asyncio.Event()
    task = asyncio.create_task(agents.serve(ready))
    if agents.count:
        await asyncio.wait({task, asyncio.create_task(ready.wait())}, return_when=asyncio.FIRST_COMPLETED)
        if task.done():
            task.result()
    await asyncio.sleep(5.0)
    process = psutil.Process(service.pid)
    family = [process, *process.children(recursive=True)]

    def own() -> float:
        return sum(sum(one.cpu_times()[:2]) for one in family)

    began, cpu, database, answers = time.monotonic(), own(), counters.seconds(), agents.answers
    transactions, wal = counters.transactions(), counters.wal()
    await asyncio.sleep(window)
    elapsed = time.monotonic() - began
    found: dict[str, Any] = {
        "service": 100.0 * (own() - cpu) / elapsed,
        "postgres": 100.0 * (counters.seconds() - database) / elapsed,
        "answers": (agents.answers - answers) / elapsed,
        "transactions": (counters.transactions() - transactions) / elapsed,
        "wal": (counters.wal() - wal) / elapsed / 1e3,
        "memory": process.memory_info().rss / 2**20,
        "connections": counters.number(
            "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database()"
            " AND application_name = 'geoswarm' AND pid <> pg_backend_pid()"
        ),
        "woken": None,
    }
    if agents.count:
        asked = time.monotonic()
        await asyncio.to_thread(JobService(store, NoWaker()).submit, parse_problem(PROBLEM))
        while agents.first is None and time.monotonic() < asked + 30.0:
            await asyncio.sleep(0.005)
        found["woken"] = None if agents.first is None else 1e3 * (agents.first - asked)
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)
    return found


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--agents", default="0,500,2000")
    parser.add_argument("--wait", type=float, default=50.0, help="time that one request waits [s]")
    parser.add_argument("--window", type=float, default=60.0, help="time that is measured [s]")
    options = parser.parse_args()
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    print(
        "| agents | service % | PostgreSQL % | answers/s | transactions/s | WAL kB/s | MB | connections | woken ms |",
        "|---|---|---|---|---|---|---|---|---|",
        sep="\n",
        flush=True,
    )
    with PostgresServer(durable=True) as server:
        assert server.pid is not None
        for count in (int(text) for text in options.agents.split(",")):
            url = server.create_database()
            store = Store(Settings(database_url=url))
            keys = [ApiKeys(store).create("idle", "agent")[0] for _ in range(max(1, -(-count // AGENTS_A_KEY)))]
            port = free_port()
            environment = os.environ | {"GEOSWARM_MAX_CONNECTIONS": "5000", "GEOSWARM_COMPUTE_PROCESSES": "1"}
            command = [sys.executable, "-m", "geoswarm", "serve", "--workers", "0", "--port", str(port)]
            service = subprocess.Popen([*command, "--database", url], env=environment, stderr=subprocess.DEVNULL)
            address = f"http://127.0.0.1:{port}"
            try:
                _wait_for(address)
                agents = Agents(port, keys, count, options.wait)
                found = asyncio.run(measure(service, agents, PostgresWork(url, server.pid), store, options.window))
            finally:
                service.terminate()
                service.wait()
                store.close()
            woken = "" if found["woken"] is None else f"{found['woken']:.0f}"
            print(
                f"| {count} | {found['service']:.1f} | {found['postgres']:.1f} | {found['answers']:.1f} |"
                f" {found['transactions']:.1f} | {found['wal']:.1f} | {found['memory']:.0f} | {found['connections']} |"
                f" {woken} |",
                flush=True,
            )


def _wait_for(address: str) -> None:
    deadline = time.monotonic() + 120.0
    while True:
        try:
            if httpx.get(f"{address}/health/ready", timeout=5.0).is_success:
                return
        except httpx.TransportError:
            pass
        if time.monotonic() > deadline:
            raise SystemExit(f"the service at {address} does not get ready")
        time.sleep(0.2)


if __name__ == "__main__":
    main()
