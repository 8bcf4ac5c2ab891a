"""How fast the dashboard is: first view, navigation, the matrix plot and its slider, and many dashboards at once.

Run with ``python benchmarks/dashboard.py``; ``--seconds 600`` watches the many dashboards for ten minutes. It starts
``geoswarm serve`` on a new database in a temporary folder, as a process of its own, and the system's Chromium.
"""

# ruff: noqa: E402  modules beside this folder are found only once the path is set

from __future__ import annotations

import argparse
import asyncio
import json
import os
import re
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

import httpx
from playwright.sync_api import Browser, Page

from tests.dashboard.browser import chromium

PROBLEM = ROOT / "examples" / "oedometer" / "problem.yaml"
DASHBOARDS = 50
RUNS = 5
TICK = os.sysconf("SC_CLK_TCK")

PAINT = """async ([base, count, size]) => {
    const { Cloud } = await import(base + "/js/statistics/cloud.js");
    const { Matrix } = await import(base + "/js/statistics/matrix.js");
    let seed = 1;
    const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
    const range = { unit: "-", scale: "linear", lower: 0, upper: 1 };
    const parameters = Array.from({ length: size }, (_, i) => ({ name: `p${i}`, symbol: `p${i}`, ...range }));
    const values = parameters.map(() => Float32Array.from({ length: count }, random));
    const far = (n) => values.reduce((sum, value) => sum + (value[n] - 0.5) ** 2, 0);
    const objective = Float32Array.from({ length: count }, (_, n) => 1e-3 + far(n));
    const series = [{ name: "y", weight: 1, y_unit: "m" }];
    const points = { count, parameters, values, objective, series, misfits: { y: objective }, responses: {} };
    document.getElementById("matrix").replaceChildren();
    const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
    const matrix = new Matrix(document.getElementById("matrix"), { onRanges: () => {} });
    await frame();
    const began = performance.now();
    const cloud = new Cloud(points);
    matrix.show(cloud, cloud.quantile(0.1), "m²");
    await frame();
    const drawn = performance.now() - began;
    const moves = [];
    for (const share of [0.05, 0.08, 0.12, 0.15, 0.2]) {
        const start = performance.now();
        matrix.update(cloud.quantile(share));
        await frame();
        moves.push(performance.now() - start);
    }
    return [drawn, Math.max(...moves)];
}"""
"""Draw made-up points in the real plot; milliseconds up to the frame, and the slowest move of the slider."""


@dataclass
class Measured:
    """One figure beside its limit."""

    name: str
    value: float
    limit: float
    unit: str

    @property
    def good(self) -> bool:
        """Whether it is within its limit."""
        return self.value <= self.limit

    def __str__(self) -> str:
        verdict = "ok" if self.good else "TOO MUCH"
        return f"{self.name:<58} {self.value:9.1f} {self.unit:<10} limit {self.limit:g}   {verdict}"


