"""An installed geoswarm works beside modules that are called like its rooms: a user's own, or another package's."""

from __future__ import annotations

import json
import os
import re
import secrets
import shutil
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from geoswarm import Client
from tests.contracts.repository import ROOT
from tests.installation import Installation, install_beside

PROBLEM: dict[str, Any] = {
    "name": "line",
    "forward_model": {"kind": "misbehaving", "behaviour": "sleep"},
    "parameters": {"slope": {"lower": 0, "upper": 5}},
    "observations": [{"series": "y", "points": {"x": [1, 2, 3], "y": [2, 4, 6]}}],
    "method": {"kind": "particle_swarm", "particles": 4},
    "stopping": {"max_evaluations": 20},
    "seed": 3,
}
SCRIPT = """
import json, sys
from geoswarm import Client
from geoswarm.cli import main
import api, solver, workers   # the user's own
assert api.MINE and solver.MINE and workers.MINE
if __name__ == "__main__":
    sys.exit(main(["run", "problem.json", "--workers", "2", "--json"]))
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Installation:
    return install_beside(tmp_path_factory.mktemp("installed"))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A user's folder: a plug-in, a problem for it, a script, and modules of their own that only the script wants."""
    for name in ("api.py", "solver.py", "tests.py", "examples.py"):
        (tmp_path / name).write_text("MINE = True\n")
    (tmp_path / "workers").mkdir()
    (tmp_path / "workers" / "__init__.py").write_text("MINE = True\n")
    shutil.copytree(ROOT / "tests" / "models", tmp_path, dirs_exist_ok=True)
    (tmp_path / "problem.json").write_text(json.dumps(PROBLEM))
    (tmp_path / "script.py").write_text(SCRIPT)
    return tmp_path


@pytest.fixture
def environment(folder: Path) -> dict[str, str]:
    """The folder is also on Python's path, where plug-ins are found, in every process."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return {**kept, "PYTHONPATH": str(folder)}


@contextmanager
def running(command: list[str], folder: Path, environment: dict[str, str]) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(command, cwd=folder, env=environment, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.send_signal(signal.SIGTERM)


@pytest.mark.slow
def test_console_script_module_and_script_give_the_same(
    installed: Installation, folder: Path, environment: dict[str, str]
) -> None:
    answers = []
    for command in (
        [str(installed.script), "run", "problem.json", "--json"],
        [str(installed.python), "-m", "geoswarm", "run", "problem.json", "--json"],
        [str(installed.python), "script.py"],
    ):
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        answer = json.loads(done.stdout)
        answers.append({name: answer[name] for name in ("state", "objective", "parameters", "evaluations")})
    assert answers[0]["state"] == "finished"
    assert answers == answers[:1] * 3


@pytest.mark.slow
def test_what_runs_is_the_installation(installed: Installation, folder: Path, environment: dict[str, str]) -> None:
    code = "import geoswarm.api, geoswarm.workers, geoswarm.solver as last; print(last.__file__)"
    done = subprocess.run(
        [installed.python, "-c", code], cwd=folder, env=environment, capture_output=True, text=True, check=True
    )
    assert Path(done.stdout.strip()).is_relative_to(installed.packages)


@pytest.mark.slow
def test_the_service_and_its_workers_work(installed: Installation, folder: Path, environment: dict[str, str]) -> None:
    database = f"sqlite:///{folder / 'jobs.db'}"
    command = [str(installed.script), "serve", "--port", "0", "--workers", "1", "--database", database]
    with running(command, folder, environment) as process:
        assert process.stderr is not None
        line = process.stderr.readline()
        found = re.search(r"http://127\.0\.0\.1:\d+", line)
        assert found, line + process.stderr.read()
        with Client(found[0]) as client:
            job = client.wait(client.submit(PROBLEM).id, timeout=240)
            assert (job.state, job.evaluations) == ("finished", 20)


@pytest.mark.slow
def test_a_celery_worker_works(
    installed: Installation,
    folder: Path,
    environment: dict[str, str],
    fresh_postgres_url: str,
    fresh_redis_url: str,
    free_port: int,
) -> None:
    backends = ["--database", fresh_postgres_url, "--broker", fresh_redis_url]
    key = secrets.token_hex(16)
    environment |= {"GEOSWARM_API_KEY": key}
    serve = [str(installed.script), "serve", "--port", str(free_port), *backends]
    worker = [str(installed.script), "worker", "--concurrency", "1", *backends]
    with running(serve, folder, environment) as process:
        assert process.stderr is not None
        line = process.stderr.readline()
        assert "serves at" in line, line + process.stderr.read()
        with running(worker, folder, environment), Client(f"http://127.0.0.1:{free_port}", key) as client:
            job = client.wait(client.submit(PROBLEM).id, timeout=240)
            assert (job.state, job.evaluations) == ("finished", 20)
