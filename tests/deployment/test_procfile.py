"""deploy/Procfile works with the environment that deploy/geoswarm.env.example tells to make."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest
from sqlalchemy.engine import make_url

from geoswarm import Client
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from tests.contracts.repository import ROOT
from tests.integration.engines import wait_for
from tests.servers import find_program, free_port
from tests.solver.problems import decay_document

pytestmark = pytest.mark.timeout(900)

DEPLOY = ROOT / "deploy"
SECONDS = 300.0


def filled_in(database_url: str, broker_url: str, port: int) -> str:
    """Fill in the example as an operator does: the three secrets, and where the servers are."""
    text = (DEPLOY / "geoswarm.env.example").read_text(encoding="utf-8")
    database, broker = make_url(database_url), make_url(broker_url)
    for old, new in (
        ("geoswarm:PASSWORD@127.0.0.1:5432/geoswarm", f"geoswarm:{database.password}@127.0.0.1:{database.port}/"),
        (":PASSWORD@127.0.0.1:6379/0", f"127.0.0.1:{broker.port}/{broker.database}"),
        ("GEOSWARM_API_KEY=\n", f"GEOSWARM_API_KEY={secrets.token_hex(24)}\n"),
        ("PORT=8765", f"PORT={port}"),
    ):
        assert text.count(old) == 1, old
        text = text.replace(old, f"{new}{database.database}" if old.startswith("geoswarm:") else new)
    return text


def variables(text: str) -> dict[str, str]:
    """Read an environment file as honcho and foreman do."""
    return dict(re.findall(r"^(?!#)(\w+)=(.*)$", text, flags=re.MULTILINE))


@contextmanager
def started(environment: Mapping[str, str], logs: Path) -> Iterator[dict[str, subprocess.Popen[bytes]]]:
    """Start every line of the Procfile with a shell; at the end all are asked to stop, and must."""
    lines = dict(line.split(": ", 1) for line in (DEPLOY / "Procfile").read_text().splitlines() if line)
    processes = {}
    try:
        for name, command in lines.items():
            with (logs / f"{name}.log").open("wb") as log:
                processes[name] = subprocess.Popen(
                    [str(find_program("setpriv")), "--pdeathsig", "KILL", "/bin/sh", "-c", f"exec {command}"],
                    cwd=DEPLOY,
                    env=dict(environment),
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
        yield processes
        for process in processes.values():
            process.terminate()
        assert {name: process.wait(60) for name, process in processes.items()} == dict.fromkeys(lines, 0)
    finally:
        for process in processes.values():
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.mark.slow
def test_the_procfile_works_with_the_environment_of_the_example(
    fresh_postgres_url: str, fresh_redis_url: str, tmp_path: Path
) -> None:
    port = free_port()
    own = variables(filled_in(fresh_postgres_url, fresh_redis_url, port))
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    # kernels as plain Python: nothing waits until they are compiled
    environment = {"PATH": path, "HOME": str(tmp_path), "NUMBA_DISABLE_JIT": "1", **own}
    check = [sys.executable, "-m", "geoswarm.workers.hosts.healthcheck", "--worker"]

    def ready() -> bool:
        ended = [name for name, process in processes.items() if process.poll() is not None]
        assert not ended, "".join((tmp_path / f"{name}.log").read_text() for name in ended)
        try:
            answered = httpx.get(f"http://127.0.0.1:{port}/health/ready", timeout=20.0).status_code == 200
        except httpx.TransportError:
            return False
        return answered and subprocess.run(check, env=environment, cwd=DEPLOY, check=False).returncode == 0

    with started(environment, tmp_path) as processes:
        wait_for(ready, "a service and a worker that are ready", SECONDS)
        with Client(f"http://127.0.0.1:{port}", api_key=own["GEOSWARM_API_KEY"]) as client:
            job = client.wait(client.submit(decay_document()).id, timeout=SECONDS)
    expected = calibrate(parse_problem(decay_document()))
    assert (job.state, job.objective, job.parameters) == ("finished", expected.objective, expected.parameters)


def test_the_example_is_complete_for_whoever_starts_it() -> None:
    named = variables((DEPLOY / "geoswarm.env.example").read_text(encoding="utf-8"))
    assert {"GEOSWARM_DATABASE_URL", "GEOSWARM_BROKER_URL", "GEOSWARM_API_KEY", "PORT"} <= set(named)
    used = set(re.findall(r"\$\{?(\w+)", (DEPLOY / "Procfile").read_text(encoding="utf-8")))
    assert used <= set(named)