@contextmanager
def served(folder: Path) -> Iterator[tuple[str, int]]:
    """A service with one embedded worker: its address and the id of its process."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "geoswarm", "serve", "--port", str(port), "--workers", "1"]
    environment = {**os.environ, "GEOSWARM_DATABASE_URL": f"sqlite:///{folder}/jobs.db"}
    with (folder / "log").open("w") as log:
        process = subprocess.Popen(command, cwd=folder, env=environment, stdout=log, stderr=log)
        url = f"http://127.0.0.1:{port}"
        try:
            deadline = time.monotonic() + 120
            while True:
                try:
                    if httpx.get(f"{url}/health/ready").status_code == 200:
                        break
                except httpx.TransportError:
                    pass
                if time.monotonic() > deadline or process.poll() is not None:
                    raise RuntimeError(f"the service does not start: {(folder / 'log').read_text()}")
                time.sleep(0.1)
            yield url, process.pid
        finally:
            process.terminate()
            process.wait(30)


def problem(**changes: Any) -> dict[str, Any]:
    """Return the published oedometer test as a document."""
    from geoswarm.solver.problem import load_problem

    return load_problem(PROBLEM).document() | changes


def submitted(url: str, document: dict[str, Any]) -> str:
    """Submit a job and return its id."""
    answer = httpx.post(f"{url}/api/v1/jobs", json=document, timeout=60)
    answer.raise_for_status()
    return str(answer.json()["id"])


def finished(url: str, job: str) -> None:
    """Wait for the end of a job."""
    while httpx.get(f"{url}/api/v1/jobs/{job}").json()["state"] not in ("finished", "failed", "cancelled"):
        time.sleep(0.5)


SEEN = """(selectors) => {
    window.seen = {};
    const look = () => {
        for (const one of selectors)
            if (!(one in seen) && document.querySelector(one)) seen[one] = performance.now();
        requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
}"""


def loaded(page: Page, url: str, ready: str) -> float:
    """Return the time [ms] from the start of a navigation to the frame that shows an element made by the view's script.

    The page measures it: plots that are drawn afterwards keep it from answering for a while.
    """
    page.goto(url)
    shown: float = page.wait_for_function("ready => window.seen?.[ready]", arg=ready).json_value()
    return shown


def views(browser: Browser, url: str, job: str) -> list[Measured]:
    """Measure first views in new profiles, and views again in one that knows the files."""
    pages = {
        "jobs": ("/", "#choose button:disabled"),
        "job": (f"/jobs/{job}", "#actions button"),
        "statistics, plot": (f"/jobs/{job}/statistics", ".marks .cell"),
        "mesh": (f"/jobs/{job}/mesh", "main h1"),
        "new": ("/new", "#verdict:not(:empty)"),
        "workers": ("/workers", "#workers tbody tr, #workers .empty"),
    }
    script = f"({SEEN})({json.dumps([ready for _, ready in pages.values()])})"
    found = []
    for name, (path, ready) in pages.items():
        cold = []
        for _ in range(3):
            context = browser.new_context()
            context.add_init_script(script)
            cold.append(loaded(context.new_page(), url + path, ready))
            context.close()
        found.append(Measured(f"first view, {name}", statistics.median(cold), 1500, "ms"))
    context = browser.new_context()
    context.add_init_script(script)
    page = context.new_page()
    for path, ready in pages.values():
        loaded(page, url + path, ready)
    for name, (path, ready) in pages.items():
        warm = []
        for _ in range(RUNS):
            warm.append(loaded(page, url + path, ready))
            page.wait_for_load_state("networkidle")  # the service has answered what this view asked for
        found.append(Measured(f"again, {name}", statistics.median(warm), 300, "ms"))
    context.close()
    return found


def matrix(browser: Browser, url: str, job: str) -> list[Measured]:
    """Measure the matrix plot with made-up points."""
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    page = context.new_page()
    page.goto(f"{url}/jobs/{job}/statistics")
    page.wait_for_selector(".marks .cell")
    base = page.locator("body").get_attribute("data-static")
    found = []
    for count, size, draw, slide in ((2000, 5, 500, 100), (20_000, 6, 3000, 300)):
        drawn, moved = zip(*[page.evaluate(PAINT, [base, count, size]) for _ in range(RUNS)], strict=True)
        found.append(Measured(f"matrix plot of {count} x {size} drawn", statistics.median(drawn), draw, "ms"))
        found.append(Measured("its slider, slowest of five moves up to 20 %", statistics.median(moved), slide, "ms"))
    context.close()
    return found


def usage(process: int) -> tuple[float, float]:
    """Return the processor time [s] and the memory [MiB] of a process, without those below it."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    memory = re.search(r"^Rss: +(\d+)", Path(f"/proc/{process}/smaps_rollup").read_text(), re.MULTILINE)
    assert memory is not None
    return (int(fields[11]) + int(fields[12])) / TICK, int(memory[1]) / 1024


async def watch(url: str, job: str, seconds: float) -> int:
    """Open dashboards, each with its page and its event stream; return the number of events that came."""
    events = 0

    async def dashboard(client: httpx.AsyncClient) -> None:
        nonlocal events
        await client.get(f"{url}/jobs/{job}", headers={"Accept": "text/html"})
        async with client.stream("GET", f"{url}/api/v1/jobs/{job}/events") as stream:
            async for line in stream.aiter_lines():
                events += line.startswith("id:")

    limits = httpx.Limits(max_connections=2 * DASHBOARDS)
    async with httpx.AsyncClient(timeout=None, limits=limits) as client:
        tasks = [asyncio.create_task(dashboard(client)) for _ in range(DASHBOARDS)]
        await asyncio.sleep(seconds)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
    return events


def many(url: str, process: int, seconds: float) -> list[Measured]:
    """Measure what many dashboards on a running job cost the service, beyond what the job itself does."""
    endless = {"stopping": {"max_evaluations": 4_000_000}, "answer": {"max_evaluations": "off"}}
    document = problem(method={"kind": "particle_swarm", "particles": 200}, **endless)
    job = submitted(url, document)
    while httpx.get(f"{url}/api/v1/jobs/{job}").json()["state"] != "running":
        time.sleep(0.2)

    def share(act: Any) -> tuple[float, float, float]:
        (before, low), began = usage(process), time.monotonic()
        act()
        (after, high), wall = usage(process), time.monotonic() - began
        return 100 * (after - before) / wall, low, high

    alone, _, _ = share(lambda: time.sleep(min(seconds, 20)))
    asyncio.run(watch(url, job, min(10, seconds)))  # what is kept once for the first ones does not count as growth
    events = 0

    def watched() -> None:
        nonlocal events
        events = asyncio.run(watch(url, job, seconds))

    busy, low, high = share(watched)
    httpx.post(f"{url}/api/v1/jobs/{job}/cancel")
    print(f"the job alone costs the api {alone:.1f} % of a core; {events} events were sent")
    return [
        Measured(f"{DASHBOARDS} dashboards on a running job: processor", busy, 20, "% of a core"),
        Measured(f"growth of memory in {seconds:g} s", high - low, 5, "MiB"),
    ]


def main() -> int:
    """Print all figures beside their limits; 1 when one is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="how long many dashboards are watched")
    seconds = parser.parse_args().seconds
    found: list[Measured] = []
    with tempfile.TemporaryDirectory() as folder, served(Path(folder)) as (url, process):
        sampling = problem(method={"kind": "monte_carlo", "samples": 2000}, stopping={})
        job = submitted(url, sampling)
        finished(url, job)
        with chromium() as browser:
            found += views(browser, url, job)
            found += matrix(browser, url, job)
        found += many(url, process, seconds)
    for one in found:
        print(one)
    return 0 if all(one.good for one in found) else 1


if __name__ == "__main__":
    sys.exit(main())
