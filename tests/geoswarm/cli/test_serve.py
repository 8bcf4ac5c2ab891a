"""What ``serve``, ``worker`` and ``sweep`` refuse, and the demo."""

from __future__ import annotations

import os
import re
import shutil
import socket
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import httpx
import pytest

from geoswarm.cli import main
from geoswarm.cli.start.demo import LABORATORY, PUBLISHED
from geoswarm.cli.start.examples import example_problem
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.solver.kernels.cache import settle
from geoswarm.solver.problem import load_problem
from tests.integration.engines import PATIENCE


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The default database is a file in the working folder."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.1"])
def test_other_machines_need_a_key(host: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["serve", "--host", host, "--port", "0"]) == 2
    error = capsys.readouterr().err
    assert f"--host {host}" in error
    assert "GEOSWARM_API_KEY" in error


def test_short_key_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["serve", "--port", "0", "--api-key", "short"]) == 2
    assert "at least 8" in capsys.readouterr().err


def test_other_machines_need_a_long_key(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["serve", "--host", "0.0.0.0", "--port", "0", "--api-key", "8f3b1d0e52a94c7788"]) == 2
    error = capsys.readouterr().err
    assert "GEOSWARM_API_KEY has 18 characters; at least 32 are accepted" in error
    assert "8f3b1d0e52a94c7788" not in error


BUSY = """
import sys, threading, time
from geoswarm.workers.service.job_service import JobService

def list_jobs(self, *_, **__):  # as a request that takes for ever
    print("busy", flush=True)
    while True:
        sum(range(1000))

JobService.list = list_jobs
from geoswarm.cli import main
sys.exit(main(["serve", "--port", "0", "--workers", "1", "--api-key", "8f3b1d0e52a94c7788"]))
"""


@pytest.mark.slow
def test_sigterm_ends_a_service_with_a_busy_thread() -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", BUSY],
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stderr is not None
        assert process.stdout is not None
        assert "at least 32 are accepted" in process.stderr.readline()
        url = re.search(r"http://\S+", process.stderr.readline())
        assert url is not None
        with ThreadPoolExecutor() as pool:
            headers = {"X-API-Key": "8f3b1d0e52a94c7788"}
            asked = pool.submit(httpx.get, f"{url[0]}/api/v1/jobs", headers=headers, timeout=120)
            assert process.stdout.readline() == "busy\n"
            process.terminate()
            _, errors = process.communicate(timeout=PATIENCE)
            assert asked.exception() is not None or asked.result().status_code >= 500
        assert process.returncode == 0
        assert "Stopped." in errors
        assert "Traceback" not in errors
    finally:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("command", ["serve", "sweep"])
def test_unreachable_database_is_one_message(command: str, free_port: int, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--port", "0"] if command == "serve" else []
    url = f"postgresql://geoswarm:secret@127.0.0.1:{free_port}/jobs"
    assert main([command, *options, "--database", url]) == 2
    error = capsys.readouterr().err
    assert f"127.0.0.1:{free_port}" in error
    assert "secret" not in error
    assert "Traceback" not in error


@pytest.mark.parametrize("command", ["serve", "worker"])
def test_unreachable_broker_is_one_message(command: str, free_port: int, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--port", "0"] if command == "serve" else ["--concurrency", "1"]
    assert main([command, *options, "--broker", f"redis://127.0.0.1:{free_port}/0"]) == 2
    error = capsys.readouterr().err
    assert f"127.0.0.1:{free_port}" in error
    assert "Traceback" not in error


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--database", "mysql://host/name"], "sqlite, postgresql"),
        (["--database", "sqlite:///:memory:"], "must name a file"),
        (["--broker", "amqp://host"], "redis://"),
    ],
)
def test_addresses_of_the_wrong_kind_are_named(
    options: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["serve", "--port", "0", *options]) == 2
    assert message in capsys.readouterr().err


def test_worker_needs_a_broker(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["worker"]) == 2
    assert "GEOSWARM_BROKER_URL" in capsys.readouterr().err


def test_a_worker_makes_no_database_of_its_own(
    tmp_path: Path, fresh_redis_url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "other.db"
    for command in ("worker", "sweep"):
        assert main([command, "--broker", fresh_redis_url, "--database", f"sqlite:///{file}"]) == 2
        error = capsys.readouterr().err
        assert f"there is no database {file}" in error
        assert "Traceback" not in error
        assert not file.exists()


def test_no_service_is_one_message(free_port: int, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "--url", f"http://127.0.0.1:{free_port}"]) == 2
    error = capsys.readouterr().err
    assert f"http://127.0.0.1:{free_port}" in error
    assert "geoswarm serve" in error


def test_demo_ends_with_the_published_values_beside_its_own(tmp_path: Path) -> None:
    """With its usual port taken, and without a terminal: it ends by itself. It compiles what it needs, nothing else."""
    compiled, noted = settle(), tmp_path / "kernels-by-source"
    assert compiled is not None
    shutil.copytree(compiled, noted, ignore=shutil.ignore_patterns("compiled-*"))  # it asks which are compiled
    with socket.create_server(("127.0.0.1", 0)) as taken:
        command = [sys.executable, "-m", "geoswarm", "demo", "--port", str(taken.getsockname()[1])]
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
            cwd=Path(__file__).parents[3],
            env={**os.environ, "TMPDIR": str(tmp_path), "NUMBA_CACHE_DIR": str(noted)},
        )
    assert done.returncode == 0, done.stderr
    assert "SYNTHETIC" in done.stderr
    assert [path.name.split("-")[1] for path in noted.glob("compiled-*")] == ["oedometer"]
    assert "Traceback" not in done.stderr
    for name in PUBLISHED:
        row = next(line.split() for line in done.stdout.splitlines() if line.strip().startswith(name))
        numbers = [float(cell) for cell in row if cell.replace(".", "").isdigit()]
        assert numbers[1:] == [PUBLISHED[name], LABORATORY[name]]
        assert numbers[0] == pytest.approx(PUBLISHED[name], rel=0.35)
    objective = next(line.split()[1] for line in done.stdout.splitlines() if line.strip().startswith("objective"))
    assert 2e-9 < float(objective) <= 5e-9
    assert "http://127.0.0.1:" not in done.stdout  # nobody serves a page when the command has ended
    assert list(tmp_path.iterdir()) == [noted], "the database was in a temporary folder that is gone"


def test_published_values_are_those_of_the_reference_data() -> None:
    with example_problem("oedometer") as path:
        problem = load_problem(path)
        note = (path.parent / "settlement.csv").read_text(encoding="utf-8").splitlines()[0]
    assert problem.free_names == tuple(PUBLISHED)
    assert all(f"{name} {value:g}" in note for name, value in PUBLISHED.items())


def test_missing_example_is_named() -> None:
    with pytest.raises(BadInputError, match="the example 'nothing' is missing"), example_problem("nothing"):
        pass
